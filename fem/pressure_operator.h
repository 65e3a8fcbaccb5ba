// The load of a pressure that follows the surface's normal, as fast as an inner loop needs it.
//
//     F = value ∬ w N (x_u × x_v) du dv,     x = Σ N_m x_m
//
// This load is the same in every parameterisation of a triangle: in the dofs that affine maps carry
// along (elements/reference_triangle.h) it is one fixed tensor for all whole triangles,
//
//     F_a = Σ_{b<c} T_abc (x_b × x_c),   T_abc = ∬ N_a (N_b,1 N_c,2 - N_b,2 N_c,1) dL1 dL2,
//
// so there is no quadrature at run time. Positions are taken relative to the triangle's first
// vertex, which leaves 55 pairs (b, c) and keeps the digits of large coordinates. Cut triangles of
// a trim have a tensor of their own, made once.
#pragma once

#include <memory>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/trim.h"

namespace batten {

/// Made once for a mesh, used for many shapes of it. Keeps no reference to mesh or trim. Triangles
/// outside of a trim carry nothing. HCT: exact. Z12: 1e-10 of the load on whole triangles, the
/// trim's rule of degree 7 on cut ones.
///
/// add() and volume() allocate nothing, run on thread_count() threads, give the same bits on any
/// number of them, and take about a tenth of a microsecond a triangle on one (a cut triangle five
/// times as long). One call at a time: they share the object's working storage.
class PressureOperator {
 public:
  /// O(triangles), and some 20 µs for each cut triangle.
  PressureOperator(const ParametricMesh& mesh, TriangleElement kind,
                   std::shared_ptr<const Trim> trim = nullptr);

  /// F += value ∬ w N (x_u × x_v) du dv for the surface with dofs x (dofs × 3). `weights`: w of
  /// each triangle, empty: 1 everywhere. Throws InputError when a count is wrong.
  void add(const Points& x, const VecX& weights, double value, Points& F) const;

  /// ⅓ ∬ w x·(x_u × x_v) du dv: the volume between the surface and the origin; of a closed surface
  /// with the normal outwards, its volume. Throws InputError as add() does.
  double volume(const Points& x, const VecX& weights = VecX()) const;

 private:
  static constexpr int kLanes = 4;  // triangles that are computed side by side
  // Triangles side by side. Lanes behind `count` repeat the first and are left out of the sums.
  struct alignas(32) Batch {
    double numbers[18 * kLanes];  // of P: gradient, altitude, slant (DofTransformCoefficients)
    int dof[12 * kLanes];         // in the part
    int triangle[kLanes];
    int count;
    int tensor;  // of a cut triangle, which stands alone; -1: the reference tensor
  };
  // Triangles that lie together, with the dofs they touch numbered anew.
  struct Part {
    int first_batch, end_batch;
    int first_dof, end_dof;  // in dof_ and forces_
  };
  class PartBuilder;
  void build_dof_lists();  // of each global dof, once the parts are made
  void check(const Points& x, const VecX& weights) const;
  // Fills forces_ with the parts' shares of ∬ w N (x_u × x_v).
  void forces(const Points& x, const VecX& weights) const;
  void part_forces(const Part& part, const Points& x, const VecX& weights) const;

  int dofs_, triangles_;
  std::vector<Batch> batches_;
  std::vector<Part> parts_;
  std::vector<int> dof_;                 // of each local dof of each part: its global number
  std::vector<int> start_, local_dofs_;  // of each global dof: its local ones, by part
  const double* reference_;              // tensor of whole triangles: 55 pairs × 12
  std::vector<double> tensors_;          // of the cut ones
  // Working storage, three numbers a local dof: places, and forces.
  mutable std::vector<double> positions_, forces_;
};

}  // namespace batten
