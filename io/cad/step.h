// Writes regions as STEP files that are exactly their surfaces, and measures STEP files.
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
// Edges in space are the surface's own cubics, with the parameter of the parameter lines. Every
// vertex and edge exists once and is shared by the faces beside it, also where regions have a line
// in common: nothing is sewn. No edge is degenerate. Normals are along x_u × x_v.
//
//   regions that lines of the same name connect, closed    one solid, normals outwards
//   the same, open                                         one shell
//   one-sided, or three sides at a line                    a shell for each region, with edges of
//                                                          its own: STEP has no common way for
//                                                          more; the report warns
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/step_file_options.h"
#include "batten/io/cad/step_report.h"
#include "batten/io/cad/unwritable_regions.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// How write_step() writes a file.
struct StepOptions {
  StepFileOptions file = {};
  /// Whether Z12 surfaces are written by the HCT functions of the same dofs. Values and gradients
  /// on all element edges are the same; inside they differ by O(h⁴), which
  /// StepReport::max_deviation measures.
  bool z12_as_hct = false;
  /// Largest distance of the fitted faces of cut regions from their surfaces, in model units;
  /// 0: 1e-4 of the size.
  double tolerance = 0;
};

/// A warning for the user, to be shown before write_step(), when the file will be large (more than
/// 10,000 triangles in exact faces): how many faces, and about how many megabytes. Otherwise "".
std::string step_size_warning(const std::vector<const SkinnedRegion*>& regions);

/// Writes all regions and returns check_step of the file. Regions meet where their lines
/// have the same name: the same curve, in either direction, in two regions or twice in one. Where
/// the vertices of one side are not those of the other, edges end at both. Ends of lines that
/// coincide are one vertex. The coordinates are the model's own and the file declares the model's
/// unit. The file is written whole or not at all. About 4.75 kB and 0.4 ms a face to write, 1 ms to
/// read back and measure; all of it again, four times at most, when a fitted face misses the
/// tolerance. One that cannot reach it is written as near as it comes, and the report says so.
///
/// Throws InputError: no region; nothing but regions that embedded lines cut, by their names; exact
/// regions of which one embeds a line that another has as a run; lines of one name that differ; a
/// unit other than um, mm, cm, m, km, inch, ft, mi, mil, uin; a Z12 surface, other than a fitted
/// one, without `z12_as_hct`; a tolerance below 0; what write_step_faces says of fitted regions;
/// dofs that are not finite; a size above 20 km; an element edge without length; a file that cannot be written.
StepReport write_step(const std::filesystem::path& file,
                      const std::vector<const SkinnedRegion*>& regions, double model_unit_in_metres,
                      const StepOptions& options = {});

/// Reads a STEP file of any origin into model units and measures it. `regions`: the regions that it
/// should hold, shell by shell. Throws InputError when the file cannot be read or holds no shape,
/// and for units as above.
StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const SkinnedRegion*>& regions = {});

}  // namespace batten
