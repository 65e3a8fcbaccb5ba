// Networks of which one half is drawn.
#pragma once

#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Adds to the lines of half a model those of the other half: the mirror image in the plane through
/// the origin at right angles to the scene's axis of symmetry (SceneNetwork::symmetry), with the
/// name "mirrored NAME", of every line that does not lie in that plane within 1e-3 of the lines'
/// size. Nothing without an axis. Throws InputError, with the place in the scene, for a line that
/// crosses the plane.
void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines);

/// The scene's words about joins and regions, and the same about the mirror images: of every join
/// whose line has one, of every region that is not its own.
std::vector<JoinSpec> mirrored_joins(const Scene& scene, const std::vector<CharacterLine>& lines);
std::vector<RegionSpec> mirrored_regions(const Scene& scene,
                                         const std::vector<CharacterLine>& lines);

}  // namespace batten
