// SPDX-License-Identifier: Apache-2.0
#include <map>

#include <opencv2/imgcodecs.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/json_text.h"
#include "engine/mapping/option_changes.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/own_pose_record.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_schema.h"
#include "engine/recording/sqlite.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {
namespace {

/// Ends the statement's read transaction, so that the writer's log can be folded into the file.
class ResetAtEnd {
 public:
  explicit ResetAtEnd(sqlite::Statement& statement) : statement_(statement) {}
  ~ResetAtEnd() { statement_.Reset(); }
  ResetAtEnd(const ResetAtEnd&) = delete;
  ResetAtEnd& operator=(const ResetAtEnd&) = delete;

 private:
  sqlite::Statement& statement_;
};

Status CheckFormat(sqlite::Database& database) {
  const Result<std::int64_t> id = database.QueryInteger("PRAGMA application_id");
  if (!id) return id.error();
  const std::string name = database.file().string();
  if (*id != kRunApplicationId) {
    return Error{ErrorCode::kInvalidInput, name + " is not a run file of Plumbline; choose a .plb"};
  }
  const Result<std::int64_t> version = database.QueryInteger("PRAGMA user_version");
  if (!version) return version.error();
  if (*version > kRunFormatVersion) {
    return Error{ErrorCode::kUnsupported, name + " was written by a newer Plumbline (run format " +
                                              std::to_string(*version) + ", this one reads up to " +
                                              std::to_string(kRunFormatVersion) +
                                              "); update this one"};
  }
  return {};
}

/// SQLite itself notices missing pages, but not a last page cut short.
Status CheckWhole(sqlite::Database& database) {
  std::error_code error;
  const std::string log = database.location().string() + "-wal";
  if (std::filesystem::exists(log, error) && std::filesystem::file_size(log, error) > 0) return {};
  const Result<std::int64_t> pages = database.QueryInteger("PRAGMA page_count");
  const Result<std::int64_t> page_size = database.QueryInteger("PRAGMA page_size");
  if (!pages) return pages.error();
  if (!page_size) return page_size.error();
  const auto size =
      static_cast<std::int64_t>(std::filesystem::file_size(database.location(), error));
  if (error || size >= *pages * *page_size) return {};
  return Error{ErrorCode::kCorrupt, database.file().string() + " is truncated or damaged (" +
                                        std::to_string(size) + " of " +
                                        std::to_string(*pages * *page_size) +
                                        " bytes are there); copy it again, or repeat the run"};
}

}  // namespace

class RunReader::Implementation {
 public:
  explicit Implementation(std::unique_ptr<sqlite::Database> database)
      : database_(std::move(database)) {}

  Status Start() {
    const std::pair<sqlite::Statement&, const char*> statements[] = {
        {header_, "SELECT value FROM run WHERE key = 'header'"},
        {finished_, "SELECT value FROM run WHERE key = 'finished'"},
        {count_, "SELECT IFNULL(MAX(position) + 1, 0) FROM frames"},
        {frame_,
         "SELECT frame, stamp_ns, skipped, num_objects, details FROM frames WHERE position = ?1"},
        {objects_,
         "SELECT object, state, category, label, confirmed_frame, weighed, details, particles_at, "
         "particles FROM objects WHERE position = ?1 ORDER BY object"},
        {brief_objects_,
         "SELECT object, state, category, label, confirmed_frame, weighed, details, NULL, NULL "
         "FROM objects WHERE position = ?1 ORDER BY object"},
        {particles_, "SELECT particles FROM objects WHERE position = ?1 AND object = ?2"},
        {frame_events_,
         "SELECT position, 0, kind, object, other, text FROM events WHERE position = ?1 ORDER BY "
         "ordinal"},
        {thumbnail_, "SELECT thumbnail FROM frames WHERE position = ?1"},
        {find_, "SELECT position FROM frames WHERE frame <= ?1 ORDER BY frame DESC LIMIT 1"},
        {frames_,
         "SELECT position, frame, stamp_ns, skipped <> '' FROM frames WHERE position >= ?1 ORDER "
         "BY position"},
        {events_,
         "SELECT position, frame, kind, object, other, text FROM events JOIN frames USING "
         "(position) "
         "WHERE position >= ?1 ORDER BY position, ordinal"},
        {timings_,
         "SELECT position, frame, skipped <> '', elapsed_s, details FROM frames WHERE position >= "
         "?1 "
         "ORDER BY position"},
        {tracks_,
         "SELECT o.object, o.category, o.label, o.state, t.first, t.last, a.frame, b.frame, "
         "o.confirmed_frame, "
         "t.weighed FROM (SELECT object, MIN(position) AS first, MAX(position) AS last, "
         "SUM(weighed) AS weighed "
         "FROM objects GROUP BY object) AS t JOIN objects AS o ON o.position = t.last AND o.object "
         "= t.object "
         "JOIN frames AS a ON a.position = t.first JOIN frames AS b ON b.position = t.last ORDER "
         "BY o.object"}};
    for (const auto& [statement, sql] : statements) {
      Result<sqlite::Statement> prepared = database_->Prepare(sql);
      if (!prepared) return prepared.error();
      statement = std::move(*prepared);
    }
    return LoadHeader();
  }

  Result<std::int64_t> QueryNumber(sqlite::Statement& statement) {
    const ResetAtEnd reset(statement);
    const Result<bool> row = statement.Step();
    if (!row) return row.error();
    if (!*row) return Corrupt("a table is empty");
    return statement.Integer(0);
  }

  Result<FrameReport> ReadFrame(int position) { return ReadFrame(position, objects_); }
  Result<FrameReport> ReadFrameBrief(int position) { return ReadFrame(position, brief_objects_); }

  Result<FrameReport> ReadFrame(int position, sqlite::Statement& objects) {
    FrameReport report;
    std::int64_t num_objects = 0;
    {
      const ResetAtEnd reset(frame_);
      frame_.Bind(1, std::int64_t{position});
      const Result<bool> row = frame_.Step();
      if (!row) return row.error();
      if (!*row) return Absent(position);
      report.frame = static_cast<int>(frame_.Integer(0));
      report.stamp_ns = frame_.Integer(1);
      report.skipped = frame_.Text(2);
      num_objects = frame_.Integer(3);
      if (const Status decoded = DecodeFrame(frame_.Blob(4), report); !decoded.ok()) {
        return Damaged(position);
      }
    }
    if (const Status status = ReadObjects(position, objects, report); !status.ok())
      return status.error();
    if (static_cast<std::int64_t>(report.objects.size()) != num_objects) return Damaged(position);
    frame_events_.Bind(1, std::int64_t{position});
    const Result<std::vector<RunEvent>> events = ReadEvents(frame_events_);
    if (!events) return events.error();
    for (const RunEvent& event : *events) report.events.push_back(event.event);
    return report;
  }

  Result<cv::Mat> ReadThumbnail(int position) {
    const ResetAtEnd reset(thumbnail_);
    thumbnail_.Bind(1, std::int64_t{position});
    const Result<bool> row = thumbnail_.Step();
    if (!row) return row.error();
    if (!*row) return Absent(position);
    const std::string_view bytes = thumbnail_.Blob(0);
    if (bytes.empty()) return cv::Mat();
    const std::vector<unsigned char> buffer(bytes.begin(), bytes.end());
    cv::Mat image = cv::imdecode(buffer, cv::IMREAD_COLOR);
    if (image.empty()) return Damaged(position);
    return image;
  }

  Result<std::optional<int>> FindFrame(int frame) {
    const ResetAtEnd reset(find_);
    find_.Bind(1, std::int64_t{frame});
    const Result<bool> row = find_.Step();
    if (!row) return row.error();
    if (!*row) return std::optional<int>();
    return std::optional<int>(static_cast<int>(find_.Integer(0)));
  }

  Result<std::vector<RunFrame>> Frames(int first_position) {
    const ResetAtEnd reset(frames_);
    frames_.Bind(1, std::int64_t{first_position});
    std::vector<RunFrame> frames;
    while (true) {
      const Result<bool> row = frames_.Step();
      if (!row) return row.error();
      if (!*row) return frames;
      frames.push_back({static_cast<int>(frames_.Integer(0)), static_cast<int>(frames_.Integer(1)),
                        frames_.Integer(2), frames_.Integer(3) != 0});
    }
  }

  Result<std::vector<RunEvent>> Events(int first_position) {
    events_.Bind(1, std::int64_t{first_position});
    return ReadEvents(events_);
  }

  Result<std::vector<RunTiming>> Timings(int first_position) {
    const ResetAtEnd reset(timings_);
    timings_.Bind(1, std::int64_t{first_position});
    std::vector<RunTiming> timings;
    while (true) {
      const Result<bool> row = timings_.Step();
      if (!row) return row.error();
      if (!*row) return timings;
      const int position = static_cast<int>(timings_.Integer(0));
      FrameReport report;
      if (const Status decoded = DecodeFrame(timings_.Blob(4), report); !decoded.ok())
        return Damaged(position);
      timings.push_back({position, static_cast<int>(timings_.Integer(1)), timings_.Integer(2) != 0,
                         timings_.Real(3), std::move(report.timings)});
    }
  }

  Result<std::vector<ObjectTrack>> Tracks() {
    const ResetAtEnd reset(tracks_);
    std::vector<ObjectTrack> tracks;
    const auto integer = [&](int column) { return static_cast<int>(tracks_.Integer(column)); };
    while (true) {
      const Result<bool> row = tracks_.Step();
      if (!row) return row.error();
      if (!*row) return tracks;
      ObjectTrack& track = tracks.emplace_back();
      track.id = {integer(0)};
      track.category = tracks_.Text(1);
      track.label = {integer(2)};
      if (integer(2) < 0 || integer(2) >= NumModels() || !IsState(integer(3)))
        return Corrupt("an object of a state or a model that is not known");
      track.state = static_cast<ObjectState>(integer(3));
      track.first_position = integer(4);
      track.last_position = integer(5);
      track.first_frame = integer(6);
      track.last_frame = integer(7);
      if (!tracks_.IsNull(8)) track.confirmed_frame = integer(8);
      track.frames_updated = integer(9);
    }
  }

  sqlite::Database& database() { return *database_; }
  const RunHeader& header() const { return run_header_; }
  sqlite::Statement& count() { return count_; }
  sqlite::Statement& finished() { return finished_; }

 private:
  Status LoadHeader() {
    const ResetAtEnd reset(header_);
    const Result<bool> row = header_.Step();
    if (!row) return row.error();
    if (!*row) return Corrupt("it has no header");
    const nlohmann::json json = ParseJson(header_.Text(0));
    Result<RunHeader> header = HeaderFromJson(json);
    if (!header) return Corrupt(header.error().message);
    run_header_ = std::move(*header);
    return {};
  }

  Status ReadObjects(int position, sqlite::Statement& rows, FrameReport& report) {
    const ResetAtEnd reset(rows);
    rows.Bind(1, std::int64_t{position});
    while (true) {
      const Result<bool> row = rows.Step();
      if (!row) return row.error();
      if (!*row) return {};
      ObjectReport object;
      if (!IsState(rows.Integer(1))) return Damaged(position);
      object.id = {static_cast<std::int32_t>(rows.Integer(0))};
      object.state = static_cast<ObjectState>(rows.Integer(1));
      object.category = rows.Text(2);
      object.label = {static_cast<std::int32_t>(rows.Integer(3))};
      if (!rows.IsNull(4)) object.confirmed_frame = static_cast<int>(rows.Integer(4));
      object.updated = rows.Integer(5) != 0;
      if (!DecodeObject(rows.Blob(6), object).ok() || !NamesModels(object, NumModels()))
        return Damaged(position);
      if (!rows.IsNull(7)) {
        const int at = static_cast<int>(rows.Integer(7));
        Result<std::vector<Particle>> particles =
            at == position ? DecodeParticles(rows.Blob(8)) : ReadParticles(at, object.id);
        if (!particles || !NameModels(*particles, NumModels())) return Damaged(position);
        object.particles = std::make_shared<const std::vector<Particle>>(std::move(*particles));
      }
      report.objects.push_back(std::move(object));
    }
  }

  /// Of an object that was not weighed since `position`.
  Result<std::vector<Particle>> ReadParticles(int position, ObjectId object) {
    const ResetAtEnd reset(particles_);
    particles_.Bind(1, std::int64_t{position});
    particles_.Bind(2, std::int64_t{object.value});
    const Result<bool> row = particles_.Step();
    if (!row) return row.error();
    if (!*row) return Damaged(position);
    return DecodeParticles(particles_.Blob(0));
  }

  Result<std::vector<RunEvent>> ReadEvents(sqlite::Statement& statement) {
    const ResetAtEnd reset(statement);
    std::vector<RunEvent> events;
    const auto integer = [&](int column) { return static_cast<int>(statement.Integer(column)); };
    while (true) {
      const Result<bool> row = statement.Step();
      if (!row) return row.error();
      if (!*row) return events;
      if (integer(2) < 0 || integer(2) > static_cast<int>(EventKind::kPosesCorrected))
        return Corrupt("an event of a kind that is not known");
      LifeEvent event{static_cast<EventKind>(integer(2)), {integer(3)}, {integer(4)},
                      std::string(statement.Text(5)),     {},           {}};
      if (event.kind == EventKind::kOptionsChanged) {
        Result<std::string> changes =
            event.text.starts_with('{') ? event.text : OptionChangesFromFormat1(event.text);
        if (!changes.ok()) return Corrupt(changes.error().message);
        event.option_changes = std::move(changes).value();
        event.text = DescribeOptionChanges(event.option_changes);
      }
      if (event.kind == EventKind::kPosesCorrected) {
        const auto edges = LandmarkEdgesFromText(event.text);
        if (!edges.ok()) return Corrupt(edges.error().message);
        event.landmarks = std::move(event.text);
        event.text = DescribeLandmarkEdges(*edges);
      }
      events.push_back({integer(0), integer(1), std::move(event)});
    }
  }

  Error Corrupt(const std::string& what) const {
    return {ErrorCode::kCorrupt,
            database_->file().string() + " is damaged: " + what + "; repeat the run"};
  }
  int NumModels() const { return static_cast<int>(run_header_.models.size()); }

  Error Damaged(int position) const {
    return {ErrorCode::kCorrupt, database_->file().string() + ": the frame at position " +
                                     std::to_string(position) +
                                     " is damaged; repeat the run from there"};
  }
  Error Absent(int position) const {
    return {ErrorCode::kNotFound,
            database_->file().string() + " has no frame at position " + std::to_string(position)};
  }

  std::unique_ptr<sqlite::Database> database_;
  RunHeader run_header_;
  sqlite::Statement header_, finished_, count_, frame_, objects_, brief_objects_, particles_,
      frame_events_, thumbnail_, find_, frames_, events_, timings_, tracks_;
};

Result<std::unique_ptr<RunReader>> RunReader::Open(const std::filesystem::path& file) {
  // Only SQLite may open the file: closing any other descriptor of it would drop the locks of a
  // writer in this process.
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    return Error{ErrorCode::kNotFound, file.string() + " does not exist; check the path"};
  }
  if (!std::filesystem::is_regular_file(file, error)) {
    return Error{ErrorCode::kInvalidInput,
                 file.string() + " is not a run file of Plumbline; choose a .plb"};
  }
  FileLock::RemoveStale(file);
  Result<std::unique_ptr<sqlite::Database>> database = sqlite::Database::OpenToRead(file);
  if (!database) return database.error();
  if (const Status format = CheckFormat(**database); !format.ok()) return format.error();
  if (const Status whole = CheckWhole(**database); !whole.ok()) return whole.error();
  auto implementation = std::make_unique<Implementation>(std::move(*database));
  if (const Status started = implementation->Start(); !started.ok()) return started.error();
  return std::unique_ptr<RunReader>(new RunReader(std::move(implementation)));
}

RunReader::RunReader(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
RunReader::~RunReader() = default;

const std::filesystem::path& RunReader::file() const { return implementation_->database().file(); }
const RunHeader& RunReader::header() const { return implementation_->header(); }

Result<int> RunReader::NumFrames() {
  const Result<std::int64_t> count = implementation_->QueryNumber(implementation_->count());
  if (!count) return count.error();
  return static_cast<int>(*count);
}

Result<bool> RunReader::Finished() {
  const Result<std::int64_t> finished = implementation_->QueryNumber(implementation_->finished());
  if (!finished) return finished.error();
  return *finished != 0;
}

Result<FrameReport> RunReader::ReadFrame(int position) {
  return implementation_->ReadFrame(position);
}

Result<FrameReport> RunReader::ReadFrameBrief(int position) {
  return implementation_->ReadFrameBrief(position);
}

Result<FrameReport> RunReader::LastFrame() {
  const Result<int> count = NumFrames();
  if (!count) return count.error();
  if (*count == 0) return Error{ErrorCode::kNotFound, file().string() + " has no frames yet"};
  return ReadFrame(*count - 1);
}

Result<cv::Mat> RunReader::ReadThumbnail(int position) {
  return implementation_->ReadThumbnail(position);
}
Result<std::optional<int>> RunReader::FindFrame(int frame) {
  return implementation_->FindFrame(frame);
}
Result<std::vector<RunFrame>> RunReader::Frames(int first_position) {
  return implementation_->Frames(first_position);
}
Result<std::vector<RunEvent>> RunReader::Events(int first_position) {
  return implementation_->Events(first_position);
}
Result<std::vector<RunTiming>> RunReader::Timings(int first_position) {
  return implementation_->Timings(first_position);
}
Result<std::vector<ObjectTrack>> RunReader::ObjectTracks() { return implementation_->Tracks(); }
Result<std::shared_ptr<const OwnPoses>> RunReader::ReadOwnPoses() {
  return LoadOwnPoses(implementation_->database());
}

}  // namespace plumbline
