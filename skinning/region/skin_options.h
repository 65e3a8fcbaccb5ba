// Options for making a region of its lines.
#pragma once

#include <memory>

#include "batten/elements/c1_triangle.h"

namespace batten {

class SizeField;  // skinning/domains/size_field.h

/// How a region is made of its lines.
struct SkinOptions {
  /// Largest distance between a line and its C1 cubic curve, model units. 0: 1e-4 of the region's
  /// size.
  double tolerance = 0;
  /// A line turns a corner where its direction turns by more, degrees.
  double corner_angle = 20;
  TriangleElement element = TriangleElement::HCT;
  enum class Mesher {
    Delaunay,  ///< CGAL's Mesh_2; falls back to Fan, with a warning, in a build without CGAL
    Fan        ///< triangles from the domain's centre to its sides, each cut in four again and
               ///< again; sides of one line each, no inner lines
  };
  Mesher mesher = Mesher::Delaunay;
  enum class Domain {
    Auto,
    Polygon,      ///< for three corners or more; lines are fitted
    Projected,    ///< for a loop that projects simply; lines are embedded
    Developable,  ///< for any other loop, unfolded like a strip of paper; lines are embedded
    Annulus       ///< for two smooth loops; they are fitted
  };
  Domain domain = Domain::Auto;
  /// Every corner turns to the left of the loop, wherever the lines alone seem to turn: so do those of a
  /// face that the region will be drawn to. Such a face may be far from any surface that the lines make.
  bool convex = false;
  /// The region rests in the shape that its boundary means (rest_shape.h), if there is one; else it bends
  /// from nothing.
  bool rest = true;
  /// Inner lines of a ring are sections of it, in their order from the first rim to the last.
  bool sections = false;
  /// The outline runs against its first line: the normal points to the other side.
  bool reverse_orientation = false;
  /// Whether a polygon's corners move, and the mesh is made anew, until the surface that the lines
  /// make is as little stretched and sheared as straight sides allow (at most three rounds, each
  /// one solve).
  bool minimize_distortion = false;
  /// How often the triangles of the fan are cut in four; -1: until edges are short enough. Lines
  /// that need more nodes than the fan then has on a side to reach the tolerance are refused.
  int fan_refinements = -1;
  /// Target length of element edges, model units. 0: 1/20 of the region's size.
  double edge_length = 0;
  /// Shorter edges than that, on a polygon of given curves; null: none.
  std::shared_ptr<const SizeField> size_field{};
};

}  // namespace batten
