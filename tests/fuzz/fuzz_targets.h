// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/result.h"

namespace plumbline::fuzz {

/// A reader of bytes that people bring. README.md of this folder lists them.
struct Target {
  std::string_view name;  ///< Its seeds lie in seeds/NAME.
  /// Reads the input as the program would, and what follows from it. What is wrong with the input
  /// is an error; an exception, a crash or a report of a sanitizer is a fault of the reader.
  Status (*run)(std::string_view input);
};

/// All of them, by module.
std::vector<Target> Targets();

std::span<const Target> TextTargets();        ///< engine/base, command line
std::span<const Target> DatasetTargets();     ///< engine/dataset, engine/sensor
std::span<const Target> ModelTargets();       ///< engine/models
std::span<const Target> VisionTargets();      ///< engine/vision
std::span<const Target> AnnotationTargets();  ///< engine/annotation
std::span<const Target> RunTargets();         ///< engine/recording, engine/pipeline
std::span<const Target> BatchTargets();       ///< engine/batch
std::span<const Target> NodeTargets();        ///< engine/transport, engine/nodes
std::span<const Target> SessionTargets();     ///< engine/session
std::span<const Target> WindowTargets();      ///< ui/files
/// ui/inspect; linked only where the window is built (PLUMBLINE_FUZZ_PANELS).
std::span<const Target> PanelTargets();

/// The input as a file of this name, in a folder that holds nothing else and is this process's own.
std::filesystem::path FileOf(std::string_view name, std::string_view input);

/// An input that stands for several files (see SplitFiles), in that folder.
std::filesystem::path FolderOf(std::string_view input);

/// Success or the error of a result.
template <typename T>
Status StatusOf(const Result<T>& result) {
  return result.ok() ? Status() : Status(result.error());
}

}  // namespace plumbline::fuzz
