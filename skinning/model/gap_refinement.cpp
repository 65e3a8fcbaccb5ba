#include "batten/skinning/model/gap_refinement.h"

#include <algorithm>

namespace batten {

double max_line_gap(const std::vector<SkinnedRegion>& regions) {
  double gap = 0;
  for (const SkinnedRegion& region : regions)
    for (const EmbeddedLine& line : region.embedded)
      gap = std::max(gap, line_gap(region.surface, line));
  return gap;
}

GapRefinement::GapRefinement(const ModelLayout& layout) {
  constexpr int usual = 20'000, times = 4;
  max_triangles_ = std::max(usual, times * layout.mesh()->triangle_count());
}

bool GapRefinement::bisect(ModelLayout& layout, const std::vector<SkinnedRegion>& regions) {
  // The rest of the tolerance is left to the deviation of curves from the given ones.
  constexpr double max_gap = 0.7;  // of the tolerance
  if (exhausted() || max_line_gap(regions) <= max_gap * layout.tolerance()) return false;
  std::vector<char> marks(static_cast<size_t>(layout.mesh()->triangle_count()), 0);
  for (size_t r = 0; r < regions.size(); ++r)
    mark_gaps(regions[r], 0.5 * layout.tolerance(),
              marks.data() + layout.first_triangle(static_cast<int>(r)));
  const auto more = std::count(marks.begin(), marks.end(), 1);
  if (layout.mesh()->triangle_count() + more > max_triangles_ || !layout.refine(marks))
    return false;
  ++rounds_;
  return true;
}

}  // namespace batten
