// Raster images in memory, PNG and GIF output, and the check for a display.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// RGB image, row by row from the top, three bytes per pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;
};

/// Size of a picture.
struct PictureSize {
  int width = 1600, height = 1000;  ///< pixels, 64 to 4096
};

/// Writes a PNG, atomically. Throws InputError if the image has no pixels, its number of bytes is
/// not 3 · width · height, or the file cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

// Animations are written as GIF files, which browsers and mail programs can play.

/// Colour palette of up to 255 colours shared by several images. Each palette colour is the mean
/// colour of one box of the RGB cube.
class Palette {
 public:
  /// Computes the palette by repeatedly splitting the box with the largest variance (sum of squared
  /// distances from its mean) at its mean.
  ///
  /// Colours are distinguished by their upper 6 bits per channel. All frames use one palette, so
  /// that static parts do not flicker. Cost: O(pixels). Throws InputError for invalid frames, like
  /// write_gif().
  explicit Palette(const std::vector<Image>& images);
  /// Number of colours.
  int count() const { return isize(colours_) / 3; }
  /// Red, green and blue of each colour: 3 · count() bytes.
  const std::vector<unsigned char>& colours() const { return colours_; }
  /// Index (0-based) of the palette colour that represents an image colour.
  int index(unsigned char red, unsigned char green, unsigned char blue) const;

 private:
  std::vector<unsigned char> colours_;
  std::vector<unsigned char> index_;  // palette index of each cell of the RGB cube
};

/// Writes a GIF that plays the frames in a loop, atomically. Each frame is shown for `seconds`, the
/// last one for `last_seconds` (rounded to 1/100 s, at least 2/100). Only the changed part of each
/// frame is written; the same frames give the same bytes.
///
/// Throws InputError if there are no frames, frames are empty or differ in size, a side exceeds
/// 65535 pixels, a time is not positive, or the file cannot be written.
void write_gif(const std::filesystem::path& path, const std::vector<Image>& frames, double seconds,
               double last_seconds);

// The X server used for drawing.

/// Throws InputError if there is no X server that VTK can draw with; VTK itself would abort the
/// process. Call it on the main thread, before a long computation that ends in pictures.
void require_display();

}  // namespace batten
