#include "batten/skinning/region.h"

#include "batten/core/errors.h"

namespace batten {

HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundaryPiece& piece) {
  const auto i = static_cast<size_t>(piece.index);
  const HermiteCurve& curve = piece.kind == BoundaryPiece::Kind::Run ? region.runs.at(i).fitted
                                                                     : region.embedded.at(i).fitted;
  return piece.reversed ? curve.backwards() : curve;
}

HermiteCurve boundary_image(const SkinnedRegion& region, const BoundaryPiece& piece) {
  const auto i = static_cast<size_t>(piece.index);
  if (piece.kind == BoundaryPiece::Kind::Embedded) {
    const HermiteCurve& image = region.embedded.at(i).image;
    return piece.reversed ? image.backwards() : image;
  }
  // The run is straight and evenly parametrised.
  const LineRun& run = region.runs.at(i);
  const ParametricMesh& mesh = region.surface.mesh();
  Vec2 from = mesh.vertices()[run.vertices.front()], along = Vec2::Zero();
  for (size_t k = 0; k < run.edges.size(); ++k) {
    const bool forward = mesh.edges()[run.edges[k]].low == run.vertices[k];
    along += (forward ? 1 : -1) * mesh.edge_length(run.edges[k]) * mesh.edge_tangent(run.edges[k]);
  }
  const Vec2 to = from + along;
  const Vec2 slope = along / (run.fitted.end() - run.fitted.start());
  Points x(2, 3), d(2, 3);
  x << from.x(), from.y(), 0, to.x(), to.y(), 0;
  d << slope.x(), slope.y(), 0, slope.x(), slope.y(), 0;
  const HermiteCurve image({run.fitted.start(), run.fitted.end()}, x, d);
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
