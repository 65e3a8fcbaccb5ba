// Lays out one region of a network in one way after the other, until its surface has no flaw.
//
// What its lines ask for is tried first. Where that fails, turns over, folds, passes through itself
// or sags, the same lines are tried on the other domains, on a finer mesh, and then without inner
// lines; each that turns over, folds or passes through itself without the rest shape, too. The trial
// with the least of these evils stays:
//
//     evil = 4 [turns over] + 2 [folds] + 2 [passes through itself] + 1 [area > 2 plain fillings]
//            + 1 [Jacobian < 0.05 of the median] + 1 [misses its lines] + 1 [without inner lines]
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// The region as it is asked for.
struct RegionRequest {
  std::string name;
  std::vector<CharacterLine> lines;  ///< the inner ones last
  int inner = 0;                     ///< how many of them are inner lines
  SkinOptions skin;                  ///< `domain`: the first to be tried
  double filling_area = 0;           ///< of a plain filling; 0: unknown
  int max_triangles = 8'000;         ///< of all trials but the first, about
  Progress progress{};               ///< asked whether to go on, by several threads at once
};

/// How a region was laid out.
struct LayoutStrategy {
  SkinOptions skin;
  bool inner = true;     ///< whether with its inner lines
  int defect_score = 0;  ///< of the trial
};

/// A region that could be laid out, in the shape that its own lines make.
struct LayoutCandidate {
  std::shared_ptr<const RegionLayout> layout;
  Points rest;  ///< what its boundary means (rest_shape.h); no rows: nothing
  Points shape;
  LayoutStrategy strategy;
  std::vector<std::string> warnings;  ///< what was tried before, and why it did not serve
};

/// Returns the first trial without a flaw, or else the one with the least evil; of equals the
/// first. At most twenty trials, and none but the usual ones once these made max_triangles and one of
/// them could be made; each as long as a RegionLayout, one solve and find_defects(); one where the
/// first is well. Throws what the first trial threw when all fail.
LayoutCandidate best_layout(const RegionRequest& request, const ModelMetadata& metadata,
                            const SurfaceStiffness& material);

/// Lays the region out in a way that was taken before, without a shape. Throws what RegionLayout throws.
std::shared_ptr<const RegionLayout> lay_out(const RegionRequest& request,
                                            const LayoutStrategy& strategy);

/// Lays the region out once more, its lines cut at other places, in the way that was taken before.
/// Returns nothing where that has come to more evil than it had. Throws what RegionLayout and the
/// solve throw.
std::optional<LayoutCandidate> retry_layout(const RegionRequest& request,
                                            const LayoutStrategy& strategy,
                                            const ModelMetadata& metadata,
                                            const SurfaceStiffness& material);

/// Lays a region out whose shape is spoiled where it goes on in its neighbours: on a plane, or as a
/// sheet, where it was a polygon; as a sheet, where it was on a plane. Returns the first of these
/// that has no flaw by itself, or nothing; nothing for a domain that was asked for.
std::optional<LayoutCandidate> try_other_domain(const RegionRequest& request,
                                                SkinOptions::Domain was,
                                                const ModelMetadata& metadata,
                                                const SurfaceStiffness& material);

/// Whether the Jacobian of a finished region falls below 0.05 of the median, or its area is more
/// than twice that of a plain filling (0: unknown). O(triangles).
bool is_inverted_or_sagging(const SkinnedRegion& region, double filling_area);

}  // namespace batten
