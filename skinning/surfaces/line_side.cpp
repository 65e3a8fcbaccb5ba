#include "batten/skinning/surfaces/line_side.h"

namespace batten {

std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name) {
  for (const auto& loop : made.boundary)
    for (const BoundarySegment& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const bool embedded = piece.kind == BoundarySegment::Kind::Embedded;
      if ((embedded ? made.embedded[i].line : made.edge_aligned[i].line).name != name) continue;
      const bool against = embedded && made.embedded[i].opposite_to_prescribed;
      return JoinSide{region, embedded, piece.index, piece.reversed == against};
    }
  return std::nullopt;
}

}  // namespace batten
