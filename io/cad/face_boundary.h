// The boundary of a region as CAD faces have it. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/core/plane.h"
#include "batten/io/cad/step_plan.h"

namespace batten {

/// A smooth part of the boundary, in space and in (u, v), over the same parameters, along the loop.
struct FaceStretch {
  HermiteCurve curve, image;
  std::string line;             ///< that it is a part of
  bool reversed = false;        ///< the loop runs against the line
  double shift = 0, scale = 1;  ///< t of the line = shift + scale · t of the stretch

  Vec2 uv(double t) const { return flat(image.evaluate(t)); }
  Vec2 first() const { return flat(image.position(0)); }
  Vec2 last() const { return flat(image.evaluate({image.segment_count() - 1, 1.0})); }
  double line_parameter(double t) const { return shift + scale * t; }
};
using FaceLoop = std::vector<FaceStretch>;

struct FaceBoundary {
  std::vector<FaceLoop> loops;  ///< of a ring, the first two are one wire, the seam between them
  double period = 0;
  double seam = 0;  ///< its u
  DomainLoops domain;

  /// Lines are cut at corners, at the cuts of `common`, and where the seam of a ring meets them.
  /// Throws InputError: as write_step_faces, and for a line without name when others are in common.
  explicit FaceBoundary(const SkinnedRegion& region, const StepPlan* common = nullptr);

  bool contains(Vec2 uv) const;
  /// Where it cuts lines, besides their ends.
  void add_cuts(StepPlan& plan) const;

 private:
  void unroll(const std::string& name);
};

/// Cuts lines where the boundary of one of these regions does, so that all regions cut them at the
/// same places. Throws InputError as FaceBoundary.
void cut_lines(StepPlan& plan, const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
