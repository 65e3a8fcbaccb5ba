// The boundary of a region, in the pieces that a CAD face has as edges. Internal.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/io/step/step_plan.h"

namespace batten {

/// A smooth part of the boundary, in the direction of its loop.
struct FaceBoundarySegment {
  HermiteCurve curve, pcurve;   ///< in space and in (u, v), over the same parameters
  std::string line;             ///< name of its line
  bool reversed = false;        ///< whether the loop runs against the line
  double shift = 0, scale = 1;  ///< t of the line = shift + scale · t of the stretch
  bool shared = false;          ///< whether the line has another side
  /// From the surface's unit normal to the one that the faces on both sides are to have, at even shares
  /// of the parameter; none where the surfaces meet at an angle. Empty until find_tangent_joins() sets it.
  std::vector<std::optional<Vec3>> normal_corrections = {};

  Vec2 uv(double t) const { return drop_z(pcurve.evaluate(t)); }
  Vec2 first() const { return drop_z(pcurve.position(0)); }
  Vec2 last() const { return drop_z(pcurve.evaluate({pcurve.segment_count() - 1, 1.0})); }
  double line_parameter(double t) const { return shift + scale * t; }
  /// Between the nearest of `normal_corrections`; none where one of them is none.
  std::optional<Vec3> normal_correction(double t) const;
};
using FaceLoop = std::vector<FaceBoundarySegment>;

/// All loops of a region's boundary.
struct FaceBoundary {
  std::vector<FaceLoop> loops;  ///< of a ring, the first two make one wire with the seam
  double period = 0;            ///< the mesh's period in u; 0 when the region is not a ring
  double seam = 0;              ///< u of a ring's seam
  DomainLoops domain;

  /// Whether a ring's rims are cut, and begin, where the seam of its (u, v) meets them.
  enum class AnnulusBoundary { AtSeam, Whole };

  /// Cuts the region's lines at corners, at the cuts of `common`, and where the seam of a ring
  /// meets them (Rims::AtSeam). Throws InputError as write_step_faces() does of boundaries, and for a
  /// line without a name when `common` is given.
  explicit FaceBoundary(const SkinnedRegion& region, const StepPlan* common = nullptr,
                        AnnulusBoundary boundary_cut = AnnulusBoundary::AtSeam);

  bool contains(Vec2 uv) const;
  /// Adds to the plan where this boundary cuts lines, besides their ends.
  void add_cuts(StepPlan& plan) const;

 private:
  void unroll(const std::string& name);
};

/// Adds to the plan where the boundaries of these regions cut lines, so that all regions cut them
/// at the same places. Rims of the regions in `whole` stay whole. Throws InputError as FaceBoundary.
void cut_lines(StepPlan& plan, const std::vector<const SkinnedRegion*>& regions,
               const std::set<const SkinnedRegion*>& whole = {});

}  // namespace batten
