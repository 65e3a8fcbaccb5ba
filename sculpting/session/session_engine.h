// Inside of a sculpting session: the answers. Owns working storage only.
#pragma once

#include <vector>

#include "batten/sculpting/session/secants.h"
#include "batten/sculpting/session/session_system.h"

namespace batten::live {

/// Positions and velocities, n×3, about the definition's origin.
struct Shape {
  Points x, v;
};

// Hard rows of which less is left than this, of their size, beside lines and other rows: they could
// be met by a surface full of waves only.
inline constexpr double kDependent = 1e-5;
// Over the size: rows that others imply must agree to this.
inline constexpr double kAgree = 5e-11;

class Engine {
 public:
  /// Storage for a model of another size; forgets what was learnt of the last one.
  void bind(const System& system);
  /// Forgets responses and secants: the state was put back.
  void forget();

  /// The matrix and its factor for these parameter values, the coupling for these rows. True when
  /// there was something to factor. Throws InputError (a material that is none), NoSolutionError;
  /// the model's system is then as it was.
  bool prepare_matrix(System& system, const std::vector<double>& values);

  /// Static: iterates from x, which becomes the answer. When it does not converge, or runs off, the
  /// answer says so; x holds the last iterate unless it ran off.
  struct Run {
    bool converged = false, ran_off = false, superposed = false, expected = false;
    int iterations = 0;
    double change = 0;
  };
  Run answer(System& system, const std::vector<double>& values, Points& x, int most,
             double tolerance, bool may_superpose);
  bool is_linear(const System& system, const std::vector<double>& values) const;

  /// Feet of scans move to the nearest places of the surface; the matrix has to be
  /// prepared again then. False when none moved by more than 1e-6 in (u, v).
  bool follow_scans(System& system, const Points& x);
  /// The model's matrix, if it has scans, no longer fits their feet.
  static void outdate(System& system) { system.matrix_values.clear(); }

  /// Motion: systems for it, and one step from values at its beginning to values at its end.
  bool prepare_motion(System& system, const Motion& motion);
  void step(System& system, const std::vector<double>& from, const std::vector<double>& to,
            Shape& shape);
  /// Moves a shape onto the rows as they are now, with the least energy, and takes from the
  /// velocities what the rows do not allow.
  void project(System& system, const std::vector<double>& values, Shape& shape);

  /// Largest violation of all rows, model units.
  double residual(const System& system, const std::vector<double>& values, const Points& x);
  /// alpha part, beta part of a shape, on the domain of size 1.
  SurfaceEnergy elastic_energy(const System& system, const std::vector<double>& values,
                               const Points& x);
  /// Of each name among lines and constraints, on the domain of size 1.
  std::vector<Reaction> reactions(const System& system, const std::vector<double>& values,
                                  const Points& x);
  /// Of each scan, of two shapes in absolute coordinates.
  std::vector<ScanDistances> scan_distances(const System& system, const Points& before,
                                            const Points& now) const;
  /// xᵀKx - 2Fᵀx and springs, plus ρ vᵀMv in motion.
  double total_energy(const System& system, const std::vector<double>& values, const Shape& shape,
                      bool moving);

 private:
  void make_matrix(System& system, const std::vector<double>& values);
  void add_scans(System& system, const std::vector<double>& values, SparseMatrix& K);
  void couple(System& system, const Coupling* older);
  bool superpose(System& system, const std::vector<double>& values, Points& x, Run& run);
  bool trusts_guess(double first_change, double tolerance, Run& run);
  void aim_moving(System& system, const std::vector<double>& from, const std::vector<double>& to,
                  const Shape& shape);
  void prepare_right(System& system, const std::vector<double>& values);
  void lines_right(const System& system, const std::vector<double>& values, MatX& right) const;
  void loose_right(const System& system, const std::vector<double>& values);
  void aim_springs(System& system, const std::vector<double>& values, const Points& x);
  void add_linear(const System& system, const std::vector<double>& values, MatX& to) const;
  void map(System& system, const std::vector<double>& values, const Points& x, Points& to);
  ConstraintSet all_rows(const System& system, const std::vector<double>& values) const;
  void throw_conflict(const System& system, const std::vector<double>& values, int row) const;
  struct Pull {
    double stiffness;
    Vec3 target;
  };
  double stretch_energy(const System& system, const LooseRows::Source& source, const Vec3& p) const;
  Pull pull(const System& system, const LooseRows::Source& source, double value,
            const Vec3& p) const;

  double change_between(const Points& a, const Points& b) const;
  void put_on_rows(const System& system, Points& x);
  MatX right_, rate_, hd_, base_, y_;
  VecX felt_;
  Points e_, next_, F_, product_;
  MatX ae_, ax_, av_;  // functionals of the loose rows on e, x and v: points × 3
  VecX g_, stiffness_, wanted_;
  Secants secants_;
  // Of drags: change of the second iteration over that of the first, at most lately; 0: not known.
  double gain_ = 0;
  int unseen_ = 0;  // answers since it was looked at
  // Superposition.
  std::vector<Points> responses_;
  std::vector<char> known_response_;
  Points anchor_;
  std::vector<double> anchor_values_;
  bool anchored_ = false, x_is_anchor_ = false;  // the state's x; copied when a slider begins
  // Values for which right_, e_, hd_ and ae_ stand; empty: none.
  std::vector<double> right_values_;
  const LiveSystem* right_matrix_ = nullptr;
};

/// out = S x for the lower triangle S.
void symmetric_times(const SparseMatrix& S, const Points& x, Points& out);

}  // namespace batten::live
