// The surface that runs through sections of one region, before any line is held. Internal.
#pragma once

#include <optional>
#include <vector>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

bool is_annulus(const RegionLayout& region);

/// The side, 0 to 3, of a region with four corners on which a run of its outline lies. Side k runs
/// from corner k to the next.
int domain_side(const RegionLayout& region, const EdgeAlignedLine& aligned_line);

/// (s, t) in [0, 1]² run over the domain, s along the sections, t from one to the next: the bilinear
/// map of a domain with four corners; of a ring s goes once around, t from rim to rim. On each line
/// of equal s the surface is the cubic spline through the sections' points there, over its chord
/// lengths, with ends that are not flat (open_spline.h): straight between two. Chord lengths run
/// smoothly over t.
class SectionSurface {
 public:
  /// Sections are `side` and the opposite side (of a ring: its rims, whatever `side`), and inner
  /// lines that run along s rather than along t. `region` must outlive it.
  SectionSurface(const RegionLayout& region, int side);

  Vec3 at(const Vec2& uv) const { return evaluate_at(inside(st(uv)), nullptr); }
  /// Values and slopes at the dofs of the region's mesh. Slopes along s are differences, good to
  /// about 1e-9.
  Points dofs() const;

 private:
  // A place of the surface and its derivatives by s and t.
  struct Slopes {
    Vec3 x, by_s, by_t;
  };
  // A piece of a section: its curve, its image in (u, v) over the same parameters, and where these
  // are along s.
  struct Piece {
    HermiteCurve curve, pcurve;
    std::vector<double> at, s;
  };
  Mat2 slopes_of_map(const Vec2& st) const;
  Vec2 map(const Vec2& st) const;
  Vec2 st(const Vec2& uv) const;
  double s_of(const Piece& piece, double parameter) const;
  void add(HermiteCurve curve, HermiteCurve pcurve);
  std::optional<double> parameter_at(const Piece& piece, double s) const;
  Vec2 inside(Vec2 st) const;
  Vec3 evaluate_at(const Vec2& st, Vec3* by_t) const;
  Slopes slopes(const Vec2& st) const;

  const RegionLayout& region_;
  bool annulus_, across_;  // across_: s is the second parameter of the bilinear map
  Vec2 corners_[4];        // of a ring: of one period
  std::vector<Piece> pieces_;
};

}  // namespace batten
