// What a picture of a fairing shows.
#pragma once

#include <vector>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/io/pictures/curve_pictures.h"
#include "batten/io/scene/fair_scene.h"

namespace batten {

/// Combs: as given and at the end. Stages: as given, after each stage of whole lines, after each
/// row of local ones. Lines without length are dots. At least one result has a curve.
CombPicture comb_panels(const std::vector<FairedResult>& results, const FairScene& scene,
                        const CombPictureRule& rule);

}  // namespace batten
