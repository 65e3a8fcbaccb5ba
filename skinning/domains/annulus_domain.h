// Rings: regions between two smooth closed rims, as tubes, skirts and annuli.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Returns whether two rims run in one direction around the ring between them. `a`, `b`: the same
/// number of points, evenly around each rim. Through a tube they do when their area vectors point
/// to the same side along the way from rim to rim. Where these do not decide (an annulus), they do
/// when points at equal shares of the rims lie nearer together than they would with one rim turned
/// over, from the best start in both cases. O(n²).
bool circles_have_same_direction(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// Makes a strip that is periodic in u: rim A along v = 0, in the direction of its first line, rim
/// B along v = V. It has no singular point, and the rims are straight runs of element edges:
///
///   U = mean length of the rims / size          u runs evenly with the arc length of each rim
///   V = mean distance of matched points / size
///
/// Points of equal u are matched: of the two directions of rim B and all its starts, those that
/// make the sum of squared distances between points at equal fractions of arc length least, so that
/// the strip is not twisted. Both rims become closed C1 cubic curves within the tolerance, whose
/// nodes lie on columns of the mesh. A rim of one line may begin anywhere: one of them is cut where
/// it matches the start of the other, and both begin at u = 0. Where lines join on both rims, the
/// columns tilt by up to half an edge so that each ends on a joint.
///
/// The mesh: right triangles, rows × columns with cells as near to squares of the wished edge as
/// the lines' nodes allow, diagonals alternating.
///
/// `a`, `b`: loops without corners, as make_loops() finds them. The parts have a mesh, one run for
/// each line (those of rim A first, along each rim; the vertices of a rim that is one closed line
/// name the first one again at the end) and two boundary loops: rim A with u, rim B against it.
/// Throws InputError in words for the user: a rim with a corner, rims that coincide, an edge length
/// that means more than 2 million triangles. Cost: O(columns · rows).
RegionGeometry make_annulus_geometry(const Outline& a, const Outline& b, const DomainInput& task);

/// Embeds holes and inner lines in a ring that has a shape. c(t) are the nearest points of the
/// surface; of an inner line that crosses no other one they are spread over it as evenly as the
/// line is long (nearest points crowd where a line bulges away from the surface). Images run on
/// over the seam, beyond [0, U]; a line begins in [0, U). A closed line that runs around the ring
/// ends one period from where it begins: its curve and its image are open curves then, whose ends
/// meet on the ring. Throws InputError as embed_on_surface() does, for a hole around the ring, and for an
/// inner line that is to be fitted. O(triangles · lines).
void embed_on_annulus(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry);


// Inside of rings: a rim with its lines.

/// Returns the part of x in [0, 1).
inline double fractional_part(double x) {
  x -= std::floor(x);
  return x < 1 ? x : 0;
}

/// A closed curve that has its seam at another of its points.
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

/// A rim and where its lines lie on it, in the direction of u.
struct BoundaryCircle {
  Outline outline;
  std::vector<ArcLength> arcs;
  double length = 0;
  struct Span {
    double from, length_fraction;  // of the rim's length; from in [0, 1)
    HermiteCurve fitted;           // along the rim
  };
  std::vector<Span> spans;  // of each line

  explicit BoundaryCircle(Outline loop) : outline(std::move(loop)) {
    for (const auto& p : outline.segments) {
      arcs.emplace_back(p.segment.curve);
      length += arcs.back().total();
    }
    // Slopes of given curves go on from one to the next over their own parameters.
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
  bool prescribed() const { return outline.segments[0].segment.prescribed != nullptr; }
  const HermiteCurve& prescribed(size_t i) const {
    return outline.segments[i].segment.prescribed->curve;
  }
  bool is_single_line() const { return spans.size() == 1; }

  struct Point {
    Vec3 x, tangent;
  };
  Point point(double fraction) const {
    double s = fractional_part(fraction) * length;
    size_t i = 0;
    for (; i + 1 < arcs.size() && s > arcs[i].total(); ++i) s -= arcs[i].total();
    const double t = arcs[i].parameter(s);
    const InputCurve& curve = *outline.segments[i].segment.curve;
    return {curve.evaluate(t), curve.evaluate(t, 1).normalized()};
  }

  // Returns a rim of one line with its seam at another place.
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
