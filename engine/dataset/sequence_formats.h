// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/model_frames.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// How sure a reader is that a path is one of its own.
enum class Likeness { kNone, kPossible, kCertain };

/// How a sequence is written in another layout.
struct WriteOptions {
  std::optional<int> jpeg_quality;  ///< 1 to 100; without it images are PNGs, which lose nothing.
  ModelFrames models;               ///< That the ground truth is to pose.
};

/// What was written.
struct WrittenSequence {
  int frames = 0, skipped = 0, depth_images = 0, poses = 0;
  std::vector<std::string> warnings;  ///< What was left out and why, one sentence each.
};

/// A way to store a sequence. A new one is a file pair and a line of the table in
/// sequence_formats.cc.
struct SequenceFormat {
  std::string_view name;     ///< As the command line knows it.
  std::string_view title;    ///< As people read it.
  std::string_view expects;  ///< What is looked for, as "a folder with ..".
  /// Looks at names only; quick.
  Likeness (*probe)(const std::filesystem::path& path);
  Result<std::shared_ptr<const Sequence>> (*open)(const std::filesystem::path& path,
                                                  const SequenceOptions& options);
  /// Writes it to a new folder; null where Plumbline only reads it.
  Result<WrittenSequence> (*write)(const Sequence& sequence, const std::filesystem::path& folder,
                                   const WriteOptions& options, const WorkContext& context);
  /// The ground truth of objects that comes with it, in `world` of the opened sequence; nothing
  /// where this one has none. Null where such a data set never has. It poses the models whose
  /// frames are known; else what its mesh files become if they stand below their middle already.
  /// What is odd goes into the warnings.
  Result<std::optional<GroundTruth>> (*truth)(const Sequence& sequence, const ModelFrames& models,
                                              std::vector<std::string>& warnings);
};

std::span<const SequenceFormat> SequenceFormats();

/// The ground truth of objects that comes with an opened sequence, in whatever form its data set
/// has; nothing where there is none. Errors: those of the files.
Result<std::optional<GroundTruth>> ReadTruthOf(const Sequence& sequence,
                                               std::vector<std::string>& warnings,
                                               const ModelFrames& models = {});

/// The format whose reader is surest; of equally sure ones the first of the table. Null where none
/// knows it.
const SequenceFormat* FindSequenceFormat(const std::filesystem::path& path);

}  // namespace plumbline
