// Builds the surface model of a scene: finds the faces that its curves bound, and skins them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The curve network of a scene's lines. Throws InputError that begins with the name of the scene
/// file.
CurveNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                        const Progress& progress = {});

/// Finds the regions of a network, following the scene's [[region]] and [[join]]. Throws
/// InputError, with the location in the scene, for specifications that match no lines or contradict
/// each other. Also throws it, with the reason, if there are no regions.
FoundRegions regions_of(const Scene& scene, const CurveNetwork& network,
                        const Progress& progress = {});

/// A model and the data that it was built from.
struct BuiltModel {
  // Set unless the scene specifies a single region or is a series of sections:
  std::optional<CurveNetwork> network;
  std::optional<FoundRegions> found;
  /// The model. Without a network it has one region, which is not solved yet.
  SurfaceModel model;
  /// Names of curves recognised as a series of sections, in order: the shape is their loft.
  std::vector<std::string> sections;
  double fit_tolerance = 0;  ///< tolerance of edge-aligned and embedded lines, model units

  /// Names of the skinned regions, to which loads and weights of the scene may refer.
  std::vector<std::string> region_names() const;
};

/// True if a scene specifies how its single region is made: domain, mesher, three stiffnesses,
/// `hold`, treatments, or a loft.
bool specifies_single_region(const Scene& scene);

/// Builds the model of the scene's curves, which does not depend on loads and constraints. The
/// model is a single region if the scene specifies it or the line roles leave one outline; the loft
/// of a series of sections; or else the network of all faces that the curves bound. Throws the
/// exceptions of network_of() and regions_of(), NoSolutionError, ConflictError and CancelledError.
BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress = {});

// The character lines of a solved shape, as curves for CAD export.

/// The lines of the shape in `made` as named C1 cubic splines, including moves of lines. Network
/// lines without a region keep their position in the network.
///
/// Edges into which a network line was split are merged if they continue in the same direction
/// (within 1e-6 rad); their parameters are scaled to make the derivatives equal. A network line
/// with corners, or one that shares an edge with another line, gives several curves named after its
/// edges: NAME.1-3, NAME.4. Those of a single region are NAME.1, NAME.2, …
std::vector<CubicSpline> line_curves(const BuiltModel& made);

}  // namespace batten
