// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/roi_align.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/vectorised.h"

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
  std::vector<CellShare> shares;  ///< Of bin i from starts[i] to starts[i + 1].
  std::vector<std::size_t> starts;
  int first = 0, end = 0;  ///< The cells that any bin takes from.

  std::span<const CellShare> bin(int i) const {
    return std::span(shares).subspan(starts[i], starts[i + 1] - starts[i]);
  }
};

void FindShares(float start, float end, int cells, int stride, const TwoStageSettings& s,
                AxisShares& found) {
  const float scale = 1 / static_cast<float>(stride), from = start * scale;
  const float length = std::max(end * scale - from, 1.0f);
  const float bin = length / static_cast<float>(s.crop_size);
  const int samples = s.crop_sampling > 0
                          ? s.crop_sampling
                          : static_cast<int>(std::ceil(length / static_cast<float>(s.crop_size)));
  const float weight = 1 / static_cast<float>(samples);
  found.shares.clear();
  found.starts.assign(1, 0);
  found.first = cells, found.end = 0;
  for (int i = 0; i < s.crop_size; ++i) {
    for (int sample = 0; sample < samples; ++sample) {
      const float at = from + static_cast<float>(i) * bin +
                       (static_cast<float>(sample) + 0.5f) * bin / static_cast<float>(samples);
      if (at < -1 || at > static_cast<float>(cells)) continue;
      const float inside = std::clamp(at, 0.0f, static_cast<float>(cells - 1));
      const int low = static_cast<int>(inside), high = std::min(low + 1, cells - 1);
      const float share = inside - static_cast<float>(low);
      found.shares.push_back({low, weight * (1 - share)});
      if (share > 0) found.shares.push_back({high, weight * share});
      found.first = std::min(found.first, low);
      found.end = std::max(found.end, high + 1);
    }
    found.starts.push_back(found.shares.size());
  }
}

/// sums[i] = sum over shares of weight * cells[cell * step + i].
PLUMBLINE_VECTORISED
void SumShares(const CellShare* shares, std::size_t share_count, const float* cells,
               std::size_t step, std::size_t count, float* __restrict sums) {
  if (share_count == 0) {
    std::fill(sums, sums + count, 0.0f);
    return;
  }
  const float* values = cells + static_cast<std::size_t>(shares[0].cell) * step;
  for (std::size_t i = 0; i < count; ++i) sums[i] = shares[0].weight * values[i];
  for (std::size_t k = 1; k < share_count; ++k) {
    const float weight = shares[k].weight;
    values = cells + static_cast<std::size_t>(shares[k].cell) * step;
    for (std::size_t i = 0; i < count; ++i) sums[i] += weight * values[i];
  }
}

/// One crop: rows are combined into one for each bin down, then its columns into bins across.
class Cropper {
 public:
  Cropper(const TwoStageSettings& settings, int channels)
      : settings_(settings),
        channels_(static_cast<std::size_t>(channels)),
        bins_(static_cast<std::size_t>(settings.crop_size * settings.crop_size)),
        sums_(bins_ * channels_) {}

  void Crop(const FeatureMap& map, const Box2& box, float* crop) {
    FindShares(box.x0, box.x1, map.columns, map.stride, settings_, across_);
    FindShares(box.y0, box.y1, map.rows, map.stride, settings_, down_);
    const std::size_t width = std::max(0, across_.end - across_.first) * channels_;
    row_.resize(width);
    for (CellShare& share : across_.shares) share.cell -= across_.first;  // `row_` begins there
    float* sums = sums_.data();
    for (int y = 0; y < settings_.crop_size; ++y) {
      const auto rows = down_.bin(y);
      SumShares(rows.data(), rows.size(), map.values.data() + across_.first * channels_,
                map.columns * channels_, width, row_.data());
      for (int x = 0; x < settings_.crop_size; ++x, sums += channels_) {
        const auto columns = across_.bin(x);
        SumShares(columns.data(), columns.size(), row_.data(), channels_, channels_, sums);
      }
    }
    for (std::size_t c = 0; c < channels_; ++c) {
      for (std::size_t bin = 0; bin < bins_; ++bin) *crop++ = sums_[bin * channels_ + c];
    }
  }

 private:
  const TwoStageSettings& settings_;
  const std::size_t channels_, bins_;
  AxisShares across_, down_;
  std::vector<float> row_, sums_;
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
  cv::Mat crops(4, shape, CV_32FC1);
  std::fill(crops.ptr<float>(0) + boxes.size() * crops.step1(0),
            crops.ptr<float>(0) + crops.total(), 0.0f);
  cv::parallel_for_({0, static_cast<int>(boxes.size())}, [&](const cv::Range& range) {
    Cropper cropper(settings, channels);
    for (int i = range.start; i < range.end; ++i)
      cropper.Crop(maps[CropLevel(boxes[i], maps, settings)], boxes[i], crops.ptr<float>(i));
  });
  return crops;
}

}  // namespace plumbline
