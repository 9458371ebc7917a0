// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// One visitor out of several lambdas, for std::visit. Give one for every type of the variant and
/// none that takes `auto`: then a type that is added does not compile before it is handled.
template <typename... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
template <typename... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

}  // namespace plumbline
