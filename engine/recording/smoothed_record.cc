// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/smoothed_record.h"

#include <exception>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/landmark_history.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_place.h"
#include "engine/recording/sqlite.h"

namespace plumbline {
namespace {

/// docs/run_file.md explains it. Files of older versions lack it, and older versions do not look
/// for it, so the format's version stays.
constexpr const char* kSmoothedSchema = R"(
DROP TABLE IF EXISTS smoothed;
CREATE TABLE smoothed (
  object INTEGER PRIMARY KEY,
  state INTEGER NOT NULL,
  category TEXT NOT NULL,
  label INTEGER NOT NULL,
  confirmed_frame INTEGER,
  spawned_frame INTEGER NOT NULL,
  looks INTEGER NOT NULL,
  looks_before INTEGER NOT NULL,
  views INTEGER NOT NULL,
  refined INTEGER NOT NULL,
  agreement REAL NOT NULL,
  pushed_m REAL NOT NULL,
  details BLOB NOT NULL);
)";

std::string SummaryText(const SmoothedMap& map) {
  return nlohmann::json{{"version", 1},
                        {"last_frame", map.last_frame},
                        {"looks", map.looks},
                        {"floor_objects", map.floor_objects},
                        {"floor_height_m", map.floor_height_m},
                        {"floor_std_m", map.floor_std_m}}
      .dump();
}

Status Store(sqlite::Database& database, const SmoothedMap& map) {
  Status status = database.Execute(kSmoothedSchema);
  if (!status.ok()) return status;
  Result<sqlite::Statement> summary =
      database.Prepare("INSERT OR REPLACE INTO run (key, value) VALUES ('smoothed', ?1)");
  if (!summary) return summary.error();
  summary->BindText(1, SummaryText(map));
  if (status = summary->Run(); !status.ok()) return status;
  Result<sqlite::Statement> insert = database.Prepare(
      "INSERT INTO smoothed VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)");
  if (!insert) return insert.error();
  for (const SmoothedObject& object : map.objects) {
    const ObjectReport& belief = object.belief;
    const std::string details = EncodeObject(belief);
    insert->Bind(1, std::int64_t{belief.id.value});
    insert->Bind(2, static_cast<std::int64_t>(belief.state));
    insert->BindText(3, belief.category);
    insert->Bind(4, std::int64_t{belief.label.value});
    insert->BindNull(5);
    if (belief.confirmed_frame) insert->Bind(5, std::int64_t{*belief.confirmed_frame});
    insert->Bind(6, std::int64_t{object.spawned_frame});
    insert->Bind(7, std::int64_t{object.looks});
    insert->Bind(8, std::int64_t{object.looks_before});
    insert->Bind(9, std::int64_t{object.views});
    insert->Bind(10, std::int64_t{object.refined});
    insert->Bind(11, object.agreement);
    insert->Bind(12, object.pushed_m);
    insert->BindBlob(13, details);
    if (status = insert->Run(); !status.ok()) return status;
  }
  return {};
}

Error Corrupt(const std::filesystem::path& run) {
  return {ErrorCode::kCorrupt,
          "the smoothed map in " + run.string() + " is damaged; 'plumbline smooth' makes it again"};
}

Result<SmoothedObject> ReadObject(const std::filesystem::path& run, int num_models,
                                  sqlite::Statement& row) {
  const auto integer = [&](int column) { return static_cast<int>(row.Integer(column)); };
  if (!IsState(row.Integer(1))) return Corrupt(run);
  SmoothedObject object;
  ObjectReport& belief = object.belief;
  belief.id = ObjectId{integer(0)};
  belief.state = static_cast<ObjectState>(integer(1));
  belief.category = row.Text(2);
  belief.label = ModelId{integer(3)};
  if (!row.IsNull(4)) belief.confirmed_frame = integer(4);
  object.spawned_frame = integer(5);
  object.looks = integer(6);
  object.looks_before = integer(7);
  object.views = integer(8);
  object.refined = integer(9) != 0;
  object.agreement = row.Real(10);
  object.pushed_m = row.Real(11);
  belief.updated = true;
  if (!DecodeObject(row.Blob(12), belief).ok() || belief.modes.empty() ||
      !NamesModels(belief, num_models))
    return Corrupt(run);
  return object;
}

}  // namespace

Status WriteSmoothed(const std::filesystem::path& run, const SmoothedMap& map) {
  std::error_code ignored;
  if (!std::filesystem::exists(run, ignored))
    return Error{ErrorCode::kNotFound, run.string() + " does not exist; check the path"};
  const auto lock = FileLock::Acquire(run);
  if (!lock.ok()) return lock.error();
  {
    const auto reader = RunReader::Open(run);
    if (!reader.ok()) return reader.error();
    const Result<FrameReport> last = (*reader)->LastFrame();
    if (!last.ok()) return last.error();
    if (last->frame < map.last_frame) {
      return Error{ErrorCode::kInvalidInput,
                   run.string() + " is not the run that was smoothed any more; smooth it again"};
    }
  }
  const auto database = sqlite::Database::Open(run, sqlite::Access::kReadWrite);
  if (!database.ok()) return database.error();
  Status status = UseWriteAheadLog(**database);
  if (status.ok()) status = (*database)->Execute("BEGIN IMMEDIATE");
  if (status.ok()) status = Store(**database, map);
  if (status.ok()) status = (*database)->Execute("COMMIT");
  if (!status.ok()) {
    (void)(*database)->Execute("ROLLBACK");
    return status;
  }
  (void)FoldLog(**database);
  return {};
}

Result<std::optional<SmoothedMap>> ReadSmoothed(const std::filesystem::path& run) {
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return reader.error();
  const int num_models = static_cast<int>((*reader)->header().models.size());
  const auto database = sqlite::Database::OpenToRead(run);
  if (!database.ok()) return database.error();
  Result<sqlite::Statement> summary =
      (*database)->Prepare("SELECT value FROM run WHERE key = 'smoothed'");
  if (!summary) return summary.error();
  const Result<bool> any = summary->Step();
  if (!any) return any.error();
  if (!*any) return std::optional<SmoothedMap>();
  const nlohmann::json json = ParseJson(summary->Text(0));
  if (!json.is_object()) return Corrupt(run);
  SmoothedMap map;
  try {
    const nlohmann::json none = 0;
    map.last_frame = IntFromJson(json.value("last_frame", none));
    map.looks = IntFromJson(json.value("looks", none));
    map.floor_objects = IntFromJson(json.value("floor_objects", none));
    map.floor_height_m = json.value("floor_height_m", 0.0);
    map.floor_std_m = json.value("floor_std_m", 0.0);
  } catch (const std::exception&) {  // values of the wrong type, or numbers that do not fit
    return Corrupt(run);
  }
  Result<sqlite::Statement> rows = (*database)->Prepare(
      "SELECT object, state, category, label, confirmed_frame, spawned_frame, looks, looks_before, "
      "views, refined, agreement, pushed_m, details FROM smoothed ORDER BY object");
  if (!rows) return rows.error();
  while (true) {
    const Result<bool> row = rows->Step();
    if (!row) return row.error();
    if (!*row) return std::optional<SmoothedMap>(std::move(map));
    Result<SmoothedObject> object = ReadObject(run, num_models, *rows);
    if (!object.ok()) return object.error();
    map.objects.push_back(std::move(object).value());
  }
}

namespace {

/// What a smoother needs of a run. `pipeline` must outlive the task.
Result<SmoothingTask> TaskOfRun(RunReader& reader, MappingPipeline& pipeline) {
  const Result<bool> finished = reader.Finished();
  if (!finished) return finished.error();
  if (!*finished) {
    return Error{ErrorCode::kInvalidInput,
                 reader.file().string() +
                     " has not ended; finish it with 'plumbline run --resume', then smooth it"};
  }
  const auto options = OptionHistory::Read(reader);
  if (!options.ok()) return options.error();
  pipeline.SetOptions(options->newest());
  SmoothingTask task;
  task.setup = pipeline.setup();
  const auto landmarks = ReadLandmarks(reader);
  if (!landmarks.ok()) return landmarks.error();
  pipeline.LookBack(*landmarks);
  task.load = [&pipeline](int frame) { return pipeline.InputAgain(frame); };
  const Result<std::vector<RunFrame>> frames = reader.Frames();
  if (!frames) return frames.error();
  for (const RunFrame& frame : *frames) {
    if (frame.skipped) continue;
    const Result<FrameReport> report = reader.ReadFrameBrief(frame.position);
    if (!report.ok()) return report.error();
    if (report->world_from_cam)
      task.frames.push_back({frame.frame, frame.stamp_ns,
                             pipeline.PoseInTheEnd(frame.frame).value_or(*report->world_from_cam)});
  }
  const Result<std::vector<ObjectTrack>> tracks = reader.ObjectTracks();
  if (!tracks) return tracks.error();
  for (const ObjectTrack& track : *tracks) {
    Result<FrameReport> report = reader.ReadFrame(track.last_position);
    if (!report.ok()) return report.error();
    for (ObjectReport& object : report->objects) {
      if (object.id == track.id) task.objects.push_back(std::move(object));
    }
  }
  return task;
}

}  // namespace

Result<SmoothedMap> SmoothRun(const std::filesystem::path& run, MappingPipeline& pipeline,
                              const WorkContext& work) {
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return reader.error();
  const Result<SmoothingTask> task = TaskOfRun(**reader, pipeline);
  if (!task.ok()) return task.error();
  Result<SmoothedMap> map = Smooth(*task, work);
  if (!map.ok()) return map.error();
  if (Status status = WriteSmoothed(run, *map); !status.ok()) return status.error();
  return map;
}

}  // namespace plumbline
