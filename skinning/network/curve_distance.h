// Inside of find_contacts: how far two strands are from each other, and where.
#pragma once

#include <array>

#include "batten/skinning/network/sampled_curve.h"

namespace batten::detail {

/// Distance of two straight pieces a0 a1 and b0 b1; s and t in [0, 1] become the nearest places on
/// them.
double chord_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double& s,
                      double& t);

/// Parameters around a segment of a strand within which its nearest point is looked for.
std::array<double, 2> bracket(const SampledCurve& sampled_curve, int segment);

/// Distance of the nearest points of two curves within brackets, from ta and tb on, which become
/// their parameters: Levenberg's steps on both; one that is pushed against its end stays there.
double nearest(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
               const SampledCurve& b, const std::array<double, 2>& range_b, double& tb);

}  // namespace batten::detail
