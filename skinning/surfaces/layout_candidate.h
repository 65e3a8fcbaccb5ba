// SPDX-License-Identifier: MPL-2.0
// Selects the parameter domain and mesh of one region by trying several candidates.
//
// The default layout for the region's lines is tried first. If its surface fails, is inverted,
// folds, intersects itself or sags, other candidates follow: the other domains, a finer mesh, and
// finally without inner lines. Each that is inverted, folds or intersects itself is also tried
// without the rest shape. The candidate with the lowest defect score is taken:
//
//    score = 4 [inverted] + 2 [folds] + 2 [intersects itself] + 1 [area > 2 × expected area]
//            + 1 [Jacobian < 0.05 of the median] + 1 [misses its lines] + 1 [without inner lines]
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// The region to lay out.
struct RegionRequest {
  std::string name;
  std::vector<CharacterLine> lines;  ///< all lines, inner ones last
  int inner = 0;                     ///< number of inner lines
  SkinOptions skin;                  ///< `domain`: the first one to try
  double filling_area = 0;           ///< area of the hole-filling triangulation; 0: unknown
  int max_triangles = 8'000;         ///< approximate budget for all candidates but the first
};

/// Options with which a region was laid out.
struct LayoutStrategy {
  SkinOptions skin;
  bool inner = true;     ///< laid out with its inner lines
  int defect_score = 0;  ///< defect score of the candidate, 0: none
};

/// The layout of a region and its initial shape, which depends only on the region's own lines.
struct LayoutCandidate {
  std::shared_ptr<const RegionLayout> layout;
  Points rest;  ///< dofs of the rest shape (model_shapes.h); no rows: none
  /// Dofs of the initial shape.
  Points shape;
  LayoutStrategy strategy;
  /// Which candidates were tried before, and why they were not taken.
  std::vector<std::string> warnings;
  /// Area of the hole-filling triangulation or, if it is larger, of a reliable rest shape
  /// (reliable_rest_area()): the nose of a wing between two guides has several times the area of
  /// the web between its curves. 0: unknown.
  double expected_area = 0;
};

/// Selects the best layout: the first candidate without defects, otherwise the one with the lowest
/// defect score (ties: first).
///
/// Cost: at most twenty candidates, but only the default one if it has no defects. No further
/// candidates are tried once they have used up `max_triangles` and one of them succeeded. Each
/// costs a RegionLayout, one solve and find_defects(). If all candidates fail, throws the exception
/// of the first one.
LayoutCandidate best_layout(const RegionRequest& request, const ModelMetadata& metadata,
                            const SurfaceStiffness& material);

/// Lays out a region with known options, without computing a shape. Throws as RegionLayout does.
std::shared_ptr<const RegionLayout> lay_out(const RegionRequest& request,
                                            const LayoutStrategy& strategy);

/// Lays out a region again with known options, after its edges got other vertices. Returns nothing
/// if the defect score increased. Throws as RegionLayout and the solver do.
std::optional<LayoutCandidate> retry_layout(const RegionRequest& request,
                                            const LayoutStrategy& strategy,
                                            const ModelMetadata& metadata,
                                            const SurfaceStiffness& material);

/// Tries other domains for a region that is inverted or sags when it is solved together with its
/// neighbours.
///
/// Tries a projected, then a developable domain if it had a polygonal one, and a developable one if
/// it had a projected one. Returns the first candidate without defects of its own; nothing if there
/// is none, or if the user has specified the domain. `was`: present domain.
std::optional<LayoutCandidate> try_other_domain(const RegionRequest& request,
                                                SkinOptions::Domain was,
                                                const ModelMetadata& metadata,
                                                const SurfaceStiffness& material);

/// True if the Jacobian of a finished region falls below 0.05 of the median, or if its area is more
/// than twice `expected_area` (LayoutCandidate::expected_area; 0: unknown). Cost: O(triangles).
bool is_inverted_or_sagging(const SkinnedRegion& region, double expected_area);

}  // namespace batten
