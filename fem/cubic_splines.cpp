#include "batten/fem/cubic_splines.h"

#include <array>

#include "batten/core/box.h"

namespace batten {
namespace {

/// One segment with its place on the stretch's parameter line.
struct Piece {
  double begin = 0, end = 0;
  std::array<Vec3, 4> bezier;

  /// The symmetric function of three parameters that is the cubic where all three are equal.
  Vec3 blossom(const std::array<double, 3>& u) const {
    std::array<Vec3, 4> b = bezier;
    for (size_t level = 0; level < 3; ++level) {
      const double t = (u[level] - begin) / (end - begin);
      for (size_t i = 0; i + level < 3; ++i) b[i] = (1 - t) * b[i] + t * b[i + 1];
    }
    return b[0];
  }
  Vec3 second_at_begin() const {
    return 6 / ((end - begin) * (end - begin)) * (bezier[0] - 2 * bezier[1] + bezier[2]);
  }
  Vec3 second_at_end() const {
    return 6 / ((end - begin) * (end - begin)) * (bezier[1] - 2 * bezier[2] + bezier[3]);
  }
};

Piece piece_of(const HermiteCurve& curve, int segment, double shift) {
  const int next = (segment + 1) % curve.node_count();
  const double begin = curve.parameters()[segment], end = curve.parameters()[segment + 1];
  const double third = (end - begin) / 3;
  const Vec3 a = curve.position(segment), b = curve.position(next);
  return {begin + shift,
          end + shift,
          {a, a + third * curve.slope_out(segment), b - third * curve.slope_in(next), b}};
}

/// How often the knot between two pieces is needed.
int multiplicity(const Piece& before, const Piece& after, double size) {
  const double h = std::max(before.end - before.begin, after.end - after.begin);
  const Vec3 jump = after.second_at_begin() - before.second_at_end();
  return jump.norm() * h * h <= 1e-13 * size ? 1 : 2;
}

CubicSpline spline_of(const std::vector<Piece>& pieces) {
  CubicSpline spline;
  Box3 box;
  for (const Piece& p : pieces)
    for (const Vec3& b : p.bezier) box.extend(b);
  spline.size = box.diagonal().norm();

  std::vector<double> all;  // knots, as often as they count
  std::vector<size_t> piece_after;
  const auto add = [&](double knot, int times, size_t piece) {
    spline.knots.push_back(knot);
    spline.multiplicities.push_back(times);
    all.insert(all.end(), static_cast<size_t>(times), knot);
    piece_after.insert(piece_after.end(), static_cast<size_t>(times), piece);
  };
  add(pieces.front().begin, 4, 0);
  for (size_t i = 1; i < pieces.size(); ++i)
    add(pieces[i].begin, multiplicity(pieces[i - 1], pieces[i], spline.size), i);
  add(pieces.back().end, 4, pieces.size());
  for (size_t i = 0; i + 4 < all.size(); ++i) {
    // The pole's own three knots: any piece of positive length beside the middle one will do.
    size_t interval = i + 1;
    if (all[interval] == all[interval + 1]) interval = i + 2;
    if (all[interval] == all[interval + 1]) interval = i == 0 ? 3 : i;
    spline.poles.push_back(
        pieces[piece_after[interval]].blossom({all[i + 1], all[i + 2], all[i + 3]}));
  }
  return spline;
}

}  // namespace

std::vector<CubicSpline> cubic_splines(const std::string& name, const HermiteCurve& curve) {
  const int segments = curve.segment_count();
  const auto& corners = curve.mesh().corners();
  const int first = curve.closed() && !corners.empty() ? corners.front() : 0;
  std::vector<std::vector<Piece>> stretches(1);
  for (int k = 0; k < segments; ++k) {
    const int segment = (first + k) % segments;
    if (k > 0 && curve.mesh().is_corner(segment)) stretches.emplace_back();
    const double shift = first + k >= segments ? curve.end() - curve.start() : 0;
    stretches.back().push_back(piece_of(curve, segment, shift));
  }
  std::vector<CubicSpline> splines;
  for (const auto& pieces : stretches) {
    splines.push_back(spline_of(pieces));
    splines.back().name = name + (stretches.size() > 1 ? "." + std::to_string(splines.size()) : "");
  }
  splines.front().closed = curve.closed() && corners.empty();
  return splines;
}

}  // namespace batten
