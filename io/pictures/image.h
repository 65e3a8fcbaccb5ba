// A picture in memory.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/core/containers.h"

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


// Animations are written as GIF files, which browsers and mail programs play.

/// A palette has up to 255 colours, which stand for all colours of several pictures. Each is the
/// mean colour of one box of the colour cube.
class Palette {
 public:
  /// Computes the palette: the box with the largest sum of squared distances from its mean is cut
  /// in two at that mean, again and again. Colours are told apart by their upper 6 bits a channel.
  /// All frames use one palette, so that what stands still does not flicker. O(pixels). Throws
  /// InputError as write_gif() does of its frames.
  explicit Palette(const std::vector<Image>& images);
  int count() const { return isize(colours_) / 3; }
  /// Red, green and blue of each colour: 3 count() numbers.
  const std::vector<unsigned char>& colours() const { return colours_; }
  /// The colour of the palette, counted from 0, that stands for a colour of the pictures.
  int index(unsigned char red, unsigned char green, unsigned char blue) const;

 private:
  std::vector<unsigned char> colours_;
  std::vector<unsigned char> index_;  // of each cell of the cube
};

/// Writes one GIF that plays the frames in a loop. It shows each frame for `seconds`, the last one
/// for `last_seconds` (rounded to 1/100 s, at least 2/100). Of each frame only what changed is
/// written. The file appears whole or not at all; the same frames give the same bytes. Throws
/// InputError: no frames, frames of different sizes or of none, more than 65535 pixels a side, a
/// time that is not above 0, a file that cannot be written.
void write_gif(const std::filesystem::path& path, const std::vector<Image>& frames, double seconds,
               double last_seconds);


// The X server that pictures are drawn with.

/// Throws InputError when there is no X server that VTK can draw with: VTK itself would end the
/// program. Call it before a long computation that ends in pictures, on the main thread.
void require_display();

}  // namespace batten
