// A given surface that a model is fitted to, known by its nearest points.
#pragma once

#include <functional>
#include <optional>
#include <vector>
#include <string>

#include "batten/core/eigen.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// A face of a CAD file, a scan, the limit of a subdivision cage: whatever can say where it is nearest.
class TargetSurface {
 public:
  struct Nearest {
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();  ///< the normal has unit length
    bool at_boundary = false;  ///< the target ends there: further on there is none
  };
  virtual ~TargetSurface() = default;
  /// The nearest point to `p` of all whose normal has a positive share of `along`; of all points where
  /// `along` is zero. None where there is no such point. Called from several threads.
  virtual std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const = 0;
  /// Points of the target from which the way back is measured, dense and even enough for that.
  virtual std::vector<Nearest> samples() const = 0;
  /// The target's point over each place of a plane: its rim lies over the places that `rim` gives to points on
  /// it, the rest is spread between them. None where that cannot be. Called from several threads.
  using Parametrization = std::function<Vec3(const Vec2& uv)>;
  virtual Parametrization parametrize(const std::function<Vec2(const Vec3&)>& rim) const {
    (void)rim;
    return {};
  }
};


// How far a model and its target are apart, both ways.

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
