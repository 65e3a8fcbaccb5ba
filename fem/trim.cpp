// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/trim.h"

#include <algorithm>
#include <array>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

// Twice the signed area between the apex and the side.
double twice_area(const Vec2& apex, bool straight, const PlanarCubic& side) {
  if (straight) return cross(side.b[0] - apex, side.b[3] - apex);
  static const SegmentRule gauss = gauss_legendre(3);
  double sum = 0;
  for (long i = 0; i < gauss.s.size(); ++i)
    sum += gauss.weights[i] * cross(side.at(gauss.s[i]) - apex, side.slope(gauss.s[i]));
  return sum;
}

const SegmentRule& gauss(int points) {
  static const std::vector<SegmentRule> rules = [] {
    std::vector<SegmentRule> all(1);
    for (int n = 1; n <= 24; ++n) all.push_back(gauss_legendre(n));
    return all;
  }();
  return rules[std::min(points, 24)];
}

struct Piece {
  bool straight;
  PlanarCubic side;
};

// Boundary of the inside part of a sub-triangle.
class ClippedSubtriangle {
 public:
  ClippedSubtriangle(const std::array<Vec2, 3>& S, const DomainLoops& loops,
                     const std::vector<PlanarCubic>& segments)
      : S_(S), loops_(loops), twice_(cross(S[1] - S[0], S[2] - S[0])) {
    for (const PlanarCubic& segment : segments) add_segment(segment);
    for (int e = 0; e < 3; ++e) add_edge(e);
  }

  const std::vector<Piece>& boundary() const { return pieces_; }
  // Whether an arc passes through the sub-triangle.
  bool touched() const { return touched_; }

 private:
  // Relative tolerances. An arc along an edge belongs to neither side; the edge then bounds the
  // part.
  static constexpr double kOnEdge = 1e-12, kInward = 1e-10;
  enum class Position { Outside, Inside, AlongEdge };

  double height(int e, const Vec2& p) const {
    return cross(S_[(e + 1) % 3] - S_[e], p - S_[e]) / twice_;
  }

  double edge_parameter(int e, const Vec2& p) const {
    const Vec2 d = S_[(e + 1) % 3] - S_[e];
    return (p - S_[e]).dot(d) / d.squaredNorm();
  }

  // Adds the pieces of an arc between the lines of the edges: inside, or along an edge.
  void add_segment(const PlanarCubic& segment) {
    const std::vector<double> t = cut_by_edges(segment);
    for (size_t i = 0; i + 1 < t.size(); ++i) {
      if (t[i + 1] - t[i] < 1e-15) continue;
      int along = -1;
      const Position position = find_position(segment, t[i], t[i + 1], along);
      if (position == Position::Outside) continue;
      if (position == Position::Inside) {
        pieces_.push_back({false, segment.part(t[i], t[i + 1])});
        touched_ = true;
        continue;
      }
      const double a = edge_parameter(along, segment.at(t[i])),
                   b = edge_parameter(along, segment.at(t[i + 1]));
      covered_[along].push_back(std::minmax(a, b));
      breakpoints_[along].push_back(a);
      breakpoints_[along].push_back(b);
    }
  }

  // Parameters at which an arc crosses the lines of the edges, ascending, with the ends. Records
  // the crossings on the edges.
  std::vector<double> cut_by_edges(const PlanarCubic& segment) {
    std::vector<double> t{0, 1};
    for (int e = 0; e < 3; ++e) {
      BernsteinCubic distance;
      for (size_t i = 0; i < 4; ++i) distance.b[i] = height(e, segment.b[i]);
      for (const double zero : distance.zeros()) {
        t.push_back(zero);
        breakpoints_[e].push_back(edge_parameter(e, segment.at(zero)));
      }
    }
    std::sort(t.begin(), t.end());
    return t;
  }

  // Position of the piece from `from` to `to`. No height changes its sign there, but all may vanish
  // at a point (an arc that touches the edge), so the largest value decides.
  Position find_position(const PlanarCubic& segment, double from, double to, int& along) const {
    Position position = Position::Inside;
    for (int e = 0; e < 3; ++e) {
      double largest = 0;
      for (const double s : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const double h = height(e, segment.at(from + s * (to - from)));
        if (std::abs(h) > std::abs(largest)) largest = h;
      }
      if (largest < -kOnEdge) return Position::Outside;
      if (largest <= kOnEdge) {
        position = Position::AlongEdge;
        along = e;
      }
    }
    return position;
  }

  // Adds the pieces of an edge between its breakpoints that are inside of the loops.
  void add_edge(int e) {
    const Vec2 a = S_[e], d = S_[(e + 1) % 3] - a;
    std::vector<double>& breakpoints = breakpoints_[e];
    breakpoints.push_back(0);
    breakpoints.push_back(1);
    std::sort(breakpoints.begin(), breakpoints.end());
    for (size_t i = 0; i + 1 < breakpoints.size(); ++i) {
      const double from = std::clamp(breakpoints[i], 0.0, 1.0),
                   to = std::clamp(breakpoints[i + 1], 0.0, 1.0);
      if (to - from < 1e-15) continue;
      const double half = 0.5 * (from + to);
      if (!loops_.contains(beside_segments(e, half, a + half * d))) continue;
      const Vec2 p = a + from * d, q = a + to * d;
      pieces_.push_back({true, PlanarCubic::straight(p, q)});
    }
  }

  // A point of an edge, moved inwards if an arc lies along the edge there.
  Vec2 beside_segments(int e, double s, Vec2 point) const {
    const Vec2 centre = (S_[0] + S_[1] + S_[2]) / 3;
    for (const auto& [low, high] : covered_[e])
      if (low <= s && s <= high) {
        point += kInward * (centre - point);
        break;
      }
    return point;
  }

  const std::array<Vec2, 3>& S_;
  const DomainLoops& loops_;
  double twice_;
  std::array<std::vector<double>, 3> breakpoints_;                 // along each edge
  std::array<std::vector<std::pair<double, double>>, 3> covered_;  // by an arc along the edge
  std::vector<Piece> pieces_;
  bool touched_ = false;
};

// Triangles that an arc may intersect, by the bounding boxes of its pieces.
void collect(const TriangleLocator& locator, const PlanarCubic& segment, double part_size,
             int depth, std::vector<int>& found) {
  const Box2 box = bounding_box(segment.b);
  if (depth < 10 && box.sizes().maxCoeff() > part_size) {
    collect(locator, segment.part(0, 0.5), part_size, depth + 1, found);
    collect(locator, segment.part(0.5, 1), part_size, depth + 1, found);
    return;
  }
  const Vec2 margin = Vec2::Constant(1e-12 + 1e-9 * box.diagonal().norm());
  for (const int t : locator.near(box.min() - margin, box.max() + margin)) found.push_back(t);
}

// For each triangle that arcs may intersect, these arcs in ascending order.
std::map<int, std::vector<int>> find_segments_near(const ParametricMesh& mesh,
                                                   const DomainLoops& loops) {
  const TriangleLocator locator(mesh);
  const int n = mesh.triangle_count();
  double mesh_area = 0;
  for (int t = 0; t < n; ++t) mesh_area += mesh.shape(t).area;
  const double part_size = 2 * std::sqrt(mesh_area / n);
  std::map<int, std::vector<int>> segments_near;
  for (size_t a = 0; a < loops.segments().size(); ++a) {
    std::vector<int> found;
    collect(locator, loops.segments()[a], part_size, 0, found);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const int t : found) segments_near[t].push_back(static_cast<int>(a));
  }
  return segments_near;
}

// Connected triangles that no arc comes near lie on the same side, so one of them is tested for
// all.
std::vector<char> far_inside(const ParametricMesh& mesh, const DomainLoops& loops,
                             const std::vector<char>& near) {
  constexpr char unknown = 2;
  const int n = mesh.triangle_count();
  std::vector<char> inside(n, unknown);
  std::vector<int> waiting;
  for (int first = 0; first < n; ++first) {
    if (near[first] || inside[first] != unknown) continue;
    const Vec2 centroid = mesh.shape(first).point(Vec3::Constant(1.0 / 3));
    inside[first] = loops.contains(centroid) ? 1 : 0;
    waiting.push_back(first);
    while (!waiting.empty()) {
      const int t = waiting.back();
      waiting.pop_back();
      for (const int e : mesh.edges_of(t))
        for (const int other : mesh.edges()[e].triangle) {
          if (other < 0 || near[other] || inside[other] != unknown) continue;
          inside[other] = inside[t];
          waiting.push_back(other);
        }
    }
  }
  return inside;
}

// On a mesh that is periodic in u: the loops and their images one period to either side, which
// covers all unwrapped triangles.
DomainLoops with_periodic_images(const DomainLoops& loops, double period) {
  if (period == 0 || loops.loops().empty()) return loops;
  std::vector<DomainLoops::Loop> all;
  for (const double shift : {-period, 0.0, period})
    for (const DomainLoops::Loop& loop : loops.loops()) {
      DomainLoops::Loop image;
      for (const HermiteCurve& curve : loop) {
        Points dofs = curve.dofs();
        for (int i = 0; i < curve.node_count(); ++i) dofs(curve.mesh().position_dof(i), 0) += shift;
        image.emplace_back(curve.mesh(), std::move(dofs));
      }
      all.push_back(std::move(image));
    }
  return DomainLoops(std::move(all), loops.background());
}

}  // namespace

Trim::Trim(const ParametricMesh& mesh, DomainLoops domain_loops)
    : loops_(with_periodic_images(domain_loops, mesh.period())) {
  const int n = mesh.triangle_count();
  const std::map<int, std::vector<int>> segments_near = find_segments_near(mesh, loops_);
  std::vector<char> is_near(n, 0);
  for (const auto& [t, segments] : segments_near) is_near[t] = 1;
  const std::vector<char> inside = far_inside(mesh, loops_, is_near);

  side_.resize(n);
  area_fraction_.assign(n, 0);
  for (int t = 0; t < n; ++t) {
    const TriangleShape shape = mesh.shape(t);
    if (!is_near[t]) {
      side_[t] = inside[t] ? Side::Inside : Side::Outside;
      area_fraction_[t] = inside[t];
    } else {
      std::vector<PlanarCubic> segments;
      for (const int a : segments_near.at(t)) segments.push_back(loops_.segments()[a]);
      cut_triangle(t, shape, segments);
    }
    area_ += area_fraction_[t] * shape.area;
  }
  cones_of_.push_back(isize(cones_));
}

void Trim::cut_triangle(int t, const TriangleShape& shape,
                        const std::vector<PlanarCubic>& segments) {
  const Vec2 centroid = shape.point(Vec3::Constant(1.0 / 3));
  bool touched = false;
  std::vector<Cone> cones;
  double twice = 0;
  for (int s = 0; s < 3; ++s) {
    const std::array<Vec2, 3> S{shape.vertex[(s + 1) % 3], shape.vertex[(s + 2) % 3], centroid};
    const ClippedSubtriangle part(S, loops_, segments);
    const std::vector<Piece>& pieces = part.boundary();
    touched = touched || part.touched();
    if (pieces.empty()) continue;
    // If the apex is an end of an arc, the cone of that arc is a sliver and the others are
    // positive.
    const Vec2 apex = part.touched() ? pieces[0].side.b[0] : S[0];
    for (const Piece& p : pieces) {
      const double area = twice_area(apex, p.straight, p.side);
      if (area == 0) continue;
      twice += area;
      cones.push_back({s, apex, p.straight, p.side});
    }
  }
  // Arcs along the spokes pass through no sub-triangle.
  const double area_fraction = 0.5 * twice / shape.area;
  if (!touched && !(area_fraction > 1e-9 && area_fraction < 1 - 1e-9)) {
    side_[t] = loops_.contains(centroid) ? Side::Inside : Side::Outside;
    area_fraction_[t] = side_[t] == Side::Inside ? 1 : 0;
    return;
  }
  side_[t] = Side::Cut;
  area_fraction_[t] = area_fraction;
  cut_triangles_.push_back(t);
  cones_of_.push_back(isize(cones_));
  cones_.insert(cones_.end(), cones.begin(), cones.end());
  corners_.push_back(shape.vertex);
}

int Trim::find_cut(int triangle) const {
  const auto at = std::lower_bound(cut_triangles_.begin(), cut_triangles_.end(), triangle);
  if (at == cut_triangles_.end() || *at != triangle) return -1;
  return static_cast<int>(at - cut_triangles_.begin());
}

std::vector<Vec3> Trim::boundary_points(int triangle) const {
  const int c = find_cut(triangle);
  if (c < 0) return {};
  const TriangleShape shape(corners_[c][0], corners_[c][1], corners_[c][2]);
  std::vector<Vec3> L;
  for (int k = cones_of_[c]; k < cones_of_[c + 1]; ++k)
    for (const double t : {0.0, 0.5, 1.0})
      if (!cones_[k].straight) L.push_back(shape.barycentric(cones_[k].side.at(t)));
  return L;
}

TriangleRule Trim::rule(int triangle, int degree) const {
  const int c = find_cut(triangle);
  if (c < 0) {
    if (side_[triangle] == Side::Inside) return split_triangle_rule(degree);
    return {Points(0, 3), VecX(0)};
  }
  const TriangleShape shape(corners_[c][0], corners_[c][1], corners_[c][2]);
  std::vector<Vec3> L;
  std::vector<double> weights;
  const SegmentRule& along_radius = gauss((degree + 3) / 2);
  for (int k = cones_of_[c]; k < cones_of_[c + 1]; ++k) {
    const Cone& cone = cones_[k];
    const SegmentRule& along = gauss(cone.straight ? (degree + 2) / 2 : (3 * degree + 7) / 2);
    for (long i = 0; i < along.s.size(); ++i) {
      const Vec2 d = cone.side.at(along.s[i]) - cone.apex;
      const double jacobian = cross(d, cone.side.slope(along.s[i])) * along.weights[i] / shape.area;
      for (long j = 0; j < along_radius.s.size(); ++j) {
        const double r = along_radius.s[j];
        L.push_back(shape.barycentric(cone.apex + r * d));
        weights.push_back(along_radius.weights[j] * r * jacobian);
      }
    }
  }
  TriangleRule rule{Points(static_cast<long>(L.size()), 3), VecX(static_cast<long>(L.size()))};
  for (size_t i = 0; i < L.size(); ++i) {
    rule.L.row(static_cast<long>(i)) = L[i];
    rule.weights[static_cast<long>(i)] = weights[i];
  }
  return rule;
}

Trim Trim::concatenated(const std::vector<const Trim*>& trims,
                        const std::vector<const ParametricMesh*>& meshes) {
  Trim all;
  for (size_t m = 0; m < meshes.size(); ++m) {
    const auto first = isize(all.side_), first_cone = isize(all.cones_);
    const auto count = static_cast<size_t>(meshes[m]->triangle_count());
    if (!trims[m]) {
      all.side_.insert(all.side_.end(), count, Side::Inside);
      all.area_fraction_.insert(all.area_fraction_.end(), count, 1.0);
      for (int t = 0; t < meshes[m]->triangle_count(); ++t) all.area_ += meshes[m]->shape(t).area;
      continue;
    }
    const Trim& trim = *trims[m];
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(all.side_, trim.side_);
    append(all.area_fraction_, trim.area_fraction_);
    for (const int t : trim.cut_triangles_) all.cut_triangles_.push_back(first + t);
    for (size_t c = 0; c < trim.cut_triangles_.size(); ++c)
      all.cones_of_.push_back(first_cone + trim.cones_of_[c]);
    append(all.cones_, trim.cones_);
    append(all.corners_, trim.corners_);
    all.area_ += trim.area_;
  }
  all.cones_of_.push_back(isize(all.cones_));
  return all;
}

Trim Trim::restricted(const std::vector<int>& triangles) const {
  Trim part = *this;
  part.side_.clear();
  part.area_fraction_.clear();
  part.cut_triangles_.clear();
  part.cones_.clear();
  part.cones_of_.clear();
  part.corners_.clear();
  for (size_t i = 0; i < triangles.size(); ++i) {
    const int t = triangles[i];
    part.side_.push_back(side_[t]);
    part.area_fraction_.push_back(area_fraction_[t]);
    if (side_[t] != Side::Cut) continue;
    const auto c = static_cast<size_t>(
        std::lower_bound(cut_triangles_.begin(), cut_triangles_.end(), t) - cut_triangles_.begin());
    part.cut_triangles_.push_back(static_cast<int>(i));
    part.cones_of_.push_back(isize(part.cones_));
    part.cones_.insert(part.cones_.end(), cones_.begin() + cones_of_[c],
                       cones_.begin() + cones_of_[c + 1]);
    part.corners_.push_back(corners_[c]);
  }
  part.cones_of_.push_back(isize(part.cones_));
  part.area_ = area_;
  return part;
}

}  // namespace batten
