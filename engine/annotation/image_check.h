// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/outline_projection.h"

namespace plumbline {

struct EdgeAgreementOptions {
  double search_px = 8;  ///< Along the normal, each way, in an image 640 wide (in proportion).
  double sigma_px = 2;   ///< An edge at distance d counts exp(-d^2 / (2 sigma^2)); likewise.
  double min_agreement = 0.9;         ///< |cos| between the line's normal and the edge's.
  double certain_probability = 0.25;  ///< An edge of this probability or more counts in full.
  double crease_weight = 0.5;         ///< Of a length of crease beside the same length of contour.
};

/// The image's edge that a sample of the outline meets.
struct EdgeHit {
  float offset_px = 0;  ///< From the sample along its normal.
  float strength = 0;   ///< 0 .. 1, less the farther; 0: there is no edge in reach.
};

/// How a posed model lies in one image.
struct ImageCheck {
  int frame = 0;
  ModelOutline outline;
  std::vector<EdgeHit> hits;    ///< Of each sample of the outline; nothing where it is hidden.
  double agreement = 0;         ///< [0, 1]: share of the visible outline on edges, beyond chance.
  double median_offset_px = 0;  ///< Of |offset| where there is a hit.
  double visible_px = 0;        ///< Length of the visible outline.
};

/// Compares one image: a few milliseconds on one core, so that it can follow a drag. Safe to call
/// from several threads.
ImageCheck CheckImage(const AnnotationImage& image, const PinholeCamera& camera,
                      const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
                      const Occluders& occluders, const OutlineOptions& outline = {},
                      const EdgeAgreementOptions& options = {});

/// All images on all cores, in their order.
std::vector<ImageCheck> CheckImages(const AnnotationImages& images, const OutlineModel& model,
                                    const Eigen::Isometry3d& scan_from_object,
                                    const Occluders& occluders, const OutlineOptions& outline = {},
                                    const EdgeAgreementOptions& options = {});

/// Mean agreement, weighted by visible length; 0 without any.
double MeanAgreement(const std::vector<ImageCheck>& checks);

}  // namespace plumbline
