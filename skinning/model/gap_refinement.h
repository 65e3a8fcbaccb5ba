// Refinement of a model whose solved surface misses its embedded curves.
#pragma once

#include <vector>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The largest gap between faces and their embedded curves (line_gap()), model units; 0 without
/// embedded curves.
double max_line_gap(const std::vector<SkinnedRegion>& regions);

/// Bisects triangles where loads and constraints pull a surface off its embedded curves:
///
///     GapRefinement refinement(layout);
///     do regions = solve(layout);
///     while (refinement.bisect(layout, regions));
///
/// It ends when the gaps are within 0.7 of the model's tolerance, after eight rounds, or before the
/// model has more than 20,000 triangles and four times as many as at first. The remaining 0.3 of
/// the tolerance are left to the deviation of the fitted curves from the given ones.
class GapRefinement {
 public:
  /// `layout`: the model before the first round.
  explicit GapRefinement(const ModelLayout& layout);

  /// Bisects the triangles of `layout` with gaps above half of the tolerance. Returns false, and
  /// leaves the layout unchanged, if the refinement ends. `regions`: the faces of the solved shape
  /// on `layout`, in order. O(triangles + samples of embedded curves).
  bool bisect(ModelLayout& layout, const std::vector<SkinnedRegion>& regions);

  /// True after the last round: bisect() will return false.
  bool exhausted() const { return rounds_ == kMaxRounds; }

 private:
  static constexpr int kMaxRounds = 8;
  int max_triangles_, rounds_ = 0;
};

}  // namespace batten
