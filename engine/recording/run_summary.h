// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/ids.h"
#include "engine/base/result.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/mapping/event_report.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_header.h"

namespace plumbline {

struct FrameReport;
struct ObjectReport;
struct SmoothedMap;

/// The outcome of a run: what `plumbline run --json` and `export --format json` write. Fill it
/// frame by frame while the run goes on, or from its file.
class RunSummary {
 public:
  void Add(const FrameReport& report);

  /// The JSON of a run so far: frames, time, cost of each stage, and the objects that the last
  /// frame used reports (tentative and confirmed ones; those withdrawn are not listed). Lengths in
  /// metres, angles in degrees.
  /// @param seconds  Wall-clock time that the frames took.
  /// @param models   For the symmetries of what has several modes (MixtureCovariance); may be null.
  nlohmann::json ToJson(const RunHeader& header, double seconds,
                        const ModelDatabase* models = nullptr) const;

  int frames() const { return frames_; }
  int skipped() const { return skipped_; }

  /// A run that could use none of its frames has failed. Errors: kInvalidInput, with the commonest
  /// cause and what to do.
  Status CheckAnyFrameUsed(const std::string& sequence) const;

 private:
  struct Skips {
    SkipCause cause = SkipCause::kUnknown;
    std::string first_text;
    int count = 0;
  };

  friend Result<nlohmann::json> RunResultJson(RunReader& reader, const ModelDatabase* models);
  void AddTiming(bool skipped, const std::vector<StageTiming>& stages);

  int frames_ = 0;
  int skipped_ = 0;
  std::vector<std::pair<std::string, std::vector<double>>>
      stages_;                ///< In order of first appearance [ms].
  std::vector<Skips> skips_;  ///< By cause, in order of first appearance.
  /// Of the last frame that was not skipped; null before it.
  std::shared_ptr<const std::vector<ObjectReport>> objects_;
};

/// An object that was confirmed and is not there any more.
struct WithdrawnObject {
  ObjectId id;
  std::string category;
  int confirmed_frame = 0, withdrawn_frame = 0;  ///< In the sequence.
  std::optional<ObjectId> merged_into;           ///< It was that one all along.
  std::string why;
};

/// By the frame in which they were withdrawn; those of the parts before a resume or a fork, too.
/// Errors: kCorrupt.
Result<std::vector<WithdrawnObject>> ReadWithdrawn(RunReader& reader);

/// `withdrawn` of the JSON of a run.
nlohmann::json WithdrawnToJson(const std::vector<WithdrawnObject>& objects);

/// What the second pass found, as `smoothed` of the JSON above.
nlohmann::json SmoothedToJson(const SmoothedMap& map, const RunHeader& header,
                              const ModelDatabase* models = nullptr);

/// The same from a run file, with `smoothed` where the run has been smoothed. Errors: kCorrupt.
Result<nlohmann::json> RunResultJson(RunReader& reader, const ModelDatabase* models = nullptr);

/// What the map of a run holds at its end, tentative objects too, each with how likely it is there
/// (JSON older than that figure: 1 if confirmed, else 0): from a run file or, by its extension,
/// from the JSON above. Errors: kNotFound, kInvalidInput, kCorrupt, naming the file.
Result<std::vector<EstimatedObject>> ReadCandidates(const std::filesystem::path& run);

/// The same of its smoothed map; nothing where it has none.
Result<std::optional<std::vector<EstimatedObject>>> ReadSmoothedCandidates(
    const std::filesystem::path& run);

/// Those of them that are confirmed: what the map says is there.
std::vector<EstimatedObject> ConfirmedOf(std::vector<EstimatedObject> candidates);
Result<std::vector<EstimatedObject>> ReadEstimates(const std::filesystem::path& run);
Result<std::optional<std::vector<EstimatedObject>>> ReadSmoothedEstimates(
    const std::filesystem::path& run);

}  // namespace plumbline
