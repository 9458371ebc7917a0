// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/true_instances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/base/check.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/geometry/embree.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

constexpr int kRaysAcross = 80;
constexpr float kNearest_m = 0.05f;
constexpr float kLeastOverlap = 0.3f;  ///< Of a proposal and what shows of an instance.

std::vector<PlacedThing> PlacedTruths(const SequenceView& view) {
  std::vector<PlacedThing> truths;
  for (const SequenceView::Truth& truth : view.truth) {
    const ModelView* model = ModelByName(view, truth.model);
    truths.push_back({model != nullptr ? std::string_view(model->category) : std::string_view("?"),
                      truth.world_from_object.translation()});
  }
  return truths;
}

/// Adds the pairs of those that `wants`, among the instances that are left.
template <typename Wants>
void PairMore(const FrameReport& report, const std::vector<PlacedThing>& truths, double reach_m,
              const Wants& wants, std::vector<std::optional<int>>& pairs) {
  std::vector<bool> taken(truths.size(), false);
  for (const std::optional<int>& pair : pairs) {
    if (pair) taken[static_cast<std::size_t>(*pair)] = true;
  }
  std::vector<PlacedThing> objects, free;
  std::vector<std::size_t> object_at;
  std::vector<int> truth_at;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const ObjectReport& object = report.objects[i];
    if (pairs[i] || !wants(object)) continue;
    objects.push_back({object.category, object.world_from_object.translation()});
    object_at.push_back(i);
  }
  for (std::size_t j = 0; j < truths.size(); ++j) {
    if (taken[j]) continue;
    free.push_back(truths[j]);
    truth_at.push_back(static_cast<int>(j));
  }
  const std::vector<std::optional<int>> found = PairWithTruth(objects, free, reach_m);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) pairs[object_at[i]] = truth_at[static_cast<std::size_t>(*found[i])];
  }
}

double AzimuthBetween(const ModelView& model, double azimuth_rad) {
  if (model.any_azimuth) return 0;
  return std::abs(
      std::remainder(azimuth_rad, 2 * std::numbers::pi / std::max(1, model.symmetry_order)));
}

/// For each proposal the instance that it lies over best.
void AddBoxes(const FrameReport& report, const std::vector<PlacedThing>& truths,
              std::vector<TruthSample>& samples) {
  for (const ProposalReport& proposal : report.proposals) {
    TruthSample* best = nullptr;
    float best_overlap = kLeastOverlap;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (truths[i].category != proposal.category) continue;
      const float overlap = Iou(proposal.box, samples[i].box);
      if (overlap < best_overlap) continue;
      best_overlap = overlap;
      best = &samples[i];
    }
    if (best == nullptr || best_overlap <= best->box_overlap) continue;
    best->box_fate = proposal.fate;
    best->box_overlap = best_overlap;
    best->box_object = proposal.object;
  }
}

void AddNear(const FrameReport& report, const SequenceView& view,
             const std::vector<PlacedThing>& truths, std::vector<TruthSample>& samples) {
  const UprightFrame upright(-view.up_in_world);
  for (std::size_t j = 0; j < samples.size(); ++j) {
    const Eigen::Isometry3d& truth = view.truth[j].world_from_object;
    const ModelView* model = ModelByName(view, view.truth[j].model);
    for (const ObjectReport& object : report.objects) {
      if (model == nullptr || object.category != truths[j].category) continue;
      const double distance_m =
          (object.world_from_object.translation() - truth.translation()).norm();
      if (distance_m > kFarthestTruth_m) continue;
      const double turned =
          upright.Azimuth(object.world_from_object.linear()) - upright.Azimuth(truth.linear());
      samples[j].near.push_back({object.id, static_cast<float>(distance_m),
                                 static_cast<float>(AzimuthBetween(*model, turned))});
    }
    std::sort(samples[j].near.begin(), samples[j].near.end(),
              [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  }
}

}  // namespace

const ModelView* ModelByName(const SequenceView& view, const std::string& name) {
  for (const ModelView& model : view.models) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

std::vector<std::optional<int>> TruthsOfObjects(const FrameReport& report,
                                                const SequenceView& view) {
  std::vector<std::optional<int>> pairs(report.objects.size());
  if (view.truth.empty()) return pairs;
  const std::vector<PlacedThing> truths = PlacedTruths(view);
  const auto is = [](ObjectState state) {
    return [state](const ObjectReport& object) { return object.state == state; };
  };
  PairMore(report, truths, kPairReach_m, is(ObjectState::kConfirmed), pairs);
  PairMore(report, truths, kPairReach_m, is(ObjectState::kTentative), pairs);
  PairMore(
      report, truths, kFarthestTruth_m,
      [](const ObjectReport& object) { return object.state != ObjectState::kRetired; }, pairs);
  return pairs;
}

std::optional<ComparedTruth> TruthToCompare(const FrameReport& report, const SequenceView& view,
                                            ObjectId object, double reach_m) {
  const std::vector<std::optional<int>> pairs = TruthsOfObjects(report, view);
  const ObjectReport* asked = nullptr;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    if (report.objects[i].id != object) continue;
    if (pairs[i]) return ComparedTruth{*pairs[i], {}};
    asked = &report.objects[i];
  }
  if (asked == nullptr) return std::nullopt;
  const std::vector<PlacedThing> truths = PlacedTruths(view);
  std::optional<ComparedTruth> nearest;
  double nearest_m = reach_m;
  for (std::size_t j = 0; j < truths.size(); ++j) {
    const double distance_m = (truths[j].origin - asked->world_from_object.translation()).norm();
    if (truths[j].category != asked->category || distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = ComparedTruth{static_cast<int>(j), {}};
  }
  for (std::size_t i = 0; nearest && i < pairs.size(); ++i) {
    if (pairs[i] == nearest->truth) nearest->explained_by = report.objects[i].id;
  }
  return nearest;
}

const ObjectReport* CandidateFor(const FrameReport& report, const SequenceView& view, int truth) {
  const std::vector<std::optional<int>> pairs = TruthsOfObjects(report, view);
  const PlacedThing instance = PlacedTruths(view)[static_cast<std::size_t>(truth)];
  const ObjectReport* nearest = nullptr;
  double nearest_m = kFarthestTruth_m;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const ObjectReport& object = report.objects[i];
    if (object.category != instance.category || object.state == ObjectState::kRetired) continue;
    if (pairs[i] == truth) return &object;
    if (pairs[i]) continue;
    const double distance_m = (object.world_from_object.translation() - instance.origin).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = &object;
  }
  return nearest;
}

std::optional<PlantedObject> PlantTruth(const SequenceView& view, const std::string& instance) {
  for (const SequenceView::Truth& truth : view.truth) {
    if (truth.id == instance)
      return PlantedObject{truth.model, truth.world_from_object, truth.scale,
                           "planted at the true place of " + truth.id};
  }
  return std::nullopt;
}

struct TruthVisibility::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Eigen::AlignedBox3d> bounds;  ///< In world; as in SequenceView::truth.
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;

  Scene() : device(rtcNewDevice(nullptr)) {
    PLB_CHECK(device != nullptr) << "Embree gives no device";
    scene = rtcNewScene(device);
  }
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  void Add(const TriangleMesh& mesh, const SequenceView::Truth& truth) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const Eigen::Vector3d in_world =
          truth.world_from_object * (truth.scale * vertex.cast<double>());
      bounds.back().extend(in_world);
      const Eigen::Vector3f narrow = in_world.cast<float>();
      vertices = std::copy(narrow.data(), narrow.data() + 3, vertices);
    }
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (const Eigen::Vector3i& triangle : mesh.triangles)
      indices = std::copy(triangle.data(), triangle.data() + 3, indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(bounds.size() - 1));
    rtcReleaseGeometry(geometry);
  }

  /// Where rays can meet an instance at all.
  Box2 Reach(const Eigen::Isometry3d& cam_from_world) const {
    Box2 all;
    for (const Eigen::AlignedBox3d& box : bounds) {
      if (box.isEmpty()) continue;
      Box2 one;
      bool behind = false, front = false;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d p =
            cam_from_world * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        (p.z() > kNearest_m ? front : behind) = true;
        if (p.z() <= kNearest_m) continue;
        const auto x = static_cast<float>(fx * p.x() / p.z() + cx);
        const auto y = static_cast<float>(fy * p.y() / p.z() + cy);
        const Box2 point{x, y, x + 1e-3f, y + 1e-3f};
        one = one.empty() ? point : Union(one, point);
      }
      if (front && behind) one = {0, 0, static_cast<float>(width), static_cast<float>(height)};
      if (!one.empty()) all = all.empty() ? one : Union(all, one);
    }
    return all;
  }
};

TruthVisibility::TruthVisibility(const SequenceView& view) : scene_(std::make_unique<Scene>()) {
  scene_->width = view.image_width;
  scene_->height = view.image_height;
  scene_->fx = view.fx;
  scene_->fy = view.fy;
  scene_->cx = view.cx;
  scene_->cy = view.cy;
  for (const SequenceView::Truth& truth : view.truth) {
    scene_->bounds.emplace_back();
    const ModelView* model = ModelByName(view, truth.model);
    if (model != nullptr && model->mesh != nullptr && !model->mesh->triangles.empty())
      scene_->Add(*model->mesh, truth);
  }
  rtcCommitScene(scene_->scene);
}

TruthVisibility::~TruthVisibility() = default;
TruthVisibility::TruthVisibility(TruthVisibility&&) noexcept = default;
TruthVisibility& TruthVisibility::operator=(TruthVisibility&&) noexcept = default;

std::vector<TruthVisibility::Shown> TruthVisibility::From(
    const Eigen::Isometry3d& world_from_cam) const {
  const Scene& s = *scene_;
  std::vector<Shown> shown(s.bounds.size());
  if (s.width <= 0 || s.height <= 0 || s.fx <= 0) return shown;
  const Box2 reach = s.Reach(world_from_cam.inverse());
  const int step = std::max(1, s.width / kRaysAcross);
  RayContext context;
  InitRayContext(context);
  const Eigen::Vector3f from = world_from_cam.translation().cast<float>();
  for (int y = step / 2; y < s.height; y += step) {
    if (static_cast<float>(y) < reach.y0 || static_cast<float>(y) > reach.y1) continue;
    for (int x = step / 2; x < s.width; x += step) {
      if (static_cast<float>(x) < reach.x0 || static_cast<float>(x) > reach.x1) continue;
      const Eigen::Vector3f along =
          (world_from_cam.linear() * Eigen::Vector3d((x - s.cx) / s.fx, (y - s.cy) / s.fy, 1))
              .cast<float>();
      RTCRayHit ray{};
      ray.ray.org_x = from.x();
      ray.ray.org_y = from.y();
      ray.ray.org_z = from.z();
      ray.ray.dir_x = along.x();
      ray.ray.dir_y = along.y();
      ray.ray.dir_z = along.z();
      ray.ray.tnear = kNearest_m;
      ray.ray.tfar = std::numeric_limits<float>::infinity();
      ray.ray.mask = ~0u;
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      TraceRay(s.scene, context, ray);
      if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      Shown& hit = shown[ray.hit.geomID];
      hit.pixels += static_cast<float>(step * step);
      const auto low_x = static_cast<float>(x - step / 2), low_y = static_cast<float>(y - step / 2);
      const Box2 cell{low_x, low_y, low_x + static_cast<float>(step),
                      low_y + static_cast<float>(step)};
      hit.box = hit.box.empty() ? cell : Union(hit.box, cell);
    }
  }
  return shown;
}

std::vector<TruthSample> TruthSamplesOf(const FrameReport& report, const SequenceView& view,
                                        const std::vector<std::optional<int>>& pairs,
                                        const TruthVisibility& visibility) {
  std::vector<TruthSample> samples(view.truth.size());
  if (samples.empty()) return samples;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i]) continue;
    const auto at = static_cast<std::size_t>(*pairs[i]);
    const double distance_m = (report.objects[i].world_from_object.translation() -
                               view.truth[at].world_from_object.translation())
                                  .norm();
    if (distance_m > kPairReach_m) continue;  // compared with it, but not it
    TruthSample& sample = samples[at];
    sample.object = report.objects[i].id;
    sample.confirmed = report.objects[i].state == ObjectState::kConfirmed;
  }
  if (report.world_from_cam) {
    const std::vector<TruthVisibility::Shown> shown = visibility.From(*report.world_from_cam);
    for (std::size_t j = 0; j < samples.size(); ++j) {
      samples[j].visible_px = shown[j].pixels;
      samples[j].box = shown[j].box;
    }
  }
  const std::vector<PlacedThing> truths = PlacedTruths(view);
  AddBoxes(report, truths, samples);
  AddNear(report, view, truths, samples);
  return samples;
}

}  // namespace plumbline
