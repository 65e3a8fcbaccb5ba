// SPDX-License-Identifier: MPL-2.0
// Interactive sculpting of a model.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fem/display_points.h"
#include "batten/scenes/model.h"
#include "batten/scenes/stress.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

class SculptingSession;
namespace detail {
struct SessionContents;
}

/// Initial value and permitted range of a parameter.
struct ParameterRange {
  double value = 0;
  double min = -kInfinity, max = kInfinity;
};

/// Interactive sculpting: a model whose parameters, loads and constraints change while its shape
/// follows.
///
///     Session session(model);
///     session.add_pressure("swell", {.max = 500});
///     while (dragging) {
///       session.set("swell", slider);
///       session.update();              // quick: a few triangular solves
///       draw(session.frame()->points);
///     }
///     session.solve();
///     session.model().save("panel.step");
///
/// Everything that is added is part of model(), its scene and its report. A session of that model
/// has the same shape, to the last bit, and the same loads. Calls from several threads are
/// serialised. Every change either succeeds, or throws and leaves the session as it was.
///
/// Names that are added must be new. The functions throw InputError for invalid numbers and unknown
/// names, ConflictError for contradictory constraints, NoSolutionError for loads beyond their limit,
/// and CancelledError.
class Session {
 public:
  /// Creates the session of a model, with all its loads and constraints, at equilibrium.
  explicit Session(const Model& model, const Progress& progress = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  // Parameters and solves.
  void set(const std::string& parameter, double value);
  double value(const std::string& parameter) const;
  std::map<std::string, double> parameters() const;
  /// Moves the shape towards equilibrium, for use during a drag: at most `max_iterations`
  /// iterations, or until the change is below `tolerance` (relative to the size).
  SolveReport update(int max_iterations = 4, double tolerance = 1e-5,
                     const Progress& progress = {});
  /// Solves to equilibrium, to rounding.
  SolveReport solve(const Progress& progress = {});
  /// Undoes an edit, all set() since the last solve(), or all time steps since the last edit. Returns
  /// false if there is none.
  ///
  /// The history begins with the model that the session was created from, and keeps the last 1,000
  /// steps within 512 MiB (SessionOptions::history_bytes). Undo and redo give the same bits. A state
  /// whose factorization is no longer stored is factored again at the next solve.
  bool undo();
  bool redo();

  // Motion M (ρ ẍ + μ ẋ) + K x = F, as that of `batten sculpt --time`.
  /// Starts a motion at rest from the current shape, with the given time step. Density ρ, damping μ
  /// and parameter θ of the theta method are those of [motion] in the scene, or 1 without it.
  void start_motion(double dt);
  /// The same with other values (sculpting/session/session_options.h). Throws InputError for numbers
  /// out of range.
  void start_motion(const Motion& motion);
  /// Advances the motion, and parameters that depend on time, by `count` time steps dt. Throws
  /// InputError without a motion. Cost of a step: one pair of triangular solves.
  ///
  /// Without damping and with θ = ½, total_energy() is constant under constant loads that do not
  /// follow the surface; otherwise it decreases.
  SolveReport step(int count = 1, const Progress& progress = {});
  void stop_motion();
  bool in_motion() const;
  double time() const;  ///< time of the motion, and of parameters that depend on time
  /// Elastic energy minus the work of the loads, plus the energy of springs and, during a motion, the
  /// kinetic energy; in the units of energy().
  double total_energy() const;

  // Edits. `at`: a point in space; the item acts at the nearest point of the surface.
  /// Adds a pressure along the surface normal, per area, on some faces (empty: all).
  void add_pressure(const std::string& name, const ParameterRange& range = {},
                    const std::vector<std::string>& faces = {});
  /// Adds the point force value · direction.
  void add_force(const std::string& name, const Vec3& at, const Vec3& direction,
                 const ParameterRange& range = {});
  /// Constrains a point of the surface to a position; its parameters are NAME.x, NAME.y, NAME.z.
  ///
  /// On a curve, a position within 1e-6 of the model's size holds the point where the curve has it;
  /// others throw ConflictError. A point that would be moved by more than a tenth of its distance
  /// from a curve within 1e-3 of the size counts as a point on the curve.
  void add_point_constraint(const std::string& name, const Vec3& at, const Vec3& target);
  /// Constrains the surface normal at a point to a direction.
  void add_normal_constraint(const std::string& name, const Vec3& at, const Vec3& normal);
  /// Moves a curve by value · direction, or along the surface normal if `direction` is zero. `fade`:
  /// fraction of the length of the curve at either end over which the offset grows from 0.
  void add_offset(const std::string& name, const std::string& curve,
                  const Vec3& direction = Vec3::Zero(), double fade = 0,
                  const ParameterRange& range = {});
  /// Adds a parameter that can drive others.
  void add_parameter(const std::string& name, const ParameterRange& range = {});
  /// Drives a parameter by others: offset + Σ factor · value, with (name, factor) in `follows`.
  void drive(const std::string& parameter, const std::map<std::string, double>& follows,
             double offset = 0);
  /// Removes a load, constraint or offset.
  void remove(const std::string& name);
  std::vector<std::string> names() const;  ///< names that remove() accepts

  // Results.
  /// Points and normals of the current shape. A frame does not change while it is referenced; the
  /// memory of others is used again.
  std::shared_ptr<const Frame> frame() const;
  Points dofs() const;      ///< degrees of freedom, n×3 (docs/theory/elements.md)
  double residual() const;  ///< largest residual of all constraints, relative to the size
  double energy() const;    ///< elastic energy ½ qᵀK q, on the domain scaled to size 1
  double volume() const;    ///< ⅓ ∬ x·(x_u × x_v) du dv, model units³
  /// Reaction forces of curves and constraints, by name.
  std::vector<Reaction> reactions() const;
  /// Stresses of the current shape as a linear thin shell, for use during a drag.
  ///
  /// The settings replace the [stress] of the model; without settings, the model's own [stress] is
  /// used; `modes`, `buckling` and `accuracy` must be 0. A shape close to the one of an earlier call with the same settings is solved with its
  /// factorization: a few iterations, to a relative error of about 1e-7. model() and the function
  /// stress() give the exact values, with error estimates, reactions and checks. Throws as stress();
  /// the session is unchanged.
  SessionStress stress(const StressSettings& settings = {}, const Progress& progress = {}) const;
  /// The model in its current shape, with all that was added.
  Model model(const Progress& progress = {}) const;

  detail::SessionContents& contents() const { return *contents_; }  ///< for Batten's front ends

 private:
  std::unique_ptr<detail::SessionContents> contents_;
};

}  // namespace batten
