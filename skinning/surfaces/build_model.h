// SPDX-License-Identifier: MPL-2.0
// From curves to a model in one call: a single face, a loft through sections, or all faces that the
// curves bound.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/search/regions.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Options of build_model().
struct ModelBuildOptions {
  /// Options of the faces and joins (skin_network()). A single face has the name of the model.
  ModelOptions model;
  /// Tolerances of the curve network; fit_tolerance and corner_angle are taken from `model.skin`.
  NetworkOptions network;
  RegionSearchOptions search;  ///< faces that the user requests or excludes
  /// True: the curves bound one face, which is built with the options in `model.skin`, or they are
  /// the sections of one loft.
  bool single_face = false;
  /// Names of the sections of a loft, in order; used only with `single_face`. If every curve is a
  /// section, the sections alone define the face; otherwise all curves together bound the face.
  std::vector<std::string> sections;
  /// True: only the corners of faces are constrained, not the curves
  /// (SessionOptions::fix_corners_only). Outline curves that bound one face then make a single face
  /// instead of a network.
  bool fix_corners_only = false;
  /// Computes the fit tolerance of the curves of a network from `size`, the size of the model; both
  /// are in model units. Empty: `model.skin.tolerance` or, if that is 0, 1e-4 of the size.
  std::function<double(double size)> tolerance;
  std::string unit;  ///< name of the length unit in messages, or ""
  /// Prefixes of error messages about the model and about the curve network, such as "scene.toml: "
  /// and "scene.toml:8:1: ".
  std::string where, network_where;
};

/// Result of build_model(): a model, and the data that it was built from.
struct BuiltModel {
  // The curve network and the faces found in it; both are empty if no network was needed.
  std::optional<CurveNetwork> network;
  std::optional<FoundRegions> found;
  /// The surface model; without a curve network, one face whose shape is not computed yet.
  SurfaceModel model;
  /// Names of the curves that ordered_sections() recognised as sections, in the order of the loft.
  /// Empty: the model is not a loft through recognised sections.
  std::vector<std::string> sections;
  /// Names of the curves that the model adds to the input curves: loft_rails().
  std::vector<std::string> added_curves;
  /// Largest allowed distance between an input curve and its C1 cubic fit, model units.
  double fit_tolerance = 0;

  /// Names of the faces that were skinned. Loads and stiffness fields may refer to these names.
  std::vector<std::string> region_names() const;
};

/// Builds the curve network of `lines` with the tolerances that build_model() uses. Throws as
/// CurveNetwork does; the messages of InputError get the prefix ModelBuildOptions::network_where.
CurveNetwork build_network(const std::vector<CharacterLine>& lines,
                           const ModelBuildOptions& options, const Progress& progress = {});

/// Finds the faces of a curve network by find_regions(), and throws InputError if there are none.
/// The message contains the diagnostics of the network.
FoundRegions require_regions(const CurveNetwork& network, const ModelBuildOptions& options,
                             const Progress& progress = {});

struct LoftPlan;  // loft_plan.h

/// The network of a loft with its rails, and the faces of the loft.
struct LoftNetwork {
  CurveNetwork network;
  FoundRegions found;
  /// Names of the rails through a corner of some section: creases, even if the corner fades out.
  std::vector<std::string> creases;
  std::vector<std::string> rails;  ///< names of all rails
};

/// Adds loft_rails() to the curves of a network and finds the faces: those of loft_faces() or, if
/// there are none, those that the curves bound. Rails that are closer to each other than the gap
/// tolerance stay apart. Returns nullopt if the sections have no rails. Throws as build_network()
/// and require_regions() do.
std::optional<LoftNetwork> loft_network(const CurveNetwork& network, const LoftPlan& plan,
                                        const ModelBuildOptions& options,
                                        const Progress& progress = {});

/// Builds a model from curves given in any order. The first applicable row determines the model:
///
///     single_face                           one face; a loft if `sections` are all of the curves
///     outlines bound one face               one face with the holes and inner curves on it
///     find_loft() of the network            faces between sections with corners (loft_rails())
///     ordered_sections() of the network     the loft of a series of sections
///     otherwise                             skin_network(): all faces that the curves bound
///
/// The second to fourth rows do not apply if faces or joins are requested. The normals of a single
/// face point to the convex side or, if there is none, to the side that normal_side.h defines.
///
/// Throws as build_network(), require_regions(), RegionLayout and skin_network() do, and InputError
/// if the model has a single face and that face cannot be skinned.
BuiltModel build_model(const std::vector<CharacterLine>& lines, const ModelBuildOptions& options,
                       const Progress& progress = {});

}  // namespace batten
