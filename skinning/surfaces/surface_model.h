// The surface model of a network: skinned regions, joins, shells, defects and measurements.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/search/regions.h"
#include "batten/skinning/surfaces/fitted_primitive.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {

/// User specification of the continuity across a line. Names are those of edges, or of input
/// curves.
struct JoinSpec {
  enum class Kind {
    /// G0 continuity: the surfaces share the line only.
    Crease,
    Smooth,     ///< G1; G2 if is_curvature_continuous() finds that the lines allow it
    Tangent,    ///< G1: curvature may jump
    Curvature,  ///< G1, and G2 after fairing
  };
  std::string line;
  Kind kind = Kind::Crease;
  std::string where;  ///< prefix for messages
};

/// Options for skin_network().
struct ModelOptions {
  std::string name = "model";
  /// Options of RegionLayout. Only these fields are used: element; edge_length (0: 1/40 of the
  /// network size, 1/20 if there is only one region); alpha and beta; tolerance, the largest distance
  /// of the surface from embedded lines (0: 1e-4 of the network size).
  SkinOptions skin;
  SurfaceStiffness material{};
  std::vector<JoinSpec> joins;
  /// Crease angle in degrees: lines without a specification are smooth if the initial surfaces meet
  /// at less than this (ModelJoin::initial_deg).
  double crease_angle_deg = 25;
  /// Tolerance of smooth joins in degrees: mesh edges along them are halved until the angle between
  /// the normals is below this.
  double join_tolerance_deg = 0.1;
  int max_join_rounds = 3;  ///< largest number of such refinement rounds
  bool rest = true;         ///< use rest shapes (ModelMetadata::rest)
};

/// A network edge and the regions that meet at it.
struct ModelJoin {
  enum class Kind {
    FreeEdge,    ///< free (boundary) edge: one region
    Crease,      ///< G0: two regions share the edge
    Smooth,      ///< G1: two regions share the edge and their tangent planes along it
    NonManifold  ///< three or more regions
  };
  /// Index of the network edge.
  int edge = 0;
  std::string line;  ///< name of the edge
  /// Indices into SurfaceModel::regions. A region that meets itself at the edge is listed twice.
  std::vector<int> regions;
  Kind kind = Kind::FreeEdge;
  bool requested = false;  ///< specified by the user
  std::string why;         ///< why it is a crease although smooth was intended, or ""
  /// For each end: a smooth join that ends as a crease, because there is no tangent plane, or by
  /// JoinEnd::creased.
  std::array<bool, 2> open{};
  /// Angle between the normals of the initial shapes (those of each region's lines alone), degrees.
  /// Weighted mean: 0.4 for each end at which the lines fix both tangent planes, the rest for the
  /// mean along the line. Averaged over edges that continue each other smoothly.
  double initial_deg = 0;
  /// Largest angle between the normals of the result, degrees, sampled between nodes too; and the
  /// same without the mesh edges at ends that are creases.
  double max_deg = 0, max_inside_deg = 0;
  bool curvature = false;  ///< smooth join across which fairing makes the curvature continuous (G2)
  /// See JoinQuality; for creases and smooth joins. Gap in model units, curvatures in 1/length.
  double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
  /// Both domains unfold into one plane across the edge: the surface is C1 there up to rounding, as
  /// inside a region.
  bool one_domain = false;
};

/// A defect of a finished surface.
struct SurfaceDefect {
  enum class Kind {
    Jacobian,  ///< |x_u × x_v| vanishes, or the surface is locally inverted
    Fold,      ///< folded by more than 120° inside a region, or back onto a neighbour
    Crossing,  ///< intersects itself or another region
    Area       ///< more than twice the area of the hole-filling triangulation
  };
  Kind kind;
  /// Indices of the regions involved.
  std::vector<int> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;  ///< ratio (Jacobian, Area), degrees (Fold), number of facet pairs (Crossing)
  std::string text;  ///< a sentence for the user
};

/// A region of the network and its surface.
struct ModelRegion {
  NetworkRegion plan;  ///< loops are counter-clockwise as seen from the normal side
  /// The surface; empty if the region could not be skinned.
  std::optional<SkinnedRegion> skinned;
  int layout_index = -1;  ///< index into the regions of SurfaceModel::layout; -1: not skinned
  std::string rejection_reason;  ///< why it could not be skinned, or ""
  SkinQuality quality;
  FittedPrimitive shape;    ///< primitive that fits the surface within primitive_tolerance()
  double filling_area = 0;  ///< area of the hole-filling triangulation of its loops; 0: none
  std::vector<std::string> warnings;
};

/// A connected component of the model: faces that are joined by shared edges.
struct ModelShell {
  std::vector<int> regions;
  bool closed = false;     ///< every edge has two faces
  bool orientable = true;  ///< normals agree across every edge
  double area = 0;         ///< model units²
  double volume = 0;       ///< enclosed volume, model units³; 0 unless closed and orientable
  NormalSide normals;      ///< direction of the normals, if orientable
};

/// The surface model of a network in one shape, with its measured quality.
struct SurfaceModel {
  /// Layout of the skinned regions; null if there are none.
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;                       ///< dofs of the shape on `layout`
  std::vector<ModelRegion> regions;  ///< all regions, in the order of FoundRegions
  std::vector<ModelJoin> joins;  ///< one per network edge that has a region, in the order of edges
  std::vector<ModelShell> shells;
  std::vector<SurfaceDefect> defects;
  std::vector<std::string> warnings;
  double area = 0;
  double max_join_deg = 0;  ///< largest max_inside_deg of all smooth joins, degrees

  std::vector<const SkinnedRegion*> skinned() const;  ///< the regions that are skinned, in order
};

}  // namespace batten
