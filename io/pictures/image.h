// A picture in memory.
#pragma once

#include <filesystem>
#include <vector>

namespace batten {

/// Red, green and blue of each pixel, row by row from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;
};

struct PictureSize {
  int width = 1600, height = 1000;  ///< pixels, 64 to 4096
};

/// Writes a PNG, which appears whole or not at all. Throws InputError: no pixels, a number of bytes
/// other than 3 · width · height, a file that cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace batten
