// SPDX-License-Identifier: MPL-2.0
// The surface model of a network: skinned faces, joins, shells, defects and measurements, and its
// curves as splines.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curves/bspline.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/neighbour_edge.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/search/regions.h"
#include "batten/skinning/surfaces/fitted_primitive.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {

class CurveNetwork;  // skinning/network/curve_network.h

/// User specification of the continuity of surfaces across the edge or input curve called `line`.
struct JoinSpec {
  enum class Kind {
    /// G0 continuity: the surfaces share only positions along the curve.
    Crease,
    Smooth,     ///< G1; fairing makes it G2 if is_curvature_continuous()
    Tangent,    ///< G1: tangent planes agree; the curvature may jump
    Curvature,  ///< G1; fairing makes it G2 (continuous curvature)
  };
  std::string line;
  Kind kind = Kind::Crease;
  std::string where;  ///< prefix of error messages, such as "scene.toml:8:1: "
};

/// Options for skin_network().
struct ModelOptions {
  std::string name = "model";
  /// Options for the layout of each face (RegionLayout). Only these fields are used: element;
  /// edge_length (0: 1/40 of the network size, 1/20 if there is only one face); tolerance, the
  /// largest distance of the surface from embedded curves (0: 1e-4 of the network size).
  SkinOptions skin;
  SurfaceStiffness material{};
  std::vector<JoinSpec> joins;
  /// Crease angle, degrees: an edge without a JoinSpec is smooth if the initial surfaces meet at a
  /// smaller angle (ModelJoin::initial_deg).
  double crease_angle_deg = 25;
  /// Tolerance of smooth joins, degrees: mesh edges along a smooth join are halved until the angle
  /// between the normals of the two faces is smaller.
  double join_tolerance_deg = 0.1;
  /// Edges of given surfaces. A free edge of the model that lies on one of them is joined to the
  /// given surface: as its JoinSpec or NeighbourCurve::continuity states, or else smoothly (G1). By
  /// default, it is a crease if, at one of its ends that are corners, the plane of the two curves
  /// differs from the given tangent plane by `crease_angle_deg` or more; an edge without corners, if
  /// the initial face meets the given surface at the angle θ of `neighbour_crease_angle_deg` or more,
  /// unless the curvature of the given surface closes the opening: θ < 85 degrees, and the mean of
  /// κ · (c - x) exceeds ½ sin² θ, which is sin² θ for a sphere and 0 for a cylinder (x: the points
  /// of the edge, c: the mean of the points of the opening, κ: NeighbourSample::curvature).
  std::vector<NeighbourCurve> neighbours;
  /// Crease angle, degrees, at edges of given surfaces without corners. It is larger than
  /// crease_angle_deg, because the initial face does not know the given surface.
  double neighbour_crease_angle_deg = 60;
  /// Largest distance between an edge and the edge of its given surface, model units; 0: the
  /// tolerance of gaps in the network.
  double neighbour_tolerance = 0;
  int max_join_rounds = 3;  ///< largest number of refinement rounds along smooth joins
  bool rest = true;         ///< true: rest shapes; false: flat rest state
};

/// An edge of the curve network, and the faces that meet at this edge.
struct ModelJoin {
  enum class Kind {
    FreeEdge,  ///< free (boundary) edge: one face
    Crease,    ///< G0: two faces share the edge
    /// G1: two faces share the edge and have the same tangent planes there, or one face has those
    /// of a given surface.
    Smooth,
    NonManifold  ///< three or more faces share the edge
  };
  /// Index into CurveNetwork::edges().
  int edge = 0;
  std::string line;  ///< name of the edge
  /// Indices into SurfaceModel::regions. A face that meets itself at the edge is listed twice.
  std::vector<int> regions;
  Kind kind = Kind::FreeEdge;
  /// The given surface at this edge, or null. `regions` then has one entry.
  std::shared_ptr<const NeighbourEdge> neighbour = {};
  bool requested = false;  ///< true: the user specified `kind` by a JoinSpec
  /// Reason why an edge that was planned as a smooth join became a crease; "" if it did not.
  std::string why;
  /// For the start and the end of a smooth join: true if the join ends as a crease there, for want
  /// of a common tangent plane or because refinement could not make the faces tangent.
  std::array<bool, 2> open{};
  /// Angle between the normals of the faces at the edge in their initial shapes (each face solved
  /// separately), degrees. It is a weighted mean: each end at which the curves determine both
  /// tangent planes has the weight 0.4, and the mean along the edge has the remaining weight. Edges
  /// that continue each other smoothly get a common value, the average.
  double initial_deg = 0;
  /// Largest angle between the normals of the two faces in the solved shape, degrees.
  /// max_inside_deg excludes the mesh edges at ends at which a smooth join ends as a crease.
  double max_deg = 0, max_inside_deg = 0;
  bool curvature = false;  ///< true: fairing makes the curvature continuous (G2) across the edge
  /// Largest gap between two faces at the edge (model units), and jumps between them of the normal
  /// curvature perpendicular to the edge (1/length): median and maximum. Measured for creases and
  /// smooth joins.
  double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
  /// Mean angle along the edge, degrees; measured for creases and smooth joins.
  double mean_deg = 0;
  /// True if the domains of both faces unfold into one plane across the edge. The surface is then
  /// C1 across the edge up to rounding, as it is inside a face.
  bool one_domain = false;
};

/// A defect of a finished surface.
struct SurfaceDefect {
  enum class Kind {
    Jacobian,  ///< the normal vanishes, or the surface is inverted locally
    Fold,      ///< folded by more than 120° inside a face, or back onto a neighbour
    Crossing,  ///< the face intersects itself or another face
    Area       ///< the area is more than twice that of the hole-filling triangulation
  };
  Kind kind;
  /// Indices of the faces involved.
  std::vector<int> regions;
  Vec3 where = Vec3::Zero();
  /// Measured value: Jacobian relative to the median; angle of the fold in degrees; number of
  /// intersecting pairs of facets; area relative to the hole-filling triangulation.
  double value = 0;
  std::string text;  ///< description of the defect, as a sentence for the user
};

/// A face of the curve network and its surface.
struct ModelRegion {
  /// The face as found in the curve network. Its loops are counter-clockwise seen from the tip of
  /// the normal.
  NetworkRegion plan;
  /// The surface; empty if the face could not be skinned.
  std::optional<SkinnedRegion> skinned;
  int layout_index = -1;  ///< index into the faces of SurfaceModel::layout; -1: not skinned
  /// Reason why the face could not be skinned, or "".
  std::string rejection_reason;
  SkinQuality quality;
  FittedPrimitive shape;  ///< plane, cylinder, … that fits the surface, if any
  /// Area of the hole-filling triangulation of the loops, model units²; 0: no triangulation.
  double filling_area = 0;
  double expected_area =
      0;  ///< LayoutCandidate::expected_area; more than twice as much is a defect
  std::vector<std::string> warnings;
};

/// A connected component of the model: faces that are joined by shared edges.
struct ModelShell {
  std::vector<int> regions;
  bool closed = false;     ///< true: every edge of the shell is shared by two faces
  bool orientable = true;  ///< true: the normals of faces agree across every edge
  double area = 0;         ///< total area of the faces, model units²
  double volume = 0;       ///< enclosed volume, model units³; 0 unless closed and orientable
  NormalSide normals;      ///< direction of the normals; valid only if `orientable`
};

/// Signed volume between a point and a face, ⅓ ∬ (x - apex)·(x_u × x_v) du dv. The sum over the
/// faces of a closed shell is its volume, for any apex; one close to the shell reduces rounding.
double cone_volume(const SkinnedRegion& face, const Vec3& apex);

/// The surface model of a curve network: faces in one shape, their joins, and their quality.
struct SurfaceModel {
  /// Layout of the skinned faces; null if no face is skinned.
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;                       ///< dofs of the shape on `layout`
  std::vector<ModelRegion> regions;  ///< all faces, in the order of FoundRegions
  std::vector<ModelJoin> joins;      ///< one per network edge with a face, in edge order
  std::vector<ModelShell> shells;
  std::vector<SurfaceDefect> defects;
  std::vector<std::string> warnings;
  double area = 0;
  double max_join_deg = 0;  ///< largest angle at smooth joins (max_inside_deg), degrees

  std::vector<const SkinnedRegion*> skinned() const;  ///< skinned faces, in the order of `regions`
};

/// The curves of a model as named C1 cubic splines, as they run on its faces in their present
/// shape. Curves of the network that belong to no face keep their position in the network.
///
/// Edges into which a curve of the network was split are merged if they continue in the same
/// direction (within 1e-6 rad); their parameters are scaled to make the derivatives equal. A curve
/// with corners, or one that shares an edge with another curve, gives several splines named after
/// its edges: NAME.1-3, NAME.4. The splines of a model without a network are NAME.1, NAME.2, …
///
/// `network`: the network that the model was built from, or null for a model of a single face.
/// O(segments · log curves).
std::vector<CubicSpline> model_curves(const SurfaceModel& model, const CurveNetwork* network);

}  // namespace batten
