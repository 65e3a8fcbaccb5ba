// SPDX-License-Identifier: MPL-2.0
// Sculpting of surfaces: interactive sessions, in which loads, constraints and motion can change at
// any time, and single static load cases.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

struct SessionData;
struct SessionSnapshot;

/// An interactive sculpting session on a region or a whole model.
///
///     SculptingSession session(layout, options);
///     session.add(Load{"swell", Load::Pressure{}}, {{.name = "swell", .max = 300}});
///     session.solve_to_equilibrium();
///     while (dragging) {
///       session.set("swell", slider);
///       session.solve_preview();       // one or a few pairs of triangular solves
///       draw(session.frame());         // points and exact normals
///     }
///
/// Curves that regions share move all of these regions. Smooth joins stay smooth under all loads,
/// because their constraints are imposed together with those of the curves; creases stay creases.
/// If a curve offset rotates the tangents of curves at a node, the joins there become less smooth,
/// because their constraints still refer to the old curves; solve_to_equilibrium() recomputes these
/// constraints.
///
/// The state consists of dofs, velocities, time and parameter values. The data behind it (mesh, K,
/// factor, constraints) is shared and immutable. undo() and redo() restore states to the last bit,
/// and so are all solves after them.
///
/// Cost of a change (measurements: docs/theory/sculpting.md):
///
///     value of linear loads only         a sum of vectors (superposed; one solve at a first move)
///     right-hand side of a constraint,   one pair of triangular solves
///       curve or curve offset
///     pressure, nonlinear attractor      one pair per iteration; iterations start from the
///       springs                            last shape
///     a geometric constraint added       one solve per new point; removed: none
///     alpha, beta                        numeric factorization; the symbolic analysis is reused
///     curves added or removed,           everything on the mesh
///       refinement
///
/// set(), solve_preview() and step() do not allocate memory after the first solve of each kind,
/// except for the first history entry of a drag and the pages of the record. Every change either
/// succeeds, or throws and leaves the session in its last valid state; ConflictError names the
/// constraints in conflict.
///
/// Only one thread at a time may call the session. A viewer's thread receives frames through
/// FrameExchange.
class SculptingSession {
 public:
  /// Creates a session without loads and solves it to equilibrium under the constraints along its
  /// curves.
  ///
  /// The session keeps `progress` and also uses it during long solves. Throws InputError for
  /// invalid options, ConflictError for contradictory constraints, and NoSolutionError if the
  /// constraints do not support the surface.
  SculptingSession(ModelLayout layout, const SessionOptions& options,
                   const Progress& progress = {});
  /// Creates a session in the state of a snapshot: the same shape, to the last bit, with the same
  /// loads, constraints and parameter values. The history is empty. Sessions of one snapshot may be
  /// used by different threads. Cost: a factorization.
  explicit SculptingSession(const SessionSnapshot& state, const Progress& progress = {});
  ~SculptingSession();
  SculptingSession(SculptingSession&&) noexcept;
  SculptingSession& operator=(SculptingSession&&) noexcept;

  // -- parameters ---------------------------------------------------------------------------------
  const Parameters& parameters() const;
  /// Sets a parameter to a user value. The value takes effect at the next solve_preview(), step()
  /// or solve_to_equilibrium(). Throws InputError under the conditions of Parameters::set().
  void set(const std::string& parameter, double value) {
    set(parameters().index(parameter), value);
  }
  void set(int parameter, double value);
  /// Adds a parameter that the rules of other parameters can use.
  void add_parameter(ScalarParameter parameter);
  /// Sets or removes the rule of a parameter, see Parameters::set_rule().
  void set_rule(const std::string& parameter, std::vector<ScalarParameter::Term> rule_terms,
                double offset);

  // -- loads, stiffness fields, constraints and curves -------------------------------------------
  /// Adds a load, stiffness field, constraint, curve offset or inner curve to the current surface.
  ///
  /// A curve is embedded where the surface is closest to it. `parameters`: initial values, ranges
  /// and keyframes of the parameters of the item, by name. Missing parameters start at 0, those of
  /// a point constraint at Constraint::Point::goal. Loads and stiffness fields take effect at the
  /// next solve. After constraints, offsets or curves are added, the surface is solved to
  /// equilibrium at once.
  ///
  /// Throws InputError for a name that is already used, for points farther from the surface than
  /// half of the model size, and for numbers out of range. Throws ConflictError if the new
  /// constraint contradicts others by more than 1e-6 of the model size; a smaller difference is
  /// rounding, and the constraint then follows the others. A point within 1e-6 of the size of a curve
  /// is on the curve, and so is a point within 1e-3 that its goal would move by more than a tenth of
  /// its distance from the curve.
  void add(Operation::Item thing, std::vector<ScalarParameter> parameters = {});
  /// Replaces the constraint of the same name by one with another point, goal or direction. The
  /// type of the constraint must stay the same.
  void change(Constraint constraint);
  /// Removes a load, stiffness field, constraint, curve offset or embedded inner curve. Throws
  /// InputError if there is no item of this name or if other items refer to it.
  void remove(const std::string& name);
  /// Replaces the shape of a curve, with the same parameters and nodes as layout().line(). Only
  /// right-hand sides change. The surface is then solved to equilibrium.
  void set_line(const std::string& line, HermiteCurve curve);
  /// Current shape of a curve: the curve of the layout, displaced by its offsets.
  HermiteCurve line(const std::string& name) const;
  std::vector<std::string> names() const;  ///< names of all items that remove() accepts
  /// A load, stiffness field, constraint or curve offset that acts on the session.
  struct ActingItem {
    Operation::Item what;
    /// Locations of the item on the surface, as for a point load; empty for other items.
    std::vector<ModelPoint> foot_points;
    /// Identity: equal to that of an item listed before if the item is the same and unchanged.
    std::shared_ptr<const void> id;
  };
  /// All items that act on the session, in the order in which they were added, by kind: loads,
  /// stiffness fields, constraints, offsets.
  std::vector<ActingItem> items() const;

  // -- solves -------------------------------------------------------------------------------------
  /// Computes the equilibrium shape under all loads, to the session's tolerance.
  ///
  /// Throws NoSolutionError if the pressure exceeds its limit load; the message states the values
  /// reached. Parameters and shape are then those of the last converged solve.
  SolveReport solve_to_equilibrium();
  /// Computes an approximate equilibrium, for use during a drag.
  ///
  /// Stops when the change of the shape falls below `tolerance` times the model size (the default
  /// is about a hundredth of a pixel), or after `max_iterations`. If the solve has not converged,
  /// the next call continues it.
  SolveReport solve_preview(int max_iterations = 4, double tolerance = 1e-5);
  /// Starts a motion with velocity 0 from the current shape; step() then advances it in time.
  /// Throws InputError for numbers that Motion does not allow, for example density and damping both
  /// 0.
  void start_motion(const Motion& motion);
  /// Advances the motion and the keyframed parameters by one time step dt, with an implicit scheme.
  SolveReport step();
  void stop_motion();
  bool in_motion() const;
  /// Sets the time of keyframed parameters for the following solves. Throws InputError during a
  /// motion.
  void set_time(double time);

  // -- history ------------------------------------------------------------------------------------
  /// Undoes one step of the history. Returns false if there is nothing to undo.
  ///
  /// Each edit is one step of the history. All calls of set() since the last solve_to_equilibrium()
  /// or edit together are one step (a drag of one or several sliders), and so are all consecutive
  /// time steps of a motion.
  ///
  /// The history goes back to the constructor or clear_history(), through at most 1,000 steps within
  /// the memory SessionOptions::history_bytes. Costs a copy of the dofs. Matrices and factors that
  /// the history has dropped to save memory are computed again, to the same bits: those of the mesh
  /// at once, the factor at the next solve.
  bool undo();
  bool redo();
  /// Makes the current state the origin of the history: neither undo() nor redo() leaves it.
  void clear_history();
  /// Switches the recording of operations on or off; it is initially off. The memory of the record
  /// grows by pages of 4,096 operations. Operations that throw are recorded as well.
  void record(bool on);
  const std::vector<Operation>& recorded() const;
  /// Executes one operation by calling the member function that it represents.
  void apply(const Operation& operation);
  /// Executes a recorded sequence of operations, and returns the number of operations that threw.
  ///
  /// Operations that throw are skipped, as they were when they were recorded. On a session that was
  /// created from the same input, the result is bit-identical.
  int replay(const std::vector<Operation>& operations);

  /// The current state of the session, without its history and factors, for a second session.
  std::shared_ptr<const SessionSnapshot> snapshot() const;

  // -- refinement ---------------------------------------------------------------------------------
  /// Refines triangles by bisection, transfers the shape and all loads and constraints to the new
  /// mesh, and solves to equilibrium. Throws InputError for strokes, fractions or sizes out of
  /// range, and if there would be too many triangles.
  RefinementReport refine(const Refinement& refinement);

  // -- results ------------------------------------------------------------------------------------
  const ModelLayout& layout() const;
  Points dofs() const;
  SkinnedRegion region(int r = 0) const;  ///< region r, with its curves at their current positions
  std::vector<SkinnedRegion> regions() const;
  /// Points and normals of the current shape, in a buffer that the next call overwrites.
  const Frame& frame();
  /// Writes points and normals of the current shape into a frame of the caller
  /// (FrameExchange::writing()). Sets Frame::moved if the shape has changed since the last frame()
  /// or draw().
  void draw(Frame& to);
  /// Largest residual of all constraints for the parameter values of the last solve, divided by the
  /// model size. Excludes redundant constraints that differ from the others by rounding, see add().
  /// Costs a factorization if the history has dropped that of the current state.
  double residual() const;
  /// Elastic energy of the current shape, on the domain scaled to size 1. In relative units, it is
  /// divided by the square of the model size.
  SurfaceEnergy energy() const;
  /// Total energy for the current parameter values, in the units of energy(): the elastic energy,
  /// minus the work Fᵀx of the loads, plus the energy of springs and, during a motion, the kinetic
  /// energy.
  ///
  /// The total energy never grows under constant loads that do not follow the surface. Pressure p
  /// contributes -p V (V: the enclosed volume), which is its potential if the boundary is fixed.
  double total_energy() const;
  /// Reaction force of each curve and constraint at equilibrium. Cost: a factorization of a matrix
  /// of the size of the constraints.
  std::vector<Reaction> reactions() const;
  /// Distances of the points of each Load::PointCloudSprings from the current surface and, for
  /// comparison, from the surface with the dofs `before` on the same layout.
  std::vector<PointCloudDistances> scan_distances(const Points& before) const;
  double enclosed_volume() const;  ///< ⅓ ∬ x·(x_u × x_v) du dv for the current shape
  size_t history_bytes() const;    ///< memory of the history, without what the current state shares

 private:
  std::unique_ptr<SessionData> data_;
};

// Static solve: the equilibrium shape of a region or model under curves, constraints and loads.

/// A load together with the value of its parameter.
struct AppliedLoad {
  Load load;
  double value = 0;
};

/// One load case: loads, constraints, material, and solver settings.
struct StaticTask {
  std::vector<AppliedLoad> loads;
  /// Constraints besides the curves of the model. Point constraints use Constraint::Point::goal.
  std::vector<Constraint> constraints;
  SurfaceStiffness material;  ///< stretching and bending stiffness alpha, beta, in `units`
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< true: constrains only the corners, not the whole curves
  double tolerance = 1e-12;       ///< convergence tolerance, see SessionOptions
  int max_iterations = 60;        ///< maximum number of iterations, see SessionOptions
};

/// Result of sculpt(): the equilibrium shape and measurements.
struct SculptResult {
  Points dofs;
  /// Elastic energy on the domain scaled to size 1; in relative units, divided by model size².
  SurfaceEnergy energy;
  int iterations = 0;
  /// Change of the shape in the last iteration, relative to the model size.
  double last_change = 0;
  std::vector<Reaction> reactions;
  /// Largest residual of all constraints, divided by the model size.
  double max_constraint_residual = 0;
  /// One entry per Load::PointCloudSprings. The shape for comparison is the equilibrium without
  /// loads and additional constraints.
  std::vector<PointCloudDistances> scans;
};

/// Computes the equilibrium shape of one load case with a SculptingSession that keeps no history.
///
/// Points of application of loads are located on the equilibrium shape without loads. The point of
/// each constraint is located on the shape under the curves and the previous constraints. Throws
/// InputError for invalid numbers, ConflictError for contradictory constraints, and NoSolutionError
/// if the pressure exceeds its limit load; the message states the values reached.
SculptResult sculpt(const ModelLayout& layout, const StaticTask& task,
                    const Progress& progress = {});

}  // namespace batten
