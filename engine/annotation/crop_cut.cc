// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/crop_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr std::size_t kFewestPoints = 30;
constexpr double kSupportThickness_m = 0.015;  // As in registration: what it is scanned thick.

UprightFrame FrameOf(const Crop& crop) { return UprightFrame(-*crop.up_in_scan); }

bool InPolygon(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, k = polygon.size() - 1; i < polygon.size(); k = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[k];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      inside = !inside;
    }
  }
  return inside;
}

template <typename Inside>
std::vector<int> PointsWhere(const TriangleMesh& scan, const Inside& inside) {
  std::vector<int> points;
  for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
    if (inside(scan.vertices[i].cast<double>())) points.push_back(static_cast<int>(i));
  }
  return points;
}

std::vector<int> PointsIn(const TriangleMesh& scan, const Crop& crop, const CropBox& box) {
  PLB_CHECK(crop.up_in_scan) << "a box has no direction without up";
  const Eigen::Matrix3d box_from_scan =
      FrameOf(crop).WorldFromObjectRotation(box.azimuth_rad).transpose();
  return PointsWhere(scan, [&](const Eigen::Vector3d& point) {
    const Eigen::Array3d at = (box_from_scan * (point - box.center_in_scan)).array().abs();
    return (at <= 0.5 * box.size_m.array()).all();
  });
}

std::vector<int> PointsIn(const TriangleMesh& scan, const Crop&, const CropLasso& lasso) {
  const Eigen::Isometry3d cam_from_scan = lasso.scan_from_cam.inverse();
  return PointsWhere(scan, [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d in_cam = cam_from_scan * point;
    return in_cam.z() > 1e-6 && in_cam.z() >= lasso.near_m && in_cam.z() <= lasso.far_m &&
           InPolygon(lasso.polygon_px, lasso.camera.Project(in_cam));
  });
}

/// These points with their attributes, and the triangles between them.
TriangleMesh Part(const TriangleMesh& scan, const std::vector<int>& points) {
  TriangleMesh part;
  std::vector<int> place(scan.vertices.size(), -1);
  for (const int i : points) {
    const auto k = static_cast<std::size_t>(i);
    place[k] = static_cast<int>(part.vertices.size());
    part.vertices.push_back(scan.vertices[k]);
    if (!scan.normals.empty()) part.normals.push_back(scan.normals[k]);
    if (!scan.colors.empty()) part.colors.push_back(scan.colors[k]);
    if (!scan.texture_coordinates.empty()) {
      part.texture_coordinates.push_back(scan.texture_coordinates[k]);
    }
  }
  if (!scan.texture_coordinates.empty()) part.texture_file = scan.texture_file;
  for (const Eigen::Vector3i& t : scan.triangles) {
    const Eigen::Vector3i moved(place[static_cast<std::size_t>(t[0])],
                                place[static_cast<std::size_t>(t[1])],
                                place[static_cast<std::size_t>(t[2])]);
    if (moved.minCoeff() >= 0) part.triangles.push_back(moved);
  }
  return part;
}

/// The widest level surface in the lower third of a part of the scan; nothing where none covers a
/// third of its ground plan.
std::optional<Eigen::Vector4d> FindSupport(TriangleMesh part, const Eigen::Vector3d& up) {
  constexpr double kBin_m = 0.01, kCell_m = 0.03, kLowerPart = 1.0 / 3, kLeastShare = 1.0 / 3;
  constexpr float kLevel = 0.9f;
  if (part.vertices.empty()) return std::nullopt;
  if (part.normals.empty() && !part.triangles.empty()) ComputeNormals(part);
  const Eigen::Matrix3d level = UprightFrame(-up).upright_rotation().transpose();
  std::vector<Eigen::Vector3d> points;
  double lowest_m = 1e30, highest_m = -1e30;
  for (const Eigen::Vector3f& vertex : part.vertices) {
    points.push_back(level * vertex.cast<double>());
    lowest_m = std::min(lowest_m, points.back().z());
    highest_m = std::max(highest_m, points.back().z());
  }
  using Cell = std::pair<int, int>;
  std::set<Cell> ground_plan;
  std::map<int, std::set<Cell>> bins;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& p = points[i];
    const Cell cell(static_cast<int>(std::floor(p.x() / kCell_m)),
                    static_cast<int>(std::floor(p.y() / kCell_m)));
    ground_plan.insert(cell);
    const bool is_level =
        part.normals.empty() || std::abs(part.normals[i].dot(up.cast<float>())) > kLevel;
    if (!is_level || p.z() > lowest_m + kLowerPart * (highest_m - lowest_m)) continue;
    const int bin = static_cast<int>((p.z() - lowest_m) / kBin_m);
    for (int near = bin - 1; near <= bin + 1; ++near) bins[near].insert(cell);
  }
  const auto widest = std::max_element(bins.begin(), bins.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  if (widest == bins.end() || static_cast<double>(widest->second.size()) <
                                  kLeastShare * static_cast<double>(ground_plan.size())) {
    return std::nullopt;
  }
  const double middle_m = lowest_m + (widest->first + 0.5) * kBin_m;
  std::vector<double> heights;
  for (const Eigen::Vector3d& p : points) {
    if (std::abs(p.z() - middle_m) < 1.5 * kBin_m) heights.push_back(p.z());
  }
  const auto median = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), median, heights.end());
  return (Eigen::Vector4d() << up, -*median).finished();
}

/// Without its loose small pieces.
TriangleMesh WithoutCrumbs(const TriangleMesh& mesh, int& dropped) {
  constexpr std::size_t kShareOfLargest = 50;
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int corner = 1; corner < 3; ++corner) {
      parent[static_cast<std::size_t>(root(t[corner]))] = root(t[0]);
    }
  }
  std::map<int, std::size_t> sizes;
  std::size_t largest = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    largest = std::max(largest, ++sizes[root(t[0])]);
  }
  std::vector<int> kept;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto piece = sizes.find(root(static_cast<int>(i)));
    if (piece != sizes.end() && kShareOfLargest * piece->second >= largest) {
      kept.push_back(static_cast<int>(i));
    }
  }
  dropped = static_cast<int>(std::count_if(sizes.begin(), sizes.end(), [&](const auto& piece) {
    return kShareOfLargest * piece.second < largest;
  }));
  return Part(mesh, kept);
}

/// The front of what a lasso holds: along the smallest rectangle around the ground plan, towards
/// the viewer.
double FrontOfGroundPlan(const TriangleMesh& mesh, const UprightFrame& upright,
                         const CropLasso& lasso) {
  constexpr int kSteps = 180;
  std::vector<Eigen::Vector2d> plan;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    plan.emplace_back((upright.upright_rotation().transpose() * vertex.cast<double>()).head<2>());
  }
  double best = 0, least = 1e30;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / kSteps;
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-angle).toRotationMatrix();
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& point : plan) box.extend(Eigen::Vector2d(turn * point));
    if (box.volume() < least) {
      least = box.volume();
      best = angle;
    }
  }
  const Eigen::Vector3d viewer =
      upright.upright_rotation().transpose() *
      (lasso.scan_from_cam.translation() - BoundingBox(mesh).center().cast<double>());
  const double towards = std::atan2(viewer.y(), viewer.x());
  const double quarter = 0.5 * std::numbers::pi;
  return best + quarter * std::round((towards - best) / quarter);
}

double FrontOf(const Crop& crop, const TriangleMesh& mesh) {
  if (const auto* box = std::get_if<CropBox>(&crop.region)) return box->azimuth_rad;
  const auto& lasso = std::get<CropLasso>(crop.region);
  return lasso.azimuth_rad ? *lasso.azimuth_rad : FrontOfGroundPlan(mesh, FrameOf(crop), lasso);
}

/// The origin goes down onto the support: what was left out with it belongs to the feet.
void StandOnSupport(const Crop& crop, CroppedModel& cropped) {
  constexpr double kFarthest_m = 0.05;
  if (!crop.support_in_scan) return;
  const Eigen::Vector3d& origin = cropped.scan_from_model.translation();
  const double gap_m = crop.support_in_scan->head<3>().dot(origin) + (*crop.support_in_scan)[3];
  if (gap_m < 0 || gap_m > kFarthest_m) return;
  const Eigen::Isometry3d lift(Eigen::Translation3d(0, 0, gap_m));
  CadModel& model = cropped.built.model;
  model.mesh = Transformed(std::move(model.mesh), lift);
  model.bounds = BoundingBox(model.mesh);
  cropped.scan_from_model = cropped.scan_from_model * lift.inverse();
}

Status CheckNameIsFree(const std::string& name, const std::filesystem::path& models_folder) {
  const std::filesystem::path list = models_folder / "models.json";
  std::error_code ignored;
  if (!std::filesystem::exists(list, ignored)) return {};
  const Result<nlohmann::json> content = ReadJson(list);
  if (!content) return content.error();
  if (!content->is_object())
    return Error{ErrorCode::kCorrupt, "'" + list.string() + "' is no list of models"};
  for (const nlohmann::json& entry : content->value("models", nlohmann::json::array())) {
    if (entry.is_object() && entry.value("name", nlohmann::json()) == name) {
      return Error{ErrorCode::kInvalidInput, "'" + models_folder.string() + "' has a model '" +
                                                 name + "' already; give the crop another name"};
    }
  }
  return {};
}

}  // namespace

std::vector<int> PointsInRegion(const TriangleMesh& scan, const Crop& crop) {
  return std::visit([&](const auto& region) { return PointsIn(scan, crop, region); }, crop.region);
}

Result<Crop> CompletedCrop(Crop crop, const TriangleMesh& scan,
                           const AnnotationDocument& document) {
  if (!crop.up_in_scan) crop.up_in_scan = -document.gravity_in_scan;
  if (const Status good = CheckCrop(crop); !good.ok()) return good.error();
  if (crop.without_support && !crop.support_in_scan) {
    crop.support_in_scan = FindSupport(Part(scan, PointsInRegion(scan, crop)), *crop.up_in_scan);
  }
  return CompletedCrop(std::move(crop), document);
}

Result<TriangleMesh> CutOut(const TriangleMesh& scan, const Crop& crop) {
  if (const Status good = CheckCrop(crop); !good.ok()) return good.error();
  std::vector<int> points = PointsInRegion(scan, crop);
  if (crop.without_support && crop.support_in_scan) {
    const Eigen::Vector4d& plane = *crop.support_in_scan;
    std::erase_if(points, [&](int i) {
      return plane.head<3>().dot(scan.vertices[static_cast<std::size_t>(i)].cast<double>()) +
                 plane[3] <
             kSupportThickness_m;
    });
  }
  if (points.size() < kFewestPoints) {
    return Error{ErrorCode::kDegenerate, "the crop '" + crop.id + "' holds only " +
                                             std::to_string(points.size()) +
                                             " points of the scan; draw it around an object"};
  }
  return Part(scan, points);
}

Result<CroppedModel> ModelOfCrop(const TriangleMesh& scan, const std::filesystem::path& scan_file,
                                 const Crop& crop, int faces) {
  Result<TriangleMesh> cut = CutOut(scan, crop);
  if (!cut) return cut.error();
  if (cut->triangles.empty()) {
    return Error{ErrorCode::kDegenerate,
                 "the scan has no triangles where '" + crop.id +
                     "' is; a model needs a surface, points alone can become a fragment"};
  }
  CroppedModel cropped;
  const TriangleMesh mesh = WithoutCrumbs(*cut, cropped.pieces_dropped);
  Eigen::Isometry3d scan_from_upright = Eigen::Isometry3d::Identity();
  scan_from_upright.linear() = FrameOf(crop).WorldFromObjectRotation(FrontOf(crop, mesh));
  // Far from the scan's origin single precision would be coarse.
  scan_from_upright.translation() = BoundingBox(mesh).center().cast<double>();
  ModelBuildOptions options;
  options.faces = faces;
  options.unit = LengthUnit::kMetre;
  options.up = SignedAxis{2, 1};
  options.front = SignedAxis{0, 1};
  options.category = crop.category;
  Result<BuiltModel> built = BuildModelFrom(
      {Transformed(mesh, scan_from_upright.inverse()), {}, {}, {}}, crop.id, scan_file, options);
  if (!built) return built.error();
  cropped.built = std::move(*built);
  cropped.scan_from_model = scan_from_upright * cropped.built.report.object_from_file.inverse();
  StandOnSupport(crop, cropped);
  return cropped;
}

Result<PreparedCrop> PrepareCrop(const TriangleMesh& scan, const std::filesystem::path& scan_file,
                                 Crop crop, const AnnotationDocument& document,
                                 const std::filesystem::path& models_folder) {
  Result<Crop> complete = CompletedCrop(std::move(crop), scan, document);
  if (!complete) return complete.error();
  PreparedCrop prepared;
  prepared.edit = {"Cut out " + complete->id, {AddCrop{*complete, std::nullopt}}};
  AnnotationDocument trial = document;
  if (const auto tried = ApplyEdit(prepared.edit, trial); !tried) return tried.error();
  if (complete->into == Crop::Into::kFragment) {
    if (const auto cut = CutOut(scan, *complete); !cut) return cut.error();
    return prepared;
  }
  if (models_folder.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "the project names no models to enter '" + complete->id + "' in"};
  }
  if (const Status free = CheckNameIsFree(complete->id, models_folder); !free.ok()) {
    return free.error();
  }
  Result<CroppedModel> cropped = ModelOfCrop(scan, scan_file, *complete);
  if (!cropped) return cropped.error();
  AnnotatedInstance instance;
  for (int number = 0; instance.id.empty() || document.Find(instance.id); ++number) {
    instance.id = complete->id + "_" + std::to_string(number);
  }
  instance.model = complete->id;
  instance.category = cropped->built.model.category;
  instance.scan_from_object = cropped->scan_from_model;
  instance.annotator = complete->annotator;
  prepared.edit.edits.push_back(AddInstance{std::move(instance), std::nullopt});
  prepared.model = std::move(*cropped);
  return prepared;
}

}  // namespace plumbline
