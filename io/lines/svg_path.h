// SPDX-License-Identifier: MPL-2.0
// Parser of the path data of SVG 1.1 (attribute `d` of the element path).
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// An elliptical arc centre + R (rx cos t, ry sin t) for t from `from` to `to`, with the rotation R
/// by the angle `rotation`. All angles are in radians; `to` < `from` if t decreases along the arc.
struct SvgArc {
  Vec2 centre = Vec2::Zero(), radii = Vec2::Zero();
  double rotation = 0, from = 0, to = 0;
};

/// A segment of a path in absolute coordinates. Quadratic Bézier curves are elevated to cubic ones.
struct SvgSegment {
  enum class Type { line, cubic, arc };
  Type type = Type::line;
  std::array<Vec2, 4> points;  ///< start, control points (of a cubic only), end
  SvgArc arc;                  ///< arc only

  const Vec2& end() const { return points[3]; }
};

/// A part of a path that begins with a command M or m, or after a command Z or z.
struct SvgSubpath {
  Vec2 start = Vec2::Zero();
  /// Without segments of zero length. A closed subpath ends with a line to its start, unless it
  /// ends there anyway.
  std::vector<SvgSegment> segments;
};

/// An error in path data: what was found and expected, and where.
class SvgPathError : public std::runtime_error {
 public:
  SvgPathError(size_t index, const std::string& message)
      : std::runtime_error(message), index(index) {}
  size_t index;  ///< position in the data, from 0
};

/// Parses path data: the commands M, Z, L, H, V, C, S, Q, T and A, absolute and relative, repeated
/// implicitly, with numbers and flags that need no separators. Radii of arcs are made positive, and
/// enlarged if they are too small to reach the end point; an arc with a radius of zero is a line.
/// Throws SvgPathError if the data are not valid. O(length).
std::vector<SvgSubpath> parse_svg_path(std::string_view data);

/// The arc from a to b with the given radii and rotation (radians), by the implementation notes of
/// SVG 1.1, F.6.5 and F.6.6. `large`: more than a half turn; `sweep`: t increases. The radii must
/// not be zero and the points not equal.
SvgArc svg_arc(const Vec2& a, const Vec2& b, Vec2 radii, double rotation, bool large, bool sweep);

}  // namespace batten
