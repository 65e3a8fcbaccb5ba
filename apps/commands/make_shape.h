// From a scene to its shape: lines → layout → constraints → sculpting.
#pragma once

#include <vector>

#include "batten/io/scene.h"
#include "batten/skinning/skin.h"

namespace batten {

/// The region of a scene before it has a shape. It does not depend on parameters: one layout serves
/// all their values. Throws InputError.
RegionLayout lay_out(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress = {});

struct MadeShape {
  SkinnedRegion region;
  Surface unloaded;  ///< what the lines alone make: same mesh, no loads, no [[constraint]]
  SculptResult sculpt;
  double max_normal_constraint_deg = 0;  ///< measured at the vertices that a [[constraint]] holds
};

/// The shape that a scene's constraints, loads and material make of its layout: by one sculpt(), or
/// by a session that settles where only a session knows what the scene asks for.
/// Throws ConflictError, NoSolutionError, InputError, CancelledError.
MadeShape make_shape(const RegionLayout& layout, const Scene& scene, const Progress& progress = {});

/// Halves the layout's triangles where a region on its mesh leaves its embedded lines, which a move
/// may have displaced, by more than `target` between their points. False when it does not.
bool halve_at_gaps(RegionLayout& layout, const SkinnedRegion& region, double target);

/// Half of the tolerance is the lines' own deviation from their curves.
inline constexpr double kMostGap = 0.7;

/// The same, halving the layout's triangles where loads and constraints pull the surface off its
/// embedded lines, until it keeps the tolerance there or halving helps no more.
MadeShape make_refined_shape(RegionLayout& layout, const Scene& scene,
                             const Progress& progress = {});

}  // namespace batten
