// SPDX-License-Identifier: MPL-2.0
// Lays out and solves each region of a network on its own; the first stage of skin_network().
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/model/join.h"
#include "batten/skinning/surfaces/layout_candidate.h"
#include "batten/skinning/surfaces/orientation.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Makes the layouts and initial shapes of all regions of a network.
class RegionMaker {
 public:
  /// Orients the regions and sets the shells and plans of `model`. Keeps references to all
  /// arguments.
  RegionMaker(const CurveNetwork& network, const FoundRegions& found, const ModelOptions& options,
              const Progress& progress, SurfaceModel& model);

  /// Lays out the given regions and solves each on its own, in parallel.
  ///
  /// ModelRegion::rejection_reason explains why a region could not be skinned. If a region was laid
  /// out before and now fails, it keeps its previous layout. `from`, `to`: range of the reported
  /// progress, 0 to 1.
  void lay_out(const std::vector<int>& which, double from, double to);
  /// Reverses the patches whose initial shapes show that their normals point to the wrong side
  /// (normal_side.h), and lays them out again.
  void orient_normals();
  /// Shortens the target edge lengths of regions whose elements do not resolve the rest shape
  /// within the tolerance (rest_shape_error.h), for the next lay_out(). Does nothing if the user
  /// has specified an edge length. Returns the regions next to edges that got more vertices.
  std::set<int> refine_for_rest_shapes(std::set<int> regions);
  /// Lays out a region on another domain (try_other_domain()). Returns false if there is none.
  bool lay_out_alternative(int region);
  /// Lays out a region again without its rest shape. Returns false if it had none.
  bool lay_out_without_rest_shape(int region);
  /// Lays out a region again without its rest shape if that reduces `misfit` to less than 0.8 of
  /// its value. For a region with two corners, twice the value suffices: the sweep between its two
  /// sides is singular at the corners, where its elements cannot follow given tangent planes.
  /// Returns true if the rest shape was dropped.
  bool drop_rest_shape_if_better(int region,
                                 const std::function<double(const SkinnedRegion&)>& misfit);
  /// Excludes a region afterwards; `why` becomes its rejection reason.
  void exclude(int region, const std::string& why);
  /// Bisects the vertex spacing of a network edge, for the next lay_out().
  void halve(int edge);

  ModelMetadata metadata() const;
  /// Layout of each region; null: it could not be skinned.
  const std::vector<std::shared_ptr<const RegionLayout>>& layouts() const { return layouts_; }
  /// Dofs of the initial shape of each region, which depends only on its own lines.
  const std::vector<Points>& initial_shapes() const { return initial_shapes_; }
  /// Dofs of the rest shape of each region; no rows: none.
  const std::vector<Points>& rest_shapes() const { return rest_shapes_; }
  /// Uses of a network edge by regions.
  const std::vector<EdgeUse>& sides(int edge) const { return orientation_.sides[edge]; }
  /// The C1 cubic curve of a network edge; null if no face uses the edge.
  const std::shared_ptr<const PrescribedCurve>& prescribed(int edge) const {
    return prescribed_[edge];
  }
  /// Side of the edge in the current shape of the region that uses it; empty if the region does not
  /// have the edge on its boundary.
  std::optional<JoinSide> side_of(const EdgeUse& use, int edge) const;

 private:
  double edge_of(int region) const;       // target edge length as specified
  double element_edge(int region) const;  // the same, shorter in small regions
  std::shared_ptr<const RegionLayout> plain_layout(int region) const;
  std::set<int> divide_sides(const RegionLayout& layout, const SizeField& sizes);
  void require_memory_for_all() const;
  void distribute_vertices();
  std::vector<CharacterLine> lines_of(const NetworkRegion& plan) const;
  RegionRequest request_of(size_t r) const;
  void lay_out_one(size_t r);
  void try_as_hole(size_t r, LayoutCandidate& annulus);
  void take(size_t r, LayoutCandidate candidate);

  const CurveNetwork& network_;
  const ModelOptions& options_;
  const Progress& progress_;
  SurfaceModel& model_;
  double edge_ = 0, tolerance_ = 0;
  Vec3 origin_ = Vec3::Zero();
  Orientation orientation_;
  std::vector<std::shared_ptr<const PrescribedCurve>>
      prescribed_;  // curve and vertices of each network edge
  // Options with which each region was laid out.
  std::vector<std::optional<LayoutStrategy>> strategies_;
  std::vector<std::shared_ptr<const RegionLayout>> layouts_;
  std::vector<Points> initial_shapes_, rest_shapes_;
  std::vector<std::shared_ptr<const SizeField>> sizes_;  // for each region; null: default sizes
};

}  // namespace batten
