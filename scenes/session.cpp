// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/session.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>

#include "batten/core/cancellation.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/session_data.h"
#include "batten/scenes/shapes/stress_setup.h"

namespace batten {
namespace detail {

std::string name_of(const SculptingSession::ActingItem& item) {
  return std::visit([](const auto& what) { return what.name; }, item.what);
}

namespace {

/// Identity and values of everything that determines the shape on which a scene locates loads:
/// constraints and, at the value nearest to 0, offsets.
std::vector<std::pair<std::shared_ptr<const void>, std::vector<double>>> reference_items(
    const SculptingSession& session) {
  std::vector<std::pair<std::shared_ptr<const void>, std::vector<double>>> all;
  const Parameters& parameters = session.parameters();
  for (const SculptingSession::ActingItem& item : session.items()) {
    const std::string name = name_of(item);
    std::vector<double> values;
    if (!std::holds_alternative<LineOffset>(item.what) &&
        !std::holds_alternative<Constraint>(item.what))
      continue;
    for (const char* axis : {".x", ".y", ".z"})
      if (parameters.has(name + axis)) values.push_back(parameters.value(name + axis));
    all.emplace_back(item.id, std::move(values));
  }
  return all;
}

}  // namespace

SessionContents::SessionContents(const Model& of, const Progress& progress) {
  of.data().require_surface();
  const ActiveProgress active(active_progress, &progress);
  const auto data = of.shared_data();
  base = data;
  if (data->origin) {
    model = data->origin->model;
    reference = data->origin->reference;
    solve_report = data->origin->solve_report;
    session = std::make_unique<SculptingSession>(*data->origin->state, forwarding_progress());
  } else {
    model = std::make_shared<const SculptModel>(
        sculpt_model(*data->made, data->scene, forwarding_progress()));
    progress.update("session", 0);
    session = std::make_unique<SculptingSession>(
        make_session(*model->layout, data->scene, model->made, FactorReuse::many,
                     forwarding_progress(), &reference, model->fair.rest));
    solve_report = session->solve_to_equilibrium();
  }
  for (const SculptingSession::ActingItem& item : session->items())
    scene_items[name_of(item)] = item.id;
  scene_reference = reference_items(*session);
}

Progress SessionContents::forwarding_progress() {
  Progress progress;
  progress.report = [this](std::string_view stage, double fraction) {
    if (active_progress && active_progress->report) active_progress->report(stage, fraction);
  };
  progress.cancelled = [this] {
    return active_progress && active_progress->cancelled && active_progress->cancelled();
  };
  return progress;
}

std::shared_ptr<const Frame> SessionContents::current_frame() {
  if (!stale && shown) return shown;
  shown.reset();
  std::shared_ptr<Frame> free;
  for (const auto& frame : frames)
    if (frame.use_count() == 1) free = frame;
  std::atomic_thread_fence(std::memory_order_acquire);  // pairs with the release of its last reader
  if (!free) {
    free = std::make_shared<Frame>();
    constexpr size_t most_kept = 4;
    if (frames.size() < most_kept) frames.push_back(free);
  }
  session->draw(*free);
  shown = free;
  stale = false;
  return shown;
}

SessionStress SessionContents::current_stress(const StressTable& table) {
  const Scene& scene = base->scene;
  if (table.accuracy != 0)
    throw InputError("accuracy: found " + format_number(table.accuracy) +
                     ", expected 0: the stresses of a session are those on its own elements");
  if (table.empty() && !scene.stress)
    throw InputError(scene.name +
                     ": found no [stress], expected one, or settings with material, thickness, "
                     "supports and loads");
  for (const char* key : {"modes", "buckling"})
    for (const auto& [name, value] : table.values)
      if (name == key)
        throw InputError(name + ": found " + value +
                         ", expected 0: stress(session.model(), …) computes mode shapes");
  try {
    if (!stress || table != stress_settings) {
      stress.reset();
      stress_settings = table;
      stress_scene = scene;
      if (!table.empty()) {
        stress_scene.stress = parsed_table(table, scene.unit);
        stress_scene.file = kStressFile;
      }
      stress.emplace(shell_problem(stress_scene));
    }
    const auto frame = current_frame();
    const ShellEvaluator::MaxValues largest = stress->at(session->layout(), session->dofs());
    ShellEvaluator::Field field = stress->field(frame->pattern->locations);
    return {std::move(field.load_case), largest.von_mises, largest.displacement,
            std::move(field.von_mises), std::move(field.displacement)};
  } catch (const InputError& e) {
    const std::string message = with_settings(table, scene.unit, e.what());
    if (message == e.what()) throw;
    throw InputError(message);
  }
}

// The scene of the current state: the scene of the base with the items that were added and removed.

namespace {

/// An inline table, written key by key.
class InlineTable {
 public:
  explicit InlineTable(const std::string& name) { add("name", name); }
  template <class Value>
  InlineTable& add(const std::string& key, const Value& value) {
    values_.emplace_back(key, SceneText::toml_value(value));
    return *this;
  }
  InlineTable& add_list(const std::string& key, const std::vector<std::string>& texts) {
    values_.emplace_back(key, SceneText::toml_string_list(texts));
    return *this;
  }
  InlineTable& add_parameter(const Parameters& parameters, const std::string& name) {
    const ScalarParameter& p = parameters.all()[static_cast<size_t>(parameters.index(name))];
    add("value", parameters.value(name));
    if (p.min > -kInfinity) add("min", p.min);
    if (p.max < kInfinity) add("max", p.max);
    return *this;
  }
  std::string text() const { return SceneText::inline_table(values_); }

 private:
  std::vector<SceneText::Value> values_;
};

/// Writes the items of a session as tables of its scene.
class ItemWriter {
 public:
  /// `unloaded`, `constrained`: dofs of the shape of the curves alone, and of the shape under the
  /// constraints and offsets without loads. A scene locates constraints on the first, loads on the
  /// second.
  ItemWriter(const SculptingSession& session, const Points& unloaded, const Points& constrained)
      : parameters_(session.parameters()),
        layout_(session.layout()),
        unloaded_(layout_.surface(unloaded)),
        constrained_(layout_.surface(constrained)) {}

  void write(SceneText& text, const SculptingSession::ActingItem& item) const {
    if (const auto* load = std::get_if<Load>(&item.what))
      text.add("load", load_table(*load, item.foot_points));
    else if (const auto* constraint = std::get_if<Constraint>(&item.what))
      text.add("constraint", constraint_table(*constraint, item.foot_points));
    else if (const auto* offset = std::get_if<LineOffset>(&item.what))
      text.add("offset", offset_table(*offset));
    else
      throw Error("found an item of a session that its scene cannot hold");
  }

  /// Writes where an existing load acts, which depends on the constraints that were added.
  void write_position(SceneText& text, const SculptingSession::ActingItem& item) const {
    const auto* load = std::get_if<Load>(&item.what);
    if (!load || item.foot_points.empty()) return;
    std::vector<std::string> points;
    for (const ModelPoint& at : item.foot_points)
      points.push_back(SceneText::toml_value(on(constrained_, at)));
    if (std::holds_alternative<Load::Point>(load->kind))
      text.set({"load", load->name}, "at", points.front());
    else if (std::holds_alternative<Load::AttractorSprings>(load->kind))
      text.set({"load", load->name}, "at", SceneText::list(points));
  }

 private:
  /// Position of a foot point on a reference surface.
  Vec3 on(const Surface& reference, const ModelPoint& at) const {
    const Location where = TriangleLocator(*layout_.region(at.region).mesh()).locate(at.uv);
    return reference.position(layout_.to_model_location(at.region, where));
  }

  std::string load_table(const Load& load, const std::vector<ModelPoint>& foot_points) const {
    InlineTable table(load.name);
    if (const auto* pressure = std::get_if<Load::Pressure>(&load.kind)) {
      table.add("type", "pressure");
      if (isize(pressure->area.regions) > 0 &&
          isize(pressure->area.regions) < layout_.region_count())
        table.add_list("faces", pressure->area.regions);
    } else if (const auto* point = std::get_if<Load::Point>(&load.kind)) {
      table.add("type", "point")
          .add("at", on(constrained_, foot_points.front()))
          .add("direction", point->direction);
    } else {
      throw Error("found a load of a session that its scene cannot hold");
    }
    return table.add_parameter(parameters_, load.name).text();
  }

  std::string constraint_table(const Constraint& constraint,
                               const std::vector<ModelPoint>& foot_points) const {
    InlineTable table(constraint.name);
    if (std::holds_alternative<Constraint::Point>(constraint.kind)) {
      const Vec3 goal(parameters_.value(constraint.name + ".x"),
                      parameters_.value(constraint.name + ".y"),
                      parameters_.value(constraint.name + ".z"));
      table.add("type", "point").add("at", on(unloaded_, foot_points.front())).add("to", goal);
    } else if (const auto* normal = std::get_if<Constraint::Normal>(&constraint.kind)) {
      table.add("type", "normal")
          .add("at", on(unloaded_, foot_points.front()))
          .add("direction", normal->normal);
    } else {
      throw Error("found a constraint of a session that its scene cannot hold");
    }
    return table.text();
  }

  std::string offset_table(const LineOffset& offset) const {
    InlineTable table(offset.name);
    table.add("curve", offset.line);
    if (offset.direction) table.add("direction", *offset.direction);
    table.add("fade", offset.fade);
    return table.add_parameter(parameters_, offset.name).text();
  }

  const Parameters& parameters_;
  const ModelLayout& layout_;
  const Surface unloaded_, constrained_;
};

/// Table of a scene that defines a parameter; {} if the parameter has no table of its own.
SceneTable table_of(const SceneText& text, const std::string& name) {
  for (const char* kind : {"load", "stiffness", "offset", "parameter"})
    if (text.has({kind, name})) return {kind, name};
  return {};
}

/// Adds the parameters that belong to no item.
void write_added_parameters(SceneText& text, const Scene& scene, const SculptingSession& session) {
  std::set<std::string> known;
  for (const Parameter& p : scene.parameters()) known.insert(p.name);
  for (const SculptingSession::ActingItem& item : session.items()) {
    const std::string name = name_of(item);
    known.insert(name);
    for (const char* axis : {".x", ".y", ".z"}) known.insert(name + axis);
  }
  for (const ScalarParameter& p : session.parameters().all())
    if (!known.count(p.name))
      text.add("parameter", InlineTable(p.name).add_parameter(session.parameters(), p.name).text());
}

/// Replaces the rules between parameters, if they changed.
void write_rules(SceneText& text, const Scene& scene, const SculptingSession& session) {
  const auto same = [](const std::vector<ScalarParameter::Term>& a,
                       const std::vector<ScalarParameter::Term>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
      return x.of == y.of && x.factor == y.factor;
    });
  };
  bool changed = false;
  std::map<std::string, ScalarParameter> before;
  for (const ScalarParameter& p : scene.named_values()) before[p.name] = p;
  std::map<std::string, std::vector<std::string>> drives;
  const std::vector<ScalarParameter>& all = session.parameters().all();
  for (const ScalarParameter& p : all) {
    const auto was = before.find(p.name);
    // The parts of an offset of a split curve follow its first part, in the scene without a rule.
    if (was == before.end() && table_of(text, p.name).name.empty()) continue;
    changed |= was == before.end() ? !p.rule_terms.empty()
                                   : !same(p.rule_terms, was->second.rule_terms) ||
                                         (!p.rule_terms.empty() && p.offset != was->second.offset);
    for (size_t i = 0; i < p.rule_terms.size(); ++i) {
      InlineTable table(p.name);
      table.add("factor", p.rule_terms[i].factor);
      if (i == 0) table.add("offset", p.offset);
      drives[p.rule_terms[i].of].push_back(table.text());
    }
  }
  if (!changed) return;
  for (const ScalarParameter& p : all) {
    const SceneTable table = table_of(text, p.name);
    if (table.name.empty()) continue;
    if (drives.count(p.name))
      text.set(table, "drives", SceneText::list(drives.at(p.name)));
    else if (!text.value(table, "drives").empty())
      text.erase(table, "drives");
  }
}

}  // namespace

Points SessionContents::constrained_shape() {
  const std::vector<SculptingSession::ActingItem> items = session->items();
  const bool located = std::any_of(items.begin(), items.end(), [](const auto& item) {
    return std::holds_alternative<Load>(item.what) && !item.foot_points.empty();
  });
  if (!located || reference_items(*session) == scene_reference) return reference.constrained;
  SculptingSession copy(*session->snapshot(), forwarding_progress());
  for (const ScalarParameter& p : std::vector<ScalarParameter>(copy.parameters().all()))
    if (!p.rule_terms.empty()) copy.set_rule(p.name, {}, copy.parameters().value(p.name));
  for (const auto& item : items) {
    const std::string name = name_of(item);
    if (std::holds_alternative<LineOffset>(item.what)) {
      const auto& all = copy.parameters().all();
      const ScalarParameter& p = all[static_cast<size_t>(copy.parameters().index(name))];
      copy.set(name, std::clamp(0.0, p.min, p.max));
    } else if (!std::holds_alternative<Constraint>(item.what)) {
      copy.remove(name);
    }
  }
  copy.solve_to_equilibrium();
  return copy.dofs();
}

std::string SessionContents::current_scene(const Points& constrained) {
  SceneText text(Model(base).scene(), base->scene.file);
  const std::vector<SculptingSession::ActingItem> items = session->items();
  std::map<std::string, std::shared_ptr<const void>> present;
  for (const auto& item : items) present[name_of(item)] = item.id;
  for (const SceneTable& table : std::vector<SceneTable>(text.tables())) {
    const auto was = scene_items.find(table.name);
    if (was == scene_items.end()) continue;
    for (const char* kind : {"load", "stiffness", "constraint", "offset"})
      if (table.kind == kind && (!present.count(table.name) || present[table.name] != was->second))
        text.remove(table);
  }
  const ItemWriter writer(*session, reference.unloaded, constrained);
  const bool moved = reference_items(*session) != scene_reference;
  for (const auto& item : items) {
    const auto was = scene_items.find(name_of(item));
    if (was == scene_items.end() || was->second != item.id)
      writer.write(text, item);
    else if (moved)
      writer.write_position(text, item);
  }
  write_added_parameters(text, base->scene, *session);
  write_rules(text, base->scene, *session);
  return text.text();
}

namespace {

/// Sets the values of a session in a scene, except those that others drive or that depend on time.
void set_values(Scene& scene, const Parameters& parameters) {
  for (const ScalarParameter& p : scene.named_values())
    if (p.rule_terms.empty() && p.keyframes.empty() && parameters.has(p.name))
      scene.set(p.name, parameters.value(p.name), "");
}

}  // namespace

Model SessionContents::current_model() {
  SessionReference shapes{reference.unloaded, constrained_shape()};
  std::string text = current_scene(shapes.constrained);
  Scene scene = parse_scene(text, base->scene.file);
  set_values(scene, session->parameters());
  SolvedShape shape = shape_of(*session, scene, reference.unloaded, solve_report);
  SessionOrigin origin{session->snapshot(), model, std::move(shapes), solve_report};
  return Model(std::make_shared<const ModelData>(std::move(text), std::move(scene), *base,
                                                 std::move(shape), std::move(origin)));
}

}  // namespace detail

namespace {

ScalarParameter parameter(const std::string& name, const ParameterRange& range) {
  ScalarParameter p;
  p.name = name;
  p.value = range.value;
  p.min = range.min;
  p.max = range.max;
  return p;
}

/// A direction of length 1. Throws InputError for a zero vector or numbers that are not finite.
Vec3 unit_direction(const Vec3& direction, const std::string& name) {
  const double length = direction.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("'" + name + "': found the direction [" + format_number(direction[0]) + ", " +
                     format_number(direction[1]) + ", " + format_number(direction[2]) +
                     "], expected a direction of length above 0");
  return direction / length;
}

}  // namespace

Session::Session(const Model& model, const Progress& progress)
    : contents_(std::make_unique<detail::SessionContents>(model, progress)) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

void Session::set(const std::string& name, double value) {
  contents_->with_session(true, [&](SculptingSession& session) { session.set(name, value); });
}

double Session::value(const std::string& name) const {
  return contents_->with_session(
      false, [&](SculptingSession& session) { return session.parameters().value(name); });
}

std::map<std::string, double> Session::parameters() const {
  return contents_->with_session(false, [](SculptingSession& session) {
    std::map<std::string, double> values;
    for (const ScalarParameter& p : session.parameters().all())
      values[p.name] = session.parameters().value(p.name);
    return values;
  });
}

SolveReport Session::update(int max_iterations, double tolerance, const Progress& progress) {
  if (max_iterations < 1)
    throw InputError("max_iterations: found " + std::to_string(max_iterations) +
                     ", expected 1 or more");
  if (!(tolerance > 0 && std::isfinite(tolerance)))
    throw InputError("tolerance: found " + format_number(tolerance) +
                     ", expected a number above 0");
  return contents_->with_session(true, progress, [&](SculptingSession& session) {
    return contents_->solve_report = session.solve_preview(max_iterations, tolerance);
  });
}

SolveReport Session::solve(const Progress& progress) {
  return contents_->with_session(true, progress, [&](SculptingSession& session) {
    return contents_->solve_report = session.solve_to_equilibrium();
  });
}

bool Session::undo() {
  return contents_->with_session(true, [](SculptingSession& session) { return session.undo(); });
}

bool Session::redo() {
  return contents_->with_session(true, [](SculptingSession& session) { return session.redo(); });
}

void Session::start_motion(double dt) {
  const SceneMotion& scene = contents_->base->scene.motion;
  start_motion(Motion{dt, scene.density, scene.damping, scene.theta});
}

void Session::start_motion(const Motion& motion) {
  contents_->with_session(true, [&](SculptingSession& session) { session.start_motion(motion); });
}

SolveReport Session::step(int count, const Progress& progress) {
  if (count < 1) throw InputError("count: found " + std::to_string(count) + ", expected 1 or more");
  return contents_->with_session(true, progress, [&](SculptingSession& session) {
    for (int i = 0; i < count; ++i) {
      if (count > 1) progress.update("motion", static_cast<double>(i) / count);
      contents_->solve_report = session.step();
    }
    return contents_->solve_report;
  });
}

void Session::stop_motion() {
  contents_->with_session(true, [](SculptingSession& session) { session.stop_motion(); });
}

bool Session::in_motion() const {
  return contents_->with_session(false,
                                 [](SculptingSession& session) { return session.in_motion(); });
}

double Session::time() const {
  return contents_->with_session(
      false, [](SculptingSession& session) { return session.parameters().time(); });
}

double Session::total_energy() const {
  return contents_->with_session(false,
                                 [](SculptingSession& session) { return session.total_energy(); });
}

void Session::add_pressure(const std::string& name, const ParameterRange& range,
                           const std::vector<std::string>& faces) {
  Load::Pressure pressure;
  pressure.area.regions = faces;
  contents_->with_session(true, [&](SculptingSession& session) {
    session.add(Load{name, pressure}, {parameter(name, range)});
  });
}

void Session::add_force(const std::string& name, const Vec3& at, const Vec3& direction,
                        const ParameterRange& range) {
  const Load load{name, Load::Point{at, unit_direction(direction, name)}};
  contents_->with_session(
      true, [&](SculptingSession& session) { session.add(load, {parameter(name, range)}); });
}

void Session::add_point_constraint(const std::string& name, const Vec3& at, const Vec3& target) {
  contents_->with_session(true, [&](SculptingSession& session) {
    session.add(Constraint{name, Constraint::Point{at, target}});
  });
}

void Session::add_normal_constraint(const std::string& name, const Vec3& at, const Vec3& normal) {
  const Constraint constraint{name, Constraint::Normal{at, unit_direction(normal, name)}};
  contents_->with_session(true, [&](SculptingSession& session) { session.add(constraint); });
}

void Session::add_offset(const std::string& name, const std::string& curve, const Vec3& direction,
                         double fade, const ParameterRange& range) {
  LineOffset offset{name, curve, {}, fade};
  if (direction != Vec3::Zero()) offset.direction = unit_direction(direction, name);
  contents_->with_session(
      true, [&](SculptingSession& session) { session.add(offset, {parameter(name, range)}); });
}

void Session::add_parameter(const std::string& name, const ParameterRange& range) {
  contents_->with_session(
      true, [&](SculptingSession& session) { session.add_parameter(parameter(name, range)); });
}

void Session::drive(const std::string& name, const std::map<std::string, double>& follows,
                    double offset) {
  std::vector<ScalarParameter::Term> terms;
  for (const auto& [of, factor] : follows) {
    const bool material = of.starts_with("alpha") || of.starts_with("beta");
    if (material || of.find('.') != std::string::npos)
      throw InputError("found '" + of + "' to drive '" + name +
                       "', expected a load, stiffness field, offset or added parameter");
    terms.push_back({of, factor});
  }
  contents_->with_session(
      true, [&](SculptingSession& session) { session.set_rule(name, terms, offset); });
}

void Session::remove(const std::string& name) {
  contents_->with_session(true, [&](SculptingSession& session) { session.remove(name); });
}

std::vector<std::string> Session::names() const {
  return contents_->with_session(false, [](SculptingSession& session) { return session.names(); });
}

std::shared_ptr<const Frame> Session::frame() const {
  return contents_->with_session(false,
                                 [&](SculptingSession&) { return contents_->current_frame(); });
}

Points Session::dofs() const {
  return contents_->with_session(false, [](SculptingSession& session) { return session.dofs(); });
}

double Session::residual() const {
  return contents_->with_session(false,
                                 [](SculptingSession& session) { return session.residual(); });
}

double Session::energy() const {
  const SurfaceEnergy energy =
      contents_->with_session(false, [](SculptingSession& session) { return session.energy(); });
  return energy.stretching + energy.bending;
}

double Session::volume() const {
  return contents_->with_session(
      false, [](SculptingSession& session) { return session.enclosed_volume(); });
}

std::vector<Reaction> Session::reactions() const {
  return contents_->with_session(false,
                                 [](SculptingSession& session) { return session.reactions(); });
}

SessionStress Session::stress(const StressSettings& settings, const Progress& progress) const {
  const ProgressScope scope(progress);
  const detail::StressTable table = detail::stress_table(settings);
  return contents_->with_session(
      false, progress, [&](SculptingSession&) { return contents_->current_stress(table); });
}

Model Session::model(const Progress& progress) const {
  return contents_->with_session(false, progress,
                                 [&](SculptingSession&) { return contents_->current_model(); });
}

}  // namespace batten
