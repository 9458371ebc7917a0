// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// How sure a reader is that a path is one of its own.
enum class Likeness { kNone, kPossible, kCertain };

/// A way to store a sequence. A new one is a file pair and a line of the table in
/// sequence_formats.cc.
struct SequenceFormat {
  std::string_view name;     ///< As the command line knows it.
  std::string_view title;    ///< As people read it.
  std::string_view expects;  ///< What is looked for, as "a folder with ..".
  bool written;              ///< Whether Plumbline writes it too.
  /// Looks at names only; quick.
  Likeness (*probe)(const std::filesystem::path& path);
  Result<std::shared_ptr<const Sequence>> (*open)(const std::filesystem::path& path,
                                                  const SequenceOptions& options);
};

std::span<const SequenceFormat> SequenceFormats();

/// The format whose reader is surest; of equally sure ones the first of the table. Null where none
/// knows it.
const SequenceFormat* FindSequenceFormat(const std::filesystem::path& path);

}  // namespace plumbline
