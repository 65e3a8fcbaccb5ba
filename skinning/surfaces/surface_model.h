// One model from a network: all regions skinned, joined along their lines, measured.
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

/// The user's word about a line: names are those of arcs, or of lines.
struct JoinSpec {
  enum class Kind {
    Crease,
    Smooth,     ///< curvature goes on or not, as the lines say: is_curvature_continuous()
    Tangent,    ///< smooth, and curvature may jump
    Curvature,  ///< smooth, and fairing lets curvature go on
  };
  std::string line;
  Kind kind = Kind::Crease;
  std::string where;  ///< for messages
};

/// How a model is made of a network.
struct ModelOptions {
  std::string name = "model";
  /// Element, edge_length (0: 1/40 of the network's size, 1/20 where there is one region), alpha and
  /// beta as in RegionLayout; its tolerance is that of embedded lines (0: 1e-4 of the network's size).
  SkinOptions skin;
  SurfaceStiffness material{};
  std::vector<JoinSpec> joins;
  /// Lines without a word are smooth where the surfaces that the lines alone make meet at less than
  /// this (ModelJoin::initial_deg); degrees.
  double crease_angle_deg = 25;
  /// Edges along smooth joins are halved until the angle between the normals is below this;
  /// degrees.
  double join_tolerance_deg = 0.1;
  int max_join_rounds = 3;  ///< of such halving
  bool rest = true;         ///< ModelMetadata::rest
};

/// A line and the regions that meet along it.
struct ModelJoin {
  enum class Kind {
    FreeEdge,    ///< one region
    Crease,      ///< two that share the line
    Smooth,      ///< two that share the line and their tangent planes along it
    NonManifold  ///< three or more
  };
  int edge = 0;
  std::string line;  ///< the arc's name
  /// Indices into SurfaceModel::regions; a region that meets itself is there twice.
  std::vector<int> regions;
  Kind kind = Kind::FreeEdge;
  bool requested = false;  ///< the user's word
  std::string why;         ///< why it is a crease although it was to be smooth, or ""
  /// A smooth join is a crease at its start, end: no tangent plane, or JoinEnd::creased.
  std::array<bool, 2> open{};
  /// Angle between the normals of the first shapes, those of each region's lines alone: 0.4 of that
  /// at either end where lines fix both planes, the rest of the mean along the line; averaged over
  /// lines that go on straight.
  double initial_deg = 0;
  /// Largest angle between the normals of the result, sampled between nodes too; and the same
  /// without the edges at ends that are creases.
  double max_deg = 0, max_inside_deg = 0;
  bool curvature = false;  ///< of a smooth one: fairing lets curvature go on across it
  /// As in JoinQuality, of creases and smooth joins: model units, 1/length.
  double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
  /// Both domains unfold into one plane along it: the surface is C1 across it to rounding, as
  /// inside of a region.
  bool one_domain = false;
};

/// What is wrong with a surface that was made.
struct SurfaceDefect {
  enum class Kind {
    Jacobian,  ///< x_u × x_v vanishes, or turns over against its surroundings
    Fold,      ///< turns by more than 120 degrees inside, or doubles back on a neighbour
    Crossing,  ///< it passes through itself or another region
    Area       ///< more than twice that of a plain hole filling
  };
  Kind kind;
  std::vector<int> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;  ///< ratio (Jacobian, Area), degrees (Fold), number of facets (Crossing)
  std::string text;  ///< a sentence for the user
};

/// A region of the network, and the surface that it got.
struct ModelRegion {
  NetworkRegion plan;  ///< loops run counter-clockwise seen from the side of the normal
  std::optional<SkinnedRegion> skinned;
  int layout_index =
      -1;  ///< index into the regions of SurfaceModel::layout, of one that is skinned
  std::string rejection_reason;  ///< why it could not be skinned, or ""
  SkinQuality quality;
  FittedPrimitive shape;    ///< what the finished surface is, within primitive_tolerance()
  double filling_area = 0;  ///< area of the plain filling of its loops; 0 when there is none
  std::vector<std::string> warnings;
};

/// Regions that are connected along arcs.
struct ModelShell {
  std::vector<int> regions;
  bool closed = false;     ///< every arc has two of them
  bool orientable = true;  ///< normals agree across every arc
  double area = 0;         ///< model units²
  double volume = 0;       ///< enclosed, model units³; 0 unless closed and orientable
  NormalSide normals;      ///< where its normals point; of an orientable one
};

/// What a network became, in one shape, and what that shape is worth.
struct SurfaceModel {
  /// The layout of the regions that are skinned; null when none is.
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;                       ///< the shape: dofs on the layout
  std::vector<ModelRegion> regions;  ///< all regions, in the order of the plan
  std::vector<ModelJoin> joins;      ///< a join for every arc that has a region, by arc
  std::vector<ModelShell> shells;
  std::vector<SurfaceDefect> defects;
  std::vector<std::string> warnings;
  double area = 0;
  double max_join_deg = 0;  ///< largest max_inside_deg of the smooth joins

  std::vector<const SkinnedRegion*> skinned() const;  ///< of those regions that are skinned
};

}  // namespace batten
