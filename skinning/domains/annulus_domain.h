// SPDX-License-Identifier: MPL-2.0
// Annular domains: regions between two smooth closed curves, such as tubes, skirts and annuli.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Tests whether two boundary circles run in the same direction around the annulus between them.
/// `a`, `b`: the same number of points, evenly spaced around each circle.
///
/// For a tube the answer is yes if the area vectors point to the same side along the axis from
/// circle to circle. If the area vectors do not decide (a flat annulus), two sums of squared
/// distances at equal fractions of arc length are compared: with one circle reversed and not
/// reversed, each with the best start point. O(n²).
bool circles_have_same_direction(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// Builds a strip that is periodic in u. Circle A lies on v = 0, in the direction of its first
/// line; circle B lies on v = V. The domain has no singular point, and both circles are straight
/// chains of element edges:
///
///   U = mean length of the circles / size          u is proportional to arc length on each circle
///   V = mean distance of matched points / size
///
/// Points of equal u are matched. So that the strip is not twisted, circle B gets the direction of
/// circles_have_same_direction(). Its start point minimises the sum of squared distances between
/// points at equal fractions of arc length. Both circles become closed C1 cubic curves within the
/// tolerance, whose nodes lie on columns of the mesh. A circle of one line may begin anywhere: its
/// seam is moved to match the start of the other one, and both begin at u = 0. If both circles
/// consist of several lines, the columns tilt by up to half an edge, so that each column ends at a
/// line's end point.
///
/// The mesh has right triangles in rows × columns, with alternating diagonals. The cells are as
/// close to squares of side `task.options.edge_length` as the nodes of the lines allow.
///
/// `a`, `b`: loops without corners from make_loops(). The result has a mesh, one edge-aligned line
/// per input line (those of circle A first, in order along each circle), and two boundary loops:
/// circle A in the direction of u, circle B against it. If a circle is one closed line, its list of
/// vertices repeats the first vertex at the end.
///
/// Throws InputError, with a message for the user: a circle with a corner, circles that coincide,
/// an edge length that leads to more than 2 million triangles. Cost: O(columns · rows).
RegionGeometry make_annulus_geometry(const Outline& a, const Outline& b, const DomainInput& task);

/// Embeds holes and inner lines in an annulus whose surface is known. The pcurves c(t) pass through
/// the closest points on the surface. Closest points cluster where a line bulges away from the
/// surface. So if an inner line crosses no other one, they are redistributed in proportion to the
/// line's arc length.
///
/// Pcurves continue across the seam, beyond [0, U]; each begins in [0, U). A closed line that runs
/// around the annulus ends one period away from its start. Its curve and its pcurve are then open
/// curves whose ends meet on the annulus.
///
/// Throws InputError as embed_on_surface() does; also for a hole that runs around the annulus and
/// for an inner line with MeshAlignment::EdgeAligned. Cost: O(triangles · lines).
void embed_on_annulus(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry);

// Annular surfaces through sections, on which the inner sections are embedded.

/// Builds a surface on the mesh of an annulus, through its boundary circles and the closed curves
/// between them, in their order.
///
/// On each line u = const it is the cubic spline through the sections. Each section lies at one v,
/// proportional to its mean distance from the section before. Its points are evenly spaced in arc
/// length over u, with the start point and direction that make it nearest to the section before.
/// O(vertices · sections).
Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element);

// Boundary circles with their lines.

/// Fractional part of x, in [0, 1).
inline double fractional_part(double x) {
  x -= std::floor(x);
  return x < 1 ? x : 0;
}

/// A closed curve whose seam (start and end point) is moved to another of its points.
class RotatedSeamCurve final : public InputCurve {
 public:
  RotatedSeamCurve(std::shared_ptr<const InputCurve> whole, double seam)
      : whole_(std::move(whole)),
        seam_(seam),
        before_(whole_->end() - seam),
        period_(whole_->end() - whole_->start()) {}
  double start() const override { return 0; }
  double end() const override { return period_; }
  Vec3 evaluate(double t, int order) const override {
    return whole_->evaluate(t < before_ ? seam_ + t : seam_ + t - period_, order);
  }
  std::vector<double> breaks() const override {
    std::vector<double> all = {0};
    const auto prescribed = whole_->breaks();
    for (const double b : prescribed)
      if (b > seam_) all.push_back(b - seam_);
    for (const double b : prescribed)
      if (b > whole_->start() && b < seam_) all.push_back(b - seam_ + period_);
    all.push_back(period_);
    return all;
  }

 private:
  std::shared_ptr<const InputCurve> whole_;
  double seam_, before_, period_;
};

/// A boundary circle and the positions of its lines along it, in the direction of u.
struct BoundaryCircle {
  Outline outline;
  /// Arc length of each line, in the direction of the circle.
  std::vector<ArcLength> arcs;
  /// Length of the circle, model units.
  double length = 0;
  struct Span {
    double from, length_fraction;  // fractions of the circle's length; from in [0, 1)
    HermiteCurve fitted;           // C1 cubic curve, oriented along the circle
  };
  std::vector<Span> spans;  // one per line

  explicit BoundaryCircle(Outline loop) : outline(std::move(loop)) {
    for (const auto& p : outline.segments) {
      arcs.emplace_back(p.segment.curve);
      length += arcs.back().total();
    }
    // Prescribed curves: the parametrisation continues from one curve to the next, so fractions are
    // of parameter intervals, not of length.
    std::vector<double> before = {0};
    for (size_t i = 0; i < arcs.size(); ++i)
      before.push_back(before.back() + (prescribed() ? prescribed(i).end() - prescribed(i).start()
                                                     : arcs[i].total()));
    for (size_t i = 0; i < arcs.size(); ++i) {
      const auto length_fraction = [&](double part) {
        return prescribed() ? part / before.back() : round_to_grid(part / length);
      };
      const double from = length_fraction(before[i]);
      spans.push_back({from, length_fraction(before[i + 1]) - from, {}});
    }
  }
  /// True if the lines have prescribed curves (all or none have).
  bool prescribed() const { return outline.segments[0].segment.prescribed != nullptr; }
  const HermiteCurve& prescribed(size_t i) const {
    return outline.segments[i].segment.prescribed->curve;
  }
  bool is_single_line() const { return spans.size() == 1; }

  /// Position and unit tangent.
  struct Point {
    Vec3 x, tangent;
  };
  /// Point at a fraction of the circle's length; periodic.
  Point point(double fraction) const {
    double s = fractional_part(fraction) * length;
    size_t i = 0;
    for (; i + 1 < arcs.size() && s > arcs[i].total(); ++i) s -= arcs[i].total();
    const double t = arcs[i].parameter(s);
    const InputCurve& curve = *outline.segments[i].segment.curve;
    return {curve.evaluate(t), curve.evaluate(t, 1).normalized()};
  }

  // The circle with its seam at another fraction of its length. It must consist of one line.
  BoundaryCircle with_seam_at(double fraction) const {
    Outline cut = outline;
    auto& piece = cut.segments[0];
    const double t = arcs[0].parameter(fractional_part(fraction) * length);
    if (t > piece.segment.curve->start() && t < piece.segment.curve->end()) {
      piece.segment.curve = std::make_shared<RotatedSeamCurve>(piece.segment.curve, t);
      piece.start = piece.segment.curve->evaluate(0);
    }
    return BoundaryCircle(std::move(cut));
  }
};

}  // namespace batten
