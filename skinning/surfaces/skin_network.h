// From the regions of a network to one model, and that model in another shape.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Skins all regions of a network.
///
/// 1. Regions get normals that agree across arcs, outwards where a shell is closed.
/// 2. Each is laid out (RegionLayout) on the arcs' own curves, with the same vertices on both
///    sides of an arc, and solved by itself: all lines are creases.
/// 3. Arcs become creases or smooth joins (JoinWord, or the angle found). At a node where the
///    tangents of both sides do not lie in one plane a smooth join ends in a crease, and that is
///    said. One that a region carries embedded and would leave above 2 degrees becomes a crease.
/// 4. Regions that smooth joins connect are solved together (model/join.h), and halved along joins
///    until these keep the tolerance.
/// 5. What came out is measured, and looked through for flaws.
///
/// A region that cannot be skinned is left out and says why; the others are made all the same.
/// Throws InputError for words that fit nothing, NoSolutionError, CancelledError.
SurfaceModel skin_network(const CharacterLineNetwork& network, const FoundRegions& found,
                          const ModelOptions& options = {}, const Progress& progress = {});

/// Gives a model another shape, that of a session; it is measured and looked through anew.
/// `layout`: with the same regions (their meshes may be finer); `made`: its regions, in order.
/// Joins that were given up on the way become creases.
void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress = {});

}  // namespace batten
