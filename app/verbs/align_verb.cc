// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/vector_argument.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/trajectory.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "engine/registration/floor.h"
#include "engine/registration/model_alignment.h"

namespace plumbline {
namespace {

constexpr double kLeastLevel = 0.985;  ///< Cosine of 10 degrees.

struct AlignArguments {
  std::string scan, model, init, gravity, floor, trajectory, json;
  int dof = 4;
  bool on_support = false, anywhere = false;
  double min_fitness = 0.05;
  AlignOptions options;
};

/// Rows and columns: x, y, z [m], azimuth [rad]; with 6 degrees of freedom the rotation vector.
nlohmann::json CovarianceToJson(const AlignCandidate& candidate, const Eigen::Vector3d& up,
                                FreeMotion motion) {
  Eigen::MatrixXd select = Eigen::MatrixXd::Identity(6, 6);
  if (motion != FreeMotion::kRigid) {
    select = Eigen::MatrixXd::Zero(4, 6);
    select.topLeftCorner<3, 3>().setIdentity();
    select.bottomRightCorner<1, 3>() = up.transpose();
  }
  const Eigen::MatrixXd covariance = select * candidate.covariance * select.transpose();
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : covariance.rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

/// Whether the list of models beside a model says that it stands on the floor; a file that lies
/// beside no list, or is not in it, may be anywhere.
Result<bool> StandsOnFloor(const std::filesystem::path& model) {
  const std::filesystem::path list = model.parent_path() / "models.json";
  std::error_code ignored;
  if (!std::filesystem::exists(list, ignored)) return false;
  const Result<nlohmann::json> json = ReadJson(list);
  if (!json) return Error{json.error().code, json.error().message + "; --anywhere ignores it"};
  const nlohmann::json models = json->is_object() ? json->value("models", nlohmann::json()) : *json;
  for (const nlohmann::json& entry : models) {
    if (entry.is_object() && entry.value("file", nlohmann::json()) == model.filename().string())
      return entry.value("support", nlohmann::json()) == "floor";
  }
  return false;
}

/// The floor of the scan at the start, level; nothing where none can be told.
std::optional<Eigen::Vector4d> LevelFloor(const ScanTarget& scan, const Eigen::Vector3d& up,
                                          const Eigen::Vector3d& start,
                                          const std::vector<Eigen::Vector3d>& camera_centers) {
  const Result<FloorPlane> floor = FindFloor(scan, {camera_centers, up});
  if (!floor || floor->up_in_scan.dot(up) < kLeastLevel) return std::nullopt;
  const double above_m =
      (floor->up_in_scan.dot(start) + floor->offset_m) / floor->up_in_scan.dot(up);
  Eigen::Vector4d level;
  level << up, above_m - start.dot(up);
  return level;
}

/// What fell out, besides the time that it took.
struct AlignResult {
  ModelAlignment alignment;
  std::optional<Eigen::Vector4d> floor;  ///< That was given, or found because none was.
  double prepare_ms = 0, align_ms = 0;
};

nlohmann::json ToJson(const AlignResult& result, const UprightFrame& upright,
                      const AlignArguments& arguments) {
  nlohmann::json candidates = nlohmann::json::array();
  for (const AlignCandidate& candidate : result.alignment.candidates) {
    candidates.push_back(
        {{"scan_from_model", IsometryToJson(candidate.scan_from_model)},
         {"azimuth_deg", kDegPerRad * upright.Azimuth(candidate.scan_from_model.linear())},
         {"tilt_deg", kDegPerRad * upright.Tilt(candidate.scan_from_model.linear())},
         {"fitness", candidate.fitness},
         {"rmse_m", candidate.rmse_m},
         {"score", candidate.score},
         {"converged", candidate.converged},
         {"iterations", candidate.iterations},
         {"stands", candidate.stands},
         {"same_by_symmetry", candidate.same_by_symmetry},
         {"covariance",
          CovarianceToJson(candidate, upright.up_in_world(), arguments.options.motion)}});
  }
  nlohmann::json json = candidates.front();
  json["iterations"] = result.alignment.iterations;
  json["starts"] = arguments.options.starts;
  json["dof"] = arguments.dof;
  json["standing"] = arguments.options.standing == Standing::kOnSupport ? "on_support" : "anywhere";
  json["floor"] = nullptr;
  if (result.floor) {
    const Eigen::Vector4d& plane = *result.floor;
    json["floor"] = {plane[0], plane[1], plane[2], plane[3]};
  }
  json["symmetry_order"] = result.alignment.symmetry_order;
  json["seconds"] = result.align_ms / 1e3;
  json["prepare_seconds"] = result.prepare_ms / 1e3;
  json["candidates"] = std::move(candidates);
  return json;
}

void PrintTable(const AlignResult& result, const UprightFrame& upright) {
  std::printf("%4s  %9s  %24s  %8s  %7s  %18s\n", "rank", "azimuth", "position [m]", "fitness",
              "rmse", "std");
  int rank = 1;
  for (const AlignCandidate& candidate : result.alignment.candidates) {
    const Eigen::Vector3d at = candidate.scan_from_model.translation();
    const Eigen::Vector3d& up = upright.up_in_world();
    const PoseDeviations deviations = DeviationsOf(candidate.covariance, up);
    std::printf("%4d  %5.1f deg  %7.3f %7.3f %7.3f  %6.1f %%  %4.1f mm  %5.2f mm %5.3f deg%s\n",
                rank++, kDegPerRad * upright.Azimuth(candidate.scan_from_model.linear()), at.x(),
                at.y(), at.z(), 100 * candidate.fitness, 1e3 * candidate.rmse_m,
                1e3 * deviations.position_m, kDegPerRad * deviations.azimuth_rad,
                candidate.same_by_symmetry ? "  (the first, turned by its symmetry)" : "");
  }
  if (result.floor) std::printf("The floor is at %.3f m along up.\n", -(*result.floor)[3]);
  const int order = result.alignment.symmetry_order;
  if (order == 0)
    std::printf("The model looks the same at any azimuth: its azimuth means nothing.\n");
  if (order > 1) {
    std::printf("The model looks the same turned by %d degrees: the scan cannot tell which.\n",
                360 / order);
  }
  std::printf("%.2f s (scan and model prepared in %.2f s)\n", result.align_ms / 1e3,
              result.prepare_ms / 1e3);
}

Result<AlignResult> Run(const AlignArguments& arguments, const Eigen::VectorXd& init,
                        const UprightFrame& upright) {
  const Result<TriangleMesh> scan = ReadMesh(arguments.scan);
  if (!scan) return scan.error();
  const Result<TriangleMesh> model = ReadMesh(arguments.model);
  if (!model) return model.error();
  std::vector<Eigen::Vector3d> camera_centers;
  if (!arguments.trajectory.empty()) {
    const Result<Trajectory> trajectory = ReadTrajectory(arguments.trajectory, std::nullopt);
    if (!trajectory) return trajectory.error();
    for (const StampedPose& pose : trajectory->poses) {
      camera_centers.push_back(pose.world_from_cam.translation());
    }
  }
  AlignResult result;
  Stopwatch watch;
  const auto target = ScanTarget::Prepare(*scan, camera_centers);
  if (!target) return Error{target.error().code, arguments.scan + ": " + target.error().message};
  const auto surface = ModelSurface::Prepare(*model);
  if (!surface)
    return Error{surface.error().code, arguments.model + ": " + surface.error().message};
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.linear() = upright.WorldFromObjectRotation(init.size() > 3 ? init[3] / kDegPerRad : 0.0);
  start.translation() = init.head<3>();
  AlignOptions options = arguments.options;
  if (options.standing == Standing::kOnSupport && !options.floor_in_scan) {
    options.floor_in_scan =
        LevelFloor(**target, upright.up_in_world(), start.translation(), camera_centers);
  }
  result.floor = options.floor_in_scan;
  result.prepare_ms = watch.Lap();
  ConsoleWork work;
  Result<ModelAlignment> alignment =
      AlignModel(**target, **surface, start, upright.up_in_world(), options, work.context());
  if (!alignment) return alignment.error();
  result.align_ms = watch.Lap();
  result.alignment = std::move(*alignment);
  const double fitness = result.alignment.candidates.front().fitness;
  if (fitness < arguments.min_fitness) {
    char text[200];
    std::snprintf(text, sizeof(text),
                  "only %.1f %% of the model's surface meets the scan, which says nothing of where "
                  "it is; start nearer, search further, or ask for less with --min-fitness",
                  100 * fitness);
    return Error{ErrorCode::kDegenerate, text};
  }
  return result;
}

Status Align(AlignArguments arguments) {
  const Result<Eigen::VectorXd> init = ParseNumbers(arguments.init, "--init", 3, 4);
  if (!init) return init.error();
  const Result<Eigen::Vector3d> gravity = ParseDirection(arguments.gravity, "--gravity");
  if (!gravity) return gravity.error();
  arguments.options.motion = MotionWith(arguments.dof);
  bool on_support = arguments.on_support;
  if (!on_support && !arguments.anywhere) {
    const Result<bool> stands = StandsOnFloor(arguments.model);
    if (!stands) return stands.error();
    on_support = *stands;
    if (on_support && arguments.json != "-") {
      std::printf("It stands on what is below it, as models.json says; --anywhere does not ask.\n");
    }
  }
  if (on_support) arguments.options.standing = Standing::kOnSupport;
  if (!arguments.floor.empty()) {
    const Result<Eigen::VectorXd> floor = ParseNumbers(arguments.floor, "--floor", 4, 4);
    if (!floor) return floor.error();
    // Scaled so that (a, b, c) is a unit vector; one that is stays as it is, bit for bit. A wall,
    // or a floor upside down, is a mistake.
    const double norm = floor->head(3).norm();
    const Eigen::Vector4d plane = std::abs(norm - 1) < 1e-12 ? *floor : *floor / norm;
    if (!plane.allFinite() || plane.head<3>().dot(-*gravity) < kLeastLevel) {
      return Error{ErrorCode::kInvalidInput, "--floor " + arguments.floor +
                                                 " is not level: (a, b, c) must point up, against "
                                                 "--gravity, within 10 degrees"};
    }
    arguments.options.floor_in_scan = plane;
  }
  const UprightFrame upright(*gravity);
  const Result<AlignResult> result = Run(arguments, *init, upright);
  if (!result) return result.error();
  if (arguments.json != "-") PrintTable(*result, upright);
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, ToJson(*result, upright, arguments));
}

}  // namespace

void AddAlignVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<AlignArguments>();
  CLI::App* verb = app.add_subcommand(
      "align",
      "Align a CAD model to a scan, upright: azimuth and translation by ICP from many "
      "azimuths");
  verb->add_option("--scan", arguments->scan, "The scan, metres: a mesh or a point cloud")
      ->required()
      ->type_name("SCAN.ply");
  verb->add_option("--model", arguments->model,
                   "The model in its canonical frame: metres, z up, as 'models build' writes it")
      ->required()
      ->type_name("MODEL.ply");
  verb->add_option("--init", arguments->init,
                   "Roughly where the model's origin (the middle of its foot) is in the scan, and "
                   "its azimuth [degrees]")
      ->required()
      ->type_name("x,y,z[,yaw_deg]");
  verb->add_option("--gravity", arguments->gravity,
                   "Direction of gravity in the scan; 'plumbline gravity' finds it")
      ->required()
      ->type_name("x,y,z");
  verb->add_option("--dof", arguments->dof,
                   "What is free: 4 azimuth and translation, 3 azimuth and the two translations "
                   "along the floor, 1 azimuth alone, 6 everything")
      ->check(CLI::IsMember({4, 3, 1, 6}))
      ->capture_default_str();
  verb->add_flag("--on-support", arguments->on_support,
                 "The model stands on the level surface below it (a chair on the floor): poses "
                 "that float must fit far better, and what stands on --floor stands on it exactly. "
                 "The default where the models.json beside the model says 'support: floor'");
  verb->add_flag("--anywhere", arguments->anywhere,
                 "The model may hang or float, whatever models.json says")
      ->excludes("--on-support");
  verb->add_option(
          "--floor", arguments->floor,
          "The floor's plane ax + by + cz + d = 0 with (a, b, c) up, as 'plumbline gravity' "
          "finds it: where the scan shows no surface below the model (default for what stands on "
          "its support: the widest level plane below the scan)")
      ->type_name("a,b,c,d");
  verb->add_option("--starts", arguments->options.starts,
                   "Azimuths to start from, evenly spread; 1: only the one given")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  verb->add_option("--search", arguments->options.search_m,
                   "How far from the start the model may be [m]; nothing further is an answer")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
  verb->add_option("--min-fitness", arguments->min_fitness,
                   "Refuse a result of which a smaller share of the model's surface meets the scan "
                   "within 2 cm; 0: none")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--trajectory", arguments->trajectory,
                   "Camera poses in the scan's frame (TUM): they tell the seen side of a point "
                   "cloud's surface")
      ->type_name("FILE");
  verb->add_option("--json", arguments->json, "Write the results as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Align(*arguments); }; });
}

}  // namespace plumbline
