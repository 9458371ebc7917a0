// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/simulated_detector.h"

#include <algorithm>
#include <cmath>

#include "engine/base/random.h"

namespace plumbline {
namespace {

constexpr double kBestScore = 0.95;

std::uint32_t KeyOf(int value) { return static_cast<std::uint32_t>(value); }

Box2 Clipped(Box2 box, const PinholeCamera& camera) {
  const auto right = static_cast<float>(camera.width - 1),
             bottom = static_cast<float>(camera.height - 1);
  return {std::clamp(box.x0, 0.0f, right), std::clamp(box.y0, 0.0f, bottom),
          std::clamp(box.x1, 0.0f, right), std::clamp(box.y1, 0.0f, bottom)};
}

Box2 Noisy(const Box2& box, double noise, Random& random) {
  const auto shift = [&](float size) {
    return static_cast<float>(noise * random.Gaussian()) * size;
  };
  return {box.x0 + shift(box.width()), box.y0 + shift(box.height()), box.x1 + shift(box.width()),
          box.y1 + shift(box.height())};
}

void Report(const Box2& box, const std::string& category, double score, const PinholeCamera& camera,
            std::vector<Detection>& found) {
  const Box2 inside = Clipped(box, camera);
  if (inside.width() >= 3 && inside.height() >= 3)
    found.push_back({inside, category, static_cast<float>(score)});
}

}  // namespace

DetectorFlaws FlawsOf(const SyntheticOptions& options) {
  DetectorFlaws flaws;
  if (options.flawless) {
    flaws.missed = flaws.false_per_frame = flaws.box_noise = 0;
    flaws.least_score = kBestScore;
    return flaws;
  }
  flaws.miss_memory = std::pow(flaws.miss_memory, 30 / options.rate_hz);
  flaws.false_frames = std::max(1.0, flaws.false_frames * options.rate_hz / 30);
  if (options.scene == SyntheticScene::kDuplicate) {
    flaws.split = 0.30;
    flaws.doubled = 0.35;
  }
  return flaws;
}

struct VisibilityMeter::Body {
  explicit Body(const RoomPart& part)
      : scene(std::span(&part, 1)), velocity_m_s(part.velocity_m_s) {}
  TracedScene scene;
  Eigen::Vector3d velocity_m_s;
};

VisibilityMeter::VisibilityMeter(const Room& room) {
  bodies_.resize(room.instances.size());
  for (const RoomPart& part : room.parts) {
    if (part.instance > 0)
      bodies_[static_cast<std::size_t>(part.instance - 1)] = std::make_shared<const Body>(part);
  }
}

Visibility VisibilityMeter::Measure(const PinholeCamera& camera, const Shutter& shutter,
                                    const SurfaceMaps& maps) const {
  Visibility result;
  const std::size_t count = bodies_.size();
  result.pixels.assign(count, 0);
  result.share.assign(count, -1);
  result.box.assign(count, {});
  result.truncated.assign(count, false);
  std::vector<cv::Rect> extent(count);
  std::vector<int> x1(count, -1), y1(count, -1), x0(count, camera.width), y0(count, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const int number = maps.instance.at<std::uint16_t>(y, x);
      if (number == 0) continue;
      const auto i = static_cast<std::size_t>(number - 1);
      ++result.pixels[i];
      x0[i] = std::min(x0[i], x);
      x1[i] = std::max(x1[i], x);
      y0[i] = std::min(y0[i], y);
      y1[i] = std::max(y1[i], y);
    }
  }
  constexpr int kStep = 4;
  for (std::size_t i = 0; i < count; ++i) {
    if (result.pixels[i] > 0) {
      result.box[i] = {x0[i], y0[i], x1[i] - x0[i] + 1, y1[i] - y0[i] + 1};
      result.truncated[i] =
          x0[i] == 0 || y0[i] == 0 || x1[i] == camera.width - 1 || y1[i] == camera.height - 1;
    }
    Eigen::AlignedBox3f bounds;
    for (const Eigen::Vector3f& vertex : bodies_[i]->scene.vertices()) bounds.extend(vertex);
    const Eigen::Vector3d moved = shutter.TimeOf(0) * bodies_[i]->velocity_m_s;
    const Eigen::Vector3d center_in_room = bounds.center().cast<double>() + moved;
    const Eigen::Vector3d center = shutter.Seeing(center_in_room).inverse() * center_in_room;
    const double radius = bounds.sizes().cast<double>().norm() / 2;
    if (center.z() < -radius) continue;
    int left = 0, right = camera.width, top = 0, bottom = camera.height;
    if (center.z() > 1.5 * radius) {
      const double reach = camera.fx * radius / (center.z() - radius);
      const Eigen::Vector2d middle = camera.Project(center);
      left = std::clamp(static_cast<int>(middle.x() - reach), 0, camera.width);
      right = std::clamp(static_cast<int>(middle.x() + reach), 0, camera.width);
      top = std::clamp(static_cast<int>(middle.y() - reach), 0, camera.height);
      bottom = std::clamp(static_cast<int>(middle.y() + reach), 0, camera.height);
    }
    int whole = 0;
    for (int y = top - top % kStep + kStep / 2; y < bottom; y += kStep) {
      const Eigen::Isometry3d room_from_cam = shutter.RoomFromCam(y);
      const Eigen::Matrix3f rotation = room_from_cam.linear().cast<float>();
      const Eigen::Vector3f origin = (room_from_cam.translation() - moved).cast<float>();
      for (int x = left - left % kStep + kStep / 2; x < right; x += kStep) {
        const Eigen::Vector2d bearing = camera.Bearing({x, y});
        const Eigen::Vector3f in_cam(static_cast<float>(bearing.x()),
                                     static_cast<float>(bearing.y()), 1);
        whole += bodies_[i]->scene.Trace(origin, (rotation * in_cam).normalized()).valid();
      }
    }
    if (whole > 0)
      result.share[i] =
          std::min(1.0, result.pixels[i] / static_cast<double>(whole * kStep * kStep));
  }
  return result;
}

SimulatedDetector::SimulatedDetector(const Room& room, const DetectorFlaws& flaws,
                                     std::uint64_t seed)
    : flaws_(flaws), seed_(seed), missing_(room.instances.size()) {
  for (const RoomInstance& instance : room.instances) categories_.push_back(instance.category);
  for (const FurnitureModel& model : room.catalogue) {
    if (std::find(known_.begin(), known_.end(), model.category) == known_.end())
      known_.push_back(model.category);
  }
  for (std::size_t i = 0; i < missing_.size(); ++i) {
    missing_[i] =
        Random({.seed = seed_, .object = KeyOf(static_cast<int>(i)), .particle = 0x6d6973})
            .Uniform() < flaws_.missed;
  }
}

void SimulatedDetector::BoxObject(int frame, int instance, const PinholeCamera& camera,
                                  const Visibility& visibility, std::vector<Detection>& found) {
  const auto i = static_cast<std::size_t>(instance);
  Random random(
      {.seed = seed_, .frame = KeyOf(frame), .object = KeyOf(instance), .particle = 0x646574});
  const double afresh = (1 - flaws_.miss_memory) * flaws_.missed;
  missing_[i] = random.Uniform() < (missing_[i] ? flaws_.miss_memory + afresh : afresh);
  const double area = static_cast<double>(camera.width) * camera.height / (960.0 * 500.0);
  if (missing_[i] || visibility.pixels[i] < flaws_.min_pixels * area ||
      visibility.share[i] < flaws_.min_visible)
    return;
  const cv::Rect& rect = visibility.box[i];
  const Box2 truth{static_cast<float>(rect.x), static_cast<float>(rect.y),
                   static_cast<float>(rect.x + rect.width - 1),
                   static_cast<float>(rect.y + rect.height - 1)};
  const std::string& category = categories_[i];
  const double score = random.Uniform(flaws_.least_score, kBestScore);
  const double fate = random.Uniform();
  if (fate < flaws_.split) {
    const bool upright = truth.height() > truth.width();
    const auto cut = static_cast<float>(random.Uniform(0.35, 0.65));
    Box2 first = truth, second = truth;
    (upright ? first.y1 : first.x1) =
        upright ? truth.y0 + cut * truth.height() : truth.x0 + cut * truth.width();
    (upright ? second.y0 : second.x0) = upright ? first.y1 : first.x1;
    Report(Noisy(first, flaws_.box_noise, random), category, score, camera, found);
    const double second_score = random.Uniform(flaws_.least_score, kBestScore);
    Report(Noisy(second, flaws_.box_noise, random), category, second_score, camera, found);
    return;
  }
  Report(Noisy(truth, flaws_.box_noise, random), category, score, camera, found);
  if (fate < flaws_.split + flaws_.doubled) {
    const double second_score = random.Uniform(flaws_.least_score, kBestScore);
    Report(Noisy(truth, 2 * flaws_.box_noise, random), category, second_score, camera, found);
  }
}

void SimulatedDetector::BoxPhantoms(int frame, const PinholeCamera& camera, const Shutter& shutter,
                                    const SurfaceMaps& maps, std::vector<Detection>& found) {
  Random random({.seed = seed_, .frame = KeyOf(frame), .object = 0xffff, .particle = 0x706861});
  std::erase_if(phantoms_, [&](const Phantom& phantom) { return phantom.last_frame < frame; });
  // One may be born in a frame; in the long run births * duration = false_per_frame.
  if (random.Uniform() < flaws_.false_per_frame / flaws_.false_frames) {
    for (int attempt = 0; attempt < 30; ++attempt) {
      const int x = static_cast<int>(random.Index(KeyOf(camera.width))),
                y = static_cast<int>(random.Index(KeyOf(camera.height)));
      const double depth = maps.depth.at<float>(y, x);
      if (depth <= 0 || maps.instance.at<std::uint16_t>(y, x) != 0) continue;
      const Eigen::Vector2d bearing = camera.Bearing({x, y});
      Phantom phantom;
      phantom.point_in_room =
          shutter.RoomFromCam(y) * Eigen::Vector3d(bearing.x() * depth, bearing.y() * depth, depth);
      const double scale = camera.width / 960.0;
      phantom.width_m = random.Uniform(40, 190) * scale * depth / camera.fx;
      phantom.height_m = random.Uniform(40, 190) * scale * depth / camera.fy;
      phantom.category = known_[random.Index(KeyOf(static_cast<int>(known_.size())))];
      // Geometric.
      int frames = 1;
      while (random.Uniform() > 1 / flaws_.false_frames) ++frames;
      phantom.last_frame = frame + frames - 1;
      phantoms_.push_back(phantom);
      break;
    }
  }
  for (const Phantom& phantom : phantoms_) {
    const Eigen::Vector3d in_cam =
        shutter.Seeing(phantom.point_in_room).inverse() * phantom.point_in_room;
    const double score = random.Uniform(0.35, 0.80);
    if (in_cam.z() < 0.2) continue;
    const Eigen::Vector2d at = camera.Project(in_cam);
    const auto half_width = static_cast<float>(phantom.width_m * camera.fx / in_cam.z() / 2);
    const auto half_height = static_cast<float>(phantom.height_m * camera.fy / in_cam.z() / 2);
    const auto x = static_cast<float>(at.x()), y = static_cast<float>(at.y());
    const Box2 box{x - half_width, y - half_height, x + half_width, y + half_height};
    Report(Noisy(box, flaws_.box_noise, random), phantom.category, score, camera, found);
  }
}

std::vector<Detection> SimulatedDetector::Detect(int frame, const PinholeCamera& camera,
                                                 const Shutter& shutter, const SurfaceMaps& maps,
                                                 const Visibility& visibility) {
  std::vector<Detection> found;
  for (std::size_t i = 0; i < categories_.size(); ++i)
    BoxObject(frame, static_cast<int>(i), camera, visibility, found);
  BoxPhantoms(frame, camera, shutter, maps, found);
  std::stable_sort(found.begin(), found.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return found;
}

}  // namespace plumbline
