// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace plumbline {

/// The 80 categories of COCO, in the order in which networks give them.
std::span<const std::string_view> CocoCategories();
/// The number (1 to 90) that COCO's annotations have for one of its categories; nothing for others.
std::optional<int> CocoNumber(std::string_view category);
/// What files in COCO's format number categories of ours from, beyond all of COCO's.
inline constexpr int kFirstNumberBeyondCoco = 1000;
/// The 20 categories of PASCAL VOC, in the usual order, by the names that COCO has for them.
std::span<const std::string_view> VocCategories();

/// The name of a category as models and mapper have it: that of COCO where `name` is another word
/// for one of its categories (sofa, TV_Monitor, dining_table), else `name` in lower case with
/// spaces.
std::string CategoryName(std::string_view name);

/// Whether things of a category go from place to place by themselves: vehicles, people, animals.
bool MovesByItself(std::string_view category);

}  // namespace plumbline
