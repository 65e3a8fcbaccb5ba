// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/session/session_data.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/refinement.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

using detail::SessionDefinition;

void SessionData::rebuild(SessionDefinition def) {
  // Values are matched by name, because parameter indices change.
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
  // New parameters have not acted on the shape yet.
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

// Updates the parameter name of each value.
void SessionData::update_value_names() {
  value_names.clear();
  for (const ScalarParameter& p : now.parameters.all()) value_names.push_back(p.name);
}

// Call after the constraints changed. In statics, computes the equilibrium shape, deformed from the
// present rest shape. In motion, projects onto the constraints.
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

// Call after loads changed: the shape stays as it is, and belongs to the old values.
void SessionData::keep_shape() {
  read_values();
  engine.prepare_matrix(system(), values);
}

void SessionData::require_free_name(const std::string& name) {
  if (name.empty()) throw InputError("a load, stiffness field, constraint or offset has no name");
  const SessionDefinition& d = system().def;
  if (detail::index_of(d.loads, name) >= 0 || detail::index_of(d.weights, name) >= 0 ||
      detail::index_of(d.constraints, name) >= 0 || detail::index_of(d.moves, name) >= 0 ||
      layout().has_line(name))
    throw InputError("the name '" + name + "' is already used; choose a different one");
}

void SessionData::add_parameters(const std::string& name, std::vector<ScalarParameter> given,
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
  const auto placed = std::make_shared<const detail::AttachedConstraint>(
      detail::attach(constraint, def, surface()));
  def.constraints.push_back(placed);
  std::vector<std::string> wanted;
  std::vector<double> start;
  if (const auto* point = std::get_if<Constraint::Point>(&placed->constraint.kind))
    for (int c = 0; c < 3; ++c) {
      wanted.push_back(constraint.name + detail::kAxes[c]);
      start.push_back(point->goal[c]);
    }
  add_parameters(constraint.name, parameters, wanted, start);
  rebuild(std::move(def));
  solve_constrained();
}

void SessionData::add(const LineOffset& move, const std::vector<ScalarParameter>& parameters) {
  require_free_name(move.name);
  SessionDefinition def = system().def;
  def.moves.push_back(
      std::make_shared<const detail::AttachedOffset>(detail::attach(move, def, surface())));
  add_parameters(move.name, parameters, {move.name}, {0});
  rebuild(std::move(def));
  solve_constrained();
}

void SessionData::add(const CharacterLine& line, const std::vector<ScalarParameter>& parameters) {
  if (!parameters.empty()) throw InputError("curve '" + line.name + "' cannot have parameters");
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
                     did_you_mean(constraint.name, names()));
  auto& placed = def.constraints[at];
  if (placed->constraint.kind.index() != constraint.kind.index())
    throw InputError("constraint '" + constraint.name +
                     "' cannot change its type: remove it and add a new one");
  placed = std::make_shared<const detail::AttachedConstraint>(
      detail::attach(constraint, def, surface()));
  if (const auto* point = std::get_if<Constraint::Point>(&placed->constraint.kind))
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
    throw InputError("nothing named '" + name + "' can be removed" + did_you_mean(name, names()));
  require_unused(name);
  ModelLayout layout = this->layout();
  layout.remove_inner_line(name);
  change_layout(std::move(layout));
}

void SessionData::start_motion(const Motion& m) {
  if (!(m.dt > 0) || !std::isfinite(m.dt))
    throw InputError("found the time step " + format_number(m.dt) + ", expected a number above 0");
  if (!(m.density >= 0) || !(m.damping >= 0) || !(m.density + m.damping > 0) ||
      !std::isfinite(m.density + m.damping))
    throw InputError("found density " + format_number(m.density) + " and damping " +
                     format_number(m.damping) + ", expected 0 or more, and not both 0");
  if (!(m.theta >= 0.5) || !(m.theta <= 1))
    throw InputError("found theta = " + format_number(m.theta) + ", expected 0.5 to 1");
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

using detail::SessionDefinition;
using detail::ShapeState;

void SessionData::require_lines(const char* what) {
  if (system().def.fix_corners_only)
    throw InputError(std::string("curves cannot be ") + what +
                     " here: with boundary = \"corners\" only the corners are fixed");
}

// Transfers dofs from the current layout to the meshes of another one.
SurfaceTransfer SessionData::transferred(const ModelLayout& layout, const Points& dofs) {
  SurfaceTransfer all;
  std::vector<Points> each;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& from = this->layout().region(r);
    SurfaceTransfer own = interpolate_onto(
        Surface(from.mesh(), from.element(), this->layout().region_dofs(r, dofs), from.trim()),
        *layout.region(r).mesh());
    all.max_displacement = std::max(all.max_displacement, own.max_displacement);
    each.push_back(std::move(own.dofs));
  }
  all.dofs = layout.all_dofs(each);
  return all;
}

// Transfers the shapes to which loads, stiffness fields and constraints refer.
void SessionData::transfer_reference_shapes(const ModelLayout& layout, SessionDefinition& def) {
  std::vector<std::pair<detail::SharedPoints, detail::SharedPoints>> moved;
  const auto along = [&](detail::SharedPoints& on) {
    throw_if_cancelled();
    if (!on) return;
    for (const auto& [old, made] : moved)
      if (old == on) {
        on = made;
        return;
      }
    auto made = std::make_shared<const Points>(transferred(layout, *on).dofs);
    moved.emplace_back(on, made);
    on = made;
  };
  const auto follow = [&](auto& things) {
    for (auto& thing : things) {
      auto copy = *thing;
      along(copy.on);
      thing = std::make_shared<const std::decay_t<decltype(copy)>>(std::move(copy));
    }
  };
  follow(def.loads);
  follow(def.weights);
  follow(def.constraints);
}

// Replaces the layout by one with other meshes or lines and transfers the shape.
SurfaceTransfer SessionData::change_layout(ModelLayout layout) {
  bool other_mesh = false;
  for (int r = 0; r < layout.region_count(); ++r)
    other_mesh = other_mesh || layout.region(r).mesh() != this->layout().region(r).mesh();
  SessionDefinition def = system().def;
  SurfaceTransfer made;
  ShapeState shape = now.shape;
  if (other_mesh) {
    made = transferred(layout, absolute(now.shape.x));
    if (now.in_motion) shape.v = transferred(layout, now.shape.v).dofs;
    transfer_reference_shapes(layout, def);
  }
  if (other_mesh && !layout.join_plans().empty()) layout.plan_joins(made.dofs);
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  rebuild(std::move(def));
  if (other_mesh) {
    VecX ones = system().parts->ones;
    shape.x = made.dofs - ones * system().origin().transpose();
    if (!now.in_motion) shape.v = Points::Zero(shape.x.rows(), 3);
    now.shape = std::move(shape);
    now.converged_x = now.shape.x;
  }
  solve_constrained();
  return made;
}

void SessionData::require_unused(const std::string& line) {
  const auto refuse = [&](const std::string& user) {
    throw InputError("curve '" + line + "' cannot be removed: '" + user + "' uses it");
  };
  const auto near = [&](const Area& area) {
    const auto* at = std::get_if<Area::NearLine>(&area.where);
    return at && at->line == line;
  };
  for (const auto& p : system().def.loads) {
    if (const auto* l = std::get_if<Load::Line>(&p->load.kind); l && l->line == line)
      refuse(p->load.name);
    if (const auto* l = std::get_if<Load::Pressure>(&p->load.kind); l && near(l->area))
      refuse(p->load.name);
    if (const auto* l = std::get_if<Load::Uniform>(&p->load.kind); l && near(l->area))
      refuse(p->load.name);
  }
  for (const auto& p : system().def.weights) {
    const auto* along = p->weight.along ? std::get_if<std::string>(&*p->weight.along) : nullptr;
    if (near(p->weight.area) || (along && *along == line)) refuse(p->weight.name);
  }
  for (const auto& p : system().def.constraints)
    if (const auto* c = std::get_if<Constraint::LineNormal>(&p->constraint.kind);
        c && c->line == line)
      refuse(p->constraint.name);
  for (const auto& p : system().def.moves)
    if (p->move.line == line) refuse(p->move.name);
}

void SessionData::set_line(const std::string& name, const HermiteCurve& curve) {
  require_lines("edited");
  ModelLayout layout = this->layout();
  layout.set_line(name, curve);
  SessionDefinition def = system().def;
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  rebuild(std::move(def));
  solve_constrained();
}

HermiteCurve SessionData::line(const std::string& name) {
  HermiteCurve curve = layout().line(name);
  const SessionDefinition& def = system().def;
  for (size_t i = 0; i < def.moves.size(); ++i)
    if (def.moves[i]->move.line == name)
      curve = detail::sum(curve, def.moves[i]->displacement,
                          now.parameters.value(system().move_parameter[i]));
  return curve;
}

namespace {

// Selects the triangles to be refined.
std::vector<char> marks(const Refinement& refinement, const ModelLayout& layout,
                        const Surface& surface, const std::vector<double>& jumps) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> marked(static_cast<size_t>(mesh.triangle_count()), 0);
  const auto longest = [&](int t) {
    double length = 0;
    const auto& v = mesh.triangles()[t];
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = surface.dofs().row(surface.dof_map().vertex(v[i])),
                 b = surface.dofs().row(surface.dof_map().vertex(v[(i + 1) % 3]));
      length = std::max(length, (a - b).norm());
    }
    return length;
  };
  const double smallest = refinement.smallest;
  const auto mark = [&](int t) {
    if (longest(t) > 2 * smallest) marked[t] = 1;
  };
  if (const auto* brush = std::get_if<Refinement::Brush>(&refinement.where)) {
    if (brush->strokes.empty())
      throw InputError("the refinement brush has no strokes, expected one or more");
    for (const auto& stroke : brush->strokes) {
      if (!stroke.at.allFinite() || !(stroke.radius > 0) || !std::isfinite(stroke.radius))
        throw InputError("a refinement stroke needs a finite point and a radius above 0");
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        poll_every<1024>(t);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& L : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(.5, .5, 0),
                              Vec3(0, .5, .5), Vec3(.5, 0, .5), Vec3(1. / 3, 1. / 3, 1. / 3)})
          nearest = std::min(nearest, (surface.position({t, L}) - stroke.at).norm());
        if (nearest < stroke.radius) mark(t);
      }
    }
    return marked;
  }
  const double fraction = std::get<Refinement::JumpIndicator>(refinement.where).fraction;
  if (!(fraction > 0 && fraction <= 1))
    throw InputError("refinement: found the fraction " + format_number(fraction) +
                     " of the curvature jumps, expected a number above 0, at most 1");
  for (const int t : dorfler_marking(jumps, fraction)) mark(t);
  return marked;
}

}  // namespace

RefinementReport SessionData::refine(const Refinement& refinement) {
  RefinementReport report;
  report.triangles_before = layout().mesh()->triangle_count();
  Refinement wanted = refinement;
  if (!(wanted.smallest >= 0) || !std::isfinite(wanted.smallest))
    throw InputError("refinement: found the smallest edge length " +
                     format_number(wanted.smallest) + ", expected 0 or more");
  if (wanted.smallest == 0) wanted.smallest = size() / 2000;
  update_progress("refining", 0);
  const Surface surface = this->surface();
  std::vector<double> jumps;
  if (std::holds_alternative<Refinement::JumpIndicator>(wanted.where)) {
    // In the units of the whole model; a region's own indicator is scaled by (S/s_r)².
    for (int r = 0; r < layout().region_count(); ++r) {
      const VecX own = residual_indicator(skinned_region(r).surface);
      const double scale = layout().domain_scale().size() > 0
                               ? layout().domain_scale()[layout().first_triangle(r)]
                               : 1;
      for (long t = 0; t < own.size(); ++t) jumps.push_back(own[t] / scale);
    }
  }
  const std::vector<char> marked = marks(wanted, layout(), surface, jumps);
  read_values();
  report.energy_before = report.energy_transferred = report.energy_at_equilibrium =
      elastic_energy(now.shape.x);
  report.triangles = report.triangles_before;
  ModelLayout layout = this->layout();
  if (!layout.refine(marked)) return report;
  if (layout.mesh()->triangle_count() > wanted.max_triangles)
    throw InputError("the refinement would create " +
                     std::to_string(layout.mesh()->triangle_count()) + " triangles, more than " +
                     std::to_string(wanted.max_triangles));
  report.triangles = layout.mesh()->triangle_count();
  update_progress("refining", 1);
  const SurfaceTransfer transferred = change_layout(std::move(layout));
  report.max_displacement = transferred.max_displacement / size();
  report.energy_at_equilibrium = elastic_energy(now.shape.x);
  report.energy_transferred =
      elastic_energy(transferred.dofs - system().parts->ones * system().origin().transpose());
  return report;
}

using detail::SessionDefinition;

void SessionData::mark_converged() {
  now.converged_x = now.shape.x;
  now.converged_rest = system().rest;
  now.converged_values = now.shape_values = values;
  now.fresh.assign(values.size(), 0);
}

// Restores parameters and shape of the last converged solve.
void SessionData::restore_converged() {
  if (now.converged_values.size() != static_cast<size_t>(now.parameters.count())) return;
  read_values();
  for (size_t p = 0; p < values.size(); ++p) {
    const ScalarParameter& own = now.parameters.all()[p];
    if (!now.fresh[p])
      values[p] = now.converged_values[p];
    else if (system().roles[p] != detail::kNothing)  // as close to no effect as its range allows
      values[p] = std::clamp(now.converged_values[p], own.min, own.max);
  }
  now.parameters.restore(values, now.parameters.time());
  now.shape_values = now.converged_values;
  now.shape.x = now.converged_x;
  engine.reset_acceleration();
  ++version;
  read_values();
  try {
    if (system().rest != now.converged_rest) engine.set_rest_shape(system(), now.converged_rest);
    engine.prepare_matrix(system(), values);
  } catch (const CancelledError&) {
    engine.invalidate_matrix(system());
    throw;
  }
}

// Computes the matrix again if a cancelled solve has left it to other values than those of the
// shape, or if the undo history has dropped it.
void SessionData::require_matrix() {
  if (system().matrix_values.empty())
    engine.prepare_matrix(system(), now.shape_values);
  else if (!system().statics || !system().coupling)
    engine.prepare_matrix(system(), std::vector<double>(system().matrix_values));
}

// Load stepping from the last converged values to `goal`. Steps are halved if the solve does not
// converge.
detail::SessionEngine::SolveStatus SessionData::step_loads(const std::vector<double>& goal) {
  const std::vector<double> start = now.converged_values;
  Points reached_x = now.converged_x;
  double reached = 0, step = 0.5;
  detail::SessionEngine::SolveStatus total;
  constexpr double smallest = 1.0 / 256, nothing = 1e-9;  // minimum step: fraction of the value
                                                          // reached; fraction of the total
  while (reached < 1) {
    update_progress("solving", reached);
    const double target = std::min(1.0, reached + step);
    for (size_t p = 0; p < goal.size(); ++p)
      values[p] = target == 1 ? goal[p] : start[p] + target * (goal[p] - start[p]);
    now.shape.x = reached_x;
    engine.reset_acceleration();
    engine.prepare_matrix(system(), values);
    const auto run = engine.solve_preview(system(), values, now.shape.x, options.max_iterations,
                                          options.tolerance, false);
    total.iterations += run.iterations;
    total.change = run.change;
    if (run.converged) {
      reached = target;
      reached_x = now.shape.x;
      continue;
    }
    step = 0.5 * (target - reached);
    if (step < std::max(smallest * reached, nothing)) break;
  }
  total.converged = reached == 1;
  if (total.converged) return total;
  std::string moved;
  for (size_t p = 0; p < goal.size(); ++p)
    if (goal[p] != start[p] &&
        (system().roles[p] != detail::kNothing || now.parameters.all()[p].rule_terms.empty()))
      moved += (moved.empty() ? "" : ", ") + ("'" + now.parameters.all()[p].name + "' = ") +
               format_number(goal[p]) + " (" +
               format_number(start[p] + reached * (goal[p] - start[p])) + " was reached)";
  if (moved.empty())
    throw NoSolutionError("the solution does not converge within " +
                          std::to_string(options.max_iterations) +
                          " iterations; increase alpha or beta, or reduce the loads");
  throw NoSolutionError("load limit exceeded at " + moved + ": the solution converges up to " +
                        format_number(100 * reached) + " % of the change, but not beyond within " +
                        std::to_string(options.max_iterations) +
                        " iterations; increase alpha or beta, or reduce the loads");
}

bool SessionData::has_point_clouds() {
  for (const auto& load : system().def.loads)
    if (std::holds_alternative<Load::PointCloudSprings>(load->load.kind)) return true;
  return false;
}

// Plans smooth joins again if moved lines have rotated the tangents at nodes, so that the gluing
// functions γ and δ change.
bool SessionData::plan_joins() {
  constexpr double same = 1e-7;
  if (layout().join_plans().empty() || system().def.fix_corners_only ||
      !(layout().gluing_change(absolute(now.shape.x)) > same))
    return false;
  ModelLayout next = layout();
  next.plan_joins(absolute(now.shape.x));
  SessionDefinition def = system().def;
  def.layout = std::make_shared<const ModelLayout>(std::move(next));
  rebuild(std::move(def));
  return true;
}

// Solves to equilibrium. If the solve is cancelled, the session keeps its state.
SolveReport SessionData::solve_to_equilibrium_or_keep() {
  detail::SessionState before = now;  // shares the system, of which a solve changes these members:
  const auto rest = system().rest;
  const auto scan_foot_points = system().scan_foot_points;
  const auto scan_used = system().scan_used;
  const auto matrix_values = system().matrix_values;
  try {
    return solve_to_equilibrium();
  } catch (const CancelledError&) {
    const UncancellableScope scope;
    const bool other_system = now.system != before.system;
    now = std::move(before);
    const bool same_matrix = !options.rest && !has_point_clouds() && !other_system &&
                             system().matrix_values == matrix_values;
    system().rest = rest;
    system().scan_foot_points = scan_foot_points;
    system().scan_used = scan_used;
    if (!same_matrix) engine.invalidate_matrix(system());
    if (other_system) {
      engine.bind(system());
      update_value_names();
    } else {
      engine.reset_acceleration();
    }
    ++version;
    throw;
  }
}

SolveReport SessionData::solve_to_equilibrium(bool anew) {
  SolveReport answer = solve_once(anew);
  constexpr int most_plans = 4;
  for (int i = 0; i < most_plans && plan_joins(); ++i) {
    const int before = answer.iterations;
    answer = solve_once(anew);
    answer.iterations += before;
    answer.joins_planned = true;
  }
  return answer;
}

SolveReport SessionData::solve_once(bool anew) {
  SolveReport answer;
  try {
    read_values();
    update_rest_shape(anew);
    constexpr int max_rounds = 20;
    for (int round = 0; round < max_rounds; ++round) {
      throw_if_cancelled();
      const bool scans = has_point_clouds();
      if (scans && !engine.update_scan_foot_points(system(), now.shape.x) && round > 0) break;
      answer.factored |= engine.prepare_matrix(system(), values);
      update_progress("solving", 0);
      Points from = now.shape.x;
      auto run = engine.solve_preview(system(), values, now.shape.x, options.max_iterations,
                                      options.tolerance, false);
      answer.iterations += run.iterations;
      if (!run.converged) {
        const bool can_go_back = now.converged_values.size() == values.size();
        if (!can_go_back) {
          now.shape.x = from;
          throw NoSolutionError("the solution does not converge within " +
                                std::to_string(options.max_iterations) +
                                " iterations; increase alpha or beta, or reduce the loads");
        }
        const std::vector<double> goal = values;
        run = step_loads(goal);
        answer.iterations += run.iterations;
      }
      answer.change = run.change;
      update_progress("solving", 1);
      mark_converged();
      if (!scans) break;
    }
  } catch (const CancelledError&) {
    throw;  // the caller restores the state
  } catch (const Error&) {
    restore_converged();
    throw;
  }
  now.shape.v.setZero();
  coalesces = false;
  ++version;
  answer.time = now.parameters.time();
  return answer;
}

SolveReport SessionData::solve_preview(int most, double tolerance) {
  SolveReport answer;
  read_values();
  try {
    answer.factored = engine.prepare_matrix(system(), values);
    const auto run =
        engine.solve_preview(system(), values, now.shape.x, std::max(1, most), tolerance, true);
    answer.converged = run.converged;
    answer.iterations = run.iterations;
    answer.change = run.change;
    answer.superposed = run.superposed;
    answer.change_is_estimated = run.change_is_estimated;
    if (run.diverged)
      throw NoSolutionError("load limit exceeded: the solution diverges with these values");
    now.shape_values = values;
    version += run.change != 0;
    if (run.converged) mark_converged();
  } catch (const CancelledError&) {
    // The shape is unchanged, and needs the matrix for its own values.
    if (answer.factored) engine.invalidate_matrix(system());
    throw;
  } catch (const Error&) {
    restore_converged();
    throw;
  }
  answer.time = now.parameters.time();
  return answer;
}

SolveReport SessionData::step() {
  if (!now.in_motion) throw InputError("step() without a simulation: start the motion first");
  SolveReport answer;
  // Starts from the values for which the shape was computed.
  before = now.shape_values;
  const double time = now.parameters.time();
  now.parameters.set_time(time + now.motion.dt);
  read_values();
  try {
    answer.factored = engine.prepare_matrix(system(), values);
    answer.factored |= engine.prepare_motion(system(), now.motion);
    engine.step(system(), before, values, now.shape);
    if (!now.shape.x.allFinite() ||
        now.shape.x.cwiseAbs().maxCoeff() > 1e6 * (size() + now.converged_x.cwiseAbs().maxCoeff()))
      throw NoSolutionError("load limit exceeded: the solution diverges at time " +
                            format_number(now.parameters.time()));
  } catch (const CancelledError&) {  // the shape is unchanged
    now.parameters.set_time(time);
    if (answer.factored) engine.invalidate_matrix(system());
    throw;
  } catch (const Error&) {
    now.shape.v.setZero();
    now.parameters.restore(before, time);
    restore_converged();
    throw;
  }
  ++version;
  mark_converged();
  answer.iterations = 1;
  answer.time = now.parameters.time();
  return answer;
}

namespace {

bool same_rows(const ConstraintSet& a, const ConstraintSet& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.value == q.value && std::equal(p.entries.begin(), p.entries.end(), q.entries.begin(),
                                            q.entries.end(), [](const auto& x, const auto& y) {
                                              return x.dof == y.dof &&
                                                     x.coefficient == y.coefficient;
                                            });
  };
  return std::equal(a.constraints().begin(), a.constraints().end(), b.constraints().begin(),
                    b.constraints().end(), same) &&
         std::equal(a.coupled_constraints().begin(), a.coupled_constraints().end(),
                    b.coupled_constraints().begin(), b.coupled_constraints().end(), same);
}

}  // namespace

// Shape under the constraints that bends least from a rest shape, without loads. Absolute
// coordinates.
Points SessionData::deformed_from(std::shared_ptr<const detail::RestConfiguration> rest) {
  std::vector<double> unloaded = values;
  for (const int p : system().load_parameter) unloaded[p] = 0;
  engine.set_rest_shape(system(), std::move(rest));
  engine.prepare_matrix(system(), unloaded);
  Points x = now.shape.x;
  engine.solve_preview(system(), unloaded, x, options.max_iterations, options.tolerance, false);
  return absolute(x);
}

// Computes the rest shape if there is none yet or, with `anew`, if the constraints have changed.
void SessionData::update_rest_shape(bool anew) {
  const auto last = system().rest;
  if (!options.rest || (last && !anew)) return;
  ConstraintSet rows = engine.all_rows(system(), values);
  if (last && same_rows(last->rows, rows)) return;
  const VecX& ones = system().parts->ones;
  const Vec3 origin = system().origin();
  const Points bent = deformed_from(nullptr);
  Points near(0, 3);
  if (last && last->first.rows() > 0)
    near = deformed_from(std::make_shared<const detail::RestConfiguration>(
        detail::RestConfiguration{last->first, {}, ConstraintSet(0)}));
  const ConstraintSet absolute_rows = rows.translated(ones, -origin);
  Points dofs = options.rest({layout(), absolute_rows, bent, near, progress});
  if (dofs.rows() > 0) {
    if (dofs.rows() != system().dofs() || !dofs.allFinite())
      throw InputError("found a rest shape of " + std::to_string(dofs.rows()) + " dofs, expected " +
                       std::to_string(system().dofs()) + " finite dofs");
    dofs -= ones * origin.transpose();
  }
  Points first = last && last->first.rows() > 0 ? last->first : dofs;
  engine.set_rest_shape(
      system(), std::make_shared<const detail::RestConfiguration>(
                    detail::RestConfiguration{std::move(dofs), std::move(first), std::move(rows)}));
}

}  // namespace batten
