// The boundary of a region as CAD faces have it. Internal.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/core/plane.h"
#include "batten/skinning/region.h"

namespace batten {

/// A smooth part of the boundary, in space and in (u, v), over the same parameters, along the loop.
struct FaceStretch {
  HermiteCurve curve, image;
  std::string line;       ///< that it is a part of
  bool reversed = false;  ///< the loop runs against the line
  double shift = 0;       ///< t of the line = shift + t of the stretch, or shift - t when reversed

  Vec2 uv(double t) const { return flat(image.evaluate(t)); }
  Vec2 first() const { return flat(image.position(0)); }
  Vec2 last() const { return flat(image.evaluate({image.segment_count() - 1, 1.0})); }
  double line_parameter(double t) const { return shift + (reversed ? -t : t); }
};
using FaceLoop = std::vector<FaceStretch>;

/// Parameters where lines are cut, by their names.
using LineCuts = std::map<std::string, std::vector<double>>;

/// Lines that faces have in common.
struct CommonLines {
  std::map<std::string, const HermiteCurve*> curves;
  LineCuts cuts;        ///< ascending
  double distance = 0;  ///< at most, of a boundary from its line
};

struct FaceBoundary {
  std::vector<FaceLoop> loops;  ///< of a ring, the first two are one wire, the seam between them
  double period = 0;
  double seam = 0;  ///< its u
  DomainLoops domain;

  /// Lines are cut at corners, at the cuts of `common`, and where the seam of a ring meets them.
  /// Throws InputError: as write_step_face, and for a boundary that is not on the lines of
  /// `common`.
  explicit FaceBoundary(const SkinnedRegion& region, const CommonLines* common = nullptr);

  bool contains(Vec2 uv) const;
  /// Where it cuts lines, besides their ends.
  void add_cuts(LineCuts& cuts) const;

 private:
  void unroll(const std::string& name);
};

}  // namespace batten
