// The operations on a session, as data, and what an answer reports.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// How an answer was reached.
struct SolveReport {
  bool converged = true;
  int iterations = 0;       ///< pairs of triangular solves
  double change = 0;        ///< change of the last iteration, over the model's size
  bool superposed = false;  ///< only linear loads moved: a sum of known shapes
  /// The answer stopped after its first iteration: `change` is not measured but is five times what
  /// the answers before let expect. Every fourth answer makes a second iteration and measures it.
  bool change_is_estimated = false;
  bool factored = false;  ///< a new factor was needed
  /// settle() planned smooth joins again, because moved lines had turned the tangents at nodes.
  bool joins_planned = false;
  double time = 0;  ///< time of the motion, or of the values
};

/// Says which triangles are halved, and the limits of that.
struct Refinement {
  struct Brush {
    std::vector<Area::Painted::Stroke> strokes;  ///< triangles that have a point inside of one
  };
  struct JumpIndicator {
    double fraction = 0.3;  ///< the halved triangles carry this share of the sum of all jumps
  };
  std::variant<Brush, JumpIndicator> where;
  /// A triangle is halved only when its longest edge in space is longer than twice this; model
  /// units; 0: size / 2000.
  double smallest = 0;
  int max_triangles = 200000;  ///< a refinement that would make more throws InputError
};

/// What a refinement did.
struct RefinementReport {
  int triangles_before = 0, triangles = 0;
  double max_displacement = 0;  ///< largest move of the surface when it was carried over, before it
                                ///< settled again; over the size
  double energy_before = 0, energy_transferred = 0,
         energy_at_equilibrium = 0;  ///< stretching and bending
};

/// One operation on a session, with all that replay() needs.
struct Operation {
  using Item = std::variant<Load, StiffnessField, Constraint, LineOffset, CharacterLine>;
  struct Add {
    Item what;
    std::vector<ScalarParameter> parameters;  ///< start values and ranges
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
    ScalarParameter parameter;
  };
  struct SetRule {
    std::string parameter;
    std::vector<ScalarParameter::Term> rule_terms;
    double offset = 0;
  };
  using Edit =
      std::variant<Add, Change, Remove, SetLine, Refinement, Motion, AddParameter, SetRule>;
  enum class Kind {
    Set,
    SolveToEquilibrium,
    SolvePreview,
    Step,
    StopMotion,
    Time,
    Undo,
    Redo,
    Edit
  } kind = Kind::SolveToEquilibrium;
  int index = 0;     ///< Set: parameter; SolvePreview: most iterations
  double value = 0;  ///< Set; SolvePreview: tolerance; Time
  std::shared_ptr<const Edit> edit = {};
};

}  // namespace batten
