// SPDX-License-Identifier: MPL-2.0
// Catch2, whichever major version is installed.
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#include <concepts>
#include <string>
using Catch::Approx;
namespace Catch {
namespace Matchers {
/// In version 3, Contains() of a text is called ContainsSubstring().
template <typename Text>
requires std::convertible_to<Text, std::string> StringContainsMatcher Contains(Text&& text) {
  return ContainsSubstring(std::string(text));
}
}  // namespace Matchers
using Matchers::Contains;
}  // namespace Catch
#else
#include <catch2/catch.hpp>
#endif
