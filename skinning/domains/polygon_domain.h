// Inside of polygons: the straight lines of the domain on which their lines lie, before and after
// the mesh.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// A stretch and its straight image in the domain, from `from` to `to`. Fractions run from 0 to 1
/// with the parameter of the fitted curve.
struct AlignedSegment {
  CharacterLine line;
  bool flipped = false;
  HermiteCurve fitted;
  Vec2 from, to;
  std::vector<double> nodes;  ///< fractions that must be mesh vertices, 0 and 1 included
  std::vector<int> points;    ///< of a given curve: its vertices in the mesh, by `nodes`
  bool prescribed() const { return line.prescribed != nullptr; }
  double fraction(double u) const { return (u - fitted.start()) / (fitted.end() - fitted.start()); }
  Vec2 at(double fraction) const { return from + fraction * (to - from); }
};

/// The polygon and the strips that lie on it, in the region's own scale.
struct PolygonDomain {
  DomainInput task;  ///< its mesher is one that the build has
  Outline outline;
  std::vector<double> line_angles;  ///< at the corners, in space, radians
  std::vector<Vec2> polygon;
  std::vector<AlignedSegment>
      aligned_segments;  ///< pieces of the outline in loop order, then inner lines
  std::vector<SmoothSegment> aligned_inner;  ///< inner lines that are strips
  /// All outline lines have given curves.
  bool prescribed() const { return outline.segments[0].segment.prescribed != nullptr; }
};

/// Returns the C1 cubic curve of a stretch between two joints. `alone`: it is a whole side.
HermiteCurve fit_aligned_segment(const PolygonDomain& domain, const SmoothSegment& s,
                                 const LoopVertex& start, const LoopVertex& end, bool alone);

/// Makes an inner line a straight run across the polygon. Returns "", or why it cannot be one.
std::string add_inner_segment(PolygonDomain& domain, const SmoothSegment& s);

/// Makes the mesh, with all strips on element edges. Throws InputError: too many triangles; what
/// the mesher refuses.
ParametricMesh mesh_polygon(PolygonDomain& domain);

/// Returns the edges and vertices of that mesh on a strip.
EdgeAlignedLine edge_aligned_line_on(const ParametricMesh& mesh,
                                     const AlignedSegment& aligned_segment);

}  // namespace batten
