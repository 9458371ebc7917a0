// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace onnx {
class GraphProto;
}

namespace plumbline {

/// Cuts a network that ends as YOLOv8 does (also 9, 10, 11 and 26, with masks or boxes chosen
/// at the end) after its last convolutions. It then gives two outputs instead of all it had:
///
///   [1, cells, 4, bins]    distances from the middle of each cell to the sides of its box (left,
///                          top, right, bottom), as logits over whole strides; of one bin, in
///                          strides
///   [1, cells, categories] scores, 0 to 1
///
/// level after level, row after row. What is left out, OpenCV 4.6 cannot run, and is a few lines of
/// ours (distance_heads.h). False, and nothing changes, where the network ends otherwise.
bool LeaveOutBoxDecoding(onnx::GraphProto& graph);

}  // namespace plumbline
