// Stiffness, mass and loads of whole curves.
//
// Energy of one coordinate: E = ∫ (alpha w_u² + beta w_uu² - 2 f w) du = qᵀK q - 2 Fᵀq, so the
// minimum satisfies K q = F. x, y and z share K. Matrices are symmetric, kept by their LOWER
// triangle.
#pragma once

#include <vector>

#include "batten/elements/hermite_segment.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/element_pattern.h"

namespace batten {

class CurveAssembler {
 public:
  /// A coefficient along a curve: one for all segments, or one for each; within a segment constant
  /// or linear.
  using Coefficient = std::vector<HermiteSegment::Linear>;

  explicit CurveAssembler(CurveMesh mesh);

  const CurveMesh& mesh() const { return mesh_; }
  SparseMatrix pattern() const { return pattern_.zero(); }
  /// Stiffness ∫ alpha H_u H_uᵀ + beta H_uu H_uuᵀ, exact. Throws InputError on a wrong count.
  void stiffness(const Coefficient& alpha, const Coefficient& beta, SparseMatrix& K) const;
  SparseMatrix stiffness(const Coefficient& alpha, const Coefficient& beta) const;
  /// Mass ∫ weight H Hᵀ: one weight for all segments, or one for each. Throws InputError on a wrong
  /// count.
  SparseMatrix mass(const std::vector<double>& weight = {1}) const;
  /// Load ∫ H f, f given at u_0 … u_m (rows) and linear between them: exact. Throws InputError on a
  /// wrong count.
  Points load(const Points& f) const;
  /// Load of a force at one point.
  Points point_load(double u, const Vec3& force) const;

 private:
  CurveMesh mesh_;
  ElementPattern pattern_;
};

}  // namespace batten
