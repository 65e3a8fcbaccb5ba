#include "batten/skinning/region/skinned_region.h"

#include "batten/core/errors.h"

namespace batten {

HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve& curve = piece.kind == BoundarySegment::Kind::EdgeAligned
                                  ? region.edge_aligned.at(i).fitted
                                  : region.embedded.at(i).fitted;
  return piece.reversed ? curve.backwards() : curve;
}

HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line) {
  const Vec2 from = mesh.vertices()[aligned_line.vertices.front()],
             along = mesh.chain_vector(aligned_line.vertices), to = from + along,
             slope = along / (aligned_line.fitted.end() - aligned_line.fitted.start());
  Points x(2, 3), d(2, 3);
  x << from.x(), from.y(), 0, to.x(), to.y(), 0;
  d << slope.x(), slope.y(), 0, slope.x(), slope.y(), 0;
  return {{aligned_line.fitted.start(), aligned_line.fitted.end()}, x, d};
}

HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve pcurve =
      piece.kind == BoundarySegment::Kind::Embedded
          ? region.embedded.at(i).pcurve
          : edge_aligned_pcurve(region.surface.mesh(), region.edge_aligned.at(i));
  return piece.reversed ? pcurve.backwards() : pcurve;
}

DomainLoops boundary_loops(const SkinnedRegion& region) {
  std::vector<DomainLoops::Loop> loops;
  for (const auto& segments : region.boundary) {
    DomainLoops::Loop loop;
    for (const BoundarySegment& piece : segments) loop.push_back(boundary_pcurve(region, piece));
    loops.push_back(std::move(loop));
  }
  return DomainLoops(std::move(loops));
}

}  // namespace batten
