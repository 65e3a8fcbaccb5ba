// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/face_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr double kHair = 1e-9;  // relative to a parameter interval

const std::string& line_name(const SkinnedRegion& region, const BoundarySegment& piece) {
  const auto i = static_cast<size_t>(piece.index);
  return piece.kind == BoundarySegment::Kind::EdgeAligned ? region.edge_aligned.at(i).line.name
                                                          : region.embedded.at(i).line.name;
}

/// The restriction of a curve to [from, to], within which it must be smooth.
HermiteCurve part(const HermiteCurve& whole, double from, double to) {
  const HermiteCurve curve = whole.with_nodes({from, to});
  std::vector<double> u;
  std::vector<Vec3> x, d;
  for (int i = 0; i <= curve.segment_count(); ++i) {
    const double at = curve.parameters()[i];
    if (at < from || at > to) continue;
    const int node = i % curve.node_count();
    u.push_back(at);
    x.push_back(curve.position(node));
    d.push_back(at == to ? curve.slope_in(node) : curve.slope_out(node));
  }
  Points positions(static_cast<long>(u.size()), 3), derivatives(positions.rows(), 3);
  for (size_t i = 0; i < u.size(); ++i) {
    positions.row(static_cast<long>(i)) = x[i];
    derivatives.row(static_cast<long>(i)) = d[i];
  }
  return {u, positions, derivatives};
}

/// Splits the segment at the given parameters; returns it unchanged if none lies inside.
FaceLoop cut(const FaceBoundarySegment& whole, std::vector<double> at) {
  const double start = whole.curve.start(), end = whole.curve.end(), hair = kHair * (end - start);
  // Snap to nearby nodes, so that rounding leaves no slivers beside them.
  for (double& t : at)
    for (const HermiteCurve* curve : {&whole.curve, &whole.pcurve})
      for (const double node : curve->parameters())
        if (std::abs(node - t) <= 1e-12 * (end - start)) t = node;
  std::erase_if(at, [&](double t) { return t <= start + hair || t >= end - hair; });
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a <= hair; }),
           at.end());
  if (at.empty()) return {whole};
  at.insert(at.begin(), start);
  at.push_back(end);
  FaceLoop pieces;
  for (size_t i = 0; i + 1 < at.size(); ++i)
    pieces.push_back({part(whole.curve, at[i], at[i + 1]), part(whole.pcurve, at[i], at[i + 1]),
                      whole.line, whole.reversed, whole.shift, whole.scale, whole.shared});
  return pieces;
}

std::vector<double> corner_parameters(const HermiteCurve& curve) {
  std::vector<double> at;
  for (const int node : curve.mesh().corners()) at.push_back(curve.parameters()[node]);
  return at;
}

HermiteCurve shifted(const HermiteCurve& pcurve, double du) {
  Points dofs = pcurve.dofs();
  for (int i = 0; i < pcurve.node_count(); ++i) dofs(pcurve.mesh().position_dof(i), 0) += du;
  return {pcurve.mesh(), std::move(dofs)};
}

/// Determines the direction of the segment along its curve, and the map to the curve's parameter. A
/// segment has the direction of its loop, whatever the direction of the curve.
void parameter_on_line(FaceBoundarySegment& whole, const StepPlan& common,
                       const std::string& region) {
  const auto found = common.lines.find(whole.line);
  if (found == common.lines.end())
    throw InputError("face '" + region +
                     "': found a boundary curve without a name, expected a name for curves that "
                     "faces share");
  const HermiteCurve& line = *found->second.curve;
  whole.reversed = direction_along(whole.curve, line, common.distance) < 0;
  // A model face that fitted the curve itself has another parametrisation.
  whole.scale = (line.end() - line.start()) / (whole.curve.end() - whole.curve.start());
  if (whole.reversed) whole.scale = -whole.scale;
  whole.shared = found->second.sides > 1;
  whole.shift = (whole.reversed ? line.end() : line.start()) - whole.scale * whole.curve.start();
}

FaceLoop loop_of(const SkinnedRegion& region, const std::vector<BoundarySegment>& pieces,
                 const StepPlan* common) {
  FaceLoop loop;
  const double period = region.surface.mesh().period();
  for (const BoundarySegment& piece : pieces) {
    FaceBoundarySegment whole{boundary_curve(region, piece), boundary_pcurve(region, piece),
                              line_name(region, piece)};
    if (!(std::abs(whole.curve.start() - whole.pcurve.start()) +
              std::abs(whole.curve.end() - whole.pcurve.end()) <=
          1e-9 * (whole.curve.end() - whole.curve.start())))
      throw InputError("face '" + region.name + "': a boundary curve runs from " +
                       format_number(whole.curve.start()) + " to " +
                       format_number(whole.curve.end()) + ", its curve in (u, v) from " +
                       format_number(whole.pcurve.start()) + " to " +
                       format_number(whole.pcurve.end()));
    if (period > 0 && !loop.empty()) {
      const double du = loop.back().last().x() - whole.first().x();
      whole.pcurve = shifted(whole.pcurve, period * std::round(du / period));
    }
    auto at = corner_parameters(whole.curve);
    for (const double t : corner_parameters(whole.pcurve)) at.push_back(t);
    if (common) {
      parameter_on_line(whole, *common, region.name);
      for (const double t : common->lines.at(whole.line).cuts)
        at.push_back((t - whole.shift) / whole.scale);
    }
    for (FaceBoundarySegment& segment : cut(whole, at)) loop.push_back(std::move(segment));
  }
  return loop;
}

/// The parameters at which a segment crosses the given u, ascending within each cubic.
std::vector<double> crossings(const FaceBoundarySegment& segment, double u) {
  std::vector<double> found;
  const auto arcs = planar_cubics(segment.pcurve);
  for (size_t k = 0; k < arcs.size(); ++k) {
    for (const double s : BernsteinCubic::coordinate(arcs[k], 0, u).zeros())
      found.push_back(segment.pcurve.parameters()[k] + s * segment.pcurve.mesh().length(k));
  }
  return found;
}

/// Rotates a loop around an annulus to start where it crosses u = seam (mod period), and shifts it
/// in u accordingly. Empty if it does not cross.
FaceLoop begun_at(const FaceLoop& loop, double seam, double period) {
  const bool forward = loop.back().last().x() > loop.front().first().x();
  const double begin = forward ? seam : seam + period;
  const double size = 1e-9 * period;
  FaceLoop pieces;
  size_t first = std::numeric_limits<size_t>::max();
  for (const FaceBoundarySegment& segment : loop) {
    std::vector<double> at;
    double low = kInfinity, high = -kInfinity;
    for (const PlanarCubic& arc : planar_cubics(segment.pcurve))
      for (const Vec2& p : arc.b) {
        low = std::min(low, p.x());
        high = std::max(high, p.x());
      }
    for (double k = std::ceil((low - begin) / period); begin + k * period <= high; ++k)
      for (const double t : crossings(segment, begin + k * period)) at.push_back(t);
    for (FaceBoundarySegment& piece : cut(segment, at)) {
      const double winding = (piece.first().x() - begin) / period;
      if (first > pieces.size() && std::abs(winding - std::round(winding)) * period <= size)
        first = pieces.size();
      pieces.push_back(std::move(piece));
    }
  }
  if (first >= pieces.size()) return {};
  std::rotate(pieces.begin(), pieces.begin() + static_cast<long>(first), pieces.end());
  for (size_t i = 0; i < pieces.size(); ++i) {
    const double to = i == 0 ? begin : pieces[i - 1].last().x();
    const double du = period * std::round((to - pieces[i].first().x()) / period);
    pieces[i].pcurve = shifted(pieces[i].pcurve, du);
  }
  return pieces;
}

DomainLoops::Loop parameter_loops(const FaceLoop& loop) {
  DomainLoops::Loop result;
  for (const FaceBoundarySegment& segment : loop) result.push_back(segment.pcurve);
  return result;
}

HermiteCurve straight(const Vec2& a, const Vec2& b) {
  Points x(2, 3), d(2, 3);
  x << a.x(), a.y(), 0, b.x(), b.y(), 0;
  d << b.x() - a.x(), b.y() - a.y(), 0, b.x() - a.x(), b.y() - a.y(), 0;
  return {{0, 1}, x, d};
}

/// True if a pcurve is straight from its start to its end, and never turns back.
bool is_straight(const HermiteCurve& pcurve, double distance) {
  const Vec2 a = drop_z(pcurve.position(0));
  const Vec2 b = drop_z(pcurve.evaluate({pcurve.segment_count() - 1, 1.0}));
  const Vec2 along = (b - a).normalized();
  double before = 0;
  for (const PlanarCubic& arc : planar_cubics(pcurve))
    for (const Vec2& p : arc.b) {
      const double f = along.dot(p - a);
      if (!(std::abs(cross(along, p - a)) <= distance) || !(f >= before - distance)) return false;
      before = f;
    }
  return true;
}

/// The indices of the segments that begin at the corners, if the pcurves of a loop form a convex
/// quadrilateral that is traversed counter-clockwise.
std::optional<std::array<size_t, 4>> corners_of_quadrilateral(const FaceLoop& loop) {
  constexpr double straight_deg = 1e-6, least_deg = 10;
  double length = 0;
  for (const FaceBoundarySegment& s : loop) length += (s.last() - s.first()).norm();
  const double hair = 1e-9 * length;
  std::vector<size_t> found;
  for (size_t i = 0; i < loop.size(); ++i) {
    const FaceBoundarySegment &before = loop[(i + loop.size() - 1) % loop.size()], &here = loop[i];
    const Vec2 a = before.last() - before.first(), b = here.last() - here.first();
    if (!is_straight(here.pcurve, hair) || !((here.first() - before.last()).norm() <= hair) ||
        !(b.norm() > hair))
      return std::nullopt;
    const double turn = std::atan2(cross(a, b), a.dot(b)) * 180 / std::numbers::pi;
    if (std::abs(turn) <= straight_deg) continue;
    if (!(turn > least_deg && turn < 180 - least_deg) || found.size() == 4) return std::nullopt;
    found.push_back(i);
  }
  if (found.size() != 4) return std::nullopt;
  return std::array<size_t, 4>{found[0], found[1], found[2], found[3]};
}

/// A pcurve on the line `from` + x `side`, moved to the line `to` + x `along`.
HermiteCurve moved_to(const HermiteCurve& pcurve, const Vec2& from, const Vec2& side,
                      const Vec2& to, const Vec2& along) {
  Points dofs = pcurve.dofs();
  std::vector<char> is_position(static_cast<size_t>(dofs.rows()), 0);
  for (int i = 0; i < pcurve.node_count(); ++i) is_position[pcurve.mesh().position_dof(i)] = 1;
  for (long i = 0; i < dofs.rows(); ++i) {
    const bool position = is_position[static_cast<size_t>(i)] != 0;
    const Vec2 p = dofs.row(i).head<2>().transpose();
    const double x = side.dot(position ? Vec2(p - from) : p) / side.squaredNorm();
    const Vec2 moved = position ? Vec2(to + x * along) : Vec2(x * along);
    dofs.row(i).head<2>() = moved.transpose();
  }
  return {pcurve.mesh(), std::move(dofs)};
}

}  // namespace

std::optional<Vec3> FaceBoundarySegment::normal_correction(double t) const {
  if (normal_corrections.empty()) return std::nullopt;
  const double at = (t - curve.start()) / (curve.end() - curve.start()) *
                    static_cast<double>(normal_corrections.size() - 1);
  const auto k =
      static_cast<size_t>(std::clamp(at, 0.0, static_cast<double>(normal_corrections.size() - 2)));
  if (!normal_corrections[k] || !normal_corrections[k + 1]) return std::nullopt;
  const double s = std::clamp(at - static_cast<double>(k), 0.0, 1.0);
  return (1 - s) * *normal_corrections[k] + s * *normal_corrections[k + 1];
}

FaceBoundary::FaceBoundary(const SkinnedRegion& region, const StepPlan* common,
                           AnnulusBoundary boundary_cut)
    : period(region.surface.mesh().period()) {
  if (region.boundary.empty() || (period > 0 && region.boundary.size() < 2))
    throw InputError("face '" + region.name + "': found no boundary loops; expected an outline");
  for (const auto& pieces : region.boundary) {
    if (pieces.empty())
      throw InputError("face '" + region.name + "': found a boundary loop without curves");
    loops.push_back(loop_of(region, pieces, common));
  }
  map_quadrilateral();
  std::vector<FaceLoop> whole = loops;
  if (period > 0) unroll(region.name);
  std::vector<DomainLoops::Loop> all;
  for (const FaceLoop& loop : loops) all.push_back(parameter_loops(loop));
  if (period > 0) {
    // Along one loop, up the seam, back along the other, down the seam.
    DomainLoops::Loop around = all[0];
    around.push_back(straight(loops[0].back().last(), loops[1].front().first()));
    around.insert(around.end(), all[1].begin(), all[1].end());
    around.push_back(straight(loops[1].back().last(), loops[0].front().first()));
    all.erase(all.begin(), all.begin() + 2);
    all.insert(all.begin(), around);
  }
  domain = DomainLoops(std::move(all));
  if (boundary_cut == AnnulusBoundary::Whole) loops = std::move(whole);
}

/// Replaces the parameters by those of a rectangle if the domain is a convex quadrilateral.
void FaceBoundary::map_quadrilateral() {
  if (period > 0 || loops.size() != 1) return;
  FaceLoop& loop = loops.front();
  const auto corners = corners_of_quadrilateral(loop);
  if (!corners) return;
  std::array<Vec2, 4> at;
  for (size_t k = 0; k < 4; ++k) at[k] = loop[(*corners)[k]].first();
  const auto side = [&](size_t k) { return Vec2(at[(k + 1) % 4] - at[k]); };
  // Mean lengths of opposite sides, so that the parameters keep their scale.
  const Vec2 extent((side(0).norm() + side(2).norm()) / 2, (side(1).norm() + side(3).norm()) / 2);
  const BilinearMap map(at, extent);
  const Vec2 rectangle[4] = {{0, 0}, {extent.x(), 0}, extent, {0, extent.y()}};
  double least = kInfinity, most = 0;
  for (const Vec2& corner : rectangle) {
    const double area = map.jacobian(corner).determinant();
    least = std::min(least, area);
    most = std::max(most, area);
  }
  constexpr double least_ratio = 0.05;
  if (!(least > least_ratio * most)) return;  // too close to a triangle
  for (size_t k = 0; k < 4; ++k) {
    const Vec2 to = rectangle[k], along = rectangle[(k + 1) % 4] - to;
    for (size_t i = (*corners)[k]; i != (*corners)[(k + 1) % 4]; i = (i + 1) % loop.size())
      loop[i].pcurve = moved_to(loop[i].pcurve, at[k], side(k), to, along);
  }
  to_domain = map;
}

bool FaceBoundary::contains(Vec2 uv) const {
  if (period > 0) uv.x() -= std::floor((uv.x() - seam) / period) * period;
  return domain.contains(uv);
}

void FaceBoundary::add_cuts(StepPlan& plan) const {
  std::map<std::string, std::pair<double, double>> ends;
  for (const FaceLoop& loop : loops)
    for (const FaceBoundarySegment& s : loop) {
      const double a = s.line_parameter(s.curve.start()), b = s.line_parameter(s.curve.end());
      const auto [it, added] = ends.emplace(s.line, std::minmax(a, b));
      it->second = {std::min(it->second.first, std::min(a, b)),
                    std::max(it->second.second, std::max(a, b))};
    }
  for (const FaceLoop& loop : loops)
    for (const FaceBoundarySegment& s : loop)
      for (const double t : {s.curve.start(), s.curve.end()}) {
        const double at = s.line_parameter(t);
        const auto [low, high] = ends.at(s.line);
        const double hair = kHair * (high - low);
        if (at > low + hair && at < high - hair) plan.lines.at(s.line).cuts.push_back(at);
      }
}

/// Chooses a seam that meets no hole, at the start of the first loop if possible.
void FaceBoundary::unroll(const std::string& name) {
  const double start = loops[0].front().first().x();
  const auto winding = [&](const FaceLoop& loop) {
    return (loop.back().last().x() - loop.front().first().x()) / period;
  };
  if (winding(loops[1]) > 0) std::swap(loops[0], loops[1]);
  if (std::abs(winding(loops[0]) - 1) + std::abs(winding(loops[1]) + 1) > 1e-6)
    throw InputError("face '" + name + "': the two boundary loops of an annular face wind " +
                     format_number(winding(loops[0])) + " and " + format_number(winding(loops[1])) +
                     " times around it; expected once each, with the face to their left");
  constexpr int tries = 64;
  for (int k = 0; k < tries; ++k) {
    seam = start + period * k / tries;
    std::vector<FaceLoop> moved{begun_at(loops[0], seam, period), begun_at(loops[1], seam, period)};
    bool free = !moved[0].empty() && !moved[1].empty();
    for (size_t h = 2; h < loops.size() && free; ++h) {
      double low = kInfinity, high = -kInfinity;
      for (const FaceBoundarySegment& segment : loops[h])
        for (const PlanarCubic& arc : planar_cubics(segment.pcurve))
          for (const Vec2& p : arc.b) {
            low = std::min(low, p.x());
            high = std::max(high, p.x());
          }
      const double back = -std::floor((low - seam) / period) * period;
      free = high + back < seam + period;
      moved.push_back(loops[h]);
      for (FaceBoundarySegment& segment : moved.back())
        segment.pcurve = shifted(segment.pcurve, back);
    }
    if (!free) continue;
    loops = std::move(moved);
    return;
  }
  throw InputError(
      "face '" + name +
      "': found holes on every straight seam of an annular face; expected a seam without holes");
}

void cut_lines(StepPlan& plan, const std::vector<const SkinnedRegion*>& regions,
               const std::set<const SkinnedRegion*>& whole) {
  for (const SkinnedRegion* region : regions)
    FaceBoundary(*region, &plan,
                 whole.count(region) ? FaceBoundary::AnnulusBoundary::Whole
                                     : FaceBoundary::AnnulusBoundary::AtSeam)
        .add_cuts(plan);
  for (auto& [name, line] : plan.lines) {
    // Readers make closed curves periodic, which changes rational ones; see
    // reparametrize_for_gap_check() in step_check.h.
    if (line.cuts.empty() && line.sides > 1 && line.places[0] == line.places[1])
      line.cuts.push_back((line.curve->start() + line.curve->end()) / 2);
    std::sort(line.cuts.begin(), line.cuts.end());
    const double hair = 1e-9 * (line.curve->end() - line.curve->start());
    line.cuts.erase(std::unique(line.cuts.begin(), line.cuts.end(),
                                [&](double a, double b) { return b - a <= hair; }),
                    line.cuts.end());
  }
}

}  // namespace batten
