// SPDX-License-Identifier: MPL-2.0
// Boundary curves as users type them, and the surfaces that they expect.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten_test {

using batten::Vec3;

/// Smooth piece of an expected surface: x(u, v) over the unit square. Periodic surfaces consist of
/// several pieces, so that the closest point is never beyond an edge of its piece.
struct ExpectedPatch {
  explicit ExpectedPatch(std::function<Vec3(double u, double v)> at, int cells = 24,
                         bool required = true)
      : at(std::move(at)), cells(cells), required(required) {}

  std::function<Vec3(double u, double v)> at;
  int cells;      ///< cells per side of the grid from which the closest-point search starts
  bool required;  ///< false: an optional face of the result, such as the rib of a wing

  /// Distance from the nearest point: grid search, then Gauss-Newton with steps clamped to the
  /// square.
  double distance(const Vec3& p) const;

 private:
  // Centres of the grid's cells, row by row, if no patch is degenerate there; computed at the first
  // call.
  mutable std::vector<Vec3> nodes_;
};

/// Curve given by points. It is closed if the first point is repeated at the end.
struct TypedCurve {
  std::string name;
  std::vector<Vec3> points;
};

/// Curves, and the surface expected from them.
struct ExpectedShape {
  std::string name;
  std::string group;  ///< "revolved", "sections", "ruled", "flat" or "solids"
  std::vector<TypedCurve> curves;
  std::vector<ExpectedPatch> patches;
  double tolerance = 1e-3;             ///< largest distance, as a fraction of size()
  std::optional<double> area, volume;  ///< if known exactly; model units
  /// Lofts that would produce the surface, each as sets of curves that are lofted one after the
  /// other.
  std::vector<std::vector<std::vector<std::string>>> lofts = {};

  double size() const;  ///< diagonal of the bounding box of the curves
  const TypedCurve& curve(const std::string& called) const;
  /// The file that a user would write: columns curve, x, y, z.
  std::string csv() const;
  /// n × n points of every required patch, in its interior.
  std::vector<Vec3> samples(int n) const;
  /// Distance from the nearest patch, required or not.
  double distance(const Vec3& p) const;
};

/// The 35 shapes. Seed 0 gives the standard ones. Any other seed changes dimensions and numbers of
/// points, rotates, scales and translates each shape, reverses some curves and shuffles them; the
/// result depends on the seed only.
std::vector<ExpectedShape> expected_shapes(unsigned seed = 0);

/// Polygons whose corners are too blunt for find_corners(): they could also be points of a smooth
/// curve.
std::vector<ExpectedShape> ambiguous_outlines();

/// Triangulated surface for exact point-to-surface distances.
class FacetedSurface {
 public:
  FacetedSurface(std::vector<Vec3> points, const std::vector<std::array<int, 3>>& facets);
  double distance(const Vec3& p) const;
  const std::vector<Vec3>& points() const { return points_; }
  double area() const;

 private:
  // Consecutive facets with a common bounding box.
  struct Bundle {
    size_t begin, end;
    Vec3 low, high;
  };
  std::vector<Vec3> points_;
  std::vector<std::array<int, 3>> facets_;
  std::vector<Bundle> bundles_;
};

}  // namespace batten_test
