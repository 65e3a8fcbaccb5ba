// Shapes that boundary lines mean by themselves: planes, cylinders, surfaces of revolution.
#pragma once

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// What the lines around a region mean, where no line lies inside of it: whoever draws two equal
/// arcs and two straight lines between them means a piece of a cylinder, though a surface that
/// bends least would sag between the arcs.
struct NaturalShape {
  enum class Kind {
    Free,   ///< nothing of what follows
    Plane,  ///< all lines lie in one plane
    // Straight lines between two opposite sides (of a ring: its rims). They are
    Cylinder,     ///< equal arcs of circles, and the lines stand upright on their planes
    Cone,         ///< arcs of different radii about one axis
    Extrusion,    ///< equal lines of another kind
    Developable,  ///< of one direction at both ends of each straight line: it unfolds
    // Two opposite sides are arcs about one axis, the others are equal, in planes through it. They
    // are
    Sphere,     ///< arcs about a point of the axis
    Torus,      ///< arcs about other points
    Revolution  ///< other lines
  };
  Kind kind = Kind::Free;
  double radius = 0;  ///< of a cylinder, a sphere, a torus's tube; of a cone the larger one
  int side = 0;       ///< one of the two opposite sides, between which the lines run

  bool has_rest() const { return kind != Kind::Free && kind != Kind::Plane; }
};

/// The word for a kind: "plane", "cylinder", …; "" for Kind::Free.
const char* word_for(NaturalShape::Kind kind);

/// Sides are straight, arcs, or equal within 5e-4 of the region's size, directions parallel within
/// 1 degree. O(mesh vertices on the outline).
NaturalShape natural_shape(const RegionLayout& region);

/// Dofs of the surfaces that lines mean, of all regions that mean one; 0 in all others; no rows
/// where no region does, or none is to (ModelFrame::natural). As a rest shape (ModelLayout::least_energy) it costs no energy, so that a
/// region keeps it unless its neighbours bend it. Planes need none: they are what bends least.
/// O(triangles) of those regions.
Points natural_dofs(const ModelLayout& layout);

/// By how much a shape of a region is off what the region's lines mean, at vertices of its mesh,
/// model units. 0 for Kind::Free.
double off_natural(const RegionLayout& region, const NaturalShape& shape, const Points& dofs);

}  // namespace batten
