// The fit of a FaceMaker: its target, tangent planes along joins, and how far it goes for them.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "batten/io/cad/face_maker.h"

namespace batten {
namespace {

/// Parameters of an arc, each in the middle of a step that is no longer than allowed where it begins.
std::vector<double> parameters_along(const PlanarCubic& arc, const BoundaryStep& longest) {
  Vec2 fastest = Vec2::Zero();  // |dc/dt| is nowhere larger
  for (const size_t k : {0, 1, 2})
    fastest = fastest.cwiseMax(3 * (arc.b[k + 1] - arc.b[k]).cwiseAbs());
  std::vector<double> sample_parameters;
  for (double t = 0; t < 1;) {
    const double steps = fastest.cwiseQuotient(longest(arc.at(t))).maxCoeff();
    const double next = std::min(t + 1 / steps, 1.0);
    sample_parameters.push_back((t + next) / 2);
    t = next;
  }
  return sample_parameters;
}

}  // namespace

bool FaceMaker::refine(double deviation, double angle_deg) {
  if (analytic_ || !fit_.reached || !std::isfinite(deviation)) return false;
  const bool far = deviation > options_.tolerance;
  constexpr int most_failures = 2;
  const bool askew = angle_deg > options_.join_deg && goal_.angle_deg < options_.join_deg &&
                     failed_angles_ < most_failures;
  if (!far && !askew) return false;
  const PatchFit before = fit_;
  // What is missed lies between the samples of the fit: its own measures are to fall in proportion.
  constexpr double at_once = 0.02;
  const auto tighten = [](double& goal, double requested) {
    goal = std::max(std::min(goal, requested), at_once * goal);
  };
  if (far) tighten(goal_.deviation, 0.9 * options_.tolerance / deviation * before.deviation);
  if (askew) tighten(goal_.angle_deg, 0.9 * options_.join_deg / angle_deg * before.angle_deg);
  constexpr int most_steps = 3;
  for (int i = 0; i < most_steps; ++i) {
    const double asked = goal_.angle_deg;
    fit(&before.patch);
    if (!fit_.reached) break;
    const bool nearer = (!far || fit_.deviation < before.deviation) &&
                        (!askew || fit_.angle_deg < before.angle_deg);
    if (nearer && fit_.patch.poles.rows() > before.patch.poles.rows()) return true;
    if (goal_.angle_deg > asked) break;  // out of reach
    if (far) goal_.deviation *= 0.8;
    if (askew) goal_.angle_deg *= 0.8;
  }
  fit_ = before;
  if (askew) ++failed_angles_;
  return false;
}

std::vector<PatchTangent> FaceMaker::tangents(const BoundaryStep& longest) const {
  std::vector<PatchTangent> found;
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop) {
      if (segment.normal_corrections.empty()) continue;
      const auto arcs = planar_cubics(segment.pcurve);
      for (size_t k = 0; k < arcs.size(); ++k) {
        for (const double s : parameters_along(arcs[k], longest)) {
          const double t = segment.pcurve.parameters()[k] +
                           s * segment.pcurve.mesh().length(static_cast<int>(k));
          const auto normal_correction = segment.normal_correction(t);
          if (!normal_correction) continue;
          const Vec2 uv = arcs[k].at(s);
          const SurfaceJet jet = near_origin_.surface().jet(near_origin_.locate(uv));
          // Where the surface comes to a point its planes turn without end.
          if (!(jet.area_vector().norm() > 1e-3 * jet.x_u.norm() * jet.x_v.norm())) continue;
          const Vec3 n_both = (jet.normal() + *normal_correction).normalized();
          found.push_back(
              {uv, jet.x_u - n_both.dot(jet.x_u) * n_both, jet.x_v - n_both.dot(jet.x_v) * n_both});
        }
      }
    }
  return found;
}

PatchTarget FaceMaker::target() const {
  PatchTarget target;
  target.inside = [&](const Vec2& uv) { return boundary_.contains(uv); };
  target.position = [&](const Vec2& uv) { return near_origin_.position(uv); };
  target.boundary = [&](const BoundaryStep& longest) {
    std::vector<Vec2> points;
    for (const FaceLoop& loop : boundary_.loops)
      for (const FaceBoundarySegment& segment : loop)
        for (const PlanarCubic& arc : planar_cubics(segment.pcurve)) {
          for (const double s : parameters_along(arc, longest)) points.push_back(arc.at(s));
          points.push_back(arc.b[3]);
        }
    return points;
  };
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop) target.fixed.push_back(segment.first());
  target.low = boundary_.domain.low();
  target.high = boundary_.domain.high();
  target.periodic = boundary_.period > 0;
  if (target.periodic) {
    target.low.x() = boundary_.seam;
    target.high.x() = boundary_.seam + boundary_.period;
  }
  return target;
}

void FaceMaker::fit() { fit(nullptr); }

void FaceMaker::fit(const BicubicPatch* start) {
  PatchTarget target = this->target();
  constexpr int few = 6'000;
  const int triangles = region_.surface.mesh().triangle_count();
  const int in_proportion = std::max(few, options_.max_poles_per_triangle * triangles);
  // A cell of the first fit holds up to eight triangles.
  const int first = std::clamp(static_cast<int>(std::lround(std::sqrt(triangles / 8.0))), 2, 8);
  const PatchLimits limits{options_.max_poles, std::min(options_.max_poles_total, in_proportion),
                           first};
  bool tangent = false;
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop)
      tangent = tangent || !segment.normal_corrections.empty();
  if (tangent) {
    // A few poles a triangle follow what a surface's elements mean; more of them follow their kinks.
    constexpr int fewest = 3'000, a_triangle = 8;
    PatchLimits for_angle = limits;
    for_angle.max_poles = std::min(
        limits.max_poles, std::max({fewest, a_triangle * triangles,
                                    start ? static_cast<int>(2 * start->poles.rows()) : 0}));
    target.tangents = [&](const BoundaryStep& longest) { return tangents(longest); };
    fit_ = fit_bicubic_patch(target, goal_, for_angle, start);
    if (!fit_.reached && fit_.deviation > goal_.deviation) {
      // The deviation alone tells which knots it needs: from these on the angle may be within reach.
      fit_ = fit_bicubic_patch(target, {goal_.deviation}, limits, start);
      for_angle.max_poles =
          std::max(for_angle.max_poles, static_cast<int>(4 * fit_.patch.poles.rows()));
      const PatchFit nearer = fit_bicubic_patch(target, goal_, for_angle, &fit_.patch);
      if (nearer.deviation <= goal_.deviation && nearer.angle_deg < fit_.angle_deg) fit_ = nearer;
    }
    if (fit_.deviation <= goal_.deviation) {
      goal_.angle_deg = std::max(goal_.angle_deg, 1.05 * fit_.angle_deg);
      fit_.reached = true;
      return;
    }
    target.tangents = nullptr;
    goal_.angle_deg = PatchGoal{}.angle_deg;
  }
  fit_ = fit_bicubic_patch(target, {goal_.deviation}, limits, start);
}

}  // namespace batten
