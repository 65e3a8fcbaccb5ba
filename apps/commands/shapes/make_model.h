// Makes the model of a scene: its lines make one region, or a network of regions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The network of a scene's lines. Throws InputError that begins with the scene's file.
CharacterLineNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                                const Progress& progress = {});

/// Finds the regions of a network, as the scene's words ask. Throws InputError with the place in
/// the scene: words that fit no lines or contradict each other; no region at all, with the reason.
FoundRegions regions_of(const Scene& scene, const CharacterLineNetwork& network,
                        const Progress& progress = {});

/// A model and what it was made from.
struct MadeModel {
  // Set for a scene with [network]:
  std::optional<CharacterLineNetwork> network;
  std::optional<FoundRegions> found;
  SurfaceModel model;        ///< the model; without [network] it has one region
  double fit_tolerance = 0;  ///< tolerance of fitted and embedded lines, model units

  /// Names of the regions that are skinned, which the scene's loads and weights may use.
  std::vector<std::string> region_names() const;
};

/// Makes the model of the scene's lines, which does not depend on loads and constraints. Without
/// [network] the region has no shape yet. Throws what network_of() and regions_of() throw,
/// NoSolutionError, ConflictError and CancelledError.
MadeModel make_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress = {});

}  // namespace batten
