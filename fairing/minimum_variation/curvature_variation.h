// How much the curvature of a surface changes at a point, as residuals with their derivatives.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Derivatives of a surface at one point, one column each: X_u, X_v, X_uu, X_uv, X_vv, X_uuu,
/// X_uuv, X_uvv, X_vvv.
using Jet3 = Eigen::Matrix<double, 3, 9>;
/// The same derivatives of the twelve functions of a triangle: Jet3 = qᵀ Table3.
using Table3 = Eigen::Matrix<double, 12, 9>;

/// The parts of the change ∇II of the curvature, in the orthonormal frame Y_1, Y_2 of the principal
/// directions. C is symmetric in its three indices:
///
///     C_abc = n·Y_abc - Σ_l (Γ^l_ab II_lc + Γ^l_ac II_lb + Γ^l_bc II_la),   Γ^l_ab = Y_l·Y_ab
///
struct CurvatureTensors {
  Vec3 II;            ///< II_11, II_12, II_22, 1/length
  Eigen::Vector4d C;  ///< C_111, C_112, C_122, C_222, 1/length²
  double jacobian;    ///< |X_u × X_v|
};

/// Weights of the residuals; all are constant during a step.
struct CurvatureVariationWeights {
  double principal = 1;    ///< s in [0, 1]: 1 where the principal directions are known
  double second_form = 0;  ///< weight of |II|², 1/length²
  double gauss = 0;        ///< weight of K²
};

/// A frame that is kept during a step: the matrix M with Y_a = Σ_i M_ai X_i orthonormal in the
/// principal directions of the surface that the step starts from.
Mat2 principal_frame(const Jet3& jet);

/// Returns the forms in the frame that is nearest to the kept one: M is first made orthonormal for
/// this jet, (M g Mᵀ)^(-1/2) M with g the metric. The jet must have an area.
CurvatureTensors curvature_tensors(const Jet3& jet, const Mat2& frame);

inline constexpr int kCurvatureVariationResiduals = 8;
using CurvatureVariationVector = Eigen::Matrix<double, kCurvatureVariationResiduals, 1>;
using CurvatureVariationJacobian = Eigen::Matrix<double, kCurvatureVariationResiduals, 27>;

/// The residuals at a point, times √J (du dv still to come). With b1 = ¾ (C111 + C122),
/// b2 = ¾ (C112 + C222) the change of the mean curvature and a1 = ¼ C111 - ¾ C122,
/// a2 = ¾ C112 - ¼ C222 the rest of C:
///
///     b1 + s a1, b2 - s a2, √(1-s²) a1, √(1-s²) a2        s = 1: C111 and C222, zero on cyclides
///     √second_form (II11, √2 II12, II22), √gauss K
///
CurvatureVariationVector curvature_variation_residuals(const CurvatureTensors& forms,
                                                       const CurvatureVariationWeights& weights);

/// Their derivatives with respect to the jet, in the order [x of all nine columns; y; z], at a jet
/// for which the frame is orthonormal; and the residuals there.
CurvatureVariationJacobian curvature_variation_jacobian(const Jet3& jet, const Mat2& frame,
                                                        const CurvatureVariationWeights& weights,
                                                        CurvatureVariationVector& residuals);

}  // namespace batten
