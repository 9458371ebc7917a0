// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <opencv2/core.hpp>

namespace plumbline {

/// An ONNX network as OpenCV 4.6 can load it: weights are no inputs, nobody copies constants,
/// numbers of 16 bits are of 32, bounds of Clip and lengths of Split are attributes (as up to opset
/// 10 and 12), the decoding of boxes as YOLOv8 has it is left out, arithmetic about shapes is done,
/// and nothing follows a product of matrices at once.
/// @param bytes  Of an ONNX file.
/// @param input  [px] What a network of colour images is fed, where the file leaves it open.
std::string OnnxForOpenCv(const std::string& bytes, std::optional<cv::Size> input);

}  // namespace plumbline
