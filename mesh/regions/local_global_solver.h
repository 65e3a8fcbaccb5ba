// SPDX-License-Identifier: MPL-2.0
// Local/global solver for ARAP-type energies, shared by the iterative deformers.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/regions/local_global_iteration.h"

namespace batten {

/// ARAP-type energy: rows that keep vectors of the rest shape up to a rotation of each cell,
///
///     E(p, G) = ½ Σ_e 1/m Σ_{c of e} Σ_{r of e} |(A p)_r - G_c b_r|²
///             + ½ Σ_links λ_ij |G_i - G_j|²
///
/// e: an element with a contiguous range of rows and m cells. G_c: the rotation of a cell; with
/// `fits_scale` a rotation times a scale ≥ 0 (which requires m = 1 and no links).
struct ArapEnergy {
  RowMatrix A;                       ///< rows × vertices
  RowPoints base;                    ///< b, the rows applied to the rest shape
  std::vector<int> row_start = {0};  ///< rows of element e: row_start[e] … row_start[e+1] - 1
  int cells_of_element = 1;          ///< m
  std::vector<int> cells;            ///< cells of each element, cells_of_element each
  /// Cells × vertices: averages the initial rotations of the vertices for each cell.
  RowMatrix mean;
  /// Vertex of each cell, or -1: if the vertex is fixed or belongs to a handle, the rotation of the
  /// cell is not fitted, but that of the handle (fixed: none). Empty: -1 for all cells.
  std::vector<int> cell_vertices;
  /// Penalty λ_ij on the difference of the rotations of two cells.
  struct Link {
    int a, b;
    double weight;
  };
  std::vector<Link> links;
  bool fits_scale = false;
};

/// Minimises E by LocalGlobalIteration: over G with p fixed, cell by cell, then over p with G
/// fixed, one solve with the factor of AᵀA. Linked cells are processed colour by colour. Each one
/// therefore uses the newest rotations of its neighbours, and results do not depend on the number
/// of threads.
///
/// Initial rotations: the logarithms of the handle rotations, interpolated by min |A q|² with the
/// same factor.
class LocalGlobalSolver final : private LocalGlobalIteration {
 public:
  /// Eliminates the fixed vertices and handles of `constraints`. Parts that no row connects to any
  /// of them stay. Throws InputError (see check() in deform_problem.h) or NoSolutionError, whose
  /// message begins with `name`.
  LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem constraints, ArapEnergy rows,
                    const std::string& name);

  /// Minimises E for given handle transformations. `guess`: initial positions (n×3), or null for
  /// the rest shape with interpolated rotations.
  const Points& deform(std::span<const HandleTransform> moves, const Points* guess,
                       int max_iterations, double tolerance);
  const Points& positions() const { return result_; }
  using LocalGlobalIteration::report;
  const std::vector<Mat3>& rotations() const { return G_; }
  int unknowns() const { return positions_.free_count(); }

 private:
  /// Hard constraints: one row per constrained vertex, and its handle, or -1.
  struct Constraints {
    ConstraintSet rows;
    std::vector<int> vertex, handle;
  };
  static Constraints collect_constraints(const MeshTopology& topology, const DeformProblem& problem,
                                         const ArapEnergy& rows);
  LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem problem, ArapEnergy rows,
                    const std::string& name, Constraints constraints);
  void find_coincident_vertices(const MeshTopology& topology);
  void gather_cells();
  void colour_cells();
  void compute_handle_weights();
  void find_prescribed_cells();
  void set_constraint_rhs();
  void start(const Points* guess);
  void global_step() override;
  double update_rotations() override;
  void store_rotations() override { G_before_ = G_; }
  void restore_rotations() override { G_ = G_before_; }
  /// With links, rotations depend on each other, so they are accelerated instead of positions.
  double iterate(double energy_before) override;
  void evaluate_rows();
  void local_step();
  Mat3 cell_covariance(int cell) const;
  template <class CellOf>
  void local_step_independent(int count, const CellOf& cell_of);
  template <class CellOf>
  void local_step_batch(int count, const CellOf& cell_of);
  double energy();
  int cell_count() const { return static_cast<int>(rows_.mean.rows()); }
  int element_count() const { return isize(rows_.row_start) - 1; }

  DeformProblem problem_;
  DeformEdit edit_;
  ArapEnergy rows_;
  Vec3 origin_;
  Points points_;  // of the undeformed mesh
  std::vector<std::pair<int, int>>
      coincident_vertices_;  // pairs (constrained vertex, free vertex at the same node)
  std::vector<int> constrained_vertex_, constrained_handle_;
  AffineReduction positions_;
  SparseMatrix B_;  // A D
  SparseCholesky factor_;
  MatX weights_;  // cells × handles: interpolation weights of the handle rotations

  std::vector<int> element_start_, elements_;  // per cell
  std::vector<int> link_start_, linked_;       // per cell
  std::vector<double> link_weight_;
  std::vector<int> colour_start_, coloured_;  // cells by colour; empty without links
  std::vector<double> base_square_;           // Σ |b|² per element
  std::vector<char> prescribed_;              // per cell: the rotation is that of a handle

  MatX rhs_;                                      // of the constraints
  MatX rotations_before_, rotations_;             // with links: G_ before and after an iteration
  std::vector<Vec3> rotation_vectors_;            // of the handles
  RowPoints now_, constrained_part_, residual_;   // A p, A d0, target of the free unknowns
  std::vector<Mat3> covariances_, G_, G_before_;  // per element Σ (A p) bᵀ; per cell
  std::vector<double> energy_parts_;              // partial energies, one per chunk
  RowPoints p_;                                   // relative to origin_
  Points result_;
};

}  // namespace batten
