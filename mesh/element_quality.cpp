// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/element_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kFlattened = 1e-12;

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Corner positions of a face, without corners that repeat the previous one.
void corners_of(const ShellMesh& shells, const Points& points, int face, std::vector<Vec3>& p) {
  const auto nodes = shells.corners(face);
  p.clear();
  for (size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i] != nodes[i == 0 ? nodes.size() - 1 : i - 1])
      p.push_back(points.row(nodes[i]).transpose());
}

Vec3 area_vector(const std::vector<Vec3>& p) {
  Vec3 twice = Vec3::Zero();
  for (size_t i = 1; i + 1 < p.size(); ++i) twice += (p[i] - p[0]).cross(p[i + 1] - p[0]);
  return 0.5 * twice;
}

double ratio(double smallest, double largest) { return largest > 0 ? smallest / largest : 0; }

// Derivatives of the shape functions with respect to ξ and η at one point: one row per node.
using ShapeDerivatives = Eigen::Matrix<double, Eigen::Dynamic, 2>;

ShapeDerivatives quadratic_triangle(double xi, double eta) {
  const double zeta = 1 - xi - eta;
  ShapeDerivatives d(6, 2);
  d << 1 - 4 * zeta, 1 - 4 * zeta,  //
      4 * xi - 1, 0,                //
      0, 4 * eta - 1,               //
      4 * (zeta - xi), -4 * xi,     //
      4 * eta, 4 * xi,              //
      -4 * eta, 4 * (zeta - eta);
  return d;
}

ShapeDerivatives serendipity_quad(double xi, double eta) {
  ShapeDerivatives d(8, 2);
  const int corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int i = 0; i < 4; ++i) {
    // ¼ (1 + s ξ)(1 + t η)(s ξ + t η - 1)
    const double s = corner[i][0], t = corner[i][1];
    d(i, 0) = 0.25 * s * (1 + t * eta) * (2 * s * xi + t * eta);
    d(i, 1) = 0.25 * t * (1 + s * xi) * (s * xi + 2 * t * eta);
  }
  // ½ (1 - ξ²)(1 + t η) for the bottom and top midside nodes, ½ (1 + s ξ)(1 - η²) for right and
  // left.
  d.row(4) << -xi * (1 - eta), -0.5 * (1 - xi * xi);
  d.row(5) << 0.5 * (1 - eta * eta), -eta * (1 + xi);
  d.row(6) << -xi * (1 + eta), 0.5 * (1 - xi * xi);
  d.row(7) << -0.5 * (1 - eta * eta), -eta * (1 - xi);
  return d;
}

const std::vector<ShapeDerivatives>& derivatives_at_nodes(size_t nodes) {
  static const std::vector<ShapeDerivatives> triangle = [] {
    const double at[6][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}};
    std::vector<ShapeDerivatives> all;
    for (const auto& [xi, eta] : at) all.push_back(quadratic_triangle(xi, eta));
    return all;
  }();
  static const std::vector<ShapeDerivatives> quad = [] {
    const double at[8][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    std::vector<ShapeDerivatives> all;
    for (const auto& [xi, eta] : at) all.push_back(serendipity_quad(xi, eta));
    return all;
  }();
  return nodes == 6 ? triangle : quad;
}

double second_order_jacobian(const ShellMesh& shells, const Points& points, int face,
                             const Vec3& n) {
  const auto nodes = shells.face(face);
  double smallest = kInfinity, largest = -kInfinity;
  for (const ShapeDerivatives& d : derivatives_at_nodes(nodes.size())) {
    Vec3 x_xi = Vec3::Zero(), x_eta = Vec3::Zero();
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Vec3 p = (points.row(nodes[i]) - points.row(nodes[0])).transpose();
      x_xi += d(static_cast<int>(i), 0) * p;
      x_eta += d(static_cast<int>(i), 1) * p;
    }
    const double J = n.dot(x_xi.cross(x_eta));
    smallest = std::min(smallest, J);
    largest = std::max(largest, J);
  }
  return ratio(smallest, largest);
}

// All measures of a face with corners p.
ElementQuality measure(const ShellMesh& shells, const Points& points, int face,
                       const std::vector<Vec3>& p) {
  for (const int node : shells.face(face))
    if (!points.row(node).allFinite())
      return {kNotANumber, kNotANumber, kNotANumber, kNotANumber, kNotANumber};
  const size_t k = p.size();
  if (k < 3) return {kInfinity, 0, 0, 0, 0};

  const Vec3 area = area_vector(p);
  const Vec3 n = area / std::max(area.norm(), std::numeric_limits<double>::min());
  double longest = 0, narrowest = kInfinity, smallest_J = kInfinity, largest_J = -kInfinity,
         smallest = kInfinity, largest = 0, warpage = 0;
  std::vector<Vec3> normal(k);
  for (size_t i = 0; i < k; ++i) {
    const Vec3 next = p[(i + 1) % k] - p[i], previous = p[(i + k - 1) % k] - p[i];
    const double length = next.norm();
    longest = std::max(longest, length);
    double width = 0;
    for (size_t j = 2; j < k && length > 0; ++j)
      width = std::max(width, next.cross(p[(i + j) % k] - p[i]).norm() / length);
    narrowest = std::min(narrowest, width);
    normal[i] = next.cross(previous);
    const double J = n.dot(normal[i]);
    smallest_J = std::min(smallest_J, J);
    largest_J = std::max(largest_J, J);
    double angle = angle_between(next, previous);
    if (J < 0) angle = 2 * std::numbers::pi - angle;
    smallest = std::min(smallest, angle);
    largest = std::max(largest, angle);
  }
  if (k == 4) {
    warpage = std::max(angle_between(normal[0], normal[2]), angle_between(normal[1], normal[3]));
  } else if (k > 4) {
    for (size_t i = 0; i < k; ++i)
      for (size_t j = 0; j < i; ++j)
        warpage = std::max(warpage, angle_between(normal[i], normal[j]));
  }
  const double regular = k % 2 == 0 ? 1 / std::tan(std::numbers::pi / static_cast<double>(k))
                                    : 0.5 / std::tan(std::numbers::pi / static_cast<double>(2 * k));
  ElementQuality q;
  q.aspect = narrowest > 0 ? regular * longest / narrowest : kInfinity;
  q.warpage_degrees = degrees(warpage);
  q.smallest_angle_degrees = degrees(smallest);
  q.largest_angle_degrees = degrees(largest);
  if (shells.second_order(face)) {
    q.jacobian = second_order_jacobian(shells, points, face, n);
  } else if (k == 3) {
    q.jacobian = narrowest > kFlattened * longest ? 1 : 0;
  } else {
    q.jacobian = ratio(smallest_J, largest_J);
  }
  return q;
}

void check_size(const ShellMesh& shells, const Points& points) {
  if (points.rows() != shells.node_count())
    throw InputError("element quality: found " + std::to_string(points.rows()) + " points for " +
                     std::to_string(shells.node_count()) + " nodes, expected one for each");
}

// Accumulates one measure over all faces; `sign`: +1 if large values are bad, -1 if small ones are.
class MeasureAccumulator {
 public:
  explicit MeasureAccumulator(double sign) : sign_(sign) {}
  void add(int face, double value, double limit) {
    const bool better_than_worst =
        summary_.worst_face >= 0 &&
        (std::isnan(summary_.worst) || sign_ * value <= sign_ * summary_.worst);
    if (!better_than_worst) {
      summary_.worst = value;
      summary_.worst_face = face;
    }
    if (!(sign_ * value <= sign_ * limit)) ++summary_.violations;
    if (std::isfinite(value)) {
      sum_ += value;
      ++finite_;
    }
  }
  MeasureSummary summary() const {
    MeasureSummary result = summary_;
    if (finite_ > 0) result.mean = sum_ / finite_;
    return result;
  }

 private:
  double sign_, sum_ = 0;
  int finite_ = 0;
  MeasureSummary summary_;
};

// Two faces that share an edge; `same_winding`: they traverse it in opposite directions.
struct Hinge {
  int first, second;
  bool same_winding;
};

std::vector<Hinge> hinges(const ShellMesh& shells) {
  struct Side {
    int low, high, face;
    bool forwards;
    bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
  };
  std::vector<Side> sides;
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto nodes = shells.corners(f);
    for (size_t i = 0; i < nodes.size(); ++i) {
      const int a = nodes[i], b = nodes[(i + 1) % nodes.size()];
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.face} < std::array{b.low, b.high, b.face};
  });
  std::vector<Hinge> result;
  for (size_t begin = 0, end; begin < sides.size(); begin = end) {
    end = begin + 1;
    while (end < sides.size() && sides[end].same_edge(sides[begin])) ++end;
    const Side &a = sides[begin], &b = sides[end - 1];
    if (end == begin + 2 && a.face != b.face)
      result.push_back({a.face, b.face, a.forwards != b.forwards});
  }
  return result;
}

std::vector<Vec3> area_vectors(const ShellMesh& shells, const Points& points) {
  std::vector<Vec3> result(shells.face_count()), p;
  for (int f = 0; f < shells.face_count(); ++f) {
    corners_of(shells, points, f, p);
    result[f] = area_vector(p);
  }
  return result;
}

}  // namespace

ElementQuality quality_of(const ShellMesh& shells, const Points& points, int face) {
  std::vector<Vec3> p;
  corners_of(shells, points, face, p);
  return measure(shells, points, face, p);
}

QualitySummary summarize(const ShellMesh& shells, const Points& points,
                         const QualityLimits& limits) {
  check_size(shells, points);
  MeasureAccumulator aspect(1), warpage(1), jacobian(-1), smallest(-1), largest(1);
  std::vector<Vec3> p;
  for (int f = 0; f < shells.face_count(); ++f) {
    corners_of(shells, points, f, p);
    const ElementQuality q = measure(shells, points, f, p);
    const bool triangle = p.size() <= 3;
    aspect.add(f, q.aspect, limits.aspect);
    warpage.add(f, q.warpage_degrees, limits.warpage_degrees);
    jacobian.add(f, q.jacobian, limits.jacobian);
    smallest.add(f, q.smallest_angle_degrees,
                 triangle ? limits.smallest_triangle_angle_degrees : limits.smallest_angle_degrees);
    largest.add(f, q.largest_angle_degrees,
                triangle ? limits.largest_triangle_angle_degrees : limits.largest_angle_degrees);
  }
  return {shells.face_count(), aspect.summary(),   warpage.summary(),
          jacobian.summary(),  smallest.summary(), largest.summary()};
}

namespace {

/// Faces with a smaller ratio were bad before the edit: a straight corner has 0, up to rounding.
constexpr double kSoundJacobian = 1e-6;

}  // namespace

std::vector<int> inverted_faces(const ShellMesh& shells, const Points& before,
                                const Points& after) {
  check_size(shells, before);
  check_size(shells, after);
  std::vector<char> inverted(shells.face_count(), 0);
  for (int f = 0; f < shells.face_count(); ++f)
    inverted[f] = quality_of(shells, before, f).jacobian > kSoundJacobian &&
                  !(quality_of(shells, after, f).jacobian > 0);

  const std::vector<Vec3> normal_before = area_vectors(shells, before),
                          normal_after = area_vectors(shells, after);
  std::vector<Hinge> folds;
  std::vector<int> fold_count(shells.face_count(), 0);
  for (const Hinge& hinge : hinges(shells)) {
    const auto angle = [&](const std::vector<Vec3>& normal) {
      const double sign = hinge.same_winding ? 1 : -1;
      return degrees(angle_between(normal[hinge.first], sign * normal[hinge.second]));
    };
    if (!(angle(normal_before) < 90 && angle(normal_after) > 120)) continue;
    folds.push_back(hinge);
    ++fold_count[hinge.first];
    ++fold_count[hinge.second];
  }
  for (const auto& [first, second, same_winding] : folds) {
    if (fold_count[first] >= fold_count[second]) inverted[first] = 1;
    if (fold_count[second] >= fold_count[first]) inverted[second] = 1;
  }
  std::vector<int> result;
  for (int f = 0; f < shells.face_count(); ++f)
    if (inverted[f]) result.push_back(f);
  return result;
}

namespace {

/// A corner and its three neighbours, right-handed in a valid element.
using Corner = std::array<int, 4>;
constexpr std::array<Corner, 4> kTetrahedron{
    {{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 1, 0, 2}}};
constexpr std::array<Corner, 4> kPyramid{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<Corner, 6> kWedge{
    {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5}, {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}}};
constexpr std::array<Corner, 8> kHexahedron{{{0, 1, 3, 4},
                                             {1, 2, 0, 5},
                                             {2, 3, 1, 6},
                                             {3, 0, 2, 7},
                                             {4, 7, 5, 0},
                                             {5, 4, 6, 1},
                                             {6, 5, 7, 2},
                                             {7, 6, 4, 3}}};

std::span<const Corner> solid_corners_of(int count) {
  switch (count) {
    case 4:
      return kTetrahedron;
    case 5:
      return kPyramid;
    case 6:
      return kWedge;
    case 8:
      return kHexahedron;
    default:
      return {};
  }
}

double volume(const Points& p, const std::vector<int>& nodes, const Corner& c) {
  const auto edge = [&](int k) -> Vec3 {
    return (p.row(nodes[c[k]]) - p.row(nodes[c[0]])).transpose();
  };
  return edge(1).cross(edge(2)).dot(edge(3));
}

}  // namespace

int corner_count(const NonShellElement& solid) {
  if (solid.kind != NonShellElement::Kind::Solid) return 0;
  switch (solid.nodes.size()) {
    case 4:
    case 10:
      return 4;
    case 5:
    case 13:
      return 5;
    case 6:
    case 15:
      return 6;
    case 8:
    case 20:
    case 27:
      return 8;
    default:
      return 0;
  }
}

std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after) {
  std::vector<int> result;
  for (int e = 0; e < isize(elements); ++e) {
    const auto corners = solid_corners_of(corner_count(elements[e]));
    double largest = 0, sum = 0;
    for (const Corner& c : corners) {
      const double v0 = volume(before, elements[e].nodes, c);
      largest = std::max(largest, std::abs(v0));
      sum += v0;
    }
    // Corners of the other sign were inverted before the edit.
    if (std::any_of(corners.begin(), corners.end(), [&](const Corner& c) {
          const double v0 = volume(before, elements[e].nodes, c);
          return v0 * sum > 0 && std::abs(v0) > 1e-9 * largest &&
                 !(volume(after, elements[e].nodes, c) * v0 > 0);
        }))
      result.push_back(e);
  }
  return result;
}

}  // namespace batten
