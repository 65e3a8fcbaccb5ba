// Writes and reads the parts of a session's log as JSON: loads, weights, constraints, moves, lines,
// parameters. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/io/sessions/session_log_json.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/lines/character_line.h"

namespace batten::session_log {

/// A function object for std::visit, made of one function for each kind.
template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

LogJson json_of(const std::vector<Area::Painted::Stroke>& strokes);
LogJson json_of(const HermiteCurve& curve);
LogJson json_of(const Load& load);
LogJson json_of(const StiffnessField& weight);
LogJson json_of(const Constraint& constraint);
LogJson json_of(const LineOffset& move);
/// Throws InputError for a line that is not piecewise cubic and C1.
LogJson json_of(const CharacterLine& line);
LogJson json_of(const std::vector<ScalarParameter::Term>& terms);
LogJson json_of(const ScalarParameter& parameter);

// These read what the parent holds under `key`, or under the key named behind them. They throw
// InputError with the line of the log.
std::vector<Area::Painted::Stroke> strokes_of(const LogObject& parent, const std::string& key);
std::vector<ScalarParameter::Term> terms_of(const LogObject& parent, const std::string& key);
HermiteCurve curve_of(const LogObject& parent, const std::string& key);
Load load_of(const LogObject& parent);                  // "load"
StiffnessField weight_of(const LogObject& parent);      // "weight"
Constraint constraint_of(const LogObject& parent);      // "constraint"
LineOffset move_of(const LogObject& parent);            // "move"
CharacterLine line_of(const LogObject& parent);         // "line"
ScalarParameter parameter_of(const LogObject& parent);  // "parameter"
/// Reads "parameters"; none when the key is missing.
std::vector<ScalarParameter> parameters_of(const LogObject& parent);

}  // namespace batten::session_log
