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
#pragma once

#include "batten/io/cad/step_face_options.h"
#include "batten/io/cad/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

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
