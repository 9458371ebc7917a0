// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/vision/network_sidecar.h"
#include "engine/vision/onnx_file.h"

namespace plumbline {

/// What a network without a sidecar seems to be.
struct NetworkGuess {
  NetworkSidecar sidecar;
  /// Why, one sentence each: what the file says, what the shapes say, what is only usual.
  std::vector<std::string> reasons;
};

/// From the shapes of inputs and outputs (the network is run once on a grey image), and from what
/// the exporter noted in the file. @param categories  Names where the user gives them, else empty.
/// Errors: kUnsupported (not one of the known forms; with the shapes), kInvalidInput (names are
/// missing, or not as many as the network has), kNotFound, kCorrupt.
Result<NetworkGuess> GuessSidecar(const std::filesystem::path& onnx_file,
                                  const std::vector<std::string>& categories = {});

}  // namespace plumbline
