// What a run of `batten sequence` is asked beside its scene.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace batten {

struct SequenceTask {
  /// Frames that this run makes, counted from 1: so that several runs share the work. None: all.
  std::optional<std::pair<int, int>> frames;

  /// The name of a file that each run of a part has for itself: "walk.png", or "walk_3-7.png".
  std::string name_of(const std::filesystem::path& file) const;
};

}  // namespace batten
