// A curve with a name and points.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/core/eigen.h"

namespace batten {

/// A line by its name: a curve or, where none could be made (of a single point, for example), its
/// points only.
struct NamedCurve {
  std::string name;
  HermiteCurve curve;              ///< the curve; without segments: none
  std::vector<double> parameters;  ///< u of the points that .curves, .csv and .obj files get
  std::vector<Vec3> points;        ///< points of a line without a curve

  bool has_curve() const { return curve.segment_count() > 0; }
  /// The points of the curve at `parameters`, those that follow each other in one place once (no
  /// reader takes them twice); without a curve, `points`.
  std::vector<Vec3> written_points() const;
};


// A line of points as it stood in a file.

/// One line of a file: its points in their order, two or more (.curves: one or more).
struct NamedPoints {
  std::string name;          ///< unique in the file
  std::vector<Vec3> points;  ///< model units
  int first_line = 0;        ///< row of the file where it starts, counted from 1, for messages
  std::string format_note =
      {};  ///< in words, of a file's first line: title, columns, decimal commas
};


// Options of curve files for CAD.

/// What STEP and IGES files of curves declare; other files have no place for it.
struct CurveFileOptions {
  double unit_in_metres = 1e-3;  ///< the model's unit, which the file declares
  bool ap242 = false;            ///< of STEP, instead of AP214
};


// Names of lines from files.

/// Empty names become `other`; names that are there several times get _1, _2, … in their order.
void make_names_unique(const std::vector<std::string*>& names, const std::string& other);


// Lines from their segments.

/// Chains lines of two points into the lines that they are segments of, as programs write them that
/// know edges only (`l 1 2`, `l 2 3`, …). Two segments of one name are joined where they alone have
/// a point and the line turns by less than 60 degrees there: the sides of a hexagon stay six lines.
/// Points are the same where their coordinates are. A chain lies where its first segment lay in the
/// list, runs as that one does, and repeats its first point when it is closed. All other lines
/// are as given. O(n log n).
std::vector<NamedPoints> chain_segments(std::vector<NamedPoints> lines);

}  // namespace batten
