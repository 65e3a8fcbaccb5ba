// Writes a deforming mesh as glTF 2.0 in one binary file. Internal.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/files/atomic_file.h"

namespace batten {

/// One mesh: the first frame, and all others as morph targets. An animation of its weights shows each
/// at its time; between them it blends. The JSON part comes first in the file and has the bounds of
/// all frames in it, so room is left for it and it is written last.
class GlbWriter {
 public:
  /// Throws InputError when the file would be larger than 4 GB, what AtomicFile throws.
  GlbWriter(const std::filesystem::path& path, std::vector<std::array<int, 3>> triangles,
            int points, std::vector<double> times);
  /// Appends a frame. Throws InputError for a coordinate too large for single precision.
  void write(const Points& points);
  void finish();

 private:
  struct Bounds {
    std::array<float, 3> low{}, high{};
  };
  std::string json(const std::vector<Bounds>& bounds) const;
  void put(const std::string& bytes);

  AtomicFile file_;
  size_t triangles_;
  int points_;
  std::vector<double> times_;
  std::ofstream out_;
  size_t json_room_ = 0, binary_size_ = 0;
  Points first_;  // as single precision has it
  std::vector<Bounds> bounds_;
};

}  // namespace batten
