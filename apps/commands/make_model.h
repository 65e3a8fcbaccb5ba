// From a scene with [network] to its model: lines → network → regions → surfaces.
#pragma once

#include <vector>

#include "batten/io/scene.h"

namespace batten {

/// Throws InputError that begins with the scene's file.
CharacterLineNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                                const Progress& progress = {});

/// Throws InputError with the place in the scene: words that fit no lines or contradict each other;
/// no region at all, with what stands in the way.
FoundRegions regions_of(const Scene& scene, const CharacterLineNetwork& network,
                        const Progress& progress = {});

struct MadeModel {
  CharacterLineNetwork network;
  FoundRegions found;
  SurfaceModel model;
  double fit_tolerance = 0;   ///< of lines and embedded ones, model units
  double bending_energy = 0;  ///< of all regions, each over the network's size squared
};

/// Throws as above, and NoSolutionError, ConflictError, CancelledError.
MadeModel make_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress = {});

}  // namespace batten
