// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/annotation/crop_cut.h"
#include "engine/annotation/pose_exchange.h"
#include "engine/annotation/y_up_models.h"
#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

nlohmann::json TwelveNumbers(const Eigen::Isometry3d& pose) {
  nlohmann::json numbers = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) numbers.push_back(pose.matrix()(r, c));
  }
  return numbers;
}

std::optional<Eigen::Isometry3d> FromTwelveNumbers(const nlohmann::json& json) {
  if (!VectorFromJson(json, 12)) return std::nullopt;
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({json[4 * r], json[4 * r + 1], json[4 * r + 2], json[4 * r + 3]});
  }
  rows.push_back({0, 0, 0, 1});
  return IsometryFromJson(rows);
}

/// What stands before the last underscore.
std::string ModelOf(const std::string& name) { return name.substr(0, name.rfind('_')); }

/// `<model>_<N>`: the id itself where it has that form, else a number of its own.
std::vector<std::string> VismaNames(const AnnotationDocument& document) {
  std::set<std::string> taken;
  for (const AnnotatedInstance& instance : document.instances) taken.insert(instance.id);
  std::vector<std::string> names;
  for (const AnnotatedInstance& instance : document.instances) {
    std::string name = instance.id;
    for (int number = 0; ModelOf(name) != instance.model || name == instance.model; ++number) {
      const std::string candidate = instance.model + "_" + std::to_string(number);
      if (taken.insert(candidate).second) name = candidate;
    }
    names.push_back(name);
  }
  return names;
}

constexpr const char* kReadme =
    "As VISMA's RGBD/<sequence>; metres.\n"
    "fragments/alignment.json: name -> 12 numbers, row-major 3x4, model to scan. The models are\n"
    "those of CAD/ (VISMA's CAD_database_root), +y up; Plumbline's z-up models are theirs turned "
    "by\n"
    "(x, y, z) -> (x, -z, y).\n"
    "result_alignment.json: T_ef_corvis, 12 numbers, row-major 3x4, the sequence's world to the\n"
    "scan; the identity where both share a frame.\n"
    "test.klg.ply: the scan. fragments/augmented_scene.ply: its points, and points sampled from "
    "the\n"
    "posed models.\n";

/// Of what the scan or a model has no colours for.
constexpr std::array<std::uint8_t, 3> kScanGrey = {178, 178, 178};
constexpr std::array<std::uint8_t, 3> kModelGreen = {0, 255, 0};  // VISMA's
constexpr double kFloorReach_m = 0.02;
/// Samples of a posed model: some 3 mm apart, as fine as scans are, and not more than these.
constexpr double kSamplesPerSquareMetre = 100'000;
constexpr int kFewestSamples = 1000, kMostSamples = 200'000;

/// Points on the posed model, in its colours.
Result<TriangleMesh> Sampled(const CadModel& model, const Eigen::Isometry3d& scan_from_object) {
  const double wanted = kSamplesPerSquareMetre * SurfaceArea(model.mesh);
  const int count = static_cast<int>(std::clamp(wanted, 1.0 * kFewestSamples, 1.0 * kMostSamples));
  const Result<SurfaceSamples> samples = SampleSurface(model.mesh, count, 0);
  if (!samples) return samples.error();
  TriangleMesh points;
  for (std::size_t i = 0; i < samples->points.size(); ++i) {
    const Eigen::Vector3d& point = samples->points[i];
    points.vertices.emplace_back((scan_from_object * point).cast<float>());
    if (model.mesh.colors.empty()) {
      points.colors.push_back(kModelGreen);
      continue;
    }
    const Eigen::Vector3i& triangle =
        model.mesh.triangles[static_cast<std::size_t>(samples->triangles[i])];
    const auto farther = [&](int a, int b) {
      const auto distance = [&](int k) {
        return (model.mesh.vertices[static_cast<std::size_t>(k)].cast<double>() - point).norm();
      };
      return distance(a) < distance(b);
    };
    const int* nearest = std::min_element(triangle.data(), triangle.data() + 3, farther);
    points.colors.push_back(model.mesh.colors[static_cast<std::size_t>(*nearest)]);
  }
  return points;
}

/// The points of the scan for which `wanted` holds, coloured.
template <typename Wanted>
TriangleMesh PointsWhere(const TriangleMesh& scan, const Wanted& wanted) {
  TriangleMesh points;
  for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
    if (!wanted(scan.vertices[i].cast<double>().eval())) continue;
    points.vertices.push_back(scan.vertices[i]);
    points.colors.push_back(scan.colors.empty() ? kScanGrey : scan.colors[i]);
  }
  return points;
}

/// What of the scan is within `reach_m` of the posed model.
Result<TriangleMesh> FragmentOf(const TriangleMesh& scan, const CadModel& model,
                                const Eigen::Isometry3d& scan_from_object, double reach_m) {
  const auto surface = ClosestTriangleSearch::Build(model.mesh);
  if (!surface) return surface.error();
  const Eigen::Isometry3d object_from_scan = scan_from_object.inverse();
  const auto reach = static_cast<float>(reach_m);
  const Eigen::AlignedBox3f near(model.bounds.min().array() - reach,
                                 model.bounds.max().array() + reach);
  return PointsWhere(scan, [&](const Eigen::Vector3d& point_in_scan) {
    const Eigen::Vector3d point = object_from_scan * point_in_scan;
    return near.contains(Eigen::Vector3f(point.cast<float>())) &&
           (*surface)->FindWithin(point, reach_m).has_value();
  });
}

/// Where VISMA has it, beside the folder of fragments, or in it, as we wrote it once.
std::filesystem::path ResultAlignmentOf(const std::filesystem::path& fragments) {
  std::error_code ignored;
  for (const std::filesystem::path& folder : {fragments.parent_path(), fragments}) {
    if (std::filesystem::exists(folder / "result_alignment.json", ignored))
      return folder / "result_alignment.json";
  }
  return {};
}

}  // namespace

Status WriteVisma(const AnnotationDocument& document, const ModelDatabase* models,
                  const std::filesystem::path& folder) {
  std::vector<std::string> file_names;
  for (const AnnotatedInstance& instance : document.instances)
    file_names.insert(file_names.end(), {instance.id, instance.model});
  for (const Crop& crop : document.crops) file_names.push_back(crop.id);
  for (const std::string& name : file_names) {
    if (!IsFileName(name))
      return InvalidInput("VISMA's files have the names of what is in them, and '" + name +
                          "' cannot be the name of a file; rename it");
  }
  for (const std::filesystem::path& part : {folder / "fragments", folder / "CAD"}) {
    std::error_code error;
    std::filesystem::create_directories(part, error);
    if (error)
      return Error{ErrorCode::kIo, "cannot make '" + part.string() + "': " + error.message()};
  }
  nlohmann::json names = VismaNames(document), alignment = nlohmann::json::object();
  std::set<std::string> used;
  for (std::size_t i = 0; i < document.instances.size(); ++i) {
    const AnnotatedInstance& instance = document.instances[i];
    alignment[names[i].get<std::string>()] =
        TwelveNumbers(instance.scan_from_object * ObjectFromYUp());
    used.insert(instance.model);
  }
  for (const Crop& crop : document.crops) {
    if (crop.into == Crop::Into::kFragment && !alignment.contains(crop.id)) {
      names.push_back(crop.id);  // Still to be aligned.
    }
  }
  const Eigen::Isometry3d scan_from_world =
      document.scan_from_world.value_or(Eigen::Isometry3d::Identity());
  Status status = WriteJson(folder / "fragments" / "objects.json", {{"entries", names}});
  if (status.ok()) status = WriteJson(folder / "fragments" / "alignment.json", alignment);
  if (status.ok()) status = WriteFileAtomically(folder / "README.txt", kReadme);
  if (status.ok()) {
    status = WriteJson(folder / "result_alignment.json",
                       {{"T_ef_corvis", TwelveNumbers(scan_from_world)}});
  }
  for (const std::string& name : used) {
    const auto id = models ? models->Find(name) : std::nullopt;
    if (!status.ok() || !id) continue;
    status = WriteFileAtomically(folder / "CAD" / (name + ".obj"), YUpObj(models->model(*id).mesh));
  }
  return status;
}

Status WriteVismaScene(const AnnotationDocument& document, const ModelDatabase& models,
                       const TriangleMesh& scan, double reach_m,
                       const std::filesystem::path& folder) {
  const std::filesystem::path fragments = folder / "fragments";
  std::error_code ignored;  // a folder that cannot be made is found out when a file is written
  std::filesystem::create_directories(fragments, ignored);
  const std::vector<std::string> names = VismaNames(document);
  TriangleMesh augmented = PointsWhere(scan, [](const Eigen::Vector3d&) { return true; });
  for (std::size_t i = 0; i < document.instances.size(); ++i) {
    const AnnotatedInstance& instance = document.instances[i];
    const auto id = models.Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    const CadModel& model = models.model(*id);
    const auto fragment = FragmentOf(scan, model, instance.scan_from_object, reach_m);
    if (!fragment) return fragment.error();
    const Status written = WritePly(fragments / (names[i] + ".ply"), *fragment);
    if (!written.ok()) return written;
    const auto samples = Sampled(model, instance.scan_from_object);
    if (!samples) return samples.error();
    Append(*samples, augmented);
  }
  for (const Crop& crop : document.crops) {
    if (crop.into != Crop::Into::kFragment) continue;
    const Result<TriangleMesh> cut = CutOut(scan, crop);
    if (!cut) return cut.error();
    if (const Status written = WritePly(fragments / (crop.id + ".ply"), *cut); !written.ok()) {
      return written;
    }
  }
  Status status = WritePly(folder / "test.klg.ply", scan);
  if (status.ok() && document.floor_in_scan) {
    const Eigen::Vector4d& floor = *document.floor_in_scan;
    status = WritePly(fragments / "floor.ply", PointsWhere(scan, [&](const Eigen::Vector3d& p) {
                        return std::abs(floor.dot(p.homogeneous())) <= kFloorReach_m;
                      }));
  }
  return status.ok() ? WritePly(fragments / "augmented_scene.ply", augmented) : status;
}

Result<ImportedPoses> ReadVisma(const std::filesystem::path& given) {
  std::error_code ignored;
  const std::filesystem::path inner = given / "fragments";
  const std::filesystem::path folder =
      std::filesystem::exists(inner / "alignment.json", ignored) ? inner : given;
  const std::filesystem::path file = folder / "alignment.json";
  const Result<nlohmann::json> alignment = ReadJson(file);
  if (!alignment) return alignment.error();
  if (!alignment->is_object()) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' must map names to 12 numbers"};
  }
  ImportedPoses imported;
  std::vector<Eigen::Vector3d> translations;
  for (const auto& [name, numbers] : alignment->items()) {
    const auto pose = FromTwelveNumbers(numbers);
    if (!pose) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + file.string() + "': '" + name +
                       "' has no rigid pose of 12 numbers, row by row, within 1000 km"};
    }
    AnnotatedInstance instance;
    instance.id = name;
    instance.model = ModelOf(name);
    instance.scan_from_object = *pose * ObjectFromYUp().inverse();
    translations.push_back(pose->translation());
    imported.instances.push_back(std::move(instance));
  }
  if (auto warning = MetreWarning(translations, file.string())) {
    imported.warnings.push_back(std::move(*warning));
  }
  if (std::filesystem::exists(folder / "objects.json", ignored)) {
    const Result<nlohmann::json> objects = ReadJson(folder / "objects.json");
    if (!objects) return objects.error();
    if (!objects->is_object()) {
      return Error{ErrorCode::kInvalidInput, "'" + (folder / "objects.json").string() +
                                                 "' must hold a list 'entries' of names"};
    }
    for (const nlohmann::json& name : objects->value("entries", nlohmann::json::array())) {
      if (!name.is_string() || alignment->contains(name.get<std::string>())) continue;
      imported.warnings.push_back("'" + file.string() + "' has no pose of '" +
                                  name.get<std::string>() + "', which objects.json lists");
    }
  }
  if (const auto result_file = ResultAlignmentOf(folder); !result_file.empty()) {
    const Result<nlohmann::json> result = ReadJson(result_file);
    if (!result) return result.error();
    const auto pose = result->contains("T_ef_corvis") ? FromTwelveNumbers((*result)["T_ef_corvis"])
                                                      : std::nullopt;
    if (!pose) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + result_file.string() +
                       "' needs 'T_ef_corvis', a rigid pose of 12 numbers within 1000 km"};
    }
    // The identity says that both share a frame, as a project without an alignment does.
    if (!pose->isApprox(Eigen::Isometry3d::Identity(), 0)) imported.scan_from_world = *pose;
  }
  return imported;
}

}  // namespace plumbline
