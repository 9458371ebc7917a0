// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/image_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

namespace plumbline {
namespace {

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Fills in what the hits say.
void Summarise(double chance, const EdgeAgreementOptions& options, ImageCheck& check) {
  double hit = 0, all = 0;
  std::vector<double> offsets;
  for (std::size_t i = 0; i < check.hits.size(); ++i) {
    const OutlineSample& sample = check.outline.samples[i];
    if (sample.hidden) continue;
    const bool crease = sample.kind == OutlineKind::kCrease;
    const double length = (crease ? options.crease_weight : 1.0) * sample.length_px;
    hit += length * check.hits[i].strength;
    all += length;
    check.visible_px += sample.length_px;
    if (check.hits[i].strength > 0) offsets.push_back(std::abs(check.hits[i].offset_px));
  }
  check.median_offset_px = Median(std::move(offsets));
  if (all > 0) check.agreement = std::clamp((hit / all - chance) / (1 - chance), 0.0, 1.0);
}

}  // namespace

ImageCheck CheckImage(const AnnotationImage& image, const PinholeCamera& camera,
                      const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
                      const Occluders& occluders, const OutlineOptions& outline,
                      const EdgeAgreementOptions& options) {
  ImageCheck check;
  check.frame = image.frame;
  check.outline =
      ProjectOutline(model, scan_from_object, image.scan_from_cam, camera, occluders, outline);
  const EdgeSearch search(image.edges, options);
  for (const OutlineSample& sample : check.outline.samples) {
    check.hits.push_back(sample.hidden ? EdgeHit{} : search.Find(sample.pixel, sample.normal));
  }
  Summarise(search.Chance(), options, check);
  return check;
}

std::vector<ImageCheck> CheckImages(const AnnotationImages& images, const OutlineModel& model,
                                    const Eigen::Isometry3d& scan_from_object,
                                    const Occluders& occluders, const OutlineOptions& outline,
                                    const EdgeAgreementOptions& options) {
  std::vector<ImageCheck> checks(images.images().size());
  tbb::parallel_for(std::size_t{0}, checks.size(), [&](std::size_t i) {
    checks[i] = CheckImage(images.images()[i], images.camera(), model, scan_from_object, occluders,
                           outline, options);
  });
  return checks;
}

double MeanAgreement(const std::vector<ImageCheck>& checks) {
  double sum = 0, all = 0;
  for (const ImageCheck& check : checks) {
    sum += check.visible_px * check.agreement;
    all += check.visible_px;
  }
  return all > 0 ? sum / all : 0;
}

double MedianOffset(const std::vector<ImageCheck>& checks) {
  std::vector<double> offsets;
  for (const ImageCheck& check : checks) {
    if (check.visible_px > 0) offsets.push_back(check.median_offset_px);
  }
  if (offsets.empty()) return 0;
  std::sort(offsets.begin(), offsets.end());
  return offsets[offsets.size() / 2];
}

}  // namespace plumbline
