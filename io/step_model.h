// A model of several regions as one STEP file: faces that share their edges.
//
// Each region is one trimmed bicubic B-spline face, fitted as in step_face.h. Each arc of the
// network is one edge for all regions beside it: in space the arc's own curve as a C1 cubic
// B-spline, on each face its image there, over the same parameters. (Where a ring's seam meets an
// arc, or the image of an arc bends, the arc is several edges.) Nodes are vertices. Nothing is
// sewn: faces hang together because they use the same edges.
//
//   ModelShell, closed, orientable    one solid with one shell, normals outwards
//   ModelShell, open, orientable      one shell
//   one-sided, or three at an arc     a shell for each region, with common edges: CAD has no other
//                                     way; the report warns
//
// Tolerances of edges and vertices are the distances that were measured between them and the faces.
#pragma once

#include "batten/io/step_face.h"
#include "batten/skinning/network/model.h"

namespace batten {

/// Measured on the file read back, as StepFaceReport.
struct StepModelReport : StepFaceReport {
  int shells = 0, solids = 0;
  int closed_shells = 0;  ///< without a free edge
  double volume = 0;      ///< of all solids, model units³
  /// Of edges and vertices, as a reader has them: the largest.
  double max_tolerance = 0;
};

/// Writes the skinned regions of a model. StepFaceOptions as in write_step_face; each face's limits
/// are its own. Regions that are not skinned are left out; their shell is then open.
///
/// Throws InputError: no skinned region, a region whose boundary is not made of the network's arcs,
/// and what write_step_face throws. The file is written whole or not at all.
StepModelReport write_step_model(const std::filesystem::path& file,
                                 const CharacterLineNetwork& network, const SurfaceModel& model,
                                 double model_unit_in_metres, const StepFaceOptions& options);

}  // namespace batten
