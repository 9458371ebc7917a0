// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// One line of `plumbline info`.
struct InfoLine {
  std::string label, text;
};

/// What something is: one screen for people, the same for machines.
struct PathInfo {
  std::string title;  ///< What it is and how it is stored.
  std::vector<InfoLine> lines;
  std::vector<std::string> odd;  ///< What the user should know before using it, a sentence each.
  nlohmann::json json = nlohmann::json::object();
};

/// Something that `plumbline info` knows. A new kind is a probe and a description, and a line of
/// the table in path_info.cc.
struct KnownPath {
  std::string_view name;     ///< "kind" in JSON.
  std::string_view expects;  ///< As "a sequence"; for messages.
  Likeness (*probe)(const std::filesystem::path& path);
  Result<PathInfo> (*describe)(const std::filesystem::path& path);
};

std::span<const KnownPath> PathKinds();

/// Errors: kNotFound; kUnsupported where no kind fits; kCorrupt and others of what it is.
Result<PathInfo> DescribePath(const std::filesystem::path& path);

// One pair a kind.
Likeness ProbeSequence(const std::filesystem::path& path);
Result<PathInfo> DescribeSequence(const std::filesystem::path& path);
Likeness ProbeRun(const std::filesystem::path& path);
Result<PathInfo> DescribeRun(const std::filesystem::path& path);
Likeness ProbeModels(const std::filesystem::path& path);
Result<PathInfo> DescribeModels(const std::filesystem::path& path);
Likeness ProbeProject(const std::filesystem::path& path);
Result<PathInfo> DescribeProject(const std::filesystem::path& path);
Likeness ProbeNetwork(const std::filesystem::path& path);
Result<PathInfo> DescribeNetwork(const std::filesystem::path& path);
Likeness ProbeTrajectory(const std::filesystem::path& path);
Result<PathInfo> DescribeTrajectory(const std::filesystem::path& path);
Likeness ProbeMesh(const std::filesystem::path& path);
Result<PathInfo> DescribeMesh(const std::filesystem::path& path);

}  // namespace plumbline
