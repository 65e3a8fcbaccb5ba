// Inside of a sculpting session: computes its answers. It owns working storage only.
#pragma once

#include <vector>

#include "batten/sculpting/session/secants.h"
#include "batten/sculpting/session/session_system.h"

namespace batten::live {

/// The positions and velocities of all dofs, n×3, are relative to the definition's origin.
struct Shape {
  Points x, v;
};

// A hard row is implied when lines and the other rows leave less of it than this share of its size:
// only a surface full of waves could meet it by itself.
inline constexpr double kDependent = 1e-5;
// Right-hand sides of implied rows must agree with the other rows to this, over the size.
inline constexpr double kAgree = 5e-11;

/// Answers, steps and measures on one system.
class Engine {
 public:
  /// Makes storage for another system, and forgets what was learnt on the last one.
  void bind(const System& system);
  /// Forgets responses and secants, because the state was put back.
  void forget();

  /// Makes the matrix and its factor for these values of parameters, and the coupling for the
  /// system's rows. Returns whether there was something to factor. Throws InputError (a material
  /// that is none, a negative stiffness), NoSolutionError.
  bool prepare_matrix(System& system, const std::vector<double>& values);

  /// Iterates to the shape at rest from x, which becomes the answer. When it does not converge, or
  /// runs off, Run says so; x holds the last iterate unless it ran off.
  struct Run {
    bool converged = false, ran_off = false, superposed = false, expected = false;
    int iterations = 0;
    double change = 0;
  };
  Run answer(System& system, const std::vector<double>& values, Points& x, int most,
             double tolerance, bool may_superpose);
  /// Whether no load follows under these values: one iteration is then enough.
  bool is_linear(const System& system, const std::vector<double>& values) const;

  /// Moves the feet of scans to the nearest places of the surface. Returns whether one moved by
  /// more than 1e-6 in (u, v); the matrix has to be prepared again then.
  bool follow_scans(System& system, const Points& x);
  /// Notes that the system's matrix no longer fits.
  static void outdate(System& system) { system.matrix_values.clear(); }

  /// Gives the system a rest shape, or takes it away (null); prepare_matrix() has to follow.
  void set_rest(System& system, std::shared_ptr<const Rest> rest);
  /// Returns all rows, of lines and others, with their names and their values now.
  ConstraintSet all_rows(const System& system, const std::vector<double>& values) const;

  /// Makes the matrix of motion and its factor, and their coupling. Returns whether there was
  /// something to make.
  bool prepare_motion(System& system, const Motion& motion);
  /// Makes one step, from the values at its beginning to those at its end.
  void step(System& system, const std::vector<double>& from, const std::vector<double>& to,
            Shape& shape);
  /// Moves a shape onto the present rows, by the displacement of least energy, and takes from the
  /// velocities what the rows do not allow.
  void project(System& system, const std::vector<double>& values, Shape& shape);

  /// Returns the largest residual of all rows, model units.
  double residual(const System& system, const std::vector<double>& values, const Points& x);
  /// Returns the energies of stretching and of bending of a shape, on the domain of size 1.
  SurfaceEnergy elastic_energy(const System& system, const std::vector<double>& values,
                               const Points& x);
  /// Returns the reaction of each name among lines and constraints, on the domain of size 1.
  std::vector<Reaction> reactions(const System& system, const std::vector<double>& values,
                                  const Points& x);
  /// Returns the distances of each scan from two shapes in absolute coordinates.
  std::vector<ScanDistances> scan_distances(const System& system, const Points& before,
                                            const Points& now) const;
  /// Returns xᵀKx - 2Fᵀx and the energy of springs, plus ρ vᵀMv in motion.
  double total_energy(const System& system, const std::vector<double>& values, const Shape& shape,
                      bool moving);

 private:
  void make_matrix(System& system, const std::vector<double>& values);
  void add_scans(System& system, const std::vector<double>& values, SparseMatrix& K);
  static SparseMatrix join_stiffness(const System& system, const std::vector<double>& values);
  static void load_rest(System& system, const SparseMatrix& K);
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
  // In drags: largest ratio, lately, of the change of the second iteration to that of the first; 0:
  // not known.
  double gain_ = 0;
  int unseen_ = 0;  // answers since it was measured
  // Superposition.
  std::vector<Points> responses_;
  std::vector<char> known_response_;
  Points anchor_;
  std::vector<double> anchor_values_;
  bool anchored_ = false, x_is_anchor_ = false;  // x is copied to anchor_ when a slider begins
  // The values that right_, e_, hd_ and ae_ were made for; empty: none.
  std::vector<double> right_values_;
  const LiveSystem* right_matrix_ = nullptr;
};

/// Computes out = S x, with S symmetric and given by its lower triangle.
void symmetric_times(const SparseMatrix& S, const Points& x, Points& out);

}  // namespace batten::live
