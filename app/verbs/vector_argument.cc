// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/vector_argument.h"

#include <charconv>
#include <cmath>
#include <vector>

namespace plumbline {

Result<Eigen::VectorXd> ParseNumbers(const std::string& text, const std::string& option, int least,
                                     int most) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  while (good) {
    double number = 0;
    if (at != end && *at == '+') ++at;
    const auto [next, error] = std::from_chars(at, end, number);
    good = error == std::errc() && std::isfinite(number);
    if (!good) break;
    numbers.push_back(number);
    at = next;
    if (at == end) break;
    good = *at++ == ',';
  }
  const int count = static_cast<int>(numbers.size());
  if (!good || count < least || count > most) {
    const std::string wanted = least == most
                                   ? std::to_string(least)
                                   : std::to_string(least) + " to " + std::to_string(most);
    return Error{
        ErrorCode::kInvalidInput,
        option + " takes " + wanted + " numbers with commas between them, not '" + text + "'"};
  }
  return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(numbers.data(), count));
}

Result<Eigen::Vector3d> ParseDirection(const std::string& text, const std::string& option) {
  const Result<Eigen::VectorXd> numbers = ParseNumbers(text, option, 3, 3);
  if (!numbers) return numbers.error();
  const Eigen::Vector3d direction = *numbers;
  if (!(direction.norm() > 1e-9)) {
    return Error{ErrorCode::kInvalidInput, option + " has no direction: all numbers are zero"};
  }
  return Eigen::Vector3d(direction.normalized());
}

}  // namespace plumbline
