// SPDX-License-Identifier: MPL-2.0
// Formats of CAD files: extensions, detection of truncated files, options for writing STEP files.
// Does not need OpenCASCADE.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "batten/fem/curves/bspline.h"
#include "batten/skinning/model/neighbour_edge.h"
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

/// CAD file formats. `Patches` (spline patches of the library G+Smo, .xml) can only be read.
enum class CadFormat { Step, Iges, Brep, Patches };

/// The file extensions of CAD formats, with the dot.
const std::vector<std::string>& cad_extensions();

/// The format that corresponds to the extension of a file. Throws InputError for an unknown
/// extension.
CadFormat cad_format(const std::filesystem::path& file);

/// True if `bytes`, the content of a BREP file, is in binary form.
bool is_binary_brep(const std::string& bytes);

/// Checks that a file has the given format and is not truncated, as far as this can be recognised
/// without OpenCASCADE. Throws InputError with the line of the error (for binary files, the byte).
/// The check is needed because OpenCASCADE silently reads the intact part of a truncated file.
/// O(file size).
void check_cad_text(const std::filesystem::path& file, CadFormat format);

// Options for writing STEP files of surfaces and of fitted faces.

/// Product name, author, schema and additional curves of a STEP file of surfaces.
struct StepFileOptions {
  std::string name = "surface";  ///< product name
  std::string author = "";
  bool ap242 = false;  ///< STEP schema; true: AP242, false: AP214
  /// Named curves to write in addition to the faces, in a separate product "curves". CAD programs
  /// show these curves as wires, which can be hidden. Programs that mesh the whole file also mesh
  /// the curves, without sharing nodes with the faces. Empty: no additional product.
  std::vector<CubicSpline> lines = {};
};

/// Options for fitting B-spline faces to surfaces and writing them to a STEP file.
struct StepFaceOptions {
  double tolerance = 0;  ///< largest distance of a face from its surface, model units; above 0
  /// Largest permitted angle between adjacent faces along edges at which their surfaces are
  /// tangent, degrees; above 0.
  double join_deg = 0.1;
  StepFileOptions file = {};
  /// True: write a face as an exact plane, cylinder, sphere, cone or torus if one of these fits the
  /// surface within `tolerance`.
  bool analytic = true;
  /// Primitives of model faces, by name, if they are known: used instead of fitted ones where the
  /// surface lies within `tolerance` of them.
  std::map<std::string, FittedPrimitive> primitives = {};
  /// Primitives that model faces continue with all of their edges, by name: used if the surface lies
  /// within `tolerance`, and within 1 % of the face's size, of them.
  std::map<std::string, FittedPrimitive> continued_primitives = {};
  /// The given surfaces that faces continue with tangent planes, by the name of the curve between
  /// them. The fitted faces have the tangent planes of these surfaces within `join_deg`.
  std::map<std::string, std::shared_ptr<const NeighbourEdge>> neighbours = {};
  int max_poles = 400;  ///< maximum number of poles of a face in u, and in v; 16 or more
  /// Maximum number of poles of a face in total (u times v), 256 or more. A face of 60,000 poles
  /// takes about 6 MB in the file.
  int max_poles_total = 60'000;
  /// Maximum ratio of the number of poles of a face to the number of triangles of its surface;
  /// 6,000 poles are always permitted. A valid surface needs about one pole per triangle, seldom
  /// more than five. The limit stops the fit of defective surfaces, to which splines do not
  /// converge.
  int max_poles_per_triangle = 20;
};

}  // namespace batten
