// One triangle of a shell at many points.
#pragma once

#include "batten/analysis/shell_point.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/reference_triangle.h"

namespace batten {

/// Geometry, functions and displacements at places of which the reference functions are known
/// (TabulatedRule): a fraction of the time of evaluating each anew.
class ShellTriangle {
 public:
  using Dofs = Eigen::Matrix<double, 12, 3>;

  ShellTriangle(const Surface& surface, int t, const Vec3& along)
      : triangle_(surface.kind(), surface.mesh().shape(t)),
        map_(triangle_.shape()),
        shape_(triangle_.pull_back(surface.triangle_dofs(t))),
        along_(along) {}

  double parametric_area() const { return triangle_.shape().area; }
  /// The dofs q of a displacement on this triangle, as jet() wants them.
  Dofs reference(const Dofs& q) const { return triangle_.pull_back(q); }

  DisplacementJet jet(const Dofs& reference, const ReferenceTabulation& functions) const {
    const Eigen::Matrix<double, 3, 6> local = reference.transpose().lazyProduct(functions);
    DisplacementJet jet;
    jet.col(kW) = local.col(0);
    jet.middleCols<2>(kU) = local.middleCols<2>(1).lazyProduct(map_.first.transpose());
    jet.middleCols<3>(kUU) = local.middleCols<3>(3).lazyProduct(map_.second.transpose());
    return jet;
  }
  ShellPoint point(const ReferenceTabulation& functions) const {
    const DisplacementJet x = jet(shape_, functions);
    return {{x.col(kW), x.col(kU), x.col(kV), x.col(kUU), x.col(kUV), x.col(kVV)}, along_};
  }
  /// The functions of the dofs themselves. P: pull_back_matrix(), once a triangle.
  Mat12 pull_back_matrix() const { return triangle_.pull_back_matrix(); }
  Tabulation functions(const Mat12& P, const ReferenceTabulation& f) const {
    Tabulation local;
    local.col(kW) = f.col(0);
    local.middleCols<2>(kU) = f.middleCols<2>(1).lazyProduct(map_.first.transpose());
    local.middleCols<3>(kUU) = f.middleCols<3>(3).lazyProduct(map_.second.transpose());
    return P.transpose().lazyProduct(local);
  }

 private:
  C1Triangle triangle_;
  DerivativeMap map_;
  Dofs shape_;
  Vec3 along_;
};

}  // namespace batten
