// SPDX-License-Identifier: MPL-2.0
// Convergence of the largest stress of a load case while a mesh is refined; singular stresses.
#pragma once

#include <vector>

#include "batten/analysis/models/parent_triangles.h"
#include "batten/analysis/models/shell_results.h"

namespace batten {

/// Follows the largest stress of a load case from mesh to mesh, and finds the places where it is
/// singular. From then on, the largest stress is that outside of these places.
///
/// A stress is singular within three edge lengths of a point force or point support, or if its
/// relative increase is at least 2 % in two successive rounds and hardly decreases from the first
/// to the second, by less than 30 % (a re-entrant corner, the end of a support), or if it has not
/// converged with elements of an eighth of the thickness. The place is a ball whose radius is the
/// edge length of the first mesh there or, if larger, the thickness: closer to a singularity, the
/// stress of the shell theory differs from that of the solid.
class StressConvergence {
 public:
  /// `first`: the first mesh, with the lengths of its edges (triangle_edge_lengths()). `accuracy`:
  /// largest accepted error().
  StressConvergence(const ParentTriangles& first, const std::vector<double>& edge_lengths,
                    double accuracy)
      : first_(first), edge_lengths_(edge_lengths), accuracy_(accuracy) {}

  /// Takes the result on the next mesh.
  void take(const ShellModel& shell, const ShellLoadCase& load_case, const ShellCaseResult& result,
            const ShellStresses& stresses);

  /// Estimated relative error of the largest stress: the larger of its change since the mesh before
  /// and of ShellStresses::Peak::spread.
  double error() const { return error_; }
  const ShellStresses::Peak& peak() const { return peak_; }
  const std::vector<SingularPlace>& singular_places() const { return places_; }

  /// Marks the triangles around the largest stress if its error is too large: `levels` becomes the
  /// number of times that each triangle is to be bisected, at least.
  void mark(const Surface& surface, std::vector<int>& levels) const;

 private:
  bool is_singular(const ShellModel& shell) const;
  bool grows_without_limit() const;
  void exclude(const ShellModel& shell, const Vec3& at, const Location& where);
  void follow(const ShellModel& shell, const ShellLoadCase& load_case,
              const ShellStresses& stresses, ShellStresses::Peak peak);

  const ParentTriangles& first_;
  const std::vector<double>& edge_lengths_;
  double accuracy_;
  std::vector<SingularPlace> places_;
  ShellStresses::Peak peak_;
  std::vector<double> values_;  // of this peak, from mesh to mesh
  double error_ = 0;
};

/// The edge length of each triangle: √(twice its area), model units.
std::vector<double> triangle_edge_lengths(const Surface& surface);

}  // namespace batten
