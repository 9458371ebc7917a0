// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_agree.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/geometry/angles.h"
#include "engine/session/annotation_opening.h"

namespace plumbline {
namespace {

/// One file under two names is one scan, too.
bool IsSameScan(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  if (std::filesystem::file_size(a, error) != std::filesystem::file_size(b, error) || error)
    return false;
  const auto left = ReadFile(a), right = ReadFile(b);
  return left.ok() && right.ok() && *left == *right;
}

/// Poses in the scan's frame.
Result<GroundTruth> ReadSecond(const AnnotationProject& project, const SecondArguments& arguments) {
  const AnnotationDocument& document = project.document();
  if (!IsForAnnotation(arguments.file)) {
    Result<GroundTruth> truth = ReadGroundTruth(arguments.file);
    if (!truth) return truth;
    const Eigen::Isometry3d scan_from_truth =
        TargetFromScan(document, FrameOf(arguments.frame)).inverse();
    truth->gravity_in_world = scan_from_truth.linear() * truth->gravity_in_world;
    for (GroundTruthInstance& instance : truth->instances)
      instance.world_from_object = scan_from_truth * instance.world_from_object;
    return truth;
  }
  const auto second = OpenProject(arguments.file, AnnotationProject::Access::kRead);
  if (!second) return second.error();
  const AnnotationDocument& other = (*second)->document();
  if (!document.scan.empty() && !other.scan.empty() &&
      !IsSameScan(project.Resolve(document.scan), (*second)->Resolve(other.scan))) {
    log::warn(
        "'{}' is over '{}', and '{}' over '{}', which is another file: are their poses in one "
        "frame?",
        project.file().string(), document.scan, arguments.file, other.scan);
  }
  return GroundTruthOf(other, PoseFrame::kScan);
}

nlohmann::json Degrees(const std::optional<double>& rad) {
  return rad ? nlohmann::json(*rad * kDegPerRad) : nullptr;
}

nlohmann::json ToJson(const PooledDeviation& pooled) {
  return {{"objects", pooled.objects},
          {"azimuths", pooled.azimuths},
          {"horizontal_std_m", pooled.horizontal_m},
          {"height_std_m", pooled.height_m},
          {"position_std_m", pooled.position_std_m},
          {"azimuth_std_deg", pooled.azimuth_std_rad * kDegPerRad}};
}

nlohmann::json ToJson(const AnnotatorAgreement& agreement) {
  nlohmann::json json = {
      {"objects", nlohmann::json::array()},        {"only_in_first", nlohmann::json::array()},
      {"only_in_second", nlohmann::json::array()}, {"fine", ToJson(agreement.fine)},
      {"coarse", ToJson(agreement.coarse)},        {"all", ToJson(agreement.all)}};
  for (const AgreedObject& object : agreement.objects) {
    const Eigen::Vector3d& d = object.difference_m;
    json["objects"].push_back({{"first", object.first.id},
                               {"second", object.second.id},
                               {"model", object.first.model},
                               {"second_model", object.second.model},
                               {"quality", object.fine ? "fine" : "coarse"},
                               {"copied", object.copied},
                               {"difference_m", {d.x(), d.y(), d.z()}},
                               {"horizontal_m", object.horizontal_m()},
                               {"height_m", d.z()},
                               {"azimuth_deg", Degrees(object.azimuth_rad)},
                               {"tilt_deg", object.tilt_rad * kDegPerRad},
                               {"position_std_m", object.position_std_m},
                               {"azimuth_std_deg", Degrees(object.azimuth_std_rad)}});
  }
  for (const auto& instance : agreement.only_first) json["only_in_first"].push_back(instance.id);
  for (const auto& instance : agreement.only_second) json["only_in_second"].push_back(instance.id);
  return json;
}

std::string InDegrees(const std::optional<double>& rad, const char* format) {
  if (!rad) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), format, *rad * kDegPerRad);
  return text;
}

void PrintPooled(const char* name, const PooledDeviation& pooled) {
  if (pooled.objects == 0) return;
  std::printf(
      "%-8s %7d %12.2f %9.2f %12.2f %10s%s\n", name, pooled.objects, 100 * pooled.horizontal_m,
      100 * pooled.height_m, 100 * pooled.position_std_m,
      InDegrees(pooled.azimuths > 0 ? std::optional(pooled.azimuth_std_rad) : std::nullopt, "%.2f")
          .c_str(),
      pooled.objects < kLeastPooled ? "   too few to tell" : "");
}

void Print(const AnnotatorAgreement& agreement) {
  std::printf("%-18s %-18s %10s %8s %9s %7s\n", "first", "second", "horizontal", "height",
              "azimuth", "tilt");
  std::printf("%-18s %-18s %10s %8s %9s %7s\n", "", "", "cm", "cm", "deg", "deg");
  for (const AgreedObject& object : agreement.objects) {
    std::printf("%-18s %-18s %10.2f %+8.2f %9s %7.2f%s%s%s\n", object.first.id.c_str(),
                object.second.id.c_str(), 100 * object.horizontal_m(),
                100 * object.difference_m.z(), InDegrees(object.azimuth_rad, "%+.2f").c_str(),
                object.tilt_rad * kDegPerRad, object.fine ? "" : "  coarse",
                object.same_model ? "" : ("  OTHER MODEL: " + object.second.model).c_str(),
                object.copied ? "  the same to the last digit: copied, not counted" : "");
  }
  for (const auto& instance : agreement.only_first)
    std::printf("%-18s %-18s only in the first\n", instance.id.c_str(), "-");
  for (const auto& instance : agreement.only_second)
    std::printf("%-18s %-18s only in the second\n", "-", instance.id.c_str());
  if (agreement.all.objects == 0) {
    std::printf("\nno object was placed by both\n");
    return;
  }
  std::printf("\none annotator's standard deviation: sigma^2 = mean(difference^2) / 2\n");
  std::printf("%-8s %7s %12s %9s %12s %10s\n", "", "objects", "x or y [cm]", "z [cm]", "x,y,z [cm]",
              "azimuth");
  PrintPooled("fine", agreement.fine);
  PrintPooled("coarse", agreement.coarse);
  PrintPooled("all", agreement.all);
}

}  // namespace

void AddSecondOptions(CLI::App& command, SecondArguments& arguments) {
  command
      .add_option("--second-frame", arguments.frame,
                  "The frame of a second ground truth: the scan's own, the scan turned z-up with "
                  "the floor at 0, or the sequence's world")
      ->check(CLI::IsMember({"scan", "level", "world"}))
      ->capture_default_str();
  command
      .add_option("--reach", arguments.reach_m,
                  "Objects of the two that are further apart are not the same one [m]")
      ->check(CLI::Range(0.001, 100.0))
      ->capture_default_str();
}

PoseFrame FrameOf(const std::string& name) {
  if (name == "level") return PoseFrame::kLevel;
  return name == "world" ? PoseFrame::kWorld : PoseFrame::kScan;
}

Result<AnnotatorAgreement> CompareWithSecond(const AnnotationProject& project,
                                             const ModelDatabase* models,
                                             const SecondArguments& arguments) {
  const Result<GroundTruth> second = ReadSecond(project, arguments);
  if (!second) return second.error();
  return CompareAnnotators(GroundTruthOf(project.document(), PoseFrame::kScan), *second, models,
                           arguments.reach_m);
}

std::map<std::string, PoseDeviation> DeviationsOf(const AnnotationProject& project,
                                                  const AnnotatorAgreement& agreement) {
  GroundTruth truth = GroundTruthOf(project.document(), PoseFrame::kScan);
  SetDeviations(agreement, truth);
  std::map<std::string, PoseDeviation> deviations;
  for (const GroundTruthInstance& instance : truth.instances) {
    if (instance.position_std_m)
      deviations[instance.id] = {instance.position_std_m, instance.azimuth_std_rad};
  }
  std::printf("how well it is known is written for %zu of %zu instances\n", deviations.size(),
              truth.instances.size());
  if (deviations.size() < truth.instances.size()) {
    std::printf(
        "  it takes %d objects of a quality that both placed on their own, with the same "
        "model; the others keep what is usual (docs/formats.md)\n",
        kLeastPooled);
  }
  return deviations;
}

Status Agree(const std::string& project_file, const SecondArguments& arguments,
             const std::string& json_file) {
  const auto project = OpenProject(project_file, AnnotationProject::Access::kRead);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  const auto agreement = CompareWithSecond(**project, inputs->models.get(), arguments);
  if (!agreement) return agreement.error();
  if (json_file != "-") Print(*agreement);
  if (inputs->models == nullptr)
    log::warn("'{}' names no models, so nothing counts as symmetric", project_file);
  return json_file.empty() ? Status() : WriteJsonResult(json_file, ToJson(*agreement));
}

}  // namespace plumbline
