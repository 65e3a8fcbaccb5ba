// Inside of skin_network(): lays out and solves each region of a network by itself.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/surfaces/layout_candidate.h"
#include "batten/skinning/model/join.h"
#include "batten/skinning/surfaces/orientation.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Makes the layouts and first shapes of all regions of a network.
class RegionMaker {
 public:
  /// Orients the regions, and fills in shells and plans of the model. It keeps references to all
  /// arguments.
  RegionMaker(const CurveNetwork& network, const FoundRegions& found, const ModelOptions& options,
              const Progress& progress, SurfaceModel& model);

  /// Lays out these regions and solves each by itself, on all threads. ModelRegion::rejection_reason says
  /// why one could not be skinned; one that could be before stays as it was then. `from`, `to`:
  /// range of the progress that is reported.
  void lay_out(const std::vector<int>& which, double from, double to);
  /// Turns over the sheets whose first shapes show that their normals point to the wrong side
  /// (normal_side.h), and lays these out again.
  void orient_normals();
  /// Chooses shorter edges for these regions where their elements would not follow the rest shape
  /// within the tolerance (rest_shape_error.h), for the next lay_out(). Nothing where an edge length is stated.
  /// Returns the regions beside arcs that got more vertices.
  std::set<int> refine_for_rest_shapes(std::set<int> regions);
  /// Lays out a region in another way (try_other_domain()). Whether there was one.
  bool lay_out_alternative(int region);
  /// Lays a region out once more without its rest shape. Whether it had one.
  bool lay_out_without_rest_shape(int region);
  /// Leaves a region out after all, for a reason in words.
  void exclude(int region, const std::string& why);
  /// Puts a mesh vertex between any two on this arc, for the next lay_out().
  void halve(int edge);

  ModelMetadata metadata() const;
  /// The layout of each region; null: it could not be skinned.
  const std::vector<std::shared_ptr<const RegionLayout>>& layouts() const { return layouts_; }
  /// Returns the dofs of the shape that each region's own lines make.
  const std::vector<Points>& initial_shapes() const { return initial_shapes_; }
  /// Returns the dofs of the rest shape of each region; no rows: it has none.
  const std::vector<Points>& rest_shapes() const { return rest_shapes_; }
  /// Returns the uses of an arc by regions.
  const std::vector<EdgeUse>& sides(int edge) const { return orientation_.sides[edge]; }
  /// Returns the side by which the region of a use has that arc in its present shape.
  std::optional<JoinSide> side_of(const EdgeUse& use, int edge) const;

 private:
  double edge_of(int region) const;       // as stated
  double element_edge(int region) const;  // and shorter in small regions
  std::shared_ptr<const RegionLayout> plain_layout(int region) const;
  std::set<int> divide_sides(const RegionLayout& layout, const SizeField& sizes);
  void require_memory_for_all() const;
  void distribute_vertices();
  std::vector<CharacterLine> lines_of(const NetworkRegion& plan) const;
  RegionRequest request_of(size_t r) const;
  void lay_out_one(size_t r);
  void take(size_t r, LayoutCandidate candidate);

  const CurveNetwork& network_;
  const ModelOptions& options_;
  const Progress& progress_;
  SurfaceModel& model_;
  double edge_ = 0, tolerance_ = 0;
  Vec3 origin_ = Vec3::Zero();
  Orientation orientation_;
  std::vector<std::shared_ptr<const PrescribedCurve>>
      prescribed_;                                         // by arc: the curve and its vertices
  std::vector<std::optional<LayoutStrategy>> strategies_;  // how each region was laid out
  std::vector<std::shared_ptr<const RegionLayout>> layouts_;
  std::vector<Points> initial_shapes_, rest_shapes_;
  std::vector<std::shared_ptr<const SizeField>> sizes_;  // of each region; null: as usual
};

}  // namespace batten
