// The alternation that the deformers of this room share. Internal.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/anderson_accelerator.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/regions/iterative_deformer.h"

namespace batten {

/// Rows that vectors of the rest shape are kept by while they turn:
///
///     E(p, G) = ½ Σ_e 1/m Σ_{c of e} Σ_{r of e} |(A p)_r - G_c b_r|²
///             + ½ Σ_links λ_ij |G_i - G_j|²
///
/// e: elements, each with a run of rows and m cells; G_c: the rotation of a cell, or with
/// `fits_scale` a rotation times a scale of 0 or more (then m = 1 and no links).
struct ArapEnergy {
  RowMatrix A;                       ///< rows × vertices
  RowPoints base;                    ///< b
  std::vector<int> row_start = {0};  ///< the rows of element e: row_start[e] … row_start[e+1]
  int cells_of_element = 1;
  std::vector<int> cells;  ///< of each element, cells_of_element each
  RowMatrix mean;          ///< cells × vertices: whose turns a cell takes at the start
  struct Link {
    int a, b;
    double weight;
  };
  std::vector<Link> links;
  bool fits_scale = false;
};

/// The problem of fixed vertices and handles alone.
DeformProblem handle_problem(std::vector<int> fixed, std::vector<Handle> handles);

/// Minimises E by turns: over G with p as it is, cell by cell, then over p with G as it is, one
/// solve with the factor of AᵀA. Both are exact minima of the same energy, so it cannot rise. Rounds
/// are mixed (mixing.h) as long as that leads lower than they stood, otherwise the plain one is
/// taken. Cells that links join are taken colour by colour, so that each sees the newest rotations of the
/// others and threads change nothing.
///
/// Start: the logarithms of the handles' turns spread by min |A q|², with the same factor.
class LocalGlobalSolver {
 public:
  /// Fixed vertices and handles of `constraints` are eliminated; what no row joins to any of them stays.
  /// Throws InputError (check() in deform_problem.h), NoSolutionError that begins with `error_prefix`.
  LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem constraints, ArapEnergy rows,
                    const std::string& error_prefix);

  const Points& deform(std::span<const HandleTransform> moves, const Points* guess,
                       int max_iterations, double tolerance);
  const Points& positions() const { return result_; }
  const IterationReport& report() const { return report_; }
  const std::vector<Mat3>& rotations() const { return G_; }
  int unknowns() const { return positions_.free_count(); }

 private:
  /// Hard rows, one a held vertex; whoever holds it: a handle, or -1.
  struct Constraints {
    ConstraintSet rows;
    std::vector<int> vertex, handle;
  };
  static Constraints collect_constraints(const MeshTopology& topology, const DeformProblem& problem,
                                         const ArapEnergy& rows);
  LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem problem, ArapEnergy rows,
                    const std::string& error_prefix, Constraints constraints);
  void find_coincident_vertices(const MeshTopology& topology);
  void gather_cells();
  void colour_cells();
  void spread_rotations();
  void set_constraint_rhs();
  void start(const Points* guess);
  void global_step();
  /// One round to the next y_ and G_; returns the energy there, which is not above the one before.
  double iterate(double energy_before);
  /// The same where links let turns see each other: then turns are mixed, and not positions.
  double iterate_with_links(double energy_before);
  /// Positions from y_, what the rows see of them, the best turns; returns the energy.
  double update_rotations();
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
  std::string error_prefix_;
  double size_;
  Vec3 origin_;
  Points points_;  // of the mesh as it was given
  std::vector<std::pair<int, int>>
      coincident_vertices_;  // vertices that have the place of a free one
  std::vector<int> constrained_vertex_, constrained_handle_;
  AffineReduction positions_;
  SparseMatrix B_;  // A D
  SparseCholesky factor_;
  MatX weights_;  // cells × handles: of the handles' turns

  std::vector<int> element_start_, elements_;  // of each cell
  std::vector<int> link_start_, linked_;       // of each cell
  std::vector<double> link_weight_;
  std::vector<int> colour_start_, coloured_;  // cells by colour; empty without links
  std::vector<double> base_square_;           // Σ |b|² of each element

  MatX rhs_, y_, load_, accelerated_;  // load_: right side, then the solution
  MatX rotations_before_, rotations_;  // with links: G_ as it went into a round and came out
  AndersonAccelerator accelerator_{1e-5};
  RowPoints now_, constrained_part_, residual_;   // A p, A d0, what is left for the free vertices
  std::vector<Mat3> covariances_, G_, G_before_;  // of elements: Σ (A p) bᵀ; of cells
  std::vector<double> energy_parts_;              // of the energy, chunk by chunk
  RowPoints p_;                                   // relative to origin_
  Points result_;
  IterationReport report_;
};

}  // namespace batten
