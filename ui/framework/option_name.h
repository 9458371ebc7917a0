// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace plumbline {

/// What a field of an options struct is called in a form, and under which heading it stands.
struct OptionName {
  std::string_view key;  ///< As in JSON and after --set.
  std::string_view group;
  std::string_view name;
};

}  // namespace plumbline
