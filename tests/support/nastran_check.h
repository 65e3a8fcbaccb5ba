// SPDX-License-Identifier: MPL-2.0
// Independent check of a Nastran deck and its edited copy.
#pragma once

#include <cstdio>
#include <cstdlib>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {

/// The JSON output of nastran_check.py; null, with a warning, if Python's numpy is missing.
inline nlohmann::json deck_changes(const std::filesystem::path& before,
                                   const std::filesystem::path& after) {
  if (std::system("/usr/bin/python3 -c 'import numpy' > /dev/null 2>&1") != 0) {
    WARN("skipped: python3 has no module numpy");
    return {};
  }
  const std::string command = "/usr/bin/python3 '" BATTEN_SOURCE_DIR
                              "/tests/support/nastran_check.py' '" +
                              before.string() + "' '" + after.string() + "'";
  FILE* const pipe = popen(command.c_str(), "r");
  REQUIRE(pipe);
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  REQUIRE(pclose(pipe) == 0);
  return nlohmann::json::parse(text);
}

/// Only coordinates of nodes differ, and spiders are rigid to `rounding`, according to that script.
inline void check_deck_changes(const std::filesystem::path& before,
                               const std::filesystem::path& after, double rounding) {
  const auto changes = deck_changes(before, after);
  if (changes.is_null()) return;
  INFO(before.string());
  CHECK(changes["other"] == "");
  CHECK(changes["moved"] > 0);
  CHECK(changes["bent"].get<double>() <= rounding);
}

}  // namespace batten_test
