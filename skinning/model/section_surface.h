// SPDX-License-Identifier: MPL-2.0
// Surface through the sections of one region (loft), before any lines are imposed.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/bilinear_map.h"
#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// True if the region's domain is an annulus (its mesh is periodic in u).
bool is_annulus(const RegionLayout& region);

/// The side (0 to 3) of a region with four corners on which an edge-aligned line of its outline
/// lies. Side k runs from corner k to the next one.
int domain_side(const RegionLayout& region, const EdgeAlignedLine& aligned_line);

/// A loft through the sections of one region. Its parameters (s, t) in [0, 1]² cover the domain, s
/// along the sections and t from one section to the next. With four corners (s, t) is the bilinear
/// map of the domain; in an annulus s goes around once and t from circle to circle.
///
/// On each line of constant s the surface is the cubic spline through the sections' points, with
/// chord-length parametrisation and not-a-knot ends (not_a_knot_slopes()). Between two sections it
/// is straight. The chord length is a smooth function of t.
class SectionSurface {
 public:
  /// The sections are `side` (0 to 3) and the opposite side; in an annulus the boundary circles,
  /// whatever `side` is. Inner lines that run along s rather than along t are further sections.
  /// `region` must outlive the object.
  SectionSurface(const RegionLayout& region, int side);

  /// Position of the loft at a point of the domain.
  Vec3 at(const Vec2& uv) const { return evaluate_at(inside(map_.inverse(uv)), nullptr); }
  /// Positions and derivatives at the dofs of the region's mesh. Derivatives along s are finite
  /// differences, accurate to about 1e-9.
  Points dofs() const;

 private:
  // A point of the surface and its derivatives with respect to s and t.
  struct Slopes {
    Vec3 x, by_s, by_t;
  };
  // A part of a section: its curve, its pcurve with the same parameters, and sampled parameters
  // `at` with their values of s.
  struct Piece {
    HermiteCurve curve, pcurve;
    std::vector<double> at, s;
  };
  double s_of(const Piece& piece, double parameter) const;
  void add(HermiteCurve curve, HermiteCurve pcurve);
  std::optional<double> parameter_at(const Piece& piece, double s) const;
  Vec2 inside(Vec2 st) const;
  Vec3 evaluate_at(const Vec2& st, Vec3* by_t) const;
  Slopes slopes(const Vec2& st) const;

  const RegionLayout& region_;
  bool annulus_;
  BilinearMap map_;  // from (s, t) to the domain; of an annulus: to one period
  std::vector<Piece> pieces_;
};

}  // namespace batten
