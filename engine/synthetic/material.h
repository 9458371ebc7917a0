// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace plumbline {

/// How a surface varies; each is a function of the texture coordinates alone.
enum class Pattern {
  kPlain,
  kWood,    ///< grain along x
  kPlanks,  ///< a floor of planks along x
  kTiles,   ///< square floor tiles with joints
  kWeave,   ///< cloth
  kPlaster,
  kStripes,  ///< wallpaper, vertical stripes
  kDots,     ///< wallpaper, a small motif
  kRug,      ///< borders and a field, over `extent`, centred on 0
  kPicture,  ///< a framed abstract landscape, over `extent`, centred on 0
  kBook,     ///< a spine with bands
  kLeaf,
  kCardboard,
  kScreen,  ///< a switched-on screen over `extent`, centred on 0 (emits)
  kView     ///< what one sees through a window, over `extent`, from 0 (emits)
};

/// The looks of a surface. Colours are linear RGB.
struct Material {
  Pattern pattern = Pattern::kPlain;
  Eigen::Vector3f color{0.6f, 0.6f, 0.6f};   ///< Diffuse reflectance, 0 .. 1.
  Eigen::Vector3f accent{0.4f, 0.4f, 0.4f};  ///< The pattern's second colour.
  float scale = 1;                           ///< Size of the pattern, 1 = natural.
  float gloss = 0;                           ///< Reflectance at normal incidence; 0: matte.
  float roughness = 0.2f;                    ///< Spread of the reflection, tangent of the angle.
  float emission = 0;                        ///< Radiance of its own, times colour or pattern.
  Eigen::Vector2f extent{1, 1};              ///< [m], for patterns that fill a rectangle
  std::uint32_t seed = 0;
};

/// A colour as one picks it on a screen: 0xRRGGBB in sRGB, as linear RGB.
Eigen::Vector3f ColorFromHex(std::uint32_t rgb);
/// Inverse of the sRGB transfer function's linear side: linear [0, 1] to encoded [0, 1].
float EncodeSrgb(float linear);

/// The colour of the pattern at texture coordinates [m]: reflectance, or for emitting materials the
/// colour of the emission. Detail finer than `footprint_m` fades into its mean.
Eigen::Vector3f PatternColor(const Material& material, const Eigen::Vector3f& texture,
                             float footprint_m);

/// Smooth noise in [0, 1] with features of size 1.
float ValueNoise(const Eigen::Vector3f& point, std::uint32_t seed);
/// Sum of `octaves` of it, each half as strong and twice as fine, in [0, 1].
float FractalNoise(const Eigen::Vector3f& point, int octaves, std::uint32_t seed);
/// A well mixed number in [0, 1) for a cell of a pattern.
float CellNoise(int x, int y, int z, std::uint32_t seed);

}  // namespace plumbline
