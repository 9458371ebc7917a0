// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/edge_level.h"

#include <algorithm>

namespace plumbline {
namespace {

constexpr double kRate = 0.1;  ///< How fast it follows, per independent look.

void Follow(double& level, double surplus, double looks) {
  level = std::max(EdgeLevel::kUsual, level + kRate * looks * (surplus - level));
}

}  // namespace

void EdgeLevel::Add(const std::string& category, double surplus, double looks) {
  Follow(of_category_.try_emplace(category, all_).first->second, surplus, looks);
  Follow(all_, surplus, looks);
}

double EdgeLevel::Of(const std::string& category) const {
  const auto own = of_category_.find(category);
  return own == of_category_.end() ? all_ : std::min(all_, own->second);
}

void EdgeLevel::Save(ByteWriter& out) const {
  out.Put(all_);
  out.Put(static_cast<std::uint32_t>(of_category_.size()));
  for (const auto& [category, level] : of_category_) {
    out.Put(static_cast<std::uint32_t>(category.size()));
    for (const char letter : category) out.Put(letter);
    out.Put(level);
  }
}

void EdgeLevel::Restore(ByteReader& in) {
  all_ = in.Get<double>();
  of_category_.clear();
  const auto count = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    std::string category;
    const auto letters = in.Get<std::uint32_t>();
    for (std::uint32_t k = 0; k < letters && in.ok(); ++k) category += in.Get<char>();
    of_category_[category] = in.Get<double>();
  }
}

}  // namespace plumbline
