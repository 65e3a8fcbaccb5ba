// Smooth joins across which the curvature goes on.
#pragma once

#include <vector>

#include "batten/fairing/minimum_variation_surface.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Whether fairing lets the curvature go on across a smooth join: what JoinLine::curvature says or,
/// where it says nothing, what the lines do that cross it at its ends. Two lines that go on into
/// each other there, one on each side, have normal curvatures κ_A and κ_B, and the surfaces must
/// have the same ones. It goes on unless, over the ends at which there are such lines,
///
///     Σ |κ_A - κ_B| > ½ Σ max(|κ_A|, |κ_B|),
///
/// as where a cap meets a cylinder. Without such lines it goes on. False for a plan that is given
/// up.
bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan);

/// The points, two for each edge or hat, of all joins across which the curvature goes on, and of
/// those on embedded lines. On these the jump of the tangent plane counts too, since the rows of
/// such a join leave it open between its hats; elsewhere the rows hold it.
std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout);

}  // namespace batten
