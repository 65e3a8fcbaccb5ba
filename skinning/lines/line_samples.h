// Samples of input curves for fairing. A header of its own: most users of character_line.h do not
// fair.
#pragma once

#include "batten/fairing/curves/staged_fairing.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Samples a curve for fair_in_stages(), evenly by arc length in each segment between corners.
///
/// Each segment gets at least eight points, eight per span between breaks, and its share of about
/// 200 points. CurveSamples::extra_points are three more between neighbours. The last point of a
/// closed curve equals the first.
///
/// `corner_angle`: turning angle of a corner, degrees; see corner_angle_of(). A prescribed curve of
/// the line is ignored. Throws InputError for a curve without length or with a point that is not
/// finite.
CurveSamples sample_line(const CharacterLine& line, double corner_angle);

}  // namespace batten
