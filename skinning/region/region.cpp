#include "batten/skinning/region/region.h"

#include "batten/core/errors.h"

namespace batten {

HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundaryPiece& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve& curve = piece.kind == BoundaryPiece::Kind::Run ? region.runs.at(i).fitted
                                                                     : region.embedded.at(i).fitted;
  return piece.reversed ? curve.backwards() : curve;
}

HermiteCurve run_image(const ParametricMesh& mesh, const LineRun& run) {
  const Vec2 from = mesh.vertices()[run.vertices.front()], along = mesh.displacement(run.vertices),
             to = from + along, slope = along / (run.fitted.end() - run.fitted.start());
  Points x(2, 3), d(2, 3);
  x << from.x(), from.y(), 0, to.x(), to.y(), 0;
  d << slope.x(), slope.y(), 0, slope.x(), slope.y(), 0;
  return {{run.fitted.start(), run.fitted.end()}, x, d};
}

HermiteCurve boundary_image(const SkinnedRegion& region, const BoundaryPiece& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve image = piece.kind == BoundaryPiece::Kind::Embedded
                                 ? region.embedded.at(i).image
                                 : run_image(region.surface.mesh(), region.runs.at(i));
  return piece.reversed ? image.backwards() : image;
}

DomainLoops boundary_loops(const SkinnedRegion& region) {
  std::vector<DomainLoops::Loop> loops;
  for (const auto& pieces : region.boundary) {
    DomainLoops::Loop loop;
    for (const BoundaryPiece& piece : pieces) loop.push_back(boundary_image(region, piece));
    loops.push_back(std::move(loop));
  }
  return DomainLoops(std::move(loops));
}

}  // namespace batten
