// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/material.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

std::uint32_t Mix(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352dU;
  h ^= h >> 15;
  h *= 0x846ca68bU;
  return h ^ (h >> 16);
}

float Smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

Vector3f Blend(const Vector3f& a, const Vector3f& b, float t) { return a + (b - a) * t; }

/// How much of a detail of `size_m` is left at this footprint.
float Detail(float size_m, float footprint_m) {
  return std::clamp(2 - 2 * footprint_m / size_m, 0.0f, 1.0f);
}

/// Share of a line of `width` at distance `d` from its middle, widened to the footprint and then
/// fainter.
float Line(float d, float width, float footprint) {
  const float wide = std::max(width, footprint);
  return std::clamp(1.5f - 2 * std::abs(d) / wide, 0.0f, 1.0f) * std::min(1.0f, width / wide);
}

Vector3f Wood(const Material& m, const Vector3f& t, float footprint) {
  const Vector3f p = t / m.scale;
  const float wave = FractalNoise({p.x() * 1.3f, p.y() * 9, p.z() * 9}, 2, m.seed);
  const float rings = 0.5f + 0.5f * std::sin(40 * wave);
  const float fine = Detail(0.012f, footprint), finer = Detail(0.006f, footprint);
  const float streaks =
      finer > 0 ? ValueNoise({p.x() * 7, p.y() * 260, p.z() * 260}, m.seed + 7) : 0.5f;
  const float mix = 0.35f + 0.4f * (wave - 0.5f) + fine * 0.3f * (rings - 0.5f) +
                    finer * 0.35f * (streaks - 0.5f);
  return Blend(m.color, m.accent, std::clamp(mix, 0.0f, 1.0f));
}

Vector3f Planks(const Material& m, const Vector3f& t, float footprint) {
  const float width = 0.15f * m.scale, length = 1.4f * m.scale;
  const float row = std::floor(t.y() / width);
  const float shift = CellNoise(static_cast<int>(row), 3, 0, m.seed) * length;
  const float column = std::floor((t.x() + shift) / length);
  const int r = static_cast<int>(row), c = static_cast<int>(column);
  const float across = t.y() - row * width, along = t.x() + shift - column * length;
  Vector3f color = Wood(m, t + Vector3f(0, 0, 3.1f * CellNoise(r, c, 1, m.seed)), footprint);
  color *= 0.84f + 0.32f * CellNoise(r, c, 2, m.seed);
  const float joint = std::max(Line(std::min(across, width - across), 0.004f, footprint),
                               Line(std::min(along, length - along), 0.004f, footprint));
  return color * (1 - 0.6f * joint);
}

Vector3f Tiles(const Material& m, const Vector3f& t, float footprint) {
  const float size = 0.3f * m.scale;
  const float column = std::floor(t.x() / size), row = std::floor(t.y() / size);
  const float u = t.x() - column * size, v = t.y() - row * size;
  const float tone = CellNoise(static_cast<int>(column), static_cast<int>(row), 0, m.seed);
  const float cloud = FractalNoise(t * 9, 3, m.seed) - 0.5f;
  const Vector3f color = m.color * (0.92f + 0.12f * tone + 0.2f * cloud);
  const float joint = std::max(Line(std::min(u, size - u), 0.006f, footprint),
                               Line(std::min(v, size - v), 0.006f, footprint));
  return Blend(color, m.accent, joint);
}

Vector3f Weave(const Material& m, const Vector3f& t, float footprint) {
  const float threads = 2 * 3.14159f / (0.004f * m.scale);
  const float cross = std::sin(t.x() * threads) * std::sin((t.y() + t.z()) * threads);
  const float mottle = FractalNoise(t * 22 / m.scale, 3, m.seed) - 0.5f;
  const float fine = Detail(0.006f, footprint);
  const float fuzz = fine > 0 ? ValueNoise(t * 420, m.seed + 5) - 0.5f : 0;
  const float tone = 1 + 0.3f * mottle + fine * (0.12f * cross + 0.2f * fuzz);
  return Blend(m.color, m.accent, std::clamp(0.5f * mottle, 0.0f, 0.4f)) * tone;
}

Vector3f Plaster(const Material& m, const Vector3f& t, float footprint) {
  const float broad = FractalNoise(t * 1.1f, 2, m.seed) - 0.5f;
  const float detail = Detail(0.012f, footprint);
  const float fine = detail > 0 ? ValueNoise(t * 130, m.seed + 1) - 0.5f : 0;
  return m.color * (1 + 0.05f * broad + 0.07f * detail * fine);
}

Vector3f Stripes(const Material& m, const Vector3f& t, float footprint) {
  const float period = 0.16f * m.scale;
  const float u = t.x() / period - std::floor(t.x() / period);
  const float edge = std::max(0.01f, footprint / period);
  const float band = Smooth(0.25f - edge, 0.25f + edge, u) - Smooth(0.75f - edge, 0.75f + edge, u);
  return Blend(Plaster(m, t, footprint), m.accent, band);
}

Vector3f Dots(const Material& m, const Vector3f& t, float footprint) {
  const float period = 0.12f * m.scale;
  const float row = std::floor(t.y() / period);
  const float shifted = t.x() / period + 0.5f * (row - 2 * std::floor(row / 2));
  const float u = shifted - std::floor(shifted) - 0.5f, v = t.y() / period - row - 0.5f;
  const float angle = std::atan2(v, u), radius = std::hypot(u, v);
  const float petal = 0.2f + 0.1f * std::cos(6 * angle);
  const float edge = 0.02f + footprint / period;
  const float inside = Smooth(petal + edge, petal - edge, radius);
  return Blend(Plaster(m, t, footprint), m.accent, inside * std::min(1.0f, 0.04f / footprint));
}

Vector3f Rug(const Material& m, const Vector3f& t, float footprint) {
  const float x = std::abs(t.x()), y = std::abs(t.y());
  const float border = std::min(m.extent.x() / 2 - x, m.extent.y() / 2 - y);
  const Vector3f third = 0.5f * (m.color + m.accent);
  const float band = Smooth(0.06f, 0.065f, border) - Smooth(0.10f, 0.105f, border) +
                     Smooth(0.13f, 0.134f, border) - Smooth(0.145f, 0.149f, border);
  Vector3f color = Blend(m.color, m.accent, band);
  if (border > 0.16f) {
    const float cell = 0.26f * m.scale;
    const float u = std::abs(t.x() / cell - std::round(t.x() / cell));
    const float v = std::abs(t.y() / cell - std::round(t.y() / cell));
    const float diamond = u + v;
    color = Blend(third, m.color, Smooth(0.30f, 0.33f, diamond));
    color = Blend(color, m.accent, Smooth(0.16f, 0.13f, diamond));
  }
  Material pile = m;
  pile.color = color;
  pile.accent = color * 0.7f;
  pile.scale = 1.6f;
  return Weave(pile, t, footprint);
}

/// Hills before a sky: each layer's crest is smooth noise.
Vector3f Landscape(const Material& m, const Vector2f& uv, float aspect, float edge) {
  const Vector3f paper(0.82f, 0.80f, 0.76f);
  Vector3f color = Blend(m.color * 1.15f + Vector3f::Constant(0.12f), paper, 0.6f * uv.y());
  const Vector2f sun(0.25f + 0.5f * CellNoise(1, 2, 3, m.seed),
                     0.62f + 0.16f * CellNoise(3, 2, 1, m.seed));
  const float from_sun = std::hypot((uv.x() - sun.x()) * aspect, uv.y() - sun.y());
  color = Blend(color, Vector3f(0.85f, 0.48f, 0.22f), Smooth(0.11f + edge, 0.11f - edge, from_sun));
  for (int layer = 0; layer < 4; ++layer) {
    const auto number = static_cast<float>(layer);
    const Vector3f along(uv.x() * aspect * (1.6f + 0.5f * number), number * 7.3f, 0);
    const float crest = 0.58f - 0.13f * number + 0.22f * (FractalNoise(along, 3, m.seed) - 0.5f);
    const Vector3f hill = Blend(m.color, m.accent, 0.15f + 0.28f * number);
    color = Blend(color, hill, Smooth(crest + edge, crest - edge, uv.y()));
  }
  return color;
}

/// Fields of colour over one another, with soft borders.
Vector3f ColorFields(const Material& m, const Vector2f& uv, float aspect, float edge) {
  Vector3f color = Blend(Vector3f(0.80f, 0.76f, 0.69f), m.color, 0.25f);
  for (int i = 0; i < 5; ++i) {
    const auto draw = [&](int k) { return CellNoise(i, k, 5, m.seed); };
    const Vector2f center(0.15f + 0.7f * draw(0), 0.15f + 0.7f * draw(1));
    const Vector2f half(0.08f + 0.2f * draw(2), 0.08f + 0.2f * draw(3));
    const Vector2f off((uv.x() - center.x()) * aspect, uv.y() - center.y());
    const float wobble = 0.02f * (FractalNoise({uv.x() * 9, uv.y() * 9, 0}, 2, m.seed + 1) - 0.5f);
    const float outside = i % 2 == 0
                              ? std::max(std::abs(off.x()) - half.x(), std::abs(off.y()) - half.y())
                              : off.norm() - half.x();
    const Vector3f fill =
        i == 3 ? Vector3f(0.78f, 0.42f, 0.16f) : Blend(m.color, m.accent, draw(4));
    color = Blend(color, fill, Smooth(edge, -edge, outside + wobble));
  }
  return color;
}

/// A framed picture with a paper border.
Vector3f Picture(const Material& m, const Vector3f& t, float footprint) {
  const Vector2f uv(t.x() / m.extent.x() + 0.5f, t.y() / m.extent.y() + 0.5f);
  const float border = std::min(std::min(uv.x(), 1 - uv.x()) * m.extent.x(),
                                std::min(uv.y(), 1 - uv.y()) * m.extent.y());
  if (border < 0.05f) return {0.82f, 0.80f, 0.76f};
  const float aspect = m.extent.x() / m.extent.y();
  const float edge = std::max(0.006f, 1.5f * footprint / m.extent.y());
  const Vector3f color =
      m.seed % 2 == 0 ? Landscape(m, uv, aspect, edge) : ColorFields(m, uv, aspect, edge);
  return color * (0.92f + 0.16f * FractalNoise(t * 60, 2, m.seed + 9));
}

Vector3f Book(const Material& m, const Vector3f& t, float footprint) {
  const float position = t.x() / 0.2f;
  const float band = Line(std::abs(position) - 0.36f, 0.05f, footprint / 0.2f) +
                     0.8f * Smooth(0.22f, 0.2f, std::abs(position - 0.05f)) *
                         Detail(0.01f, footprint) *
                         (ValueNoise(t * 190, m.seed) > 0.55f ? 1.0f : 0.0f);
  return Blend(m.color, m.accent, std::min(1.0f, 0.6f * band));
}

Vector3f Leaf(const Material& m, const Vector3f& t, float footprint) {
  const float vein = Line(t.y(), 0.004f, footprint);
  const float tone = 0.75f + 0.5f * FractalNoise(t * 14, 2, m.seed);
  return Blend(m.color * tone, m.accent, 0.5f * vein);
}

Vector3f Cardboard(const Material& m, const Vector3f& t, float footprint) {
  const float flute = Detail(0.008f, footprint) * 0.05f * std::sin(t.y() * 1000);
  return m.color * (0.95f + 0.14f * (FractalNoise(t * 7, 3, m.seed) - 0.5f) + flute);
}

Vector3f Screen(const Material& m, const Vector3f& t, float footprint) {
  const float u = t.x() / m.extent.x() + 0.5f, v = t.y() / m.extent.y() + 0.5f;
  Vector3f color = Blend(Vector3f(0.02f, 0.06f, 0.16f), Vector3f(0.10f, 0.22f, 0.30f), v);
  const auto window = [&](float u0, float v0, float u1, float v1, const Vector3f& fill) {
    if (u < u0 || u > u1 || v < v0 || v > v1) return;
    color = v > v1 - 0.05f ? Vector3f(0.25f, 0.27f, 0.3f) : fill;
    const float line = std::sin((v - v0) * 190);
    const float reach =
        u0 +
        (u1 - u0) * (0.35f + 0.6f * CellNoise(static_cast<int>((v - v0) * 30.24f), 5, 0, m.seed));
    if (v < v1 - 0.08f && u > u0 + 0.02f && u < reach) {
      color = Blend(color, m.accent, 0.5f * Detail(0.012f, footprint) * std::max(0.0f, line));
    }
  };
  window(0.08f, 0.18f, 0.55f, 0.88f, {0.015f, 0.018f, 0.022f});
  window(0.48f, 0.10f, 0.93f, 0.66f, {0.55f, 0.56f, 0.55f});
  return color;
}

Vector3f View(const Material& m, const Vector3f& t) {
  const float u = t.x() / m.extent.x(), v = t.y() / m.extent.y();
  const float cloud = FractalNoise({u * 3, v * 5, 0}, 4, m.seed);
  Vector3f color =
      Blend(Vector3f(0.92f, 0.96f, 1.0f), Vector3f(0.60f, 0.78f, 1.0f), Smooth(0.35f, 1.0f, v));
  color = Blend(color, Vector3f(1, 1, 1), 0.7f * Smooth(0.45f, 0.75f, cloud));
  const float crest = 0.34f + 0.22f * (FractalNoise({u * 5, 3.3f, 0}, 3, m.seed + 1) - 0.4f);
  const Vector3f trees = Blend(Vector3f(0.10f, 0.18f, 0.06f), Vector3f(0.30f, 0.42f, 0.16f),
                               FractalNoise({u * 14, v * 14, 0}, 3, m.seed + 2));
  return Blend(color, trees, Smooth(crest + 0.05f, crest - 0.05f, v));
}

}  // namespace

Vector3f ColorFromHex(std::uint32_t rgb) {
  Vector3f color;
  for (int i = 0; i < 3; ++i) {
    const float c = static_cast<float>((rgb >> (16 - 8 * i)) & 255) / 255.0f;
    color[i] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  }
  return color;
}

float EncodeSrgb(float linear) {
  const float c = std::clamp(linear, 0.0f, 1.0f);
  return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}

float CellNoise(int x, int y, int z, std::uint32_t seed) {
  const std::uint32_t h = Mix(
      static_cast<std::uint32_t>(x) * 0x8da6b343U ^ static_cast<std::uint32_t>(y) * 0xd8163841U ^
      static_cast<std::uint32_t>(z) * 0xcb1ab31fU ^ (seed * 0x9e3779b9U + 1));
  return static_cast<float>(h >> 8) * 0x1.0p-24f;
}

float ValueNoise(const Vector3f& point, std::uint32_t seed) {
  const Vector3f base = point.array().floor();
  const Vector3f f = point - base;
  const Vector3f w = f.array().square() * (3 - 2 * f.array());
  const int x = static_cast<int>(base.x()), y = static_cast<int>(base.y()),
            z = static_cast<int>(base.z());
  const auto edge = [&](int dy, int dz) {
    const float a = CellNoise(x, y + dy, z + dz, seed);
    return a + (CellNoise(x + 1, y + dy, z + dz, seed) - a) * w.x();
  };
  const float low = edge(0, 0) + (edge(1, 0) - edge(0, 0)) * w.y();
  const float high = edge(0, 1) + (edge(1, 1) - edge(0, 1)) * w.y();
  return low + (high - low) * w.z();
}

float FractalNoise(const Vector3f& point, int octaves, std::uint32_t seed) {
  float sum = 0, weight = 1, total = 0;
  Vector3f p = point;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * ValueNoise(p, seed + static_cast<std::uint32_t>(i) * 101);
    total += weight;
    weight *= 0.5f;
    p *= 2;
  }
  return sum / total;
}

Vector3f PatternColor(const Material& m, const Vector3f& t, float footprint) {
  switch (m.pattern) {
    case Pattern::kPlain:
      return m.color;
    case Pattern::kWood:
      return Wood(m, t, footprint);
    case Pattern::kPlanks:
      return Planks(m, t, footprint);
    case Pattern::kTiles:
      return Tiles(m, t, footprint);
    case Pattern::kWeave:
      return Weave(m, t, footprint);
    case Pattern::kPlaster:
      return Plaster(m, t, footprint);
    case Pattern::kStripes:
      return Stripes(m, t, footprint);
    case Pattern::kDots:
      return Dots(m, t, footprint);
    case Pattern::kRug:
      return Rug(m, t, footprint);
    case Pattern::kPicture:
      return Picture(m, t, footprint);
    case Pattern::kBook:
      return Book(m, t, footprint);
    case Pattern::kLeaf:
      return Leaf(m, t, footprint);
    case Pattern::kCardboard:
      return Cardboard(m, t, footprint);
    case Pattern::kScreen:
      return Screen(m, t, footprint);
    case Pattern::kView:
      return View(m, t);
  }
  return m.color;
}

}  // namespace plumbline
