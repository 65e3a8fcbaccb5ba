// The promises that a result must keep.
#pragma once

#include <vector>

#include "batten/io/report/report.h"

namespace batten {

/// The promises that the measured numbers break, and numbers that are not finite. The promises are:
///
///   curves    conditions of [[fair]] ≤ 1e-12 of the curve's size
///   lines     deviation of input from fitted curve ≤ tolerance
///   surface   constraint residual ≤ 1e-10 of the region's size, held normals ≤ 1e-6°,
///             normal jump inside ≤ 1e-3°, Jacobian ≥ 0.05 of its median, no singular node;
///             when lines are held: line residual ≤ 1e-10, gap of embedded lines and line
///             deviation ≤ tolerance
///   step      exact: valid, gap and (of HCT surfaces) deviation ≤ 1e-9 of the size plus the step's
///             tolerance, normal jump ≤ 1e-3°
///             one face: valid, deviation ≤ the step's tolerance; when lines are held, gap ≤ that
///             plus `tolerance`
///
/// Each region of a network keeps the promises of `surface` (its lines may also have been moved by
/// the network's tolerance where they were joined), and
///
///   regions   each is skinned; no flaw (SurfaceDefect)
///   joins     a smooth one stays under the join tolerance along all of it (0.05° more under loads
///             and moves), but for ends where the lines leave no tangent plane; one that is asked
///             for as smooth is smooth
///
/// `tolerance` is that of lines, in model units.
std::vector<FailedCheck> failed_checks(const Report& report, double tolerance);

}  // namespace batten
