// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/viewpoint_model.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include "engine/base/files.h"
#include "engine/geometry/angles.h"
#include "engine/vision/model_lines.h"

namespace plumbline {
namespace {

constexpr std::size_t kFloatsPerPoint = 8;

constexpr char kFormat[] = "plumbline-viewpoints-14";

std::string CacheKey(const CadModel& model, const ViewpointModelOptions& o) {
  std::string key = std::string(kFormat) + "|" + model.content_hash + "|" +
                    std::to_string(model.symmetry.order == 0);
  for (const double value :
       {static_cast<double>(o.azimuths), static_cast<double>(o.elevations), o.min_elevation_deg,
        o.max_elevation_deg, static_cast<double>(o.points), static_cast<double>(o.image_px),
        o.contour_step_m, o.inner_weight, o.crease_angle_deg, o.mark_contrast, o.rim_m}) {
    key += "|" + std::to_string(value);
  }
  for (const double distance : o.distances) key += "|" + std::to_string(distance);
  return HashHex(key);
}

template <typename T>
void PutVector(const std::vector<T>& values, std::string& out) {
  const std::uint64_t count = values.size();
  out.append(reinterpret_cast<const char*>(&count), sizeof(count));
  out.append(reinterpret_cast<const char*>(values.data()), count * sizeof(T));
}

template <typename T>
bool TakeVector(std::string_view& in, std::vector<T>& values) {
  std::uint64_t count = 0;
  if (in.size() < sizeof(count)) return false;
  std::memcpy(&count, in.data(), sizeof(count));
  in.remove_prefix(sizeof(count));
  if (count > in.size() / sizeof(T)) return false;
  values.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), in.data(), count * sizeof(T));
  in.remove_prefix(count * sizeof(T));
  return true;
}

}  // namespace

int ViewpointModel::NumViews() const {
  return static_cast<int>(options_.distances.size()) * options_.elevations * options_.azimuths;
}

ViewpointModelOptions ViewpointsOf(const CadModel& model) {
  ViewpointModelOptions options;
  options.max_elevation_deg = 80;
  options.min_elevation_deg = model.support == Support::kFloor ? -10 : -60;
  options.elevations =
      1 +
      static_cast<int>(std::lround((options.max_elevation_deg - options.min_elevation_deg) / 10));
  return options;
}

Result<std::shared_ptr<const ViewpointModel>> ViewpointModel::Build(
    const CadModel& model, const ViewpointModelOptions& options, const WorkContext& work) {
  PLB_CHECK(!model.mesh.triangles.empty()) << "model '" << model.name << "' has no triangles";
  const std::shared_ptr<ViewpointModel> result(new ViewpointModel);
  result->options_ = options;
  result->center_ = model.bounds.center();
  float radius = 0;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices)
    radius = std::max(radius, (vertex - result->center_).norm());
  result->bounding_radius_ = radius;
  // A body of revolution looks the same from every azimuth: its first view is turned. Finite
  // symmetries of scanned models hold only nearly, so all their views are made.
  const bool revolved = model.symmetry.order == 0 &&
                        model.symmetry.axis.cross(Eigen::Vector3d::UnitZ()).norm() < 1e-6;
  const float step = static_cast<float>(std::min(options.contour_step_m, 0.3 * radius));
  const RayScene scene(model.mesh);
  const int views = result->NumViews();
  std::vector<std::vector<ContourPoint>> found(static_cast<std::size_t>(views));
  result->length_per_point_m_.resize(static_cast<std::size_t>(views));
  result->outline_size_.resize(static_cast<std::size_t>(views));
  std::atomic<int> done = 0;
  tbb::parallel_for(0, views, [&](int view) {
    const int azimuth_index = view % options.azimuths;
    if (work.stop.stop_requested() || (revolved && azimuth_index > 0)) return;
    const int elevation_index = view / options.azimuths % options.elevations;
    const int distance_index = view / options.azimuths / options.elevations;
    const double azimuth = 2.0 * std::numbers::pi * azimuth_index / options.azimuths;
    const double elevation =
        kRadPerDeg *
        (options.min_elevation_deg + (options.max_elevation_deg - options.min_elevation_deg) *
                                         elevation_index / std::max(1, options.elevations - 1));
    const Eigen::Vector3f from_center(static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
                                      static_cast<float>(std::cos(elevation) * std::sin(azimuth)),
                                      static_cast<float>(std::sin(elevation)));
    const float distance =
        static_cast<float>(options.distances[static_cast<std::size_t>(distance_index)]) * radius;
    const ViewCamera camera =
        CameraAt(result->center_, from_center, distance, radius, options.image_px);
    ModelLines lines = SampleLines(scene, camera, step, options);
    result->outline_size_[static_cast<std::size_t>(view)] = lines.outline_size;
    result->length_per_point_m_[static_cast<std::size_t>(view)] =
        lines.points.empty() ? 0.0f
                             : static_cast<float>(lines.length_px * camera.pixel * distance /
                                                  static_cast<double>(lines.points.size()));
    found[static_cast<std::size_t>(view)] = std::move(lines.points);
    const int now = ++done;
    if (now % 64 == 0 || now == views) work.report({"viewpoint models", now, views});
  });
  if (work.stop.stop_requested())
    return Error{ErrorCode::kCancelled, "building the viewpoint models was cancelled"};
  result->first_point_.push_back(0);
  for (int view = 0; view < views; ++view) {
    auto& points = found[static_cast<std::size_t>(view)];
    if (const int azimuth_index = view % options.azimuths; revolved && azimuth_index > 0) {
      const Eigen::Matrix3f turn =
          Eigen::AngleAxisf(2.0f * std::numbers::pi_v<float> * static_cast<float>(azimuth_index) /
                                static_cast<float>(options.azimuths),
                            Eigen::Vector3f::UnitZ())
              .toRotationMatrix();
      points = found[static_cast<std::size_t>(view - azimuth_index)];
      result->length_per_point_m_[static_cast<std::size_t>(view)] =
          result->length_per_point_m_[static_cast<std::size_t>(view - azimuth_index)];
      result->outline_size_[static_cast<std::size_t>(view)] =
          result->outline_size_[static_cast<std::size_t>(view - azimuth_index)];
      for (ContourPoint& point : points)
        point = {turn * point.position, turn * point.normal, point.rim, point.luminance};
    }
    for (int k = 0; k < 3; ++k) {
      for (const ContourPoint& point : points) result->points_.push_back(point.position[k]);
    }
    for (int k = 0; k < 3; ++k) {
      for (const ContourPoint& point : points) result->points_.push_back(point.normal[k]);
    }
    for (const ContourPoint& point : points) result->points_.push_back(point.rim);
    for (const ContourPoint& point : points) result->points_.push_back(point.luminance);
    result->first_point_.push_back(
        static_cast<std::int32_t>(result->points_.size() / kFloatsPerPoint));
  }
  return std::shared_ptr<const ViewpointModel>(result);
}

Result<std::shared_ptr<const ViewpointModel>> ViewpointModel::LoadOrBuild(
    const CadModel& model, const ViewpointModelOptions& options,
    const std::filesystem::path& cache_folder, const WorkContext& work) {
  const std::filesystem::path file =
      cache_folder / ("viewpoints-" + CacheKey(model, options) + ".bin");
  constexpr std::size_t kHashSize = 16;
  if (const Result<std::string> cached = ReadFile(file);
      cached.ok() && cached->size() > kHashSize) {
    const std::string_view body = std::string_view(*cached).substr(kHashSize);
    const bool undamaged = cached->starts_with(HashHex(body));
    if (auto found = undamaged ? Decode(body, options) : nullptr) return found;
  }
  Result<std::shared_ptr<const ViewpointModel>> built = Build(model, options, work);
  if (!built.ok()) return built;
  const std::string body = (*built)->Encode();
  // A cache that cannot be written costs only the next start.
  static_cast<void>(WriteFileAtomically(file, HashHex(body) + body).ok());
  return built;
}

std::string ViewpointModel::Encode() const {
  std::string bytes;
  PutVector(std::vector<float>{center_.x(), center_.y(), center_.z(), bounding_radius_}, bytes);
  PutVector(first_point_, bytes);
  PutVector(length_per_point_m_, bytes);
  PutVector(outline_size_, bytes);
  PutVector(points_, bytes);
  return bytes;
}

std::shared_ptr<const ViewpointModel> ViewpointModel::Decode(std::string_view bytes,
                                                             const ViewpointModelOptions& options) {
  const std::shared_ptr<ViewpointModel> model(new ViewpointModel);
  std::vector<float> head;
  if (!TakeVector(bytes, head) || head.size() != 4 || !TakeVector(bytes, model->first_point_) ||
      !TakeVector(bytes, model->length_per_point_m_) || !TakeVector(bytes, model->outline_size_) ||
      !TakeVector(bytes, model->points_)) {
    return nullptr;
  }
  model->options_ = options;
  model->center_ = {head[0], head[1], head[2]};
  model->bounding_radius_ = head[3];
  return model->IsWhole() ? model : nullptr;
}

bool ViewpointModel::IsWhole() const {
  const auto views = static_cast<std::size_t>(NumViews());
  if (!center_.allFinite() || first_point_.size() != views + 1 || outline_size_.size() != views ||
      length_per_point_m_.size() != views || first_point_.front() != 0 ||
      points_.size() != kFloatsPerPoint * static_cast<std::size_t>(first_point_.back())) {
    return false;
  }
  for (std::size_t view = 0; view < views; ++view) {
    const std::int64_t size = std::int64_t{first_point_[view + 1]} - first_point_[view];
    if (size < 0 || outline_size_[view] < 0 || outline_size_[view] > size) return false;
  }
  return true;
}

ContourView ViewpointModel::View(const Eigen::Vector3f& camera_in_object) const {
  const Eigen::Vector3f from_center = camera_in_object - center_;
  const float distance = std::max(from_center.norm(), 1e-6f);
  const float turn =
      std::atan2(from_center.y(), from_center.x()) / (2.0f * std::numbers::pi_v<float>);
  const int azimuth =
      static_cast<int>(std::lround((turn + 1.0f) * options_.azimuths)) % options_.azimuths;
  const float elevation = std::asin(std::clamp(from_center.z() / distance, -1.0f, 1.0f));
  const float step =
      static_cast<float>((options_.max_elevation_deg - options_.min_elevation_deg) * kRadPerDeg) /
      std::max(1, options_.elevations - 1);
  const int ring = std::clamp(
      static_cast<int>(std::lround(
          (elevation - static_cast<float>(options_.min_elevation_deg * kRadPerDeg)) / step)),
      0, options_.elevations - 1);
  const float ratio = distance / bounding_radius_;
  int shell = 0;
  while (shell + 1 < static_cast<int>(options_.distances.size()) &&
         ratio * ratio > options_.distances[shell] * options_.distances[shell + 1]) {
    ++shell;
  }
  const std::size_t view =
      static_cast<std::size_t>((shell * options_.elevations + ring) * options_.azimuths + azimuth);
  const std::int32_t first = first_point_[view];
  const int n = first_point_[view + 1] - first;
  const float* x = points_.data() + kFloatsPerPoint * static_cast<std::size_t>(first);
  return {n,
          outline_size_[view],
          x,
          x + n,
          x + 2 * n,
          x + 3 * n,
          x + 4 * n,
          x + 5 * n,
          x + 6 * n,
          x + 7 * n,
          length_per_point_m_[view]};
}

}  // namespace plumbline
