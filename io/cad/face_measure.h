// Measures faces of a STEP file that was read back against their regions. Internal.
#pragma once

#include <TopoDS_Face.hxx>

#include <map>
#include <vector>

#include "batten/io/cad/face_maker.h"
#include "batten/io/cad/step_report.h"
#include "batten/io/cad/tangent_joins.h"

namespace batten {

/// A face beside a piece of a line, at even places along it.
struct JoinNormals {
  std::string region;
  std::vector<Vec3> of_face;  ///< not normalised; zero where the surfaces meet at an angle
  std::vector<Vec3> of_surface,
      target_normals;  ///< normals of the surface, and those that both faces are to have
};
using FaceNormals = std::map<LineSegmentId, JoinNormals>;

/// Measures a face of the file against the region that it was made of, all of `patch` but its names
/// and poles. Returns its normals along smooth joins; the plan says which piece of a line a stretch is.
FaceNormals measure_face(const TopoDS_Face& face, const FaceMaker& made, const StepPlan& plan,
                         StepPatch& patch);

/// Whether an analytic face is as large as its region, and so the part of its surface that it should be.
bool has_area_of_region(const TopoDS_Face& face, const FaceMaker& made);

/// The same normals of the last fit, before there is a file; before there is a fit those of an analytic face,
/// or of the surface.
FaceNormals normals_of_fit(const FaceMaker& made, const StepPlan& plan);
FaceNormals normals_before_fit(const FaceMaker& made, const StepPlan& plan);

/// The joins between faces, by line. Where a side is no fitted face, the angle is
/// that from the normals that were wanted.
std::vector<StepJoin> joins_between(const std::vector<FaceNormals>& faces, double join_deg);

/// The largest angle across the joins of each face that miss `join_deg`, degrees, as far as a better face
/// could mend it: what the other face alone is off by, farther than that from the wanted normal, does
/// not count. 0: nothing is missed.
std::vector<double> correctable_angles(const std::vector<FaceNormals>& faces, double join_deg);

/// The largest angle of each face from the normals that are wanted along its joins, degrees, wherever the
/// surfaces meet by `join_deg` at most: what it misses alone, however good the other face is.
std::vector<double> angles_from_target(const std::vector<FaceNormals>& faces, double join_deg);

}  // namespace batten
