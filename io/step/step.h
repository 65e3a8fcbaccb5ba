// Writes model faces to STEP files, as exact or as fitted faces, and measures STEP files.
//
// An HCT triangle consists of three cubics. A cubic in affine coordinates (s, t) is a bicubic on
// the square 0 ≤ s, t ≤ 1. So each sub-triangle (V_j, V_k, centroid) becomes one bicubic face,
// trimmed along straight parameter lines:
//
//     t
//     1 o centroid        V_j = (0,0), V_k = (1,0), centroid = (0,1)
//       | \   spoke of V_k
//       |  \  on the
//       |   \ slanted side
//     0 o----o  s
//      V_j    V_k
//
// Edges in space are the cubics of the surface, with the same parameter as the pcurves. Each vertex
// and edge exists once and is shared by the adjacent faces, also across model faces with a common
// curve, so nothing needs to be sewn. No edge is degenerate. Normals have the direction of x_u ×
// x_v.
//
//   model faces connected by curves of the same name:
//     closed                                       one solid, normals outwards
//     open                                         one shell
//     one-sided (not orientable), or non-manifold  one shell per model face, with edges of its own,
//                                                  because STEP has no common representation;
//                                                  the report has a warning
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/step_options.h"
#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Options of write_step().
struct StepOptions {
  StepFileOptions file = {};
  /// Write Z12 surfaces with the HCT functions of the same dofs. Values and gradients on element
  /// edges agree; inside the elements the surfaces differ by O(h⁴), which StepReport::max_deviation
  /// measures.
  bool z12_as_hct = false;
  /// Largest distance of the fitted faces of trimmed model faces from their surfaces, in model
  /// units; 0: 1e-4 of the model size.
  double tolerance = 0;
};

/// A warning to show before write_step() if the file will be large (more than 10,000 triangles in
/// exact faces). It states the number of faces and the approximate size in megabytes. Otherwise "".
std::string step_size_warning(const std::vector<const SkinnedRegion*>& regions);

/// Writes all model faces with exact faces, reads the file back, and returns the report of
/// check_step(). Model faces trimmed by embedded curves get fitted faces. Model faces are connected
/// along curves with the same name: the same curve, in either direction, in two model faces or
/// twice in one. If the vertices on both sides differ, the edges end at the vertices of both.
/// Coincident curve ends become one vertex. The file uses model coordinates and declares the model
/// unit. It is written atomically.
///
/// Costs about 4.75 kB and 0.4 ms per face to write, and 1 ms per face to read back and measure. If
/// a fitted face misses the tolerance, all of this is repeated, six times at most in total. A face
/// that cannot reach the tolerance is written as close as possible, and the report says so.
///
/// Throws InputError: no model face; only trimmed model faces (listed by name); an exact model face
/// that embeds a curve to which another exact model face is edge-aligned; different curves under
/// one name; a unit other than um, mm, cm, m, km, inch, ft, mi, mil, uin; a Z12 surface, other than
/// a fitted one, without `z12_as_hct`; a tolerance below 0; the conditions of write_step_faces()
/// for fitted model faces; non-finite dofs; a size above 20 km; an element edge of length zero; a
/// file that cannot be written.
StepReport write_step(const std::filesystem::path& file,
                      const std::vector<const SkinnedRegion*>& regions, double model_unit_in_metres,
                      const StepOptions& options = {});

/// Reads any STEP file into model units and measures it. `regions`: the model faces that it should
/// contain, shell by shell. Throws InputError if the file cannot be read or contains no shape, and
/// for units as write_step().
StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const SkinnedRegion*>& regions = {});

// Writes model faces as small STEP files: one trimmed bicubic B-spline face per model face.
//
// Each face is a least-squares fit of x(u, v) over the bounding rectangle of the model face's
// boundary loops. It is C2 and has only as many poles as the tolerance requires. Its parameters are
// the model face's own u, v; the outward normal has the direction of x_u × x_v. The wires are the
// boundary loops, the outer one first. Each boundary segment between corners is one edge. Its
// pcurve is the model face's own c(t). Its curve in space is S(c(t)) on the face, within 1e-7 mm,
// the distance below which readers treat points as coincident. The face interpolates the corners of
// its curves. An annulus is periodic in u and has a seam.
//
// Model faces with curves of the same name are connected as described at the top of this file. Such
// a curve is one edge for all of them: the curve's own C1 cubic B-spline. (It is several edges if
// the seam of an annulus meets it, or if its pcurve has a corner.) It may be off both faces by up
// to the tolerance. STEP cannot store a tolerance per edge: OpenCASCADE's reader uses the largest
// distance at 23 points. Its check for Boolean operations reports edges with a larger distance in
// between (also for its own sewn fillings).
//
// If the surfaces of two model faces are tangent along at least half of a curve, so are their
// faces. Both are fitted to common target normals, which are smooth along the curve (features
// shorter than 3 % of it are smoothed away). All joins that meet at a point have the same normal
// there. Near it, the normals rotate such that each face has a single twist in its corner
// (matching_twists() in tangent_joins.h). StepReport::joins contains the angle of each join in the
// file.
//
// The report does not rely on the fit: OpenCASCADE reads the file back from disk, it is sampled,
// and knots are refined until the file meets the tolerance.

/// Writes one face per model face and measures the file. Coordinates and unit are as in
/// write_step(). `max_deviation` and `max_gap` of the report are the maxima over the faces. The
/// tolerance may be out of reach because of the limits on poles, or because finer knots no longer
/// help (too many curvature jumps between the elements). Then the best file found is written and
/// the report says so. The same holds for the angles across joins. To reach these, a face gets at
/// most 3,000 poles, 8 per triangle, or four times the number that its deviation needs, whichever
/// is largest. The file is written atomically. Takes seconds for 10,000 triangles, and about 90
/// bytes per pole.
///
/// Throws InputError: no model face; a model face without boundary, or whose boundary curve and
/// pcurve have different parameters; different curves under one name; curves without a name next to
/// named ones; an annulus whose boundary circles do not run around it, or whose holes leave no
/// space for the seam; a unit that write_step() rejects; a tolerance that is not > 0; limits on
/// poles below those of StepFaceOptions; non-finite dofs; a size above 20 km; a file that cannot be
/// written.
StepReport write_step_faces(const std::filesystem::path& file,
                            const std::vector<const SkinnedRegion*>& regions,
                            double model_unit_in_metres, const StepFaceOptions& options);

}  // namespace batten
