// SPDX-License-Identifier: MPL-2.0
// Writes the faces of a model to STEP files, exactly or by fitted B-spline faces, and measures STEP
// files.
//
// An HCT triangle consists of three cubics. A cubic in affine coordinates (s, t) is a bicubic on
// the square 0 ≤ s, t ≤ 1. Therefore each sub-triangle with the corners V_j, V_k and the centroid
// becomes one bicubic face, trimmed along straight lines in the (s, t) plane:
//
//     t
//     1 o centroid        V_j = (0,0), V_k = (1,0), centroid = (0,1)
//       | \    edge from V_k
//       |  \   to the centroid,
//       |   \  a straight line
//     0 o----o  s
//      V_j    V_k
//
// The 3D curves of edges are cubics with the same parameter as the pcurves. Each vertex and edge
// occurs once and is shared by the adjacent faces, even if these belong to different model faces
// with a common curve, so no sewing is needed. No edge is degenerate. Normals have the direction of
// x_u × x_v.
//
// Model faces that are connected by curves of the same name are written as follows:
//
//     closed set of faces             one solid, normals outwards
//     open set of faces               one shell
//     non-orientable or non-manifold  one shell per model face with separate edges, because STEP
//                                     has no common representation; the report has a warning
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_format.h"
#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Options for writing exact faces to a STEP file.
struct StepOptions {
  StepFileOptions file = {};
  /// True: write each Z12 surface as the HCT surface with the same dofs. Values and gradients of
  /// the two surfaces agree on element edges; inside the elements the surfaces differ by O(h⁴),
  /// where h is the element size. StepReport::max_deviation contains the measured difference.
  bool z12_as_hct = false;
  /// Tolerance for model faces that are trimmed and therefore written as fitted faces: largest
  /// distance from the surface, model units; 0: 1e-4 of the size of the model.
  double tolerance = 0;
};

/// A warning to show before write_step() if the file will be large (more than 10,000 triangles in
/// exact faces); otherwise "". The warning contains the number of faces and the approximate file
/// size in megabytes.
std::string step_size_warning(const std::vector<const SkinnedRegion*>& regions);

/// Writes all model faces to a STEP file as exact faces, reads the file back, and returns the
/// report of check_step(). Model faces trimmed by embedded curves are written as fitted faces.
/// Model faces are connected along curves with the same name, which occur in two model faces, in
/// either direction, or twice in one. If the mesh vertices on the two sides of a curve differ, the
/// curve is split into edges at the vertices of both sides. Coincident curve ends become one
/// vertex. The file, written atomically, uses model coordinates and declares the model unit.
///
/// Writing takes about 0.4 ms and 4.75 kB per face; reading back and measuring takes 1 ms per face.
/// If a fitted face misses the tolerance, all of this is repeated, up to six times in total. A face
/// that cannot reach the tolerance is written with the smallest deviation possible, which the
/// report contains.
///
/// Throws InputError if:
/// - there is no model face, or all model faces are trimmed (the message lists them);
/// - an exact model face embeds a curve with which the mesh of another exact model face is aligned;
/// - different curves have the same name;
/// - the unit is not um, mm, cm, m, km, inch, ft, mi, mil or uin;
/// - a model face is a Z12 surface and not fitted, and `z12_as_hct` is false;
/// - the tolerance is below 0;
/// - a fitted model face violates the requirements of write_step_faces();
/// - a dof is not finite, the size exceeds 20 km, or an element edge has length zero;
/// - the file cannot be written.
StepReport write_step(const std::filesystem::path& file,
                      const std::vector<const SkinnedRegion*>& regions, double model_unit_in_metres,
                      const StepOptions& options = {});

/// Reads any STEP file, converts it to model units and measures gaps, angles and deviations.
/// `regions`: the model faces that the file should contain, shell by shell. Throws InputError if
/// the file cannot be read or contains no shape, or if write_step() would reject the unit.
StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const SkinnedRegion*>& regions = {});

// Writes small STEP files with one trimmed bicubic B-spline face per model face.
//
// Each face is a least-squares fit of the surface x(u, v) over the bounding rectangle of the
// boundary loops of the model face. It is C2 and has only as many poles as the tolerance requires.
// Its parameters are u, v of the model face; the outward normal has the direction of x_u × x_v. The
// wires are the boundary loops, starting with the outer loop. Each part of a boundary loop between
// corners is one edge. The pcurve of the edge is the boundary curve c(t) of the model face in (u,
// v). The 3D curve of the edge is S(c(t)), where S is the fitted face, within 1e-7 mm; readers
// treat points closer than that as coincident. The face interpolates the corners of its boundary
// curves. An annulus is periodic in u and has a seam.
//
// Model faces with curves of the same name are connected as described at the top of this file. A
// common curve is one edge for all of these faces, with the C1 cubic B-spline of the curve. (It is
// several edges if the seam of an annulus ends on it, or if its pcurve has a corner.) The edge may
// deviate from the faces by up to the tolerance. STEP cannot store a tolerance per edge.
// OpenCASCADE's reader therefore measures the distance at 23 points and uses the largest one; its
// check for Boolean operations reports edges with a larger distance between these points (also for
// fillings that OpenCASCADE itself has sewn).
//
// If the surfaces of two model faces are tangent along at least half of a curve, the fitted faces
// are tangent there, too. Both are fitted to common target normals, which vary smoothly along the
// curve (features shorter than 3 % of the curve are smoothed). All smooth edges that meet at a
// point have the same normal there. Near this point, the normals are rotated so that the twist
// vectors of each face agree at the corner (matching_twists() in tangent_joins.h).
// StepReport::joins contains the measured angle at each smooth edge of the file.
//
// The report does not rely on the fit: OpenCASCADE reads the file back from disk, and the faces are
// sampled. Knots are refined until the file meets the tolerance.

/// Writes a STEP file with one fitted B-spline face per model face, and measures it. The file uses
/// model coordinates and declares the model unit. `max_deviation` and `max_gap` of the report are
/// the maxima over all faces.
///
/// The tolerance may be unreachable because of the limits on the number of poles, or because knot
/// refinement no longer helps (too many curvature jumps between elements). In this case the file
/// with the smallest deviation is kept, and StepReport::reached is false. The same applies to the
/// angles at smooth edges. To reach these angles, a face gets at most as many poles as the largest
/// of 3,000, 8 per triangle, and four times the number needed for its deviation. The file is
/// written atomically. Takes seconds for 10,000 triangles, and about 90 bytes per pole.
///
/// Throws InputError if:
/// - there is no model face, or a model face without boundary;
/// - a boundary curve and its pcurve have different parameters;
/// - different curves have the same name, or only some of the curves have names;
/// - the boundary circles of an annulus do not run around it, or holes leave no space for the seam;
/// - write_step() would reject the unit;
/// - the tolerance is not above 0, or a limit on poles is below the minimum in StepFaceOptions;
/// - a dof is not finite, or the size exceeds 20 km;
/// - the file cannot be written.
StepReport write_step_faces(const std::filesystem::path& file,
                            const std::vector<const SkinnedRegion*>& regions,
                            double model_unit_in_metres, const StepFaceOptions& options);

}  // namespace batten
