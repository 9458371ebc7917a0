// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/image_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>

namespace plumbline {
namespace {

/// Looks for edges along the normals of an outline.
class EdgeSearch {
 public:
  EdgeSearch(const EdgeMap& edges, const EdgeAgreementOptions& options)
      : edges_(edges), options_(options) {
    const double scale = edges.probability.cols / 640.0;
    reach_ = static_cast<float>(options.search_px * scale);
    sigma_ = static_cast<float>(options.sigma_px * scale);
    for (int p = 0; p < 256; ++p) {
      strength_[p] = static_cast<float>(std::min(1.0, p / (255.0 * options.certain_probability)));
    }
  }

  EdgeHit Find(const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal) const {
    const int steps = static_cast<int>(std::ceil(reach_));
    EdgeHit best;
    for (int i = -steps; i <= steps; ++i) {
      // Edges are one pixel wide: the two pixels that the line passes between, so that none of a
      // slanting edge is missed.
      const Eigen::Vector2f at = pixel + static_cast<float>(i) * normal;
      const bool flat = std::abs(normal.x()) > std::abs(normal.y());
      const int x = static_cast<int>(flat ? std::lround(at.x()) : std::floor(at.x()));
      const int y = static_cast<int>(flat ? std::floor(at.y()) : std::lround(at.y()));
      Consider(x, y, pixel, normal, best);
      Consider(flat ? x : x + 1, flat ? y + 1 : y, pixel, normal, best);
    }
    return best;
  }

  /// Mean strength that a line anywhere in the image would find.
  double Chance() const {
    constexpr int kAcross = 24, kDown = 16, kDirections = 2;
    double sum = 0;
    for (int i = 0; i < kAcross * kDown * kDirections; ++i) {
      const int cell = i / kDirections;
      const double angle = std::numbers::pi * (i % kDirections) / kDirections +
                           std::numbers::pi * (cell % 7) / (7 * kDirections);
      const Eigen::Vector2f pixel(
          static_cast<float>(edges_.probability.cols * (cell % kAcross + 0.5) / kAcross),
          static_cast<float>(edges_.probability.rows * (cell / kAcross + 0.5) / kDown));
      sum += Find(pixel, {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))})
                 .strength;
    }
    return sum / (kAcross * kDown * kDirections);
  }

 private:
  void Consider(int x, int y, const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal,
                EdgeHit& best) const {
    if (x < 0 || y < 0 || x >= edges_.probability.cols || y >= edges_.probability.rows) return;
    const int probability = edges_.probability.at<std::uint8_t>(y, x);
    if (probability == 0) return;
    const float offset =
        normal.dot(Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - pixel);
    if (std::abs(offset) > reach_) return;
    const float strength =
        strength_[probability] * std::exp(-0.5f * offset * offset / (sigma_ * sigma_));
    if (strength <= best.strength) return;
    const float angle =
        edges_.angle.at<std::uint8_t>(y, x) * static_cast<float>(std::numbers::pi / 256);
    if (std::abs(normal.x() * std::cos(angle) + normal.y() * std::sin(angle)) <
        static_cast<float>(options_.min_agreement)) {
      return;
    }
    best = {offset, strength};
  }

  const EdgeMap& edges_;
  const EdgeAgreementOptions& options_;
  float reach_, sigma_;
  float strength_[256];
};

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

}  // namespace plumbline
