// SPDX-License-Identifier: MPL-2.0
// Paths of test files.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include <unistd.h>

namespace batten_test {

/// Reference values: tests/reference/<name>.
inline nlohmann::json reference(const std::string& name) {
  return nlohmann::json::parse(
      std::ifstream(std::string(BATTEN_SOURCE_DIR "/tests/reference/") + name));
}

/// Optional real input that is not part of the repository (BATTEN_TEST_DATA, or ../shared/data): an
/// empty path if it is missing; the test should then report that it is skipped.
inline std::filesystem::path optional_data(const std::string& name) {
  const char* set = std::getenv("BATTEN_TEST_DATA");
  const std::filesystem::path base = set ? set : BATTEN_SOURCE_DIR "/../shared/data";
  const auto path = base / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path{};
}

/// An empty folder for one test.
inline std::filesystem::path scratch(const std::string& name) {
  const auto path =
      std::filesystem::temp_directory_path() / ("batten_test_" + std::to_string(getpid())) / name;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace batten_test
