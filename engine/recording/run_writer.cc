// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/base/queue.h"
#include "engine/base/timer.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/own_pose_record.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_place.h"
#include "engine/recording/run_schema.h"
#include "engine/recording/sqlite.h"

namespace plumbline {
namespace {

constexpr int kThumbnailWidth = 160;
constexpr std::size_t kQueuedFrames = 16;

/// JPEG bytes; none for an empty image.
std::string EncodeThumbnail(const cv::Mat& image) {
  if (image.empty()) return {};
  cv::Mat small = image;
  if (image.cols != kThumbnailWidth) {
    const int height = std::max(1, image.rows * kThumbnailWidth / image.cols);
    cv::resize(image, small, {kThumbnailWidth, height}, 0, 0, cv::INTER_AREA);
  }
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 80});
  return {bytes.begin(), bytes.end()};
}

/// A header as it is read again: text that is not UTF-8 changes on the way.
RunHeader AsStored(const RunHeader& header) {
  Result<RunHeader> stored = HeaderFromJson(nlohmann::json::parse(JsonText(HeaderToJson(header))));
  return stored.ok() ? std::move(*stored) : header;
}

Status StoreHeader(sqlite::Database& database, const RunHeader& header) {
  Result<sqlite::Statement> statement = database.Prepare(
      "INSERT OR REPLACE INTO run (key, value) VALUES ('header', ?1), ('finished', '0')");
  if (!statement) return statement.error();
  statement->BindText(1, JsonText(HeaderToJson(header)));
  return statement->Run();
}

Result<std::unique_ptr<FileLock>> Lock(const std::filesystem::path& file) {
  auto lock = FileLock::Acquire(file);
  if (lock.ok()) return lock;
  const bool in_use = lock.error().code == ErrorCode::kInvalidInput;
  return Error{lock.error().code,
               lock.error().message + (in_use ? "; wait until it ends, or choose another file"
                                              : "; choose another folder")};
}

}  // namespace

/// The thread behind a RunWriter. Only the thread touches the database between Start and Close.
class RunWriter::Worker {
 public:
  /// @param file  Where the run will be; until PutInPlace it may be elsewhere.
  Worker(std::filesystem::path file, std::unique_ptr<FileLock> lock,
         std::unique_ptr<sqlite::Database> database, int position, int last_frame, double elapsed_s)
      : file_(std::move(file)),
        location_(database->location()),
        lock_(std::move(lock)),
        database_(std::move(database)),
        elapsed_before_s_(elapsed_s),
        last_frame_(last_frame),
        position_(position),
        num_written_(position) {}
  ~Worker() {
    (void)Close();
    if (beside()) (void)RemoveRun(location_);
  }

  Status Start() {
    const std::pair<sqlite::Statement&, const char*> statements[] = {
        {begin_, "BEGIN IMMEDIATE"},
        {commit_, "COMMIT"},
        {insert_frame_, "INSERT INTO frames VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)"},
        {insert_object_, "INSERT INTO objects VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)"},
        {insert_event_, "INSERT INTO events VALUES (?1, ?2, ?3, ?4, ?5, ?6)"}};
    for (const auto& [statement, sql] : statements) {
      Result<sqlite::Statement> prepared = database_->Prepare(sql);
      if (!prepared) return prepared.error();
      statement = std::move(*prepared);
    }
    queue_ = std::make_unique<BoundedQueue<Item>>(kQueuedFrames);
    thread_ = std::thread([this] { Loop(); });
    return {};
  }

  /// Begins a new run.
  Status Begin(const RunHeader& header, const OwnPoses* own_poses) {
    header_ = header;
    Status status = UseWriteAheadLog(*database_);
    if (status.ok()) status = database_->Execute("BEGIN");
    if (status.ok()) status = database_->Execute(kRunSchema);
    if (status.ok()) status = StoreHeader(*database_, header);
    if (status.ok() && own_poses != nullptr) status = StoreOwnPoses(*database_, *own_poses);
    if (status.ok()) status = database_->Execute("COMMIT");
    return status.ok() ? Start() : status;
  }

  /// Continues a run that is in place.
  Status GoOn(const RunHeader& header) {
    header_ = header;
    return Start();
  }

  /// What was written so far becomes the run of that name, and is continued there.
  Status PutInPlace() {
    Drain();
    if (const Status status = CurrentStatus(); !status.ok()) return status;
    if (const Status folded = FoldLog(*database_); !folded.ok()) return folded;
    database_.reset();
    if (const Status put = plumbline::PutInPlace(location_, file_); !put.ok()) return put;
    location_ = file_;
    auto database = sqlite::Database::Open(file_, sqlite::Access::kReadWrite);
    if (!database) return database.error();
    database_ = std::move(*database);
    if (const Status logged = UseWriteAheadLog(*database_); !logged.ok()) return logged;
    return Start();
  }

  Status Write(FrameReport report, const cv::Mat& image,
               std::shared_ptr<const OwnPoseGrowth> own_poses) {
    PLB_CHECK(report.frame > last_frame_) << "frame " << report.frame << " after " << last_frame_;
    last_frame_ = report.frame;
    const Status status = CurrentStatus();
    if (!status.ok()) return status;
    PLB_CHECK(queue_ && queue_->Push(Item{std::move(report), image,
                                          elapsed_before_s_ + watch_.Milliseconds() / 1000,
                                          std::move(own_poses)}))
        << "the run file is closed";
    return {};
  }

  void SetGrown(const RunHeader& header, std::shared_ptr<const OwnPoseGrowth> own_poses) {
    header_.end_frame = header.end_frame;
    header_.sequence_hash = header.sequence_hash;
    grown_ = std::move(own_poses);
  }

  int num_written() const { return num_written_; }

  Status Close() {
    Drain();
    if (database_) {
      Status status = CurrentStatus();
      if (status.ok() && grown_ != nullptr) SetStatus(status = StoreGrown());
      if (status.ok())
        SetStatus(database_->Execute("UPDATE run SET value = '1' WHERE key = 'finished'"));
      (void)FoldLog(*database_);
      database_.reset();
    }
    lock_.reset();
    return CurrentStatus();
  }

 private:
  struct Item {
    FrameReport report;
    cv::Mat image;
    double elapsed_s;
    std::shared_ptr<const OwnPoseGrowth> own_poses;
  };
  struct StoredParticles {
    std::shared_ptr<const std::vector<Particle>> particles;
    int position;
  };

  bool beside() const { return location_ != file_; }

  /// Waits until everything handed over is written; then the database is the caller's.
  void Drain() {
    if (queue_) queue_->Close();
    if (thread_.joinable()) thread_.join();
    for (sqlite::Statement* statement :
         {&begin_, &commit_, &insert_frame_, &insert_object_, &insert_event_}) {
      *statement = {};
    }
  }

  void Loop() {
    while (const std::optional<Item> item = queue_->Pop()) {
      if (!CurrentStatus().ok()) continue;  // so that nobody waits for room
      Status status;
      try {
        status = Store(*item);
      } catch (const std::exception& error) {
        status =
            Error{ErrorCode::kIo, "cannot record frame " + std::to_string(item->report.frame) +
                                      " in " + database_->file().string() + ": " + error.what()};
      }
      if (!status.ok()) {
        (void)database_->Execute("ROLLBACK");
        SetStatus(status);
      }
    }
  }

  Status Store(const Item& item) {
    const FrameReport& report = item.report;
    const std::string details = EncodeFrame(report);
    const std::string thumbnail = EncodeThumbnail(item.image);
    Status status = begin_.Run();
    if (status.ok()) status = StoreFrame(item, details, thumbnail);
    for (const ObjectReport& object : report.objects) {
      if (status.ok()) status = StoreObject(object);
    }
    for (std::size_t i = 0; i < report.events.size() && status.ok(); ++i) {
      status = StoreEvent(report.events[i], static_cast<int>(i));
    }
    if (status.ok() && item.own_poses != nullptr) status = AddOwnPoses(*database_, *item.own_poses);
    if (status.ok()) status = commit_.Run();
    if (!status.ok()) return status;
    Forget(report);
    ++position_;
    num_written_ = position_;
    return {};
  }

  Status StoreGrown() {
    Status status = database_->Execute("BEGIN");
    if (status.ok()) status = StoreHeader(*database_, header_);
    if (status.ok()) status = AddOwnPoses(*database_, *grown_);
    return status.ok() ? database_->Execute("COMMIT") : status;
  }

  Status StoreFrame(const Item& item, const std::string& details, const std::string& thumbnail) {
    const FrameReport& report = item.report;
    insert_frame_.Bind(1, std::int64_t{position_});
    insert_frame_.Bind(2, std::int64_t{report.frame});
    insert_frame_.Bind(3, report.stamp_ns);
    insert_frame_.BindText(4, report.skipped);
    insert_frame_.Bind(5, static_cast<std::int64_t>(report.objects.size()));
    insert_frame_.Bind(6, item.elapsed_s);
    insert_frame_.BindBlob(7, details);
    insert_frame_.BindBlob(8, thumbnail);
    return insert_frame_.Run();
  }

  Status StoreObject(const ObjectReport& object) {
    insert_object_.Bind(1, std::int64_t{position_});
    insert_object_.Bind(2, std::int64_t{object.id.value});
    insert_object_.Bind(3, static_cast<std::int64_t>(object.state));
    insert_object_.BindText(4, object.category);
    insert_object_.Bind(5, std::int64_t{object.label.value});
    insert_object_.BindNull(6);
    if (object.confirmed_frame) insert_object_.Bind(6, std::int64_t{*object.confirmed_frame});
    insert_object_.Bind(7, std::int64_t{object.updated});
    insert_object_.BindBlob(8, EncodeObject(object));
    insert_object_.BindNull(9);
    insert_object_.BindNull(10);
    if (object.particles) {
      // An object that was not weighed keeps its set: stored once, referred to afterwards.
      const auto stored = stored_.find(object.id);
      if (stored != stored_.end() && stored->second.particles == object.particles) {
        insert_object_.Bind(9, std::int64_t{stored->second.position});
      } else {
        insert_object_.Bind(9, std::int64_t{position_});
        insert_object_.BindBlob(10, EncodeParticles(*object.particles));
        stored_[object.id] = {object.particles, position_};
      }
    }
    return insert_object_.Run();
  }

  Status StoreEvent(const LifeEvent& event, int ordinal) {
    insert_event_.Bind(1, std::int64_t{position_});
    insert_event_.Bind(2, std::int64_t{ordinal});
    insert_event_.Bind(3, static_cast<std::int64_t>(event.kind));
    insert_event_.Bind(4, std::int64_t{event.object.value});
    insert_event_.Bind(5, std::int64_t{event.other.value});
    insert_event_.BindText(6, event.kind == EventKind::kOptionsChanged   ? event.option_changes
                              : event.kind == EventKind::kPosesCorrected ? event.landmarks
                                                                         : event.text);
    return insert_event_.Run();
  }

  /// Lets go of the particles of objects that are no longer reported.
  void Forget(const FrameReport& report) {
    std::erase_if(stored_, [&](const auto& entry) {
      return std::none_of(report.objects.begin(), report.objects.end(),
                          [&](const ObjectReport& object) { return object.id == entry.first; });
    });
  }

  Status CurrentStatus() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  void SetStatus(Status status) {
    const std::lock_guard lock(mutex_);
    status_ = std::move(status);
  }

  const std::filesystem::path file_;
  std::filesystem::path location_;  ///< `file_`, or beside it until the run is put in place.
  std::unique_ptr<FileLock> lock_;
  std::unique_ptr<sqlite::Database> database_;
  sqlite::Statement begin_, commit_, insert_frame_, insert_object_, insert_event_;
  std::unique_ptr<BoundedQueue<Item>> queue_;
  const double elapsed_before_s_;  // of a resumed run
  const Stopwatch watch_;
  int last_frame_;
  int position_;
  std::map<ObjectId, StoredParticles> stored_;
  RunHeader header_;
  std::shared_ptr<const OwnPoseGrowth> grown_;  ///< Null unless the sequence grew.
  std::atomic<int> num_written_;
  mutable std::mutex mutex_;
  Status status_;
  std::thread thread_;
};

Result<std::unique_ptr<RunWriter>> RunWriter::Create(const std::filesystem::path& file,
                                                     const RunHeader& header, const WritePast& past,
                                                     const OwnPoses* own_poses) {
  auto lock = Lock(file);
  if (!lock) return lock.error();
  if (const Status free = CheckReplaceable(file); !free.ok()) return free.error();
  const std::filesystem::path beside = PlaceBeside(file);
  if (const Status removed = RemoveRun(beside); !removed.ok()) return removed.error();
  auto database = sqlite::Database::Open(beside, sqlite::Access::kCreate, file);
  if (!database) return Error{ErrorCode::kIo, database.error().message};
  auto worker = std::make_unique<Worker>(file, std::move(*lock), std::move(*database), 0,
                                         std::numeric_limits<int>::min(), 0.0);
  Status status = worker->Begin(header, own_poses);
  if (!status.ok()) return Error{ErrorCode::kIo, status.error().message};
  std::unique_ptr<RunWriter> writer(new RunWriter(std::move(worker)));
  if (past) status = past(*writer);
  if (status.ok()) status = writer->worker_->PutInPlace();
  if (!status.ok()) return status.error();
  return writer;
}

namespace {

/// A run as it is found, up to its last complete frame.
struct Found {
  RunHeader header;
  std::shared_ptr<const FrameReport> last;
  int num_frames = 0;
  double elapsed_s = 0;
};

/// @param header  Null: that of the file.
Result<Found> FindEnd(const std::filesystem::path& file, const RunHeader* header) {
  Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
  if (!reader) return reader.error();
  const RunHeader& stored_header = (*reader)->header();
  if (header != nullptr) {
    if (const Status same = CheckContinues(stored_header, AsStored(*header)); !same.ok()) {
      return Error{same.error().code,
                   "cannot resume " + file.string() + ": " + same.error().message};
    }
  }
  Found found{.header = header != nullptr ? *header : stored_header};
  found.header.forked_after = (*reader)->header().forked_after;
  const Result<int> stored = (*reader)->NumFrames();
  if (!stored) return stored.error();
  for (found.num_frames = *stored; found.num_frames > 0; --found.num_frames) {
    Result<FrameReport> last = (*reader)->ReadFrame(found.num_frames - 1);
    if (!last) continue;
    found.last = std::make_shared<const FrameReport>(std::move(*last));
    break;
  }
  const Result<std::vector<RunTiming>> timings = (*reader)->Timings(found.num_frames - 1);
  if (timings && !timings->empty()) found.elapsed_s = timings->front().elapsed_s;
  return found;
}

}  // namespace

Result<RunWriter::Resumed> RunWriter::OpenToResume(const std::filesystem::path& file,
                                                   const RunHeader& header,
                                                   const OwnPoses* own_poses) {
  return GoOn(file, &header, own_poses);
}

Result<RunWriter::Resumed> RunWriter::Reopen(const std::filesystem::path& file) {
  return GoOn(file, nullptr, nullptr);
}

Result<RunWriter::Resumed> RunWriter::GoOn(const std::filesystem::path& file,
                                           const RunHeader* header, const OwnPoses* own_poses) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound, file.string() + " does not exist; check the path"};
  }
  auto lock = Lock(file);
  if (!lock) return lock.error();
  if (const Status left_over = RemoveRun(PlaceBeside(file)); !left_over.ok())
    return left_over.error();
  Result<Found> found = FindEnd(file, header);
  if (!found) return found.error();
  Result<std::unique_ptr<sqlite::Database>> database =
      sqlite::Database::Open(file, sqlite::Access::kReadWrite);
  if (!database) return database.error();
  Status status = UseWriteAheadLog(**database);
  if (status.ok()) status = (*database)->Execute("BEGIN IMMEDIATE");
  for (const char* table : {"frames", "objects", "events"}) {
    const std::string sql = std::string("DELETE FROM ") + table +
                            " WHERE position >= " + std::to_string(found->num_frames);
    if (status.ok()) status = (*database)->Execute(sql.c_str());
  }
  // What was smoothed is not this run any more once it goes on.
  if (status.ok()) {
    status = (*database)->Execute(
        "DELETE FROM run WHERE key = 'smoothed'; DROP TABLE IF EXISTS smoothed");
  }
  if (status.ok()) status = StoreHeader(**database, found->header);
  if (status.ok() && own_poses != nullptr) status = StoreOwnPoses(**database, *own_poses);
  if (status.ok()) status = (*database)->Execute("COMMIT");
  if (!status.ok()) return status.error();
  const Result<StoredOwnPoses> stored = CountOwnPoses(**database);
  if (!stored) return stored.error();
  const int last_frame = found->last ? found->last->frame : std::numeric_limits<int>::min();
  auto worker = std::make_unique<Worker>(file, std::move(*lock), std::move(*database),
                                         found->num_frames, last_frame, found->elapsed_s);
  if (const Status started = worker->GoOn(found->header); !started.ok()) return started.error();
  return Resumed{std::unique_ptr<RunWriter>(new RunWriter(std::move(worker))),
                 std::move(found->last), stored->images, stored->corrections};
}

RunWriter::RunWriter(std::unique_ptr<Worker> worker) : worker_(std::move(worker)) {}
RunWriter::~RunWriter() = default;
Status RunWriter::Write(FrameReport report, const cv::Mat& image,
                        std::shared_ptr<const OwnPoseGrowth> own_poses) {
  return worker_->Write(std::move(report), image, std::move(own_poses));
}
void RunWriter::SetGrown(const RunHeader& header, std::shared_ptr<const OwnPoseGrowth> own_poses) {
  worker_->SetGrown(header, std::move(own_poses));
}
int RunWriter::num_written() const { return worker_->num_written(); }
Status RunWriter::Close() { return worker_->Close(); }

}  // namespace plumbline
