// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// The fields of a panel for numbers. What is typed into one counts once, when the field is left:
/// by Enter, by Tab or by a click elsewhere. Esc does not count, nor does the number that was
/// there, as it was shown, nor what is no number.
class NumberFields {
 public:
  /// The number, in the frame in which the field was left.
  std::optional<double> Draw(const FrameContext& context, const std::string& name, double value,
                             const char* format, const char* tooltip);

 private:
  std::string name_;  ///< Of the field that is being typed into.
  double typed_ = 0;
};

}  // namespace plumbline
