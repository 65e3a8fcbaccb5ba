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
  /// Name of the model and of its only face, options of faces, material, joins, rest shapes.
  ModelOptions model;
  NetworkOptions network;      ///< fit_tolerance and corner_angle are those of model.skin
  RegionSearchOptions search;  ///< requested and excluded faces
  /// True: the curves bound one face, laid out as model.skin says, or are the sections of one.
  bool single_face = false;
  /// With single_face: names of the sections, in order. They alone define the face if they are all
  /// of the curves; otherwise the curves bound it.
  std::vector<std::string> sections;
  /// True: only the corners of faces are constrained (SessionOptions::fix_corners_only), so that
  /// outlines alone may be a single face instead of a network.
  bool fix_corners_only = false;
  /// Tolerance of curves for a model of a given size, both in model units, of networks. Empty:
  /// model.skin.tolerance, or 1e-4 of the size.
  std::function<double(double size)> tolerance;
  std::string unit;  ///< length unit, for messages
  /// Prefixes of messages about the model and about its network, such as "scene.toml: " and
  /// "scene.toml:8:1: ".
  std::string where, network_where;
};

/// A model and the data that it was built from.
struct BuiltModel {
  // Set unless the model is a single face or a series of sections:
  std::optional<CurveNetwork> network;
  std::optional<FoundRegions> found;
  /// The model. Without a network it has one face, which is not solved yet.
  SurfaceModel model;
  /// Names of curves recognised as a series of sections, in order: the shape is their loft.
  std::vector<std::string> sections;
  double fit_tolerance = 0;  ///< tolerance of edge-aligned and embedded lines, model units

  /// Names of the skinned faces, to which loads and weights may refer.
  std::vector<std::string> region_names() const;
};

/// The curve network with the tolerances of build_model(). Throws the exceptions of CurveNetwork,
/// beginning with ModelBuildOptions::network_where.
CurveNetwork build_network(const std::vector<CharacterLine>& lines,
                           const ModelBuildOptions& options, const Progress& progress = {});

/// find_regions() that throws InputError, with the diagnostics of the network, if there are none.
FoundRegions require_regions(const CurveNetwork& network, const ModelBuildOptions& options,
                             const Progress& progress = {});

/// Builds the model of curves in any order:
///
///     single_face                           one face; a loft if `sections` are all of the curves
///     outlines bound one face               one face with the holes and inner curves on it
///     ordered_sections() of the network     the loft of a series of sections
///     otherwise                             skin_network(): all faces that the curves bound
///
/// Requested faces or joins exclude the two in the middle. Sections with a corner get two surfaces
/// in each bay (corner_rails()). The normals of a single face point to the side of normal_side.h.
///
/// Throws the exceptions of build_network(), require_regions(), RegionLayout and skin_network();
/// InputError if the only face cannot be skinned.
BuiltModel build_model(const std::vector<CharacterLine>& lines, const ModelBuildOptions& options,
                       const Progress& progress = {});

}  // namespace batten
