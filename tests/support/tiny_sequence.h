// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <opencv2/core.hpp>

namespace plumbline {

inline void WriteText(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

/// Writes a sequence in Plumbline's own layout with `frames` images of 64x48 (numbered from 0, 10
/// Hz, JPEG), poses along x (frame i at x = i metres), gravity and floor. `frames` with edges and
/// proposals too where asked for.
struct TinySequenceOptions {
  int frames = 5;
  bool edges = false;
  bool proposals = false;
};
void WriteTinySequence(const std::filesystem::path& folder,
                       const TinySequenceOptions& options = {});

/// 000007 for 7.
std::string FrameName(int number);

}  // namespace plumbline
