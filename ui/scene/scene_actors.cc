// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/scene_actors.h"

#include <algorithm>
#include <cmath>

#include <vtkActorCollection.h>
#include <vtkCellData.h>
#include <vtkPlane.h>
#include <vtkPlaneSource.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include "engine/geometry/gravity.h"
#include "engine/geometry/vertex_clustering.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/sequence_view.h"
#include "ui/framework/particle_place.h"
#include "ui/framework/theme.h"
#include "ui/scene/scan_actor.h"
#include "ui/scene/vtk_helpers.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kScanVerticesWhileMoving = 15'000;
constexpr int kFrustumImageWidth = 256, kBackdropImageWidth = 960;
constexpr double kSmallestFocus = 1.0;  ///< [m]

/// The floor's height along up, else that of the lowest things, without stray points: the second
/// percentile of the scan, else the lowest truth, else 1.4 m (a carried camera) below the lowest
/// camera.
double FloorHeight(const SequenceView& sequence) {
  if (sequence.floor_height_m) return *sequence.floor_height_m;
  const Vector3d& up = sequence.up_in_world;
  std::vector<double> heights;
  if (sequence.scan != nullptr && !sequence.scan->empty()) {
    const auto& vertices = sequence.scan->vertices;
    const std::size_t stride = std::max<std::size_t>(1, vertices.size() / 20000);
    for (std::size_t i = 0; i < vertices.size(); i += stride) {
      heights.push_back(vertices[i].cast<double>().dot(up));
    }
    const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
    std::nth_element(heights.begin(), low, heights.end());
    return *low;
  }
  for (const auto& truth : sequence.truth) {
    heights.push_back(truth.world_from_object.translation().dot(up));
  }
  if (!heights.empty()) return *std::min_element(heights.begin(), heights.end());
  for (const auto& pose : sequence.world_from_cam) heights.push_back(pose.translation().dot(up));
  return heights.empty() ? 0.0 : *std::min_element(heights.begin(), heights.end()) - 1.4;
}

/// Where the cameras are on the whole.
std::optional<Vector3d> MeanEye(const SequenceView& sequence) {
  if (sequence.world_from_cam.empty()) return std::nullopt;
  Vector3d eye = Vector3d::Zero();
  for (const auto& pose : sequence.world_from_cam) eye += pose.translation();
  return Vector3d(eye / static_cast<double>(sequence.world_from_cam.size()));
}

}  // namespace

SceneActors::SceneActors(vtkRenderer* ground, vtkRenderer* renderer, bool software_gl)
    : ground_(ground), renderer_(renderer), software_gl_(software_gl) {}

void SceneActors::SetSequence(const SequenceView& sequence) {
  ground_->RemoveAllViewProps();
  renderer_->RemoveAllViewProps();
  models_.clear();
  truth_.clear();
  truth_solid_.clear();
  smoothed_.clear();
  objects_.clear();
  bounds_.setEmpty();
  for (const auto& pose : sequence.world_from_cam) bounds_.extend(pose.translation());
  for (const auto& truth : sequence.truth) bounds_.extend(truth.world_from_object.translation());
  focus_bounds_ = bounds_;
  AddModels(sequence);
  AddScan(sequence);
  if (focus_bounds_.isEmpty() || focus_bounds_.diagonal().norm() < kSmallestFocus) {
    focus_bounds_ = bounds_;
  }
  AddGrid(sequence);
  AddTruth(sequence);
  AddSmoothed(sequence);
  AddTrajectory(sequence);
  camera_.lines = LineActorOf(SegmentsOf({}), colors::kTrajectory, 1.5);
  camera_.picture = ActorOf(SegmentsOf({}), IM_COL32_WHITE);
  camera_.picture->GetProperty()->LightingOff();
  camera_.texture = vtkSmartPointer<vtkTexture>::New();
  camera_.texture->InterpolateOn();
  particles_ = LineActorOf(SegmentsOf({}), IM_COL32_WHITE, 1);
  selected_particle_ = LineActorOf(SegmentsOf({}), IM_COL32_WHITE, 3);
  for (vtkActor* actor :
       {camera_.lines.Get(), camera_.picture.Get(), particles_.Get(), selected_particle_.Get()}) {
    actor->VisibilityOff();
    renderer_->AddActor(actor);
  }
}

double SceneActors::ViewAzimuth(const SequenceView& sequence) const {
  Vector3d back = Vector3d::Zero();
  for (const auto& pose : sequence.world_from_cam) back -= pose.linear().col(2);
  const UprightFrame upright(-sequence.up_in_world);
  const Vector3d back_in_upright = upright.upright_rotation().transpose() * back;
  if (back_in_upright.head<2>().norm() < 0.1 * static_cast<double>(sequence.world_from_cam.size()))
    return 0.8;
  return std::atan2(back_in_upright.y(), back_in_upright.x());
}

void SceneActors::AddModels(const SequenceView& sequence) {
  for (const ModelView& model : sequence.models) {
    ModelData data;
    data.surface = SurfaceOf(model.mesh != nullptr ? *model.mesh : TriangleMesh());
    data.edges = SharpEdgesOf(data.surface);
    models_.push_back(std::move(data));
  }
}

void SceneActors::AddTruth(const SequenceView& sequence) {
  for (const auto& truth : sequence.truth) {
    for (std::size_t i = 0; i < sequence.models.size(); ++i) {
      if (sequence.models[i].name != truth.model) continue;
      auto actor = LineActorOf(models_[i].edges, colors::kTruth, 1.5);
      SetPose(*actor, truth.world_from_object, truth.scale);
      renderer_->AddActor(actor);
      truth_.push_back(actor);
      auto solid = ActorOf(models_[i].surface, IM_COL32(150, 152, 156, 255));
      ShowOwnColors(*solid, false);
      SetPose(*solid, truth.world_from_object, truth.scale);
      solid->VisibilityOff();
      renderer_->AddActor(solid);
      truth_solid_.push_back(solid);
    }
  }
}

void SceneActors::AddSmoothed(const SequenceView& sequence) {
  if (sequence.smoothed == nullptr) return;
  for (const SmoothedObject& object : sequence.smoothed->objects) {
    const auto label = static_cast<std::size_t>(object.belief.label.value);
    if (object.belief.state != ObjectState::kConfirmed || label >= models_.size()) continue;
    auto actor = LineActorOf(models_[label].edges, colors::kSmoothed, 1.5);
    SetPose(*actor, object.belief.world_from_object, object.belief.scale);
    renderer_->AddActor(actor);
    smoothed_.push_back(actor);
  }
}

void SceneActors::AddScan(const SequenceView& sequence) {
  const auto fine =
      software_gl_ && sequence.scan_coarse != nullptr ? sequence.scan_coarse : sequence.scan;
  const bool has_scan = fine != nullptr && !fine->empty();
  scan_fine_ = scan_coarse_ = nullptr;
  if (!has_scan) return;
  // The 1 .. 99 % box: one stray point must not push the view away.
  std::vector<float> values;
  Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    const std::size_t stride = std::max<std::size_t>(1, fine->vertices.size() / 20000);
    for (std::size_t i = 0; i < fine->vertices.size(); i += stride) {
      values.push_back(fine->vertices[i][axis]);
    }
    std::sort(values.begin(), values.end());
    low[axis] = values[values.size() / 100];
    high[axis] = values[values.size() - 1 - values.size() / 100];
  }
  bounds_.extend(low);
  bounds_.extend(high);
  const std::optional<Vector3d> eye = MeanEye(sequence);
  scan_fine_ = ScanActor(*fine, sequence.up_in_world, eye);
  scan_coarse_ =
      ScanActor(ClusterToAbout(*fine, kScanVerticesWhileMoving), sequence.up_in_world, eye);
  for (vtkActor* actor : {scan_fine_.Get(), scan_coarse_.Get()}) {
    // A cloud that was thinned out closes again.
    if (fine->triangles.empty()) actor->GetProperty()->SetPointSize(3);
    ground_->AddActor(actor);
  }
}

void SceneActors::AddTrajectory(const SequenceView& sequence) {
  std::vector<Vector3d> points;
  for (const auto& pose : sequence.world_from_cam) points.push_back(pose.translation());
  trajectory_ =
      LineActorOf(PolylineOf(points), Mixed(colors::kTrajectory, colors::kBackground, 0.62), 1.25);
  walked_ = LineActorOf(PolylineOf({}), colors::kTrajectory, 2.5);
  renderer_->AddActor(trajectory_);
  renderer_->AddActor(walked_);
}

void SceneActors::AddGrid(const SequenceView& sequence) {
  const UprightFrame upright(-sequence.up_in_world);
  const Eigen::Matrix3d& axes = upright.upright_rotation();
  const double height = FloorHeight(sequence);
  double half = 2.5;
  Vector3d center = Vector3d::Zero();
  if (!bounds_.isEmpty()) {
    half = std::clamp(0.5 * bounds_.diagonal().norm(), 1.0, 50.0);
    center = axes.transpose() * bounds_.center();
  }
  grid_step_m_ = half < 1.6 ? 0.25 : half < 6 ? 0.5 : half < 16 ? 1.0 : 5.0;
  const int lines = static_cast<int>(std::ceil(half / grid_step_m_));
  const int first_x = static_cast<int>(std::floor(center.x() / grid_step_m_)) - lines;
  const int first_y = static_cast<int>(std::floor(center.y() / grid_step_m_)) - lines;
  std::vector<Vector3d> minor, major;
  const auto at = [&](int x, int y) -> Vector3d {
    return axes * Vector3d(x * grid_step_m_, y * grid_step_m_, height);
  };
  for (int i = 0; i <= 2 * lines; ++i) {
    std::vector<Vector3d>& along_y = (first_x + i) % 2 == 0 ? major : minor;
    along_y.insert(along_y.end(), {at(first_x + i, first_y), at(first_x + i, first_y + 2 * lines)});
    std::vector<Vector3d>& along_x = (first_y + i) % 2 == 0 ? major : minor;
    along_x.insert(along_x.end(), {at(first_x, first_y + i), at(first_x + 2 * lines, first_y + i)});
  }
  grid_ = LineActorOf(SegmentsOf(minor), IM_COL32(40, 46, 54, 255), 1);
  grid_major_ = LineActorOf(SegmentsOf(major), IM_COL32(58, 66, 77, 255), 1);
  for (vtkActor* actor : {grid_.Get(), grid_major_.Get()}) ground_->AddActor(actor);
}

void SceneActors::SetSnapshot(const SceneContent& content) {
  const SceneLayers& layers = content.layers;
  for (const auto& actor : truth_) actor->SetVisibility(layers.truth && !layers.truth_solid);
  for (const auto& actor : truth_solid_) actor->SetVisibility(layers.truth_solid);
  for (const auto& actor : smoothed_) actor->SetVisibility(layers.smoothed);
  trajectory_->SetVisibility(layers.trajectory && !content.look_through);
  walked_->SetVisibility(layers.trajectory && !content.look_through);
  grid_->SetVisibility(layers.grid && !content.look_through);
  grid_major_->SetVisibility(layers.grid && !content.look_through);
  scan_shown_ = layers.scan && !content.look_through;
  SetCoarse(coarse_);
  UpdateObjects(content);
  UpdateCamera(content);
  UpdateTrajectory(content);
  UpdateParticles(content);
  Clip(content);
}

/// The grid and the camera stay: they tell where the rest is.
void SceneActors::Clip(const SceneContent& content) {
  if (content.clip) {
    const ClipBox& box = *content.clip;
    while (clip_planes_->GetNumberOfItems() < 6) clip_planes_->AddItem(vtkNew<vtkPlane>());
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      const bool lower = side % 2 == 0;
      const Vector3d inward = (lower ? 1 : -1) * box.world_from_upright.col(axis);
      const Vector3d corner =
          box.world_from_upright * (lower ? box.in_upright.min() : box.in_upright.max());
      vtkPlane& plane = *clip_planes_->GetItem(side);
      plane.SetOrigin(corner.x(), corner.y(), corner.z());
      plane.SetNormal(inward.x(), inward.y(), inward.z());
    }
  }
  for (vtkRenderer* layer : {ground_, renderer_}) {
    vtkActorCollection* actors = layer->GetActors();
    actors->InitTraversal();
    while (vtkActor* actor = actors->GetNextActor()) {
      const bool stays = actor == grid_ || actor == grid_major_ || actor == camera_.lines ||
                         actor == camera_.picture;
      actor->GetMapper()->SetClippingPlanes(
          content.clip && !stays ? clip_planes_.Get() : static_cast<vtkPlaneCollection*>(nullptr));
    }
  }
}

void SceneActors::SetCoarse(bool coarse) {
  coarse_ = coarse;
  if (scan_fine_ == nullptr) return;
  scan_fine_->SetVisibility(scan_shown_ && !coarse);
  scan_coarse_->SetVisibility(scan_shown_ && coarse);
}

SceneActors::ObjectActors& SceneActors::ActorsOf(const ObjectReport& object) {
  ObjectActors& actors = objects_[object.id];
  const auto label = static_cast<std::size_t>(object.label.value);
  if (actors.surface == nullptr) {
    actors.surface = ActorOf(models_[label].surface, IM_COL32_WHITE);
    actors.surface->GetProperty()->SetAmbient(0.22);
    actors.surface->GetProperty()->SetDiffuse(0.78);
    actors.edges = LineActorOf(models_[label].edges, IM_COL32_WHITE, 1);
    renderer_->AddActor(actors.surface);
    renderer_->AddActor(actors.edges);
  }
  SetData(*actors.surface, models_[label].surface);
  SetData(*actors.edges, models_[label].edges);
  return actors;
}

void SceneActors::UpdateObjects(const SceneContent& content) {
  for (auto& [id, actors] : objects_) {
    actors.surface->VisibilityOff();
    actors.edges->VisibilityOff();
  }
  if (content.snapshot == nullptr || !content.layers.models) return;
  for (const ObjectReport& object : content.snapshot->report.objects) {
    const auto label = static_cast<std::size_t>(object.label.value);
    const auto drawn =
        std::find_if(content.objects.begin(), content.objects.end(),
                     [&](const SceneObject& wanted) { return wanted.id == object.id; });
    if (drawn == content.objects.end() || label >= models_.size()) continue;
    ObjectActors& actors = ActorsOf(object);
    const bool selected = object.id == content.selected;
    const bool tentative = object.state == ObjectState::kTentative;
    SetColor(*actors.surface, drawn->color);
    ShowOwnColors(*actors.surface, content.layers.own_colors);
    actors.surface->VisibilityOn();
    actors.edges->VisibilityOn();
    SetPose(*actors.surface, object.world_from_object, object.scale);
    SetPose(*actors.edges, object.world_from_object, object.scale);
    const float opacity =
        selected && content.layers.particles ? std::min(drawn->opacity, 0.45f) : drawn->opacity;
    actors.surface->GetProperty()->SetOpacity(opacity);
    actors.edges->GetProperty()->SetOpacity(selected ? 1.0 : std::min(1.0, 0.15 + opacity));
    SetColor(*actors.edges, selected ? IM_COL32_WHITE
                                     : Mixed(drawn->color, IM_COL32_BLACK, tentative ? 0.2 : 0.55));
    actors.edges->GetProperty()->SetLineWidth(selected ? 2.0f : 1.0f);
  }
}

void SceneActors::UpdateCamera(const SceneContent& content) {
  const bool shown = (content.layers.frustum || content.look_through) &&
                     content.snapshot != nullptr && content.snapshot->report.world_from_cam &&
                     content.sequence->fx > 0;
  camera_.lines->SetVisibility(shown && !content.look_through);
  camera_.picture->SetVisibility(false);
  if (!shown) return;
  const SequenceView& sequence = *content.sequence;
  const Eigen::Isometry3d& world_from_cam = *content.snapshot->report.world_from_cam;
  const double depth = content.look_through ? kBackdrop_m
                       : bounds_.isEmpty()
                           ? 0.3
                           : std::clamp(0.05 * bounds_.diagonal().norm(), 0.12, 0.4);
  const auto corner = [&](double u, double v) -> Vector3d {
    return world_from_cam * Vector3d(depth * (u - sequence.cx) / sequence.fx,
                                     depth * (v - sequence.cy) / sequence.fy, depth);
  };
  const double right = sequence.image_width - 0.5, bottom = sequence.image_height - 0.5;
  const Vector3d eye = world_from_cam.translation();
  const Vector3d c[4] = {corner(-0.5, -0.5), corner(right, -0.5), corner(right, bottom),
                         corner(-0.5, bottom)};
  std::vector<Vector3d> lines;
  for (int i = 0; i < 4; ++i) lines.insert(lines.end(), {eye, c[i], c[i], c[(i + 1) % 4]});
  SetData(*camera_.lines, SegmentsOf(lines));
  if (content.snapshot->image.empty()) return;
  vtkNew<vtkPlaneSource> plane;
  plane->SetOrigin(c[3].x(), c[3].y(), c[3].z());
  plane->SetPoint1(c[2].x(), c[2].y(), c[2].z());
  plane->SetPoint2(c[0].x(), c[0].y(), c[0].z());
  plane->Update();
  SetData(*camera_.picture, plane->GetOutput());
  camera_.texture->SetInputData(TextureImage(
      content.snapshot->image, content.look_through ? kBackdropImageWidth : kFrustumImageWidth));
  camera_.picture->SetTexture(camera_.texture);
  camera_.picture->VisibilityOn();
}

void SceneActors::UpdateTrajectory(const SceneContent& content) {
  std::vector<Vector3d> points;
  const SequenceView& sequence = *content.sequence;
  if (content.snapshot != nullptr && content.snapshot->report.world_from_cam &&
      sequence.num_frames > 1) {
    // Poses are listed without their frames; those that lack one are few.
    const double share =
        static_cast<double>(content.snapshot->report.frame) / (sequence.num_frames - 1);
    const auto count =
        static_cast<std::size_t>(share * static_cast<double>(sequence.world_from_cam.size()));
    for (std::size_t i = 0; i < std::min(count, sequence.world_from_cam.size()); ++i) {
      points.push_back(sequence.world_from_cam[i].translation());
    }
    points.push_back(content.snapshot->report.world_from_cam->translation());
  }
  SetData(*walked_, PolylineOf(points));
}

void SceneActors::UpdateParticles(const SceneContent& content) {
  particles_->VisibilityOff();
  selected_particle_->VisibilityOff();
  if (content.snapshot == nullptr || !content.layers.particles) return;
  for (const ObjectReport& object : content.snapshot->report.objects) {
    if (object.id != content.selected || object.particles == nullptr) continue;
    const UprightFrame upright(-content.sequence->up_in_world);
    const ImU32 color = content.particle_color;
    const auto label = static_cast<std::size_t>(object.label.value);
    const auto& models = content.sequence->models;
    const double length = NeedleLength(label < models.size() ? &models[label] : nullptr);
    double heaviest = -1e9;
    for (const Particle& p : *object.particles) heaviest = std::max<double>(heaviest, p.log_weight);
    std::vector<Vector3d> needles;
    vtkNew<vtkUnsignedCharArray> rgb;
    rgb->SetNumberOfComponents(3);
    for (std::size_t i = 0; i < object.particles->size(); ++i) {
      const Particle& particle = (*object.particles)[i];
      const ParticlePlace place = PlaceOf(particle, object, upright);
      needles.insert(needles.end(), {place.center_in_world,
                                     place.center_in_world + length * place.heading_in_world});
      const double light = std::exp(std::max(-4.0, particle.log_weight - heaviest));
      const cv::Vec3b bgr = BgrOf(
          Mixed(Mixed(color, IM_COL32_BLACK, 0.45), Mixed(color, IM_COL32_WHITE, 0.55), light));
      rgb->InsertNextTuple3(bgr[2], bgr[1], bgr[0]);
      if (static_cast<int>(i) == content.selected_particle) {
        SetData(*selected_particle_, SegmentsOf({needles.end() - 2, needles.end()}));
        selected_particle_->VisibilityOn();
      }
    }
    auto data = SegmentsOf(needles);
    data->GetCellData()->SetScalars(rgb);
    SetData(*particles_, data);
    particles_->VisibilityOn();
  }
}

std::vector<std::pair<vtkActor*, ObjectId>> SceneActors::pickable() const {
  std::vector<std::pair<vtkActor*, ObjectId>> actors;
  for (const auto& [id, object] : objects_) {
    if (object.surface->GetVisibility()) actors.emplace_back(object.surface.Get(), id);
  }
  return actors;
}

}  // namespace plumbline
