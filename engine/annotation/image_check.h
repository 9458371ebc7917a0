// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/edge_search.h"
#include "engine/annotation/outline_projection.h"

namespace plumbline {

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
/// Median of the images' medians [px]; 0 without any.
double MedianOffset(const std::vector<ImageCheck>& checks);

}  // namespace plumbline
