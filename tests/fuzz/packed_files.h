// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumbline::fuzz {

/// One of the files of an input.
struct PackedFile {
  std::string name;  ///< Relative, below the folder of the input.
  std::string content;
};

/// The files of a text in which each begins below a line `==> NAME <==`, as head(1) prints several.
/// What comes before the first such line is nobody's; names that leave the folder are passed over.
std::vector<PackedFile> SplitFiles(std::string_view input);

std::string JoinFiles(const std::vector<PackedFile>& files);

}  // namespace plumbline::fuzz
