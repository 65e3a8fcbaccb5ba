// Builds the surface model of a scene: how its tables determine the options of build_model().
#pragma once

#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/skinning/surfaces/build_model.h"

namespace batten {

/// The options that a scene states for its model. `lines`: the scene's curves, of a half model with
/// their mirror images. They refer to the scene, which must outlive them.
ModelBuildOptions model_build_options(const Scene& scene, const std::vector<CharacterLine>& lines);

/// True if a scene specifies how its single region is made: domain, mesher, three stiffnesses,
/// `hold`, treatments, or a loft.
bool specifies_single_region(const Scene& scene);

/// Builds the model of the scene's curves, which does not depend on loads and constraints. The
/// model is a single region if the scene specifies it or the line roles leave one outline; the loft
/// of a series of sections; or else the network of all faces that the curves bound. Throws the
/// exceptions of build_model() in skinning/surfaces/build_model.h, with the location in the scene.
BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress = {});

}  // namespace batten
