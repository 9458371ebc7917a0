// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// A command of the program. `add` declares its options on a subcommand and, when that is chosen on
/// the command line, stores into `chosen` what to run. An error's sentence goes to standard error
/// and the exit code is 1 (usage: 2).
using VerbFunction = std::function<Status()>;
struct Verb {
  void (*add)(CLI::App& app, VerbFunction& chosen);
};

// One function per command, each in a file of its own; listed in main.cc.
void AddDetectVerb(CLI::App& app, VerbFunction& chosen);
void AddEdgesVerb(CLI::App& app, VerbFunction& chosen);
void AddBatchVerb(CLI::App& app, VerbFunction& chosen);
void AddConvertVerb(CLI::App& app, VerbFunction& chosen);
void AddInfoVerb(CLI::App& app, VerbFunction& chosen);
void AddModelsVerb(CLI::App& app, VerbFunction& chosen);
void AddSynthVerb(CLI::App& app, VerbFunction& chosen);
void AddAlignVerb(CLI::App& app, VerbFunction& chosen);
void AddAnnotateVerb(CLI::App& app, VerbFunction& chosen);
void AddGravityVerb(CLI::App& app, VerbFunction& chosen);
void AddEvaluateVerb(CLI::App& app, VerbFunction& chosen);
void AddExportVerb(CLI::App& app, VerbFunction& chosen);
void AddRecordVerb(CLI::App& app, VerbFunction& chosen);
void AddReportVerb(CLI::App& app, VerbFunction& chosen);
void AddCompareVerb(CLI::App& app, VerbFunction& chosen);
void AddRenderVerb(CLI::App& app, VerbFunction& chosen);
void AddGuiVerb(CLI::App& app, VerbFunction& chosen);
void AddRunVerb(CLI::App& app, VerbFunction& chosen);
void AddSmoothVerb(CLI::App& app, VerbFunction& chosen);
void AddVioVerb(CLI::App& app, VerbFunction& chosen);
void AddCalibrateVerb(CLI::App& app, VerbFunction& chosen);
void AddNetworksVerb(CLI::App& app, VerbFunction& chosen);
void AddDemoVerb(CLI::App& app, VerbFunction& chosen);
void AddUpVerb(CLI::App& app, VerbFunction& chosen);
void AddNodeVerb(CLI::App& app, VerbFunction& chosen);
void AddGraphVerb(CLI::App& app, VerbFunction& chosen);
void AddKeysVerb(CLI::App& app, VerbFunction& chosen);

/// Says on standard error what was odd in what was read.
void Warn(const std::vector<std::string>& warnings);

/// The file of this program, which starts itself as other processes. Errors: kIo.
Result<std::filesystem::path> ThisProgram();

/// Writes results for machines: to standard output for "-".
Status WriteJsonResult(const std::string& file, const nlohmann::json& json);

}  // namespace plumbline
