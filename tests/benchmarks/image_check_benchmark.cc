// SPDX-License-Identifier: Apache-2.0
// How well the true poses of a sequence agree with its images, and what refinement by images makes
// of poses that are off. Prints the milliseconds that an image takes on one core.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/annotation/check_frames.h"
#include "engine/annotation/image_check.h"
#include "engine/annotation/image_refinement.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/random.h"
#include "engine/base/timer.h"
#include "engine/dataset/ground_truth.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

void Draw(const AnnotationImage& image, const ImageCheck& check,
          const std::filesystem::path& file) {
  cv::Mat picture = image.image.clone();
  const auto point = [](const Eigen::Vector2f& p) {
    return cv::Point(static_cast<int>(std::lround(16 * p.x())),
                     static_cast<int>(std::lround(16 * p.y())));
  };
  for (const OutlinePolyline& line : check.outline.lines) {
    const cv::Scalar color = line.hidden                          ? cv::Scalar(160, 160, 160)
                             : line.kind == OutlineKind::kContour ? cv::Scalar(0, 220, 0)
                                                                  : cv::Scalar(255, 160, 0);
    for (std::size_t i = 1; i < line.pixels.size(); ++i) {
      cv::line(picture, point(line.pixels[i - 1]), point(line.pixels[i]), color, 1, cv::LINE_AA, 4);
    }
  }
  for (std::size_t i = 0; i < check.hits.size(); ++i) {
    if (check.hits[i].strength == 0) continue;
    const OutlineSample& sample = check.outline.samples[i];
    cv::line(picture, point(sample.pixel),
             point(sample.pixel + check.hits[i].offset_px * sample.normal), cv::Scalar(0, 0, 255),
             1, cv::LINE_AA, 4);
  }
  cv::imwrite(file, picture);
}

struct Arguments {
  std::vector<std::filesystem::path> sequences;
  std::filesystem::path pictures;
  std::string edges;
  int frames = 12, trials = 0;
  std::vector<double> shifts_m{0.05};
  double turn_deg_per_m = 80;
  std::uint64_t seed = 1;
};

/// The errors of a pose: across up, along up [m] and about up [degrees].
Eigen::Vector3d Errors(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& pose,
                       const Eigen::Vector3d& center, const UprightFrame& upright) {
  const Eigen::Vector3d up = upright.up_in_world(), off = pose * center - truth * center;
  const double height = up.dot(off);
  return {(off - height * up).norm(), height,
          kDegPerRad * WrapAngle(upright.Azimuth(pose.linear()) - upright.Azimuth(truth.linear()))};
}

/// A refinement that began `shift_m` beside the truth; 0: at the truth.
struct Trial {
  double shift_m = 0;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< As of Errors.
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< Likewise.
  double squared_by_covariance = 0;  ///< Of shift and turn; 4 on average where it is right.
  bool back = false;                 ///< At the place that it comes to from the truth itself.
};

/// A refinement by the truth, at the model's middle, where shift and turn are apart.
Trial Judge(const Eigen::Isometry3d& truth, const ImageRefinement& refined,
            const Eigen::Vector3d& center, const UprightFrame& upright) {
  const Eigen::Vector3d up = upright.up_in_world();
  const Eigen::Vector3d lever = refined.scan_from_object.linear() * center;
  Eigen::Matrix<double, 4, 6> middle = Eigen::Matrix<double, 4, 6>::Zero();
  middle.topLeftCorner<3, 3>().setIdentity();
  middle.topRightCorner<3, 3>() << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(),
      -lever.x(), 0;
  middle.bottomRightCorner<1, 3>() = up.transpose();
  const Eigen::Matrix4d at = middle * refined.covariance * middle.transpose();
  Trial trial;
  trial.error = Errors(truth, refined.scan_from_object, center, upright);
  const double height_var = up.dot(at.topLeftCorner<3, 3>() * up);
  trial.sigma = {std::sqrt(at.topLeftCorner<3, 3>().trace() - height_var), std::sqrt(height_var),
                 kDegPerRad * std::sqrt(at(3, 3))};
  Eigen::Vector4d off;
  off << refined.scan_from_object * center - truth * center, trial.error[2] / kDegPerRad;
  trial.squared_by_covariance = off.dot(at.ldlt().solve(off));
  return trial;
}

Eigen::Isometry3d Beside(const Eigen::Isometry3d& pose, const Eigen::Vector3d& center,
                         const UprightFrame& upright, double shift_m, double turn_deg,
                         Random random) {
  const double heading = 2 * std::numbers::pi * random.Uniform();
  const Eigen::Vector3d up = upright.up_in_world();
  const Eigen::Matrix3d frame = upright.upright_rotation();
  const Eigen::Vector3d shift =
      shift_m * (std::cos(heading) * frame.col(0) + std::sin(heading) * frame.col(1) +
                 0.5 * (2 * random.Uniform() - 1) * up);
  const double turn = turn_deg / kDegPerRad * (random.Uniform() < 0.5 ? -1 : 1);
  Eigen::Isometry3d start = pose;
  start.linear() = Eigen::AngleAxisd(turn, up) * start.linear();
  start.translation() = pose * center + shift - start.linear() * center;
  return start;
}

/// Refines from the truth itself and from places around it. What fewer than six images show does
/// not count.
void Refine(const Arguments& arguments, const AnnotationImages& images, const OutlineModel& model,
            const AnnotatedInstance& instance, const Occluders& occluders,
            const UprightFrame& upright, std::vector<Trial>& trials) {
  constexpr double kSame_m = 0.005, kSame_deg = 0.5, kTurnUnseen_deg = 2;
  const Eigen::Vector3d up = upright.up_in_world(), center = model.center().cast<double>();
  constexpr int kFewestImages = 6;
  std::optional<Eigen::Isometry3d> from_truth;
  bool counts = false;
  const auto refine = [&](double shift_m, std::uint32_t number) {
    const Eigen::Isometry3d start =
        Beside(instance.scan_from_object, center, upright, shift_m,
               arguments.turn_deg_per_m * shift_m, Random({arguments.seed, number}));
    Stopwatch watch;
    const auto refined = RefineByImages(images, model, start, up, occluders);
    if (!refined) {
      std::printf("    %s\n", refined.error().message.c_str());
      return;
    }
    if (!from_truth) {
      from_truth = refined->scan_from_object;
      counts = refined->images >= kFewestImages;
    }
    Trial trial = Judge(instance.scan_from_object, *refined, center, upright);
    const Eigen::Vector3d apart = Errors(*from_truth, refined->scan_from_object, center, upright);
    trial.shift_m = shift_m;
    trial.back = apart[0] < kSame_m && std::abs(apart[1]) < kSame_m &&
                 (std::abs(apart[2]) < kSame_deg || trial.sigma[2] > kTurnUnseen_deg);
    if (counts) trials.push_back(trial);
    std::printf(
        "    from %3.0f mm: %5.1f mm %5.1f mm %6.2f deg  sigma %4.1f %4.1f mm %4.2f deg  agreement "
        "%.3f -> %.3f  %s, start %d, %d images, %.2f s\n",
        1e3 * shift_m, 1e3 * trial.error[0], 1e3 * trial.error[1], trial.error[2],
        1e3 * trial.sigma[0], 1e3 * trial.sigma[1], trial.sigma[2], refined->agreement_before,
        refined->agreement_after,
        refined->stop == RefinementStop::kConverged ? "converged"
        : refined->stop == RefinementStop::kMoving  ? "moving"
                                                    : "no better",
        refined->start, refined->images, watch.Lap() / 1e3);
  };
  refine(0, 0);
  for (const double shift_m : arguments.shifts_m) {
    for (int i = 1; i <= arguments.trials; ++i) refine(shift_m, static_cast<std::uint32_t>(i));
  }
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

/// A line for each distance of the start from the truth.
void Summarise(const std::vector<Trial>& trials) {
  constexpr double kSquaredWithin95 = 9.49;  // Of four degrees of freedom.
  std::map<double, std::vector<Trial>> by_shift;
  for (const Trial& trial : trials) by_shift[trial.shift_m].push_back(trial);
  std::printf(
      "start  runs  same place as from the truth  median, 90 %%: across, height, azimuth"
      "   squared by covariance: median, within 95 %%\n");
  for (const auto& [shift_m, list] : by_shift) {
    std::vector<double> errors[3], squared;
    int back = 0, within = 0;
    for (const Trial& trial : list) {
      for (int i = 0; i < 3; ++i) errors[i].push_back(std::abs(trial.error[i]));
      squared.push_back(trial.squared_by_covariance);
      back += trial.back;
      within += trial.squared_by_covariance < kSquaredWithin95;
    }
    std::printf(
        "%3.0f mm  %4zu  %5.1f %%  %4.1f %5.1f mm  %4.1f %5.1f mm  %5.2f %5.2f deg   %.2f  "
        "%.1f %%\n",
        1e3 * shift_m, list.size(), 100.0 * back / static_cast<double>(list.size()),
        1e3 * Quantile(errors[0], 0.5), 1e3 * Quantile(errors[0], 0.9),
        1e3 * Quantile(errors[1], 0.5), 1e3 * Quantile(errors[1], 0.9), Quantile(errors[2], 0.5),
        Quantile(errors[2], 0.9), Quantile(squared, 0.5),
        100.0 * within / static_cast<double>(list.size()));
  }
}

Status Run(const Arguments& arguments, const std::filesystem::path& folder,
           std::vector<Trial>& trials) {
  const auto sequence = OpenSequence(folder);
  if (!sequence) return sequence.error();
  const auto truth = ReadGroundTruth(*(*sequence)->ground_truth_file());
  if (!truth) return truth.error();
  auto models = ModelDatabase::Load(*(*sequence)->models_folder());
  if (!models) return models.error();
  auto mesh = ReadMesh(*(*sequence)->scene_file());
  if (!mesh) return mesh.error();
  Stopwatch watch;
  auto scan = OccludingScan::Prepare(std::make_shared<TriangleMesh>(std::move(*mesh)));
  std::printf("scan prepared in %.0f ms\n", watch.Lap());
  AnnotationDocument document;
  document.gravity_in_scan = truth->gravity_in_world;
  for (const GroundTruthInstance& instance : truth->instances) {
    document.instances.push_back(
        {instance.id, instance.model, instance.category, instance.world_from_object});
  }
  OutlineScene scene(*models, scan ? *scan : nullptr);
  for (const AnnotatedInstance& instance : document.instances) {
    const auto model = scene.Model(instance.model);
    if (!model) return model.error();
    const Occluders occluders = scene.OccludersOf(document, instance.id);
    watch.Lap();
    CheckFrameOptions choice;
    choice.frames = arguments.frames;
    const auto frames = ChooseCheckFrames(**sequence, document, **model, instance.scan_from_object,
                                          occluders, choice);
    const double choose_ms = watch.Lap();
    if (!frames) return frames.error();
    std::vector<int> indices;
    for (const CheckFrame& frame : *frames) indices.push_back(frame.frame);
    if (indices.empty()) {
      std::printf("%-16s no frame shows it\n", instance.id.c_str());
      continue;
    }
    const auto images = AnnotationImages::Load(*sequence, document, indices, arguments.edges);
    if (!images) return images.error();
    const double load_ms = watch.Lap();
    std::vector<ImageCheck> checks;
    for (const AnnotationImage& image : (*images)->images()) {
      checks.push_back(
          CheckImage(image, (*images)->camera(), **model, instance.scan_from_object, occluders));
    }
    const double check_ms = watch.Lap() / static_cast<double>(checks.size());
    std::printf(
        "%-16s agreement %.2f  %.2f ms an image (%zu edges), %zu frames chosen in %.0f ms, "
        "loaded in %.0f ms\n",
        instance.id.c_str(), MeanAgreement(checks), check_ms, (*model)->edges().size(),
        frames->size(), choose_ms, load_ms);
    if (arguments.trials > 0) {
      Refine(arguments, **images, **model, instance, occluders,
             UprightFrame(document.gravity_in_scan), trials);
      continue;
    }
    for (std::size_t i = 0; i < checks.size(); ++i) {
      const CheckFrame& frame = (*frames)[i];
      std::printf(
          "    frame %4d  visible %3.0f %%  %4.1f m  %4.0f deg  agreement %.2f  offset %.2f "
          "px  %zu samples\n",
          frame.frame, 100 * frame.visible, frame.distance_m, 57.2958 * frame.bearing_rad,
          checks[i].agreement, checks[i].median_offset_px, checks[i].hits.size());
      if (!arguments.pictures.empty()) {
        Draw((*images)->images()[i], checks[i],
             arguments.pictures / (instance.id + "_" + std::to_string(frame.frame) + ".png"));
      }
    }
  }
  return {};
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  CLI::App app("Image agreement and refinement by images on a sequence with ground truth");
  plumbline::Arguments arguments;
  app.add_option("sequences", arguments.sequences, "In Plumbline's own layout")->required();
  app.add_option("--pictures", arguments.pictures, "Folder to draw outlines into");
  app.add_option("--edges", arguments.edges, "dataset, gradient or a FILE.onnx");
  app.add_option("--frames", arguments.frames, "Key frames of each object");
  app.add_option("--trials", arguments.trials, "Refine from so many poses that are off");
  app.add_option("--shift", arguments.shifts_m, "By how much [m]; several: the basin")
      ->delimiter(',');
  app.add_option("--turn", arguments.turn_deg_per_m, "Degrees of turn for each metre of shift");
  app.add_option("--seed", arguments.seed);
  CLI11_PARSE(app, argc, argv);
  std::vector<plumbline::Trial> trials;
  for (const std::filesystem::path& folder : arguments.sequences) {
    const plumbline::Status status = plumbline::Run(arguments, folder, trials);
    if (status.ok()) continue;
    std::fprintf(stderr, "%s\n", status.error().message.c_str());
    return 1;
  }
  if (!trials.empty()) plumbline::Summarise(trials);
  return 0;
}
