// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace onnx {
class ModelProto;
}

namespace plumbline {

/// Replaces arithmetic about shapes (Shape, Gather, Add, Div, Concat .. of whole numbers that are
/// known once the input's size is) by its results. torch writes it for `chunk` and `view`, and
/// OpenCV 4.6 cannot compute it. What is not known stays as it is.
void FoldShapeArithmetic(onnx::ModelProto& model);

}  // namespace plumbline
