// Pictures that move: GIF, which every browser, mail and chat program plays.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/core/index.h"
#include "batten/io/pictures/image.h"

namespace batten {

/// Up to 255 colours that stand for those of several pictures, each given by the box of the colour
/// cube that it is the mean of.
class Palette {
 public:
  /// Boxes of colours are halved, each time the one with the largest sum of squared distances from
  /// its mean, at that mean. Colours are told apart by their upper 6 bits a channel. One palette
  /// for all frames, so that what stands still does not flicker. O(pixels). Throws InputError: no
  /// pictures.
  explicit Palette(const std::vector<Image>& images);
  int count() const { return count_of(colours_) / 3; }
  /// Red, green, blue of each colour.
  const std::vector<unsigned char>& colours() const { return colours_; }
  /// Of a colour of the pictures.
  int index(unsigned char red, unsigned char green, unsigned char blue) const;

 private:
  std::vector<unsigned char> colours_;
  std::vector<unsigned char> index_;  // of each cell of the cube
};

/// One GIF that plays the frames in a loop, each for so many seconds (rounded to 1/100 s, at least
/// 2/100); `last_seconds`: the last one, before it begins again. Of each frame only what changed is
/// written. Whole or not at all; the same frames give the same bytes. Throws
/// InputError: no frames, frames of different sizes or of none, more than 65535 pixels a side, a
/// time that is not above 0, a file that cannot be written.
void write_gif(const std::filesystem::path& path, const std::vector<Image>& frames, double seconds,
               double last_seconds);

}  // namespace batten
