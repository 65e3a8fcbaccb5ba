// SPDX-License-Identifier: MPL-2.0
// Numerical engine of a sculpting session: solves, time steps and measurements. It owns only
// working storage.
#pragma once

#include <vector>

#include "batten/core/anderson_accelerator.h"
#include "batten/fem/trim.h"
#include "batten/sculpting/session/session_system.h"

namespace batten::detail {

/// Positions and velocities of all dofs, n×3, relative to the definition's origin.
struct ShapeState {
  Points x, v;
};

// A hard constraint is redundant if the lines and the other constraints leave less of it than this
// fraction of its size. Only a heavily oscillating surface could satisfy the rest independently.
inline constexpr double kRedundantTolerance = 1e-5;

/// Solves, time steps and measurements on one system.
class SessionEngine {
 public:
  /// Allocates storage for another system and discards what was learnt about the previous one. After
  /// CancelledError, only bind() may be called.
  void bind(const SessionSystem& system);
  /// Discards load responses and the Anderson history, because the state was restored.
  void reset_acceleration();

  /// Assembles and factors the matrix for these parameter values, and the Schur complement of the
  /// auxiliary constraints.
  ///
  /// Returns true if something had to be factored. Throws InputError for an invalid material or a
  /// negative stiffness, NoSolutionError, and CancelledError. After an exception, the system keeps
  /// its previous matrix and the loads that belong to it; its factor may have to be computed again,
  /// which the next call does.
  bool prepare_matrix(SessionSystem& system, const std::vector<double>& values);

  /// Iterates from x towards the equilibrium shape, which is returned in x.
  ///
  /// SolveStatus tells whether it converged or diverged. x is the last iterate, unless it diverged.
  /// After an exception, for example CancelledError, x is unchanged.
  struct SolveStatus {
    bool converged = false, diverged = false, superposed = false, change_is_estimated = false;
    int iterations = 0;
    double change = 0;
  };
  SolveStatus solve_preview(SessionSystem& system, const std::vector<double>& values, Points& x,
                            int most, double tolerance, bool may_superpose);
  /// True if no follower load acts under these values: one iteration is then enough.
  bool is_linear(const SessionSystem& system, const std::vector<double>& values) const;

  /// Moves the foot points of point-cloud springs to the closest surface points. Returns true if
  /// one moved by more than 1e-6 in (u, v); prepare_matrix() must then be called again.
  bool update_scan_foot_points(SessionSystem& system, const Points& x);
  /// Marks the system's matrix as out of date: prepare_matrix() computes it again.
  static void invalidate_matrix(SessionSystem& system) { system.matrix_values.clear(); }

  /// Sets or (null) removes the rest shape of the system; prepare_matrix() must follow.
  void set_rest_shape(SessionSystem& system, std::shared_ptr<const RestConfiguration> rest);
  /// All constraints, of lines and others, with their names and current values.
  ConstraintSet all_rows(const SessionSystem& system, const std::vector<double>& values) const;

  /// Assembles and factors the matrix of motion and its Schur complement. Returns true if something
  /// had to be computed.
  bool prepare_motion(SessionSystem& system, const Motion& motion);
  /// Makes one time step, given the parameter values at its beginning and at its end.
  void step(SessionSystem& system, const std::vector<double>& from, const std::vector<double>& to,
            ShapeState& shape);
  /// Projects a shape onto the current constraints by the displacement of least energy, and removes
  /// from the velocities what the constraints do not allow.
  void project(SessionSystem& system, const std::vector<double>& values, ShapeState& shape);

  /// Largest residual of all constraints, model units.
  double residual(const SessionSystem& system, const std::vector<double>& values, const Points& x);
  /// Stretching and bending energy of a shape on the domain of size 1.
  SurfaceEnergy elastic_energy(const SessionSystem& system, const std::vector<double>& values,
                               const Points& x);
  /// Reaction of each line and constraint by name, on the domain of size 1.
  std::vector<Reaction> reactions(const SessionSystem& system, const std::vector<double>& values,
                                  const Points& x);
  /// Distances of the points of each point cloud from two shapes in absolute coordinates.
  std::vector<PointCloudDistances> scan_distances(const SessionSystem& system, const Points& before,
                                                  const Points& now) const;
  /// ½ xᵀKx - Fᵀx plus the energy of springs; in motion also ½ ρ vᵀMv.
  double total_energy(const SessionSystem& system, const std::vector<double>& values,
                      const ShapeState& shape, bool dynamics);

 private:
  void make_matrix(SessionSystem& system, const std::vector<double>& values);
  void add_point_clouds(SessionSystem& system, const std::vector<double>& values, SparseMatrix& K);
  static SparseMatrix elastic_stiffness(const SessionSystem& system,
                                        const std::vector<double>& values);
  static JoinPenalty join_penalty(const SessionSystem& system, const std::vector<double>& values);
  static void set_rest_load(SessionSystem& system, const SparseMatrix& K);
  void couple(SessionSystem& system, const SchurComplementConstraints* older);
  SolveStatus iterate(SessionSystem& system, const std::vector<double>& values, Points& x, int most,
                      double tolerance, bool may_superpose);
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
  Points e_, next_, start_, F_, product_;
  bool start_moved_ = false;  // start_ holds x from before the iteration
  MatX ae_, ax_, av_;         // functionals of the auxiliary constraints on e, x and v: points × 3
  VecX g_, stiffness_, wanted_stiffness_;
  AndersonAccelerator accelerator_;
  // During drags: largest recent ratio of the change in the second iteration to that in the first;
  // 0: unknown.
  double contraction_ratio_ = 0;
  int unmeasured_count_ = 0;  // number of solves since contraction_ratio_ was measured
  // Superposition of linear loads.
  std::vector<Points> responses_;
  std::vector<char> response_is_known_;
  Points anchor_;
  std::vector<double> anchor_values_;
  bool anchored_ = false, x_is_anchor_ = false;  // true: x is copied to anchor_ when a slider
                                                 // begins to move
  // Parameter values for which rhs_, e_, hd_ and ae_ were computed; empty: none.
  std::vector<double> rhs_values_;
  const ReusableFactorization* rhs_matrix_ = nullptr;
};

/// Computes out = S x for a symmetric matrix S given by its lower triangle.
void multiply_symmetric(const SparseMatrix& S, const Points& x, Points& out);

}  // namespace batten::detail
