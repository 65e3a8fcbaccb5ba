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

#include "batten/io/cad/step_options.h"
#include "batten/io/step/step_report.h"
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


// Writes skinned regions as small STEP files: one trimmed bicubic B-spline face for each region.
//
// The face is a least-squares fit of x(u, v) over the rectangle around the region's boundary loops,
// C2 and with as few poles as the tolerance asks for; the parameters are the region's own u, v, the
// outward normal is along x_u × x_v. Wires are the boundary loops, the outline first. Each stretch
// of the boundary between corners is one edge: on the face its image c(t), in space the curve
// S(c(t)) of the face itself, within 1e-7 mm, which is where readers take points for one. The face
// passes through the corners of its lines. A ring closes in u and has a seam.
//
// Regions with lines of the same name hang together as in step.h: such a line is one edge for all
// of them, the line's own C1 cubic B-spline. (Where a ring's seam meets it, or the image of it bends,
// it is several edges.) It lies off both faces by the tolerance: STEP has no tolerance of an edge,
// OpenCASCADE's reader takes the largest distance at 23 places, and its check for Boolean operations
// names edges that are farther off in between (as it does for its own sewn fillings).
//
// Where the surfaces of two regions are tangent along at least half of a line, their faces are too:
// both are fitted to normals that are common to them, smooth along the line (what is shorter than 3 %
// of it is smoothed away), and one normal for all joins that meet in a place, where they turn so that each
// face has one twist in its corner (corner_twists.h). StepReport::joins has the angle of each in the file.
//
// The report does not use the fit's own numbers: OpenCASCADE reads the file back from disk, it is
// sampled, and knots are refined until the file keeps the tolerance.

/// Writes one face for each region and measures the file (coordinates and unit as in
/// write_step). `max_deviation` and `max_gap` are the largest of the faces. When the tolerance
/// cannot be reached, because of the limits of poles or because finer knots no longer help (the
/// elements' own jumps of curvature are too many), the best file found is written and the report
/// says so; so it does of angles across joins, for which a face gets 3,000 poles, 8 a triangle, or four times what
/// its deviation needs, at most. The file is written whole or not at all. Takes seconds for 10,000 triangles, and about
/// 90 bytes for each pole.
///
/// Throws InputError: no region; a region without boundary, or whose boundary curve and image have
/// different parameters; lines of one name that differ, lines without a name beside them; a ring
/// whose rims do not run around it, or whose holes leave no room for the seam; a unit other than
/// those of write_step; a tolerance that is not > 0; limits of poles below those that
/// StepFaceOptions allows; dofs that are not finite; a size above 20 km; a file that cannot be written.
StepReport write_step_faces(const std::filesystem::path& file,
                            const std::vector<const SkinnedRegion*>& regions,
                            double model_unit_in_metres, const StepFaceOptions& options);

}  // namespace batten
