// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/domains/annulus_domain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/outline.h"

namespace batten {
namespace {

// Sum of squared distances between the points of circle A and those of circle B, which begins at k.
double sum_of_squared_distances(const std::vector<Vec3>& a, const std::vector<Vec3>& b, int k,
                                int direction) {
  const int n = isize(a);
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += (a[i] - b[(k + direction * i + n) % n]).squaredNorm();
  return sum;
}

class AnnulusBuilder {
 public:
  AnnulusBuilder(const Outline& a, const Outline& b, const DomainInput& task)
      : task_(task), circles_{BoundaryCircle(a), BoundaryCircle(b)} {}

  RegionGeometry build() {
    for (const BoundaryCircle& circle : circles_) require_smooth(circle.outline);
    match();
    for (BoundaryCircle& circle : circles_) fit(circle);
    columns();
    RegionGeometry geometry;
    geometry.mesh = mesh();
    geometry.boundary.resize(2);
    for (const int r : {0, 1})
      for (size_t i = 0; i < circles_[r].spans.size(); ++i) {
        const int index = isize(geometry.edge_aligned);
        const bool flipped = circles_[r].outline.segments[i].flipped;
        geometry.boundary[r].push_back(
            {BoundarySegment::Kind::EdgeAligned, index, flipped != (r == 1)});
        geometry.edge_aligned.push_back(aligned_line(*geometry.mesh, r, i));
      }
    // Circle B runs against u; its first line stays first.
    std::reverse(geometry.boundary[1].begin() + 1, geometry.boundary[1].end());
    return geometry;
  }

 private:
  void require_smooth(const Outline& circle) const {
    if (circle.corners.empty()) return;
    const auto& piece = circle.segments[circle.corners[0]];
    throw InputError(
        "the boundaries of an annular face must be smooth, found a corner of more than " +
        format_number(task_.options.corner_angle) + " degrees at the start of curve '" +
        piece.segment.name + "', " + format_point(piece.start) +
        "; increase corner_angle, or divide the face with curves between its boundaries");
  }

  // Chooses the direction and the start point of circle B relative to circle A.
  void match() {
    constexpr int n = 256;
    std::vector<Vec3> a(n), b(n);
    for (int i = 0; i < n; ++i) {
      a[i] = circles_[0].point(static_cast<double>(i) / n).x;
      b[i] = circles_[1].point(static_cast<double>(i) / n).x;
    }
    const int direction = circles_have_same_direction(a, b) ? 1 : -1;
    double least = std::numeric_limits<double>::infinity();
    int start = 0;
    for (int k = 0; k < n; ++k) {
      const double sum = sum_of_squared_distances(a, b, k, direction);
      // Ties go to the first candidate.
      if (sum < least - 1e-9 * n * task_.size * task_.size) {
        least = sum;
        start = k;
      }
    }
    if (direction < 0) {
      circles_[1] = BoundaryCircle(reversed(circles_[1].outline));
      start = (n - start) % n;
    }
    // Between samples: the zero of the sum's derivative, by bisection.
    const auto slope = [&](double phase) {
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        const auto span = circles_[1].point(phase + static_cast<double>(i) / n);
        sum += (span.x - a[i]).dot(span.tangent);
      }
      return sum;
    };
    double low = (start - 1.0) / n, high = (start + 1.0) / n;
    double phase = static_cast<double>(start) / n;
    if (slope(low) < 0 && slope(high) > 0) {
      for (int step = 0; step < 48; ++step) {
        phase = 0.5 * (low + high);
        (slope(phase) < 0 ? low : high) = phase;
      }
    }
    phase = fractional_part(round_to_grid(phase));

    double distance = 0;
    for (int i = 0; i < n; ++i)
      distance += (circles_[1].point(phase + static_cast<double>(i) / n).x - a[i]).norm() / n;
    U_ = round_to_grid(0.5 * (circles_[0].length + circles_[1].length) / task_.size);
    V_ = round_to_grid(distance / task_.size);
    if (!(V_ > 1e-6 * U_))
      throw InputError("the boundaries of an annular face, with curves '" +
                       circles_[0].outline.segments[0].segment.name + "' and '" +
                       circles_[1].outline.segments[0].segment.name + "', coincide");
    if (circles_[1].is_single_line() && !circles_[1].prescribed()) {
      circles_[1] = circles_[1].with_seam_at(phase);
    } else if (circles_[0].is_single_line() && !circles_[0].prescribed()) {
      circles_[0] = circles_[0].with_seam_at(-phase);
    } else {
      // The seam of a B-spline face starts at phase 0: it meets a node or keeps away from it.
      constexpr double close = 2e-3;
      for (const auto& span : circles_[1].spans)
        if (std::abs(std::remainder(span.from - phase, 1.0)) < close) phase = span.from;
      for (auto& span : circles_[1].spans) span.from = fractional_part(span.from - phase);
    }
  }

  // Uses prescribed curves unchanged, so that the adjacent regions carry the same curves.
  static void take_prescribed(BoundaryCircle& circle) {
    for (size_t i = 0; i < circle.spans.size(); ++i) {
      const auto& piece = circle.outline.segments[i];
      const HermiteCurve along = piece.segment.prescribed_along(piece.flipped);
      circle.spans[i].fitted = circle.is_single_line() ? as_closed_curve(along) : along;
    }
  }

  void fit(BoundaryCircle& circle) const {
    if (circle.prescribed()) return take_prescribed(circle);
    FitOptions fit;
    fit.tolerance = task_.options.tolerance;
    fit.corner_angle = 180;
    fit.fixed_parameters = true;
    fit.bisection_only = true;
    fit.closed = circle.is_single_line();
    const size_t n = circle.spans.size();
    for (size_t i = 0; i < n; ++i) {
      if (n > 1) {
        const LoopVertex start = loop_vertex_at(circle.outline, i),
                         end = loop_vertex_at(circle.outline, (i + 1) % n);
        fit.start = {start.position, start.outgoing};
        fit.end = {end.position, end.incoming};
      }
      const SmoothSegment& line = circle.outline.segments[i].segment;
      auto& span = circle.spans[i];
      span.fitted = fit_curve(line.name, line.curve, fit);
      // Scaled by the rounding factor of the length fraction, so that the speed is continuous from
      // line to line.
      std::vector<double> u = span.fitted.parameters();
      const double segment = span.length_fraction * circle.length / u.back();
      for (double& x : u) x *= segment;
      span.fitted = {CurveMesh(std::move(u), circle.is_single_line()), span.fitted.dofs()};
    }
  }

  // Nodes of a circle, or its prescribed vertices, as fractions of the circle.
  static std::vector<double> nodes(const BoundaryCircle& circle) {
    std::vector<double> all;
    for (size_t i = 0; i < circle.spans.size(); ++i) {
      const BoundaryCircle::Span& p = circle.spans[i];
      const auto& piece = circle.outline.segments[i];
      const double end = p.fitted.end();
      if (circle.prescribed()) {
        for (const double vertex : piece.segment.prescribed->vertices)
          if (const double t = piece.flipped ? end - vertex : vertex; t < end)
            all.push_back(fractional_part(p.from + p.length_fraction * t / end));
      } else {
        for (int k = 0; k < p.fitted.segment_count(); ++k)
          all.push_back(fractional_part(
              p.from + p.length_fraction * round_to_grid(p.fitted.parameters()[k] / end)));
      }
    }
    return all;
  }

  // A column of the mesh: its fractions on both circles, which may exceed 1.
  struct Column {
    double at[2];
  };

  // A node on one circle, and the node of the other circle in the same column.
  struct Node {
    double at;
    int circle;
    int partner;  // index in the list of all nodes; -1: none
  };

  // Width of columns as a fraction of the circle: near-square cells, at least eight around.
  double column_width() const {
    const double h = std::min({task_.options.edge_length / task_.size, 2 * V_, U_ / 8}) / U_;
    const double expected = 2 * U_ * V_ * task_.size * task_.size /
                            (task_.options.edge_length * task_.options.edge_length);
    require_mesh_size(std::max(expected, 2 / h), task_.options.edge_length, task_.size,
                      "an annular face");
    return h;
  }

  // Collects the nodes of both circles. Neighbours on different circles are paired to share a
  // column: first those that coincide, then those within half a column.
  std::vector<Node> paired_nodes(double h) const {
    std::vector<Node> found;
    for (int r = 0; r < 2; ++r)
      for (const double f : nodes(circles_[r])) found.push_back({f, r, -1});
    std::sort(found.begin(), found.end(), [](const Node& a, const Node& b) {
      return a.at != b.at ? a.at < b.at : a.circle < b.circle;
    });
    const int n = isize(found);
    constexpr double coincide = 1e-8;
    for (const double reach : {coincide, 0.5 * h})
      for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        Node &a = found[i], &b = found[j];
        if (a.circle == b.circle || a.partner >= 0 || b.partner >= 0) continue;
        if (fractional_part(b.at - a.at) > reach) continue;
        a.partner = j;
        b.partner = i;
      }
    return found;
  }

  // Columns that end on nodes of both circles; the first is repeated at the end.
  static std::vector<Column> shared_columns(const std::vector<Node>& found) {
    std::vector<Column> shared;
    for (const Node& node : found)
      if (node.circle == 0 && node.partner >= 0) {
        const double other = found[node.partner].at;
        shared.push_back({{node.at, node.at + std::remainder(other - node.at, 1.0)}});
      }
    if (shared.empty()) shared.push_back({{found[0].at, found[0].at}});
    shared.push_back({{shared[0].at[0] + 1, shared[0].at[1] + 1}});
    return shared;
  }

  void columns() {
    const double h = column_width();
    const std::vector<Node> found = paired_nodes(h);
    const std::vector<Column> shared = shared_columns(found);
    // Between two shared columns, a node of one circle gets the other end of its column by linear
    // interpolation.
    for (size_t k = 0; k + 1 < shared.size(); ++k) {
      const Column &from = shared[k], &to = shared[k + 1];
      const auto between = [&](double t) {
        return Column{
            {from.at[0] + t * (to.at[0] - from.at[0]), from.at[1] + t * (to.at[1] - from.at[1])}};
      };
      std::vector<double> spans = {0, 1};
      for (const Node& node : found) {
        if (node.partner >= 0) continue;
        const int r = node.circle;
        const double t = fractional_part(node.at - from.at[r]) / (to.at[r] - from.at[r]);
        if (t > 0 && t < 1) spans.push_back(t);
      }
      std::sort(spans.begin(), spans.end());
      spans.erase(std::unique(spans.begin(), spans.end()), spans.end());
      for (size_t p = 0; p + 1 < spans.size(); ++p) {
        const double width =
            (spans[p + 1] - spans[p]) * std::max(to.at[0] - from.at[0], to.at[1] - from.at[1]);
        const int cuts = std::max(1, static_cast<int>(std::ceil(width / h - 0.2)));
        for (int c = 0; c < cuts; ++c)
          columns_.push_back(between(spans[p] + (spans[p + 1] - spans[p]) * c / cuts));
      }
    }
  }

  std::shared_ptr<const ParametricMesh> mesh() const {
    const int n = isize(columns_);
    const int rows =
        std::max(1, static_cast<int>(std::lround(V_ * task_.size / task_.options.edge_length)));
    std::vector<Vec2> vertices;
    for (int j = 0; j <= rows; ++j)
      for (const Column& c : columns_) {
        const double s = static_cast<double>(j) / rows;
        const double f = fractional_part((1 - s) * c.at[0] + s * c.at[1]);
        vertices.emplace_back(f * U_ < U_ ? f * U_ : 0, j == rows ? V_ : s * V_);
      }
    std::vector<ParametricMesh::Triangle> triangles;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * n + i, b = j * n + (i + 1) % n, c = a + n, d = b + n;
        if ((i + j) % 2) {
          triangles.push_back({a, b, c});
          triangles.push_back({b, d, c});
        } else {
          triangles.push_back({a, b, d});
          triangles.push_back({a, d, c});
        }
      }
    return std::make_shared<ParametricMesh>(std::move(vertices), std::move(triangles), U_);
  }

  EdgeAlignedLine aligned_line(const ParametricMesh& mesh, int r, size_t index) const {
    const auto& line = circles_[r].outline.segments[index];
    const BoundaryCircle::Span& p = circles_[r].spans[index];
    const int n = isize(columns_);
    const int row = r == 0 ? 0 : mesh.vertex_count() - n;
    // The column at a fraction of the circle.
    const auto column_at = [&](double fraction) {
      int best = 0;
      for (int i = 1; i < n; ++i)
        if (std::abs(std::remainder(columns_[i].at[r] - fraction, 1.0)) <
            std::abs(std::remainder(columns_[best].at[r] - fraction, 1.0)))
          best = i;
      return best;
    };
    EdgeAlignedLine aligned_line;
    aligned_line.line = {line.segment.name,
                         line.flipped ? reversed(line.segment.curve) : line.segment.curve,
                         line.segment.role};
    aligned_line.fitted = line.flipped ? p.fitted.backwards() : p.fitted;
    const int first = column_at(p.from), last = column_at(p.from + p.length_fraction);
    const int count = last > first ? last - first : last - first + n;
    for (int k = 0; k <= count; ++k) {
      const int i = (first + k) % n;
      aligned_line.vertices.push_back(row + i);
      const double f = k == 0 ? 0
                       : k == count
                           ? 1
                           : fractional_part(columns_[i].at[r] - p.from) / p.length_fraction;
      aligned_line.parameters.push_back((line.flipped ? 1 - f : f) * p.fitted.end());
    }
    if (line.flipped) {
      std::reverse(aligned_line.vertices.begin(), aligned_line.vertices.end());
      std::reverse(aligned_line.parameters.begin(), aligned_line.parameters.end());
    }
    for (size_t k = 0; k + 1 < aligned_line.vertices.size(); ++k)
      aligned_line.edges.push_back(
          mesh.edge_between(aligned_line.vertices[k], aligned_line.vertices[k + 1]));
    return aligned_line;
  }

  const DomainInput& task_;
  BoundaryCircle circles_[2];
  double U_ = 0, V_ = 0;
  std::vector<Column> columns_;
};

}  // namespace

bool circles_have_same_direction(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const auto n = static_cast<double>(a.size());
  const auto middle = [n](const std::vector<Vec3>& points) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points) sum += p / n;
    return sum;
  };
  const auto area = [](const std::vector<Vec3>& p, const Vec3& about) {
    Vec3 sum = Vec3::Zero();
    for (size_t i = 0; i < p.size(); ++i)
      sum += (p[i] - about).cross(p[(i + 1) % p.size()] - about);
    return sum;
  };
  const Vec3 ma = middle(a), mb = middle(b), axis = mb - ma, na = area(a, ma), nb = area(b, mb);
  constexpr double clear = 0.2;
  const double sa = na.dot(axis), sb = nb.dot(axis);
  if (std::abs(sa) > clear * na.norm() * axis.norm() &&
      std::abs(sb) > clear * nb.norm() * axis.norm())
    return sa * sb > 0;
  const auto least = [&](int direction) {
    double sum = std::numeric_limits<double>::infinity();
    for (int k = 0; k < isize(a); ++k)
      sum = std::min(sum, sum_of_squared_distances(a, b, k, direction));
    return sum;
  };
  const double alike = least(1), against = least(-1);
  constexpr double tie = 1e-6;
  if (std::abs(alike - against) < tie * (alike + against)) return na.dot(nb) >= 0;
  return alike < against;
}

RegionGeometry make_annulus_geometry(const Outline& a, const Outline& b, const DomainInput& task) {
  return AnnulusBuilder(a, b, task).build();
}

// Inner lines of annular domains: pcurves that continue across the seam.

namespace {

// The same closed curve, opened at its start.
HermiteCurve cut_open(const HermiteCurve& closed) {
  const int n = closed.segment_count();
  Points x(n + 1, 3), slope(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    x.row(i) = closed.position(i % n);
    slope.row(i) = closed.slope_out(i % n);
  }
  return {closed.parameters(), x, slope};
}

// Tracks closest points along a curve. u continues across the seam instead of jumping by the
// period.
class ClosestPointTracker {
 public:
  ClosestPointTracker(const Surface& surface, const SurfaceProjector& projector,
                      const Location& start)
      : surface_(surface), projector_(projector), where_(start), uv_(uv_of(start)) {}

  Vec2 to(const Vec3& x) {
    p_ = x;
    where_ = projector_.nearest(x, where_).where;
    uv_ = surface_.mesh().image_near(uv_of(where_), uv_);
    return uv_;
  }
  Vec3 foot_point() const { return surface_.position(where_); }
  // The slope in (u, v) of the closest points of a curve with this `slope` at the last point. If
  // `speed` is given, the result is scaled to that speed on the surface. Off the surface, closest
  // points move faster or slower than the curve: J'J du + (x - p)·(x_uu …) du = J' dp.
  Vec2 pull(const Vec3& slope, std::optional<double> speed = {}) const {
    const SurfaceJet jet = surface_.jet(where_);
    Eigen::Matrix<double, 3, 2> J;
    J << jet.x_u, jet.x_v;
    const Vec3 off = jet.x - p_;
    const Mat2 G = J.transpose() * J;
    Mat2 H;
    H << jet.x_uu.dot(off), jet.x_uv.dot(off), jet.x_uv.dot(off), jet.x_vv.dot(off);
    H += G;
    constexpr double far = 0.1;  // near a centre of curvature the closest point is ill-conditioned
    const bool near = H(0, 0) > 0 && H.determinant() > far * G.determinant();
    const Vec2 d = (near ? H : G).ldlt().solve(J.transpose() * slope);
    return speed ? Vec2(*speed / std::max((J * d).norm(), 1e-300) * d) : d;
  }

 private:
  Vec2 uv_of(const Location& at) const { return surface_.mesh().shape(at.triangle).point(at.L); }
  const Surface& surface_;
  const SurfaceProjector& projector_;
  Location where_;
  Vec2 uv_;
  Vec3 p_ = Vec3::Zero();
};

// Samples of a curve and of its closest points: parameters and cumulative arc lengths
// (`path_length` on the surface, `length` of the curve).
struct Samples {
  std::vector<double> t, path_length, length;

  // The parameter at which the path on the surface has this length; periodic for closed lines.
  double at(double target, bool closed) const {
    const double span = t.back() - t.front();
    const double periods = closed ? std::floor(target / path_length.back()) : 0;
    target -= periods * path_length.back();
    const auto above = std::upper_bound(path_length.begin(), path_length.end(), target);
    const auto k = static_cast<size_t>(std::clamp<long>(above - path_length.begin(), 1,
                                                        static_cast<long>(path_length.size()) - 1));
    const double part = std::clamp(
        (target - path_length[k - 1]) / std::max(path_length[k] - path_length[k - 1], 1e-300), 0.0,
        1.0);
    return t[k - 1] + part * (t[k] - t[k - 1]) + periods * span;
  }
  // Mean of the path length minus its value for proportional spacing. Closed lines are shifted by
  // it, so that the result does not depend on where they begin.
  double offset() const {
    double sum = 0;
    for (size_t k = 1; k < t.size(); ++k) {
      const double scale = path_length.back() / length.back();
      sum += 0.5 * (length[k] - length[k - 1]) *
             (path_length[k] + path_length[k - 1] - scale * (length[k] + length[k - 1]));
    }
    return sum / length.back();
  }
};

// For each node of the pcurve, the curve parameter whose closest point it gets. That is the node's
// own parameter. With `evenly` it is the parameter at which the path on the surface has the node's
// fraction of the curve's length.
std::vector<double> source_parameters(const std::vector<double>& nodes, const Samples& s,
                                      bool closed, bool evenly) {
  if (!evenly || !(s.path_length.back() > 0)) return nodes;
  std::vector<double> from;
  const size_t each = (s.t.size() - 1) / (nodes.size() - 1);
  const double offset = closed ? s.offset() : 0;
  for (size_t i = 0; i < nodes.size(); ++i)
    from.push_back(
        s.at(offset + s.length[each * i] / s.length.back() * s.path_length.back(), closed));
  if (closed) {
    from.back() = from.front() + nodes.back() - nodes.front();
  } else {
    from.front() = nodes.front();
    from.back() = nodes.back();
  }
  return from;
}

// Replaces the line's pcurve by one that may cross the seam. Parameters of its nodes and its start
// point stay as in `line.pcurve`. A closed line that runs around the annulus has no closed pcurve:
// both curves are cut open.
void embed_across_seam(EmbeddedLine& line, const Surface& surface,
                       const SurfaceProjector& projector, const TriangleLocator& locator,
                       bool evenly) {
  const ParametricMesh& mesh = surface.mesh();
  const HermiteCurve curve = line.fitted;
  const std::vector<double> nodes = line.pcurve.parameters();
  const Location start = locator.locate(drop_z(line.pcurve.position(0)));
  constexpr int each = 16;  // samples per segment
  Samples samples{{nodes[0]}, {0}, {0}};
  ClosestPointTracker tracker(surface, projector, start);
  Vec3 x = curve.evaluate(nodes[0]);
  const Vec2 first = tracker.to(x);
  Vec2 last = first;
  Vec3 foot_point = tracker.foot_point();
  for (size_t i = 0; i + 1 < nodes.size(); ++i)
    for (int k = 1; k <= each; ++k) {
      samples.t.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / each);
      const Vec3 next = curve.evaluate(samples.t.back());
      last = tracker.to(next);
      samples.path_length.push_back(samples.path_length.back() +
                                    (tracker.foot_point() - foot_point).norm());
      samples.length.push_back(samples.length.back() + (next - x).norm());
      x = next;
      foot_point = tracker.foot_point();
    }
  const double around = std::round((last.x() - first.x()) / mesh.period());
  if (curve.closed() && around != 0) line.fitted = cut_open(curve);

  const CurveMesh pcurve(nodes, line.fitted.closed());
  const std::vector<double> from = source_parameters(nodes, samples, curve.closed(), evenly);
  const double span = curve.end() - curve.start(),
               scale = samples.path_length.back() / samples.length.back();
  Points dofs = Points::Zero(pcurve.dof_count(), 3);
  ClosestPointTracker again(surface, projector, start);
  double here = nodes[0], shift = 0;
  for (int i = 0; i < pcurve.node_count(); ++i) {
    // Small steps, because a long one might jump to another part of the surface.
    const double to = from[i], before = here;
    const double step = span / static_cast<double>(samples.t.size() - 1);
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to - before) / step)));
    Vec2 c;
    for (int k = 1; k <= steps; ++k) {
      here = before + (to - before) * k / steps;
      c = again.to(curve.evaluate(here));
    }
    const Vec3 slope = curve.evaluate(nodes[i], 1);
    const Vec2 d =
        evenly ? again.pull(curve.evaluate(to, 1), scale * slope.norm()) : again.pull(slope);
    // Shifted by whole periods, so that the line begins in [0, U).
    if (i == 0) shift = mesh.wrapped(c).x() - c.x();
    dofs.row(pcurve.position_dof(i)) << round_to_grid(c.x() + shift), round_to_grid(c.y()), 0;
    dofs.row(pcurve.slope_out(i)) = round_slope_to_grid({d.x(), d.y(), 0}, span);
  }
  if (curve.closed() && around != 0) {
    // It ends at its start point, one period further.
    const int end = pcurve.node_count() - 1;
    dofs.row(pcurve.position_dof(end)) = dofs.row(pcurve.position_dof(0));
    dofs(pcurve.position_dof(end), 0) += around * mesh.period();
    dofs.row(pcurve.slope_out(end)) = dofs.row(pcurve.slope_out(0));
  }
  line.pcurve = {pcurve, std::move(dofs)};
}

// Embeds a hole. A hole that does not run around the annulus can be embedded as on any domain,
// after the seam has been moved to the opposite side.
void embed_hole(const Outline& hole, const Surface& surface, const SurfaceProjector& projector,
                const DomainInput& task, RegionGeometry& geometry) {
  const ParametricMesh& mesh = surface.mesh();
  const auto uv_of = [&](const Vec3& p) {
    const Location at = projector.nearest(p).where;
    return mesh.shape(at.triangle).point(at.L);
  };
  // Range of u that the hole covers.
  Vec2 uv = uv_of(hole.segments[0].start);
  double low = uv.x(), high = low;
  constexpr int samples = 32;
  for (const Outline::OrientedSegment& piece : hole.segments) {
    const InputCurve& c = *piece.segment.curve;
    for (int k = 0; k <= samples; ++k) {
      uv = mesh.image_near(uv_of(c.evaluate(c.start() + (c.end() - c.start()) * k / samples)), uv);
      low = std::min(low, uv.x());
      high = std::max(high, uv.x());
    }
  }
  if (!(high - low < 0.9 * mesh.period()))
    throw InputError("the hole with curve '" + hole.segments[0].segment.name +
                     "' runs around the annular face and would divide it; boundaries of annular "
                     "faces have role = \"outline\"");
  const double u_shift = round_to_grid(0.5 * (mesh.period() - low - high));
  std::vector<Vec2> vertices = mesh.vertices();
  for (Vec2& p : vertices) p = mesh.wrapped({p.x() + u_shift, p.y()});
  const Surface shifted_surface(
      std::make_shared<ParametricMesh>(std::move(vertices), mesh.triangles(), mesh.period()),
      surface.kind(), surface.dofs());
  const size_t first = geometry.embedded.size();
  embed_on_surface(shifted_surface, {hole}, {}, task, geometry);
  const double begin = geometry.embedded[first].pcurve.position(0).x() - u_shift,
               back = mesh.wrapped({begin, 0}).x() - begin - u_shift;
  for (size_t i = first; i < geometry.embedded.size(); ++i) {
    HermiteCurve& pcurve = geometry.embedded[i].pcurve;
    Points dofs = pcurve.dofs();
    for (int n = 0; n < pcurve.node_count(); ++n) dofs(pcurve.mesh().position_dof(n), 0) += back;
    pcurve = {pcurve.mesh(), std::move(dofs)};
  }
}

}  // namespace

void embed_on_annulus(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry) {
  for (const SmoothSegment& line : inner)
    if (line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
      throw InputError("curve '" + line.name +
                       "' has alignment = \"aligned\", but inner curves of annular faces are "
                       "always embedded");
  const SurfaceProjector projector(surface);
  for (const Outline& hole : holes) embed_hole(hole, surface, projector, task, geometry);
  const size_t before = geometry.embedded.size();
  // Fits the lines. The pcurves are replaced below, because they may be wrong across the seam.
  embed_on_surface(surface, {}, inner, task, geometry);
  const TriangleLocator locator(surface.mesh());
  for (size_t i = before; i < geometry.embedded.size(); ++i) {
    // Lines that cross others keep the plain closest points, so that they meet in the domain too.
    EmbeddedLine& line = geometry.embedded[i];
    const double near = 10 * task.gap_tolerance;
    bool reparametrise = true;
    for (size_t j = 0; j < geometry.embedded.size() && reparametrise; ++j) {
      const InputCurve &a = *line.line.curve, &b = *geometry.embedded[j].line.curve;
      std::vector<Vec3> ends;
      for (const double s : {a.start(), a.end()})
        for (const double t : {b.start(), b.end()})
          if ((a.evaluate(s) - b.evaluate(t)).norm() <= near) ends.push_back(a.evaluate(s));
      reparametrise = j == i || !BoxedCurve(a).crossing(BoxedCurve(b), near, ends, 20 * near).found;
    }
    embed_across_seam(line, surface, projector, locator, reparametrise);
  }
}

// Annular surfaces through sections.

namespace {

constexpr int kCircleSamples = 256;  // around a section
using SectionSamples = std::vector<Vec3>;

double wrapped_index(double s) { return fractional_part(s) * kCircleSamples; }

Vec3 at(const SectionSamples& section, double s) {
  const double x = wrapped_index(s);
  const int i = std::min(static_cast<int>(x), kCircleSamples - 1);
  const double f = x - i;
  return (1 - f) * section[static_cast<size_t>(i)] +
         f * section[static_cast<size_t>((i + 1) % kCircleSamples)];
}

// A boundary circle sampled at equal steps of u.
SectionSamples circle_samples(const RegionGeometry& ring, size_t loop) {
  const ParametricMesh& mesh = *ring.mesh;
  SectionSamples section(kCircleSamples, Vec3::Zero());
  for (const BoundarySegment& piece : ring.boundary[loop]) {
    const EdgeAlignedLine& aligned_line = ring.edge_aligned[static_cast<size_t>(piece.index)];
    const HermiteCurve pcurve = edge_aligned_pcurve(mesh, aligned_line);
    const double from = pcurve.evaluate(pcurve.start()).x(),
                 to = from + (pcurve.position(pcurve.node_count() - 1) - pcurve.position(0)).x();
    const double span = std::abs(to - from) > 0 ? to - from : mesh.period();
    for (int k = 0; k < kCircleSamples; ++k)
      for (const int around : {-1, 0, 1}) {
        const double f = (mesh.period() * (k / double(kCircleSamples) + around) - from) / span;
        if (f < 0 || f > 1) continue;
        const double p = aligned_line.parameters.front() +
                         f * (aligned_line.parameters.back() - aligned_line.parameters.front());
        section[static_cast<size_t>(k)] = aligned_line.fitted.evaluate(p);
      }
  }
  return section;
}

SectionSamples even_points(const SmoothSegment& line) {
  const ArcLength arc(line.curve);
  SectionSamples section;
  for (int k = 0; k < kCircleSamples; ++k)
    section.push_back(line.curve->evaluate(arc.parameter(arc.total() * k / kCircleSamples)));
  return section;
}

// A section resampled from the start point and in the direction that make it nearest to `before`.
SectionSamples matched(const SectionSamples& section, const SectionSamples& before) {
  double least = std::numeric_limits<double>::infinity();
  int phase = 0, direction = 1;
  const auto place = [](int k) {
    return static_cast<size_t>((k % kCircleSamples + kCircleSamples) % kCircleSamples);
  };
  for (const int d : {1, -1})
    for (int p = 0; p < kCircleSamples; ++p) {
      double sum = 0;
      for (int k = 0; k < kCircleSamples; k += 4)
        sum += (section[place(p + d * k)] - before[static_cast<size_t>(k)]).squaredNorm();
      if (sum < least) least = sum, phase = p, direction = d;
    }
  // Shift between samples, from one Gauss-Newton step.
  double slope = 0, bend = 0;
  for (int k = 0; k < kCircleSamples; ++k) {
    const Vec3 tangent = 0.5 * (section[place(phase + direction * k + 1)] -
                                section[place(phase + direction * k - 1)]);
    slope += tangent.dot(before[static_cast<size_t>(k)] - section[place(phase + direction * k)]);
    bend += tangent.squaredNorm();
  }
  const double shift = bend > 0 ? std::clamp(slope / bend, -0.5, 0.5) : 0;
  SectionSamples result;
  for (int k = 0; k < kCircleSamples; ++k)
    result.push_back(at(section, (phase + shift + direction * k) / kCircleSamples));
  return result;
}

}  // namespace

Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element) {
  std::vector<SectionSamples> row{circle_samples(ring, 0)};
  for (const SmoothSegment& section : sections)
    row.push_back(matched(even_points(section), row.back()));
  row.push_back(circle_samples(ring, 1));
  std::vector<double> t{0};
  for (size_t i = 1; i < row.size(); ++i) {
    double distance = 0;
    for (int k = 0; k < kCircleSamples; ++k)
      distance += (row[i][static_cast<size_t>(k)] - row[i - 1][static_cast<size_t>(k)]).norm();
    t.push_back(t.back() + distance);
  }
  for (double& x : t) x /= t.back();
  const ParametricMesh& mesh = *ring.mesh;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec2& p : mesh.vertices()) low = std::min(low, p.y()), high = std::max(high, p.y());
  const auto place = [&](const Vec2& uv, int order) {
    Points x(isize(row), 3);
    for (size_t i = 0; i < row.size(); ++i)
      x.row(static_cast<long>(i)) = at(row[i], uv.x() / mesh.period());
    const HermiteCurve along(t, x, not_a_knot_slopes(t, x));
    return along.evaluate((uv.y() - low) / (high - low), order);
  };
  Points dofs = interpolate_surface(mesh, [&](const Vec2& uv) {
    const double h = mesh.period() / kCircleSamples;
    FirstOrderJet s{place(uv, 0), {}};
    s.gradient << (place(uv + Vec2(h, 0), 0) - place(uv - Vec2(h, 0), 0)) / (2 * h),
        place(uv, 1) / (high - low);
    return s;
  });
  return {ring.mesh, element, std::move(dofs), ring.trim};
}

}  // namespace batten
