// The curves of a model as splines, for CAD files. A header of its own, so that other users of
// surface_model.h do not depend on the network's names.
#pragma once

#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The curves of a model as named C1 cubic splines, in the shape of its faces (moves of curves are
/// applied). Curves of the network without a face keep their position in the network.
///
/// Edges into which a curve of the network was split are merged if they continue in the same
/// direction (within 1e-6 rad); their parameters are scaled to make the derivatives equal. A curve
/// with corners, or one that shares an edge with another curve, gives several splines named after
/// its edges: NAME.1-3, NAME.4. Those of a model without a network are NAME.1, NAME.2, …
///
/// `network`: the network that the model was made of, or null for a model of a single face.
/// O(segments · log curves).
std::vector<CubicSpline> model_curves(const SurfaceModel& model, const CurveNetwork* network);

}  // namespace batten
