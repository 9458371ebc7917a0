// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/evaluate_trajectory.h"

#include <cstdio>
#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/verbs/verb.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/trajectory.h"
#include "engine/dataset/trajectory_writer.h"
#include "engine/evaluation/trajectory_error.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

Result<std::vector<TimedPose>> ReadPoses(const fs::path& file) {
  std::vector<TimedPose> poses;
  if (file.extension() == ".csv") {
    const Result<ReferenceStates> states = ReadReferenceStates(file);
    if (!states.ok()) return states.error();
    Warn(states->warnings);
    for (const ReferenceState& state : states->states)
      poses.push_back({state.stamp_ns, state.world_from_body, std::nullopt});
    return poses;
  }
  // Both files are to be of the same sensor: whichever it is, its poses are compared as they are.
  const Result<Trajectory> trajectory = ReadTrajectory(file, Eigen::Isometry3d::Identity());
  if (!trajectory.ok()) return trajectory.error();
  Warn(trajectory->warnings);
  for (const StampedPose& pose : trajectory->poses)
    poses.push_back({pose.stamp_ns, pose.world_from_cam, std::nullopt});
  return poses;
}

Status AddCovariances(const fs::path& file, std::vector<TimedPose>& poses) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  const Result<Covariances> covariances = ReadCovariances(file);
  if (!covariances.ok()) return covariances.error();
  Warn(covariances->warnings);
  auto next = covariances->rows.begin();
  bool any = false;
  for (TimedPose& pose : poses) {
    while (next != covariances->rows.end() && next->stamp_ns < pose.stamp_ns) ++next;
    if (next == covariances->rows.end() || next->stamp_ns != pose.stamp_ns) continue;
    pose.covariance = next->covariance;
    any = true;
  }
  if (!any) {
    Warn({"'" + file.string() +
          "' has no covariance at the time of any pose: it is of another trajectory; going "
          "without"});
  }
  return {};
}

TrajectoryAlignment AlignmentNamed(const std::string& name) {
  std::size_t i = 0;
  while (EnumNames<TrajectoryAlignment>::names[i] != name) ++i;
  return static_cast<TrajectoryAlignment>(i);
}

nlohmann::json RelativeToJson(const std::vector<RelativeError>& errors, const char* span) {
  nlohmann::json list = nlohmann::json::array();
  for (const RelativeError& error : errors) {
    if (error.pairs == 0) continue;
    list.push_back({{span, error.span},
                    {"pairs", error.pairs},
                    {"translation_m", error.translation_m},
                    {"translation_median_m", error.translation_median_m},
                    {"rotation_deg", error.rotation_rad * kDegPerRad}});
  }
  return list;
}

nlohmann::json ErrorsToJson(const TrajectoryErrors& errors, const std::string& align) {
  nlohmann::json matrix = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      matrix[row][column] = errors.reference_from_estimate(row, column);
  }
  nlohmann::json json = {{"align", align},
                         {"alignment", matrix},
                         {"matched", errors.matched},
                         {"path_m", errors.path_m},
                         {"ate_m", errors.ate_m},
                         {"ate_max_m", errors.ate_max_m},
                         {"ate_deg", errors.ate_rad * kDegPerRad},
                         {"tilt_deg", errors.tilt_rad * kDegPerRad},
                         {"scale", errors.scale},
                         {"rpe", RelativeToJson(errors.by_time, "seconds")},
                         {"rpe_lengths", RelativeToJson(errors.by_length, "metres")},
                         {"nees", nullptr}};
  if (errors.nees) json["nees"] = *errors.nees;
  return json;
}

void PrintRelative(const std::vector<RelativeError>& errors, const char* unit) {
  for (const RelativeError& error : errors) {
    if (error.pairs == 0) continue;
    std::printf("over %4g %-3s %10.4f m rms %10.4f m median %9.3f deg rms   %d pairs\n", error.span,
                unit, error.translation_m, error.translation_median_m,
                error.rotation_rad * kDegPerRad, error.pairs);
  }
}

void PrintErrors(const TrajectoryErrors& errors, const std::string& align) {
  std::printf("%d poses matched, %.2f m of the reference; alignment %s\n", errors.matched,
              errors.path_m, align.c_str());
  std::printf("absolute      %10.4f m rms %10.4f m largest %8.3f deg rms\n", errors.ate_m,
              errors.ate_max_m, errors.ate_rad * kDegPerRad);
  PrintRelative(errors.by_time, "s");
  PrintRelative(errors.by_length, "m");
  std::printf("tilt          %10.3f deg rms\n", errors.tilt_rad * kDegPerRad);
  std::printf("scale         %10.4f (by which the estimate has to grow)\n", errors.scale);
  if (errors.nees)
    std::printf("NEES          %10.2f of 6, %d poses\n", *errors.nees, errors.nees_poses);
}

}  // namespace

Status EvaluateTrajectory(const TrajectoryArguments& arguments) {
  Result<std::vector<TimedPose>> estimate = ReadPoses(arguments.estimate);
  if (!estimate.ok()) return estimate.error();
  if (Status status = AddCovariances(CovarianceFileOf(arguments.estimate), *estimate); !status.ok())
    return status;
  const Result<std::vector<TimedPose>> reference = ReadPoses(arguments.reference);
  if (!reference.ok()) return reference.error();
  TrajectoryErrorOptions options;
  options.align = AlignmentNamed(arguments.align);
  const Result<TrajectoryErrors> errors = CompareTrajectories(*estimate, *reference, options);
  if (!errors.ok()) {
    return Error{errors.error().code, "cannot compare '" + arguments.estimate + "' with '" +
                                          arguments.reference + "': " + errors.error().message};
  }
  if (arguments.json != "-") PrintErrors(*errors, arguments.align);
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, ErrorsToJson(*errors, arguments.align));
}

}  // namespace plumbline
