// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/image.h"

#include <gif_lib.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <ostream>
#include <string>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"

namespace batten {

void write_png(const std::filesystem::path& path, const Image& image) {
  const size_t row = size_t{3} * static_cast<size_t>(std::max(image.width, 0));
  if (image.width < 1 || image.height < 1 || image.rgb.size() != row * image.height)
    throw InputError(path.string() + ": found a picture of " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) + " pixels with " +
                     std::to_string(image.rgb.size()) + " bytes, expected three per pixel");
  AtomicFile file(path);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr))
    throw Error(path.string() + ": libpng cannot encode this picture: " + png.message);
  bytes.resize(size);
  file.write([&](std::ostream& out) { out << bytes; });
  file.commit();
}

namespace {

constexpr int kBits = 6, kCells = 1 << (3 * kBits), kMapSize = 256;
/// Colour index of unchanged pixels: GIF compresses long runs of one index well.
constexpr int kUnchanged = 255, kMostColours = kUnchanged;

int cell_of(const unsigned char* rgb) {
  constexpr int drop = 8 - kBits;
  return (rgb[0] >> drop) << (2 * kBits) | (rgb[1] >> drop) << kBits | rgb[2] >> drop;
}

/// Pixel count and colour sum of one cell of the RGB cube.
struct Cell {
  int cell = 0;
  double pixels = 0;
  std::array<double, 3> sum{};
  double mean(int channel) const { return sum[channel] / pixels; }
};

/// A set of cells that share one palette colour.
struct Box {
  std::vector<Cell> cells;
  std::array<double, 3> mean{};
  double spread = 0;  // Σ pixels |colour - mean|²
  int widest = 0;     // channel with the largest part of the spread

  void measure() {
    double pixels = 0;
    std::array<double, 3> sum{}, part{};
    for (const Cell& cell : cells) {
      pixels += cell.pixels;
      for (size_t c = 0; c < 3; ++c) sum[c] += cell.sum[c];
    }
    for (size_t c = 0; c < 3; ++c) mean[c] = sum[c] / pixels;
    for (const Cell& cell : cells)
      for (int c = 0; c < 3; ++c) {
        const double d = cell.mean(c) - mean[c];
        part[c] += cell.pixels * d * d;
      }
    spread = part[0] + part[1] + part[2];
    widest = static_cast<int>(std::max_element(part.begin(), part.end()) - part.begin());
  }
};

void check(const std::vector<Image>& frames) {
  if (frames.empty()) throw InputError("found no pictures, expected one or more");
  for (const Image& frame : frames) {
    if (frame.width < 1 || frame.height < 1 || frame.width > 65535 || frame.height > 65535 ||
        frame.rgb.size() != size_t{3} * static_cast<size_t>(frame.width) * frame.height)
      throw InputError(
          "found a picture of " + std::to_string(frame.width) + " x " +
          std::to_string(frame.height) + " pixels with " + std::to_string(frame.rgb.size()) +
          " bytes, expected 1 to 65535 pixels in each direction and three bytes per pixel");
    if (frame.width != frames.front().width || frame.height != frames.front().height)
      throw InputError("found pictures of " + std::to_string(frames.front().width) + " x " +
                       std::to_string(frames.front().height) + " and " +
                       std::to_string(frame.width) + " x " + std::to_string(frame.height) +
                       " pixels, expected one size");
  }
}

struct Rectangle {
  int left = 0, top = 0, width = 0, height = 0;
};

/// The smallest rectangle that contains all differing pixels; a single pixel if none differ.
Rectangle changed(const std::vector<unsigned char>& before, const std::vector<unsigned char>& now,
                  int width, int height) {
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t at = static_cast<size_t>(y) * static_cast<size_t>(width) + x;
      if (before[at] == now[at]) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

int hundredths(double seconds) {
  return static_cast<int>(std::clamp(std::round(100 * seconds), 2.0, 65535.0));
}

/// Encodes a GIF frame by frame.
class GifWriter {
 public:
  /// `path`: name of the file in messages.
  GifWriter(const std::filesystem::path& path, int width, int height)
      : path_(path), width_(width), height_(height), now_(pixels()), row_(columns()) {
    int error = 0;
    gif_.reset(EGifOpen(&bytes_, append, &error));
    if (!gif_) fail(error);
  }

  void write_colours(const Palette& palette) {
    EGifSetGifVersion(gif_.get(), true);
    std::array<GifColorType, kMapSize> colours{};
    for (int i = 0; i < palette.count(); ++i) {
      const unsigned char* rgb = &palette.colours()[3 * i];
      colours[i] = {rgb[0], rgb[1], rgb[2]};
    }
    const std::unique_ptr<ColorMapObject, void (*)(ColorMapObject*)> map(
        GifMakeMapObject(kMapSize, colours.data()), GifFreeMapObject);
    if (!map) throw std::bad_alloc();
    expect(EGifPutScreenDesc(gif_.get(), width_, height_, 8, 0, map.get()));
  }

  /// Makes players loop the animation forever.
  void repeat_forever() {
    const unsigned char forever[3] = {1, 0, 0};
    expect(EGifPutExtensionLeader(gif_.get(), APPLICATION_EXT_FUNC_CODE));
    expect(EGifPutExtensionBlock(gif_.get(), 11, "NETSCAPE2.0"));
    expect(EGifPutExtensionBlock(gif_.get(), 3, forever));
    expect(EGifPutExtensionTrailer(gif_.get()));
  }

  /// Writes the part of a frame that changed; the first frame is written completely.
  void write_frame(const Image& frame, const Palette& palette, double seconds) {
    for (size_t p = 0; p < now_.size(); ++p) {
      const unsigned char* rgb = &frame.rgb[3 * p];
      now_[p] = static_cast<unsigned char>(palette.index(rgb[0], rgb[1], rgb[2]));
    }
    write_control(seconds);
    write_pixels(is_first() ? Rectangle{0, 0, width_, height_}
                            : changed(before_, now_, width_, height_));
    before_ = now_;
  }

  /// Ends the file and returns its bytes.
  const std::string& close() {
    int error = 0;
    if (EGifCloseFile(gif_.release(), &error) == GIF_ERROR) fail(error);
    return bytes_;
  }

 private:
  struct CloseGif {
    void operator()(GifFileType* gif) const { EGifCloseFile(gif, nullptr); }
  };

  static int append(GifFileType* gif, const GifByteType* bytes, int count) noexcept {
    try {
      static_cast<std::string*>(gif->UserData)
          ->append(reinterpret_cast<const char*>(bytes), static_cast<size_t>(count));
      return count;
    } catch (const std::exception&) {
      return 0;
    }
  }

  size_t columns() const { return static_cast<size_t>(width_); }
  size_t pixels() const { return columns() * static_cast<size_t>(height_); }
  bool is_first() const { return before_.empty(); }

  [[noreturn]] void fail(int code) const {
    const char* reason = GifErrorString(code);
    throw Error(path_.string() +
                ": giflib cannot encode these pictures: " + (reason ? reason : "unknown reason"));
  }
  void expect(int result) const {
    if (result == GIF_ERROR) fail(gif_->Error);
  }

  void write_control(double seconds) {
    GraphicsControlBlock control{};
    control.DisposalMode = DISPOSE_DO_NOT;
    control.DelayTime = hundredths(seconds);
    control.TransparentColor = is_first() ? NO_TRANSPARENT_COLOR : kUnchanged;
    GifByteType bytes[4];
    expect(EGifPutExtension(gif_.get(), GRAPHICS_EXT_FUNC_CODE,
                            static_cast<int>(EGifGCBToExtension(&control, bytes)), bytes));
  }

  void write_pixels(const Rectangle& part) {
    expect(
        EGifPutImageDesc(gif_.get(), part.left, part.top, part.width, part.height, false, nullptr));
    for (int y = 0; y < part.height; ++y) {
      const size_t first =
          static_cast<size_t>(part.top + y) * columns() + static_cast<size_t>(part.left);
      for (size_t x = 0; x < row_.size() && x < static_cast<size_t>(part.width); ++x) {
        const bool same = !is_first() && now_[first + x] == before_[first + x];
        row_[x] = same ? kUnchanged : now_[first + x];
      }
      expect(EGifPutLine(gif_.get(), row_.data(), part.width));
    }
  }

  const std::filesystem::path& path_;
  int width_, height_;
  std::vector<unsigned char> before_, now_, row_;  // palette indices
  std::string bytes_;
  std::unique_ptr<GifFileType, CloseGif> gif_;
};

}  // namespace

Palette::Palette(const std::vector<Image>& images) : index_(kCells, 0) {
  check(images);
  std::vector<Cell> cube(kCells);
  for (const Image& image : images)
    for (size_t p = 0; p < image.rgb.size(); p += 3) {
      Cell& cell = cube[cell_of(&image.rgb[p])];
      ++cell.pixels;
      for (size_t c = 0; c < 3; ++c) cell.sum[c] += image.rgb[p + c];
    }
  std::vector<Box> boxes(1);
  for (int c = 0; c < kCells; ++c)
    if (Cell& cell = cube[c]; cell.pixels > 0) {
      cell.cell = c;
      boxes[0].cells.push_back(cell);
    }
  boxes[0].measure();
  while (boxes.size() < kMostColours) {
    const auto worst = std::max_element(
        boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.spread < b.spread; });
    if (!(worst->spread > 0)) break;
    const int channel = worst->widest;
    const double middle = worst->mean[channel];
    Box upper;
    const auto from =
        std::stable_partition(worst->cells.begin(), worst->cells.end(),
                              [&](const Cell& c) { return c.mean(channel) < middle; });
    // Rounding of the mean may leave one side empty: then all cells have one colour.
    if (from == worst->cells.begin() || from == worst->cells.end()) {
      worst->spread = 0;
      continue;
    }
    upper.cells.assign(from, worst->cells.end());
    worst->cells.erase(from, worst->cells.end());
    worst->measure();
    upper.measure();
    boxes.push_back(std::move(upper));
  }
  for (size_t b = 0; b < boxes.size(); ++b) {
    for (const double mean : boxes[b].mean)
      colours_.push_back(static_cast<unsigned char>(std::lround(mean)));
    for (const Cell& cell : boxes[b].cells) index_[cell.cell] = static_cast<unsigned char>(b);
  }
}

int Palette::index(unsigned char red, unsigned char green, unsigned char blue) const {
  const unsigned char rgb[3] = {red, green, blue};
  return index_[cell_of(rgb)];
}

void write_gif(const std::filesystem::path& path, const std::vector<Image>& frames, double seconds,
               double last_seconds) {
  check(frames);
  for (const double s : {seconds, last_seconds})
    if (!(s > 0) || !std::isfinite(s))
      throw InputError("found " + format_number(s) +
                       " seconds per picture, expected a time above 0");
  const Palette palette(frames);
  AtomicFile file(path);
  GifWriter gif(path, frames.front().width, frames.front().height);
  gif.write_colours(palette);
  gif.repeat_forever();
  for (size_t f = 0; f < frames.size(); ++f)
    gif.write_frame(frames[f], palette, f + 1 == frames.size() ? last_seconds : seconds);
  const std::string& bytes = gif.close();
  file.write([&](std::ostream& out) { out << bytes; });
  file.commit();
}

}  // namespace batten
