// SPDX-License-Identifier: Apache-2.0
// Parses the command line, runs the chosen command and turns errors into exit codes: 1 failure, 2
// usage.

#include <exception>
#include <iostream>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/verbs/verb.h"
#include "engine/base/data_paths.h"

namespace {

/// What is stored as JSON must be.
bool IsUtf8(const char* text) {
  try {
    nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

}  // namespace

int main(int argc, char** argv) {
  using plumbline::Verb;
  const std::vector<Verb> kVerbs = {
      // one line each, in the order of --help
      {plumbline::AddGuiVerb},    {plumbline::AddDemoVerb},      {plumbline::AddRunVerb},
      {plumbline::AddDetectVerb}, {plumbline::AddEdgesVerb},     {plumbline::AddModelsVerb},
      {plumbline::AddSynthVerb},  {plumbline::AddEvaluateVerb},  {plumbline::AddGravityVerb},
      {plumbline::AddAlignVerb},  {plumbline::AddAnnotateVerb},  {plumbline::AddExportVerb},
      {plumbline::AddInfoVerb},   {plumbline::AddConvertVerb},   {plumbline::AddRenderVerb},
      {plumbline::AddReportVerb}, {plumbline::AddCompareVerb},   {plumbline::AddSmoothVerb},
      {plumbline::AddVioVerb},    {plumbline::AddCalibrateVerb}, {plumbline::AddNetworksVerb},
      {plumbline::AddBatchVerb},  {plumbline::AddUpVerb},        {plumbline::AddGraphVerb},
      {plumbline::AddNodeVerb},   {plumbline::AddKeysVerb},      {plumbline::AddRecordVerb},
  };
  CLI::App app("Plumbline maps objects from video with camera poses and gravity, and shows why.",
               "plumbline");
  app.set_version_flag("--version", PLUMBLINE_VERSION);
  app.require_subcommand(1);
  // Of every command, so that it may stand before or behind it.
  app.fallthrough();
  app.add_flag_callback("--allow-outside", plumbline::AllowOutside,
                        "Names in data files (models.json, data.csv) may lead out of their folder");
  app.get_formatter()->column_width(34);
  plumbline::VerbFunction chosen;
  for (const Verb& verb : kVerbs) verb.add(app, chosen);
  for (int i = 1; i < argc; ++i) {
    if (IsUtf8(argv[i])) continue;
    std::cerr << "plumbline: argument " << i
              << " is not UTF-8 text; rename the file, or write it in UTF-8\n";
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  try {
    const plumbline::Status status = chosen();
    if (status.ok()) return 0;
    std::cerr << "plumbline: " << status.error().message << std::endl;
  } catch (const std::exception& error) {
    std::cerr << "plumbline: this is a bug in Plumbline: " << error.what() << std::endl;
  }
  return 1;
}
