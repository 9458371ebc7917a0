// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/annotation/pose_exchange.h"
#include "engine/base/progress.h"

namespace plumbline {

/// A folder with instances.json in COCO's format (images, categories by COCO's numbers, and for
/// each object that shows a box and a mask as uncompressed runs), images/NNNNNN.png, and
/// masks/NNNNNN.png: 16 bit, 0 or the `instance_number` of what shows there. Errors: kInvalidInput
/// (no sequence, no database, an instance of an unknown model), kCorrupt (a depth image), kIo,
/// kCancelled.
Status WriteCoco(const AnnotationDocument& document, const ExchangeInputs& inputs,
                 const std::filesystem::path& folder, const WorkContext& context);

/// Lengths of runs of unset and set pixels in turn, column after column, beginning with unset ones.
/// @param mask  CV_8U, 0 unset.
std::vector<int> ColumnRuns(const cv::Mat& mask);

}  // namespace plumbline
