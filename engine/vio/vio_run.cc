// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_run.h"

#include <cstdio>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/tracking/point_tracker.h"
#include "engine/vio/imu_buffer.h"

namespace plumbline {
namespace {

/// The IMU is fed this far beyond an image: the offset of the clocks may grow.
constexpr std::int64_t kImuMarginNs = 50'000'000;

/// Feeds readings and images in the order of time.
class Feeder {
 public:
  Feeder(const VioInput& input, const VioOptions& options)
      : input_(input), estimator_(input.camera, input.imu, options) {
    if (input.start) estimator_.StartFrom(*input.start);
  }

  VioEstimator& estimator() { return estimator_; }

  void FeedImu(std::int64_t image_ns) {
    // The offset moves where a clock is found to have been set back.
    while (next_ < input_.samples.size() &&
           input_.samples[next_].stamp_ns <= estimator_.ImuTimeOf(image_ns) + kImuMarginNs)
      estimator_.AddImu(input_.samples[next_++]);
  }

  std::size_t used() const { return next_; }
  /// Of the readings the first ones were taken away, which were used.
  void Forget(std::size_t readings) {
    PLB_CHECK(readings <= next_);
    next_ -= readings;
  }

  /// @return the reports and points that it added to the run.
  std::pair<std::span<const VioReport>, std::span<const MapPoint>> FeedImage(
      const TrackedImage& image) {
    const std::size_t reports = run.reports.size(), points = run.points.size();
    for (VioReport& report : estimator_.AddImage(image)) run.reports.push_back(std::move(report));
    for (MapPoint& point : estimator_.TakePoints()) run.points.push_back(point);
    ++run.images;
    return {std::span<const VioReport>(run.reports).subspan(reports),
            std::span<const MapPoint>(run.points).subspan(points)};
  }

  VioRun run;

 private:
  const VioInput& input_;
  VioEstimator estimator_;
  std::size_t next_ = 0;
};

}  // namespace

VioRun RunVio(const VioInput& input, std::span<const TrackedImage> images,
              const VioOptions& options, const WorkContext& work) {
  VioOptions given = options;
  given.creep_px = options.given_creep_px;
  given.blur_noise = 0;
  given.covariance_inflation = 1;
  Feeder feeder(input, given);
  for (const TrackedImage& image : images) {
    if (work.stop.stop_requested()) break;
    feeder.FeedImu(image.stamp_ns);
    feeder.FeedImage(image);
    work.report({"visual-inertial", feeder.run.images, static_cast<int>(images.size())});
  }
  return std::move(feeder.run);
}

struct VioRunner::Impl {
  Impl(const VioInput& given, ImageSource source, const VioOptions& options,
       const TrackerOptions& tracker_options)
      : input(given),
        images(std::move(source)),
        feeder(input, options),
        tracker(input.camera, tracker_options) {}

  /// Errors: why the image cannot be read.
  Status See(int index, const VioObserver& seen);

  VioInput input;
  ImageSource images;
  Feeder feeder;
  PointTracker tracker;
  std::optional<std::int64_t> previous_ns;
  int next = 0;
};

Status VioRunner::Impl::See(int index, const VioObserver& seen) {
  const std::int64_t stamp_ns = images.stamps_ns[static_cast<std::size_t>(index)];
  const Result<cv::Mat> image = images.read(index);
  if (!image.ok()) return image.error();
  feeder.FeedImu(stamp_ns);
  const Eigen::Matrix3d turn =
      feeder.estimator().CamRotation(previous_ns.value_or(stamp_ns), stamp_ns);
  previous_ns = stamp_ns;
  const TrackedImage tracked = tracker.Track(*image, stamp_ns, turn);
  if (tracker.light_jump() != 1) {
    char text[80];
    std::snprintf(text, sizeof(text), "the light jumped: the image is %.2f times as bright",
                  tracker.light_jump());
    feeder.estimator().Note(text);
  }
  const double tracking_ms = tracker.cost().track_ms + tracker.cost().detect_ms;
  feeder.run.tracking_ms += tracking_ms;
  const auto [reports, points] = feeder.FeedImage(tracked);
  if (seen) seen({index, *image, tracked, reports, points, feeder.estimator(), tracking_ms});
  return {};
}

VioRunner::VioRunner(const VioInput& input, ImageSource images, const VioOptions& options,
                     const TrackerOptions& tracker)
    : impl_(std::make_unique<Impl>(input, std::move(images), options, tracker)) {}
VioRunner::~VioRunner() = default;

bool VioRunner::Next(const VioObserver& seen) {
  if (static_cast<std::size_t>(impl_->next) >= impl_->images.stamps_ns.size()) return false;
  if (Status status = impl_->See(impl_->next++, seen); !status.ok())
    impl_->feeder.run.skipped.push_back(status.error().message);
  return true;
}

void VioRunner::Extend(std::int64_t stamp_ns, std::span<const ImuSample> samples,
                       std::size_t forgotten) {
  impl_->images.stamps_ns.push_back(stamp_ns);
  impl_->input.samples = samples;
  impl_->feeder.Forget(forgotten);
}

std::int64_t VioRunner::ImuTimeOf(std::int64_t image_ns) const {
  return impl_->feeder.estimator().ImuTimeOf(image_ns);
}

int VioRunner::next() const { return impl_->next; }
std::size_t VioRunner::readings_used() const { return impl_->feeder.used(); }
VioRun VioRunner::TakeRun() { return std::exchange(impl_->feeder.run, {}); }

VioRun RunVio(const VioInput& input, const ImageSource& images, const VioOptions& options,
              const TrackerOptions& tracker, const WorkContext& work, const VioObserver& seen) {
  VioRunner runner(input, images, options, tracker);
  while (!work.stop.stop_requested() && runner.Next(seen))
    work.report({"visual-inertial", runner.next(), static_cast<int>(images.stamps_ns.size())});
  return runner.TakeRun();
}

std::vector<TrackedImage> DropTracks(std::span<const TrackedImage> images, double probability,
                                     std::uint64_t seed) {
  std::vector<TrackedImage> kept(images.begin(), images.end());
  for (TrackedImage& image : kept) {
    std::erase_if(image.points, [&](const TrackedPoint& point) {
      const auto id = static_cast<std::uint64_t>(point.id);
      return Random({seed, static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32)})
                 .Uniform() < probability;
    });
  }
  return kept;
}

}  // namespace plumbline
