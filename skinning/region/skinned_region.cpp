// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/region/skinned_region.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/region/polygon_fit.h"

namespace batten {

HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve& curve = piece.kind == BoundarySegment::Kind::EdgeAligned
                                  ? region.edge_aligned.at(i).fitted
                                  : region.embedded.at(i).fitted;
  return piece.reversed ? curve.backwards() : curve;
}

HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line) {
  const Vec2 from = mesh.vertices()[aligned_line.vertices.front()],
             along = mesh.chain_vector(aligned_line.vertices), to = from + along,
             slope = along / (aligned_line.fitted.end() - aligned_line.fitted.start());
  Points x(2, 3), d(2, 3);
  x << from.x(), from.y(), 0, to.x(), to.y(), 0;
  d << slope.x(), slope.y(), 0, slope.x(), slope.y(), 0;
  return {{aligned_line.fitted.start(), aligned_line.fitted.end()}, x, d};
}

HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve pcurve =
      piece.kind == BoundarySegment::Kind::Embedded
          ? region.embedded.at(i).pcurve
          : edge_aligned_pcurve(region.surface.mesh(), region.edge_aligned.at(i));
  return piece.reversed ? pcurve.backwards() : pcurve;
}

DomainLoops boundary_loops(const SkinnedRegion& region) {
  std::vector<DomainLoops::Loop> loops;
  for (const auto& segments : region.boundary) {
    DomainLoops::Loop loop;
    for (const BoundarySegment& piece : segments) loop.push_back(boundary_pcurve(region, piece));
    loops.push_back(std::move(loop));
  }
  return DomainLoops(std::move(loops));
}

namespace {

// Updates a maximum; NaN counts as the largest value and is kept.
void update_max(double& largest, double value) {
  if (!(value <= largest) && !std::isnan(largest)) largest = value;
}

// The surface's own edge along an edge-aligned line, as a curve with that line's parameter.
HermiteCurve surface_edge(const Surface& surface, const EdgeAlignedLine& aligned_line) {
  const auto n = static_cast<long>(aligned_line.vertices.size());
  const ParametricMesh& mesh = surface.mesh();
  const Vec2 per_parameter = mesh.chain_vector(aligned_line.vertices) /
                             (aligned_line.parameters.back() - aligned_line.parameters.front());
  Points x(n, 3), d(n, 3);
  for (long i = 0; i < n; ++i) {
    const int v = aligned_line.vertices[i];
    x.row(i) = surface.dofs().row(surface.dof_map().vertex(v));
    d.row(i) = per_parameter.x() * surface.dofs().row(surface.dof_map().vertex(v, 1)) +
               per_parameter.y() * surface.dofs().row(surface.dof_map().vertex(v, 2));
  }
  return {aligned_line.parameters, x, d};
}

// A point of an edge, as a location in one of its two triangles.
Location on_edge(const ParametricMesh& mesh, int edge, int side, double fraction_from_low) {
  const auto& e = mesh.edges()[edge];
  const int t = e.triangle[side], i = e.local[side];
  const int low = mesh.edge_sign(t, i) > 0 ? (i + 1) % 3 : (i + 2) % 3;
  Location where{t, Vec3::Zero()};
  where.L[low] = 1 - fraction_from_low;
  where.L[3 - i - low] = fraction_from_low;
  return where;
}

// x_u × x_v at the same barycentric points in every triangle: one small matrix product per
// triangle.
class AreaVectors {
 public:
  AreaVectors(const Surface& surface, const std::vector<Vec3>& L)
      : surface_(surface), slopes_(12, 2 * static_cast<long>(L.size())) {
    for (size_t i = 0; i < L.size(); ++i)
      slopes_.middleCols<2>(2 * static_cast<long>(i)) =
          reference_functions(surface.kind(), L[i]).middleCols<2>(1);
  }
  /// Area vectors at all points of triangle t.
  const std::vector<Vec3>& at(int t) {
    const TriangleShape shape = surface_.mesh().shape(t);
    const Eigen::Matrix<double, 12, 3> q =
        C1Triangle(surface_.kind(), shape).pull_back(surface_.triangle_dofs(t));
    found_ = q.transpose().lazyProduct(slopes_);
    const double scale = DerivativeMap(shape).first.determinant();
    areas_.clear();
    for (long i = 0; i < found_.cols(); i += 2)
      areas_.push_back(scale * Vec3(found_.col(i)).cross(Vec3(found_.col(i + 1))));
    return areas_;
  }

 private:
  const Surface& surface_;
  Eigen::Matrix<double, 12, Eigen::Dynamic> slopes_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> found_;
  std::vector<Vec3> areas_;
};

// Number of samples along an element edge.
constexpr int kEdgeSamples = 6;

// Distances from the surface to the fitted line and to the input, and from the input to the
// surface.
void measure_aligned_line(const SkinnedRegion& region, const EdgeAlignedLine& aligned_line,
                          SkinQuality& q) {
  const Surface& surface = region.surface;
  const ParametricMesh& mesh = surface.mesh();
  const CurveDistance distance_to(*aligned_line.line.curve);
  for (size_t i = 0; i < aligned_line.edges.size(); ++i) {
    const bool from_low = mesh.edges()[aligned_line.edges[i]].low == aligned_line.vertices[i];
    for (int k = 0; k <= kEdgeSamples; ++k) {
      const double f = static_cast<double>(k) / kEdgeSamples;
      const Vec3 x =
          surface.position(on_edge(mesh, aligned_line.edges[i], 0, from_low ? f : 1 - f));
      const double u = aligned_line.parameters[i] +
                       f * (aligned_line.parameters[i + 1] - aligned_line.parameters[i]);
      update_max(q.max_line_residual, (x - aligned_line.fitted.evaluate(u)).norm() / region.size);
      update_max(q.max_line_deviation, distance_to(x));
    }
  }
  const HermiteCurve edge = surface_edge(surface, aligned_line);
  const InputCurve& input = *aligned_line.line.curve;
  const int count = std::max<int>(24, kEdgeSamples * isize(aligned_line.edges));
  for (int k = 0; k <= count; ++k) {
    const double t = input.start() + (input.end() - input.start()) * k / count;
    update_max(q.max_line_deviation, edge.closest_point(input.evaluate(t)).distance);
  }
}

// Symmetric distance: from the surface along the line to the input, and from the input to the
// surface's own curve.
void measure_embedded(const Surface& surface, const TriangleLocator& locator,
                      const EmbeddedLine& line, SkinQuality& q) {
  update_max(q.max_line_gap, line_gap(surface, line));
  if (!line.line.constrains_surface) return;
  const int count =
      std::max<int>({256, 2 * kEdgeSamples * isize(line.points), 4 * line.fitted.segment_count()});
  const auto on_surface = [&](double u) -> Vec3 {
    return surface.position(locator.locate(drop_z(line.pcurve.evaluate(u))));
  };
  const InputCurve& input = *line.line.curve;
  const CurveDistance distance_to(input);
  for (int k = 0; k <= count; ++k)
    update_max(q.max_line_deviation,
               distance_to(on_surface(line.pcurve.start() +
                                      (line.pcurve.end() - line.pcurve.start()) * k / count)));
  const HermiteCurve& fitted = line.fitted;
  for (int k = 0; k <= count; ++k) {
    const Vec3 p = input.evaluate(input.start() + (input.end() - input.start()) * k / count);
    // The surface's own curve is within the gap of the fitted one, so its closest point is searched
    // for around the foot point on the fitted curve.
    const auto foot_point = fitted.closest_point(p);
    const double search_radius = 0.5 * (fitted.end() - fitted.start()) / count;
    const auto apart = [&](double u) { return (on_surface(u) - p).norm(); };
    update_max(q.max_line_deviation,
               std::min({apart(foot_point.u), apart(foot_point.u - search_radius),
                         apart(foot_point.u + search_radius)}));
  }
}

// Normal jumps across edges, and Jacobians inside triangles and at vertices. All are computed from
// area vectors at three points per edge, at the quadrature points, and at the vertices.
class ElementMeasures {
 public:
  explicit ElementMeasures(const Surface& surface)
      : surface_(surface),
        mesh_(surface.mesh()),
        trim_(surface.trim().get()),
        first_side_(static_cast<size_t>(mesh_.edge_count())),
        at_vertex_(mesh_.vertex_count(), 0),
        vertex_inside_(mesh_.vertex_count(), 0) {}

  void measure(SkinQuality& q) {
    AreaVectors area_vectors(surface_, sample_points());
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
      poll_every<2048>(t);
      const std::vector<Vec3>& found = area_vectors.at(t);
      compare_sides(t, found, q);
      if (!trim_ || trim_->side(t) != Trim::Side::Outside) add_jacobians(t, found);
    }
    std::vector<double> sorted = jacobians_;
    const auto middle = sorted.begin() + static_cast<long>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double median = *middle;
    q.min_jacobian_ratio = *std::min_element(jacobians_.begin(), jacobians_.end()) / median;
    for (int v = 0; v < mesh_.vertex_count(); ++v)
      if (vertex_inside_[v] && !(at_vertex_[v] > 1e-6 * median)) ++q.singular_nodes;
  }

 private:
  std::vector<Vec3> sample_points() const {
    std::vector<Vec3> points;
    for (int i = 0; i < 3; ++i)
      for (const double f : {0.1, 0.5, 0.9}) {
        Vec3 L = Vec3::Zero();
        L[(i + 1) % 3] = 1 - f;
        L[(i + 2) % 3] = f;
        points.push_back(L);
      }
    for (long p = 0; p < rule_.weights.size(); ++p) points.push_back(rule_.L.row(p).transpose());
    for (int i = 0; i < 3; ++i) points.push_back(Vec3::Unit(i));
    return points;
  }

  void compare_sides(int t, const std::vector<Vec3>& found, SkinQuality& q) {
    for (int i = 0; i < 3; ++i) {
      const int e = mesh_.edges_of(t)[i];
      const auto& edge = mesh_.edges()[e];
      if (edge.boundary()) continue;
      for (size_t f = 0; f < 3; ++f) {
        const size_t from_low = mesh_.edge_sign(t, i) > 0 ? f : 2 - f;
        const Vec3& area = found[3 * static_cast<size_t>(i) + f];
        Vec3& other = first_side_[e][from_low];
        if (edge.triangle[0] == t)
          other = area;
        else
          update_max(q.max_normal_jump_deg, degrees_between(other, area));
      }
    }
  }

  // Signed Jacobians, relative to the mean normal of their triangle.
  void add_jacobians(int t, const std::vector<Vec3>& found) {
    const bool cut = trim_ && trim_->side(t) == Trim::Side::Cut;
    areas_.clear();
    Vec3 mean = Vec3::Zero();
    if (cut) {
      const TriangleRule rule = trim_->rule(t, 2);
      for (long p = 0; p < rule.weights.size(); ++p) {
        const Vec3 area = surface_.area_vector({t, rule.L.row(p).transpose()});
        mean += rule.weights[p] * area;
        // Points with negative weights (from the quadrature of cut cells) lie outside.
        if (rule.weights[p] > 0) areas_.push_back(area);
      }
    } else {
      for (long p = 0; p < rule_.weights.size(); ++p) {
        areas_.push_back(found[kEdgePoints + static_cast<size_t>(p)]);
        mean += rule_.weights[p] * areas_.back();
      }
    }
    const size_t corners = kEdgePoints + static_cast<size_t>(rule_.weights.size());
    for (int i = 0; i < 3; ++i) {
      const int v = mesh_.triangles()[t][i];
      if (cut && !trim_->loops().contains(mesh_.vertices()[v])) continue;
      areas_.push_back(found[corners + static_cast<size_t>(i)]);
      at_vertex_[v] = areas_.back().norm();
      vertex_inside_[v] = 1;
    }
    for (const Vec3& a : areas_) jacobians_.push_back(std::copysign(a.norm(), a.dot(mean)));
  }

  static constexpr size_t kEdgePoints = 9;
  const Surface& surface_;
  const ParametricMesh& mesh_;
  const Trim* trim_;
  const TriangleRule rule_ = split_triangle_rule(2);
  std::vector<std::array<Vec3, 3>> first_side_;  // by edge
  std::vector<double> jacobians_, at_vertex_;
  std::vector<char> vertex_inside_;
  std::vector<Vec3> areas_;  // of the current triangle
};

}  // namespace

double line_gap(const SkinnedRegion& region) {
  double gap = 0;
  for (const EmbeddedLine& line : region.embedded)
    gap = std::max(gap, line_gap(region.surface, line));
  return gap;
}

double max_line_gap(const std::vector<SkinnedRegion>& regions) {
  double gap = 0;
  for (const SkinnedRegion& region : regions) gap = std::max(gap, line_gap(region));
  return gap;
}

void mark_gaps(const SkinnedRegion& region, double target, char* marks) {
  const Surface& surface = region.surface;
  const TriangleLocator locator(surface.mesh());
  constexpr int samples = 20;
  for (const EmbeddedLine& line : region.embedded) {
    // Ends are included: collocation points may have been left out there, or the line may be
    // closed.
    std::vector<double> ends = line.points;
    ends.insert(ends.begin(), line.pcurve.start());
    ends.push_back(line.pcurve.end());
    for (size_t i = 0; i + 1 < ends.size(); ++i) {
      const double from = ends[i], to = ends[i + 1];
      std::vector<int> triangles;
      double gap = 0;
      for (int k = 0; k <= samples; ++k) {
        const double t = from + (to - from) * k / samples;
        const Vec3 uv = line.pcurve.evaluate(t);
        const Location where = locator.locate({uv.x(), uv.y()});
        gap = std::max(gap, (surface.position(where) - line.fitted.evaluate(t)).norm());
        triangles.push_back(where.triangle);
      }
      if (gap <= target) continue;
      for (const int t : triangles) marks[t] = 1;
    }
  }
}

SkinQuality measure(const Surface& surface) {
  SkinQuality q;
  ElementMeasures(surface).measure(q);
  q.area = surface.area();
  return q;
}

SkinQuality measure(const SkinnedRegion& region) {
  const Surface& surface = region.surface;
  SkinQuality q = measure(surface);
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
    measure_aligned_line(region, aligned_line, q);
  const TriangleLocator locator(surface.mesh());
  for (const EmbeddedLine& line : region.embedded) measure_embedded(surface, locator, line, q);
  const Distortion d = distortion(surface);
  q.max_shear = d.max_shear;
  q.rms_strain = d.rms;
  return q;
}

}  // namespace batten
