// What is done to a session, and what it answers.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "batten/fem/curve.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

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
  using Thing = std::variant<Load, WeightField, Constraint, LineMove, CharacterLine>;
  struct Add {
    Thing what;
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
  std::shared_ptr<const Edit> edit = {};
};

}  // namespace batten
