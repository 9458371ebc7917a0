// SPDX-License-Identifier: Apache-2.0
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "engine/base/log.h"
#include "engine/nodes/our_nodes.h"
#include "engine/sources/recording_rig.h"
#include "engine/sources/sensor_recorder.h"

namespace plumbline {
namespace {

constexpr auto kTellPeriod = std::chrono::milliseconds(500);

/// What is told of a sensor.
struct SensorStory {
  StreamMeter& items;
  std::function<std::string()> in_words;
  bool was_there = false;  ///< Before this process began.
};

/// Lets a sensor record until it ends or the node is to end, and tells meanwhile how it goes.
Status RecordWhileServing(const NodeSetup& setup, NodeLink& link, const SensorStory& story,
                          const std::function<Status(const SensorWork&)>& record) {
  std::stop_source ended;
  const std::stop_callback outside(setup.work.stop, [&] { ended.request_stop(); });
  std::mutex mutex;
  std::string trouble;  // until something comes again
  SensorWork work;
  work.began_ns = setup.plan.recording.began_ns;
  work.joined_ns = SteadyNs();
  work.patient = story.was_there;
  work.stop = ended.get_token();
  work.tell = [&](const std::string& sentence) {
    log::warn("{}", sentence);
    const std::lock_guard lock(mutex);
    trouble = sentence;
  };
  work.came = [&] {
    story.items.Count(0);
    const std::lock_guard lock(mutex);
    trouble.clear();
  };
  Status status;
  std::jthread recording([&] {
    status = record(work);
    ended.request_stop();
  });
  std::jthread telling([&] {
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!ended.stop_requested()) {
      link.SetState(trouble.empty() ? story.in_words() : trouble);
      never.wait_for(lock, ended.get_token(), kTellPeriod, [] { return false; });
    }
  });
  link.Serve(ended.get_token(), [&](const wire::Request& request) -> Result<wire::Reply> {
    return DoesNotAnswer(request, setup.node);
  });
  recording.join();
  telling.join();
  return setup.work.stop.stop_requested() ? Status() : status;
}

}  // namespace

Status RunCameraNode(const NodeSetup& setup) {
  const std::filesystem::path& folder = setup.plan.recipe->sequence;
  const Result<RecordingRig> rig = ReadRecordingRig(folder);
  if (!rig.ok()) return rig.error();
  auto writer = RecordingWriter::Join(folder);
  if (!writer.ok()) return writer.error();
  const Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  const GraphRecording& recording = setup.plan.recording;
  CameraRecorder recorder(rig->camera, recording.lossless, **writer);
  CameraInput input{setup.node.source};
  if (recording.exposure_ms) input.exposure = Exposure{*recording.exposure_ms};
  const auto in_words = [&] {
    return std::to_string((*writer)->num_images()) + " images, " + std::to_string(recorder.gaps()) +
           " gaps";
  };
  const SensorStory story{(*link)->AddStream("images"), in_words, (*writer)->num_images() > 0};
  return RecordWhileServing(setup, **link, story,
                            [&](const SensorWork& work) { return recorder.Run(input, work); });
}

Status RunImuNode(const NodeSetup& setup) {
  auto writer = RecordingWriter::Join(setup.plan.recipe->sequence);
  if (!writer.ok()) return writer.error();
  const Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  ImuRecorder recorder(**writer, setup.plan.folder / "imu_clock.json");
  const auto in_words = [&] {
    return std::to_string(recorder.readings()) + " readings, " +
           std::to_string(recorder.not_understood()) + " lines not understood, " +
           std::to_string(recorder.not_later()) + " not later";
  };
  const SensorStory story{(*link)->AddStream("readings"), in_words, (*writer)->joined_readings()};
  return RecordWhileServing(setup, **link, story, [&](const SensorWork& work) {
    return recorder.Run(setup.node.source, work);
  });
}

}  // namespace plumbline
