// Makes the panels of a picture of curvature combs.
#pragma once

#include <vector>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/io/pictures/curve_pictures.h"
#include "batten/io/scene/fair_scene.h"

namespace batten {

/// The panels of a [[picture]]. Combs shows the lines as given and at the end; Stages shows them as
/// given, after each stage of whole lines, and after local stages that follow each other. Lines
/// without length are dots. At least one result must have a curve.
CombPicture comb_panels(const std::vector<FairedResult>& results, const FairScene& scene,
                        const CombPictureRule& rule);

}  // namespace batten
