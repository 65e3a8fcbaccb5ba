// Pointwise curvature variation of a surface: residuals and their derivatives.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// First to third derivatives of a surface at one point, one per column: X_u, X_v, X_uu, X_uv,
/// X_vv, X_uuu, X_uuv, X_uvv, X_vvv.
using Jet3 = Eigen::Matrix<double, 3, 9>;
/// The same derivatives of the twelve basis functions of a triangle: Jet3 = qᵀ Table3.
using Table3 = Eigen::Matrix<double, 12, 9>;

/// Second fundamental form II and its covariant derivative C = ∇II in the orthonormal frame Y_1,
/// Y_2 of the principal directions.
///
/// C is symmetric in its three indices:
///
///     C_abc = n·Y_abc - Σ_l (Γ^l_ab II_lc + Γ^l_ac II_lb + Γ^l_bc II_la),   Γ^l_ab = Y_l·Y_ab
struct CurvatureTensors {
  Vec3 II;            ///< II_11, II_12, II_22, 1/length
  Eigen::Vector4d C;  ///< C_111, C_112, C_122, C_222, 1/length²
  double jacobian;    ///< |X_u × X_v|
};

/// Weights of the residuals; all are constant during a Gauss-Newton step.
struct CurvatureVariationWeights {
  /// s in [0, 1]: 1 if the principal directions are well defined, 0 at umbilics.
  double principal = 1;
  double second_form = 0;  ///< weight of |II|², 1/length²
  double gauss = 0;        ///< weight of K²
};

/// Computes the frame of the principal directions: the matrix M for which the vectors Y_a = Σ_i
/// M_ai X_i are orthonormal. It is computed at the start of a step and kept constant during it.
Mat2 principal_frame(const Jet3& jet);

/// Computes II and C in the orthonormal frame closest to the given one.
///
/// M is first made orthonormal for this jet: (M g Mᵀ)^(-1/2) M with the metric g. Requires X_u ×
/// X_v ≠ 0.
CurvatureTensors curvature_tensors(const Jet3& jet, const Mat2& frame);

inline constexpr int kCurvatureVariationResiduals = 8;
using CurvatureVariationVector = Eigen::Matrix<double, kCurvatureVariationResiduals, 1>;
using CurvatureVariationJacobian = Eigen::Matrix<double, kCurvatureVariationResiduals, 27>;

/// Computes the residuals at a point, times √J (the factor du dv is still missing).
///
/// b1 = ¾ (C111 + C122) and b2 = ¾ (C112 + C222) are the gradient of the mean curvature. a1 = ¼
/// C111 - ¾ C122 and a2 = ¾ C112 - ¼ C222 are the remaining part of C:
///
///     b1 + s a1, b2 - s a2, √(1-s²) a1, √(1-s²) a2        s = 1: C111 and C222, zero on cyclides
///     √second_form (II11, √2 II12, II22), √gauss K
CurvatureVariationVector curvature_variation_residuals(const CurvatureTensors& forms,
                                                       const CurvatureVariationWeights& weights);

/// Computes the derivatives of the residuals with respect to the jet, in the order [x of all nine
/// columns; y; z], and the residuals themselves. The frame must be orthonormal for this jet.
CurvatureVariationJacobian curvature_variation_jacobian(const Jet3& jet, const Mat2& frame,
                                                        const CurvatureVariationWeights& weights,
                                                        CurvatureVariationVector& residuals);

}  // namespace batten
