// Surfaces as STEP files that are exactly the surfaces, and what such a file holds when read back.
//
// An HCT triangle is three cubics, and a cubic in affine (s, t) is a bicubic on the square
// 0 ≤ s, t ≤ 1: each sub-triangle (V_j, V_k, centroid) becomes one bicubic face, cut along straight
// parameter lines.
//
//     t
//     1 o centroid        V_j = (0,0), V_k = (1,0), centroid = (0,1)
//       | \   spoke of V_k
//       |  \  on the
//       |   \ slanted side
//     0 o----o  s
//      V_j    V_k
//
// Edges in space are the surface's own cubics, their parameter runs as that of the parameter lines
// does. Every vertex and edge exists once, shared by the faces beside it: a surface is one shell
// without gaps, its normals along x_u × x_v. No poles, nothing is sewn.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/fem/surface.h"

namespace batten {

struct StepOptions {
  std::string name = "surface";  ///< of the product
  std::string author = "";
  /// Write Z12 surfaces by the HCT functions of the same dofs: values and gradients on all element
  /// edges are the same, the inside differs by O(h⁴). StepReport::max_deviation tells by how much.
  bool z12_as_hct = false;
};

/// What is in a STEP file, measured on the file read back from disk by OpenCASCADE (which silently
/// repairs directions of curves and loops while it reads). Lengths in model units.
struct StepReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  int shells = 0;
  int faces = 0;
  int edges = 0;
  int free_edges = 0;  ///< with one face only: the rims
  /// OpenCASCADE's checks passed (BRepCheck_Analyzer). They pass on a gap too, where reading widens
  /// the edge's tolerance over it: max_gap tells.
  bool valid = false;
  double size = 0;  ///< diagonal of the box around all edges
  double area = 0;
  /// Largest distance between an edge and the faces beside it (9 points an edge), and between a
  /// vertex and the ends of its edges. Over `size` it is a relative gap.
  double max_gap = 0;
  /// Largest angle between the outward normals of two faces along their edge, 9 points an edge.
  double max_normal_jump_deg = 0;
  /// Largest distance of points of the faces (15 each) to the surfaces; only when these were given.
  std::optional<double> max_deviation;
  /// Places where one of these could not be measured: an edge without a parameter line on its face,
  /// a point where the surface is singular.
  int unmeasured = 0;
  std::vector<std::string> warnings;
};

/// A text for the user when the file will be large (more than 10,000 triangles): how many faces and
/// about how many megabytes; otherwise "". To be said before write_step.
std::string step_size_warning(const std::vector<const Surface*>& surfaces);

/// Writes each surface as one shell (AP214) and returns check_step of the file. The coordinates are
/// the model's own and the file declares the model's unit. The file is written whole or not at all.
/// About 4.75 kB and 0.4 ms a face to write, 1 ms to read back and measure.
///
/// Throws InputError: no surface; a unit other than um, mm, cm, m, km, inch, ft, mi, mil, uin; a
/// Z12 surface without `z12_as_hct`; dofs that are not finite; an element edge without length; a
/// file that cannot be written.
StepReport write_step(const std::filesystem::path& file,
                      const std::vector<const Surface*>& surfaces, double model_unit_in_metres,
                      const StepOptions& options = {});

/// Reads a STEP file of any origin into model units and measures it. `surfaces`: what it should be.
/// Throws InputError when the file cannot be read or holds no shape, and for units as above.
StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const Surface*>& surfaces = {});

}  // namespace batten
