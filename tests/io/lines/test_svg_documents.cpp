// SPDX-License-Identifier: MPL-2.0
// SVG files as other programs write them: nested drawings, clones, symbols, style sheets, and random
// drawings whose curves are known by construction.
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/io/lines/drawing.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;

namespace {

std::filesystem::path svg_file(const std::string& text) {
  static const std::filesystem::path folder = batten_test::scratch("svg_documents");
  std::ofstream(folder / "a.svg", std::ios::binary) << text;
  return folder / "a.svg";
}

Drawing read_page(const std::string& body, const std::string& head) {
  return read_drawing(svg_file("<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg' " +
                               head + ">" + body + "</svg>"));
}

const std::string page = "width='100mm' height='50mm' viewBox='0 0 100 50'";

// Centre and mean radius of a closed curve, in millimetres.
struct Round {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};
Round round_of(const Drawing& drawing, size_t i) {
  const InputCurve& curve = *drawing.lines.at(i).curve;
  constexpr int count = 64;
  const auto at = [&](int k) {
    return curve.evaluate(curve.start() + (curve.end() - curve.start()) * k / count);
  };
  Round found;
  for (int k = 0; k < count; ++k) found.centre += at(k) / count;
  for (int k = 0; k < count; ++k) found.radius += (at(k) - found.centre).norm() / count;
  const double mm = drawing.unit_in_metres / 0.001;
  return {found.centre * mm, found.radius * mm};
}
bool is_at(const Round& found, double x, double y, double radius) {
  return (found.centre - Vec3(x, y, 0)).norm() < 1e-6 && std::abs(found.radius - radius) < 1e-6;
}
std::vector<std::string> names(const Drawing& drawing) {
  std::vector<std::string> all;
  for (const DrawnLine& line : drawing.lines) all.push_back(line.name);
  return all;
}
using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("SVG: the page is fitted by its viewBox, and lengths follow from each other",
          "[io][drawings]") {
  const std::string circle = "<circle cx='400' cy='400' r='400'/>";
  const auto drawn = [&](const std::string& head) { return round_of(read_page(circle, head), 0); };
  const std::string box = " viewBox='0 0 800 800'";
  CHECK(is_at(drawn("width='100mm' height='50mm'" + box), 50, 25, 25));
  CHECK(
      is_at(drawn("width='100mm' height='50mm' preserveAspectRatio='xMinYMid'" + box), 25, 25, 25));
  CHECK(is_at(drawn("width='100mm' height='50mm' preserveAspectRatio='xMaxYMin slice'" + box), 50,
              0, 50));
  CHECK(is_at(drawn("height='40mm'" + box), 20, 20, 20));
  CHECK(is_at(drawn("width='40mm'" + box), 20, 20, 20));
  const double pixel = 25.4 / 96;
  CHECK(is_at(drawn(box), 400 * pixel, 400 * pixel, 400 * pixel));

  const Drawing stretched =
      read_page(circle, "width='100mm' height='50mm' preserveAspectRatio='none'" + box);
  const InputCurve& ellipse = *stretched.lines[0].curve;
  const double mm = stretched.unit_in_metres / 0.001;
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (int k = 0; k <= 1000; ++k) {
    const Vec3 p =
        mm * ellipse.evaluate(ellipse.start() + (ellipse.end() - ellipse.start()) * k / 1000);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  CHECK((high - low - Vec3(100, 50, 0)).norm() < 1e-3);
}

TEST_CASE("SVG: nested drawings have their own coordinates", "[io][drawings]") {
  const Drawing d = read_page(
      "<svg x='10' y='5' width='40' height='40' viewBox='0 0 200 100'>"
      "<circle id='a' cx='100' cy='50' r='20'/>"
      "<svg x='50%' width='50%' height='100%' viewBox='0 0 1 1' preserveAspectRatio='xMinYMin'>"
      "<circle id='b' r='1'/></svg></svg>"
      "<svg x='10'><circle id='c' cx='25%' cy='50%' r='5'/></svg>",
      page);
  REQUIRE(names(d) == Names{"a", "b", "c"});
  CHECK(is_at(round_of(d, 0), 30, 25, 4));   // scale 0.2, centred in y
  CHECK(is_at(round_of(d, 1), 30, 35, 20));  // 100 units of 0.2 mm
  CHECK(is_at(round_of(d, 2), 35, 25, 5));
}

TEST_CASE("SVG: clones and symbols are drawn where they are used", "[io][drawings]") {
  const Drawing d = read_page(
      "<defs><circle id='hole' r='4'/><g id='pair'><use href='#hole' x='-5'/>"
      "<use href='#hole' x='5'/></g></defs>"
      "<symbol id='mark' viewBox='-1 -1 2 2'><circle r='1'/></symbol>"
      "<use id='one' xmlns:xlink='http://www.w3.org/1999/xlink' xlink:href='#hole' x='15' y='20'/>"
      "<use id='two' href='#pair' transform='translate(60 20)'/>"
      "<use id='three' href='#mark' x='80' y='30' width='10' height='10'/>"
      "<use href='#none'/><use href='other.svg#a'/><g id='self'><use href='#self'/></g>",
      page);
  CHECK(names(d) == Names{"one", "hole_1", "hole_2", "three"});
  CHECK(is_at(round_of(d, 0), 15, 30, 4));
  CHECK(is_at(round_of(d, 1), 55, 30, 4));
  CHECK(is_at(round_of(d, 2), 65, 30, 4));
  CHECK(is_at(round_of(d, 3), 85, 15, 5));
  CHECK(d.notes.empty());
  CHECK(d.warnings ==
        Names{"skipped, although they may contain curves: 1 use of another file, 1 use that "
              "contains itself, 1 use without its element"});
}

TEST_CASE("SVG: clones that multiply are refused", "[io][drawings]") {
  std::string body = "<circle id='a0' r='1'/>";
  for (int k = 1; k <= 12; ++k) {
    body += "<g id='a" + std::to_string(k) + "'>";
    for (int i = 0; i < 10; ++i) body += "<use href='#a" + std::to_string(k - 1) + "'/>";
    body += "</g>";
  }
  CHECK_THAT(batten_test::error_message(
                 [&] { read_page("<defs>" + body + "</defs><use href='#a12'/>", page); }),
             Catch::Matchers::Contains("elements in clones"));
}

TEST_CASE("SVG: elements that are not displayed or not visible are not read", "[io][drawings]") {
  const std::string sheet =
      "<style>/* layers */ .off, #x2 { display: none } @media print { .on { display: none } }"
      "g.layer > circle { visibility: hidden } .shown { visibility: visible !important }"
      "circle[r] { display: none } rect { display: none } rect.on { display: inline }</style>";
  const Drawing d = read_page(
      sheet +
          "<circle id='x1' class='off' r='1'/><circle id='x2' r='1'/>"
          "<g class='off'><circle id='x3' r='1'/></g>"
          "<g class='layer'><circle id='x4' r='1'/><circle id='a' class='big shown' r='1'/>"
          "<g><circle id='b' r='1'/></g></g>"
          "<g visibility='hidden'><circle id='x5' r='1'/>"
          "<circle id='c' r='1' style='visibility : visible'/></g>"
          "<g style='fill:none; display: none'><circle id='x6' r='1'/></g>"
          "<circle id='x7' r='1' display='none'/>"
          "<circle id='d' class='off' r='1' style='display:inline'/>"
          "<rect id='x8' width='1' height='1'/><rect id='e' class='on' width='1' height='1'/>"
          "<clipPath id='x9'><circle r='1'/></clipPath>"
          "<switch><g requiredExtensions='x'><circle id='x10' r='1'/></g><circle id='f' r='1'/>"
          "<circle id='x11' r='1'/></switch>",
      page);
  CHECK(names(d) == Names{"a", "b", "c", "d", "e", "f"});
}

namespace {

// A random drawing in which each circle is a known similarity of the unit circle.
class RandomDrawing {
 public:
  explicit RandomDrawing(unsigned seed) : random_(seed) {
    const double unit = pick({1, 0.5, 25.4, 10});  // millimetres per user unit
    const double width = between(50, 300), height = between(50, 300);
    const char* units[] = {"mm", "cm", "in", "px", "pt"};
    const double in_mm[] = {1, 10, 25.4, 25.4 / 96, 25.4 / 72};
    const size_t u = random_() % 5;
    std::ostringstream head;
    head.precision(17);
    head << "width='" << width * unit / in_mm[u] << units[u] << "' height='"
         << height * unit / in_mm[u] << units[u] << "' viewBox='" << -7 << " " << 3 << " " << width
         << " " << height << "'";
    head_ = head.str();
    Mat3 page;
    page << unit, 0, 7 * unit, 0, -unit, (height + 3) * unit, 0, 0, 1;
    body_.precision(17);
    group(page, 0, true);
    circle(page, true);
  }
  Drawing read() const { return read_page("<defs>" + defs_ + "</defs>" + body_.str(), head_); }
  const std::vector<Round>& truth() const { return truth_; }

 private:
  double between(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random_);
  }
  double pick(std::initializer_list<double> values) {
    return *(values.begin() + random_() % values.size());
  }

  void circle(const Mat3& to_page, bool shown) {
    const double x = between(-20, 20), y = between(-20, 20), r = between(0.5, 5);
    if (random_() % 4 == 0) {
      const std::string id = "t" + std::to_string(truth_.size()) + "_" + std::to_string(random_());
      std::ostringstream definition;
      definition.precision(17);
      definition << "<circle id='" << id << "' r='" << r << "'/>";
      defs_ += definition.str();
      body_ << "<use href='#" << id << "' x='" << x << "' y='" << y << "'/>";
    } else {
      body_ << "<circle cx='" << x << "' cy='" << y << "' r='" << r << "'/>";
    }
    if (!shown) return;
    const Vec3 centre = to_page * Vec3(x, y, 1);
    truth_.push_back({Vec3(centre.x(), centre.y(), 0),
                      r * std::sqrt(std::abs(to_page.topLeftCorner<2, 2>().determinant()))});
  }

  // A similarity as the value of a transform attribute.
  std::string transform(Mat3& to_page) {
    std::ostringstream text;
    text.precision(17);
    Mat3 step = Mat3::Identity();
    switch (random_() % 4) {
      case 0: {
        const double a = between(-180, 180), t = a * M_PI / 180;
        step << std::cos(t), -std::sin(t), 0, std::sin(t), std::cos(t), 0, 0, 0, 1;
        text << "rotate(" << a << ")";
        break;
      }
      case 1:
        step(0, 2) = between(-30, 30);
        step(1, 2) = between(-30, 30);
        text << "translate(" << step(0, 2) << "," << step(1, 2) << ")";
        break;
      case 2:
        step(0, 0) = between(0.5, 2);
        step(1, 1) = random_() % 2 ? step(0, 0) : -step(0, 0);
        text << "scale(" << step(0, 0) << " " << step(1, 1) << ")";
        break;
      default:
        step << 0, -1.5, between(-9, 9), 1.5, 0, 4, 0, 0, 1;
        text << "matrix(0 1.5 -1.5 0 " << step(0, 2) << " 4)";
    }
    to_page = to_page * step;
    return text.str();
  }

  void group(Mat3 to_page, int depth, bool shown) {
    for (int count = 1 + static_cast<int>(random_() % 3); count > 0; --count) {
      Mat3 inner = to_page;
      const auto kind = depth < 5 ? random_() % 5 : 0;
      if (kind == 0) {
        circle(to_page, shown);
      } else if (kind == 1) {
        const double x = between(-20, 20), y = between(-20, 20), w = between(5, 50),
                     h = between(5, 50), box = between(5, 50);
        body_ << "<svg x='" << x << "' y='" << y << "' width='" << w << "' height='" << h
              << "' viewBox='1 2 " << box << " " << box << "' preserveAspectRatio='xMaxYMid'>";
        const double s = std::min(w, h) / box;
        Mat3 step = Mat3::Identity();
        step << s, 0, x + w - s * box - s, 0, s, y + (h - s * box) / 2 - 2 * s, 0, 0, 1;
        group(to_page * step, depth + 1, shown);
        body_ << "</svg>";
      } else {
        const bool hidden = random_() % 5 == 0;
        body_ << "<g transform='" << transform(inner) << "'" << (hidden ? " display='none'" : "")
              << ">";
        group(inner, depth + 1, shown && !hidden);
        body_ << "</g>";
      }
    }
  }

  std::mt19937 random_;
  std::string head_, defs_;
  std::ostringstream body_;
  std::vector<Round> truth_;
};

}  // namespace

TEST_CASE("SVG: 300 random drawings have the curves that they were made of", "[io][drawings]") {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const RandomDrawing random(seed);
    const Drawing drawing = random.read();
    REQUIRE(drawing.lines.size() == random.truth().size());
    double worst = 0, size = 1;
    for (size_t i = 0; i < drawing.lines.size(); ++i) {
      const Round found = round_of(drawing, i), &right = random.truth()[i];
      worst = std::max(
          {worst, (found.centre - right.centre).norm(), std::abs(found.radius - right.radius)});
      size = std::max(size, right.centre.norm());
    }
    INFO("drawing " << seed);
    CHECK(worst < 1e-7 * size);
  }
}
