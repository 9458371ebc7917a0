// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/object_looks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace plumbline {
namespace {

using Rgb = std::array<double, 3>;  ///< Linear, 0 to 1.
using Lab = std::array<double, 3>;
using Matrix = std::array<Rgb, 3>;

constexpr Matrix kNormal = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
// Machado, Oliveira and Fernandes (2009), severity 1, for linear RGB.
constexpr Matrix kProtanope = {{{0.152286, 1.052583, -0.204868},
                                {0.114503, 0.786281, 0.099216},
                                {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix kDeuteranope = {{{0.367322, 0.860646, -0.227968},
                                  {0.280085, 0.672501, 0.047413},
                                  {-0.011820, 0.042940, 0.968881}}};

Rgb LinearOf(const LookColor& color) {
  const auto linear = [](double c) {
    c /= 255;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return {linear(color.red), linear(color.green), linear(color.blue)};
}

double LuminanceOf(const LookColor& color) {
  const Rgb c = LinearOf(color);
  return 0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2];
}

double Contrast(const LookColor& a, const LookColor& b) {
  const double x = LuminanceOf(a) + 0.05, y = LuminanceOf(b) + 0.05;
  return std::max(x, y) / std::min(x, y);
}

/// As an eye sees it, in CIE Lab (D65).
Lab Seen(const LookColor& color, const Matrix& eye) {
  const Rgb from = LinearOf(color);
  Rgb c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) c[i] += eye[i][k] * from[k];
    c[i] = std::clamp(c[i], 0.0, 1.0);
  }
  const auto f = [](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  };
  const double x = f((0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2]) / 0.95047);
  const double y = f(0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2]);
  const double z = f((0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2]) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

/// CIEDE2000 as Sharma, Wu and Dalal (2005) write it down.
double Difference(const Lab& a, const Lab& b) {
  constexpr double kRad = std::numbers::pi / 180;
  const auto pow7 = [](double v) {
    return std::sqrt(std::pow(v, 7) / (std::pow(v, 7) + std::pow(25.0, 7)));
  };
  const double g = 0.5 * (1 - pow7(0.5 * (std::hypot(a[1], a[2]) + std::hypot(b[1], b[2]))));
  const double a1 = (1 + g) * a[1], b1 = (1 + g) * b[1];
  const double c1 = std::hypot(a1, a[2]), c2 = std::hypot(b1, b[2]);
  const auto hue = [&](double y, double x) {
    const double h = std::atan2(y, x) / kRad;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(a[2], a1), h2 = hue(b[2], b1);
  double dh = h2 - h1;
  if (dh > 180) dh -= 360;
  if (dh < -180) dh += 360;
  double mean_h = 0.5 * (h1 + h2);
  if (std::abs(h1 - h2) > 180) mean_h += h1 + h2 < 360 ? 180 : -180;
  const double mean_l = 0.5 * (a[0] + b[0]), mean_c = 0.5 * (c1 + c2);
  const double t = 1 - 0.17 * std::cos((mean_h - 30) * kRad) + 0.24 * std::cos(2 * mean_h * kRad) +
                   0.32 * std::cos((3 * mean_h + 6) * kRad) -
                   0.20 * std::cos((4 * mean_h - 63) * kRad);
  const double l2 = (mean_l - 50) * (mean_l - 50);
  const double l = (b[0] - a[0]) / (1 + 0.015 * l2 / std::sqrt(20 + l2));
  const double c = (c2 - c1) / (1 + 0.045 * mean_c);
  const double h = 2 * std::sqrt(c1 * c2) * std::sin(0.5 * dh * kRad) / (1 + 0.015 * mean_c * t);
  const double turn = 60 * std::exp(-std::pow((mean_h - 275) / 25, 2));
  return std::sqrt(l * l + c * c + h * h - std::sin(turn * kRad) * 2 * pow7(mean_c) * c * h);
}

TEST(LookColors, AreMeasuredByTheFormulaOfItsAuthors) {
  // From the table of Sharma, Wu and Dalal.
  EXPECT_NEAR(Difference({50, 2.6772, -79.7751}, {50, 0, -82.7485}), 2.0425, 1e-4);
  EXPECT_NEAR(Difference({50, 2.5, 0}, {73, 25, -18}), 27.1492, 1e-4);
  EXPECT_NEAR(Difference({22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}), 2.0373, 1e-4);
}

TEST(LookColors, DifferForEveryEye) {
  for (std::size_t i = 0; i < kLookColors.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const LookColor &a = kLookColors[i], &b = kLookColors[k];
      EXPECT_GT(Difference(Seen(a, kNormal), Seen(b, kNormal)), 15) << i << " and " << k;
      EXPECT_GT(Difference(Seen(a, kProtanope), Seen(b, kProtanope)), 11) << i << " and " << k;
      EXPECT_GT(Difference(Seen(a, kDeuteranope), Seen(b, kDeuteranope)), 11) << i << " and " << k;
    }
  }
}

TEST(LookColors, StandOutFromBothThemesAndFromTruthAndPath) {
  const LookColor dark_panel{25, 29, 35}, light_panel{248, 249, 251};
  const LookColor truth{88, 214, 110}, path{242, 145, 50};
  for (const LookColor& color : kLookColors) {
    EXPECT_GT(Contrast(color, dark_panel), 3.5);
    EXPECT_GT(Contrast(color, light_panel), 1.85);
    EXPECT_GT(Difference(Seen(color, kNormal), Seen(truth, kNormal)), 14);
    EXPECT_GT(Difference(Seen(color, kProtanope), Seen(truth, kProtanope)), 8);
    EXPECT_GT(Difference(Seen(color, kDeuteranope), Seen(truth, kDeuteranope)), 8);
    EXPECT_GT(Difference(Seen(color, kNormal), Seen(path, kNormal)), 14);
    EXPECT_GT(Difference(Seen(color, kNormal), Seen(kNeutralLook, kNormal)), 8);
  }
}

FrameEvent Event(int frame, EventKind kind, int object) {
  FrameEvent event;
  event.frame = frame;
  event.event.kind = kind;
  event.event.object = {object};
  return event;
}

/// Objects 1 .. count, each born and confirmed two frames after the one before, none withdrawn.
std::vector<FrameEvent> Crowd(int count) {
  std::vector<FrameEvent> events;
  for (int id = 1; id <= count; ++id) {
    events.push_back(Event(2 * id, EventKind::kSpawned, id));
    events.push_back(Event(2 * id + 1, EventKind::kConfirmed, id));
  }
  return events;
}

TEST(ObjectLooks, AreDistinctForAllThatLiveAtTheSameTime) {
  const int count = 2 * static_cast<int>(kLookColors.size());
  const ObjectLooks looks = LooksOf(Crowd(count));
  std::set<std::pair<int, bool>> seen;
  for (const auto& [id, look] : looks) EXPECT_TRUE(seen.insert({look.color, look.dashed}).second);
  EXPECT_EQ(static_cast<int>(seen.size()), count);
  EXPECT_FALSE(looks.at({1}).dashed);
  EXPECT_FALSE(looks.at({static_cast<int>(kLookColors.size())}).dashed);
  EXPECT_TRUE(looks.at({count}).dashed) << "never by colour alone";
}

TEST(ObjectLooks, AreTheSameWhileARunGrows) {
  std::vector<FrameEvent> events = Crowd(9);
  events.push_back(Event(30, EventKind::kRetired, 2));
  events.push_back(Event(31, EventKind::kSpawned, 10));
  events.push_back(Event(35, EventKind::kConfirmed, 10));
  const ObjectLooks all = LooksOf(events);
  for (std::size_t n = 0; n <= events.size(); ++n) {
    for (const auto& [id, look] :
         LooksOf({events.begin(), events.begin() + static_cast<std::ptrdiff_t>(n)}))
      EXPECT_EQ(look, all.at(id)) << "object " << id.value << " after " << n << " events";
  }
}

TEST(ObjectLooks, AreNotTakenFromOneThatLivedWhenTheNewOneWasBorn) {
  // The last one is confirmed after 1 has gone, but was tentative beside it.
  std::vector<FrameEvent> events = Crowd(static_cast<int>(kLookColors.size()));
  events.push_back(Event(40, EventKind::kSpawned, 90));
  events.push_back(Event(45, EventKind::kRetired, 1));
  events.push_back(Event(50, EventKind::kConfirmed, 90));
  events.push_back(Event(60, EventKind::kSpawned, 91));
  events.push_back(Event(61, EventKind::kConfirmed, 91));
  const ObjectLooks looks = LooksOf(events);
  EXPECT_TRUE(looks.at({90}).dashed);
  EXPECT_EQ(looks.at({91}), looks.at({1})) << "free again";
}

TEST(ObjectLooks, AreNeutralForWhatWasNeverConfirmed) {
  const ObjectLooks looks =
      LooksOf({Event(1, EventKind::kSpawned, 1), Event(2, EventKind::kSpawned, 2),
               Event(3, EventKind::kConfirmed, 2)});
  EXPECT_FALSE(looks.contains({1}));
  EXPECT_TRUE(looks.contains({2}));
  EXPECT_EQ(ColorOf(ObjectLook()), kNeutralLook);
}

}  // namespace
}  // namespace plumbline
