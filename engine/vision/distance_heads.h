// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/vision/detector_cells.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// Whether the outputs are [1, cells, 4, bins] and [1, cells, categories], in any order: what
/// LeaveOutBoxDecoding makes of YOLOv8 and its followers.
bool AreCellsAndSides(const std::vector<cv::Mat>& outputs);

/// Generalised focal loss: scores per category, and the distance of each side from the cell's
/// point as logits over whole strides; of one bin, the distance itself. Either as above; or both
/// for all cells in one table, [1, cells, categories + 4 * bins]; or for each level two tensors,
/// [1, cells, categories] and [1, cells, 4 * bins], told apart by their last axis.
/// @param point_in_cell  Where distances start, in strides from the cell's corner.
/// @return false if the outputs are not of these shapes.
bool DecodeDistances(const std::vector<cv::Mat>& outputs, const NetworkSidecar& sidecar,
                     float point_in_cell, Cells& cells);

}  // namespace plumbline
