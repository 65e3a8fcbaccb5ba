// From a scene to its model: lines → one region, or network → regions → surfaces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Throws InputError that begins with the scene's file.
CharacterLineNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                                const Progress& progress = {});

/// Throws InputError with the place in the scene: words that fit no lines or contradict each other;
/// no region at all, with what stands in the way.
FoundRegions regions_of(const Scene& scene, const CharacterLineNetwork& network,
                        const Progress& progress = {});

struct MadeModel {
  // Of a scene with [network].
  std::optional<CharacterLineNetwork> network;
  std::optional<FoundRegions> found;
  SurfaceModel model;        ///< without [network]: one region
  double fit_tolerance = 0;  ///< of lines and embedded ones, model units

  /// Names of regions that the scene may say, and of those that could not be skinned.
  std::vector<std::string> region_names() const;
};

/// The model that the scene's lines make; it does not depend on parameters of loads and
/// constraints. Without [network] the region has no shape yet. Throws as above, and
/// NoSolutionError, ConflictError, CancelledError.
MadeModel make_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress = {});

}  // namespace batten
