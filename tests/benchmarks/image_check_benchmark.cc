// SPDX-License-Identifier: Apache-2.0
// Outlines and edge agreement of the true poses of a sequence: image_check_benchmark SEQUENCE
// [PICTURES]. Prints, for each object, the agreement and the milliseconds that an image takes on
// one core; with PICTURES, draws the outlines there.
#include <cstdio>
#include <filesystem>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/annotation/check_frames.h"
#include "engine/annotation/image_check.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/timer.h"
#include "engine/dataset/ground_truth.h"
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

Status Run(const std::filesystem::path& folder, const std::filesystem::path& pictures) {
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
    const auto frames =
        ChooseCheckFrames(**sequence, document, **model, instance.scan_from_object, occluders);
    const double choose_ms = watch.Lap();
    if (!frames) return frames.error();
    std::vector<int> indices;
    for (const CheckFrame& frame : *frames) indices.push_back(frame.frame);
    if (indices.empty()) {
      std::printf("%-16s no frame shows it\n", instance.id.c_str());
      continue;
    }
    const auto images = AnnotationImages::Load(*sequence, document, indices, "");
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
    for (std::size_t i = 0; i < checks.size(); ++i) {
      const CheckFrame& frame = (*frames)[i];
      std::printf(
          "    frame %4d  visible %3.0f %%  %4.1f m  %4.0f deg  agreement %.2f  offset %.2f "
          "px  %zu samples\n",
          frame.frame, 100 * frame.visible, frame.distance_m, 57.2958 * frame.bearing_rad,
          checks[i].agreement, checks[i].median_offset_px, checks[i].hits.size());
      if (!pictures.empty()) {
        Draw((*images)->images()[i], checks[i],
             pictures / (instance.id + "_" + std::to_string(frame.frame) + ".png"));
      }
    }
  }
  return {};
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "image_check_benchmark SEQUENCE [PICTURES]\n");
    return 2;
  }
  const plumbline::Status status = plumbline::Run(argv[1], argc > 2 ? argv[2] : "");
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
