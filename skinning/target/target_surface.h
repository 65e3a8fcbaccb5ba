// Target surfaces for fitting, defined by closest-point queries, and distances from them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Interface of a target surface: a face of a CAD file, a scan, the limit surface of a subdivision
/// cage, or anything else with a closest-point query.
class TargetSurface {
 public:
  /// Result of a closest-point query.
  struct Nearest {
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();  ///< the normal has unit length
    bool at_boundary = false;                        ///< true on the boundary of the target
  };
  virtual ~TargetSurface() = default;
  /// Finds the point closest to `p` among those whose normal n satisfies n·along > 0, or among all
  /// points if `along` is zero. Returns nullopt if there is none. Must be thread-safe.
  virtual std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const = 0;
  /// Samples of the target for measuring distances from target to model; dense and even enough for
  /// that.
  virtual std::vector<Nearest> samples() const = 0;
  /// Computes a parametrization of the target over a plane. `rim` gives the positions in the plane
  /// of points on the target's boundary; the interior is distributed between them. Returns an empty
  /// function if that is impossible (the default). Must be thread-safe.
  using Parametrization = std::function<Vec3(const Vec2& uv)>;
  virtual Parametrization parametrize(const std::function<Vec2(const Vec3&)>& rim) const {
    (void)rim;
    return {};
  }
};

// Distances between a model and its target, in both directions.

/// Statistics of the distances at many points, model units.
struct Distances {
  int points = 0;
  int excluded = 0;  ///< points beyond the boundary of the other surface, which do not count
  double rms = 0, largest = 0;
  Vec3 where = Vec3::Zero();  ///< position of the largest distance
};

/// Distances between a model and its target.
struct TargetDistances {
  /// From each region of the layout: closest-point distances at 15 points per triangle inside the
  /// trim.
  std::vector<Distances> regions;
  /// From the target's samples to the closest points of the model: distances_from_target().
  Distances back;
  /// From each line of the layout, at 8 points per segment: a lower bound for any fit.
  std::vector<Distances> lines;
  double there() const;    ///< largest distance from the regions to the target
  double largest() const;  ///< largest distance in both directions
};

/// Determines the orientation of each region relative to the target, by the majority of its area: 1
/// if its normals point to the same side as the target's, -1 if they are opposite. `targets`: one
/// per region.
std::vector<double> target_orientations(const ModelLayout& layout, const Points& dofs,
                                        const std::vector<const TargetSurface*>& targets);

/// Measures distances from the target's samples to the closest points of the model. Samples beyond
/// the model's boundary are excluded: the closest point lies outside of a trim; the offset is not
/// normal to the surface; or the two normals differ by more than 60° (another side of a body).
///
/// `largest_of`, unless null, has one value per triangle of the layout's mesh. A triangle's value
/// is raised to the distance of each sample whose closest point lies in it. O(samples), some ten
/// microseconds each.
Distances distances_from_target(const ModelLayout& layout, const Points& dofs,
                                const TargetSurface& target, VecX* largest_of = nullptr);

/// Measures distances from the regions and lines to the target, but not from the target back.
/// `largest_of`, unless null, receives the largest distance in each triangle of the layout's mesh.
/// O(points · log target).
TargetDistances target_distances(const ModelLayout& layout, const Points& dofs,
                                 const TargetSurface& target, VecX* largest_of = nullptr);

}  // namespace batten
