#include "batten/skinning/model/loft_shape.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/words.h"

namespace batten {
namespace {

// A domain with four corners, (1-s)(1-t) c0 + s (1-t) c1 + s t c2 + (1-s) t c3. Side k runs from
// corner k to the next.
class Quadrilateral {
 public:
  explicit Quadrilateral(const RegionLayout& region) {
    for (size_t k = 0; k < 4; ++k) corners_[k] = region.corners()[k].uv;
  }

  // The side nearest to p.
  int side_at(const Vec2& p) const {
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {
      const Vec2 from = corners_[k], way = corners_[(k + 1) % 4] - from;
      const double f = std::clamp(way.dot(p - from) / way.squaredNorm(), 0.0, 1.0);
      const double distance = (from + f * way - p).norm();
      if (distance >= least) continue;
      least = distance;
      nearest = k;
    }
    return nearest;
  }

  // The direction at p from side `side` to the opposite one, either way.
  Vec2 across(int side, const Vec2& p) const {
    const auto& c = corners_;
    double s = 0.5, t = 0.5;
    Mat2 slopes;
    for (int round = 0; round < 8; ++round) {
      slopes.col(0) = (1 - t) * (c[1] - c[0]) + t * (c[2] - c[3]);
      slopes.col(1) = (1 - s) * (c[3] - c[0]) + s * (c[2] - c[1]);
      const Vec2 at = (1 - t) * ((1 - s) * c[0] + s * c[1]) + t * ((1 - s) * c[3] + s * c[2]);
      const Vec2 step = slopes.inverse() * (p - at);
      s = std::clamp(s + step[0], 0.0, 1.0);
      t = std::clamp(t + step[1], 0.0, 1.0);
    }
    return slopes.col(side % 2 == 0 ? 1 : 0).normalized();
  }

 private:
  Vec2 corners_[4];
};

// The side of a region with four corners that a section is part of, or -1. Takes the sections that
// it finds out of `missing`.
int side_of_sections(const RegionLayout& region, const std::vector<std::string>& sections,
                     std::set<std::string>& missing) {
  int side = -1;
  for (const LineRun& run : region.runs()) {
    if (run.line.role != CharacterLine::Role::Outline || run.vertices.size() < 2) continue;
    const std::string& name = run.line.name;
    // "root.2" is a part of the line "root" that was cut at its corners.
    const auto named = std::find_if(sections.begin(), sections.end(), [&](const std::string& s) {
      return name == s || name.starts_with(s + ".");
    });
    if (named == sections.end()) continue;
    missing.erase(*named);
    const auto& at = region.mesh()->vertices();
    const size_t middle = run.vertices.size() / 2;
    const int found =
        Quadrilateral(region).side_at(0.5 * (at[static_cast<size_t>(run.vertices[middle - 1])] +
                                             at[static_cast<size_t>(run.vertices[middle])]));
    if (side >= 0 && found % 2 != side % 2)
      throw InputError("the sections of region '" + region.name() +
                       "' are sides that meet, expected opposite sides: '" + name + "'");
    side = found;
  }
  return side;
}

}  // namespace

bool is_ring(const RegionLayout& region) { return region.mesh()->period() > 0; }

Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections) {
  // Keeps the matrix definite, and lines side by side together; would pinch long rings.
  constexpr double in_all_ways = 1e-4, of_rings = 1e-7;
  std::set<std::string> missing(sections.begin(), sections.end());
  std::vector<SurfaceStiffness> materials(static_cast<size_t>(layout.mesh()->triangle_count()),
                                          SurfaceStiffness::isotropic(0, 1));
  bool lofted = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& region = layout.region(r);
    const bool ring = is_ring(region);
    const int side =
        !ring && region.corners().size() == 4 ? side_of_sections(region, sections, missing) : -1;
    if (!ring && side < 0) continue;
    lofted = true;
    for (int t = 0; t < region.mesh()->triangle_count(); ++t) {
      const Vec2 p = region.mesh()->shape(t).point(Vec3::Constant(1.0 / 3));
      SurfaceStiffness& m = materials[static_cast<size_t>(layout.first_triangle(r) + t)];
      m *= ring ? of_rings : in_all_ways;
      m += SurfaceStiffness::directional(ring ? Vec2(0, 1) : Quadrilateral(region).across(side, p),
                                         0, 1);
    }
  }
  if (!missing.empty())
    throw InputError("the section '" + *missing.begin() +
                     "' is no side of a region with four corners");
  if (!lofted)
    throw InputError(
        "found nothing to loft, expected a ring, or sections: lines that are sides of a region "
        "with "
        "four corners");
  return layout.least_energy_of(std::move(materials));
}

}  // namespace batten
