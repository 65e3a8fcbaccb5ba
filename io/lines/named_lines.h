// SPDX-License-Identifier: MPL-2.0
// Curves and polylines with names, and functions that make names unique and chain segments.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A curve with a name. It is a parametric curve, or only a list of points if no curve could be
/// made (for example from a single point).
struct NamedCurve {
  std::string name;
  HermiteCurve curve;  ///< no segments: there is no parametric curve
  /// Parameters u of the points to write to .curves, .csv and .obj files.
  std::vector<double> parameters;
  std::vector<Vec3> points;  ///< points of the curve; used only if `curve` has no segments

  bool has_curve() const { return curve.segment_count() > 0; }
  /// The points to write to text files: those of the parametric curve at `parameters`, or `points`
  /// if there is no parametric curve. Consecutive coincident points of a parametric curve are
  /// merged, because readers expect distinct points.
  std::vector<Vec3> written_points() const;
};

// Polylines as they are read from a file.

/// One curve of a file, given by two or more points in order (in .curves files, one or more).
struct NamedPoints {
  std::string name;          ///< unique within the file
  std::vector<Vec3> points;  ///< model units
  int first_line = 0;        ///< 1-based row of the file in which the curve starts, for messages
  /// How the file was interpreted (title, columns, decimal commas), as text. Set for the first
  /// curve of a file only.
  std::string format_note = {};
};

// Options for writing curves to CAD files and drawings.

/// Header data for writing curves to STEP, IGES, DXF and SVG files. Other formats ignore these
/// options.
struct CurveFileOptions {
  /// Length unit of the curves in metres; the file declares this unit.
  double unit_in_metres = 1e-3;
  bool ap242 = false;  ///< STEP only: schema; true: AP242, false: AP214
};

// Names of curves.

/// Makes the names of curves unique. Empty names are replaced by `other`; names that occur several
/// times get the suffixes _1, _2, … in order.
void make_names_unique(const std::vector<std::string*>& names, const std::string& other);

// Chaining of segments.

/// Joins curves of two points into longer polylines, because some programs write each edge as a
/// separate curve (`l 1 2`, `l 2 3`, …). Two segments with the same name are joined at a common
/// point if no third curve of that name contains the point and if the direction changes by less
/// than 60 degrees at the point. The sides of a hexagon therefore stay six curves. Points are
/// identical if their coordinates are equal. A polyline takes the position in the list and the
/// direction of its first segment; if it is closed, its first point is repeated at the end. All
/// other curves are unchanged. O(n log n).
std::vector<NamedPoints> chain_segments(std::vector<NamedPoints> lines);

}  // namespace batten
