// Live sculpting: loads, dynamics and constraints that can change at any moment.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/core/progress.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/fairing/energy.h"
#include "batten/sculpting/frame.h"
#include "batten/sculpting/loads.h"
#include "batten/sculpting/parameters.h"
#include "batten/sculpting/results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// How a surface moves: M (ρ ẍ + μ ẋ) + K x = F (constraints/implicit_steps.h).
struct Motion {
  double dt = 0;       ///< > 0
  double density = 1;  ///< ρ ≥ 0
  double damping = 1;  ///< μ ≥ 0
  double theta = 1;    ///< ½ … 1
};

struct SessionOptions {
  SurfaceStiffness material;  ///< the parameters alpha and beta (or alpha_uu, … beta_vv) start here
  bool isotropic_alpha = true, isotropic_beta = true;  ///< one parameter each, or three
  LoadUnits units = LoadUnits::Relative;
  bool hold_corners = false;  ///< instead of the lines
  /// One: the session settles once or twice, and a better order of its factor would not pay.
  Expected expected = Expected::many_factors;
  /// Of settle(): converged when no dof inside moves by more than this times the size in one
  /// iteration (slopes times the size of their triangles), or by less than 1e-9 that does not fall
  /// any more.
  double tolerance = 1e-12;
  int most_iterations = 60;
  /// Undo keeps states and factors up to this many bytes, and at least one step.
  size_t history_bytes = size_t(512) << 20;
  int facets_per_edge = 2;  ///< of the frames
};

/// What an answer took.
struct Answer {
  bool converged = true;
  int iterations = 0;       ///< pairs of triangular solves
  double change = 0;        ///< of the last iteration, over the region's size
  bool superposed = false;  ///< only linear loads moved: no solve at all
  /// `change` is five times what the last answers let expect after this first iteration; every
  /// fourth answer iterates once more and sees.
  bool expected = false;
  bool factored = false;  ///< a new factor was needed
  /// settle(): lines that moved had turned tangents at nodes, and smooth joins were planned again.
  bool joins_planned = false;
  double time = 0;  ///< of the motion
};

/// Which triangles to halve, and how often at most.
struct Refinement {
  struct Brush {
    std::vector<Area::Painted::Stroke> strokes;  ///< all triangles they touch
  };
  struct Jumps {
    double share = 0.3;  ///< of the indicator's sum that the halved triangles carry
  };
  std::variant<Brush, Jumps> where;
  double smallest = 0;  ///< no edge shorter than this in space, model units; 0: size / 2000
  int most_triangles = 200000;
};

struct RefinementReport {
  int triangles_before = 0, triangles = 0;
  double max_displacement = 0;  ///< of the surface by carrying it over, before it settles again;
                                ///< over the size
  double energy_before = 0, energy_carried = 0, energy_settled = 0;  ///< alpha and beta parts
};

/// One thing that was done to a session: what replay() needs.
struct Operation {
  struct Add {
    std::variant<Load, WeightField, Constraint, LineMove, CharacterLine> what;
    std::vector<NamedValue> parameters;  ///< start values and ranges
  };
  struct Change {
    Constraint constraint;
  };
  struct Remove {
    std::string name;
  };
  struct SetLine {
    std::string line;
    HermiteCurve curve;
  };
  struct AddParameter {
    NamedValue parameter;
  };
  struct Drive {
    std::string parameter;
    std::vector<NamedValue::Share> follows;
    double offset = 0;
  };
  using Edit = std::variant<Add, Change, Remove, SetLine, Refinement, Motion, AddParameter, Drive>;
  enum class Kind { Set, Settle, Answer, Step, Rest, Time, Undo, Redo, Edit } kind = Kind::Settle;
  int index = 0;     ///< Set: parameter; Answer: most iterations
  double value = 0;  ///< Set; Answer: tolerance; Time
  std::shared_ptr<const Edit> edit;
};

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
  void add(Load load, std::vector<NamedValue> parameters = {});
  void add(WeightField weight, std::vector<NamedValue> parameters = {});
  void add(Constraint constraint, std::vector<NamedValue> parameters = {});
  void add(LineMove move, std::vector<NamedValue> parameters = {});
  /// An inner line more, embedded where the surface is nearest to it.
  void add(CharacterLine line);
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
  /// Of each Load::Springs: how far its points are from the surface. `before`: a shape on the
  /// layout to compare with.
  std::vector<SpringDistances> spring_distances(const Points& before) const;
  double enclosed_volume() const;  ///< ⅓ ∬ x·(x_u × x_v)
  size_t history_bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
