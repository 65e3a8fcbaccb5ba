// Live sculpting: loads, dynamics and constraints that can change at any moment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

struct SessionData;

/// A surface that the user shapes live.
///
///     SculptingSession session(layout, options);
///     session.add(Load{"swell", Load::Pressure{}}, {{.name = "swell", .max = 300}});
///     session.solve_to_equilibrium();
///     while (dragging) {
///       session.set("swell", slider);
///       session.solve_preview();              // one or a few pairs of triangular solves
///       draw(session.frame());         // points and exact normals
///     }
///
/// It is a region or a whole model: lines that regions share move them together, smooth joins stay
/// smooth whatever acts (their rows stand among those of the lines), creases stay creases. Moves
/// that turn the tangents of lines at a node leave the joins there less smooth, because their rows
/// are those of the lines before; solve_to_equilibrium() plans them again.
///
/// The state is dofs, velocities, time and parameter values. What they are made with (mesh, K,
/// factor, rows) is shared and immutable, so undo() and redo() put back pointers: the shape comes
/// back with the same bits, and nothing is factored.
///
/// What a change costs (docs/theory/sculpting.md has the measurements):
///
///     value of linear loads only         a sum of vectors (superposed; one solve at a first move)
///     right-hand side of a constraint,   one pair of triangular solves
///       line or move
///     pressure, pulls that are not       one pair for each iteration, which starts from the
///       linear                             last shape
///     a geometric constraint added       one solve for each new point; removed: none
///     alpha, beta                        numbers of the factor again, its analysis kept
///     lines added or removed, refinement everything of the mesh
///
/// set(), solve_preview() and step() allocate nothing once each kind of answer was given (but for the
/// history's first entry of a drag, and the record's pages). Every change either happens or throws
/// and leaves the last good state: ConflictError names the constraints in conflict.
///
/// One thread at a time may call it; a viewer's thread takes frames through FrameExchange.
class SculptingSession {
 public:
  /// Makes a session on which nothing acts but the lines, and settles it. The session keeps
  /// `progress` and asks it in its long answers, too. Throws InputError, ConflictError,
  /// NoSolutionError.
  SculptingSession(ModelLayout layout, const SessionOptions& options,
                   const Progress& progress = {});
  ~SculptingSession();
  SculptingSession(SculptingSession&&) noexcept;
  SculptingSession& operator=(SculptingSession&&) noexcept;

  // -- parameters ---------------------------------------------------------------------------------
  const Parameters& parameters() const;
  /// Sets a parameter by hand; it acts from the next solve_preview(), step() or solve_to_equilibrium() on. Throws
  /// InputError as Parameters::set().
  void set(const std::string& parameter, double value) {
    set(parameters().index(parameter), value);
  }
  void set(int parameter, double value);
  /// Adds a parameter for others to follow.
  void add_parameter(ScalarParameter parameter);
  /// Makes a parameter follow others, or stand alone again: Parameters::set_rule().
  void set_rule(const std::string& parameter, std::vector<ScalarParameter::Term> rule_terms,
                double offset);

  // -- what acts on the surface -------------------------------------------------------------------
  /// Adds something that acts, on the surface as it is; a line is an inner one, embedded where the
  /// surface is nearest to it. `parameters`: start value, range and moments of the parameters that
  /// come with it, by name; those not given start at 0, the goal of a point at Point::goal. Loads
  /// and weight fields act from the next answer on; constraints, moves and lines hold at once (the
  /// surface settles). Throws InputError: a name that is taken, places far from the surface (half
  /// the size), numbers out of range; ConflictError.
  void add(Operation::Item thing, std::vector<ScalarParameter> parameters = {});
  /// Gives the constraint of this name another place, goal or direction. It stays of one kind.
  void change(Constraint constraint);
  /// Removes a load, weight field, constraint, move or embedded inner line. Throws InputError: no
  /// such name, or one that others refer to.
  void remove(const std::string& name);
  /// Gives a line another shape, over the same parameters and nodes as layout().line(). Only
  /// right-hand sides change; the surface settles.
  void set_line(const std::string& line, HermiteCurve curve);
  /// Returns the line as the surface has it: the layout's, and what moves add to it.
  HermiteCurve line(const std::string& name) const;
  std::vector<std::string> names() const;  ///< of everything that remove() knows

  // -- answers ------------------------------------------------------------------------------------
  /// Finds the shape at rest under all that acts, to the session's tolerance. Throws
  /// NoSolutionError, with the values reached, when pressure is past its limit; parameters and
  /// shape are then those of the last answer that converged.
  SolveReport solve_to_equilibrium();
  /// Does the same for a drag: it stops at the tolerance, over the size (a hundredth of a pixel),
  /// or after so many iterations. When it has not converged, the next call goes on from there.
  SolveReport solve_preview(int max_iterations = 4, double tolerance = 1e-5);
  /// Starts a motion from the present shape with velocity 0; step() then goes on in time. Throws
  /// InputError: numbers that Motion does not allow, density and damping both 0.
  void start_motion(const Motion& motion);
  /// Makes one implicit step of dt; values over time go on with it.
  SolveReport step();
  void stop_motion();
  bool in_motion() const;
  /// Sets the time for values over time, for the answers that follow. Throws InputError in motion.
  void set_time(double time);

  // -- history ------------------------------------------------------------------------------------
  /// Puts the state back by one step of the history. One edit is a step; so are all set() since the
  /// last solve_to_equilibrium() or edit (a drag of one slider or of several), and all steps of a motion in a
  /// row. Returns false when there is nothing to undo.
  bool undo();
  bool redo();
  /// Switches the record of operations on or off; at first it is off. It grows by pages of 4,096
  /// operations. Those that throw are recorded too.
  void record(bool on);
  const std::vector<Operation>& recorded() const;
  void apply(const Operation& operation);  ///< does one operation, as its own function does
  /// Does all operations again and passes over those that throw, as they did when they were
  /// recorded; returns how many threw. On a session made from the same input the result is the same
  /// bit for bit.
  int replay(const std::vector<Operation>& operations);

  // -- refinement ---------------------------------------------------------------------------------
  /// Halves triangles, carries the shape and all that acts over to the new mesh, and settles again.
  /// Throws InputError: strokes, shares or sizes out of range, too many triangles.
  RefinementReport refine(const Refinement& refinement);

  // -- results ------------------------------------------------------------------------------------
  const ModelLayout& layout() const;
  Points dofs() const;
  SkinnedRegion region(int r = 0) const;  ///< with lines as they are moved
  std::vector<SkinnedRegion> regions() const;
  /// Returns points and normals of the present shape, in a buffer that the next call overwrites.
  const Frame& frame();
  /// Writes the same into a frame of the caller's, FrameExchange::writing(). Its `moved` says
  /// whether the shape has changed since the last frame() or draw().
  void draw(Frame& to);
  /// Returns the largest residual of all rows, over the size, under the values of the last answer.
  double residual() const;
  /// Returns the elastic energy of the present shape, on the domain scaled to size 1; over size² in
  /// relative units.
  SurfaceEnergy energy() const;
  /// Returns, under the values as they are set, elastic energy - 2 Fᵀx of the loads, plus the
  /// energy of springs, and in motion kinetic energy, in the units of energy(). It never grows
  /// under loads that are constant and do not follow. Pressure p counts with -2 p V (V: the
  /// enclosed volume), which is its potential where the rim is held.
  double total_energy() const;
  /// Returns the force with which each line and constraint holds the surface at rest. It factors a
  /// matrix of the rows.
  std::vector<Reaction> reactions() const;
  /// Returns for each Load::PointCloudSprings how far its points are from the surface, and from `before`,
  /// another shape on the layout to compare with.
  std::vector<PointCloudDistances> scan_distances(const Points& before) const;
  double enclosed_volume() const;  ///< ⅓ ∬ x·(x_u × x_v)
  size_t history_bytes() const;

 private:
  std::unique_ptr<SessionData> data_;
};

}  // namespace batten
