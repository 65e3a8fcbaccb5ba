// SPDX-License-Identifier: MPL-2.0
// Pictures show the scene: everything inside the frame, correct colours, or a clear message without
// a display.
#include "batten/io/pictures/comb_pictures.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/drawing_primitives.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/pictures/shading.h"

#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>

#include "batten/core/errors.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#include "batten/tests/support/trimmed_regions.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

/// A height field over [-1,1]² with its sides as curves.
SkinnedRegion region(double height) {
  constexpr int n = 8;
  const auto z = [height](const Vec2& p, int derivative) {
    const double x = 2 * p.x() - 1, y = 2 * p.y() - 1, e = height * std::exp(-3 * (x * x + y * y));
    const double dome = 0.3 * height;
    if (derivative == 1) return -12 * x * e - 4 * dome * x;
    if (derivative == 2) return -12 * y * e - 4 * dome * y;
    return e - dome * (x * x + y * y);
  };
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(n));
  const Surface surface = interpolated(mesh, TriangleElement::HCT, [&](const Vec2& p) {
    return SurfaceJet{
        {2 * p.x() - 1, 2 * p.y() - 1, z(p, 0)}, {2, 0, z(p, 1)}, {0, 2, z(p, 2)}, {}, {}, {}};
  });
  SkinnedRegion result{"dome", surface, {}, 1, {}, {}};
  const int sides[4][2] = {{0, 1}, {n * (n + 1), 1}, {0, n + 1}, {n, n + 1}};
  for (const auto& [first, step] : sides) {
    EdgeAlignedLine aligned_line;
    aligned_line.line.name = "side";
    for (int i = 0; i <= n; ++i) {
      aligned_line.vertices.push_back(first + i * step);
      aligned_line.parameters.push_back(i);
      if (i > 0)
        aligned_line.edges.push_back(
            mesh->edge_between(aligned_line.vertices[i - 1], aligned_line.vertices[i]));
    }
    result.edge_aligned.push_back(aligned_line);
  }
  return result;
}

struct Picture {
  int width = 0, height = 0;
  vtkNew<vtkImageData> image;

  explicit Picture(const fs::path& path) {
    vtkNew<vtkPNGReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    image->ShallowCopy(reader->GetOutput());
    width = image->GetDimensions()[0];
    height = image->GetDimensions()[1];
  }
  /// From the upper left corner, 0 to 1.
  Vec3 pixel(int x, int y) const {
    const auto* p =
        static_cast<const unsigned char*>(image->GetScalarPointer(x, height - 1 - y, 0));
    return Vec3(p[0], p[1], p[2]) / 255;
  }
  long count(const std::function<bool(const Vec3&)>& wanted) const {
    long n = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) n += wanted(pixel(x, y));
    return n;
  }
};

bool red(const Vec3& c) { return c[0] > 0.5 && c[0] > 1.8 * c[1] && c[0] > 1.8 * c[2]; }
bool blue(const Vec3& c) { return c[2] > 0.4 && c[2] > 1.6 * c[0]; }
bool dark(const Vec3& c) { return c.maxCoeff() < 0.45; }

bool have_display() {
  const std::string why = error_message([] { require_display(); });
  if (!why.empty()) WARN("pictures were not drawn: " << why);
  return why.empty();
}

}  // namespace

TEST_CASE("pictures refuse values out of range", "[io][pictures]") {
  using Catch::Matchers::Contains;
  const fs::path path = batten_test::scratch("picture_errors") / "a.png";
  const SkinnedRegion dome = region(1);
  PictureScene scene;
  CHECK_THAT(error_message([&] { draw_picture(path, scene); }), Contains("no face"));
  scene.regions = {&dome};
  scene.title = "Dome";
  scene.zoom = 0;
  CHECK_THAT(error_message([&] { draw_picture(path, scene); }),
             Contains("'Dome'") && Contains("zoom 0"));
  scene.zoom = 1;
  scene.elevation = 91;
  CHECK_THAT(error_message([&] { draw_picture(path, scene); }), Contains("elevation 91"));
  scene.elevation = 0;
  CHECK_THAT(error_message([&] { draw_picture(path, scene, {1600, 10}); }), Contains("1600 x 10"));
  CHECK_THAT(error_message([&] { draw_contact_sheet(path, {}, 2); }),
             Contains("at least one scene"));
  CHECK_THAT(error_message([&] { draw_contact_sheet(path, {scene}, 0); }), Contains("0 columns"));
}

TEST_CASE("everything is in the frame, from wherever one looks", "[io][pictures]") {
  if (!have_display()) return;
  const SkinnedRegion dome = region(0.8);
  PictureScene scene;
  scene.regions = {&dome};
  scene.azimuth = GENERATE(-30, 100);
  scene.elevation = GENERATE(-90, -20, 35, 90);
  const fs::path path = batten_test::scratch("frame") / "a.png";
  draw_picture(path, scene, {320, 200});
  const Picture picture(path);
  REQUIRE(picture.width == 320);
  REQUIRE(picture.height == 200);
  // The tubes around the surface reach close to the frame in one direction, and intersect it
  // nowhere.
  int left = 320, right = -1, top = 200, bottom = -1;
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 320; ++x)
      if (red(picture.pixel(x, y))) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
  CHECK(std::max((right - left) / 320.0, (bottom - top) / 200.0) > 0.6);
  CHECK(left > 8);
  CHECK(right < 312);
  CHECK(top > 4);
  CHECK(bottom < 195);
  // No side of the surface is black.
  CHECK(picture.count([](const Vec3& c) { return c.maxCoeff() < 0.2; }) < 30);
}

TEST_CASE("curves, contours, elements and fields are drawn on request", "[io][pictures]") {
  if (!have_display()) return;
  const fs::path folder = batten_test::scratch("contents");
  const SkinnedRegion dome = region(0.8);
  PictureScene scene;
  scene.regions = {&dome};
  scene.elevation = 50;
  const auto draw = [&] {
    draw_picture(folder / "a.png", scene, {480, 300});
    return std::make_unique<Picture>(folder / "a.png");
  };
  CHECK(draw()->count(red) > 500);
  scene.lines = false;
  const auto plain = draw();
  CHECK(plain->count(red) == 0);
  const long plain_dark = plain->count(dark);
  scene.contours = 15;
  const auto with_contours = draw();
  CHECK(with_contours->count(dark) > plain_dark + 500);
  scene.contours = 0;
  scene.mesh = true;
  // Number of pixels in which a picture differs from the shaded one.
  const auto differs = [&](const Picture& other) {
    long n = 0;
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 480; ++x)
        n += (plain->pixel(x, y) - other.pixel(x, y)).cwiseAbs().maxCoeff() > 0.08;
    return n;
  };
  CHECK(differs(*draw()) > 1000);
  scene.mesh = false;
  scene.parameter_lines = 10;
  CHECK(differs(*draw()) > 1000);
  scene.parameter_lines = 0;
  // The top of the dome bends away from its normal: mean curvature is negative (blue), its Gauss
  // curvature positive (red). The legend below shows both.
  const auto top_half = [](const Picture& p, const std::function<bool(const Vec3&)>& wanted) {
    long n = 0;
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 480; ++x) n += wanted(p.pixel(x, y));
    return n;
  };
  scene.field = PictureScene::Field::Mean;
  const auto mean = draw();
  CHECK(top_half(*mean, blue) > 500);
  CHECK(mean->count(red) > 50);
  scene.field = PictureScene::Field::Gauss;
  CHECK(top_half(*draw(), red) > 500);
  // The same scene gives the same picture, bit for bit.
  const auto text = [&](const char* name) {
    std::ifstream in(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  draw_picture(folder / "b.png", scene, {480, 300});
  CHECK(text("a.png") == text("b.png"));
  CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 2);
}

TEST_CASE("a zebra has the requested number of stripes, given by the normals", "[io][pictures]") {
  using Catch::Matchers::Contains;
  const fs::path path = batten_test::scratch("zebra") / "a.png";
  // A quarter of a cylinder along y: the angle to x is uniform in the angle of its parameter.
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(12));
  const SkinnedRegion roof{"roof",
                           interpolated(mesh, TriangleElement::HCT,
                                        [](const Vec2& p) {
                                          const double a = pi / 4 + pi / 2 * (1 - p.x()),
                                                       k = -pi / 2;
                                          return SurfaceJet{{std::cos(a), p.y(), std::sin(a)},
                                                            {-k * std::sin(a), 0, k * std::cos(a)},
                                                            {0, 1, 0},
                                                            {},
                                                            {},
                                                            {}};
                                        }),
                           {},
                           1,
                           {},
                           {}};
  PictureScene scene;
  scene.regions = {&roof};
  scene.azimuth = 0;
  scene.elevation = 90;
  scene.zebra = 10;
  scene.zebra_direction = {1, 0, 0};
  scene.field = PictureScene::Field::Mean;
  CHECK_THAT(error_message([&] { draw_picture(path, scene); }),
             Contains("zebra stripes and a field"));
  scene.field = PictureScene::Field::None;
  scene.zebra_direction.setZero();
  CHECK_THAT(error_message([&] { draw_picture(path, scene); }), Contains("zebra direction"));
  scene.zebra_direction = {1, 0, 0};
  if (!have_display()) return;
  draw_picture(path, scene, {640, 400});
  const Picture picture(path);
  // Along the middle from left to right, x = cos a: changes at uniform steps of a. The height of 1
  // fills 88 % of the frame.
  const double scale = 0.88 * 400;
  std::vector<double> changes;
  for (int x = 320 - static_cast<int>(0.70 * scale); x < 320 + static_cast<int>(0.70 * scale);
       ++x) {
    const double here = picture.pixel(x, 200).mean(), next = picture.pixel(x + 1, 200).mean();
    if ((here > 0.4) != (next > 0.4))
      changes.push_back(std::acos((x + 1 - 320) / scale) * 180 / pi);
  }
  CAPTURE(changes);
  REQUIRE(changes.size() >= 9);
  REQUIRE(changes.size() <= 11);
  for (size_t i = 0; i + 1 < changes.size(); ++i)
    CHECK(changes[i] - changes[i + 1] == Approx(90 * 0.96 / 10).margin(1));
}

TEST_CASE("pictures of embedded faces show holes as holes", "[io][pictures]") {
  if (!have_delaunay_mesher() || !have_display()) return;
  const SkinnedRegion disc = wavy_disc({0.2, 0, 0.4, false});
  PictureScene scene;
  scene.regions = {&disc};
  scene.elevation = 90;
  scene.azimuth = 0;
  scene.mesh = true;
  const fs::path path = batten_test::scratch("hole") / "a.png";
  draw_picture(path, scene, {400, 400});
  const Picture picture(path);
  // The disc fills 88 % of the frame: pixels of 2 / 352.
  const auto at = [&](double x, double y) {
    return picture.pixel(static_cast<int>(200 + 176 * x), static_cast<int>(200 - 176 * y));
  };
  // Inside the hole and outside the disc there is only background.
  for (const double r : {0.0, 0.2, 0.34})
    for (int k = 0; k < 12; ++k) {
      const double a = 2 * pi * k / 12;
      const Vec3 seen = at(0.3 + r * std::cos(a), 0.2 + r * std::sin(a));
      CHECK(seen.maxCoeff() - seen.minCoeff() < 0.06);
      CHECK(seen.minCoeff() > 0.78);
    }
  CHECK(at(0.9, 0.9).minCoeff() > 0.78);
  const Vec3 body = at(-0.53, -0.31);
  CHECK(body[2] - body[0] > 0.06);
  CHECK(picture.count(red) > 800);
}

TEST_CASE("alternative surfaces are drawn as patches in their loops", "[io][pictures]") {
  if (!have_display()) return;
  const auto side = [](const Vec3& a, const Vec3& b) {
    Points x(2, 3), d(2, 3);
    x << a.transpose(), b.transpose();
    d << (b - a).transpose(), (b - a).transpose();
    return HermiteCurve({0, 1}, x, d);
  };
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(4, 3, 0), d(0, 3, 0);
  LoopPicture picture;
  picture.lines = {side(a, b), side(c, b), side(c, d), side(a, d)};
  picture.alternatives = {{"current", {picture.lines}}, {"alternative", {}}};
  const fs::path path = batten_test::scratch("loop_pictures") / "ways.png";
  draw_loops(path, picture);
  const Picture sheet(path);
  // Three panels: everywhere, with the sheet, without it.
  std::array<long, 3> sheets{}, lines{};
  for (int y = 0; y < sheet.height; ++y)
    for (int x = 0; x < sheet.width; ++x) {
      const Vec3 colour = sheet.pixel(x, y);
      sheets[3 * x / sheet.width] += colour[2] - colour[0] > 0.15;
      lines[3 * x / sheet.width] += red(colour);
    }
  CAPTURE(sheets, lines);
  CHECK(sheets[0] > 20'000);
  CHECK(sheets[1] > 50'000);
  CHECK(sheets[2] == 0);
  CHECK(lines[1] > 1000);
  CHECK(lines[2] == 0);
  picture.alternatives.pop_back();
  picture.alternatives[0].loops.clear();
  CHECK_FALSE(error_message([&] { draw_loops(path, picture); }).empty());
}

TEST_CASE("a contact sheet shows every scene in its own position", "[io][pictures]") {
  if (!have_display()) return;
  const fs::path path = batten_test::scratch("sheet") / "sheet.png";
  const SkinnedRegion dome = region(0.8), flat = region(0);
  PictureScene a, b;
  a.regions = {&dome};
  a.title = "dome";
  b.regions = {&flat};
  b.title = "a flat square with contours, of which it has none, and a long caption";
  b.contours = 10;
  b.lines = false;
  draw_contact_sheet(path, {a, b, a}, 2, {640, 400});
  const Picture sheet(path);
  REQUIRE(sheet.width == 640);
  long lines[2][2] = {};
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 640; ++x) lines[y / 200][x / 320] += red(sheet.pixel(x, y));
  CHECK(lines[0][0] > 300);
  CHECK(lines[0][1] == 0);
  CHECK(lines[1][0] == lines[0][0]);
  CHECK(lines[1][1] == 0);
  // A cell without a scene is white.
  for (int y = 210; y < 390; y += 10) CHECK(sheet.pixel(480, y) == Vec3::Ones());
}

TEST_CASE("pictures of a series share camera, heights and colours", "[io][pictures]") {
  const SkinnedRegion low = region(0.5), high = region(2);
  PictureScene look;
  look.contours = 5;
  look.field = PictureScene::Field::Mean;
  std::vector<PictureScene> scenes = {look, look};
  scenes[0].regions = {&low};
  scenes[1].regions = {&high};
  scenes[1].azimuth = 70;  // the first one's counts
  share_view(scenes);
  REQUIRE(scenes[0].in_view.size() == 8);
  CHECK(scenes[0].in_view == scenes[1].in_view);
  CHECK(scenes[1].azimuth == scenes[0].azimuth);
  REQUIRE(scenes[1].contour_range);
  CHECK(scenes[0].contour_range == scenes[1].contour_range);
  // The higher dome has the larger range: its top is 1 - 0, its corners are slightly below -0.6 of
  // its height.
  CHECK(scenes[0].contour_range->second == Approx(2).epsilon(1e-3));
  CHECK(scenes[0].contour_range->first < -1);
  CHECK(scenes[0].field_limit == scenes[1].field_limit);
  CHECK(scenes[0].field_limit > 0);
  if (!have_display()) return;
  for (PictureScene& scene : scenes) {
    scene.field = PictureScene::Field::None;
    scene.contours = 0;
    scene.lines = false;
  }
  const PictureSize size{400, 300};
  // The higher one fits completely, and so comes closer to the frame than the lower one.
  const auto rows = [&](const PictureScene& scene) {
    const Image image = picture_image(scene, size);
    const Image empty = [&] {
      PictureScene nothing = scene;
      nothing.zoom = 1e-3;
      return picture_image(nothing, size);
    }();
    int first = size.height, last = -1;
    for (int y = 0; y < size.height; ++y)
      for (int x = 5; x < size.width - 5; ++x)
        for (size_t c = 0; c < 3; ++c) {
          const size_t at = 3 * (static_cast<size_t>(y) * 400 + static_cast<size_t>(x)) + c;
          if (std::abs(image.rgb[at] - empty.rgb[at]) < 12) continue;
          first = std::min(first, y);
          last = std::max(last, y);
        }
    return std::pair(first, last);
  };
  const auto a = rows(scenes[0]), b = rows(scenes[1]);
  CHECK(a.second > a.first);
  CHECK(a.first > b.first + 20);
  CHECK(a.second < b.second);
  CHECK(b.first > 0);
  CHECK(b.second < size.height - 1);
}

TEST_CASE("edges of one kind have its colour, their combs stand out by the curvature",
          "[io][pictures]") {
  const fs::path file = scratch("edge_combs") / "a.png";
  EdgePicture picture;
  picture.title = "edges";
  picture.unit = "mm";
  CHECK_THAT(error_message([&] { draw_edge_combs(file, picture); }),
             Catch::Matchers::Contains("no edges"));
  EdgeComb edge;
  for (int k = 0; k <= 20; ++k) {
    edge.line.emplace_back(k, 0, 0);
    for (auto& curvature_vectors : edge.curvature_vectors)
      curvature_vectors.emplace_back(0, 0, -0.1);
  }
  picture.edges = {edge};
  if (!have_display()) return;
  const auto count = [&](const EdgePicture& drawn, bool (*wanted)(const Vec3&)) {
    draw_edge_combs(file, drawn, {400, 300});
    return Picture(file).count(wanted);
  };
  const long with_comb = count(picture, red);
  CHECK(with_comb > 100);
  CHECK(count(picture, blue) == 0);
  EdgePicture flat = picture;
  for (auto& curvature_vectors : flat.edges[0].curvature_vectors)
    curvature_vectors.assign(21, Vec3::Zero());
  CHECK(count(flat, red) < with_comb);
  picture.edges[0].kind = EdgeComb::Kind::Tangent;
  CHECK(count(picture, red) == 0);
  CHECK(count(picture, blue) > 100);
}

TEST_CASE("equal steps of a field have equal steps of lightness", "[io][pictures]") {
  const auto table = batten::detail::sequential_colours(10);
  std::vector<double> lightness;
  for (int i = 0; i <= 20; ++i) {
    double rgb[3], lab[3];
    table->GetColor(0.5 * i, rgb);
    vtkMath::RGBToLab(rgb, lab);
    lightness.push_back(lab[0]);
  }
  const double step = (lightness.back() - lightness.front()) / 20;
  CHECK(step < -3);
  for (size_t i = 0; i + 1 < lightness.size(); ++i)
    CHECK(lightness[i + 1] - lightness[i] == Approx(step).epsilon(0.4));
}

TEST_CASE("scales end at round numbers", "[io][pictures]") {
  for (const auto& [value, limit] : {std::pair(0.00027, 0.0003),
                                     {29.1, 30.0},
                                     {1.0, 1.0},
                                     {36.0, 40.0},
                                     {1.21e6, 1.5e6},
                                     {8.1e-9, 1e-8}})
    CHECK(batten::detail::rounded_up(value) == Approx(limit).epsilon(1e-9));
}

TEST_CASE("grooves are darker than planes and ridges", "[io][pictures]") {
  constexpr int width = 1600, height = 1200;
  constexpr double range = 4000;  // depth of the buffer in pixels
  // Depth over the distance from the middle: a plane, a groove, a ridge.
  const auto middle = [&](double slope_left, double slope_right) {
    vtkNew<vtkFloatArray> depths;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double d = x - width / 2.0;
        depths->InsertNextValue(
            static_cast<float>(0.5 + d * (d < 0 ? slope_left : slope_right) / range));
      }
    return static_cast<double>(
        batten::detail::ambient_occlusion(*depths, width, 0, 0, width, height, range)
            .at(width / 2.0, height / 2.0));
  };
  const double plane = middle(1, 1), groove = middle(1, -1), ridge = middle(-1, 1);
  CHECK(plane > 0.9);
  CHECK(ridge == Approx(plane).margin(0.01));
  CHECK(groove < plane - 0.12);
}

TEST_CASE("a surface casts a shadow on the floor, seen from above", "[io][pictures]") {
  if (!have_display()) return;
  const SkinnedRegion dome = region(0.8);
  PictureScene scene;
  scene.regions = {&dome};
  const fs::path path = scratch("floor") / "a.png";
  // The background depends on the height only: count its darker pixels.
  const auto shadow = [&](double elevation) {
    scene.elevation = elevation;
    draw_picture(path, scene, {320, 200});
    const Picture picture(path);
    long n = 0;
    for (int y = 0; y < 200; ++y) {
      const Vec3 empty = picture.pixel(1, y);
      for (int x = 0; x < 320; ++x) {
        const Vec3 seen = picture.pixel(x, y);
        n += seen.maxCoeff() - seen.minCoeff() < 0.06 && seen.mean() < empty.mean() - 0.06;
      }
    }
    return n;
  };
  const long above = shadow(25), below = shadow(-25), top = shadow(90);
  CAPTURE(above, below, top);
  CHECK(above > 1000);
  CHECK(below < above / 4);
  CHECK(top < above / 4);
}
