// SPDX-License-Identifier: MPL-2.0
// Raster images in memory, PNG and GIF output.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// RGB image: three bytes per pixel, row by row from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;
};

/// Size of a picture.
struct PictureSize {
  int width = 1600, height = 1000;  ///< in pixels, each from 64 to 4096
};

/// Writes a PNG file atomically. Throws InputError if the image has no pixels, the size of `rgb` is
/// not 3 · width · height, or the file cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

// Animations are written as GIF files, which browsers and mail programs can play.

/// Palette of up to 255 colours for several images. Each palette colour is the mean of the image
/// colours in one box of the RGB cube.
class Palette {
 public:
  /// Computes a palette for all `images` by repeatedly splitting a box of the RGB cube at its mean
  /// colour, the box with the largest variance (sum of squared distances from its mean) first.
  ///
  /// Only the upper 6 bits of each channel are distinguished. All images share the palette, so that
  /// static parts of an animation do not flicker. Cost: O(pixels). Throws InputError if there are
  /// no images, or if images are empty or differ in size.
  explicit Palette(const std::vector<Image>& images);
  int count() const { return isize(colours_) / 3; }
  /// Red, green and blue of each palette colour: 3 · count() bytes.
  const std::vector<unsigned char>& colours() const { return colours_; }
  /// 0-based index of the palette colour that represents an image colour.
  int index(unsigned char red, unsigned char green, unsigned char blue) const;

 private:
  std::vector<unsigned char> colours_;
  std::vector<unsigned char> index_;  // index of the palette colour of each cell of the RGB cube
};

/// Writes an animated GIF file that repeats endlessly; the file is written atomically. Each frame
/// is shown for `seconds`, the last one for `last_seconds` (rounded to 1/100 s, at least 2/100 s).
/// Only the part of each frame that changes is stored. The same frames always give the same bytes.
///
/// Throws InputError if there are no frames, frames are empty or differ in size, a side exceeds
/// 65535 pixels, a time is not positive, or the file cannot be written.
void write_gif(const std::filesystem::path& path, const std::vector<Image>& frames, double seconds,
               double last_seconds);

}  // namespace batten
