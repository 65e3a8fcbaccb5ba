// SPDX-License-Identifier: MPL-2.0
// Load of a pressure that follows the surface normal (follower load), optimised for inner loops.
//
//     F = value ∬ w N (x_u × x_v) du dv,     x = Σ N_m x_m
//
// N: shape functions; x_m: dofs; value: pressure; w: weight of each triangle, 1 by default.
//
// This integral does not depend on the parametrisation of a triangle. With the affine-invariant
// reference dofs (elements/reference_triangle.h), it is one fixed tensor for all uncut triangles,
//
//     F_a = Σ_{b<c} T_abc (x_b × x_c),   T_abc = ∬ N_a (N_b,1 N_c,2 - N_b,2 N_c,1) dL1 dL2,
//
// so no quadrature is needed at run time. Positions are relative to the first vertex of the
// triangle; this leaves 55 pairs (b, c) and avoids cancellation for large coordinates. Triangles
// that are cut by a trim have their own tensors, computed once.
#pragma once

#include <memory>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/trim.h"

namespace batten {

/// Operator for follower pressure and enclosed volume; constructed once per mesh and used for many
/// surfaces on it.
///
/// It keeps no reference to mesh or trim. Triangles outside of a trim carry no load. HCT: exact.
/// Z12: relative error 1e-10 on uncut triangles; cut ones use the trim's rule of degree 7.
///
/// add() and volume() allocate no memory, run on thread_count() threads with bit-identical results
/// for any number of them, and take about 0.1 µs per triangle on one thread (five times as long for
/// a cut one). Not thread-safe, because calls share a workspace.
class PressureOperator {
 public:
  /// Precomputes the pressure integrals of all triangles. `trim`: restricts the pressure to the
  /// part of the mesh inside the trim; null: the whole mesh. Cost: O(triangles), plus about 20 µs
  /// per cut triangle.
  PressureOperator(const ParametricMesh& mesh, TriangleElement kind,
                   std::shared_ptr<const Trim> trim = nullptr);

  /// Adds the load vector of a pressure `value` to F: value ∬ w N (X_u × X_v) du dv for the surface
  /// X = Σ N_m x_m with the shape functions N and the dofs x (n×3). `weights`: factor w per
  /// triangle; empty: 1 everywhere. Throws InputError for wrong sizes.
  void add(const Points& x, const VecX& weights, double value, Points& F) const;

  /// Volume ⅓ ∬ w X·(X_u × X_v) du dv between the origin and the surface X(u, v) with dofs x (n×3).
  /// For a closed surface with outward normals, this is the enclosed volume. `weights`: factor w
  /// per triangle; empty: 1 everywhere. Throws InputError for wrong sizes.
  double volume(const Points& x, const VecX& weights = VecX()) const;

 private:
  static constexpr int kLanes = 4;  // triangles that are computed side by side
  // Triangles that are computed side by side (SIMD). Lanes beyond `count` repeat the first one and
  // are not summed.
  struct alignas(32) Batch {
    // Entries of the dof transformation: gradient, altitude, slant (DofTransformCoefficients).
    double numbers[18 * kLanes];
    int dof[12 * kLanes];  // local dofs of the part
    int triangle[kLanes];
    int count;
    int tensor;  // of a cut triangle, which is alone in its batch; -1: reference tensor
  };
  // Triangles that are close together; the dofs that they touch are renumbered locally.
  struct Part {
    int first_batch, end_batch;
    int first_dof, end_dof;  // in dof_ and forces_
  };
  class PartBuilder;
  void build_dof_lists();  // for each global dof, after all parts are made
  void check(const Points& x, const VecX& weights) const;
  // Fills forces_ with the contributions of the parts to ∬ w N (x_u × x_v).
  void forces(const Points& x, const VecX& weights) const;
  void part_forces(const Part& part, const Points& x, const VecX& weights) const;

  int dofs_, triangles_;
  std::vector<Batch> batches_;
  std::vector<Part> parts_;
  std::vector<int> dof_;                 // global dof of each local dof of each part
  std::vector<int> start_, local_dofs_;  // for each global dof its local dofs, by part
  const double* reference_;              // tensor of uncut triangles: 55 pairs × 12
  std::vector<double> tensors_;          // tensors of cut triangles
  // Workspace, three numbers per local dof: positions and forces.
  mutable std::vector<double> positions_, forces_;
};

}  // namespace batten
