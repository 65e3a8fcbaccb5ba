// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/lines/character_line.h"

#include <algorithm>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/quadrature.h"
#include "batten/fairing/curves/staged_fairing.h"

namespace batten {
namespace {

using SharedBreaks = std::shared_ptr<const std::vector<double>>;

SharedBreaks shared_breaks(const InputCurve& curve) {
  return std::make_shared<const std::vector<double>>(curve.breaks());
}

// A part of a curve, in either direction. All parts of a curve share its breaks.
class Subcurve final : public InputCurve {
 public:
  Subcurve(std::shared_ptr<const InputCurve> whole, SharedBreaks given, double from, double to,
           bool backwards)
      : whole_(std::move(whole)),
        given_(std::move(given)),
        from_(from),
        to_(to),
        backwards_(backwards) {}
  double start() const override { return backwards_ ? -to_ : from_; }
  double end() const override { return backwards_ ? -from_ : to_; }
  Vec3 evaluate(double t, int order) const override {
    if (!backwards_) {
      // At its end, derivatives are those just before it, not those behind a corner.
      if (order > 0 && t >= to_) t = to_ - 1e-12 * (to_ - from_);
      return whole_->evaluate(t, order);
    }
    double forward = -t;
    if (order > 0 && forward >= to_) forward = to_ - 1e-12 * (to_ - from_);
    return (order == 1 ? -1 : 1) * whole_->evaluate(forward, order);
  }
  std::vector<double> breaks() const override {
    const auto first = std::upper_bound(given_->begin(), given_->end(), from_),
               last = std::lower_bound(first, given_->end(), to_);
    std::vector<double> inside = {from_};
    inside.insert(inside.end(), first, last);
    inside.push_back(to_);
    if (backwards_) {
      std::reverse(inside.begin(), inside.end());
      for (double& b : inside) b = -b;
    }
    return inside;
  }
  bool piecewise_cubic() const override { return whole_->piecewise_cubic(); }

 private:
  std::shared_ptr<const InputCurve> whole_;
  SharedBreaks given_;
  double from_, to_;
  bool backwards_;
};

// Derivatives just before and just after a break.
std::pair<Vec3, Vec3> one_sided(const InputCurve& curve, double t) {
  const double e = 1e-9 * (curve.end() - curve.start());
  return {curve.evaluate(t - e, 1), curve.evaluate(t + e, 1)};
}

}  // namespace

CharacterLine SmoothSegment::line(bool flipped) const {
  if (prescribed) return {name, input, role, mesh_alignment, prescribed, constrains_surface};
  return {name, flipped ? reversed(curve) : curve, role, mesh_alignment, {}, constrains_surface};
}

HermiteCurve as_closed_curve(const HermiteCurve& curve) {
  if (curve.closed()) return curve;
  const long last = 2 * (curve.node_count() - 1);
  return {CurveMesh(curve.parameters(), true), curve.dofs().topRows(last)};
}

HermiteCurve SmoothSegment::prescribed_along(bool flipped) const {
  return flipped ? prescribed->curve.backwards() : prescribed->curve;
}

namespace {

void check(const CharacterLine& line) {
  const HermiteCurve& curve = line.prescribed->curve;
  const std::vector<double>& at = line.prescribed->vertices;
  const std::string name = "prescribed curve '" + line.name + "'";
  if (curve.segment_count() < 1) throw InputError(name + " is empty");
  if (!curve.mesh().corners().empty()) throw InputError(name + " has corners in its interior");
  if (at.size() < 2 || at.front() != curve.start() || at.back() != curve.end())
    throw InputError(name + " has " + std::to_string(at.size()) +
                     " vertices, expected vertices from its start " + format_number(curve.start()) +
                     " to its end " + format_number(curve.end()));
  for (size_t i = 0; i + 1 < at.size(); ++i)
    if (!(at[i] < at[i + 1]))
      throw InputError(name + " has vertices that do not increase: " + format_number(at[i]) + ", " +
                       format_number(at[i + 1]));
  for (const double u : curve.parameters())
    if (!std::binary_search(at.begin(), at.end(), u))
      throw InputError(name + " has a node at " + format_number(u) + " that is not a vertex");
}

}  // namespace

std::shared_ptr<const InputCurve> subcurve(std::shared_ptr<const InputCurve> curve, double from,
                                           double to) {
  const SharedBreaks given = shared_breaks(*curve);
  return std::make_shared<Subcurve>(std::move(curve), given, from, to, false);
}

std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve) {
  const double a = curve->start(), b = curve->end();
  const SharedBreaks given = shared_breaks(*curve);
  return std::make_shared<Subcurve>(std::move(curve), given, a, b, true);
}

std::vector<SmoothSegment> split_at_corners(const CharacterLine& line, double corner_angle) {
  if (!line.curve) throw InputError("curve '" + line.name + "' has no geometry");
  if (line.prescribed) check(line);
  const auto whole = line.prescribed ? curve_from_hermite(line.prescribed->curve) : line.curve;
  const InputCurve& curve = *whole;
  constexpr int samples = 64;
  double length = 0;
  Vec3 before = curve.evaluate(curve.start());
  for (int i = 0; i <= samples; ++i) {
    const Vec3 p = curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / samples);
    if (!p.allFinite())
      throw InputError("curve '" + line.name + "' has a point that is not finite");
    length += (p - before).norm();
    before = p;
  }
  if (!(length > 0)) throw InputError("curve '" + line.name + "' has zero length");
  if (line.prescribed)
    return {{line.name, line.role, whole, line.mesh_alignment, line.prescribed, line.curve}};

  std::vector<double> cuts = {curve.start()};
  const SharedBreaks given = shared_breaks(curve);
  const std::vector<double>&breaks = *given, corners = curve.corners();
  for (size_t i = 1; i + 1 < breaks.size(); ++i) {
    const auto [a, b] = one_sided(curve, breaks[i]);
    if (degrees_between(a, b) > corner_angle ||
        std::binary_search(corners.begin(), corners.end(), breaks[i]))
      cuts.push_back(breaks[i]);
  }
  cuts.push_back(curve.end());
  const bool seam = !corners.empty() && corners.front() == curve.start();
  if (cuts.size() == 2)
    return {{line.name,
             line.role,
             line.curve,
             line.mesh_alignment,
             {},
             {},
             line.constrains_surface,
             {seam, seam}}};
  std::vector<SmoothSegment> parts;
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    parts.push_back({line.name + "." + std::to_string(i + 1),
                     line.role,
                     std::make_shared<Subcurve>(line.curve, given, cuts[i], cuts[i + 1], false),
                     line.mesh_alignment,
                     {},
                     {},
                     line.constrains_surface,
                     {i > 0 || seam, i + 2 < cuts.size() || seam}});
  return parts;
}

std::optional<HermiteCurve> reuse_cubic_input(const SmoothSegment& segment, double shortest,
                                              const Vec3& start, const Vec3& end) {
  constexpr double no_corner = 180, same_end = 1e-8;  // relative to the line's length
  const auto exact = exact_curve(*segment.curve, no_corner);
  if (!exact || exact->closed()) return std::nullopt;
  const int last = exact->node_count() - 1;
  if ((exact->position(0) - start).norm() > same_end * exact->end() ||
      (exact->position(last) - end).norm() > same_end * exact->end())
    return std::nullopt;
  double slowest = std::numeric_limits<double>::infinity(), fastest = 0;
  for (int s = 0; s < exact->segment_count(); ++s) {
    if (exact->mesh().length(s) < shortest && last > 1) return std::nullopt;
    for (int k = 0; k <= 8; ++k) {
      const double speed = exact->evaluate({s, k / 8.0}, 1).norm();
      slowest = std::min(slowest, speed);
      fastest = std::max(fastest, speed);
    }
  }
  constexpr double even_enough = 3;
  if (!(fastest <= even_enough * slowest)) return std::nullopt;
  Points dofs = exact->dofs();
  dofs.row(exact->mesh().position_dof(0)) = start;
  dofs.row(exact->mesh().position_dof(last)) = end;
  return HermiteCurve(exact->mesh(), dofs);
}

CurveDistance::CurveDistance(const InputCurve& curve) : curve_(curve) {
  const auto breaks = curve.breaks();
  const int samples = std::clamp<int>(512 / isize(breaks), 4, 128);
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k < samples; ++k)
      t_.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * k / samples);
  t_.push_back(curve.end());
  for (const double t : t_) x_.push_back(curve.evaluate(t, 0));
}

double CurveDistance::operator()(const Vec3& p) const {
  return closest_on_curve([&](double at, int order) { return curve_.evaluate(at, order); }, t_, x_,
                          p)
      .distance;
}

CurveSamples sample_line(const CharacterLine& line, double corner_angle) {
  const InputCurve& curve = *line.curve;
  const auto segments = split_at_corners({line.name, line.curve}, std::min(corner_angle, 179.9));
  std::vector<ArcLength> arcs;
  double total = 0;
  for (const SmoothSegment& s : segments) {
    arcs.emplace_back(s.curve);
    total += arcs.back().total();
  }
  CurveSamples result;
  result.name = line.name;
  result.corners.emplace();
  constexpr int finer = 4;
  for (size_t k = 0; k < segments.size(); ++k) {
    const InputCurve& part = *segments[k].curve;
    const int spans = isize(part.breaks()) - 1;
    const int count = std::max({8, 8 * spans, static_cast<int>(200 * arcs[k].total() / total)});
    if (k > 0) result.corners->push_back(isize(result.points));
    for (int i = 0; i < finer * count; ++i) {
      const double s = arcs[k].total() * i / (finer * count);
      const Vec3 p = part.evaluate(i == 0 ? part.start() : arcs[k].parameter(s));
      (i % finer == 0 ? result.points : result.extra_points).push_back(p);
    }
  }
  result.points.push_back(curve.evaluate(curve.end()));
  result.closed = (result.points.back() - result.points.front()).norm() <= 1e-9 * total;
  if (*result.closed) {
    result.points.back() = result.points.front();
    const double turn =
        degrees_between(curve.evaluate(curve.end(), 1), curve.evaluate(curve.start(), 1));
    if (turn > corner_angle) result.corners->insert(result.corners->begin(), 0);
  }
  return result;
}

}  // namespace batten
