// Inside of fair_points: what has to hold while a curve is faired.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/fairing/fair_options.h"

namespace batten {

/// Throws InputError, which names the line, for options out of their range and for conditions that
/// have no meaning or do not fit a closed line.
void check(const std::string& name, const FairOptions& options, bool closed);

/// Signed distance of p from the plane of a condition.
double signed_distance(const CurveCondition& plane, const Vec3& p);

/// Adds the rows of all conditions; at[k]: parameter of condition k, where it has one.
void add_rows(const std::vector<CurveCondition>& conditions, const std::vector<double>& at,
              const CurveMesh& mesh, ConstraintSet& set);

/// Largest violation of a condition, measured on the finished curve: distance over the size, angles
/// in radians. constrained_at[k]: parameter at which condition k was held.
double max_residual(const std::vector<CurveCondition>& conditions,
                    const std::vector<double>& constrained_at, const HermiteCurve& curve,
                    double size);

}  // namespace batten
