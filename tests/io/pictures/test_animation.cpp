// SPDX-License-Identifier: MPL-2.0
// Animations and file series, read back by other programs.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "batten/io/pictures/image.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A disc that moves to the right over a shaded ground.
Image disc(int step, int width = 90, int height = 64) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool inside = std::hypot(x - 20 - 8 * step, y - 30) < 12;
      const auto shade = static_cast<unsigned char>(200 + y / 2);
      const unsigned char rgb[3] = {inside ? static_cast<unsigned char>(220) : shade,
                                    inside ? static_cast<unsigned char>(40) : shade,
                                    inside ? static_cast<unsigned char>(3 * x) : shade};
      image.rgb.insert(image.rgb.end(), rgb, rgb + 3);
    }
  return image;
}

std::string bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

const char* const kReader = R"(
import json, sys
from PIL import Image, ImageSequence
gif = Image.open(sys.argv[1])
frames = []
for frame in ImageSequence.Iterator(gif):
    rgb = frame.convert('RGB')
    frames.append({'ms': frame.info.get('duration'), 'size': rgb.size,
                   'pixels': [list(rgb.getpixel((x, y))) for y in range(0, rgb.size[1], 3)
                              for x in range(0, rgb.size[0], 3)]})
json.dump({'loop': gif.info.get('loop'), 'frames': frames}, open(sys.argv[2], 'w'))
)";

}  // namespace

TEST_CASE("a palette keeps few colours as they are, and many nearly", "[io][pictures][animation]") {
  Image few{4, 1, {0, 0, 0, 255, 255, 255, 200, 10, 10, 200, 10, 10}};
  const Palette exact({few});
  CHECK(exact.count() == 3);
  for (size_t p = 0; p < few.rgb.size(); p += 3) {
    const int i = exact.index(few.rgb[p], few.rgb[p + 1], few.rgb[p + 2]);
    for (size_t c = 0; c < 3; ++c)
      CHECK(exact.colours()[3 * static_cast<size_t>(i) + c] == few.rgb[p + c]);
  }
  const Palette many({disc(0), disc(3)});
  CHECK(many.count() <= 255);
  CHECK(many.count() > 40);
  double worst = 0;
  const Image image = disc(3);
  for (size_t p = 0; p < image.rgb.size(); p += 3) {
    const int i = many.index(image.rgb[p], image.rgb[p + 1], image.rgb[p + 2]);
    for (size_t c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(double(many.colours()[3 * static_cast<size_t>(i) + c]) -
                                       image.rgb[p + c]));
  }
  CHECK(worst <= 4);
}

TEST_CASE("a GIF is read back frame by frame by another program", "[io][pictures][animation]") {
  if (std::system("/usr/bin/python3 -c 'import PIL' > /dev/null 2>&1") != 0) {
    WARN("skipped: python3 has no module PIL");
    return;
  }
  const fs::path folder = batten_test::scratch("gif");
  std::vector<Image> frames;
  for (const int step : {0, 1, 1, 4}) frames.push_back(disc(step));
  write_gif(folder / "a.gif", frames, 0.25, 1.5);
  write_gif(folder / "b.gif", frames, 0.25, 1.5);
  CHECK(bytes(folder / "a.gif") == bytes(folder / "b.gif"));
  std::ofstream(folder / "read.py") << kReader;
  REQUIRE(std::system(
              ("cd '" + folder.string() + "' && /usr/bin/python3 read.py a.gif a.json > talk 2>&1")
                  .c_str()) == 0);
  const auto read = nlohmann::json::parse(bytes(folder / "a.json"));
  CHECK(read["loop"] == 0);
  REQUIRE(read["frames"].size() == 4);
  for (size_t f = 0; f < 4; ++f) {
    const auto& frame = read["frames"][f];
    CHECK(frame["size"] == nlohmann::json{90, 64});
    CHECK(frame["ms"] == (f == 3 ? 1500 : 250));
    size_t k = 0;
    double worst = 0;
    for (int y = 0; y < 64; y += 3)
      for (int x = 0; x < 90; x += 3, ++k)
        for (int c = 0; c < 3; ++c)
          worst = std::max(worst, std::abs(frame["pixels"][k][c].get<double>() -
                                           frames[f].rgb[(size_t(y) * 90 + x) * 3 + c]));
    CHECK(worst <= 4);
  }
}

TEST_CASE("animations that cannot be are refused and leave nothing", "[io][pictures][animation]") {
  const fs::path folder = batten_test::scratch("no_gif"), file = folder / "a.gif";
  CHECK_THAT(error_message([&] { write_gif(file, {}, 1, 1); }), Contains("found no pictures"));
  CHECK_THAT(error_message([&] {
               write_gif(file, {disc(0), disc(0, 80)}, 1, 1);
             }),
             Contains("90 x 64 and 80 x 64"));
  CHECK_THAT(error_message([&] {
               write_gif(file, {Image{2, 2, {1, 2, 3}}}, 1, 1);
             }),
             Contains("with 3 bytes"));
  CHECK_THAT(error_message([&] { write_gif(file, {disc(0)}, 0, 1); }), Contains("found 0 seconds"));
  CHECK_THAT(error_message([&] { write_gif(file, {disc(0)}, 1, std::nan("")); }),
             Contains("found nan"));
  CHECK_THAT(error_message([&] { write_gif(folder / "none" / "a.gif", {disc(0)}, 1, 1); }),
             Contains("does not exist"));
  CHECK_THAT(error_message([&] { write_png(folder / "a.png", {}); }), Contains("0 x 0"));
  CHECK(fs::is_empty(folder));
}

TEST_CASE("a series has all digits of its values, in their direction", "[io][pictures][series]") {
  const fs::path folder = batten_test::scratch("pvd"), file = folder / "a.pvd";
  const double third = 1.0 / 3;
  write_pvd(file, {{-1, "a_000.vtp"}, {third, "a_001.vtp"}, {1e30, "b<&\">.vtp"}});
  const std::string text = bytes(file);
  std::vector<double> values;
  const std::regex step("timestep=\"([^\"]*)\"");
  for (std::sregex_iterator it(text.begin(), text.end(), step), end; it != end; ++it)
    values.push_back(std::stod((*it)[1]));
  CHECK(values == std::vector<double>{-1, third, 1e30});
  CHECK_THAT(text, Contains("file=\"b&lt;&amp;&quot;>.vtp\""));
  write_pvd(file, {{3, "a"}, {2, "b"}, {0, "c"}});  // also in descending order
  CHECK_THAT(error_message([&] { write_pvd(file, {}); }), Contains("no files"));
  CHECK_THAT(error_message([&] {
               write_pvd(file, {{0, "a"}, {0, "b"}});
             }),
             Contains("found the value 0"));
  CHECK_THAT(error_message([&] {
               write_pvd(file, {{0, "a"}, {1, "b"}, {0.5, "c"}});
             }),
             Contains("one direction"));
  CHECK_THAT(error_message([&] { write_pvd(file, {{std::nan(""), "a"}}); }), Contains("nan"));
}
