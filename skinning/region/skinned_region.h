// A skinned region: one C1 surface and its lines.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A fitted line: a chain of element edges along a straight run of the domain, on which the surface
/// is exactly the fitted curve.
struct EdgeAlignedLine {
  CharacterLine line;              ///< as the user gave it
  HermiteCurve fitted;             ///< the C1 cubic curve that the surface interpolates
  std::vector<int> vertices;       ///< mesh vertices from the line's start to its end
  std::vector<double> parameters;  ///< of `fitted`, at each of these vertices
  std::vector<int> edges;          ///< mesh edges between them
};

/// An embedded line: the mesh ignores it, the surface is on it at its points and nearly so between
/// them.
struct EmbeddedLine {
  CharacterLine line;          ///< as the user gave it
  HermiteCurve fitted;         ///< X(t), model units
  HermiteCurve pcurve;         ///< c(t) in (u, v), z = 0, over the same parameters
  std::vector<double> points;  ///< parameters at which x(c(t)) = X(t) is held, ascending
  /// `fitted` runs against line.given: outlines run along their loop.
  bool opposite_to_prescribed = false;
};

/// One line, or run, of the region's boundary.
struct BoundarySegment {
  enum class Kind { EdgeAligned, Embedded } kind = Kind::EdgeAligned;
  int index = 0;          ///< in SkinnedRegion::edge_aligned or ::embedded
  bool reversed = false;  ///< the loop goes against the line's direction
};

/// A surface and how its lines lie on it.
struct SkinnedRegion {
  std::string name;
  Surface surface;
  std::vector<EdgeAlignedLine> edge_aligned;
  double size = 1;  ///< length scale of the region in model units: diagonal of its lines' box
  std::vector<EmbeddedLine> embedded = {};
  /// Closed loops with the region to their left in (u, v), the outline first, then holes. A ring (a
  /// mesh that is periodic in u) begins with two, its rims, which run once around the period.
  std::vector<std::vector<BoundarySegment>> boundary = {};
};

/// Returns the straight image of a run in (u, v) (z = 0), over the parameters of its fitted curve.
HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);

/// Returns a piece of the boundary, in the direction of its loop, in (u, v) (z = 0), over the
/// parameters of boundary_curve().
HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece);
/// Returns the same piece in space.
HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece);
/// Returns the boundary as a region of the (u, v) plane. It is not for rings.
DomainLoops boundary_loops(const SkinnedRegion& region);

}  // namespace batten
