// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/roi_align.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// What a bin takes from a row or column of cells.
struct CellShare {
  int cell;
  float weight;
};

/// The shares of each bin along one axis. Bilinear samples and their mean are products of one
/// function of x and one of y, so that a crop is (bins x rows) * map * (columns x bins).
struct AxisShares {
  std::vector<std::vector<CellShare>> bins;
  int first = 0, end = 0;  ///< The cells that any bin takes from.
};

AxisShares SharesAlong(float start, float end, int cells, int stride, const TwoStageSettings& s) {
  const float scale = 1 / static_cast<float>(stride), from = start * scale;
  const float length = std::max(end * scale - from, 1.0f);
  const float bin = length / static_cast<float>(s.crop_size);
  const int samples = s.crop_sampling > 0
                          ? s.crop_sampling
                          : static_cast<int>(std::ceil(length / static_cast<float>(s.crop_size)));
  const float weight = 1 / static_cast<float>(samples);
  AxisShares shares{std::vector<std::vector<CellShare>>(s.crop_size), cells, 0};
  for (int i = 0; i < s.crop_size; ++i) {
    for (int sample = 0; sample < samples; ++sample) {
      const float at = from + static_cast<float>(i) * bin +
                       (static_cast<float>(sample) + 0.5f) * bin / static_cast<float>(samples);
      if (at < -1 || at > static_cast<float>(cells)) continue;
      const float inside = std::clamp(at, 0.0f, static_cast<float>(cells - 1));
      const int low = static_cast<int>(inside), high = std::min(low + 1, cells - 1);
      const float share = inside - static_cast<float>(low);
      shares.bins[i].push_back({low, weight * (1 - share)});
      if (share > 0) shares.bins[i].push_back({high, weight * share});
      shares.first = std::min(shares.first, low);
      shares.end = std::max(shares.end, high + 1);
    }
  }
  return shares;
}

/// One crop: rows are combined into one for each bin down, then its columns into bins across.
class Cropper {
 public:
  Cropper(const TwoStageSettings& settings, int channels)
      : settings_(settings), sum_(static_cast<std::size_t>(channels)) {}

  void Crop(const FeatureMap& map, const Box2& box, float* crop) {
    const AxisShares across = SharesAlong(box.x0, box.x1, map.columns, map.stride, settings_);
    const AxisShares down = SharesAlong(box.y0, box.y1, map.rows, map.stride, settings_);
    const int size = settings_.crop_size, bins = size * size;
    for (int y = 0; y < size; ++y) {
      CombineRows(map, down.bins[y], across.first, across.end);
      for (int x = 0; x < size; ++x) {
        std::fill(sum_.begin(), sum_.end(), 0.0f);
        for (const auto& [cell, weight] : across.bins[x])
          AddWeighted(&row_[static_cast<std::size_t>(cell - across.first) * map.channels],
                      map.channels, weight, sum_.data());
        float* target = crop + y * size + x;
        for (int c = 0; c < map.channels; ++c) target[c * bins] = sum_[c];
      }
    }
  }

 private:
  static void AddWeighted(const float* values, int count, float weight, float* sums) {
    for (int i = 0; i < count; ++i) sums[i] += weight * values[i];
  }

  void CombineRows(const FeatureMap& map, const std::vector<CellShare>& shares, int first,
                   int end) {
    const int count = std::max(0, end - first) * map.channels;
    row_.assign(static_cast<std::size_t>(count), 0.0f);
    for (const auto& [cell, weight] : shares) {
      const std::size_t start =
          (static_cast<std::size_t>(cell) * map.columns + first) * map.channels;
      AddWeighted(map.values.data() + start, count, weight, row_.data());
    }
  }

  const TwoStageSettings& settings_;
  std::vector<float> row_, sum_;
};

}  // namespace

FeatureMap MakeFeatureMap(const cv::Mat& tensor, int first, int count, int stride) {
  PLB_CHECK(tensor.dims == 4 && tensor.type() == CV_32FC1 && first + count <= tensor.size[1]);
  FeatureMap map{tensor.size[2], tensor.size[3], count, stride, {}};
  const int cells = map.rows * map.columns;
  map.values.resize(static_cast<std::size_t>(cells) * count);
  const cv::Mat planes(count, cells, CV_32FC1, const_cast<float*>(tensor.ptr<float>(0, first)));
  cv::Mat side_by_side(cells, count, CV_32FC1, map.values.data());
  cv::transpose(planes, side_by_side);
  return map;
}

int CropLevel(const Box2& box, std::span<const FeatureMap> maps, const TwoStageSettings& settings) {
  const auto level_of = [](const FeatureMap& map) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(map.stride))) - 1;
  };
  const int lowest = level_of(maps.front()), highest = level_of(maps.back());
  const float side = std::sqrt(box.area());
  const float level =
      std::floor(static_cast<float>(settings.canonical_level) +
                 std::log2(side / settings.canonical_scale) + 1e-6f);  // as torchvision rounds
  return static_cast<int>(
             std::clamp(level, static_cast<float>(lowest), static_cast<float>(highest))) -
         lowest;
}

cv::Mat CropRegions(std::span<const FeatureMap> maps, std::span<const Box2> boxes, int filled,
                    const TwoStageSettings& settings) {
  PLB_CHECK(!maps.empty() && filled >= static_cast<int>(boxes.size()));
  const int channels = maps.front().channels;
  const int shape[] = {filled, channels, settings.crop_size, settings.crop_size};
  cv::Mat crops(4, shape, CV_32FC1, cv::Scalar(0));
  cv::parallel_for_({0, static_cast<int>(boxes.size())}, [&](const cv::Range& range) {
    Cropper cropper(settings, channels);
    for (int i = range.start; i < range.end; ++i)
      cropper.Crop(maps[CropLevel(boxes[i], maps, settings)], boxes[i], crops.ptr<float>(i));
  });
  return crops;
}

}  // namespace plumbline
