// SPDX-License-Identifier: MPL-2.0
// Operations on a sculpting session as data (for recording and replay), and the reports of solves
// and refinements.
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

/// Result of a solve: convergence and cost.
struct SolveReport {
  bool converged = true;
  int iterations = 0;  ///< number of iterations, each with one pair of triangular solves
  double change = 0;   ///< change of the shape in the last iteration, relative to the model size
  bool superposed = false;  ///< true: only linear loads changed; the shape is a sum of known shapes
  /// True: the solve stopped after its first iteration, and `change` is not measured but estimated
  /// as five times the value expected from previous solves. Every fourth solve makes a second
  /// iteration and measures `change`.
  bool change_is_estimated = false;
  bool factored = false;  ///< true: a new factorization was needed
  /// True: solve_to_equilibrium() recomputed the constraints of smooth joins, because moved curves
  /// had rotated the tangents at nodes.
  bool joins_planned = false;
  double time = 0;  ///< current time of the motion or of the keyframes
};

/// Selects the triangles to be refined by bisection, and the limits of the refinement.
struct Refinement {
  struct Brush {
    /// Triangles that contain a point inside one of these strokes are refined.
    std::vector<Area::Painted::Stroke> strokes;
  };
  /// Dörfler marking by the jump estimator residual_indicator() [Dorfler1996].
  struct JumpIndicator {
    /// Fraction of the sum of all indicators that the marked triangles account for.
    double fraction = 0.3;
  };
  std::variant<Brush, JumpIndicator> where;
  /// Smallest edge length, model units; 0: model size / 2000. A triangle is refined only if its
  /// longest edge in space is longer than twice this length.
  double smallest = 0;
  /// Maximum number of triangles; refine() throws InputError if it would be exceeded.
  int max_triangles = 200000;
};

/// Result of a refinement.
struct RefinementReport {
  int triangles_before = 0, triangles = 0;
  /// Largest displacement of the surface by the transfer to the new mesh, before the new
  /// equilibrium is computed, divided by the model size.
  double max_displacement = 0;
  /// Elastic energy before the refinement, after the transfer, and at the new equilibrium.
  double energy_before = 0, energy_transferred = 0, energy_at_equilibrium = 0;
};

/// One operation on a SculptingSession, with all data that its replay() needs.
struct Operation {
  using Item = std::variant<Load, StiffnessField, Constraint, LineOffset, CharacterLine>;
  struct Add {
    Item what;
    /// Initial values and ranges of the parameters of the item.
    std::vector<ScalarParameter> parameters;
  };
  /// Replaces the constraint that has the name of `constraint`.
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
  int index = 0;     ///< parameter index of Set, or maximum number of iterations of SolvePreview
  double value = 0;  ///< value of Set, tolerance of SolvePreview, or time of Time
  std::shared_ptr<const Edit> edit = {};
};

}  // namespace batten
