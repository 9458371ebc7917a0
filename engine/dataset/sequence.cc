// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sequence.h"

#include "engine/dataset/sequence_formats.h"

namespace plumbline {

Result<std::shared_ptr<const Sequence>> OpenSequence(const std::filesystem::path& path,
                                                     const SequenceOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return Error{ErrorCode::kNotFound, "there is no sequence '" + path.string() + "'"};
  if (const SequenceFormat* format = FindSequenceFormat(path)) return format->open(path, options);
  std::string expected;
  for (const SequenceFormat& format : SequenceFormats())
    expected += (expected.empty() ? "" : ", or ") + std::string(format.expects);
  return Error{ErrorCode::kUnsupported,
               "'" + path.string() + "' is not a supported sequence; it would be " + expected};
}

int NumPosedFrames(const Sequence& sequence) {
  int posed = 0;
  for (int i = 0; i < sequence.num_frames(); ++i) posed += sequence.world_from_cam(i).has_value();
  return posed;
}

}  // namespace plumbline
