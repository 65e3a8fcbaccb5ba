// Named curves and named polylines, and helpers for names and segments.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A curve with a name: a parametric curve, or only its points if none could be made (for example
/// from a single point).
struct NamedCurve {
  std::string name;
  HermiteCurve curve;  ///< has no segments if there is no curve
  /// Parameters u of the points written to .curves, .csv and .obj files.
  std::vector<double> parameters;
  std::vector<Vec3> points;  ///< only if there is no curve

  bool has_curve() const { return curve.segment_count() > 0; }
  /// The points of the curve at `parameters`, without consecutive coincident points (readers expect
  /// distinct points). Without a curve: `points`.
  std::vector<Vec3> written_points() const;
};

// Polylines as they are in a file.

/// One curve of a file: its points in order, two or more (.curves: one or more).
struct NamedPoints {
  std::string name;          ///< unique within the file
  std::vector<Vec3> points;  ///< model units
  int first_line = 0;        ///< 1-based row of the file where it starts, for messages
  /// Set for the first curve of a file: how the file was interpreted: title, columns, decimal
  /// commas.
  std::string format_note = {};
};

// Options for writing curves to CAD files.

/// Header data of STEP and IGES files of curves. Other formats ignore it.
struct CurveFileOptions {
  double unit_in_metres = 1e-3;  ///< model unit, which the file declares
  bool ap242 = false;            ///< STEP only: AP242 instead of AP214
};

// Names of curves.

/// Replaces empty names by `other`, and appends _1, _2, … to names that occur several times, in
/// order.
void make_names_unique(const std::vector<std::string*>& names, const std::string& other);

// Chaining of segments.

/// Joins curves of two points into longer polylines. Some programs write each edge as a separate
/// curve (`l 1 2`, `l 2 3`, …). Two segments of one name are joined at a point that belongs to no
/// other curve of that name, if the direction changes by less than 60 degrees there. So the sides
/// of a hexagon stay six curves. Points are identical if their coordinates are. A chain takes the
/// position in the list and the direction of its first segment, and repeats its first point if it
/// is closed. All other curves are unchanged. O(n log n).
std::vector<NamedPoints> chain_segments(std::vector<NamedPoints> lines);

}  // namespace batten
