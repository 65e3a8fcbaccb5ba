// SPDX-License-Identifier: MPL-2.0
// Builds the surface model of a curve network, changes its shape, and fairs it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Skins all faces of a curve network and joins them into one model.
///
/// 1. The faces are oriented: normals agree across edges, and point outwards from a closed shell.
/// 2. Each face is laid out (RegionLayout) on the curves of its edges, with the same vertices on
///    both sides of an edge, and solved separately. All edges are creases at this stage.
/// 3. Each edge is classified as a crease or a smooth join: as specified (JoinSpec) or, by default,
///    by the angle between the two faces. At a node where the tangents of both sides do not lie in
///    one plane, a smooth join ends as a crease, with a warning.
/// 4. Faces connected by smooth joins are solved together (model/join.h). Mesh edges along the
///    joins are halved until the angles between the normals meet the tolerance. A join on an
///    embedded curve becomes a crease if an angle of more than 0.5° would remain.
/// 5. The model is measured, and its defects are found.
///
/// A face that cannot be skinned is left out of the model (ModelRegion::rejection_reason). Throws
/// InputError if a user specification matches no edge or face; NoSolutionError; CancelledError.
SurfaceModel skin_network(const CurveNetwork& network, const FoundRegions& found,
                          const ModelOptions& options = {}, const Progress& progress = {});

/// Replaces the shape of a model, for example by that of a session, and updates the quality
/// measures and defects.
///
/// `layout`: a layout of the same faces, possibly with finer meshes. `dofs`: the new shape on
/// `layout`. `made`: the faces in the new shape, in the order of `layout`. Joins that `layout`
/// rejects become creases.
void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress = {});

// Fairing of a model without introducing defects.

/// A face that kept its shape in fair_model().
struct UnchangedRegion {
  int region = 0;   ///< index into the faces of FairingResult::layout
  std::string why;  ///< reason why it was not faired, a sentence for the user
};

/// Result of fair_model().
struct FairingResult {
  std::shared_ptr<const ModelLayout> layout;  ///< the initial layout, or a refinement of it
  MinimumVariationSurface surface;            ///< the faired shape; its dofs refer to `layout`
  std::vector<UnchangedRegion> unchanged_regions;
};

/// Fairs a model: minimises the variation of curvature (fair_shape()) subject to the curve
/// constraints of the model.
///
/// `layout`: a layout of the faces of `model`. `start`: dofs of the initial shape on `layout`.
/// `max_join_angle_deg`: largest angle between the normals at smooth joins, degrees. `only`: for
/// each face of the layout, true if the face is to be faired. Faces marked false keep their shape
/// and are not listed in FairingResult::unchanged_regions. Empty: all faces are faired.
///
/// A face keeps its shape if it is inverted, because the curvature of an inverted face is
/// meaningless. A face keeps its shape if fairing would introduce a defect; the remaining faces are
/// then faired again.
///
/// Fairing may increase the angles at smooth joins between the nodes, and the gaps at embedded
/// curves between collocation points. If these errors exceed `max_join_angle_deg` or the tolerance
/// of the curves, triangles are halved, joins on embedded curves are planned again, and fairing
/// continues, at most three times. A refinement that makes the model worse is undone. A face keeps
/// its shape if the finer mesh alone causes a defect in it.
///
/// Throws as fair_shape() does, and NoSolutionError if no face remains to be faired.
FairingResult fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                         const Points& start, double max_join_angle_deg,
                         const MinimumVariationOptions& options = {}, const Progress& progress = {},
                         const std::vector<char>& only = {});

}  // namespace batten
