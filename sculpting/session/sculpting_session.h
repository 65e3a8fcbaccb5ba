// Interactive sculpting of surfaces: loads, dynamics and constraints that can change at any time.
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
/// Lines that regions share move them together. Smooth joins stay smooth under all loads, because
/// their constraints are imposed together with those of the lines; creases stay creases. If a line
/// offset rotates the tangents of lines at a node, the joins there become less smooth, because
/// their constraints still refer to the old lines. solve_to_equilibrium() plans these joins again.
///
/// The state consists of dofs, velocities, time and parameter values. The data behind it (mesh, K,
/// factor, constraints) is shared and immutable. undo() and redo() therefore only restore pointers:
/// the shape is bit-identical and nothing is factored.
///
/// Cost of a change (measurements: docs/theory/sculpting.md):
///
///     value of linear loads only         a sum of vectors (superposed; one solve at a first move)
///     right-hand side of a constraint,   one pair of triangular solves
///       line or line offset
///     pressure, nonlinear attractor      one pair per iteration; iterations start from the
///       springs                            last shape
///     a geometric constraint added       one solve per new point; removed: none
///     alpha, beta                        numeric factorization; the symbolic analysis is reused
///     lines added or removed, refinement everything on the mesh
///
/// set(), solve_preview() and step() do not allocate memory once each kind of solve has run, except
/// for the first history entry of a drag and the pages of the record. Every change either succeeds
/// or throws and leaves the last good state; ConflictError names the constraints in conflict.
///
/// Only one thread at a time may call the session. A viewer's thread receives frames through
/// FrameExchange.
class SculptingSession {
 public:
  /// Creates a session without loads and solves it to equilibrium under its lines.
  ///
  /// The session keeps `progress` and also uses it during long solves. Throws InputError,
  /// ConflictError and NoSolutionError.
  SculptingSession(ModelLayout layout, const SessionOptions& options,
                   const Progress& progress = {});
  ~SculptingSession();
  SculptingSession(SculptingSession&&) noexcept;
  SculptingSession& operator=(SculptingSession&&) noexcept;

  // -- parameters ---------------------------------------------------------------------------------
  const Parameters& parameters() const;
  /// Sets a parameter to a user value. It takes effect at the next solve_preview(), step() or
  /// solve_to_equilibrium(). Throws InputError as Parameters::set() does.
  void set(const std::string& parameter, double value) {
    set(parameters().index(parameter), value);
  }
  void set(int parameter, double value);
  /// Adds a parameter that the rules of others can use.
  void add_parameter(ScalarParameter parameter);
  /// Sets or removes the rule of a parameter: Parameters::set_rule().
  void set_rule(const std::string& parameter, std::vector<ScalarParameter::Term> rule_terms,
                double offset);

  // -- loads, stiffness fields, constraints and lines --------------------------------------------
  /// Adds a load, stiffness field, constraint, line offset or inner line to the current surface.
  ///
  /// A line is embedded where the surface is closest to it. `parameters`: start values, ranges and
  /// keyframes of the item's parameters, by name. Missing ones start at 0, and the goal of a point
  /// constraint at Point::goal. Loads and stiffness fields take effect at the next solve.
  /// Constraints, offsets and lines hold at once: the surface is solved to equilibrium.
  ///
  /// Throws InputError for a name that is taken, points far from the surface (half the size), and
  /// numbers out of range. Throws ConflictError if the new constraint contradicts others.
  void add(Operation::Item thing, std::vector<ScalarParameter> parameters = {});
  /// Changes the point, goal or direction of the constraint of this name. Its type must stay the
  /// same.
  void change(Constraint constraint);
  /// Removes a load, stiffness field, constraint, offset or embedded inner line. Throws InputError
  /// if there is no such item or if others refer to it.
  void remove(const std::string& name);
  /// Gives a line another shape over the same parameters and nodes as layout().line(). Only
  /// right-hand sides change; the surface is solved to equilibrium.
  void set_line(const std::string& line, HermiteCurve curve);
  /// Current curve of a line: that of the layout plus its offsets.
  HermiteCurve line(const std::string& name) const;
  std::vector<std::string> names() const;  ///< of all items that remove() accepts

  // -- solves
  // ---------------------------------------------------------------------------------------
  /// Computes the equilibrium shape under all loads, to the session's tolerance.
  ///
  /// Throws NoSolutionError, with the values reached, if the pressure exceeds its limit load.
  /// Parameters and shape are then those of the last converged solve.
  SolveReport solve_to_equilibrium();
  /// Approximate equilibrium for use during a drag.
  ///
  /// Stops when the change falls below `tolerance`, relative to the size (the default is a
  /// hundredth of a pixel), or after `max_iterations`. If it has not converged, the next call
  /// continues from there.
  SolveReport solve_preview(int max_iterations = 4, double tolerance = 1e-5);
  /// Starts a motion with velocity 0 from the current shape; step() then advances it in time.
  /// Throws InputError for numbers that Motion does not allow, for example density and damping both
  /// 0.
  void start_motion(const Motion& motion);
  /// Advances the motion by one implicit time step dt, and keyframed parameters with it.
  SolveReport step();
  void stop_motion();
  bool in_motion() const;
  /// Sets the time of keyframed parameters for the following solves. Throws InputError in motion.
  void set_time(double time);

  // -- history ------------------------------------------------------------------------------------
  /// Undoes one step of the history. Returns false if there is nothing to undo.
  ///
  /// One edit is a step. All set() since the last solve_to_equilibrium() or edit are one step (a
  /// drag of one slider or of several), and so are all consecutive steps of a motion.
  bool undo();
  bool redo();
  /// Switches the recording of operations on or off; it is initially off. The record grows by pages
  /// of 4,096 operations. Operations that throw are recorded as well.
  void record(bool on);
  const std::vector<Operation>& recorded() const;
  void apply(const Operation& operation);  ///< executes one operation like its own function
  /// Executes a recorded sequence of operations and returns how many threw.
  ///
  /// Operations that throw are skipped, as they were when they were recorded. On a session made
  /// from the same input, the result is bit-identical.
  int replay(const std::vector<Operation>& operations);

  // -- refinement ---------------------------------------------------------------------------------
  /// Refines triangles by bisection, transfers the shape and all loads and constraints to the new
  /// mesh, and solves to equilibrium. Throws InputError for strokes, fractions or sizes out of
  /// range, and for too many triangles.
  RefinementReport refine(const Refinement& refinement);

  // -- results ------------------------------------------------------------------------------------
  const ModelLayout& layout() const;
  Points dofs() const;
  SkinnedRegion region(int r = 0) const;  ///< with its lines at their current positions
  std::vector<SkinnedRegion> regions() const;
  /// Points and normals of the current shape, in a buffer that the next call overwrites.
  const Frame& frame();
  /// Writes the same into a frame of the caller (FrameExchange::writing()). `moved` is true if the
  /// shape has changed since the last frame() or draw().
  void draw(Frame& to);
  /// Largest residual of all constraints under the values of the last solve, relative to the size.
  double residual() const;
  /// Elastic energy of the current shape on the domain scaled to size 1; in relative units over
  /// size².
  SurfaceEnergy energy() const;
  /// Total energy under the current parameter values, in the units of energy(): elastic energy
  /// minus Fᵀx of the loads, plus the energy of springs and, in motion, kinetic energy.
  ///
  /// It never grows under constant loads that do not follow the surface. Pressure p contributes
  /// -p V (V: the enclosed volume), which is its potential if the boundary is fixed.
  double total_energy() const;
  /// Reaction force of each line and constraint at equilibrium. Factors a matrix of the
  /// constraints.
  std::vector<Reaction> reactions() const;
  /// Distances of the points of each Load::PointCloudSprings from the current surface and, for
  /// comparison, from `before`, another shape on the layout.
  std::vector<PointCloudDistances> scan_distances(const Points& before) const;
  double enclosed_volume() const;  ///< ⅓ ∬ x·(x_u × x_v)
  size_t history_bytes() const;

 private:
  std::unique_ptr<SessionData> data_;
};

}  // namespace batten
