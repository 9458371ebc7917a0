// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <thread>

#include <opencv2/imgproc.hpp>

#include "engine/analysis/history.h"
#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/random_vector.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

void AddBox(const Vector3d& low, const Vector3d& high, TriangleMesh& mesh) {
  const int base = static_cast<int>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? high : low).x(), (i & 2 ? high : low).y(),
                               (i & 4 ? high : low).z());
  }
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh.triangles.emplace_back(base + q[0], base + q[1], base + q[2]);
    mesh.triangles.emplace_back(base + q[0], base + q[2], base + q[3]);
  }
}

ModelView Furniture(const std::string& name, const std::string& category, double half_x,
                    double half_y, double top, double back) {
  TriangleMesh mesh;
  const double leg = 0.05;
  AddBox({-half_x, -half_y, top - 0.05}, {half_x, half_y, top}, mesh);
  for (const double x : {-half_x, half_x - leg}) {
    for (const double y : {-half_y, half_y - leg}) {
      AddBox({x, y, 0}, {x + leg, y + leg, top - 0.05}, mesh);
    }
  }
  if (back > 0) AddBox({-half_x, -half_y, top}, {-half_x + leg, half_y, top + back}, mesh);
  ModelView view{name, category, std::make_shared<const TriangleMesh>(mesh), {}};
  view.bounds = BoundingBox(mesh);
  view.center = view.bounds.center().cast<double>();
  return view;
}

struct TrueObject {
  int model;
  Isometry3d world_from_object;
  int first_frame;
  int retired_frame;  ///< -1: stays
};

Isometry3d Upright(double x, double y, double azimuth_deg) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(azimuth_deg * M_PI / 180, Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Vector3d(x, y, 0);
  return pose;
}

class FakeSource : public SnapshotSource {
 public:
  explicit FakeSource(const FakeSourceOptions& options) : options_(options) {
    view_.name = "made-up room";
    view_.path = "tests/made-up-room";
    view_.num_frames = options.num_frames;
    view_.image_width = options.width;
    view_.image_height = options.height;
    view_.fx = view_.fy = 0.62 * options.width;
    view_.cx = 0.5 * (options.width - 1);
    view_.cy = 0.5 * (options.height - 1);
    view_.models = {Furniture("chair_slim", "chair", 0.22, 0.22, 0.45, 0.5),
                    Furniture("chair_wide", "chair", 0.28, 0.3, 0.42, 0.38),
                    Furniture("table_oak", "dining table", 0.7, 0.45, 0.74, 0)};
    truth_ = {{2, Upright(0, 0, 15), 0, -1},
              {0, Upright(0.95, 0.1, 190), 0, -1},
              {1, Upright(-0.2, 0.85, 280), 5, -1},
              {0, Upright(-1.05, -0.3, 20), 9, -1},
              {1, Upright(1.6, -1.4, 100), 12, 45}};
    for (std::size_t i = 0; i + 1 < truth_.size(); ++i) {
      view_.truth.push_back({"t" + std::to_string(i), view_.models[truth_[i].model].name,
                             truth_[i].world_from_object});
    }
    for (int i = 0; i < options.num_frames; ++i) view_.world_from_cam.push_back(CameraPose(i));
    view_.scan = MakeScan();
    if (options.recorded) {
      for (; next_ < options.num_frames; next_ += options.stride) frames_.push_back(next_);
      for (int i = 0; i < options.num_frames; ++i) AddEvents(i);
      for (int i = 0; i < size(); ++i) AddHistory(*Make(FrameAt(i)));
    }
  }

  const SequenceView& view() const override { return view_; }
  int size() const override {
    const int rest = options_.num_frames - next_;
    return mapped() + (rest > 0 ? (rest - 1) / options_.stride + 1 : 0);
  }
  int mapped() const override { return static_cast<int>(frames_.size()); }
  int FrameAt(int position) const override {
    return position < mapped() ? frames_[static_cast<std::size_t>(position)]
                               : next_ + (position - mapped()) * options_.stride;
  }
  std::optional<LiveReport> live() const override {
    if (options_.live_passes_over == 0) return std::nullopt;
    LiveReport report;
    report.taken = report.done = mapped();
    report.passed_over = (frames_.empty() ? 0 : frames_.back() + 1) - mapped();
    return report;
  }
  bool recorded() const override { return options_.recorded; }
  const std::vector<FrameEvent>& events() const override { return events_; }
  const RunHistory& history() const override { return history_; }

  Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token stop) override {
    for (int waited = 0; waited < options_.milliseconds_per_frame; waited += 5) {
      if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const int frame = next_;
    if (frame == options_.fail_at_frame) {
      return Error{ErrorCode::kCorrupt, "the made-up frame cannot be read; this is a test"};
    }
    if (frame == options_.throw_at_frame) throw std::runtime_error("made-up exception");
    for (int i = frames_.empty() ? 0 : frames_.back() + 1; i <= frame; ++i) AddEvents(i);
    frames_.push_back(frame);
    next_ += options_.stride;
    if (options_.live_passes_over > 0 && next_ < options_.num_frames)
      next_ = std::min(next_ + options_.live_passes_over, options_.num_frames - 1);
    auto snapshot = Make(frame);
    AddHistory(*snapshot);
    return snapshot;
  }
  Result<std::shared_ptr<const MapSnapshot>> Past(int position, std::stop_token) override {
    return Make(FrameAt(position));
  }

 private:
  void AddHistory(const MapSnapshot& snapshot) {
    history_.frames.push_back(
        std::make_shared<const FrameSample>(SampleOf(snapshot.report, view_)));
    if (WantsThumbnail(static_cast<int>(history_.frames.size()) - 1, size()))
      history_.thumbnails.push_back({snapshot.report.frame, ThumbnailOf(snapshot.image)});
  }

  Isometry3d CameraPose(int frame) const {
    const double angle = -0.6 + 2.2 * frame / 120.0;
    const Vector3d eye(2.9 * std::cos(angle), 2.9 * std::sin(angle),
                       1.5 + 0.1 * std::sin(4 * angle));
    const Vector3d z = (Vector3d(0, 0, 0.45) - eye).normalized();
    const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() << x, z.cross(x), z;
    pose.translation() = eye;
    return pose;
  }

  std::shared_ptr<const TriangleMesh> MakeScan() const {
    auto scan = std::make_shared<TriangleMesh>();
    Random random({7, 0, 0, 0});
    for (int i = 0; i < 6000; ++i) {
      const double z = random.Gaussian() * 0.004, y = random.Uniform(-2.6, 2.6),
                   x = random.Uniform(-3, 3);
      const Vector3d point(x, y, z);
      scan->vertices.push_back(point.cast<float>());
      const auto grey = static_cast<std::uint8_t>(120 + 20 * random.Gaussian());
      scan->colors.push_back({grey, grey, static_cast<std::uint8_t>(grey - 12)});
    }
    for (const TrueObject& object : truth_) {
      for (const auto& t : view_.models[object.model].mesh->triangles) {
        const auto& v = view_.models[object.model].mesh->vertices;
        for (int i = 0; i < 12; ++i) {
          double a = random.Uniform(), b = random.Uniform();
          if (a + b > 1) a = 1 - a, b = 1 - b;
          const Vector3d p =
              (v[t[0]] + a * (v[t[1]] - v[t[0]]) + b * (v[t[2]] - v[t[0]])).cast<double>();
          scan->vertices.push_back((object.world_from_object * p).cast<float>());
          scan->colors.push_back({150, 132, 110});
        }
      }
    }
    return scan;
  }

  bool Alive(const TrueObject& object, int frame) const {
    return frame >= object.first_frame &&
           (object.retired_frame < 0 || frame <= object.retired_frame);
  }

  void AddEvents(int frame) {
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const ObjectId id{static_cast<int>(i) + 1};
      const std::string& category = view_.models[truth_[i].model].category;
      if (frame == truth_[i].first_frame) {
        events_.push_back(
            {frame, {EventKind::kSpawned, id, {}, "unexplained proposal: " + category}});
      }
      if (frame == truth_[i].first_frame + 15 && truth_[i].retired_frame < 0) {
        events_.push_back(
            {frame, {EventKind::kConfirmed, id, {}, "evidence reached the threshold"}});
      }
      if (frame == truth_[i].retired_frame) {
        events_.push_back({frame, {EventKind::kRetired, id, {}, "tentative for too long"}});
      }
    }
  }

  ObjectReport Object(int index, int frame) const {
    const TrueObject& object = truth_[index];
    const int age = frame - object.first_frame;
    const double sigma = 0.02 + 0.25 * std::exp(-age / 12.0);
    const UprightFrame upright(Vector3d(0, 0, -1));
    ObjectReport report;
    report.id = {index + 1};
    report.category = view_.models[object.model].category;
    report.reference_frame = report.first_frame = object.first_frame;
    report.world_from_reference_cam = CameraPose(object.first_frame);
    report.last_frame = frame;
    if (object.retired_frame < 0 && age >= 15) {
      report.state = ObjectState::kConfirmed;
      report.confirmed_frame = object.first_frame + 15;
    } else if (frame == object.retired_frame) {
      report.state = ObjectState::kRetired;
    }
    report.label = {object.model};
    const double sure = 1.0 - 0.5 * std::exp(-age / 20.0);
    report.label_probability = {{report.label, object.model == 2 ? 1.0 : sure}};
    if (object.model != 2) report.label_probability.push_back({{1 - object.model}, 1 - sure});
    Random random({11, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(index), 0});
    report.world_from_object = object.world_from_object;
    report.world_from_object.translation().head<2>() += 0.3 * sigma * GaussianVector<2>(random);
    report.covariance =
        Eigen::Vector4d(sigma * sigma, sigma * sigma, 0.2 * sigma * sigma, sigma * sigma)
            .asDiagonal();
    report.modes = {{report.label, 1.0, report.world_from_object, sigma, sigma}};
    const bool ambiguous = index == 2;
    if (ambiguous) {
      Isometry3d turned = report.world_from_object;
      turned.linear() = turned.linear() * Eigen::AngleAxisd(M_PI, Vector3d::UnitZ());
      report.modes[0].weight = 0.7;
      report.modes.push_back({report.label, 0.3, turned, 1.4 * sigma, 1.2 * sigma});
    }
    auto particles = std::make_shared<std::vector<Particle>>();
    const Isometry3d ref_from_world = report.world_from_reference_cam.inverse();
    for (int p = 0; p < options_.particles; ++p) {
      const bool second = ambiguous && p % 10 < 3;
      const Isometry3d& mean = report.modes[second ? 1 : 0].world_from_object;
      Particle particle;
      particle.label = static_cast<std::uint16_t>(
          object.model != 2 && random.Uniform() > sure ? 1 - object.model : object.model);
      particle.azimuth = static_cast<float>(
          WrapAngle(upright.Azimuth(mean.linear()) + sigma * 1.5 * random.Gaussian()));
      const Vector3d noise = GaussianVector<3>(random).cwiseProduct(Vector3d(1, 1, 0.4));
      const Vector3d center =
          ref_from_world * (mean * view_.models[object.model].center + sigma * noise);
      particle.x_c = static_cast<float>(center.x() / center.z());
      particle.y_c = static_cast<float>(center.y() / center.z());
      particle.rho = static_cast<float>(std::log(center.z()));
      particle.log_weight = static_cast<float>(-std::log(options_.particles));
      particle.phi_cnn = static_cast<float>(0.5 + 0.1 * random.Gaussian());
      particle.phi_edge = static_cast<float>(0.4 + 0.1 * random.Gaussian());
      particles->push_back(particle);
    }
    report.particles = particles;
    report.effective_sample_size = 0.6 * options_.particles;
    report.log_evidence = std::min(6.0, -1 + 0.3 * age);
    report.updated = index != 3 || frame % 40 < 30;
    report.visible_fraction = report.updated ? 0.55 + 0.3 * std::sin(frame * 0.05 + index) : 0.02;
    report.phi_cnn = 0.62f;
    report.phi_edge = 0.48f;
    return report;
  }

  /// Draws a mesh by barycentric z-buffering. `shade` is written into the image.
  void Draw(const TriangleMesh& mesh, const Isometry3d& cam_from_mesh, int id,
            const cv::Vec3d& color, MapSnapshot& snapshot) const {
    for (const auto& t : mesh.triangles) {
      Vector3d p[3];
      Eigen::Vector2d u[3];
      bool behind = false;
      for (int k = 0; k < 3; ++k) {
        p[k] = cam_from_mesh * mesh.vertices[t[k]].cast<double>();
        behind = behind || p[k].z() < 0.05;
        u[k] = {view_.fx * p[k].x() / p[k].z() + view_.cx,
                view_.fy * p[k].y() / p[k].z() + view_.cy};
      }
      if (behind) continue;
      const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
      const double light =
          0.35 + 0.65 * std::abs(normal.dot(Vector3d(0.3, -0.7, -0.6).normalized()));
      const double area =
          (u[1] - u[0]).x() * (u[2] - u[0]).y() - (u[1] - u[0]).y() * (u[2] - u[0]).x();
      if (std::abs(area) < 1e-9) continue;
      const auto clamp = [](double v, int high) {
        return std::clamp(static_cast<int>(v), 0, high);
      };
      const int x0 = clamp(std::min({u[0].x(), u[1].x(), u[2].x()}), options_.width - 1);
      const int x1 = clamp(std::max({u[0].x(), u[1].x(), u[2].x()}) + 1, options_.width - 1);
      const int y0 = clamp(std::min({u[0].y(), u[1].y(), u[2].y()}), options_.height - 1);
      const int y1 = clamp(std::max({u[0].y(), u[1].y(), u[2].y()}) + 1, options_.height - 1);
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          const Eigen::Vector2d q(x, y);
          const auto cross = [&](int a, int b) {
            return ((u[a] - q).x() * (u[b] - q).y() - (u[a] - q).y() * (u[b] - q).x()) / area;
          };
          const double w0 = cross(1, 2), w1 = cross(2, 0), w2 = cross(0, 1);
          if (w0 < 0 || w1 < 0 || w2 < 0) continue;
          const auto z = static_cast<float>(1 / (w0 / p[0].z() + w1 / p[1].z() + w2 / p[2].z()));
          float& depth = snapshot.depth.at<float>(y, x);
          if (depth > 0 && depth <= z) continue;
          depth = z;
          snapshot.id.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(id);
          for (int c = 0; c < 3; ++c) {
            snapshot.image.at<cv::Vec3b>(y, x)[c] =
                cv::saturate_cast<std::uint8_t>(color[c] * light);
          }
        }
      }
    }
  }

  void DrawFloor(const Isometry3d& cam_from_world, cv::Mat& image) const {
    const Isometry3d world_from_cam = cam_from_world.inverse();
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const Vector3d ray = world_from_cam.linear() *
                             Vector3d((x - view_.cx) / view_.fx, (y - view_.cy) / view_.fy, 1);
        cv::Vec3b color(172, 178, 182);
        if (ray.z() < -1e-3) {
          const Vector3d hit =
              world_from_cam.translation() - ray * world_from_cam.translation().z() / ray.z();
          const bool odd = (static_cast<int>(std::floor(hit.x() * 2)) +
                            static_cast<int>(std::floor(hit.y() * 2))) &
                           1;
          if (hit.norm() < 4) color = odd ? cv::Vec3b(116, 128, 140) : cv::Vec3b(128, 140, 152);
        }
        image.at<cv::Vec3b>(y, x) = color;
      }
    }
  }

  std::shared_ptr<const MapSnapshot> Make(int frame) const {
    auto snapshot = std::make_shared<MapSnapshot>();
    FrameReport& report = snapshot->report;
    report.frame = frame;
    report.stamp_ns = static_cast<std::int64_t>(frame) * 1'000'000'000 / 30;
    report.world_from_cam = view_.world_from_cam[frame];
    const Isometry3d cam_from_world = report.world_from_cam->inverse();
    snapshot->image.create(options_.height, options_.width, CV_8UC3);
    snapshot->depth = cv::Mat(options_.height, options_.width, CV_32F, cv::Scalar(0));
    snapshot->id = cv::Mat(options_.height, options_.width, CV_16U, cv::Scalar(0));
    DrawFloor(cam_from_world, snapshot->image);
    const cv::Vec3d colors[] = {{90, 120, 170}, {150, 110, 80}, {70, 110, 150}};
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (!Alive(truth_[i], frame)) continue;
      report.objects.push_back(Object(static_cast<int>(i), frame));
      const bool real = truth_[i].retired_frame < 0;
      if (real) {
        Draw(*view_.models[truth_[i].model].mesh, cam_from_world * truth_[i].world_from_object,
             static_cast<int>(i) + 1, colors[truth_[i].model], *snapshot);
      }
    }
    for (const FrameEvent& event : events_) {
      if (event.frame == frame) report.events.push_back(event.event);
    }
    AddEdgesAndOutlines(*snapshot);
    const double wave = 1 + 0.2 * std::sin(0.3 * frame);
    report.timings = {{"read", 3.1},       {"edges", 5.2 * wave}, {"detect", 6.4},
                      {"visibility", 1.1}, {"diffuse", 0.4},      {"score", 7.9 * wave},
                      {"resample", 0.3},   {"render", 2.2},       {"spawn", 0.6}};
    return snapshot;
  }

  void AddEdgesAndOutlines(MapSnapshot& snapshot) const {
    cv::Mat grey, dx, dy, magnitude, angle;
    cv::cvtColor(snapshot.image, grey, cv::COLOR_BGR2GRAY);
    cv::Sobel(grey, dx, CV_32F, 1, 0);
    cv::Sobel(grey, dy, CV_32F, 0, 1);
    cv::cartToPolar(dx, dy, magnitude, angle);
    magnitude.convertTo(snapshot.edge_probability, CV_8U, 1.2);
    snapshot.edge_angle.create(grey.size(), CV_8U);
    for (int i = 0; i < static_cast<int>(angle.total()); ++i) {
      snapshot.edge_angle.ptr()[i] =
          static_cast<std::uint8_t>(static_cast<int>(angle.ptr<float>()[i] * 256 / M_PI) & 255);
    }
    for (ObjectReport& object : snapshot.report.objects) {
      const cv::Mat mask = snapshot.id == object.id.value;
      std::vector<std::vector<cv::Point>> contours;
      cv::findContours(mask, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_TC89_L1);
      if (contours.empty()) continue;
      OutlineView outline{object.id, {}};
      for (const auto& contour : contours) {
        outline.contours.emplace_back();
        for (const cv::Point& p : contour) outline.contours.back().emplace_back(p.x, p.y);
      }
      snapshot.outlines.push_back(std::move(outline));
      const cv::Rect box = cv::boundingRect(mask);
      object.visible_box = object.whole_box = {static_cast<float>(box.x), static_cast<float>(box.y),
                                               static_cast<float>(box.x + box.width),
                                               static_cast<float>(box.y + box.height)};
      snapshot.report.proposals.push_back({object.visible_box, object.category, 0.78f,
                                           object.first_frame == snapshot.report.frame
                                               ? ProposalFate::kSpawned
                                               : ProposalFate::kExplained,
                                           object.id});
    }
    snapshot.report.proposals.push_back(
        {{20, 30, 80, 90}, "potted plant", 0.41f, ProposalFate::kUnknownCategory, {}});
    snapshot.report.proposals.push_back(
        {{300, 20, 360, 70}, "chair", 0.22f, ProposalFate::kLowScore, {}});
  }

  FakeSourceOptions options_;
  SequenceView view_;
  std::vector<TrueObject> truth_;
  std::vector<FrameEvent> events_;
  RunHistory history_;
  std::vector<int> frames_;  ///< Mapped.
  int next_ = 0;
};

}  // namespace

std::unique_ptr<SnapshotSource> MakeFakeSource(const FakeSourceOptions& options) {
  return std::make_unique<FakeSource>(options);
}

}  // namespace plumbline
