// SPDX-License-Identifier: MPL-2.0
// Assembles stiffness, mass and load of a deformable curve.
//
// The energy of one coordinate is E = ∫ ½ (alpha w_u² + beta w_uu²) - f w du = ½ qᵀK q - Fᵀq, so
// the minimum satisfies K q = F. x, y and z share K. Matrices are n×n for n = mesh().dof_count(),
// symmetric, and stored as their LOWER triangle; loads are n×3. Reference: [Celniker1991].
#pragma once

#include <vector>

#include "batten/elements/hermite_segment.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/element_pattern.h"

namespace batten {

/// Assembles stiffness and mass matrices and load vectors of a curve from cubic Hermite segments.
/// Cost: O(segments) per matrix or load vector.
class CurveAssembler {
 public:
  /// Stiffness alpha or beta along a curve, linear within each segment: one entry per segment, or a
  /// single entry for all segments.
  using Coefficient = std::vector<HermiteSegment::Linear>;

  explicit CurveAssembler(CurveMesh mesh);

  const CurveMesh& mesh() const { return mesh_; }
  /// Zero matrix (dofs × dofs) with the sparsity pattern of the stiffness and mass matrices.
  SparseMatrix pattern() const { return pattern_.zero(); }
  /// Computes the stiffness matrix ∫ alpha H_u H_uᵀ + beta H_uu H_uuᵀ du exactly, with the shape
  /// functions H and the curve parameter u. `K`: must have the sparsity of pattern(); is
  /// overwritten. Throws InputError if a coefficient has the wrong number of entries.
  void stiffness(const Coefficient& alpha, const Coefficient& beta, SparseMatrix& K) const;
  SparseMatrix stiffness(const Coefficient& alpha, const Coefficient& beta) const;
  /// Mass matrix ∫ weight H Hᵀ du with the shape functions H. `weight`: one value for all segments,
  /// or one per segment. Throws InputError for another number of values.
  SparseMatrix mass(const std::vector<double>& weight = {1}) const;
  /// Load vector ∫ H f du of a distributed force f with the shape functions H, exact. `f`: force
  /// per unit of the curve parameter u, one row per entry of mesh().parameters(), linear in
  /// between. Throws InputError if the number of rows is wrong.
  Points load(const Points& f) const;
  /// Load vector of a point force at the curve parameter u. A parameter beyond the ends is clamped
  /// on an open curve and wrapped on a closed one.
  Points point_load(double u, const Vec3& force) const;

 private:
  CurveMesh mesh_;
  ElementPattern pattern_;
};

}  // namespace batten
