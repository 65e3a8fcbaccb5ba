// How far a model and its target are apart, both ways.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Distances at many points, model units.
struct Distances {
  int points = 0;
  int excluded = 0;  ///< points that lie beyond a rim of the other one: they do not count
  double rms = 0, largest = 0;
  Vec3 where = Vec3::Zero();  ///< the point of the largest one
};

struct TargetDistances {
  /// From each region of the layout: at 15 points of each triangle inside of the trim, to the target's
  /// nearest points.
  std::vector<Distances> regions;
  /// From the target's samples to the nearest points of the model: distances_from_target().
  Distances back;
  /// From each line of the layout, at 8 points a segment: no fit is nearer to the target than its lines.
  std::vector<Distances> lines;
  double there() const;    ///< the largest one of the regions
  double largest() const;  ///< of the regions and of the way back
};

/// Which side of the target each region looks to: 1 where its normals are the target's, -1 where they are
/// opposite, by most of its points. `targets`: one a region.
std::vector<double> target_orientations(const ModelLayout& layout, const Points& dofs,
                                        const std::vector<const TargetSurface*>& targets);

/// From the target's samples to the nearest points of the model. Samples beyond the model's rims do not count:
/// those whose nearest point lies outside of a trim, from which the way to it is not normal to the surface, or
/// where the two normals differ by more than 60° (another side of a body).
/// O(samples); some ten microseconds each. `largest_of`, unless null, has a number for each triangle of the
/// layout's mesh; those of triangles that are nearest to a sample farther away become that distance.
Distances distances_from_target(const ModelLayout& layout, const Points& dofs,
                                const TargetSurface& target, VecX* largest_of = nullptr);

/// Measures all but the way back. `largest_of`, unless null, gets the largest distance in each triangle of the layout's
/// mesh. O(points · log target).
TargetDistances target_distances(const ModelLayout& layout, const Points& dofs,
                                 const TargetSurface& target, VecX* largest_of = nullptr);

}  // namespace batten
