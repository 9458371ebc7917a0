// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

namespace plumbline {

/// Which way a thing is longest: along its height, or with its height the shortest of the three.
enum class Proportion { kEither, kTall, kFlat };

/// What is usual for the indoor categories of COCO.
struct CategoryHabit {
  std::string_view name;
  double largest_m;  ///< The longest side, within a factor of about 1.5.
  bool on_floor;     ///< Stands on the floor.
  Proportion proportion;
};

inline constexpr std::array<CategoryHabit, 31> kCategoryHabits = {{
    {"backpack", 0.5, false, Proportion::kTall},
    {"bed", 2.1, true, Proportion::kFlat},
    {"bench", 1.5, true, Proportion::kFlat},
    {"bicycle", 1.7, true, Proportion::kEither},
    {"book", 0.25, false, Proportion::kFlat},
    {"bottle", 0.25, false, Proportion::kTall},
    {"bowl", 0.16, false, Proportion::kFlat},
    {"cell phone", 0.15, false, Proportion::kFlat},
    {"chair", 0.9, true, Proportion::kTall},
    {"clock", 0.3, false, Proportion::kEither},
    {"couch", 1.9, true, Proportion::kFlat},
    {"cup", 0.1, false, Proportion::kTall},
    {"dining table", 1.5, true, Proportion::kFlat},
    {"handbag", 0.35, false, Proportion::kEither},
    {"keyboard", 0.45, false, Proportion::kFlat},
    {"laptop", 0.35, false, Proportion::kFlat},
    {"microwave", 0.5, false, Proportion::kFlat},
    {"mouse", 0.11, false, Proportion::kFlat},
    {"oven", 0.8, true, Proportion::kEither},
    {"potted plant", 0.6, false, Proportion::kTall},
    {"refrigerator", 1.8, true, Proportion::kTall},
    {"remote", 0.2, false, Proportion::kFlat},
    {"sink", 0.6, false, Proportion::kFlat},
    {"suitcase", 0.7, true, Proportion::kTall},
    {"teddy bear", 0.4, false, Proportion::kEither},
    {"toaster", 0.3, false, Proportion::kEither},
    {"toilet", 0.75, true, Proportion::kTall},
    {"tv", 0.9, false, Proportion::kEither},
    {"umbrella", 0.9, false, Proportion::kTall},
    {"vase", 0.3, false, Proportion::kTall},
    {"wine glass", 0.2, false, Proportion::kTall},
}};

/// nullptr for other categories.
inline const CategoryHabit* FindCategoryHabit(std::string_view name) {
  for (const CategoryHabit& habit : kCategoryHabits) {
    if (habit.name == name) return &habit;
  }
  return nullptr;
}

}  // namespace plumbline
