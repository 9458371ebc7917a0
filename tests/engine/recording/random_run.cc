// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/recording/random_run.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "engine/base/random.h"
#include "engine/geometry/random_vector.h"
#include "tests/support/random_pose.h"

namespace plumbline {
namespace {

float OddFloat(std::uint32_t which) {
  constexpr float kOdd[] = {
      std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -0.0f,
      std::numeric_limits<float>::denorm_min(), -std::numeric_limits<float>::infinity()};
  return kOdd[which % 5];
}

Box2 RandomBox(Random& random) {
  return {static_cast<float>(random.Uniform(0, 100)), static_cast<float>(random.Uniform(0, 100)),
          static_cast<float>(random.Uniform(100, 200)),
          static_cast<float>(random.Uniform(100, 200))};
}

/// Spread like a converged set: that is what the size on disk depends on.
std::shared_ptr<const std::vector<Particle>> RandomParticles(Random& random, int count,
                                                             bool scaled) {
  auto particles = std::make_shared<std::vector<Particle>>();
  for (int i = 0; i < count; ++i) {
    particles->push_back(
        {static_cast<float>(0.1 + 0.02 * random.Gaussian()),
         static_cast<float>(-0.2 + 0.02 * random.Gaussian()),
         static_cast<float>(0.7 + 0.05 * random.Gaussian()),
         static_cast<float>(1.2 + 0.1 * random.Gaussian()),
         static_cast<float>(-6 + random.Gaussian()), static_cast<float>(random.Uniform(0.3, 0.8)),
         static_cast<float>(random.Uniform(0.1, 0.4)), static_cast<std::uint16_t>(random.Index(3)),
         static_cast<std::uint16_t>(random.Index(static_cast<std::uint32_t>(count)))});
  }
  for (Particle& particle : *particles) {
    if (scaled) particle.log_scale = static_cast<float>(0.03 * random.Gaussian());
  }
  if (count > 5) (*particles)[random.Index(5)].phi_cnn = OddFloat(random.Index(5));
  return particles;
}

ObjectReport RandomObject(Random& random, int id, int frame, int num_particles) {
  ObjectReport object;
  object.id = {id};
  object.state = static_cast<ObjectState>(random.Index(3));
  object.category = id % 2 == 0 ? "chair" : "dining table";
  object.reference_frame = frame / 2;
  object.world_from_reference_cam = RandomPose(random);
  object.first_frame = frame / 2;
  if (random.Index(2) == 0) object.confirmed_frame = frame / 2 + 5;
  object.last_frame = frame;
  object.label = {static_cast<int>(random.Index(3))};
  object.label_probability = {{object.label, random.Uniform()}, {{7}, random.Uniform()}};
  object.world_from_object = RandomPose(random);
  for (int i = 0; i < 16; ++i) object.covariance(i / 4, i % 4) = random.Gaussian();
  object.modes = {
      {object.label, 0.75, object.world_from_object, random.Uniform(), random.Uniform()},
      {{7}, 0.25, RandomPose(random), std::numeric_limits<double>::quiet_NaN(), -0.0}};
  if (frame % 4 == 1) {
    object.scale = object.modes[0].scale = 1.03;
    object.scale_std = object.modes[0].scale_std = 0.01;
    object.modes[1].scale = 0.98;
  }
  object.effective_sample_size = random.Uniform(1, 500);
  object.log_evidence = random.Index(4) == 0 ? -0.0 : random.Gaussian();
  object.updated = random.Index(4) != 0;
  object.visible_fraction = random.Uniform();
  object.phi_cnn = OddFloat(random.Index(5));
  object.phi_edge = static_cast<float>(random.Uniform());
  object.whole_box = RandomBox(random);
  object.visible_box = random.Index(3) == 0 ? Box2{} : RandomBox(random);
  if (num_particles >= 0) object.particles = RandomParticles(random, num_particles, frame % 4 == 1);
  object.filter_state = std::string("state\0with zero", 15) + std::to_string(random.Bits());
  return object;
}

/// The bytes of anything that has no padding.
class BitPrinter {
 public:
  template <typename T>
  BitPrinter& operator<<(const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      out_ << value.size() << ':' << value;
    } else {
      static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
      out_.write(reinterpret_cast<const char*>(&value), sizeof(value));
    }
    out_ << '|';
    return *this;
  }
  BitPrinter& operator<<(const Box2& box) { return *this << box.x0 << box.y0 << box.x1 << box.y1; }
  BitPrinter& operator<<(const Eigen::Isometry3d& pose) {
    for (int i = 0; i < 16; ++i) *this << pose.matrix()(i / 4, i % 4);
    return *this;
  }
  std::string text() const { return out_.str(); }

 private:
  std::ostringstream out_;
};

void Print(const ObjectReport& o, BitPrinter& out) {
  out << o.id.value << static_cast<int>(o.state) << o.category << o.reference_frame
      << o.world_from_reference_cam << o.first_frame << o.confirmed_frame.has_value()
      << o.confirmed_frame.value_or(0) << o.last_frame << o.label.value << o.world_from_object
      << o.effective_sample_size << o.log_evidence << o.updated << o.visible_fraction << o.phi_cnn
      << o.phi_edge << o.whole_box << o.visible_box << o.filter_state << o.label_probability.size()
      << o.modes.size() << (o.particles != nullptr) << o.scale << o.scale_std;
  for (const LabelProbability& entry : o.label_probability)
    out << entry.label.value << entry.probability;
  for (int i = 0; i < 16; ++i) out << o.covariance(i / 4, i % 4);
  for (const PoseMode& mode : o.modes) {
    out << mode.label.value << mode.weight << mode.world_from_object << mode.position_std_m
        << mode.azimuth_std_rad << mode.scale << mode.scale_std;
  }
  if (!o.particles) return;
  out << o.particles->size();
  for (const Particle& p : *o.particles) {
    out << p.x_c << p.y_c << p.rho << p.azimuth << p.log_weight << p.phi_cnn << p.phi_edge
        << p.label << p.ancestor << p.log_scale;
  }
}

}  // namespace

RunHeader RandomHeader(std::uint64_t seed) {
  Random random({.seed = seed});
  RunHeader header;
  header.recipe.sequence = "/data/kitchen";
  header.recipe.models = "/data/kitchen/models";
  header.recipe.poses = {PoseSource::kTrajectory, "/data/poses.txt", "77aa"};
  header.recipe.detector =
      DetectorChoice{DetectorSource::kNetwork, "/data/fastestdet.onnx", "00ff"};
  header.recipe.edges = EdgeChoice{EdgeSource::kGradient, {}, {}};
  header.recipe.options.alpha = random.Uniform();
  header.recipe.seed = 0xFFFFFFFFFFFFFFF0ull + seed % 16;
  header.recipe.frames = {3, 600, 2};
  header.program_version = "0.1.0";
  header.sequence_hash = "0123456789abcdef";
  header.models_hash = "fedcba9876543210";
  header.models = {{"chair_kitchen", "chair"}, {"mug \"A\"", "cup"}, {"table", "dining table"}};
  while (header.models.size() < 8) header.models.push_back({"sofa", "couch"});  // labels go up to 7
  header.gravity_in_world = GaussianVector<3>(random).normalized();
  header.floor_in_world = Eigen::Vector4d(0, 0, 1, random.Gaussian());
  header.camera = {640, 480, 525.1 + random.Uniform(), 525, 319.5, 239.5};
  header.rate_hz = 29.97;
  header.end_frame = 600;
  header.started = "2018-09-08 12:00";
  return header;
}

FrameReport RandomFrame(std::uint64_t seed, int frame, int num_objects, int num_particles) {
  Random random({.seed = seed, .frame = static_cast<std::uint32_t>(frame)});
  FrameReport report;
  report.frame = frame;
  report.stamp_ns = 1'400'000'000'000'000'000 + frame * std::int64_t{33'333'333};
  if (random.Index(8) != 0) report.world_from_cam = RandomPose(random);
  if (random.Index(8) == 0) report.skipped = "color/000007.jpg is truncated";
  for (int i = 0; i < 8; ++i) {
    report.proposals.push_back(
        {RandomBox(random), i % 2 == 0 ? "chair" : "laptop", static_cast<float>(random.Uniform()),
         static_cast<ProposalFate>(random.Index(5)), ObjectId{static_cast<int>(random.Index(9))}});
  }
  for (int i = 0; i < num_objects; ++i)
    report.objects.push_back(RandomObject(random, i + 1, frame, num_particles));
  report.events = {{EventKind::kMerged, {2}, {1}, "on the same place: 3 cm, 80 % overlap"},
                   {EventKind::kLabelChanged, {1}, {}, ""}};
  report.timings = {
      {"visibility", random.Uniform()}, {"score", random.Uniform(5, 9)}, {"total", 1e-300}};
  report.next_object_id = num_objects + 1;
  report.mapper_state = std::string("\0\1\2 mapper", 10);
  return report;
}

cv::Mat RandomImage(std::uint64_t seed) {
  cv::Mat image(500, 960, CV_8UC3);
  Random random({.seed = seed});
  const int phase = static_cast<int>(random.Index(64));
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const int noise = static_cast<int>(random.Bits() & 15);
      image.at<cv::Vec3b>(y, x) = {static_cast<unsigned char>((x + phase) / 4 % 240 + noise),
                                   static_cast<unsigned char>(y / 2 % 240 + noise),
                                   static_cast<unsigned char>((x / 40 + y / 40) % 2 * 200 + noise)};
    }
  }
  return image;
}

std::string Fingerprint(const FrameReport& report) {
  BitPrinter out;
  out << report.frame << report.stamp_ns << report.world_from_cam.has_value()
      << report.world_from_cam.value_or(Eigen::Isometry3d::Identity()) << report.skipped
      << report.next_object_id << report.mapper_state << report.proposals.size()
      << report.objects.size() << report.events.size() << report.timings.size();
  for (const ProposalReport& proposal : report.proposals) {
    out << proposal.box << proposal.category << proposal.score << static_cast<int>(proposal.fate)
        << proposal.object.value;
  }
  for (const ObjectReport& object : report.objects) Print(object, out);
  for (const LifeEvent& event : report.events) {
    out << static_cast<int>(event.kind) << event.object.value << event.other.value << event.text;
  }
  for (const StageTiming& timing : report.timings) out << timing.stage << timing.milliseconds;
  return out.text();
}

}  // namespace plumbline
