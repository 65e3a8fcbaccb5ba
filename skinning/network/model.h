// One model from a network: all regions skinned, joined along their lines, measured.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/network/regions.h"
#include "batten/skinning/quality.h"

namespace batten {

/// The user's word about a line: names are those of arcs, or of lines.
struct JoinWord {
  std::string line;
  bool smooth = false;
  std::string where;  ///< for messages
};

struct ModelOptions {
  std::string name = "model";
  /// Element, edge_length (0: 1/40 of the network's size), alpha and beta as in RegionLayout; its
  /// tolerance is that of embedded lines (0: 1e-4 of the network's size).
  SkinOptions skin;
  SurfaceStiffness material{};
  std::vector<JoinWord> joins;
  /// Lines without a word are smooth where the surfaces that the lines alone make meet at less than
  /// this (ModelJoin::first_deg); degrees.
  double smooth_below_deg = 40;
  /// What smooth joins are driven under, by halving edges along them; degrees.
  double join_tolerance_deg = 0.1;
  int most_join_rounds = 3;
};

/// A line and the regions that meet along it.
struct ModelJoin {
  enum class Kind {
    Rim,       ///< one region
    Crease,    ///< two that share the line
    Smooth,    ///< two that share the line and their tangent planes along it
    Branching  ///< three or more
  };
  int arc = 0;
  std::string line;  ///< the arc's name
  /// Indices into SurfaceModel::regions; one twice where it meets itself.
  std::vector<int> regions;
  Kind kind = Kind::Rim;
  bool asked = false;          ///< the user's word
  std::string why;             ///< why it is a crease although it was to be smooth, or ""
  std::array<bool, 2> open{};  ///< a smooth join is a crease at its start, end: no tangent plane
  /// Angle between normals across it, of lines alone: the mean along it and the mean at its ends,
  /// half and half.
  double first_deg = 0;
  /// Largest angle between normals across it, of the result, sampled between nodes too; and the
  /// same without the edges at ends that are creases.
  double max_deg = 0, max_inside_deg = 0;
  /// Both domains unfold into one plane along it: the surface is C1 across as inside of a region,
  /// to rounding.
  bool one_domain = false;
};

/// What is wrong with a surface that was made.
struct SurfaceFlaw {
  enum class Kind {
    Jacobian,  ///< x_u × x_v vanishes, or turns over against its surroundings
    Fold,      ///< turns by more than 90 degrees inside, or doubles back on a neighbour
    Crossing,  ///< it passes through itself or another region
    Area       ///< more than twice that of a plain hole filling
  };
  Kind kind;
  std::vector<int> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;  ///< ratio (Jacobian, Area), degrees (Fold), number of facets (Crossing)
  std::string text;  ///< a sentence for the user
};

struct ModelRegion {
  NetworkRegion plan;  ///< loops run counter-clockwise seen from the side of the normal
  std::optional<SkinnedRegion> skinned;
  int in_layout = -1;   ///< index into the regions of SurfaceModel::layout, of one that is skinned
  std::string why_not;  ///< why it could not be skinned, or ""
  SkinQuality quality;
  double plain_area = 0;  ///< area of the plain filling of its loops; 0 when there is none
  std::vector<std::string> warnings;
};

/// Regions that hang together along arcs.
struct ModelShell {
  std::vector<int> regions;
  bool closed = false;     ///< every arc has two of them
  bool orientable = true;  ///< normals agree across every arc
  double area = 0;         ///< model units²
  double volume = 0;       ///< enclosed, model units³; 0 unless closed and orientable
};

/// What a network became, in one shape, and what that shape is worth.
struct SurfaceModel {
  /// The layout of the regions that are skinned; null when none is.
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;                       ///< the shape: dofs on the layout
  std::vector<ModelRegion> regions;  ///< all regions, in the order of the plan
  std::vector<ModelJoin> joins;      ///< a join for every arc that has a region, by arc
  std::vector<ModelShell> shells;
  std::vector<SurfaceFlaw> flaws;
  std::vector<std::string> warnings;
  double area = 0;
  double max_join_deg = 0;  ///< largest max_inside_deg of the smooth joins

  std::vector<const SkinnedRegion*> skinned() const;
};

/// Skins all regions of a network.
///
/// 1. Regions get normals that agree across arcs, outwards where a shell is closed.
/// 2. Each is laid out (RegionLayout) on the arcs' own curves, with the same vertices on both
///    sides of an arc, and solved by itself: all lines are creases.
/// 3. Arcs become creases or smooth joins (JoinWord, or the angle found). At a node where the
///    tangents of both sides do not lie in one plane a smooth join ends in a crease, and that is
///    said. One that a region carries embedded and would leave above 2 degrees becomes a crease.
/// 4. Regions that smooth joins connect are solved together (model/seam.h), and halved along joins
///    until these keep the tolerance.
/// 5. What came out is measured, and looked through for flaws.
///
/// A region that cannot be skinned is left out and says why; the others are made all the same.
/// Throws InputError for words that fit nothing, NoSolutionError, CancelledError.
SurfaceModel skin_network(const CharacterLineNetwork& network, const FoundRegions& found,
                          const ModelOptions& options = {}, const Progress& progress = {});

/// Gives a model another shape, that of a session; it is measured and looked through anew.
/// `layout`: with the same regions (their meshes may be finer); `made`: its regions, in order.
/// Joins that were given up on the way become creases.
void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress = {});

/// The flaws of finished regions (wrong_surfaces.cpp), kind after kind as they are found; indices
/// are those of `regions`, null ones are passed over. `plain_areas`: one for each, 0 unknown. Seen
/// on facets, four for each element:
///
///   Jacobian  min_jacobian_ratio of the quality is not above 0;
///   Fold      inside of a region, normals of neighbouring facets differ by more than 90 degrees:
///             nothing that lines ask for is so sharp. Where two regions meet along a line a crease
///             of any angle may be wanted, the 90 degrees of a box as well as a thin rim; what is
///             not is that one lies back on the other. So the wedge between them is measured, 180
///             degrees where they go on in one plane: below 30 along more than a tenth of their
///             common way it is a flaw, whose value is 180 less the sharpest wedge. A knife's edge
///             is named too;
///   Crossing  facets without a common point that pass through each other or overlap in one plane
///             (facet_crossings.h). Near lines that regions share within a gap only, a tenth of an
///             edge is let pass;
///   Area      more than twice `plain_areas`.
///
/// One flaw for each kind and region or pair of regions. O(facets log facets). Throws InputError:
/// counts that differ, and what facets() throws.
std::vector<SurfaceFlaw> find_flaws(const std::vector<const SkinnedRegion*>& regions,
                                    const std::vector<SkinQuality>& qualities,
                                    const std::vector<double>& plain_areas);

}  // namespace batten
