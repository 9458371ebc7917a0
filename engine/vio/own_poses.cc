// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/own_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <unordered_map>
#include <utility>

#include <Eigen/Eigenvalues>

#include "engine/base/check.h"
#include "engine/dataset/growing_recording.h"
#include "engine/geometry/angles.h"
#include "engine/vio/chi_square_gate.h"
#include "engine/vio/floor_finder.h"
#include "engine/vio/loop_closer.h"
#include "engine/vio/point_view.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr double kGateOfPlots = 0.95;
/// A stretch that began anew is somewhere near the last one. Farther than this from it, what is
/// mapped would stand twice.
constexpr double kSamePlace_m = 0.15;
/// Of a recording that grows, behind the filter: more than a minute at 300 Hz.
constexpr std::size_t kReadingsKept = 20'000;

/// Covariance of the camera's pose, in the order of PosePerturbation.
Eigen::Matrix<double, 6, 6> CamCovariance(const FilterState& state,
                                          const CalibratedMatrix& covariance) {
  const Eigen::Isometry3d world_from_body = state.inertial().pose();
  const Eigen::Vector3d cam_in_world = (world_from_body * state.body_from_cam()).translation();
  Eigen::MatrixXd to_cam = Eigen::MatrixXd::Zero(6, kCalibratedSize);
  to_cam.block<3, 3>(0, kPhi) = -Hat(cam_in_world);
  to_cam.block<3, 3>(0, kXiP).setIdentity();
  to_cam.block<3, 3>(0, kCamTranslation) = world_from_body.linear();
  to_cam.block<3, 3>(3, kPhi).setIdentity();
  to_cam.block<3, 3>(3, kCamRotation) = world_from_body.linear();
  return to_cam * covariance * to_cam.transpose();
}

double TiltStd(const CalibratedMatrix& covariance) {
  const Eigen::Matrix2d tilt = covariance.block<2, 2>(kPhi, kPhi);
  return std::sqrt(std::max(0.0, tilt.eigenvalues().real().maxCoeff()));
}

/// Of the worst axis: v = v^ + xi_v + phi x v^.
double VelocityStd(const FilterState& state, const CalibratedMatrix& covariance) {
  Eigen::Matrix<double, 3, 6> by_state;
  by_state << -Hat(state.inertial().velocity_in_world), Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d velocity =
      by_state * covariance.block<6, 6>(kPhi, kPhi) * by_state.transpose();
  return std::sqrt(std::max(0.0, velocity.diagonal().maxCoeff()));
}

template <typename... Arguments>
std::string Sentence(const char* format, Arguments... arguments) {
  char text[240];
  std::snprintf(text, sizeof(text), format, arguments...);
  return text;
}

/// Turns what the estimator did with each image into a report of it.
class Recorder {
 public:
  Recorder(const VioInput& input, const OwnPoseOptions& options)
      : input_(input), options_(options), camera_(input.camera), floor_(options) {}

  /// Says nothing yet of the next image.
  void Expect(std::int64_t stamp_ns) {
    OwnPoseReport& frame = poses.frames.emplace_back();
    frame.vio.stamp_ns = stamp_ns;
    frame.waits_for = "the image could not be read";
  }

  /// @param move  new_world_from_world: what closed loops correct this image's pose by.
  /// @param closed  What is known of the trajectory, where loops were closed that no correction
  ///                has told yet; else null. It is told with the next image that has a pose.
  /// @param epoch   Of `closed`.
  void See(const VioMoment& moment, const YawMove& move, const TrajectoryCorrection* closed,
           int epoch) {
    OwnPoseReport& frame = poses.frames.back();
    frame.waits_for.clear();
    frame.tracking_ms = moment.tracking_ms;
    frame.measured = !moment.reports.empty();
    if (frame.measured) {
      last_ = moment.reports.back();
      frame.vio = last_;
    } else {
      frame.vio = last_;
      frame.vio.stamp_ns = moment.tracked.stamp_ns;
      frame.vio.step = {};
    }
    AddReadings(moment.tracked.stamp_ns, frame);
    const auto state = frame.vio.phase == VioPhase::kTracking
                           ? moment.estimator.Predict(moment.tracked.stamp_ns)
                           : std::nullopt;
    AddTracks(moment, state, frame);
    if (state) {
      AddPose(*state, frame);
      for (const MapPoint& point : moment.points)
        frame.points_in_world.push_back(point.point_in_world.cast<float>());
      if (closed != nullptr) {
        poses.corrections.push_back({moment.image, epoch, move, closed->moves()});
        told_epoch_ = epoch;
        drift_ = Drift{frame.vio.covariance,
                       closed->CovarianceAt(frame.vio.stamp_ns, frame.vio.covariance)};
      }
      const PoseCovariance of_filter = frame.vio.covariance;
      const Eigen::Isometry3d moved = move.AsIsometry();
      MoveFrame(moved, frame);
      if (drift_) {
        const Eigen::Matrix3d turn = moved.linear();
        PoseCovariance by = PoseCovariance::Zero();
        by.topLeftCorner<3, 3>() = by.bottomRightCorner<3, 3>() = turn;
        frame.vio.covariance =
            drift_->corrected + by * (of_filter - drift_->of_filter) * by.transpose();
        frame.cam_covariance =
            MovedBy(frame.world_from_cam->translation() - frame.vio.world_from_body.translation(),
                    frame.vio.covariance);
      }
      AddFloor(moment.image, frame);
    }
    MakeSymmetric(frame);
    Judge(frame);
  }

  /// Moves all that was told to where closed loops have it, and finds the floor again there.
  void Correct(const TrajectoryCorrection& correction) {
    floor_stretch_ = ready_stretch_ = 0;
    for (std::size_t i = 0; i < poses.frames.size(); ++i) {
      OwnPoseReport& frame = poses.frames[i];
      if (!frame.world_from_cam) continue;
      const std::int64_t stamp = frame.vio.stamp_ns;
      const PoseCovariance of_body = correction.CovarianceAt(stamp, frame.vio.covariance);
      MoveFrame(correction.At(stamp, frame.vio.world_from_body.translation()), frame);
      frame.vio.covariance = of_body;
      frame.cam_covariance = MovedBy(
          frame.world_from_cam->translation() - frame.vio.world_from_body.translation(), of_body);
      MakeSymmetric(frame);
      AddFloor(static_cast<int>(i), frame);
      if (frame.ready) ready_stretch_ = frame.vio.stretch;
    }
  }

  /// @return what the last image waits for.
  std::string last_wait() const { return last_wait_; }
  bool any_ready() const { return any_ready_; }
  /// @return the epoch of the last correction that was told; 0 before any.
  int told_epoch() const { return told_epoch_; }
  OwnPoses poses;

 private:
  void AddReadings(std::int64_t image_ns, OwnPoseReport& frame) const {
    const std::int64_t stamp = image_ns + Nanoseconds(input_.imu.time_offset_s);
    const auto next = std::lower_bound(
        input_.samples.begin(), input_.samples.end(), stamp,
        [](const ImuSample& sample, std::int64_t ns) { return sample.stamp_ns < ns; });
    const ImuSample& sample = next == input_.samples.end() ? input_.samples.back() : *next;
    frame.angular_velocity_rad_s = sample.angular_velocity_rad_s;
    frame.specific_force_m_s2 = sample.specific_force_m_s2;
  }

  void AddTracks(const VioMoment& moment, const std::optional<FilterState>& state,
                 OwnPoseReport& frame) {
    std::unordered_map<std::int64_t, const StatePoint*> points;
    if (state) {
      for (const StatePoint& point : state->points()) points[point.track] = &point;
    }
    std::unordered_map<std::int64_t, int> first_seen;
    for (const TrackedPoint& point : moment.tracked.points) {
      const auto known = first_seen_.find(point.id);
      const int first = known == first_seen_.end() ? moment.image : known->second;
      first_seen.emplace(point.id, first);
      const auto ray = camera_.Unproject(point.pixel);
      if (!ray || ray->z() <= 0) continue;
      TrackReport track{point.id, input_.camera.pinhole.Project(*ray).cast<float>(),
                        moment.image - first, TrackState::kFollowed, 0};
      if (const auto found = points.find(point.id); found != points.end()) {
        const StatePoint& in_state = *found->second;
        track.state = in_state.rejected > 0 ? TrackState::kRejected : TrackState::kInState;
        track.residual_px = Residual(*state, in_state, point.pixel);
      }
      frame.tracks.push_back(track);
    }
    first_seen_ = std::move(first_seen);
  }

  float Residual(const FilterState& state, const StatePoint& point,
                 const Eigen::Vector2d& pixel) const {
    const PoseClone* anchor = state.FindClone(point.anchor);
    if (anchor == nullptr) return 0;
    const AnchoredPoint placed =
        PlacePoint(state.body_from_cam(), anchor->world_from_body, point.bearing_and_inverse_depth);
    const auto view =
        ViewPoint(camera_, state.body_from_cam(), state.inertial().pose(), placed.point_in_world);
    return view ? static_cast<float>((pixel - view->pixel).norm()) : 0;
  }

  void AddPose(const FilterState& state, OwnPoseReport& frame) const {
    const CalibratedMatrix told = state.InflatedCovariance(options_.filter.covariance_inflation);
    frame.vio.world_from_body = state.inertial().pose();
    frame.vio.velocity_in_world = state.inertial().velocity_in_world;
    frame.vio.covariance = state.PoseCovariance(options_.filter.covariance_inflation);
    frame.world_from_cam = frame.vio.world_from_body * state.body_from_cam();
    frame.cam_covariance = CamCovariance(state, told);
    frame.tilt_std_rad = TiltStd(told);
    frame.velocity_std_m_s = VelocityStd(state, told);
    if (frame.vio.step.nis_dof > 0)
      frame.nis_gate = ChiSquareGate(kGateOfPlots)(frame.vio.step.nis_dof);
  }

  void AddFloor(int image, OwnPoseReport& frame) {
    if (frame.vio.stretch != floor_stretch_) {
      floor_stretch_ = frame.vio.stretch;
      floor_.Clear();
      found_floor_.reset();
    }
    // Before the scale has settled, heights are not those of the room.
    if (ready_stretch_ == frame.vio.stretch && !frame.points_in_world.empty()) {
      for (const Eigen::Vector3f& point : frame.points_in_world)
        floor_.Add(point.cast<double>(), image);
      if (const auto found = floor_.Find(frame.world_from_cam->translation().z()))
        found_floor_ = found;
    }
    frame.floor = found_floor_;
  }

  /// To the last bit, which products of matrices are not. Run files and messages keep one half: who
  /// maps from those must have what the first run had.
  static void MakeSymmetric(OwnPoseReport& frame) {
    for (auto* covariance : {&frame.vio.covariance, &frame.cam_covariance})
      covariance->triangularView<Eigen::StrictlyLower>() = covariance->transpose().eval();
  }

  static void MoveFrame(const Eigen::Isometry3d& move, OwnPoseReport& frame) {
    if (move.matrix().isIdentity(0)) return;
    frame.vio.world_from_body = move * frame.vio.world_from_body;
    frame.vio.velocity_in_world = move.linear() * frame.vio.velocity_in_world;
    frame.world_from_cam = move * *frame.world_from_cam;
    const auto turn = [&](PoseCovariance& covariance) {
      PoseCovariance by = PoseCovariance::Zero();
      by.topLeftCorner<3, 3>() = by.bottomRightCorner<3, 3>() = move.linear();
      covariance = by * covariance * by.transpose();
    };
    turn(frame.vio.covariance);
    turn(frame.cam_covariance);
    for (Eigen::Vector3f& point : frame.points_in_world)
      point = (move * Eigen::Vector3d(point.cast<double>())).cast<float>();
  }

  /// Whether the mapper may use the pose, and if not, why.
  void Judge(OwnPoseReport& frame) {
    const VioReport& vio = frame.vio;
    if (!frame.world_from_cam) {
      frame.waits_for = vio.message.empty() ? "the filter has not started" : vio.message;
    } else if (ready_stretch_ != vio.stretch) {
      const double tilt_deg = frame.tilt_std_rad * kDegPerRad;
      const double position_m = std::sqrt(frame.cam_covariance.diagonal().head<3>().maxCoeff());
      if (tilt_deg > options_.ready_tilt_deg) {
        frame.waits_for = Sentence("waiting for gravity: known to %.2f deg, %.2f are needed",
                                   tilt_deg, options_.ready_tilt_deg);
      } else if (frame.velocity_std_m_s > options_.ready_velocity_m_s) {
        frame.waits_for = Sentence("waiting for the velocity: known to %.3f m/s, %.3f are needed",
                                   frame.velocity_std_m_s, options_.ready_velocity_m_s);
      } else if (any_ready_ && position_m > kSamePlace_m) {
        frame.waits_for = Sentence(
            "the filter was lost and began anew within %.2f m of its old world; mapping "
            "on would put objects twice",
            position_m);
      } else {
        ready_stretch_ = vio.stretch;
      }
    }
    frame.ready = frame.waits_for.empty();
    any_ready_ = any_ready_ || frame.ready;
    if (!frame.ready) last_wait_ = frame.waits_for;
  }

  const VioInput& input_;
  OwnPoseOptions options_;
  DistortedCamera camera_;
  FloorFinder floor_;
  std::optional<FloorReport> found_floor_;
  VioReport last_;
  std::unordered_map<std::int64_t, int> first_seen_;  ///< Image of each track in sight.
  /// Covariances of the body where the last loop was closed: from there on the filter's growth
  /// adds.
  struct Drift {
    PoseCovariance of_filter, corrected;
  };
  std::optional<Drift> drift_;
  int told_epoch_ = 0;
  int floor_stretch_ = 0, ready_stretch_ = 0;
  bool any_ready_ = false;
  std::string last_wait_;
};

}  // namespace

Result<VioInput> VioInputOf(const Sequence& sequence, const ImuRecording& imu) {
  const Calibration& calibration = sequence.calibration();
  const std::string name = "'" + sequence.path().string() + "'";
  if (imu.samples.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 name + " has no readings of an IMU; the filter needs imu.csv"};
  }
  VioInput input;
  input.camera = calibration.cameras.front().camera;
  if (!input.camera.body_from_cam) {
    return Error{ErrorCode::kInvalidInput,
                 name +
                     " does not say where the camera sits on the body: add 'body_from_cam' to "
                     "camera.json"};
  }
  if (calibration.imu) input.imu = *calibration.imu;
  input.samples = imu.samples;
  return input;
}

struct OwnPoseEstimator::Impl {
  Impl(std::shared_ptr<const Sequence> given, ImuRecording recorded, int count,
       const OwnPoseOptions& chosen)
      : sequence(std::move(given)),
        growing(GrowingRecordingOf(*sequence)),
        imu(std::move(recorded)),
        input(VioInputOf(*sequence, imu).value()),
        options(chosen),
        most(count),
        end(growing != nullptr ? 0 : std::min(count, sequence->num_frames())),
        recorder(input, options),
        closer(input.camera, options.closing),
        runner(input, Images(), options.filter, options.tracker) {}

  ImageSource Images() const {
    ImageSource images;
    for (int i = 0; i < end; ++i) images.stamps_ns.push_back(sequence->stamp_ns(i));
    images.read = [this](int index) { return sequence->ReadRawImage(index); };
    return images;
  }

  void See(const VioMoment& moment) {
    if (options.loops != LoopUse::kOff) closer.See(moment);
    if (options.loops != LoopUse::kCausal) {
      recorder.See(moment, {}, nullptr, 0);
      return;
    }
    LoopReport report = closer.Report();
    std::optional<TrajectoryCorrection> closed;
    if (report.epochs > recorder.told_epoch()) closed = closer.Correction();
    recorder.See(moment, closer.PresentMove(), closed ? &*closed : nullptr, report.epochs);
    recorder.poses.loops = std::move(report);
  }

  /// Waits for the next image of a recording that grows. False: it ended, or was stopped.
  bool Grow(const std::stop_token& stop) {
    const int image = runner.next();
    if (image < end) return true;
    if (image >= most || !growing->WaitForFrame(image, stop)) return false;
    const std::int64_t stamp_ns = sequence->stamp_ns(image);
    const auto more =
        growing->WaitForImu(forgotten + imu.samples.size(), runner.ImuTimeOf(stamp_ns), stop);
    if (stop.stop_requested()) return false;
    const std::size_t old =
        runner.readings_used() > 2 * kReadingsKept ? runner.readings_used() - kReadingsKept : 0;
    imu.samples.erase(imu.samples.begin(), imu.samples.begin() + static_cast<std::ptrdiff_t>(old));
    forgotten += old;
    imu.samples.insert(imu.samples.end(), more.begin(), more.end());
    input.samples = imu.samples;
    runner.Extend(stamp_ns, imu.samples, old);
    end = image + 1;
    return true;
  }

  std::shared_ptr<const Sequence> sequence;
  const GrowingRecording* growing;  ///< Null: all images are there.
  ImuRecording imu;                 ///< Of one that grows the last readings.
  std::size_t forgotten = 0;        ///< Readings before those.
  VioInput input;
  OwnPoseOptions options;
  int most;  ///< Images from this one on are not looked at.
  int end;
  Recorder recorder;
  LoopCloser closer;
  VioRunner runner;
};

OwnPoseEstimator::OwnPoseEstimator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OwnPoseEstimator::~OwnPoseEstimator() = default;

Result<std::unique_ptr<OwnPoseEstimator>> OwnPoseEstimator::Create(
    std::shared_ptr<const Sequence> sequence, int end_frame, const OwnPoseOptions& options) {
  if (!sequence->has_images()) {
    return Error{ErrorCode::kNotFound,
                 "'" + sequence->path().string() +
                     "' has no images (there is no folder color/); poses come from images and "
                     "an IMU"};
  }
  Result<ImuRecording> imu = sequence->ReadImu();
  if (!imu.ok()) return imu.error();
  if (const auto input = VioInputOf(*sequence, *imu); !input.ok()) return input.error();
  auto impl = std::make_unique<Impl>(sequence, std::move(imu).value(), end_frame, options);
  return std::unique_ptr<OwnPoseEstimator>(new OwnPoseEstimator(std::move(impl)));
}

bool OwnPoseEstimator::Next(const std::stop_token& stop) {
  Impl& m = *impl_;
  if (m.growing != nullptr && !m.Grow(stop)) return false;
  if (m.runner.next() >= m.end) return false;
  m.recorder.Expect(m.sequence->stamp_ns(m.runner.next()));
  m.runner.Next([&m](const VioMoment& moment) { m.See(moment); });
  m.runner.TakeRun();  // all of it was seen, and a recording may go on for hours
  return true;
}
int OwnPoseEstimator::next() const { return impl_->runner.next(); }
int OwnPoseEstimator::end() const { return impl_->end; }
const LoopReport& OwnPoseEstimator::loops() const { return impl_->recorder.poses.loops; }

OwnPoseReport OwnPoseEstimator::TakeReport() {
  std::vector<OwnPoseReport>& frames = impl_->recorder.poses.frames;
  OwnPoseReport report = std::move(frames.back());
  frames.pop_back();
  return report;
}

std::vector<PastCorrection> OwnPoseEstimator::TakeCorrections() {
  return std::exchange(impl_->recorder.poses.corrections, {});
}

Result<OwnPoses> OwnPoseEstimator::Finish() {
  Recorder& recorder = impl_->recorder;
  PLB_CHECK(std::ssize(recorder.poses.frames) == next()) << "reports were taken";
  if (!recorder.any_ready()) {
    return Error{
        ErrorCode::kDegenerate,
        "no image of '" + impl_->sequence->path().string() + "' got a pose that serves mapping: " +
            (recorder.last_wait().empty() ? "no image could be read" : recorder.last_wait())};
  }
  recorder.poses.loops = impl_->closer.Report();
  const TrajectoryCorrection correction = impl_->closer.Correction();
  if (impl_->options.loops == LoopUse::kCorrected && !correction.empty()) {
    recorder.poses.causal = false;
    recorder.Correct(correction);
  }
  return std::move(recorder.poses);
}

Result<OwnPoses> EstimateOwnPoses(std::shared_ptr<const Sequence> sequence, int end_frame,
                                  const OwnPoseOptions& options, const WorkContext& work) {
  const auto estimator = OwnPoseEstimator::Create(std::move(sequence), end_frame, options);
  if (!estimator.ok()) return estimator.error();
  while (!work.stop.stop_requested() && (*estimator)->Next())
    work.report({"visual-inertial", (*estimator)->next(), (*estimator)->end()});
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  return (*estimator)->Finish();
}

}  // namespace plumbline
