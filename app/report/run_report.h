// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/analysis/run_review.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/snapshot/object_look.h"

namespace plumbline {

struct MapSnapshot;

/// A frame with what the mapper believed drawn into it.
struct ReportPicture {
  int frame = 0;
  cv::Mat image;  ///< CV_8UC3 BGR
};

/// The image of a frame with the outlines and names of the confirmed objects; tentative ones thin.
cv::Mat OutlinedImage(const MapSnapshot& snapshot, const SequenceView& view,
                      const ObjectLooks& looks);

/// A web page of a run that needs nothing else to be read: pictures and plots are inside.
/// @param evaluation  Against ground truth; nothing without.
std::string RunReportHtml(const RunReview& review, const std::vector<ReportPicture>& pictures,
                          const std::optional<MapEvaluation>& evaluation, const std::string& name);

}  // namespace plumbline
