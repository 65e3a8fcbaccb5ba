// Makes the model of a scene: finds what its curves bound, and skins that.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// The network of a scene's lines. Throws InputError that begins with the scene's file.
CurveNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                        const Progress& progress = {});

/// Finds the regions of a network, as the scene's words ask. Throws InputError with the place in
/// the scene: words that fit no lines or contradict each other; no region at all, with the reason.
FoundRegions regions_of(const Scene& scene, const CurveNetwork& network,
                        const Progress& progress = {});

/// A model and what it was made from.
struct BuiltModel {
  // Set unless the scene is one region with statements about it, or a row of sections:
  std::optional<CurveNetwork> network;
  std::optional<FoundRegions> found;
  /// The model. Without a network it has one region, which has no shape yet.
  SurfaceModel model;
  /// Names of curves that were found to be a row of sections, in their order: the shape is their loft.
  std::vector<std::string> sections;
  double fit_tolerance = 0;  ///< tolerance of fitted and embedded lines, model units

  /// Names of the regions that are skinned, which the scene's loads and weights may use.
  std::vector<std::string> region_names() const;
};

/// Whether a scene says how its only region is to be made: domain, mesher, three stiffnesses, what is
/// held, treatments, a loft.
bool specifies_single_region(const Scene& scene);

/// Makes the model of the scene's curves, which does not depend on loads and constraints: one region
/// where the scene states it, or where roles leave one outline; the loft of a row of sections; else
/// the network of all that the curves bound. Throws what network_of() and regions_of() throw,
/// NoSolutionError, ConflictError and CancelledError.
BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress = {});


// The character lines of a finished shape as curves for CAD.

/// Each line of the shape in `made` as C1 cubics by its name: where its regions have it, moves
/// included, and for lines of a network without any region where the network has it. Arcs that a
/// line of a network was cut into are one curve again where they go on in one direction (within
/// 1e-6 radians): their parameters are scaled so that the slopes are the same. A line of a network
/// that turns a corner, or of which another line has a piece, is several curves by the numbers of
/// their arcs, NAME.1-3, NAME.4; one of a single region NAME.1, NAME.2, ….
std::vector<CubicSpline> line_curves(const BuiltModel& made);

}  // namespace batten
