// Inside of a sculpting session: the answers. Owns working storage only.
#pragma once

#include <vector>

#include "batten/sculpting/secants.h"
#include "batten/sculpting/session_model.h"

namespace batten::live {

/// Positions and velocities, n×3, about the definition's origin.
struct Shape {
  Points x, v;
};

class Engine {
 public:
  /// Storage for a model of another size; forgets what was learnt of the last one.
  void bind(const Model& model);
  /// Forgets responses and secants: the state was put back.
  void forget();

  /// The matrix and its factor for these parameter values, the coupling for these rows. True when
  /// there was something to factor. Throws InputError (a material that is none), NoSolutionError;
  /// the model's system is then as it was.
  bool prepare_matrix(Model& model, const std::vector<double>& values);

  /// Static: iterates from x, which becomes the answer. When it does not converge, or runs off, the
  /// answer says so; x holds the last iterate unless it ran off.
  struct Run {
    bool converged = false, ran_off = false, superposed = false, expected = false;
    int iterations = 0;
    double change = 0;
  };
  Run answer(Model& model, const std::vector<double>& values, Points& x, int most, double tolerance,
             bool may_superpose);
  bool is_linear(const Model& model, const std::vector<double>& values) const;

  /// Feet of measured springs move to the nearest places of the surface; the matrix has to be
  /// prepared again then. False when none moved by more than 1e-6 in (u, v).
  bool follow_measured(Model& model, const Points& x);
  /// The model's matrix, if it has measured springs, no longer fits their feet.
  static void outdate(Model& model) { model.matrix_values.clear(); }

  /// Motion: systems for it, and one step from values at its beginning to values at its end.
  bool prepare_motion(Model& model, const Motion& motion);
  void step(Model& model, const std::vector<double>& from, const std::vector<double>& to,
            Shape& shape);
  /// Moves a shape onto the rows as they are now, with the least energy, and takes from the
  /// velocities what the rows do not allow.
  void project(Model& model, const std::vector<double>& values, Shape& shape);

  /// Largest violation of all rows, model units.
  double residual(const Model& model, const std::vector<double>& values, const Points& x);
  /// alpha part, beta part of a shape, on the domain of size 1.
  SurfaceEnergy elastic_energy(const Model& model, const std::vector<double>& values,
                               const Points& x);
  /// Of each name among lines and constraints, on the domain of size 1.
  std::vector<Reaction> reactions(const Model& model, const std::vector<double>& values,
                                  const Points& x);
  /// Of each spring load, of two shapes in absolute coordinates.
  std::vector<SpringDistances> spring_distances(const Model& model, const Points& before,
                                                const Points& now) const;
  /// xᵀKx - 2Fᵀx and springs, plus ρ vᵀMv in motion.
  double total_energy(const Model& model, const std::vector<double>& values, const Shape& shape,
                      bool moving);

 private:
  void prepare_right(Model& model, const std::vector<double>& values);
  void lines_right(const Model& model, const std::vector<double>& values, MatX& right) const;
  void loose_right(const Model& model, const std::vector<double>& values);
  void aim_springs(Model& model, const std::vector<double>& values, const Points& x);
  void add_linear(const Model& model, const std::vector<double>& values, MatX& to) const;
  void map(Model& model, const std::vector<double>& values, const Points& x, Points& to);
  ConstraintSet all_rows(const Model& model, const std::vector<double>& values) const;
  void throw_conflict(const Model& model, const std::vector<double>& values, int row) const;
  struct Pull {
    double stiffness;
    Vec3 target;
  };
  double stretch_energy(const Model& model, const LooseRows::Source& source, const Vec3& p) const;
  Pull pull(const Model& model, const LooseRows::Source& source, double value, const Vec3& p) const;

  double change_between(const Points& a, const Points& b) const;
  void put_on_rows(const Model& model, Points& x);
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
