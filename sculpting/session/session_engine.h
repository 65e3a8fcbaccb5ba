// Inside of a sculpting session: computes its answers. It owns working storage only.
#pragma once

#include <vector>

#include "batten/core/anderson_accelerator.h"
#include "batten/sculpting/session/session_system.h"
#include "batten/fem/trim.h"

namespace batten::detail {

/// The positions and velocities of all dofs, n×3, are relative to the definition's origin.
struct ShapeState {
  Points x, v;
};

// A hard row is implied when lines and the other rows leave less of it than this share of its size:
// only a surface full of waves could meet it by itself.
inline constexpr double kRedundantTolerance = 1e-5;
// Right-hand sides of implied rows must agree with the other rows to this, over the size.
inline constexpr double kRhsConflictTolerance = 5e-11;

/// Answers, steps and measures on one system.
class SessionEngine {
 public:
  /// Makes storage for another system, and forgets what was learnt on the last one.
  void bind(const SessionSystem& system);
  /// Forgets responses and secants, because the state was put back.
  void reset_acceleration();

  /// Makes the matrix and its factor for these values of parameters, and the coupling for the
  /// system's rows. Returns whether there was something to factor. Throws InputError (a material
  /// that is none, a negative stiffness), NoSolutionError.
  bool prepare_matrix(SessionSystem& system, const std::vector<double>& values);

  /// Iterates to the shape at rest from x, which becomes the answer. When it does not converge, or
  /// runs off, Run says so; x holds the last iterate unless it ran off.
  struct SolveStatus {
    bool converged = false, diverged = false, superposed = false, change_is_estimated = false;
    int iterations = 0;
    double change = 0;
  };
  SolveStatus solve_preview(SessionSystem& system, const std::vector<double>& values, Points& x,
                            int most, double tolerance, bool may_superpose);
  /// Whether no load follows under these values: one iteration is then enough.
  bool is_linear(const SessionSystem& system, const std::vector<double>& values) const;

  /// Moves the feet of scans to the nearest places of the surface. Returns whether one moved by
  /// more than 1e-6 in (u, v); the matrix has to be prepared again then.
  bool update_scan_foot_points(SessionSystem& system, const Points& x);
  /// Notes that the system's matrix no longer fits.
  static void invalidate_matrix(SessionSystem& system) { system.matrix_values.clear(); }

  /// Gives the system a rest shape, or takes it away (null); prepare_matrix() has to follow.
  void set_rest_shape(SessionSystem& system, std::shared_ptr<const RestConfiguration> rest);
  /// Returns all rows, of lines and others, with their names and their values now.
  ConstraintSet all_rows(const SessionSystem& system, const std::vector<double>& values) const;

  /// Makes the matrix of motion and its factor, and their coupling. Returns whether there was
  /// something to make.
  bool prepare_motion(SessionSystem& system, const Motion& motion);
  /// Makes one step, from the values at its beginning to those at its end.
  void step(SessionSystem& system, const std::vector<double>& from, const std::vector<double>& to,
            ShapeState& shape);
  /// Moves a shape onto the present rows, by the displacement of least energy, and takes from the
  /// velocities what the rows do not allow.
  void project(SessionSystem& system, const std::vector<double>& values, ShapeState& shape);

  /// Returns the largest residual of all rows, model units.
  double residual(const SessionSystem& system, const std::vector<double>& values, const Points& x);
  /// Returns the energies of stretching and of bending of a shape, on the domain of size 1.
  SurfaceEnergy elastic_energy(const SessionSystem& system, const std::vector<double>& values,
                               const Points& x);
  /// Returns the reaction of each name among lines and constraints, on the domain of size 1.
  std::vector<Reaction> reactions(const SessionSystem& system, const std::vector<double>& values,
                                  const Points& x);
  /// Returns the distances of each scan from two shapes in absolute coordinates.
  std::vector<PointCloudDistances> scan_distances(const SessionSystem& system, const Points& before,
                                            const Points& now) const;
  /// Returns xᵀKx - 2Fᵀx and the energy of springs, plus ρ vᵀMv in motion.
  double total_energy(const SessionSystem& system, const std::vector<double>& values,
                      const ShapeState& shape, bool dynamics);

 private:
  void make_matrix(SessionSystem& system, const std::vector<double>& values);
  void add_point_clouds(SessionSystem& system, const std::vector<double>& values, SparseMatrix& K);
  static SparseMatrix join_stiffness(const SessionSystem& system,
                                     const std::vector<double>& values);
  static void set_rest_load(SessionSystem& system, const SparseMatrix& K);
  void couple(SessionSystem& system, const SchurComplementConstraints* older);
  bool superpose(SessionSystem& system, const std::vector<double>& values, Points& x,
                 SolveStatus& run);
  bool accept_first_iterate(double first_change, double tolerance, SolveStatus& run);
  void set_dynamic_targets(SessionSystem& system, const std::vector<double>& from,
                           const std::vector<double>& to, const ShapeState& shape);
  void prepare_rhs(SessionSystem& system, const std::vector<double>& values);
  void line_rhs(const SessionSystem& system, const std::vector<double>& values, MatX& rhs) const;
  void auxiliary_rhs(const SessionSystem& system, const std::vector<double>& values);
  void set_spring_targets(SessionSystem& system, const std::vector<double>& values,
                          const Points& x);
  void add_linear(const SessionSystem& system, const std::vector<double>& values, MatX& to) const;
  void map(SessionSystem& system, const std::vector<double>& values, const Points& x, Points& to);
  void throw_conflict(const SessionSystem& system, const std::vector<double>& values,
                      int row) const;
  struct SpringTarget {
    double stiffness;
    Vec3 target;
  };
  double spring_energy(const SessionSystem& system, const AuxiliaryConstraints::Source& source,
                       const Vec3& p) const;
  SpringTarget spring_target(const SessionSystem& system,
                             const AuxiliaryConstraints::Source& source, double value,
                             const Vec3& p) const;

  double change_between(const Points& a, const Points& b) const;
  void project_onto_constraints(const SessionSystem& system, Points& x);
  MatX rhs_, rate_, hd_, base_, y_;
  VecX dof_weights_;
  Points e_, next_, F_, product_;
  MatX ae_, ax_, av_;  // functionals of the loose rows on e, x and v: points × 3
  VecX g_, stiffness_, wanted_stiffness_;
  AndersonAccelerator accelerator_;
  // In drags: largest ratio, lately, of the change of the second iteration to that of the first; 0:
  // not known.
  double contraction_ratio_ = 0;
  int unmeasured_count_ = 0;  // answers since it was measured
  // Superposition.
  std::vector<Points> responses_;
  std::vector<char> response_is_known_;
  Points anchor_;
  std::vector<double> anchor_values_;
  bool anchored_ = false, x_is_anchor_ = false;  // x is copied to anchor_ when a slider begins
  // The values that right_, e_, hd_ and ae_ were made for; empty: none.
  std::vector<double> rhs_values_;
  const ReusableFactorization* rhs_matrix_ = nullptr;
};

/// Computes out = S x, with S symmetric and given by its lower triangle.
void multiply_symmetric(const SparseMatrix& S, const Points& x, Points& out);

}  // namespace batten::detail

namespace batten {

// Weighs the dofs by how much a change of each one moves the surface. Internal.

/// Returns one number for each dof; |Δq| times it is a length in model units. It is 1 for
/// positions, and for slopes √(2 area) of the largest triangle of the domain that has the dof. It
/// is 0 for dofs that belong only to triangles of which less than a twentieth lies inside of the
/// trim: rounding moves these, and they change nothing that is seen.
VecX displacement_weights(const ParametricMesh& mesh, const Trim* trim);

}  // namespace batten
