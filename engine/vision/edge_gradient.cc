// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_gradient.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"
#include "engine/base/vectorised.h"
#include "engine/vision/edge_gradient_model.h"
#include "engine/vision/thinning.h"

namespace plumbline {
namespace {

/// Sobel's kernel gives eight times the grey levels per pixel; squares are 64 times as large.
constexpr float kSobelScale = 8;
/// Crests lower than this [grey levels per pixel] are noise to any likelihood.
constexpr float kLeastGradient = 4.0f;
/// What a channel adds to the structure tensor at a level; colour varies less than brightness.
constexpr float kWeights[3][2] = {{1, 0}, {1, 2}, {0.5f, 1}};  // [level][brightness, colour]
constexpr double kSmoothSigmaPx = 1.0;
constexpr double kAroundSigmaPx = 1.25;  // at quarter size
constexpr double kFarSigmaPx = 3.0;      // at quarter size
/// A crest may be lower than its neighbours by rounding.
constexpr float kTieFactor = 1.003f;

constexpr auto kRadiansPerDegree = static_cast<float>(std::numbers::pi / 180);

/// Packed channels: d/dx and d/dy of Y, Cr, Cb; at quarter size also the tensor around and the
/// energy far around.
/// Filled up to multiples of four, which the machine adds at once.
constexpr int kHalfChannels = 12;
constexpr int kTensor = 6;
constexpr int kFar = 9;
constexpr int kQuarterChannels = 12;

/// log2 of a Sobel-scaled gradient in grey levels per pixel, from its square, level below half a
/// grey level; to about 0.01, from the bits of the float: fast, and the same on every machine.
inline float LogGradient(float squared) {
  const auto bits =
      std::bit_cast<std::uint32_t>(squared * (1 / (kSobelScale * kSobelScale)) + 0.25f);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23) - 128);
  return 0.5f * (exponent + (-0.33582878f * mantissa + 2.0f) * mantissa - 0.65871759f);
}

/// Where a pixel of the image lies in a level that is `factor` times smaller: the pixel before and
/// the share of the next.
inline std::pair<int, float> Place(int pixel, int factor, int size) {
  const int doubled = std::max(0, 2 * pixel + 1 - factor);  // 2 * factor units a pixel of the level
  const int before = std::min(doubled / (2 * factor), size - 2);
  const int rest = std::min(doubled - 2 * factor * before, 2 * factor);
  return {before, static_cast<float>(rest) * (0.5f / static_cast<float>(factor))};
}

/// The packed values between pixels of a level that is `kFactor` times smaller.
template <int kChannels, int kFactor>
inline void Sample(const cv::Mat& level, int x, int y, float* values) {
  const auto [x0, fx] = Place(x, kFactor, level.cols);
  const auto [y0, fy] = Place(y, kFactor, level.rows);
  const auto* upper = level.ptr<float>(y0) + x0 * kChannels;
  const auto* lower = level.ptr<float>(y0 + 1) + x0 * kChannels;
  const cv::v_float32x4 w00 = cv::v_setall_f32((1 - fx) * (1 - fy));
  const cv::v_float32x4 w10 = cv::v_setall_f32(fx * (1 - fy));
  const cv::v_float32x4 w01 = cv::v_setall_f32((1 - fx) * fy);
  const cv::v_float32x4 w11 = cv::v_setall_f32(fx * fy);
  for (int c = 0; c < kChannels; c += 4) {
    cv::v_store(values + c,
                (w00 * cv::v_load(upper + c) + w10 * cv::v_load(upper + c + kChannels)) +
                    (w01 * cv::v_load(lower + c) + w11 * cv::v_load(lower + c + kChannels)));
  }
}

inline float Square(float x) { return x * x; }

inline float Along(const float* gradient, float nx, float ny) {
  return gradient[0] * nx + gradient[1] * ny;
}

/// What one row of pixels is judged by: the map and, per pixel, the structure tensor as twice its
/// direction.
struct CrestRows {
  const float *above, *crest, *below;
  const float *difference, *twice;  ///< xx - yy and 2 xy, without level 0
  const short *dx, *dy;             ///< Level 0.
};

/// Marks with 1 the pixels that no neighbour along the normal exceeds, as interpolated between the
/// two pixels next to the normal (as Canny does). Without branches, so that the compiler can take
/// many pixels at once.
PLUMBLINE_VECTORISED void MarkCrests(const CrestRows& rows, int columns, float* marks) {
  constexpr float kLeast = kLeastGradient * kLeastGradient * kSobelScale * kSobelScale;
  const float *above = rows.above, *crest = rows.crest, *below = rows.below;
  for (int x = 1; x < columns - 1; ++x) {
    const auto u = static_cast<float>(rows.dx[x]), v = static_cast<float>(rows.dy[x]);
    const float difference = rows.difference[x] + kWeights[0][0] * (u * u - v * v);
    const float twice = rows.twice[x] + 2 * kWeights[0][0] * u * v;
    const float length = std::sqrt(difference * difference + twice * twice);
    // The tangent of the normal's angle, or its inverse: at most 1 either way.
    const float share = std::abs(twice) / (length + std::abs(difference) + 1e-9f);
    const float a0 = above[x - 1], a1 = above[x], a2 = above[x + 1];
    const float b0 = below[x - 1], b1 = below[x], b2 = below[x + 1];
    const float left = crest[x - 1], here = crest[x], right = crest[x + 1];
    const bool flat = difference > 0, falling = twice > 0;
    const float corner_1 = falling ? b2 : a2, corner_2 = falling ? a0 : b0;
    const float upright_1 = falling ? b1 : a1, upright_2 = falling ? a1 : b1;
    const float side_1 = flat ? right : upright_1, side_2 = flat ? left : upright_2;
    const float beside_1 = side_1 + share * (corner_1 - side_1);
    const float beside_2 = side_2 + share * (corner_2 - side_2);
    const float beside = beside_1 > beside_2 ? beside_1 : beside_2;
    marks[x] = (here > kLeast ? 1.0f : 0.0f) * (kTieFactor * here >= beside ? 1.0f : 0.0f);
  }
}

/// What candidates are described from.
struct Maps {
  const cv::Mat &dx, &dy;         ///< CV_16SC1, full size, brightness.
  const cv::Mat &half, &quarter;  ///< Packed.
};

inline void Describe(const Maps& maps, EdgeCandidate& candidate) {
  float half[kHalfChannels], quarter[kQuarterChannels];
  Sample<kHalfChannels, 2>(maps.half, candidate.x, candidate.y, half);
  Sample<kQuarterChannels, 4>(maps.quarter, candidate.x, candidate.y, quarter);
  const float fine[2] = {static_cast<float>(maps.dx.at<short>(candidate.y, candidate.x)),
                         static_cast<float>(maps.dy.at<short>(candidate.y, candidate.x))};
  // The direction of the larger eigenvalue, from twice its angle.
  const float difference =
      half[kTensor] - half[kTensor + 2] + kWeights[0][0] * (fine[0] * fine[0] - fine[1] * fine[1]);
  const float twice = 2 * (half[kTensor + 1] + kWeights[0][0] * fine[0] * fine[1]);
  const float length = std::sqrt(difference * difference + twice * twice);
  const float cosine = length > 0 ? difference / length : 1.0f;
  const float nx = std::sqrt(std::max(0.0f, 0.5f * (1 + cosine)));
  const float ny = std::copysign(std::sqrt(std::max(0.0f, 0.5f * (1 - cosine))), twice);
  candidate.normal_x = nx;
  candidate.normal_y = ny;
  const auto brightness = [&](const float* g) { return Square(Along(g, nx, ny)); };
  const auto color = [&](const float* g) {
    return Square(Along(g + 2, nx, ny)) + Square(Along(g + 4, nx, ny));
  };
  const float* t = quarter + kTensor;
  const float energy = t[0] + t[2];
  const float agreeing = t[0] * nx * nx + 2 * t[1] * nx * ny + t[2] * ny * ny;
  candidate.features = {LogGradient(brightness(fine)),
                        LogGradient(brightness(half)),
                        LogGradient(color(half)),
                        LogGradient(brightness(quarter)),
                        LogGradient(color(quarter)),
                        LogGradient(energy),
                        agreeing / (energy + kSobelScale * kSobelScale),
                        LogGradient(quarter[kFar])};
}

inline float LogOdds(const std::array<float, EdgeCandidate::kNumFeatures>& features) {
  cv::v_float32x4 low = cv::v_load(kGradientModel.hidden_bias);
  cv::v_float32x4 high = cv::v_load(kGradientModel.hidden_bias + 4);
  for (int j = 0; j < EdgeCandidate::kNumFeatures; ++j) {
    const cv::v_float32x4 feature = cv::v_setall_f32(features[j]);
    low = low + feature * cv::v_load(kGradientModel.hidden[j]);
    high = high + feature * cv::v_load(kGradientModel.hidden[j] + 4);
  }
  const cv::v_float32x4 zero = cv::v_setzero_f32();
  return kGradientModel.output_bias +
         cv::v_reduce_sum(cv::v_max(low, zero) * cv::v_load(kGradientModel.output) +
                          cv::v_max(high, zero) * cv::v_load(kGradientModel.output + 4));
}

void DescribeAll(const Maps& maps, std::vector<EdgeCandidate>& candidates) {
  for (EdgeCandidate& candidate : candidates) {
    Describe(maps, candidate);
    candidate.log_odds = LogOdds(candidate.features);
  }
}

class GradientEdges : public EdgeDetector {
 public:
  Result<EdgeMap> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    EdgeMap edges{cv::Mat::zeros(frame.image.size(), CV_8UC1),
                  cv::Mat::zeros(frame.image.size(), CV_8UC1)};
    for (const EdgeCandidate& candidate : finder_.Find(frame.image)) {
      if (candidate.log_odds < kLeastLogOdds) continue;
      edges.probability.at<std::uint8_t>(candidate.y, candidate.x) =
          ProbabilityToByte(1 / (1 + std::exp(-candidate.log_odds)));
      edges.angle.at<std::uint8_t>(candidate.y, candidate.x) =
          AngleToByte(cv::fastAtan2(candidate.normal_y, candidate.normal_x) * kRadiansPerDegree);
    }
    RemoveSpareCorners(finder_.crest()({{}, frame.image.size()}), edges.probability);
    edges.angle.setTo(0, edges.probability == 0);
    return edges;
  }

 private:
  /// 4 %: fainter ones would double the number of pixels and tell nothing.
  static constexpr float kLeastLogOdds = -3.18f;
  EdgeCandidateFinder finder_;
};

}  // namespace

void EdgeCandidateFinder::MakeLevel(const float (&weights)[2], int channels, Level& level) {
  cv::cvtColor(level.bgr, level.ycc, cv::COLOR_BGR2YCrCb);
  cv::GaussianBlur(level.ycc, level.ycc, {}, kSmoothSigmaPx);
  cv::split(level.ycc, level.planes);
  for (int c = 0; c < 3; ++c) cv::spatialGradient(level.planes[c], level.dx[c], level.dy[c]);
  if (level.packed.size() != level.bgr.size())
    level.packed = cv::Mat::zeros(level.bgr.size(), CV_32FC(channels));
  level.tensor.create(level.bgr.size(), CV_32FC3);
  for (int y = 0; y < level.bgr.rows; ++y) {
    auto* packed = level.packed.ptr<float>(y);
    auto* tensor = level.tensor.ptr<float>(y);
    const short* u[3] = {level.dx[0].ptr<short>(y), level.dx[1].ptr<short>(y),
                         level.dx[2].ptr<short>(y)};
    const short* v[3] = {level.dy[0].ptr<short>(y), level.dy[1].ptr<short>(y),
                         level.dy[2].ptr<short>(y)};
    for (int x = 0; x < level.bgr.cols; ++x, packed += channels, tensor += 3) {
      const auto yu = static_cast<float>(u[0][x]), yv = static_cast<float>(v[0][x]);
      const auto ru = static_cast<float>(u[1][x]), rv = static_cast<float>(v[1][x]);
      const auto bu = static_cast<float>(u[2][x]), bv = static_cast<float>(v[2][x]);
      packed[0] = yu, packed[1] = yv, packed[2] = ru, packed[3] = rv, packed[4] = bu,
      packed[5] = bv;
      tensor[0] = weights[0] * yu * yu + weights[1] * (ru * ru + bu * bu);
      tensor[1] = weights[0] * yu * yv + weights[1] * (ru * rv + bu * bv);
      tensor[2] = weights[0] * yv * yv + weights[1] * (rv * rv + bv * bv);
    }
  }
}

void EdgeCandidateFinder::MakePyramid(const cv::Mat& image) {
  cv::cvtColor(image, gray_, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(gray_, gray_, {}, kSmoothSigmaPx);
  cv::spatialGradient(gray_, dx_, dy_);
  cv::resize(image, half_.bgr, image.size() / 2, 0, 0, cv::INTER_AREA);
  cv::resize(half_.bgr, quarter_.bgr, image.size() / 4, 0, 0, cv::INTER_AREA);
  MakeLevel(kWeights[1], kHalfChannels, half_);
  MakeLevel(kWeights[2], kQuarterChannels, quarter_);

  cv::resize(half_.tensor, around_, quarter_.bgr.size(), 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(around_, around_, {}, kAroundSigmaPx);
  cv::transform(quarter_.tensor, far_, cv::Matx13f(1, 0, 1));
  cv::GaussianBlur(far_, far_, {}, kFarSigmaPx);
  const cv::Mat parts[] = {around_, far_};
  const int order[] = {0, kTensor, 1, kTensor + 1, 2, kTensor + 2, 3, kFar};
  cv::mixChannels(parts, 2, &quarter_.packed, 1, order, 4);

  cv::resize(quarter_.tensor, enlarged_, half_.bgr.size(), 0, 0, cv::INTER_LINEAR);
  half_.tensor += enlarged_;
  cv::mixChannels(&half_.tensor, 1, &half_.packed, 1, order, 3);
  cv::transform(half_.tensor, trace_, cv::Matx13f(1, 0, 1));
  cv::resize(trace_, crest_, image.size(), 0, 0, cv::INTER_LINEAR);
  for (int y = 0; y < image.rows; ++y) {
    const auto* dx = dx_.ptr<short>(y);
    const auto* dy = dy_.ptr<short>(y);
    auto* crest = crest_.ptr<float>(y);
    for (int x = 0; x < image.cols; ++x) {
      crest[x] += kWeights[0][0] * static_cast<float>(dx[x] * dx[x] + dy[x] * dy[x]);
    }
  }
}

void EdgeCandidateFinder::FindCrests(int y, int columns) {
  for (std::vector<float>* row : {&difference_, &twice_, &marks_})
    row->resize(static_cast<std::size_t>(dx_.cols));
  const auto* tensor = half_.tensor.ptr<float>(y / 2);
  for (int i = 0; i < half_.tensor.cols; ++i, tensor += 3) {
    difference_[2 * i] = difference_[2 * i + 1] = tensor[0] - tensor[2];
    twice_[2 * i] = twice_[2 * i + 1] = 2 * tensor[1];
  }
  MarkCrests({crest_.ptr<float>(y - 1), crest_.ptr<float>(y), crest_.ptr<float>(y + 1),
              difference_.data(), twice_.data(), dx_.ptr<short>(y), dy_.ptr<short>(y)},
             columns, marks_.data());
  for (int x = 1; x + 1 < columns; ++x) {
    if (marks_[x] != 0) candidates_.push_back({.x = x, .y = y});
  }
}

const std::vector<EdgeCandidate>& EdgeCandidateFinder::Find(const cv::Mat& image) {
  PLB_CHECK(image.type() == CV_8UC3);
  // Whole pixels at every level, and room for the filters in tiny images.
  const auto padding = [](int side) { return std::max(16, (side + 3) / 4 * 4) - side; };
  const bool whole = padding(image.cols) == 0 && padding(image.rows) == 0;
  if (!whole) {
    cv::copyMakeBorder(image, padded_, 0, padding(image.rows), 0, padding(image.cols),
                       cv::BORDER_REPLICATE);
  }
  MakePyramid(whole ? image : padded_);
  candidates_.clear();
  for (int y = 1; y + 1 < image.rows; ++y) FindCrests(y, image.cols);
  DescribeAll({dx_, dy_, half_.packed, quarter_.packed}, candidates_);
  return candidates_;
}

std::unique_ptr<EdgeDetector> CreateGradientEdgeDetector() {
  return std::make_unique<GradientEdges>();
}

}  // namespace plumbline
