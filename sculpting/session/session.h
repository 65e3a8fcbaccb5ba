// Live sculpting: loads, dynamics and constraints that can change at any moment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fairing/energy.h"
#include "batten/sculpting/session/frame.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/results.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// A surface under the user's hands.
///
///     SculptingSession session(layout, options);
///     session.add(Load{"swell", Load::Pressure{}}, {{.name = "swell", .max = 300}});
///     session.settle();
///     while (dragging) {
///       session.set("swell", slider);
///       session.answer();              // one or a few pairs of triangular solves
///       draw(session.frame());         // points and exact normals
///     }
///
/// A region or a whole model: lines that regions share move them together, smooth joins stay smooth
/// under everything (their rows stand among those of the lines), creases stay creases. Where moves
/// turn the tangents of lines at a node, joins there are only as smooth as the rows of before can
/// have it until settle() plans them again.
///
/// State: dofs, velocities, time, parameter values. What they are made with (mesh, K, factor, rows)
/// is shared and immutable, so undo() and redo() put back pointers: the same bits, no downdating.
///
/// What a change costs (docs/theory/sculpting.md has the measurements):
///
///     value of linear loads only         an axpy each (superposed; one solve at the first move)
///     right-hand side of a constraint,   one pair of triangular solves
///       line or move
///     follower pressure, curved springs  one pair for each iteration, warm from the last ones
///     a geometric constraint added       one solve for each new point; removed: none
///     alpha, beta                        numbers of the factor again, its analysis kept
///     lines added or removed, refinement everything of the mesh
///
/// set(), answer() and step() allocate nothing once each kind of answer was given (but for the
/// history's first entry of a drag, and the record's pages). Every change either happens or throws
/// and leaves the last good state: ConflictError names the constraints in conflict.
///
/// One thread at a time; a viewer thread takes frames through FrameExchange.
class SculptingSession {
 public:
  /// Settles once. Throws InputError, ConflictError, NoSolutionError.
  SculptingSession(ModelLayout layout, const SessionOptions& options,
                   const Progress& progress = {});
  ~SculptingSession();
  SculptingSession(SculptingSession&&) noexcept;
  SculptingSession& operator=(SculptingSession&&) noexcept;

  // -- parameters ---------------------------------------------------------------------------------
  const Parameters& parameters() const;
  /// Takes effect with the next answer(), step() or settle(). Throws InputError.
  void set(const std::string& parameter, double value) {
    set(parameters().index(parameter), value);
  }
  void set(int parameter, double value);
  /// A parameter that drives others, or stands alone.
  void add_parameter(NamedValue parameter);
  void drive(const std::string& parameter, std::vector<NamedValue::Share> follows, double offset);

  // -- what acts on the surface -------------------------------------------------------------------
  /// `parameters`: start value, range and moments of the parameters that come with it (by name;
  /// those not given start at 0, a point's goal where it says). They take effect with the next
  /// answer; constraints and lines hold at once (the surface settles). Throws InputError: a name
  /// that is taken, places far from the surface, numbers; ConflictError.
  /// A line is one inner line more, embedded where the surface is nearest to it.
  void add(Operation::Thing thing, std::vector<NamedValue> parameters = {});
  /// Another place or direction for a constraint of this name.
  void change(Constraint constraint);
  /// A load, weight, constraint, move, or inner embedded line. Throws InputError: no such name, one
  /// that others refer to.
  void remove(const std::string& name);
  /// Another shape of a line over the same parameters and nodes as layout().line(). Moves
  /// right-hand sides only.
  void set_line(const std::string& line, HermiteCurve curve);
  /// The line as the surface has it: the layout's, and what moves add to it.
  HermiteCurve line(const std::string& name) const;
  std::vector<std::string> names() const;  ///< of everything that remove() knows

  // -- answers ------------------------------------------------------------------------------------
  /// The static shape under everything as it stands, to the session's tolerance. Throws
  /// NoSolutionError, with the values reached, when pressure is past its limit; parameters and
  /// shape are then those of the last answer that converged.
  Answer settle();
  /// The same for a drag: stops at the tolerance (a hundredth of a pixel) or after so many
  /// iterations (not converged: call it again, and it goes on).
  Answer answer(int most_iterations = 4, double tolerance = 1e-5);
  /// From the shape as it is, at rest; from then on step() goes on in time.
  void start_motion(const Motion& motion);
  /// One implicit step of dt; time functions move on.
  Answer step();
  void stop_motion();
  bool in_motion() const;
  /// Values at a time for the static answers that follow. Throws InputError when in motion.
  void set_time(double time);

  // -- history ------------------------------------------------------------------------------------
  /// Every edit is one step of the history; so are all set() since the last settle() or edit (a
  /// drag of one slider or of several), and all steps of a motion in a row. False: nothing to undo.
  bool undo();
  bool redo();
  /// Off at first. Pages of 4,096 operations. Those that throw are recorded too.
  void record(bool on);
  const std::vector<Operation>& recorded() const;
  void apply(const Operation& operation);
  /// Does it all again; what threw then throws now, and is passed over. On a session made from the
  /// same input: bit for bit the same. Returns how many threw.
  int replay(const std::vector<Operation>& operations);

  // -- refinement ---------------------------------------------------------------------------------
  RefinementReport refine(const Refinement& refinement);

  // -- results ------------------------------------------------------------------------------------
  const ModelLayout& layout() const;
  Points dofs() const;
  SkinnedRegion region(int r = 0) const;  ///< with lines as they are moved
  std::vector<SkinnedRegion> regions() const;
  /// Points and normals of the shape as it is, in a buffer that the next call writes again.
  const Frame& frame();
  /// The same into a frame of the caller's: FrameExchange::writing(). `moved`: since the last
  /// drawing.
  void draw(Frame& to);
  /// Largest over all constraint rows, over the size, under the values of the last answer.
  double residual() const;
  SurfaceEnergy energy() const;
  /// Under the values as they are set: elastic energy less the work of the loads, springs, and in
  /// motion kinetic energy, in the units of energy(): never grows under loads that stand and do not
  /// follow. Of pressure: ⅔ p V, which is its potential where the rim is held.
  double total_energy() const;
  /// Force with which each line and constraint holds the surface. At rest; factors a matrix of the
  /// rows.
  std::vector<Reaction> reactions() const;
  /// Of each Load::Scan: how far its points are from the surface. `before`: a shape on the
  /// layout to compare with.
  std::vector<ScanDistances> scan_distances(const Points& before) const;
  double enclosed_volume() const;  ///< ⅓ ∬ x·(x_u × x_v)
  size_t history_bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
