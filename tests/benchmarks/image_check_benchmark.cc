// SPDX-License-Identifier: Apache-2.0
// How well the true poses of a sequence agree with its images, and what refinement by images makes
// of poses that are off. Prints the milliseconds that an image takes on one core.
#include <cstdio>
#include <filesystem>
#include <numbers>

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
  std::filesystem::path sequence, pictures;
  std::string edges;
  int frames = 12, trials = 0;
  double shift_m = 0.05, turn_deg = 5;
  std::uint64_t seed = 1;
};

constexpr double kDegrees = 180 / std::numbers::pi;

/// The errors of a pose: across up, along up [m] and about up [degrees].
Eigen::Vector3d Errors(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& pose,
                       const Eigen::Vector3d& center, const UprightFrame& upright) {
  const Eigen::Vector3d up = upright.up_in_world(), off = pose * center - truth * center;
  const double height = up.dot(off);
  return {(off - height * up).norm(), height,
          kDegrees * WrapAngle(upright.Azimuth(pose.linear()) - upright.Azimuth(truth.linear()))};
}

/// Refines from the truth itself and from places around it.
Status Refine(const Arguments& arguments, const AnnotationImages& images, const OutlineModel& model,
              const AnnotatedInstance& instance, const Occluders& occluders,
              const UprightFrame& upright) {
  const Eigen::Vector3d up = upright.up_in_world(), center = model.center().cast<double>();
  for (int trial = 0; trial <= arguments.trials; ++trial) {
    Random random({arguments.seed, static_cast<std::uint32_t>(trial)});
    const double amount = trial == 0 ? 0 : 1, heading = 2 * std::numbers::pi * random.Uniform();
    const Eigen::Matrix3d frame = upright.upright_rotation();
    const Eigen::Vector3d shift =
        amount * arguments.shift_m *
        (std::cos(heading) * frame.col(0) + std::sin(heading) * frame.col(1) +
         0.5 * (2 * random.Uniform() - 1) * up);
    const double turn = amount * arguments.turn_deg / kDegrees * (random.Uniform() < 0.5 ? -1 : 1);
    Eigen::Isometry3d start = instance.scan_from_object;
    start.linear() = Eigen::AngleAxisd(turn, up) * start.linear();
    start.translation() = instance.scan_from_object * center + shift - start.linear() * center;
    Stopwatch watch;
    const auto refined = RefineByImages(images, model, start, up, occluders);
    if (!refined) {
      std::printf("    %s\n", refined.error().message.c_str());
      return {};
    }
    const Eigen::Vector3d error =
        Errors(instance.scan_from_object, refined->scan_from_object, center, upright);
    // The covariance is of the origin; the middle swings with the turn.
    Eigen::Matrix<double, 3, 6> middle;
    const Eigen::Vector3d lever = refined->scan_from_object.linear() * center;
    middle << Eigen::Matrix3d::Identity(), (Eigen::Matrix3d() << 0, lever.z(), -lever.y(),
                                            -lever.z(), 0, lever.x(), lever.y(), -lever.x(), 0)
                                               .finished();
    const Eigen::Matrix3d at = middle * refined->covariance * middle.transpose();
    const double height_var = up.dot(at * up);
    std::printf(
        "    %-5s %5.1f mm %5.1f mm %6.2f deg  sigma %4.1f %4.1f mm %4.2f deg  agreement "
        "%.3f -> %.3f  %s, start %d, %d images, %.2f s\n",
        trial == 0 ? "truth" : "off", 1e3 * error[0], 1e3 * error[1], error[2],
        1e3 * std::sqrt(at.trace() - height_var), 1e3 * std::sqrt(height_var),
        kDegrees * std::sqrt(up.dot(refined->covariance.bottomRightCorner<3, 3>() * up)),
        refined->agreement_before, refined->agreement_after,
        refined->stop == RefinementStop::kConverged ? "converged"
        : refined->stop == RefinementStop::kMoving  ? "moving"
                                                    : "no better",
        refined->start, refined->images, watch.Lap() / 1e3);
  }
  return {};
}

Status Run(const Arguments& arguments) {
  const auto sequence = OpenSequence(arguments.sequence);
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
      const Status refined = Refine(arguments, **images, **model, instance, occluders,
                                    UprightFrame(document.gravity_in_scan));
      if (!refined.ok()) return refined;
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
  app.add_option("sequence", arguments.sequence, "In Plumbline's own layout")->required();
  app.add_option("--pictures", arguments.pictures, "Folder to draw outlines into");
  app.add_option("--edges", arguments.edges, "dataset, gradient or a FILE.onnx");
  app.add_option("--frames", arguments.frames, "Key frames of each object");
  app.add_option("--trials", arguments.trials, "Refine from so many poses that are off");
  app.add_option("--shift", arguments.shift_m, "By how much [m]");
  app.add_option("--turn", arguments.turn_deg, "By how much [degrees]");
  app.add_option("--seed", arguments.seed);
  CLI11_PARSE(app, argc, argv);
  const plumbline::Status status = plumbline::Run(arguments);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
