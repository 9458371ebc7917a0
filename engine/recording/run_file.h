// SPDX-License-Identifier: Apache-2.0
#pragma once

// The run file (.plb): everything a run of the mapper did, frame by frame. docs/run_file.md
// describes it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/base/result.h"
#include "engine/mapping/event_report.h"
#include "engine/recording/run_header.h"

namespace plumbline {

struct FrameReport;
struct OwnPoses;
struct OwnPoseGrowth;

/// Writes a run file on a thread of its own, one transaction a frame: whatever ends the program,
/// every frame counted by num_written() can be read afterwards. Nobody else can write that file
/// meanwhile (FileLock). Functions may be called from one thread at a time.
class RunWriter {
 public:
  /// Writes the frames that a new run begins with, those of the run that it is a fork of.
  using WritePast = std::function<Status(RunWriter&)>;

  /// Starts a new file; an older run of that name is replaced in one step as soon as header and
  /// past are complete, any other file is not touched. An error leaves everything as it was.
  /// @param own_poses  Of a run with poses = vio, kept with it.
  /// Errors: kIo (folder missing or read-only), kInvalidInput (the file there is not a run, or is
  /// being written), those of `past`.
  static Result<std::unique_ptr<RunWriter>> Create(const std::filesystem::path& file,
                                                   const RunHeader& header,
                                                   const WritePast& past = {},
                                                   const OwnPoses* own_poses = nullptr);

  struct Resumed;
  /// Goes on with a run that was cut off (or ended). Anything behind the last complete frame is
  /// dropped. Errors: kNotFound, kCorrupt, kUnsupported; kInvalidInput if `header` differs from the
  /// stored one in what decides the result (CheckContinues), or if somebody is writing the file.
  /// @param own_poses  Of a run with poses = vio; they take the place of those in the file.
  static Result<Resumed> OpenToResume(const std::filesystem::path& file, const RunHeader& header,
                                      const OwnPoses* own_poses = nullptr);

  /// Goes on with a run whose writer died, for whoever knows that it is the same run: one of a live
  /// graph, which OpenToResume refuses. Its own poses are to be given from those on that it has.
  /// Errors: kNotFound, kCorrupt, kUnsupported; kInvalidInput if somebody is writing the file.
  static Result<Resumed> Reopen(const std::filesystem::path& file);

  /// As if closed; an error is then lost (call Close to see it).
  ~RunWriter();

  /// Hands one frame over and returns; blocks only while the queue is full. `image`, of any size,
  /// is stored 160 pixels wide; it may be empty and must not be written to afterwards. Frames come
  /// by rising number. Errors (kIo): what stopped the writer earlier; nothing was or will be
  /// written since.
  /// @param own_poses  Of a live run whose poses grow: what was found since they were last given,
  ///                   or null.
  Status Write(FrameReport report, const cv::Mat& image,
               std::shared_ptr<const OwnPoseGrowth> own_poses = {});

  /// Of a run whose sequence grew: what it has become by now, kept by Close.
  /// @param header  Its `end_frame` and `sequence_hash` take the place of those of Create.
  /// @param own_poses  As of Write.
  void SetGrown(const RunHeader& header, std::shared_ptr<const OwnPoseGrowth> own_poses);

  /// Frames safely in the file, those of a resumed run included. May be called from any thread.
  int num_written() const;

  /// Waits until everything handed over is written, notes that the run ended, and closes the file.
  /// Errors (kIo): the first thing that went wrong since Create.
  Status Close();

 private:
  class Worker;
  explicit RunWriter(std::unique_ptr<Worker> worker);
  /// @param header  Null: that of the file.
  static Result<Resumed> GoOn(const std::filesystem::path& file, const RunHeader* header,
                              const OwnPoses* own_poses);
  std::unique_ptr<Worker> worker_;
};

struct RunWriter::Resumed {
  std::unique_ptr<RunWriter> writer;
  /// The last complete frame: where the mapper goes on. Null in an empty run.
  std::shared_ptr<const FrameReport> last;
  std::size_t own_pose_images = 0, own_pose_corrections = 0;  ///< Of a live run.
};

/// A life event and when it happened.
struct RunEvent {
  int position = 0;  ///< In the file, from 0.
  int frame = 0;     ///< In the sequence.
  LifeEvent event;
};

/// One frame, as a timeline needs it.
struct RunFrame {
  int position = 0;
  int frame = 0;
  std::int64_t stamp_ns = 0;
  bool skipped = false;
};

/// What one frame cost.
struct RunTiming {
  int position = 0;
  int frame = 0;
  bool skipped = false;
  double elapsed_s = 0;  ///< Wall-clock time of the run up to the end of this frame; pauses between
                         ///< resumed parts apart.
  std::vector<StageTiming> stages;
};

/// An object's life in brief.
struct ObjectTrack {
  ObjectId id;
  std::string category;
  ModelId label;                                ///< In its last frame.
  ObjectState state = ObjectState::kTentative;  ///< In its last frame.
  int first_position = 0, last_position = 0;    ///< Where it is reported.
  int first_frame = 0, last_frame = 0;          ///< The same in frames of the sequence.
  std::optional<int> confirmed_frame;
  int frames_updated = 0;
};

/// Reads a run file, also while it is written: later calls see later frames. Use one reader per
/// thread.
class RunReader {
 public:
  /// Errors: kNotFound; kInvalidInput (not a run file); kUnsupported (made by a newer version);
  /// kCorrupt.
  static Result<std::unique_ptr<RunReader>> Open(const std::filesystem::path& file);
  ~RunReader();

  const std::filesystem::path& file() const;
  const RunHeader& header() const;

  /// Complete frames now in the file.
  Result<int> NumFrames();
  /// Whether the run ended in good order (and not: is still running, or was cut off).
  Result<bool> Finished();
  /// By position in the file, 0 .. NumFrames() - 1. Errors: kNotFound, kCorrupt.
  Result<FrameReport> ReadFrame(int position);
  /// The same without particles, which is far quicker. Errors: as ReadFrame.
  Result<FrameReport> ReadFrameBrief(int position);
  /// Errors: kNotFound in a run without frames.
  Result<FrameReport> LastFrame();
  /// BGR, 160 pixels wide; empty where none was given. Errors: kNotFound, kCorrupt.
  Result<cv::Mat> ReadThumbnail(int position);
  /// Position of the last stored frame whose number in the sequence is at most `frame`; nothing
  /// before the first.
  Result<std::optional<int>> FindFrame(int frame);

  /// Those from `first_position` on, in order: ask again with the next position to follow a running
  /// run.
  Result<std::vector<RunFrame>> Frames(int first_position = 0);
  Result<std::vector<RunEvent>> Events(int first_position = 0);
  Result<std::vector<RunTiming>> Timings(int first_position = 0);
  /// By id.
  Result<std::vector<ObjectTrack>> ObjectTracks();
  /// Poses of the visual-inertial filter that the run was made with; null unless poses = vio.
  /// Errors: kCorrupt.
  Result<std::shared_ptr<const OwnPoses>> ReadOwnPoses();

 private:
  class Implementation;
  explicit RunReader(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plumbline
