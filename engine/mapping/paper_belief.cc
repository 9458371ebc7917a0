// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/paper_belief.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr double kCoarserNoise = 1.04;  ///< On every level but the full one.
/// The authors' network gives every box some score; ours give none where there is no box.
constexpr float kLeastScore = 0.01f;

constexpr std::size_t kMeans = 15;
constexpr int kUpdatesOfOneLabel = 10;
constexpr double kBearingVariance = 0.02, kLogDepthVariance = 0.05, kAzimuthVariance = 0.5;
constexpr double kSettledRatio = 0.85, kSettledDistance_px = 10;
constexpr double kLostRatio = 0.75, kLostDistance_px = 15;
constexpr int kUpdatesPerBox = 5;
constexpr int kMissesPerSettledUpdate = 20, kMissesPerBox = 10;

/// There are fewer than 2^20 particles.
std::uint32_t KeyOf(int level, std::size_t particle) {
  return static_cast<std::uint32_t>(level) << 20 | static_cast<std::uint32_t>(particle);
}

void Diffuse(std::vector<Particle>& particles, const ModelDatabase& database, int level,
             const PaperOptions& options, const PaperUpdate& update) {
  const bool settled = update.settled;
  const double scale = level > 0 ? kCoarserNoise : 1.0;
  RandomKey key = update.diffuse;
  const double x = settled ? options.settled_bearing_noise : options.bearing_x_noise;
  const double y = settled ? options.settled_bearing_noise : options.bearing_y_noise;
  const double rho = settled ? options.settled_log_depth_noise : options.log_depth_noise;
  const double azimuth = settled ? options.settled_azimuth_noise_rad : options.azimuth_noise_rad;
  const double kept = settled ? options.settled_label_kept : options.label_kept;
  const double redrawn = settled ? 0 : options.azimuth_redrawn;
  const std::vector<ModelId> labels =
      database.OfCategory(database.model(ModelId{particles.front().label}).category);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    key.particle = KeyOf(level, i);
    Random random(key);
    Particle& particle = particles[i];
    particle.x_c += static_cast<float>(scale * x * random.Gaussian());
    particle.y_c += static_cast<float>(scale * y * random.Gaussian());
    particle.rho += static_cast<float>(scale * rho * random.Gaussian());
    const bool anew = random.Uniform() < redrawn;
    const double turn = anew ? random.Uniform(-std::numbers::pi, std::numbers::pi)
                             : particle.azimuth + scale * azimuth * random.Gaussian();
    particle.azimuth = static_cast<float>(WrapAngle(turn));
    if (labels.size() < 2 || random.Uniform() < kept) continue;
    // One of the others, all equally likely.
    const ModelId other = labels[random.Index(static_cast<std::uint32_t>(labels.size() - 1))];
    particle.label =
        static_cast<std::uint16_t>((other.value == particle.label ? labels.back() : other).value);
  }
}

Box2 AtFullSize(const Box2& box, float scale) {
  const auto full = [scale](float pixel) { return (pixel + 0.5f) * scale - 0.5f; };
  return {full(box.x0), full(box.y0), full(box.x1), full(box.y1)};
}

/// @param level  0 is the full size, 1 half of it ..
void Weigh(std::vector<Particle>& particles, const Eigen::Isometry3d& world_from_reference_cam,
           const PaperImage& image, const NearestEdges& edges, int level,
           const PaperOptions& options) {
  std::vector<PoseHypothesis> hypotheses;
  for (const Particle& particle : particles)
    hypotheses.push_back(ToHypothesis(particle, world_from_reference_cam));
  ScoringView view = image.view;
  for (int i = 0; i < level; ++i) view.camera = view.camera.Scaled(0.5);
  const std::vector<EdgeMatch> matches =
      edges.Match(*image.scorer, view, image.map->upright, hypotheses);
  const double scale = std::exp2(level);
  std::vector<Box2> boxes;
  for (const EdgeMatch& match : matches) {
    boxes.push_back(
        match.whole_box.empty() ? Box2{} : AtFullSize(match.whole_box, static_cast<float>(scale)));
  }
  const std::string& category =
      image.map->database->model(ModelId{particles.front().label}).category;
  const std::vector<float> log_scores = LogScores(image.detections, category, boxes);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    particles[i].phi_edge = static_cast<float>(matches[i].Score());
    particles[i].phi_cnn = log_scores[i];
    particles[i].log_weight = static_cast<float>(
        (options.edge_weight * matches[i].Score() + options.detector_weight * log_scores[i]) /
        scale);
  }
  NormalizeLogWeights(particles);
}

/// Of the last means in one of their parameters.
template <typename Parameter>
double Variance(const std::vector<Particle>& means, Parameter parameter) {
  double sum = 0, squares = 0;
  for (const Particle& mean : means) {
    const double value = parameter(mean);
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(means.size());
  return squares / n - sum * sum / (n * n);
}

}  // namespace

void PaperTrack::Add(const Particle& mean, bool settled) {
  ++(settled ? settled_updates : updates);
  same_label = !means.empty() && means.back().label == mean.label ? same_label + 1 : 0;
  means.push_back(mean);
  if (means.size() > kMeans) means.erase(means.begin());
}

void PaperTrack::Unsettle() {
  updates = 0;
  same_label = 0;
  means.clear();
}

void PaperTrack::Save(ByteWriter& out) const {
  for (const int count : {updates, settled_updates, matched, unmatched, same_label})
    out.Put(static_cast<std::int32_t>(count));
  out.Put(static_cast<std::uint32_t>(means.size()));
  for (const Particle& mean : means) {
    for (const float value : {mean.x_c, mean.y_c, mean.rho, mean.azimuth}) out.Put(value);
    out.Put(mean.label);
  }
}

void PaperTrack::Restore(ByteReader& in) {
  for (int* count : {&updates, &settled_updates, &matched, &unmatched, &same_label})
    *count = in.Get<std::int32_t>();
  means.resize(std::min<std::uint32_t>(in.Get<std::uint32_t>(), kMeans));
  for (Particle& mean : means) {
    for (float* value : {&mean.x_c, &mean.y_c, &mean.rho, &mean.azimuth}) *value = in.Get<float>();
    mean.label = in.Get<std::uint16_t>();
  }
}

std::vector<Particle> BirthAsPaper(const Box2& box, const PinholeCamera& camera,
                                   std::span<const ModelId> labels, const PaperOptions& options,
                                   RandomKey key) {
  const Eigen::Vector2d bearing = camera.Bearing({box.center_x(), box.center_y()});
  std::vector<Particle> particles;
  for (int i = 0; i < options.particles_per_shape; ++i) {
    key.particle = static_cast<std::uint32_t>(i);
    Random random(key);
    Particle particle;
    particle.x_c = static_cast<float>(bearing.x() + options.bearing_x_std * random.Gaussian());
    particle.y_c = static_cast<float>(bearing.y() + options.bearing_y_std * random.Gaussian());
    particle.rho =
        static_cast<float>(std::log(options.depth_m) + options.log_depth_std * random.Gaussian());
    particle.azimuth = static_cast<float>(random.Uniform(-std::numbers::pi, std::numbers::pi));
    for (const ModelId label : labels) {
      particle.label = static_cast<std::uint16_t>(label.value);
      particle.ancestor = static_cast<std::uint16_t>(particles.size());
      particles.push_back(particle);
    }
  }
  NormalizeLogWeights(particles);
  return particles;
}

std::vector<float> LogScores(const FrameDetections* detections, const std::string& category,
                             std::span<const Box2> boxes) {
  std::vector<float> scores(boxes.size(), kLeastScore);
  if (detections != nullptr) detections->ScoreBoxes(category, boxes, scores);
  for (float& score : scores) score = std::log(std::max(score, kLeastScore));
  return scores;
}

void UpdateAsPaper(std::vector<Particle>& particles,
                   const Eigen::Isometry3d& world_from_reference_cam, const PaperImage& image,
                   const PaperOptions& options, const PaperUpdate& update) {
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles[i].ancestor = static_cast<std::uint16_t>(i);
  int level = static_cast<int>(image.levels.size());
  for (const NearestEdges& edges : image.levels) {
    --level;
    Diffuse(particles, *image.map->database, level, options, update);
    Weigh(particles, world_from_reference_cam, image, edges, level, options);
    RandomKey key = update.resample;
    key.particle = KeyOf(level, 0);
    const std::vector<Particle> before = std::move(particles);
    particles = SystematicResample(before, static_cast<int>(update.count), key);
    for (Particle& particle : particles) particle.ancestor = before[particle.ancestor].ancestor;
  }
}

bool Settles(const PaperTrack& track, const EdgeMatch& match, const CadModel& model) {
  if (track.same_label <= kUpdatesOfOneLabel || track.means.size() < kMeans) return false;
  const double newest = track.means.back().azimuth;
  const auto azimuth = [&](const Particle& mean) {
    return AzimuthDifference(model, mean.azimuth, newest);
  };
  return Variance(track.means, [](const Particle& mean) { return mean.x_c; }) < kBearingVariance &&
         Variance(track.means, [](const Particle& mean) { return mean.y_c; }) < kBearingVariance &&
         Variance(track.means, [](const Particle& mean) { return mean.rho; }) < kLogDepthVariance &&
         Variance(track.means, azimuth) < kAzimuthVariance && match.ratio > kSettledRatio &&
         match.distance_px < kSettledDistance_px;
}

bool Lost(const EdgeMatch& match) {
  return match.ratio <= kLostRatio || match.distance_px >= kLostDistance_px;
}

bool TooManyUpdates(const PaperTrack& track, const PaperOptions& options) {
  return track.updates > options.max_updates + kUpdatesPerBox * track.matched;
}

bool TooFewBoxes(const PaperTrack& track, const PaperOptions& options) {
  return track.unmatched > options.max_unmatched + kMissesPerSettledUpdate * track.settled_updates +
                               kMissesPerBox * track.matched;
}

}  // namespace plumbline
