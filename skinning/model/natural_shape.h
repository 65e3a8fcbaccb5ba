// Shapes that boundary lines mean by themselves: planes, cylinders, cones.
#pragma once

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// What the lines around a region mean, where no line lies inside of it: whoever draws two equal arcs
/// and two straight lines between them means a piece of a cylinder, though a surface that bends least
/// would sag between the arcs.
struct NaturalShape {
  enum class Kind {
    Free,        ///< nothing of what follows
    Plane,       ///< all lines lie in one plane
    Cylinder,    ///< two opposite sides are equal arcs of a circle (of a ring: circles), joined by
                 ///< straight sides at right angles to their plane
    Cone,        ///< likewise, arcs of different radii about one axis
    Extrusion,   ///< two opposite sides are equal lines of another kind, joined by straight sides
    Developable  ///< the straight lines between two opposite sides make a surface that unfolds
  };
  Kind kind = Kind::Free;
  double radius = 0;  ///< of a cylinder; of a cone the larger one
  int side = 0;       ///< one of the two opposite sides; straight lines run from it to the other

  bool is_ruled() const { return kind != Kind::Free && kind != Kind::Plane; }
};

/// Sides are opposite and straight, or directions parallel, within 1 degree and 1e-4 of the size.
/// O(mesh vertices on the outline).
NaturalShape natural_shape(const RegionLayout& region);

/// Dofs of the surfaces of straight lines in all regions that mean one, 0 in all others; no rows
/// where no region does. As a rest shape (ModelLayout::least_energy) it costs no energy, so that a
/// region keeps it unless its neighbours bend it. Planes need none: they are what bends least.
/// O(triangles) of those regions.
Points natural_dofs(const ModelLayout& layout);

/// By how much a shape of a region is off what the region's lines mean, at vertices of its mesh,
/// model units. 0 for Kind::Free.
double off_natural(const RegionLayout& region, const NaturalShape& shape, const Points& dofs);

}  // namespace batten
