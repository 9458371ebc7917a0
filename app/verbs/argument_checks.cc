// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/argument_checks.h"

#include <charconv>
#include <cstdint>
#include <string>

namespace plumbline {

CLI::Validator IsSeed() {
  return {[](const std::string& text) -> std::string {
            std::uint64_t seed = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
            if (error == std::errc() && end == text.data() + text.size()) return "";
            return "'" + text + "' is no seed: write a whole number from 0";
          },
          "", "seed"};
}

}  // namespace plumbline
