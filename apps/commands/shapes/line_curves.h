// The character lines of a finished shape as curves for CAD.
#pragma once

#include <vector>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/fem/cubic_splines.h"

namespace batten {

/// Each line of the shape in `made` as C1 cubics by its name: where its regions have it, moves
/// included, and for lines of a network without any region where the network has it. Arcs that a
/// line of a network was cut into are one curve again where they go on in one direction (within
/// 1e-6 radians): their parameters are scaled so that the slopes are the same. A line of a network
/// that turns a corner, or of which another line has a piece, is several curves by the numbers of
/// their arcs, NAME.1-3, NAME.4; one of a single region NAME.1, NAME.2, ….
std::vector<CubicSpline> line_curves(const BuiltModel& made);

}  // namespace batten
