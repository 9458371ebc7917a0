// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// Weighs the features of an edge candidate: eight rectified sums of them, summed to the log odds
/// of an edge.
struct GradientModel {
  static constexpr int kHidden = 8;
  float hidden[8][kHidden];  ///< [feature][hidden]
  float hidden_bias[kHidden];
  float output[kHidden];
  float output_bias;
};

inline constexpr GradientModel kGradientModel = {
    .hidden =
        {{0.06981f, 0.13771f, 0.54667f, 0.19227f, -0.0865f, -0.20537f, 0.40688f, 0.21471f},
         {0.55367f, -0.29654f, 0.14659f, 0.048262f, -0.66968f, 0.081618f, -0.13685f, 0.46549f},
         {-0.028952f, -0.26814f, 0.041793f, 0.138f, 0.65658f, 0.22522f, 0.0096632f, -0.19192f},
         {0.80936f, -0.025127f, -0.12165f, -0.16647f, 0.1031f, -0.072122f, 0.047667f, 0.56339f},
         {-0.13052f, -0.020227f, 0.070937f, 0.7662f, -0.18581f, -0.35364f, -0.0089453f, 0.26378f},
         {-1.3083f, -1.2143f, -0.57257f, -0.81013f, 0.079712f, 0.046302f, 1.2564f, -0.68983f},
         {0.51507f, 0.71203f, 4.2579f, -0.28467f, 2.0642f, -0.11036f, -0.55309f, -1.8573f},
         {-0.17917f, 1.1082f, -0.24865f, -0.029576f, 0.077081f, -0.5774f, -2.0774f, 0.22872f}},
    .hidden_bias = {-0.47682f, 1.7763f, -2.7618f, 1.1441f, -0.80653f, 2.6325f, 1.2542f, -1.7013f},
    .output = {1.2717f, -0.71416f, 0.78626f, 0.78357f, 0.50018f, -0.87637f, -0.51949f, 1.0127f},
    .output_bias = -0.37004f};

}  // namespace plumbline
