// A given surface that a model is fitted to, known by its nearest points.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"

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

}  // namespace batten
