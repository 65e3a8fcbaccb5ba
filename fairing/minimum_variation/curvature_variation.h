// SPDX-License-Identifier: MPL-2.0
// Pointwise curvature variation of a surface: residuals and their derivatives, and points at which
// jumps between two separately meshed parts are penalised. Reference: [MoretonSequin1992].
#pragma once

#include <array>
#include <optional>

#include "batten/core/eigen.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// First to third derivatives of a surface at one point, one per column: X_u, X_v, X_uu, X_uv,
/// X_vv, X_uuu, X_uuv, X_uvv, X_vvv.
using Jet3 = Eigen::Matrix<double, 3, 9>;
/// First to third derivatives of the twelve shape functions of a triangle, one function per row,
/// columns as in Jet3: Jet3 = qᵀ Table3 for the dofs q (12×3) of the triangle.
using Table3 = Eigen::Matrix<double, 12, 9>;

/// Second fundamental form II and its covariant derivative C = ∇II in the orthonormal frame Y_1,
/// Y_2 of the principal directions.
///
/// n is the unit normal, Y_ab are second derivatives; C is symmetric in its three indices:
///
///     C_abc = n·Y_abc - Σ_l (Γ^l_ab II_lc + Γ^l_ac II_lb + Γ^l_bc II_la),   Γ^l_ab = Y_l·Y_ab
struct CurvatureTensors {
  Vec3 II;            ///< II_11, II_12, II_22, 1/length
  Eigen::Vector4d C;  ///< C_111, C_112, C_122, C_222, 1/length²
  double jacobian;    ///< |X_u × X_v|
};

/// Weights of curvature_variation_residuals(); all are constant during a Gauss-Newton step.
struct CurvatureVariationWeights {
  /// Weight s in [0, 1] of the derivatives along the principal directions: 1 if these directions
  /// are well defined, 0 at umbilics.
  double principal = 1;
  double second_form = 0;  ///< weight of |II|² (II: second fundamental form), 1/length²
  double gauss = 0;        ///< weight of K² (K: Gaussian curvature)
};

/// Computes the frame of the principal directions: the matrix M for which Y_a = Σ_i M_ai X_i (X_i:
/// X_u, X_v) are the orthonormal principal directions. It is computed at the start of a
/// Gauss-Newton step and kept constant during the step.
Mat2 principal_frame(const Jet3& jet);

/// Computes the second fundamental form and its covariant derivative at a point with derivatives
/// `jet`, in the orthonormal frame closest to `frame`.
///
/// The matrix M = `frame` is first made orthonormal for this jet: (M g Mᵀ)^(-1/2) M with the metric
/// tensor g. Requires X_u × X_v ≠ 0.
CurvatureTensors curvature_tensors(const Jet3& jet, const Mat2& frame);

inline constexpr int kCurvatureVariationResiduals = 8;
using CurvatureVariationVector = Eigen::Matrix<double, kCurvatureVariationResiduals, 1>;
using CurvatureVariationJacobian = Eigen::Matrix<double, kCurvatureVariationResiduals, 27>;

/// Computes the residuals of curvature variation at a point, multiplied by √J with J = |X_u × X_v|
/// (forms.jacobian). The integral of their squares over du dv is minimised.
///
/// Cabc and IIab are components of `forms`, K is the Gaussian curvature. b1 = ¾ (C111 + C122) and
/// b2 = ¾ (C112 + C222) are proportional to the gradient of the mean curvature. a1 = ¼ C111 - ¾
/// C122 and a2 = ¾ C112 - ¼ C222 are the remaining part of C. With s = weights.principal, the
/// residuals are:
///
///     b1 + s a1, b2 - s a2, √(1-s²) a1, √(1-s²) a2        s = 1: C111 and C222, zero on cyclides
///     √second_form (II11, √2 II12, II22), √gauss K
CurvatureVariationVector curvature_variation_residuals(const CurvatureTensors& forms,
                                                       const CurvatureVariationWeights& weights);

/// Computes curvature_variation_residuals() at a point and their derivatives with respect to `jet`,
/// in the order [x of all nine columns; y; z]. The frame must be orthonormal for this jet.
CurvatureVariationJacobian curvature_variation_jacobian(const Jet3& jet, const Mat2& frame,
                                                        const CurvatureVariationWeights& weights,
                                                        CurvatureVariationVector& residuals);

// Jumps between two separately meshed parts of a surface.

/// Two parametric locations that represent the same point of a curve along which two separately
/// meshed parts of a surface join smoothly. The second part may be a given surface instead.
struct JoinPoint {
  /// Tangent plane and curvature of a given surface, which replaces the second part.
  struct Given {
    Vec3 into;       ///< unit vector in the tangent plane, perpendicular to the curve
    Vec3 curvature;  ///< vector of the normal curvature in the direction `into`, 1/length
  };
  /// Set: the second entries of `at` and `direction` equal the first ones and are not used.
  std::optional<Given> given = {};
  std::array<Location, 2> at;
  /// Tangent of the curve in the (u, v) of each part: the derivative with respect to a parameter of
  /// the curve that is common to both parts.
  std::array<Vec2, 2> direction;
  double weight = 0;      ///< quadrature weight with respect to the common curve parameter
  bool curvature = true;  ///< true: penalise the jump of curvature at this point
  /// True: penalise the jump of the tangent plane at this point. Set it to false if constraints
  /// already make the tangent planes agree.
  bool tangent = true;
};

}  // namespace batten
