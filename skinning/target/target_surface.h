// SPDX-License-Identifier: MPL-2.0
// Target surfaces for fitting, defined by closest-point queries, and distances from them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

/// Interface of a target surface: a face of a CAD file, a scan, the limit surface of a subdivision
/// cage, or anything else with a closest-point query.
class TargetSurface {
 public:
  /// Result of a closest-point query.
  struct Nearest {
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();  ///< closest point and unit normal there
    bool at_boundary = false;  ///< true: `at` is on the boundary of the target
  };
  virtual ~TargetSurface() = default;
  /// Finds the point of the target closest to `p`, among the target points at which the normal n
  /// has n·along > 0, or among all target points if `along` is zero. Returns nullopt if there is no
  /// such point. Implementations must be thread-safe.
  virtual std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const = 0;
  /// Samples of the target, dense and evenly distributed, to measure distances to a model.
  virtual std::vector<Nearest> samples() const = 0;
  /// The plane, cylinder, cone, sphere or torus on which all points of the target lie; null if the
  /// target has another shape or several. The default implementation returns null.
  virtual const FittedPrimitive* primitive() const { return nullptr; }
  /// True if the target is one face with a primitive, a surface of revolution or an extruded surface
  /// in its CAD file. The default implementation returns false.
  virtual bool is_analytic() const { return false; }
  /// Computes a parametrization of the target: a function from the (u, v) plane to points of the
  /// target. `rim`: maps points on the boundary of the target to the plane; the parametrization
  /// distributes the interior between these boundary values. Returns an empty function if there is
  /// no parametrization, as the default implementation does. Implementations must be thread-safe.
  using Parametrization = std::function<Vec3(const Vec2& uv)>;
  virtual Parametrization parametrize(const std::function<Vec2(const Vec3&)>& rim) const {
    (void)rim;
    return {};
  }
};

// Distances between a model and its target, in both directions.

/// Statistics of distances from many points of one surface to another surface, model units.
struct Distances {
  int points = 0;
  /// Number of points for which no distance is counted, because they lie beyond the boundary of the
  /// surface to which distances are measured.
  int excluded = 0;
  double rms = 0, largest = 0;
  Vec3 where = Vec3::Zero();  ///< point with the largest distance
};

/// Distances between a model and its target.
struct TargetDistances {
  /// Distances from each face of the model to the target, at 15 points per triangle inside the
  /// trimmed domain.
  std::vector<Distances> regions;
  /// Distances from the samples of the target to the model (distances_from_target()).
  Distances back;
  /// Distances from each curve of the model to the target, at 8 points per cubic piece. No fit can
  /// be closer to the target than the curves of the model are.
  std::vector<Distances> lines;
  double there() const;    ///< largest distance from the faces to the target
  double largest() const;  ///< largest distance in both directions
};

/// Determines the orientation of each face of a model relative to its target: 1 if the normals of
/// face and target point to the same side on most of the area, -1 if they are opposite. `targets`:
/// the target of each face. `dofs`: shape of the model.
std::vector<double> target_orientations(const ModelLayout& layout, const Points& dofs,
                                        const std::vector<const TargetSurface*>& targets);

/// Measures distances from the target's samples to the closest points of the model. Samples beyond
/// the boundary of the model are excluded. These are samples whose closest point lies outside of
/// the trimmed domain; whose offset from the closest point is not normal to the surface; or whose
/// normal differs by more than 60° from that of the surface (because the sample is on another side
/// of a body).
///
/// `largest_of`: null, or one value per triangle of the mesh, which is increased to the largest
/// distance of the samples whose closest point is in this triangle. Cost: about ten microseconds
/// per sample.
Distances distances_from_target(const ModelLayout& layout, const Points& dofs,
                                const TargetSurface& target, VecX* largest_of = nullptr);

/// Measures distances from the faces and curves of a model to the target, but not from the target
/// to the model (TargetDistances::back). `largest_of`: null, or the output: largest distance in
/// each triangle of the model's mesh. Cost: one closest-point query per point.
TargetDistances target_distances(const ModelLayout& layout, const Points& dofs,
                                 const TargetSurface& target, VecX* largest_of = nullptr);

}  // namespace batten
