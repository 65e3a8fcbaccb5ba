// SPDX-License-Identifier: MPL-2.0
// Small-bandwidth ordering of a curve's dofs, for banded Cholesky.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "batten/core/solvers/band_cholesky.h"
#include "batten/elements/hermite_segment.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

/// Permutes the dofs of a curve mesh to a small bandwidth. Keeps a reference to the mesh.
///
/// An open curve is already ordered: bandwidth 3. A closed curve is folded flat, so that its nodes
/// follow each other in the order 0, n-1, 1, n-2, ….
class CurveDofOrdering {
 public:
  /// `pairs`: also allows entries between the dofs of two adjacent segments whose common node is no
  /// corner, as jump terms at nodes need them.
  explicit CurveDofOrdering(const CurveMesh& mesh, bool pairs = false) : mesh_(mesh) {
    if (mesh.closed()) fold();
    for (int s = 0; s < mesh.segment_count(); ++s) {
      const auto dof = mesh.segment_dofs(s);
      const int after = (s + 1) % mesh.segment_count();
      const bool joined = pairs && (mesh.closed() || after > 0) && !mesh.is_corner(after);
      const auto other = joined ? mesh.segment_dofs(after) : dof;
      for (const int a : dof) {
        for (const int b : dof)
          band_ = std::max(band_, std::abs(banded_index(a) - banded_index(b)));
        for (const int b : other)
          band_ = std::max(band_, std::abs(banded_index(a) - banded_index(b)));
      }
    }
  }

  /// Index of a mesh dof in the banded matrix.
  int banded_index(int dof) const { return banded_index_.empty() ? dof : banded_index_[dof]; }
  /// Sets A to zero with the size and bandwidth of this ordering.
  void reset(BandCholesky& A) const { A.reset(mesh_.dof_count(), band_); }
  /// Adds the 4×4 matrix of a segment to A.
  void add(BandCholesky& A, int segment, const HermiteSegment::Matrix& K) const {
    const auto dof = mesh_.segment_dofs(segment);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b <= a; ++b) A.add(banded_index(dof[a]), banded_index(dof[b]), K(a, b));
  }

 private:
  void fold() {
    banded_index_.resize(mesh_.dof_count());
    int next = 0;
    for (int i = 0; i < mesh_.node_count(); ++i) {
      const int node = i % 2 == 0 ? i / 2 : mesh_.node_count() - 1 - i / 2;
      for (int d = std::min(mesh_.slope_in(node), mesh_.position_dof(node));
           d <= mesh_.slope_out(node); ++d)
        banded_index_[d] = next++;
    }
  }

  const CurveMesh& mesh_;
  std::vector<int> banded_index_;
  int band_ = 3;
};

}  // namespace batten
