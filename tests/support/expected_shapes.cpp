// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/expected_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "batten/tests/support/sampling.h"

namespace batten_test {
namespace {

using std::numbers::pi;
using Map = std::function<Vec3(double u, double v)>;
using Path = std::function<Vec3(double t)>;

constexpr double kFar = std::numeric_limits<double>::max();

// --------------------------------------------------------------------------------------- variation

/// Dimensions and point counts of one shape: the standard ones for seed 0, random ones otherwise.
class Variation {
 public:
  Variation(unsigned seed, unsigned shape) : plain_(seed == 0), random_(7919 * seed + shape) {}

  bool plain() const { return plain_; }
  double length(double usual, double fraction = 0.2) {
    return plain_ ? usual : usual * random_.between(1 - fraction, 1 + fraction);
  }
  /// Number of points of a curve, `fewest` to three times the usual number.
  int count(int usual, int fewest) {
    return plain_ ? usual : static_cast<int>(random_.between(fewest, 3 * usual + 1));
  }
  /// Start angle of a closed curve.
  double phase(double usual) { return plain_ ? usual : random_.between(0, 2 * pi); }

  /// Rotates, scales and translates everything; reverses curves and shuffles them.
  void place(ExpectedShape& shape) {
    if (plain_) return;
    Eigen::Quaterniond q(random_(), random_(), random_(), random_());
    q.normalize();
    constexpr std::array scales{0.01, 0.3, 1.0, 25.4, 1000.0};
    const double scale = scales[static_cast<size_t>(random_.between(0, scales.size()))];
    const Vec3 shift = 60 * random_.point();
    const auto moved = [=](const Vec3& p) -> Vec3 { return scale * (q * p + shift); };
    for (TypedCurve& c : shape.curves) {
      for (Vec3& p : c.points) p = moved(p);
      if (random_() > 0) std::reverse(c.points.begin(), c.points.end());
    }
    for (size_t i = shape.curves.size(); i > 1; --i)
      std::swap(shape.curves[i - 1],
                shape.curves[static_cast<size_t>(random_.between(0, static_cast<double>(i)))]);
    for (ExpectedPatch& patch : shape.patches)
      patch.at = [at = patch.at, moved](double u, double v) { return moved(at(u, v)); };
    if (shape.area) *shape.area *= scale * scale;
    if (shape.volume) *shape.volume *= scale * scale * scale;
  }

 private:
  bool plain_;
  Random random_;
};

// --------------------------------------------------------------------------------- curves, patches

std::vector<Vec3> typed(const Path& path, int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(path(i / (count - 1.0)));
  return points;
}
/// The same with the first point repeated exactly.
std::vector<Vec3> typed_ring(const Path& path, int count) {
  auto points = typed(path, count);
  points.back() = points.front();
  return points;
}

Path along_u(const Map& f, double v) {
  return [=](double t) { return f(t, v); };
}
Path along_v(const Map& f, double u) {
  return [=](double t) { return f(u, t); };
}

Map sphere(double r, double longitude, double from, double to) {
  return [=](double u, double v) {
    const double a = longitude * u, b = from + (to - from) * v;
    return Vec3(r * std::cos(b) * std::cos(a), r * std::cos(b) * std::sin(a), r * std::sin(b));
  };
}

/// Adds f over [0, 1]² in `pieces` patches along u.
void add_patches(ExpectedShape& shape, const Map& f, int pieces = 1, bool required = true) {
  for (int k = 0; k < pieces; ++k)
    shape.patches.emplace_back([=](double u, double v) { return f((k + u) / pieces, v); }, 24,
                               required);
}

/// Flat triangle.
void add_triangle(ExpectedShape& shape, const Vec3& a, const Vec3& b, const Vec3& c) {
  shape.patches.emplace_back(
      [=](double u, double v) -> Vec3 { return a + v * ((1 - u) * b + u * c - a); }, 4);
}
void add_quadrangle(ExpectedShape& shape, const Vec3& a, const Vec3& b, const Vec3& c,
                    const Vec3& d) {
  shape.patches.emplace_back(
      [=](double u, double v) -> Vec3 {
        return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c);
      },
      4);
}

/// Four sides of f over the unit square. Sides with a count of 2 are straight; sides with a count
/// of 1 are omitted.
ExpectedShape four_sides(const std::string& name, const std::string& group, const Map& f,
                         int along_u_count, int along_v_count, double tolerance) {
  ExpectedShape shape{name, group, {}, {}, tolerance, {}, {}};
  shape.curves = {{"south", typed(along_u(f, 0), along_u_count)},
                  {"north", typed(along_u(f, 1), along_u_count)},
                  {"west", typed(along_v(f, 0), along_v_count)},
                  {"east", typed(along_v(f, 1), along_v_count)}};
  add_patches(shape, f);
  shape.lofts = {{{"south", "north"}}, {{"west", "east"}}};
  return shape;
}

// -------------------------------------------------------------------- cylinders, cones and spheres

ExpectedShape cylinder(Variation v, double degrees, double radius, double length, int count,
                       int fewest) {
  const double a = degrees * pi / 180, r = v.length(radius), l = v.length(length);
  const Map f = [=](double u, double w) {
    return Vec3(r * std::cos(a * u), l * w, r * std::sin(a * u));
  };
  ExpectedShape shape = four_sides("cylinder " + std::to_string(static_cast<int>(degrees)),
                                   "revolved", f, v.count(count, fewest), 2, 1e-3);
  if (degrees > 180) {
    shape.patches.clear();
    add_patches(shape, f, 2);
  }
  shape.area = a * r * l;
  v.place(shape);
  return shape;
}

ExpectedShape tube(Variation v, const std::string& name, double low, double high, double length,
                   int fewest) {
  const double r0 = v.length(low, 0.1), r1 = low == high ? r0 : v.length(high, 0.1);
  const double l = v.length(length, 0.1);
  const Map f = [=](double u, double w) {
    const double r = r0 + (r1 - r0) * w;
    return Vec3(r * std::cos(2 * pi * u), r * std::sin(2 * pi * u), l * w);
  };
  ExpectedShape shape{name, "revolved", {}, {}, 1e-3, pi * (r0 + r1) * std::hypot(l, r1 - r0), {}};
  const double from = v.phase(0.25) / (2 * pi);
  shape.curves = {
      {"low", typed_ring(along_u(f, 0), v.count(25, fewest))},
      {"high", typed_ring([&](double t) { return f(t + from, 1); }, v.count(25, fewest))}};
  add_patches(shape, f, 4);
  shape.lofts = {{{"low", "high"}}};
  v.place(shape);
  return shape;
}

ExpectedShape cone(Variation v) {
  const double r = v.length(35), h = v.length(60);
  const Map f = [=](double u, double w) {
    return Vec3(r * (1 - w) * std::cos(2 * pi * u), r * (1 - w) * std::sin(2 * pi * u), h * w);
  };
  ExpectedShape shape{"cone", "revolved", {}, {}, 1e-3, pi * r * std::hypot(r, h), {}};
  const int count = v.count(7, 4);
  for (int k = 0; k < 4; ++k) {
    const std::string number = std::to_string(k + 1);
    shape.curves.push_back(
        {"arc " + number, typed([&](double t) { return f((k + t) / 4, 0); }, count)});
    shape.curves.push_back({"line " + number, {f(k / 4.0, 0), Vec3(0, 0, h)}});
  }
  add_patches(shape, f, 4);
  v.place(shape);
  return shape;
}

/// Three sides: f(u, 1) is one point.
ExpectedShape octant(Variation v, const std::string& name, const Vec3& axes, int count,
                     double tolerance) {
  const Vec3 r = axes.x() == axes.z() ? Vec3(Vec3::Constant(v.length(axes.x())))
                                      : Vec3(v.length(axes.x(), 0.1), v.length(axes.y(), 0.1),
                                             v.length(axes.z(), 0.1));
  const Map unit = sphere(1, pi / 2, 0, pi / 2);
  const Map f = [=](double u, double w) { return Vec3(r.cwiseProduct(unit(u, w))); };
  ExpectedShape shape{name, "revolved", {}, {}, tolerance, {}, {}};
  const int n = v.count(count, 5);
  shape.curves = {{"equator", typed(along_u(f, 0), n)},
                  {"first meridian", typed(along_v(f, 0), n)},
                  {"second meridian", typed(along_v(f, 1), n)}};
  for (TypedCurve& c : shape.curves)
    if (c.name != "equator") c.points.back() = Vec3(0, 0, r.z());
  add_patches(shape, f);
  if (r.x() == r.z()) shape.area = pi / 2 * r.x() * r.x();
  v.place(shape);
  return shape;
}

ExpectedShape strip(Variation v) {
  const double r = v.length(40), top = 75 * pi / 180;
  ExpectedShape shape = four_sides("sphere to 75 degrees", "revolved", sphere(r, pi / 2, 0, top),
                                   v.count(9, 5), v.count(9, 5), 1e-3);
  shape.area = pi / 2 * r * r * std::sin(top);
  v.place(shape);
  return shape;
}

ExpectedShape lune(Variation v) {
  const double r = v.length(12);
  const Map f = sphere(r, pi / 2, -pi / 2, pi / 2);
  ExpectedShape shape{"lune", "revolved", {}, {}, 2e-3, pi * r * r, {}};
  const int n = v.count(13, 7);
  for (const int side : {0, 1}) {
    auto points = typed(along_v(f, side), n);
    points.front() = Vec3(0, 0, -r);
    points.back() = Vec3(0, 0, r);
    shape.curves.push_back({side ? "second half circle" : "first half circle", points});
  }
  add_patches(shape, f);
  shape.lofts = {{{"first half circle", "second half circle"}}};
  v.place(shape);
  return shape;
}

ExpectedShape dome(Variation v) {
  const double r = v.length(75);
  const Map f = sphere(r, 2 * pi, 0, pi / 2);
  ExpectedShape shape{"dome", "revolved", {}, {}, 1e-3, 2 * pi * r * r, {}};
  // Odd counts: the half circles have a common point at the top.
  const int n = 2 * (v.count(17, 9) / 2) + 1;
  const auto over = [&](const Vec3& x) {
    return typed(
        [&](double t) -> Vec3 {
          return r * (std::cos(pi * t) * x + std::sin(pi * t) * Vec3::UnitZ());
        },
        n);
  };
  shape.curves = {{"rim", typed_ring(along_u(f, 0), v.count(33, 17))},
                  {"over x", over(Vec3::UnitX())},
                  {"over y", over(Vec3::UnitY())}};
  add_patches(shape, f, 4);
  v.place(shape);
  return shape;
}

// ----------------------------------------------------------------------- tori and rows of sections

Map torus(double axis, double tube_radius) {  // angles u along the axis, v around the tube
  return [=](double u, double v) {
    const double r = axis + tube_radius * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), tube_radius * std::sin(v));
  };
}

ExpectedShape torus_piece(Variation v) {
  const Map t = torus(v.length(60, 0.1), v.length(20, 0.1));
  const Map f = [=](double u, double w) { return t(pi / 2 * u, pi * (0.75 * w - 0.25)); };
  ExpectedShape shape =
      four_sides("piece of a torus", "revolved", f, v.count(9, 5), v.count(9, 6), 1e-3);
  v.place(shape);
  return shape;
}

/// Closed sections of f at v = 0, 1/(n-1), …, 1; u runs around.
void add_sections(ExpectedShape& shape, Variation& v, const Map& f, const std::vector<double>& at,
                  int count, int fewest) {
  shape.lofts = {{{}}};
  for (size_t k = 0; k < at.size(); ++k) {
    const double from = v.phase(0.3 * static_cast<double>(k)) / (2 * pi);
    shape.curves.push_back(
        {"section " + std::to_string(k + 1),
         typed_ring([&](double t) { return f(t + from, at[k]); }, v.count(count, fewest))});
    shape.lofts[0][0].push_back(shape.curves.back().name);
  }
  add_patches(shape, f, 4);
}

ExpectedShape elbow(Variation v) {
  const Map t = torus(v.length(65, 0.1), v.length(20, 0.1));
  const Map f = [=](double u, double w) { return t(pi / 2 * w, 2 * pi * u); };
  ExpectedShape shape{"elbow of five circles", "sections", {}, {}, 2e-3, {}, {}};
  add_sections(shape, v, f, {0, 0.25, 0.5, 0.75, 1}, 25, 13);
  v.place(shape);
  return shape;
}

/// Second derivatives of the natural cubic spline: Thomas algorithm.
std::vector<double> spline_moments(const std::vector<double>& x, const std::vector<double>& y) {
  const size_t n = x.size();
  std::vector<double> moments(n, 0), ratio(n, 0);
  for (size_t i = 1; i + 1 < n; ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    const double pivot = 2 * (before + after) - before * ratio[i - 1];
    const double bend = 6 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
    ratio[i] = after / pivot;
    moments[i] = (bend - before * moments[i - 1]) / pivot;
  }
  for (size_t i = n - 1; i-- > 1;) moments[i] -= ratio[i] * moments[i + 1];
  return moments;
}

ExpectedShape bottle(Variation v) {
  const std::vector<double> z = {0, 32, 60, 92, 120};
  std::vector<double> r = {21, 28, 30, 21, 12};
  for (double& radius : r) radius = v.length(radius, 0.1);
  const Map f = [z, r, m = spline_moments(z, r)](double u, double w) {
    const double height = z.back() * w;
    size_t i = 0;
    while (i + 2 < z.size() && height > z[i + 1]) ++i;
    const double h = z[i + 1] - z[i], b = (height - z[i]) / h, a = 1 - b;
    const double radius =
        a * r[i] + b * r[i + 1] + h * h / 6 * ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]);
    return Vec3(radius * std::cos(2 * pi * u), radius * std::sin(2 * pi * u), height);
  };
  ExpectedShape shape{"bottle of five circles", "sections", {}, {}, 1e-2, {}, {}};
  std::vector<double> at;
  for (const double height : z) at.push_back(height / z.back());
  add_sections(shape, v, f, at, 25, 13);
  v.place(shape);
  return shape;
}

/// Two defensible results, correspondence by angle and by arc length, are 8e-3 apart.
ExpectedShape crossed_ellipses(Variation v) {
  const double a = v.length(10, 0.1), b = 0.4 * a, l = v.length(80);
  const Map f = [=](double u, double w) {
    return Vec3((a + (b - a) * w) * std::cos(2 * pi * u), (b + (a - b) * w) * std::sin(2 * pi * u),
                l * w);
  };
  ExpectedShape shape{"tube of crossed ellipses", "sections", {}, {}, 1e-2, {}, {}};
  add_sections(shape, v, f, {0, 1}, 41, 25);
  v.place(shape);
  return shape;
}

// --------------------------------------------------------------------------------- wings and hulls

/// Surface of a NACA four-digit airfoil of chord 1 with a closed trailing edge, at the fraction x.
Vec2 naca(double camber, double camber_at, double thickness, double x, bool upper) {
  const double half =
      5 * thickness *
      (0.2969 * std::sqrt(x) + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x))));
  double mean = 0, slope = 0;
  if (camber > 0) {
    const bool front = x < camber_at;
    const double scale = camber / std::pow(front ? camber_at : 1 - camber_at, 2);
    mean = scale * ((front ? 0 : 1 - 2 * camber_at) + 2 * camber_at * x - x * x);
    slope = 2 * scale * (camber_at - x);
  }
  const double side = (upper ? half : -half) / std::hypot(1, slope);
  return {x - side * slope, mean + side};
}

ExpectedShape wing(Variation v, const std::string& name, double root_camber, double span,
                   double sweep) {
  const double tip_chord = v.length(0.5), y = v.length(span);
  // Cosine spacing: points accumulate at both edges.
  const auto section = [=](bool tip, bool upper, double u) {
    const Vec2 p = naca(tip ? 0 : root_camber, 0.4, 0.12, 0.5 * (1 - std::cos(pi * u)), upper);
    const double chord = tip ? tip_chord : 1;
    return Vec3((tip ? sweep : 0) + chord * p.x(), tip ? y : 0, chord * p.y());
  };
  ExpectedShape shape{name, "sections", {}, {}, 3e-3, {}, {}};
  const int count = v.count(31, 23);
  for (const bool tip : {false, true})
    for (const bool upper : {true, false})
      shape.curves.push_back({std::string(tip ? "tip " : "root ") + (upper ? "upper" : "lower"),
                              typed([&](double u) { return section(tip, upper, u); }, count)});
  shape.curves.push_back({"leading edge", {section(false, true, 0), section(true, true, 0)}});
  shape.curves.push_back({"trailing edge", {section(false, true, 1), section(true, true, 1)}});
  for (const bool upper : {true, false})
    add_patches(shape, [=](double u, double w) -> Vec3 {
      return (1 - w) * section(false, upper, u) + w * section(true, upper, u);
    });
  for (const bool tip : {false, true})
    add_patches(
        shape,
        [=](double u, double w) -> Vec3 {
          return (1 - w) * section(tip, false, u) + w * section(tip, true, u);
        },
        1, false);
  shape.lofts = {{{"root upper", "tip upper"}, {"root lower", "tip lower"}}};
  v.place(shape);
  return shape;
}

/// Half of a Wigley hull with nine stations.
ExpectedShape hull(Variation v) {
  const double length = 10, beam = v.length(1), draft = v.length(0.625, 0.1);
  const Map f = [=](double u, double w) {
    const double x = 2 * u - 1, z = 1 - w;  // from the keel up to the deck
    return Vec3(length / 2 * x, beam / 2 * (1 - x * x) * (1 - z * z), -draft * z);
  };
  ExpectedShape shape{"hull of nine stations", "sections", {}, {}, 1e-3, {}, {}};
  const int count = v.count(9, 7);
  shape.lofts = {{{}}};
  for (int k = 1; k <= 9; ++k) {
    shape.curves.push_back({"station " + std::to_string(k), typed(along_v(f, k / 10.0), count)});
    shape.lofts[0][0].push_back(shape.curves.back().name);
  }
  shape.lofts[0][0].insert(shape.lofts[0][0].begin(), "stern");
  shape.lofts[0][0].push_back("bow");
  // Odd multiples of ten intervals: the deck has a point at every station.
  shape.curves.push_back({"deck", typed(along_u(f, 1), v.plain() ? 21 : 31)});
  shape.curves.push_back({"keel", typed(along_u(f, 0), 2)});
  shape.curves.push_back({"stern", typed(along_v(f, 0), 2)});
  shape.curves.push_back({"bow", typed(along_v(f, 1), 2)});
  add_patches(shape, f);
  v.place(shape);
  return shape;
}

// ------------------------------------------------------------------------- saddles, ruled surfaces

ExpectedShape saddle(Variation v) {
  const double h = v.length(20);
  const Map f = [=](double u, double w) {
    const double x = 2 * u - 1, y = 2 * w - 1;
    return Vec3(50 * x, 50 * y, h * (x * x - y * y));
  };
  ExpectedShape shape = four_sides("saddle", "ruled", f, v.count(9, 5), v.count(9, 5), 3e-3);
  v.place(shape);
  return shape;
}

ExpectedShape hypar(Variation v) {
  const double h = v.length(20);
  const Map f = [=](double u, double w) {
    return Vec3(100 * u, 100 * w, h * (2 * u - 1) * (2 * w - 1));
  };
  ExpectedShape shape = four_sides("hypar", "ruled", f, 2, 2, 2e-3);
  v.place(shape);
  return shape;
}

ExpectedShape ruled_strip(Variation v) {
  const double h = v.length(25);
  const Map f = [=](double u, double w) {
    const double s = std::sin(pi * u);
    return Vec3(100 * u, 60 * w, h * s * ((1 - w) + 0.5 * w * s * s));
  };
  ExpectedShape shape = four_sides("ruled strip", "ruled", f, v.count(17, 13), 2, 5e-3);
  v.place(shape);
  return shape;
}

ExpectedShape helicoid(Variation v) {
  const double turn = v.length(pi / 2), rise = v.length(50);
  const Map f = [=](double u, double w) {
    const double r = 20 + 40 * u;
    return Vec3(r * std::cos(turn * w), r * std::sin(turn * w), rise * w);
  };
  ExpectedShape shape = four_sides("helicoid", "ruled", f, 2, v.count(13, 7), 2e-3);
  v.place(shape);
  return shape;
}

/// Two arches on straight sills, the second one higher by a percentage.
ExpectedShape canopy(Variation v, int percent) {
  const double r = v.length(60), l = v.length(120);
  const Map f = [=](double u, double w) {
    return Vec3(-r * std::cos(pi * u), l * w, r * (1 + percent / 100.0 * w) * std::sin(pi * u));
  };
  ExpectedShape shape = four_sides("canopy, " + std::to_string(percent) + " % higher", "ruled", f,
                                   v.count(13, 7), 2, percent ? 5e-3 : 2e-3);
  if (percent == 0 && v.plain()) shape.curves[0].points = typed(along_u(f, 0), 5);
  v.place(shape);
  return shape;
}

ExpectedShape vessel(Variation v) {
  const double r = v.length(100), l = v.length(200);
  const Map wall = [=](double u, double w) {
    return Vec3(r * std::cos(pi / 2 * u), r * std::sin(pi / 2 * u), l * (w - 1));
  };
  const Map head = sphere(r, pi / 2, 0, pi / 2);
  ExpectedShape shape{"vessel", "revolved", {}, {}, 1e-3, pi / 2 * r * l + pi / 2 * r * r, {}};
  const int count = v.count(9, 5);
  shape.curves = {{"foot", typed(along_u(wall, 0), count)},
                  {"seam", typed(along_u(wall, 1), count)},
                  {"first side", {wall(0, 0), wall(0, 1)}},
                  {"second side", {wall(1, 0), wall(1, 1)}},
                  {"first meridian", typed(along_v(head, 0), count)},
                  {"second meridian", typed(along_v(head, 1), count)}};
  for (const size_t meridian : {4, 5}) shape.curves[meridian].points.back() = Vec3(0, 0, r);
  // The same corner from both formulas.
  shape.curves[5].points.front() = shape.curves[1].points.back() = shape.curves[3].points.back();
  shape.curves[0].points.back() = shape.curves[3].points.front();
  add_patches(shape, wall);
  add_patches(shape, head);
  v.place(shape);
  return shape;
}

// --------------------------------------------------------------------------- flat outlines, solids

/// One closed polyline in the plane z = 0, star-shaped around `middle`.
ExpectedShape outline(Variation v, const std::string& name, const std::vector<Vec2>& corners,
                      const Vec2& middle) {
  ExpectedShape shape{name, "flat", {}, {}, 1e-6, 0.0, {}};
  const auto in_space = [](const Vec2& p) { return Vec3(p.x(), p.y(), 0); };
  shape.curves = {{"outline", {}}};
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    shape.curves[0].points.push_back(in_space(a));
    *shape.area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    add_triangle(shape, in_space(middle), in_space(a), in_space(b));
  }
  shape.curves[0].points.push_back(in_space(corners.front()));
  v.place(shape);
  return shape;
}

std::vector<Vec2> around(const std::vector<std::pair<double, double>>& radius_and_turn) {
  std::vector<Vec2> corners;
  for (const auto& [r, turn] : radius_and_turn)
    corners.emplace_back(r * std::cos(2 * pi * turn), r * std::sin(2 * pi * turn));
  return corners;
}

ExpectedShape star(Variation v) {
  const double inside = v.length(20, 0.1);
  std::vector<std::pair<double, double>> corners;
  for (int k = 0; k < 10; ++k) corners.emplace_back(k % 2 ? inside : 50, 0.25 + k / 10.0);
  return outline(v, "star", around(corners), Vec2::Zero());
}
ExpectedShape hexagon(Variation v) {
  const double r = v.length(30);
  std::vector<std::pair<double, double>> corners;
  for (int k = 0; k < 6; ++k) corners.emplace_back(r, k / 6.0);
  return outline(v, "hexagon", around(corners), Vec2::Zero());
}
ExpectedShape gear(Variation v, double tip) {
  constexpr double foot = 40;
  std::vector<std::pair<double, double>> corners;
  for (int tooth = 0; tooth < 12; ++tooth)
    for (const auto& [part, r] : {std::pair{0.0, foot}, {0.3, foot}, {0.5, tip}, {0.8, tip}})
      corners.emplace_back(r, (tooth + part) / 12);
  return outline(v, "gear", around(corners), Vec2::Zero());
}
ExpectedShape house(Variation v, double ridge) {
  return outline(v, "house", {{0, 0}, {40, 0}, {40, 30}, {20, ridge}, {0, 30}}, {20, 15});
}

/// Solid of nine straight edges.
ExpectedShape wedge(Variation v, int degrees) {
  const double l = v.length(100), w = v.length(40), h = l * std::tan(degrees * pi / 180);
  ExpectedShape shape{"wedge of " + std::to_string(degrees) + " degrees",
                      "solids",
                      {},
                      {},
                      1e-6,
                      {},
                      l * h / 2 * w};
  const std::array<Vec3, 3> front = {Vec3(0, 0, 0), Vec3(l, 0, 0), Vec3(l, 0, h)};
  std::array<Vec3, 3> back = front;
  for (Vec3& p : back) p.y() = w;
  double area = l * h;
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3;
    const std::string number = std::to_string(i + 1);
    shape.curves.push_back({"front " + number, {front[i], front[j]}});
    shape.curves.push_back({"back " + number, {back[i], back[j]}});
    shape.curves.push_back({"across " + number, {front[i], back[i]}});
    add_quadrangle(shape, front[i], front[j], back[j], back[i]);
    area += w * (front[j] - front[i]).norm();
  }
  shape.area = area;
  add_triangle(shape, front[0], front[1], front[2]);
  add_triangle(shape, back[0], back[1], back[2]);
  v.place(shape);
  return shape;
}

double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto from_segment = [&](const Vec3& s, const Vec3& e) {
    const Vec3 d = e - s;
    const double dd = d.squaredNorm();
    const double t = dd > 0 ? std::clamp((p - s).dot(d) / dd, 0.0, 1.0) : 0.0;
    return (p - s - t * d).squaredNorm();
  };
  const Vec3 n = (b - a).cross(c - a);
  const double nn = n.squaredNorm();
  if (nn > 0 && n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 &&
      n.dot((a - c).cross(p - c)) >= 0)
    return std::pow(n.dot(p - a), 2) / nn;
  return std::min({from_segment(a, b), from_segment(b, c), from_segment(c, a)});
}

}  // namespace

double ExpectedPatch::distance(const Vec3& p) const {
  if (nodes_.empty())
    for (int i = 0; i < cells; ++i)
      for (int j = 0; j < cells; ++j) nodes_.push_back(at((i + 0.5) / cells, (j + 0.5) / cells));
  size_t nearest = 0;
  double best = kFar;
  for (size_t k = 0; k < nodes_.size(); ++k)
    if (const double d = (nodes_[k] - p).squaredNorm(); d < best) {
      best = d;
      nearest = k;
    }
  const auto row = static_cast<size_t>(cells);
  double u = (static_cast<double>(nearest / row) + 0.5) / cells;
  double v = (static_cast<double>(nearest % row) + 0.5) / cells;
  for (int step = 0; step < 25; ++step) {
    constexpr double h = 1e-5;
    const double du = u < 0.5 ? h : -h, dv = v < 0.5 ? h : -h;
    const Vec3 x = at(u, v), x_u = (at(u + du, v) - x) / du, x_v = (at(u, v + dv) - x) / dv;
    const Vec3 away = p - x;
    Eigen::Matrix2d normal;
    normal << x_u.dot(x_u), x_u.dot(x_v), x_u.dot(x_v), x_v.dot(x_v);
    normal.diagonal().array() += 1e-9 * normal.trace() + 1e-300;  // degenerate at poles
    Vec2 move = normal.inverse() * Vec2(x_u.dot(away), x_v.dot(away));
    // On an active edge of the square, only the other parameter changes.
    if ((u <= 0 && move.x() < 0) || (u >= 1 && move.x() > 0))
      move = {0, x_v.dot(away) / normal(1, 1)};
    if ((v <= 0 && move.y() < 0) || (v >= 1 && move.y() > 0))
      move = {(u <= 0 && x_u.dot(away) < 0) || (u >= 1 && x_u.dot(away) > 0)
                  ? 0
                  : x_u.dot(away) / normal(0, 0),
              0};
    bool better = false;
    for (double fraction = 1; fraction > 1e-3 && !better; fraction /= 2) {
      const double a = std::clamp(u + fraction * move.x(), 0.0, 1.0);
      const double b = std::clamp(v + fraction * move.y(), 0.0, 1.0);
      const double d = (at(a, b) - p).squaredNorm();
      if (d >= best) continue;
      better = best - d > 1e-14 * best;
      best = d;
      u = a;
      v = b;
    }
    if (!better) break;
  }
  return std::sqrt(best);
}

double ExpectedShape::size() const {
  Vec3 low = curves.front().points.front(), high = low;
  for (const TypedCurve& c : curves)
    for (const Vec3& p : c.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  return (high - low).norm();
}

const TypedCurve& ExpectedShape::curve(const std::string& called) const {
  for (const TypedCurve& c : curves)
    if (c.name == called) return c;
  throw std::out_of_range(name + " has no curve '" + called + "'");
}

std::string ExpectedShape::csv() const {
  std::string text = "curve,x,y,z\n";
  for (const TypedCurve& c : curves)
    for (const Vec3& p : c.points) {
      char line[160];
      std::snprintf(line, sizeof line, "%s,%.9g,%.9g,%.9g\n", c.name.c_str(), p.x(), p.y(), p.z());
      text += line;
    }
  return text;
}

std::vector<Vec3> ExpectedShape::samples(int n) const {
  std::vector<Vec3> points;
  for (const ExpectedPatch& patch : patches)
    for (int i = 0; i < n && patch.required; ++i)
      for (int j = 0; j < n; ++j) points.push_back(patch.at((i + 0.5) / n, (j + 0.5) / n));
  return points;
}

double ExpectedShape::distance(const Vec3& p) const {
  double nearest = kFar;
  for (const ExpectedPatch& patch : patches) nearest = std::min(nearest, patch.distance(p));
  return nearest;
}

FacetedSurface::FacetedSurface(std::vector<Vec3> points,
                               const std::vector<std::array<int, 3>>& facets)
    : points_(std::move(points)), facets_(facets) {
  constexpr size_t most = 32;
  for (size_t begin = 0; begin < facets_.size(); begin += most) {
    Bundle bundle{begin, std::min(begin + most, facets_.size()), Vec3::Constant(1e300),
                  Vec3::Constant(-1e300)};
    for (size_t f = bundle.begin; f < bundle.end; ++f)
      for (const int k : facets_[f]) {
        bundle.low = bundle.low.cwiseMin(points_[static_cast<size_t>(k)]);
        bundle.high = bundle.high.cwiseMax(points_[static_cast<size_t>(k)]);
      }
    bundles_.push_back(bundle);
  }
}

double FacetedSurface::distance(const Vec3& p) const {
  std::vector<std::pair<double, const Bundle*>> order;
  order.reserve(bundles_.size());
  for (const Bundle& b : bundles_)
    order.emplace_back((p - p.cwiseMax(b.low).cwiseMin(b.high)).squaredNorm(), &b);
  std::sort(order.begin(), order.end());
  double best = kFar;
  for (const auto& [bound, bundle] : order) {
    if (bound >= best) break;
    for (size_t f = bundle->begin; f < bundle->end; ++f) {
      const auto& [a, b, c] = facets_[f];
      best = std::min(
          best, squared_distance(p, points_[static_cast<size_t>(a)],
                                 points_[static_cast<size_t>(b)], points_[static_cast<size_t>(c)]));
    }
  }
  return std::sqrt(best);
}

double FacetedSurface::area() const {
  double area = 0;
  for (const auto& [a, b, c] : facets_) {
    const Vec3& p = points_[static_cast<size_t>(a)];
    area += 0.5 *
            (points_[static_cast<size_t>(b)] - p).cross(points_[static_cast<size_t>(c)] - p).norm();
  }
  return area;
}

std::vector<ExpectedShape> expected_shapes(unsigned seed) {
  unsigned number = 0;
  const auto v = [&] { return Variation(seed, ++number); };
  std::vector<ExpectedShape> shapes;
  shapes.push_back(cylinder(v(), 90, 40, 70, 9, 4));
  shapes.push_back(cylinder(v(), 180, 50, 120, 7, 5));
  shapes.push_back(cylinder(v(), 270, 30, 80, 13, 9));
  shapes.push_back(tube(v(), "tube, short", 30, 30, 60, 9));
  shapes.push_back(tube(v(), "tube, long", 30, 30, 300, 13));
  shapes.push_back(tube(v(), "frustum", 40, 20, 60, 13));
  shapes.push_back(cone(v()));
  shapes.push_back(octant(v(), "octant of a sphere", Vec3::Constant(50), 7, 1e-3));
  shapes.push_back(strip(v()));
  shapes.push_back(lune(v()));
  shapes.push_back(dome(v()));
  shapes.push_back(octant(v(), "octant of an ellipsoid", {60, 40, 30}, 15, 1e-2));
  shapes.push_back(torus_piece(v()));
  shapes.push_back(vessel(v()));
  shapes.push_back(elbow(v()));
  shapes.push_back(bottle(v()));
  shapes.push_back(crossed_ellipses(v()));
  shapes.push_back(wing(v(), "wing, short", 0, 1, 0.1));
  shapes.push_back(wing(v(), "wing, span 4", 0, 4, 0.2));
  shapes.push_back(wing(v(), "wing, span 8", 0, 8, 0.4));
  shapes.push_back(wing(v(), "wing, two sections", 0.02, 3, 0.2));
  shapes.push_back(hull(v()));
  shapes.push_back(saddle(v()));
  shapes.push_back(hypar(v()));
  shapes.push_back(ruled_strip(v()));
  shapes.push_back(helicoid(v()));
  for (const int percent : {0, 2, 30}) shapes.push_back(canopy(v(), percent));
  shapes.push_back(star(v()));
  shapes.push_back(hexagon(v()));
  // Lower teeth and steeper roofs: ambiguous_outlines().
  Variation of_gear = v(), of_house = v();
  const double tip = of_gear.length(49, 0.02), ridge = of_house.length(43, 0.05);
  shapes.push_back(gear(of_gear, tip));
  shapes.push_back(house(of_house, ridge));
  shapes.push_back(wedge(v(), 16));
  shapes.push_back(wedge(v(), 10));
  return shapes;
}

std::vector<ExpectedShape> ambiguous_outlines() {
  std::vector<ExpectedShape> shapes{gear(Variation(0, 0), 46.2), house(Variation(0, 0), 49)};
  shapes[0].name = "gear with low teeth";
  shapes[1].name = "house with a steep roof";
  return shapes;
}

}  // namespace batten_test
