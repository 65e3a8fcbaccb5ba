#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

using detail::SessionDefinition;

void SessionData::rebuild(SessionDefinition def) {
  // Values by name: numbers of parameters change.
  struct Known {
    std::string name;
    double good, shape;
    char fresh;
  };
  std::vector<Known> known;
  for (size_t i = 0; i < now.converged_values.size(); ++i)
    known.push_back({value_names[i], now.converged_values[i], now.shape_values[i], now.fresh[i]});
  now.system = detail::build(std::move(def), now.parameters, now.system.get());
  engine.bind(system());
  update_value_names();
  // What is new has not acted on the shape yet.
  const auto& parameters = now.parameters.all();
  now.converged_values.resize(parameters.size());
  now.shape_values.resize(parameters.size());
  now.fresh.resize(parameters.size());
  for (size_t p = 0; p < parameters.size(); ++p) {
    const auto it = std::find_if(known.begin(), known.end(),
                                 [&](const Known& k) { return k.name == parameters[p].name; });
    const bool goal = system().roles[p] & detail::kGoal;
    const double start = goal ? now.parameters.value(static_cast<int>(p)) : 0;
    const Known k = it != known.end() ? *it : Known{"", start, start, 1};
    now.converged_values[p] = k.good;
    now.shape_values[p] = k.shape;
    now.fresh[p] = k.fresh;
  }
}

// Of which parameter each value is.
void SessionData::update_value_names() {
  value_names.clear();
  for (const ScalarParameter& p : now.parameters.all()) value_names.push_back(p.name);
}

// After the rows changed: on the static shape, bent from the rest shape as it is, or in motion as
// near as can be.
void SessionData::solve_constrained() {
  read_values();
  if (!now.in_motion) {
    solve_to_equilibrium(false);
    return;
  }
  update_rest_shape(false);
  engine.prepare_matrix(system(), values);
  engine.project(system(), values, now.shape);
  ++version;
  mark_converged();
}

// After loads changed: the shape stays as it is, for the values that it was made with.
void SessionData::keep_shape() {
  read_values();
  engine.prepare_matrix(system(), values);
}

void SessionData::require_free_name(const std::string& name) {
  if (name.empty()) throw InputError("something that acts on the surface has no name");
  const SessionDefinition& d = system().def;
  if (detail::index_of(d.loads, name) >= 0 || detail::index_of(d.weights, name) >= 0 ||
      detail::index_of(d.constraints, name) >= 0 || detail::index_of(d.moves, name) >= 0 ||
      layout().has_line(name))
    throw InputError("two things have the name '" + name + "'");
}

void SessionData::add_parameters(const std::string& name,
                                            std::vector<ScalarParameter> given,
                                            const std::vector<std::string>& wanted,
                                            const std::vector<double>& start) {
  for (const ScalarParameter& g : given)
    if (std::find(wanted.begin(), wanted.end(), g.name) == wanted.end())
      throw InputError("'" + name + "' has no parameter '" + g.name + "'");
  for (size_t i = 0; i < wanted.size(); ++i) {
    const auto it = std::find_if(given.begin(), given.end(),
                                 [&](const ScalarParameter& g) { return g.name == wanted[i]; });
    ScalarParameter value;
    value.name = wanted[i];
    value.value = start[i];
    now.parameters.add(it == given.end() ? value : *it);
  }
}

void SessionData::add(const Load& load, const std::vector<ScalarParameter>& parameters) {
  require_free_name(load.name);
  SessionDefinition def = system().def;
  def.loads.push_back(
      std::make_shared<const detail::AttachedLoad>(detail::attach(load, def, surface())));
  add_parameters(load.name, parameters, {load.name}, {0});
  rebuild(std::move(def));
  keep_shape();
}

void SessionData::add(const StiffnessField& weight,
                                 const std::vector<ScalarParameter>& parameters) {
  require_free_name(weight.name);
  SessionDefinition def = system().def;
  def.weights.push_back(std::make_shared<const detail::AttachedStiffnessField>(
      detail::attach(weight, def, surface())));
  add_parameters(weight.name, parameters, {weight.name}, {0});
  rebuild(std::move(def));
  keep_shape();
}

void SessionData::add(const Constraint& constraint,
                                 const std::vector<ScalarParameter>& parameters) {
  require_free_name(constraint.name);
  SessionDefinition def = system().def;
  def.constraints.push_back(std::make_shared<const detail::AttachedConstraint>(
      detail::attach(constraint, def, surface())));
  std::vector<std::string> wanted;
  std::vector<double> start;
  if (const auto* point = std::get_if<Constraint::Point>(&constraint.kind))
    for (int c = 0; c < 3; ++c) {
      wanted.push_back(constraint.name + detail::kAxes[c]);
      start.push_back(point->goal[c]);
    }
  add_parameters(constraint.name, parameters, wanted, start);
  rebuild(std::move(def));
  solve_constrained();
}

void SessionData::add(const LineOffset& move,
                                 const std::vector<ScalarParameter>& parameters) {
  require_free_name(move.name);
  SessionDefinition def = system().def;
  def.moves.push_back(
      std::make_shared<const detail::AttachedOffset>(detail::attach(move, def, surface())));
  add_parameters(move.name, parameters, {move.name}, {0});
  rebuild(std::move(def));
  solve_constrained();
}

void SessionData::add(const CharacterLine& line,
                                 const std::vector<ScalarParameter>& parameters) {
  if (!parameters.empty()) throw InputError("line '" + line.name + "' has no parameters");
  require_free_name(line.name);
  require_lines("added");
  ModelLayout layout = this->layout();
  layout.add_inner_line(line, absolute(now.shape.x));
  change_layout(std::move(layout));
}

void SessionData::change(const Constraint& constraint) {
  SessionDefinition def = system().def;
  const int at = detail::index_of(def.constraints, constraint.name);
  if (at < 0)
    throw InputError("there is no constraint '" + constraint.name + "'" +
                     name_suggestion(constraint.name));
  auto& placed = def.constraints[at];
  if (placed->constraint.kind.index() != constraint.kind.index())
    throw InputError("constraint '" + constraint.name +
                     "' changes its place or direction, not its kind: remove it first");
  placed = std::make_shared<const detail::AttachedConstraint>(
      detail::attach(constraint, def, surface()));
  if (const auto* point = std::get_if<Constraint::Point>(&constraint.kind))
    for (int c = 0; c < 3; ++c)
      now.parameters.set(constraint.name + detail::kAxes[c], point->goal[c]);
  rebuild(std::move(def));
  solve_constrained();
}

std::vector<std::string> SessionData::names() {
  std::vector<std::string> all;
  const SessionDefinition& d = system().def;
  for (const auto& p : d.loads) all.push_back(detail::name_of(*p));
  for (const auto& p : d.weights) all.push_back(detail::name_of(*p));
  for (const auto& p : d.constraints) all.push_back(detail::name_of(*p));
  for (const auto& p : d.moves) all.push_back(detail::name_of(*p));
  for (int r = 0; r < layout().region_count(); ++r)
    for (const EmbeddedLine& line : layout().region(r).embedded())
      if (line.line.role == CharacterLine::Role::Inner) all.push_back(line.line.name);
  return all;
}

std::string SessionData::name_suggestion(const std::string& name) {
  const std::string near = closest_match(name, names());
  return near.empty() ? "" : "; did you mean '" + near + "'?";
}

void SessionData::remove(const std::string& name) {
  SessionDefinition def = system().def;
  const int held = detail::index_of(def.constraints, name);
  const bool was_point = held >= 0 && std::holds_alternative<Constraint::Point>(
                                          def.constraints[held]->constraint.kind);
  const auto take = [&](auto& things) {
    const int at = detail::index_of(things, name);
    if (at >= 0) things.erase(things.begin() + at);
    return at >= 0;
  };
  const bool load = take(def.loads), weight = !load && take(def.weights),
             constraint = !load && !weight && take(def.constraints),
             move = !load && !weight && !constraint && take(def.moves);
  if (load || weight || move) now.parameters.remove(name);
  if (constraint && was_point)
    for (const char* axis : detail::kAxes) now.parameters.remove(name + axis);
  if (load || weight || constraint || move) {
    rebuild(std::move(def));
    if (load || weight)
      keep_shape();
    else
      solve_constrained();
    return;
  }
  if (!layout().has_line(name))
    throw InputError("there is nothing with the name '" + name + "' to remove" +
                     name_suggestion(name));
  require_unused(name);
  ModelLayout layout = this->layout();
  layout.remove_inner_line(name);
  change_layout(std::move(layout));
}

void SessionData::start_motion(const Motion& m) {
  if (!(m.dt > 0) || !std::isfinite(m.dt))
    throw InputError("a time step of " + format_number(m.dt) + ": expected one above 0");
  if (!(m.density >= 0) || !(m.damping >= 0) || !(m.density + m.damping > 0) ||
      !std::isfinite(m.density + m.damping))
    throw InputError("density " + format_number(m.density) + " and damping " +
                     format_number(m.damping) + ": expected both 0 or more, and not both 0");
  if (!(m.theta >= 0.5) || !(m.theta <= 1))
    throw InputError("theta = " + format_number(m.theta) + ": expected 0.5 to 1");
  now.motion = m;
  now.in_motion = true;
  now.shape.v.setZero();
  read_values();
  engine.prepare_matrix(system(), values);
  engine.prepare_motion(system(), m);
}

double SessionData::elastic_energy(const Points& x) {
  const SurfaceEnergy e = engine.elastic_energy(system(), values, x);
  return (e.stretching + e.bending) * system().def.scale().energy_factor();
}

void SessionData::edit(const Operation::Edit& edit) {
  if (const auto* added = std::get_if<Operation::Add>(&edit))
    std::visit([&](const auto& what) { add(what, added->parameters); }, added->what);
  else if (const auto* changed = std::get_if<Operation::Change>(&edit))
    change(changed->constraint);
  else if (const auto* removed = std::get_if<Operation::Remove>(&edit))
    remove(removed->name);
  else if (const auto* line = std::get_if<Operation::SetLine>(&edit))
    set_line(line->line, line->curve);
  else if (const auto* motion = std::get_if<Motion>(&edit))
    start_motion(*motion);
  else if (const auto* parameter = std::get_if<Operation::AddParameter>(&edit)) {
    now.parameters.add(parameter->parameter);
    rebuild(system().def);
    keep_shape();
  } else if (const auto* rule = std::get_if<Operation::SetRule>(&edit)) {
    now.parameters.set_rule(rule->parameter, rule->rule_terms, rule->offset);
  }
}

}  // namespace batten
