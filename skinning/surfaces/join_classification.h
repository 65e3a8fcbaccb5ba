// Inside of skin_network(): chooses which lines become creases and which are to be smooth.
#pragma once

#include <array>
#include <vector>

#include "batten/skinning/surfaces/region_maker.h"

namespace batten {

/// What was chosen.
struct JoinClassification {
  std::vector<ModelJoin> joins;      ///< a join for every arc that has a region, by arc
  std::vector<JoinLine> join_lines;  ///< what is to be smooth; regions as the model counts them
  std::vector<int> join_of;          ///< index into `joins` of each join line
};

/// Chooses for every arc: by the user's words, or else by the angle at which the first shapes of
/// the two regions meet (ModelJoin::initial_deg). Throws InputError for words that fit no line.
JoinClassification classify_joins(const CurveNetwork& network, const RegionMaker& maker,
                                  const ModelOptions& options,
                                  const std::vector<ModelRegion>& regions);

/// Returns the angle between the present shapes of the two regions of a join line. `open`: ends
/// that are creases.
JoinQuality angle_of(const std::vector<ModelRegion>& regions, JoinLine join_line,
                     const std::array<bool, 2>& open = {});

}  // namespace batten
