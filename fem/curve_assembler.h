// Assembles stiffness, mass and load of a deformable curve.
//
// The energy of one coordinate is E = ∫ ½ (alpha w_u² + beta w_uu²) - f w du = ½ qᵀK q - Fᵀq, so
// the minimum satisfies K q = F. x, y and z share K. Matrices are symmetric and stored as their
// LOWER triangle.
#pragma once

#include <vector>

#include "batten/elements/hermite_segment.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/element_pattern.h"

namespace batten {

/// Assembles matrices and load vectors of a curve from its cubic Hermite segments.
class CurveAssembler {
 public:
  /// Coefficient along the curve, constant or linear within a segment: one entry for all segments,
  /// or one per segment.
  using Coefficient = std::vector<HermiteSegment::Linear>;

  explicit CurveAssembler(CurveMesh mesh);

  const CurveMesh& mesh() const { return mesh_; }
  /// Matrix with the sparsity pattern of the curve and zero entries.
  SparseMatrix pattern() const { return pattern_.zero(); }
  /// Stiffness ∫ alpha H_u H_uᵀ + beta H_uu H_uuᵀ, exact. Throws InputError if a coefficient has
  /// the wrong number of entries.
  void stiffness(const Coefficient& alpha, const Coefficient& beta, SparseMatrix& K) const;
  SparseMatrix stiffness(const Coefficient& alpha, const Coefficient& beta) const;
  /// Mass ∫ weight H Hᵀ. `weight`: one value for all segments, or one per segment; throws
  /// InputError otherwise.
  SparseMatrix mass(const std::vector<double>& weight = {1}) const;
  /// Load ∫ H f, exact. f: values at u_0 … u_m (rows), linear in between. Throws InputError if the
  /// number of rows is wrong.
  Points load(const Points& f) const;
  /// Load of a point force at parameter u.
  Points point_load(double u, const Vec3& force) const;

 private:
  CurveMesh mesh_;
  ElementPattern pattern_;
};

}  // namespace batten
