// Samples of a surface in the cells of a bicubic spline, and the spline of least squares.
// Internal to bicubic_patch.cpp.
#pragma once

#include <vector>

#include "batten/fem/patch_target.h"

namespace batten {

/// Samples by cell: cell i · v.intervals() + j.
class CellSamples {
 public:
  struct Sample {
    double s, t;  // in its cell
    Vec3 x;
    double weight = 1;
  };
  struct Tangent {
    double s, t;    // in its cell
    Vec3 x_s, x_t;  // derivatives by s and t
  };

  /// n×n in each cell, at the given places of [0, 1], and places and tangents of the rim, nearer to each
  /// other than `step`, of the shortest side of all cells or a third of their own cell's.
  CellSamples(const PatchTarget& target, const SplineAxis& u, const SplineAxis& v,
              const std::vector<double>& points, double step);
  const std::vector<Sample>& of(size_t cell) const { return cells_[cell]; }
  const std::vector<Tangent>& tangents(size_t cell) const { return tangents_[cell]; }
  /// Whether all places of the cell are inside: its samples begin with these, by s, then by t.
  bool full(size_t cell) const { return full_[cell] != 0; }

  /// Mean square of the second derivatives in units of the cells, by differences; of samples at
  /// four even places a quarter apart.
  double bending() const;

 private:
  std::vector<std::vector<Sample>> cells_;
  std::vector<std::vector<Tangent>> tangents_;
  std::vector<char> full_;  // all places of the cell are inside
};

/// With the strongest bending that costs no more than a hundredth of the goal. Throws
/// NoSolutionError: numbers that are not finite.
BicubicPatch fit_to_samples(const SplineAxis& u, const SplineAxis& v, const CellSamples& samples,
                            const PatchGoal& goal);

}  // namespace batten
