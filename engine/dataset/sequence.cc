// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sequence.h"

#include "engine/dataset/plumbline_sequence.h"

namespace plumbline {

Result<std::shared_ptr<const Sequence>> OpenSequence(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no sequence '" + path.string() + "'"};
  }
  if (!std::filesystem::exists(path / "camera.json", ignored)) {
    return Error{ErrorCode::kUnsupported,
                 "'" + path.string() +
                     "' is no sequence this version reads: a folder with camera.json and color/"};
  }
  return OpenPlumblineSequence(path);
}

}  // namespace plumbline
