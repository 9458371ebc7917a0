// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/annotation/pose_exchange.h"

namespace plumbline {

/// How one object shows in a frame, counted as BOP counts it (docs/exports.md).
struct InstanceMask {
  int px_all = 0;    ///< Of its silhouette alone, also beyond the image.
  cv::Rect box_all;  ///< Around these, in pixels of the image; empty: none.
  int px_valid = 0;  ///< Of `mask`, those with a measured depth.
  cv::Mat mask;      ///< CV_8U as large as the image: 255 on its silhouette, hidden or not.
  cv::Mat visible;   ///< CV_8U: 255 where it shows.
};

struct FrameMasks {
  std::vector<InstanceMask> instances;  ///< In the document's order.
  /// CV_16U: place in the document + 1 of what shows there, the nearest where `visible` are
  /// several; 0: none.
  cv::Mat shown;
};

/// Silhouettes are drawn on a canvas of three times the image's width and height about it.
/// @param depth  CV_16U [mm], 0 where nothing was measured, as of Sequence::ReadDepth: an object
///               shows where it is at most 15 mm behind what was measured, or nothing was. Empty:
///               it shows where no other object of the document is nearer.
/// Every model must be in `models`.
FrameMasks MasksOfFrame(const AnnotationDocument& document, const ModelDatabase& models,
                        const PinholeCamera& camera, const Eigen::Isometry3d& scan_from_cam,
                        const cv::Mat& depth);

/// Places in the database of the models that the document uses. Errors: kInvalidInput (no sequence,
/// no database, an instance of an unknown model); `format` begins the sentence.
Result<std::set<int>> UsedModels(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 const char* format);

/// `FrameMasks::shown` of a frame of the sequence, by its depth where it has any: what exports hold
/// of it. Errors: those of UsedModels; kNotFound for a frame without a pose; kCorrupt.
Result<cv::Mat> VisibleInstances(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 int frame);

/// The depth of a frame, empty where it has none. Errors: kCorrupt.
Result<cv::Mat> DepthOrNothing(const Sequence& sequence, int frame);

}  // namespace plumbline
