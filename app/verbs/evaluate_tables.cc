// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/evaluate_tables.h"

#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/analysis/missed_truths.h"
#include "engine/analysis/reliability.h"

namespace plumbline {
namespace {

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

std::string Number(const char* format, std::optional<double> value) {
  if (!value) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), format, *value);
  return text;
}

/// Of what a scale was estimated or is true: in per cent more than the model.
std::string SizeInWords(const MatchedObject& object) {
  if (!object.estimate.scale_std && object.truth.scale == 1) return "";
  std::string text = "  size " + Number("%+.1f", 100 * (object.estimate.scale - 1));
  if (object.estimate.scale_std) text += Number(" +- %.1f", 100 * *object.estimate.scale_std);
  return text + Number(" %% (true %+.1f %%)", 100 * (object.truth.scale - 1));
}

/// How well the truth itself is known, where its file says so.
std::string TruthInWords(const GroundTruthInstance& truth) {
  if (!truth.position_std_m && !truth.azimuth_std_rad) return "";
  std::string text = "  truth +-";
  if (truth.position_std_m) text += Number("%.1f cm", 100 * *truth.position_std_m);
  if (truth.azimuth_std_rad)
    text += (truth.position_std_m ? " " : "") + Number("%.1f deg", Degrees(*truth.azimuth_std_rad));
  return text;
}

void PrintMissed(const JudgedMap& map) {
  for (const GroundTruthInstance& instance : map.evaluation.missed) {
    std::printf("%-6s %-18s %-18s %s\n", "MISSED", instance.model.c_str(), instance.id.c_str(),
                instance.fine ? "" : "coarse");
    const TruthView* truth = map.truths ? FindTruth(*map.truths, instance.id) : nullptr;
    if (truth != nullptr) std::printf("       %s\n", truth->text.c_str());
    const auto told = map.planted.find(instance.id);
    if (told != map.planted.end())
      std::printf("       Planted, to blame is %s: %s\n", BlameOf(told->second.fate),
                  told->second.text.c_str());
  }
}

void PrintObjects(const JudgedMap& map) {
  const MapEvaluation& evaluation = map.evaluation;
  std::printf("%-6s %-18s %-18s %7s %7s %8s %8s %6s %7s %8s\n", "object", "model", "ground truth",
              "trans.", "centre", "rotation", "azimuth", "tilt", "height", "surface");
  std::printf("%-6s %-18s %-18s %7s %7s %8s %8s %6s %7s %8s\n", "", "", "", "cm", "cm", "deg",
              "deg", "deg", "cm", "mean cm");
  for (const MatchedObject& object : evaluation.matched) {
    const PoseError& pose = object.pose;
    const std::optional<double> azimuth =
        pose.azimuth_rad ? std::optional(Degrees(*pose.azimuth_rad)) : std::nullopt;
    std::printf("%-6s %-18s %-18s %7.1f %7.1f %8.2f %8s %6.2f %+7.1f %8.2f%s%s%s%s\n",
                object.estimate.id.c_str(), object.estimate.model.c_str(), object.truth.id.c_str(),
                100 * pose.translation_m, 100 * object.centre_m, Degrees(pose.rotation_rad),
                Number("%+.2f", azimuth).c_str(), Degrees(pose.tilt_rad), 100 * pose.height_m,
                100 * object.surface.mean_m, object.truth.fine ? "" : "  coarse",
                object.model_correct ? "" : "  WRONG MODEL", SizeInWords(object).c_str(),
                TruthInWords(object.truth).c_str());
  }
  for (const SpuriousObject& object : evaluation.spurious) {
    std::printf("%-6s %-18s %-18s %59s\n", object.estimate.id.c_str(),
                object.estimate.model.c_str(), "SPURIOUS",
                Number("%.2f", 100 * object.surface.mean_m).c_str());
    if (!object.moving.empty())
      std::printf("       It is where %s moved.\n", object.moving.c_str());
  }
  PrintMissed(map);
}

std::string Percent(double share, int of) {
  return of > 0 ? Number("%.1f", 100 * share / of) : "-";
}

std::optional<double> Centimetres(std::optional<double> m) {
  return m ? std::optional(100 * *m) : std::nullopt;
}

std::optional<double> InDegrees(std::optional<double> rad) {
  return rad ? std::optional(Degrees(*rad)) : std::nullopt;
}

void PrintSurface(const char* name, const ErrorStatistics& s, const std::string& remark) {
  if (s.samples == 0) {
    std::printf("%-44s %8s %8s %8s %8s   %s\n", name, "-", "-", "-", "-", remark.c_str());
    return;
  }
  std::printf("%-44s %8.2f %8.2f %8.2f %8.2f   %s\n", name, 100 * s.mean_m, 100 * s.median_m,
              100 * s.std_m, 100 * s.max_m, remark.c_str());
}

void PrintSurfaces(const JudgedMap& map) {
  const SurfaceReferences& surfaces = map.surfaces;
  const ErrorStatistics none;
  const std::string no_scan = map.has_scan ? "" : "needs --scene";
  std::printf("%-44s %8s %8s %8s %8s\n", "surface of the map, distances [cm]", "mean", "median",
              "std", "max");
  PrintSurface("to the scan, where it was scanned",
               surfaces.scanned ? surfaces.scanned->distance.to_triangle : none,
               surfaces.scanned ? Number("%.0f %%", 100 * surfaces.scanned->share) +
                                      " of the surface of what is matched"
                                : no_scan);
  PrintSurface("to the posed true models", surfaces.posed.to_triangle, "its own meshes, moved");
  PrintSurface("by the paper's rule: ICP, normal, scan",
               surfaces.paper ? surfaces.paper->distance.to_plane : none,
               surfaces.paper ? "the paper's mean: 1.39 - 2.79 VISMA, 0.3 - 6.3 SceneNN" : no_scan);
  PrintSurface("as VISMA's code: ICP, posed true models",
               surfaces.visma ? surfaces.visma->to_triangle : none,
               surfaces.visma ? "its own meshes, moved" : no_scan);
  const auto truth = static_cast<std::size_t>(map.options.truth);
  PrintSurface(("as --truth " + std::string(EnumNames<TruthSurface>::names[truth])).c_str(),
               map.evaluation.surface,
               map.has_scan && map.options.truth == TruthSurface::kBoth
                   ? "whichever is nearer, scan or its own mesh: flatters"
                   : "");
  PrintSurface("completeness: from the true objects to it", map.evaluation.completeness, "");
}

void PrintMeans(const JudgedMap& map) {
  const MeanPoseError &fine = map.evaluation.mean, &all = map.evaluation.mean_all;
  const MeanPoseError paper = map.surfaces.paper ? map.surfaces.paper->mean_all : MeanPoseError();
  std::printf("\n%-22s %8s %8s %17s   %s\n", "mean pose error", "fine", "all", "all, paper's ICP",
              "the paper");
  std::printf("%-22s %8s %8s %17s   %s\n", "translation [cm]",
              Number("%.2f", Centimetres(fine.translation_m)).c_str(),
              Number("%.2f", Centimetres(all.translation_m)).c_str(),
              Number("%.2f", Centimetres(paper.translation_m)).c_str(), "2.4 - 13.6 VISMA");
  std::printf("%-22s %8s %8s %17s   %s\n", "rotation [deg]",
              Number("%.2f", InDegrees(fine.rotation_rad)).c_str(),
              Number("%.2f", InDegrees(all.rotation_rad)).c_str(),
              Number("%.2f", InDegrees(paper.rotation_rad)).c_str(), "4.7 - 9.1 VISMA");
}

std::string OutOf(const SuccessCount& count) {
  return std::to_string(count.right) + " of " + std::to_string(count.truths);
}

void PrintBins(const char* name, const std::vector<ShownBin>& bins) {
  std::printf("  %-32s", name);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (bins[i].truths == 0) continue;
    const std::string range =
        i + 1 < bins.size() ? Number("%.0f", bins[i].from) + Number(" - %.0f", bins[i + 1].from - 1)
                            : Number("%.0f", bins[i].from) + " and more";
    std::printf("  %s: %d of %d", range.c_str(), bins[i].found, bins[i].truths);
  }
  std::printf("\n");
}

void PrintKitti(const KittiMeasures& kitti) {
  std::printf("\nas KITTI counts, %s\n", kitti.category.c_str());
  std::printf("  %-32s %9s", "[%], over 40 places of recall", "");
  for (const std::string_view level : kKittiLevelNames)
    std::printf(" %17s", std::string(level).c_str());
  std::printf("%s\n", kitti.has_levels ? "" : "   (no poses of the camera: every box counts)");
  const auto row = [&](const char* name, double least_iou, const auto& by_level) {
    std::printf("  %-32s IoU >= %.1f", name, least_iou);
    for (const KittiPrecision& p : by_level)
      std::printf(" %5.1f AOS %5.1f %2d/%2d", 100 * p.ap_40, 100 * p.aos_40, p.found, p.truths);
    std::printf("\n");
  };
  for (std::size_t k = 0; k < KittiMeasures::kLeastIous.size(); ++k) {
    row("3-D boxes, AP", KittiMeasures::kLeastIous[k], kitti.volume[k]);
    row("from above, AP", KittiMeasures::kLeastIous[k], kitti.base[k]);
  }
  if (kitti.pairs.empty()) return;
  double iou = 0, base = 0, orientation = 0;
  for (const KittiPair& pair : kitti.pairs) {
    iou += pair.iou;
    base += pair.base_iou;
    orientation += pair.orientation;
  }
  const auto count = static_cast<double>(kitti.pairs.size());
  std::printf("  %-32s IoU %.2f, from above %.2f, orientation similarity %.3f\n",
              "matched objects, mean", iou / count, base / count, orientation / count);
}

void PrintOthers(const JudgedMap& map) {
  const PlacementSuccess& placement = map.placement;
  std::printf("\nas other benchmarks count\n");
  std::printf(
      "  %-32s  %s; mean of categories %s %%", "Scan2CAD: 20 cm, 20 deg, 20 %",
      OutOf(placement.all).c_str(),
      placement.category_mean ? Number("%.1f", 100 * *placement.category_mean).c_str() : "-");
  for (const auto& [category, count] : placement.by_category)
    std::printf("; %s %s", category.c_str(), OutOf(count).c_str());
  std::printf("\n  %-32s  %s\n", "ADD(-S) below .1 diameter", OutOf(placement.add).c_str());
  const auto percent = [](std::optional<double> share) {
    return share ? Number("%.1f", 100 * *share) : std::string("-");
  };
  std::printf("  %-32s  %s at IoU .25, %s at IoU .5, of %d candidates\n", "3-D boxes, mean AP [%]",
              percent(map.detection.at_25.mean).c_str(), percent(map.detection.at_50.mean).c_str(),
              map.detection.candidates);
  if (map.single_frames) {
    const BopRecall& bop = map.single_frames->all;
    std::printf(
        "  %-32s  %.1f (VSD %.1f, MSSD %.1f, MSPD %.1f); %d of %d targets in %d frames have "
        "an estimate\n",
        "single frames, BOP's AR [%]", 100 * bop.average(), 100 * bop.vsd, 100 * bop.mssd,
        100 * bop.mspd, bop.estimated, bop.targets, map.single_frames->frames);
  }
  if (!map.truths) return;
  const ShownTruths shown = ShownTruthsOf(*map.truths);
  std::printf("\nfound, by how much it showed\n");
  PrintBins("in frames", shown.by_frames);
  PrintBins("in pixels of its best frame", shown.by_pixels);
}

}  // namespace

void PrintJudgedMap(const JudgedMap& map) {
  const MapEvaluation& evaluation = map.evaluation;
  PrintObjects(map);
  const auto align = static_cast<std::size_t>(map.options.align);
  const auto truth = static_cast<std::size_t>(map.options.truth);
  std::printf("\nmatched %zu, missed %zu, spurious %zu; alignment %s, truth %s%s\n\n",
              evaluation.matched.size(), evaluation.missed.size(), evaluation.spurious.size(),
              std::string(EnumNames<Alignment>::names[align]).c_str(),
              map.has_scan ? std::string(EnumNames<TruthSurface>::names[truth]).c_str() : "models",
              map.has_scan ? "" : " (no --scene)");
  if (map.by_trajectory) {
    const TrajectoryErrors& errors = map.by_trajectory->errors;
    std::printf(
        "own poses against the reference: %d frames, ATE %.1f cm, tilt %.2f deg, scale %.4f "
        "(by which they have to grow)\n\n",
        errors.matched, 100 * errors.ate_m, Degrees(errors.tilt_rad), errors.scale);
  }
  PrintSurfaces(map);
  PrintMeans(map);
  PrintOthers(map);
  if (map.kitti) PrintKitti(*map.kitti);
}

nlohmann::json JudgedMapToJson(const JudgedMap& map) {
  nlohmann::json json = EvaluationToJson(map.evaluation, map.options);
  json["surfaces"] = SurfacesToJson(map.surfaces);
  json["placement"] = PlacementToJson(map.placement);
  json["detection"] = DetectionToJson(map.detection);
  if (map.kitti) json["kitti"] = KittiToJson(*map.kitti);
  if (map.single_frames) json["single_frames"] = SingleFramesToJson(*map.single_frames);
  if (map.truths) json["shown"] = ShownTruthsToJson(ShownTruthsOf(*map.truths));
  if (map.by_trajectory) {
    const TrajectoryErrors& errors = map.by_trajectory->errors;
    json["trajectory"] = {{"matched", errors.matched},
                          {"ate_m", errors.ate_m},
                          {"ate_deg", Degrees(errors.ate_rad)},
                          {"tilt_deg", Degrees(errors.tilt_rad)},
                          {"scale", errors.scale},
                          {"path_m", errors.path_m}};
  }
  for (nlohmann::json& missed : json["missed_instances"]) {
    const auto id = missed["ground_truth"].get<std::string>();
    const TruthView* told = map.truths ? FindTruth(*map.truths, id) : nullptr;
    if (told != nullptr) missed["why"] = WhyMissedToJson(*told);
    if (const auto at = map.planted.find(id); at != map.planted.end())
      missed["planted"] = PlantedToJson(at->second);
  }
  return json;
}

void PrintReliability(const RunHistory& history, int truths) {
  const Reliability end = ReliabilityAtEnd(history).all;
  const RunReliability along = ReliabilityOf(history);
  std::printf("\n%-34s %10s %13s\n", "beliefs about confirmed objects", "at the end",
              "along the run");
  const auto print = [&](const char* name, const auto& of) {
    std::printf("%-34s %10s %13s\n", name, of(end).c_str(), of(along.all).c_str());
  };
  print("poses", [](const Reliability& of) { return std::to_string(of.poses); });
  print("truth in the 50 % region [%]",
        [](const Reliability& of) { return Percent(of.within_50, of.poses); });
  print("truth in the 95 % region [%]",
        [](const Reliability& of) { return Percent(of.within_95, of.poses); });
  print("NEES, 4 if honest",
        [](const Reliability& of) { return of.objects > 0 ? Number("%.1f", of.nees) : "-"; });
  print("  95 % of honest runs", [](const Reliability& of) {
    return of.objects > 0 ? Number("%.1f", of.nees_low) + " - " + Number("%.1f", of.nees_high)
                          : "-";
  });
  print("label right [%], of several models",
        [](const Reliability& of) { return Percent(of.labels.right, of.labels.count); });
  print("  believed at [%]",
        [](const Reliability& of) { return Percent(of.labels.claimed, of.labels.count); });
  print("  expected calibration error",
        [](const Reliability& of) { return Number("%.3f", of.labels.ExpectedError()); });
  std::printf("%-34s %10s\n", "average precision of being there",
              Number("%.2f", ConfirmationOf(history, truths).average_precision).c_str());
  if (along.objects.empty()) return;
  std::printf("\n%-24s %8s %8s %8s %8s\n", "along the run, by object", "poses", "50 %", "95 %",
              "NEES");
  for (const auto& [object, of] : along.objects) {
    std::printf("%-24d %8d %8s %8s %8.1f\n", object.value, of.poses,
                Percent(of.within_50, of.poses).c_str(), Percent(of.within_95, of.poses).c_str(),
                of.nees);
  }
}

}  // namespace plumbline
