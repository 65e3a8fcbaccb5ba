// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/session/sculpting_session.h"

#include <cmath>
#include <optional>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/sculpting/session/session_data.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

using detail::SessionDefinition;
using Kind = Operation::Kind;

SculptingSession::SculptingSession(ModelLayout layout, const SessionOptions& options,
                                   const Progress& progress)
    : data_(std::make_unique<SessionData>()) {
  SessionData& d = *data_;
  d.options = options;
  d.progress = progress;
  const ProgressScope scope(d.progress);
  if (!(options.tolerance > 0) || options.max_iterations < 1 || options.facets_per_edge < 1)
    throw InputError(
        "a session needs a tolerance above 0, and 1 or more iterations and facets per edge");
  Parameters& p = d.now.parameters;
  const auto material = [&](const std::string& name, bool one, double uu, double uv, double vv) {
    const double least = name == "alpha" ? -kInfinity : 0;
    if (one) {
      p.add({.name = name, .value = uu, .min = 0});
      return;
    }
    p.add({.name = name + "_uu", .value = uu, .min = 0});
    p.add({.name = name + "_uv", .value = uv, .min = least});
    p.add({.name = name + "_vv", .value = vv, .min = 0});
  };
  const SurfaceStiffness& m = options.material;
  material("alpha", options.isotropic_alpha, m.alpha(0, 0), m.alpha(0, 1), m.alpha(1, 1));
  material("beta", options.isotropic_beta, m.beta[0], m.beta[1], m.beta[2]);
  SessionDefinition def;
  def.origin = layout.origin();
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  def.units = options.units;
  def.fix_corners_only = options.fix_corners_only;
  def.factor_reuse = options.factor_reuse;
  d.now.system = detail::build(std::move(def), p, nullptr);
  d.engine.bind(*d.now.system);
  d.update_value_names();
  d.now.shape.x = d.now.shape.v = Points::Zero(d.now.system->dofs(), 3);
  d.now.converged_x = d.now.shape.x;
  d.solve_to_equilibrium();
}

SculptingSession::SculptingSession(const SessionSnapshot& state, const Progress& progress)
    : data_(std::make_unique<SessionData>()) {
  SessionData& d = *data_;
  d.options = state.options;
  d.now = state.state;
  d.now.system = detail::without_factors(*state.state.system);
  d.now.system->matrix_values.clear();
  d.progress = progress;
  const ProgressScope scope(d.progress);
  // Working storage of its own, so that sessions in different threads do not share it.
  d.now.system->parts = std::make_shared<const detail::MeshData>(d.layout());
  d.engine.bind(d.system());
  d.update_value_names();
  d.read_values();
  d.engine.prepare_matrix(d.system(), d.values);
}

std::shared_ptr<const SessionSnapshot> SculptingSession::snapshot() const {
  auto copy = std::make_shared<SessionSnapshot>(SessionSnapshot{data_->options, data_->now});
  copy->state.system = detail::without_factors(*data_->now.system);
  return copy;
}

SculptingSession::~SculptingSession() = default;

SculptingSession::SculptingSession(SculptingSession&&) noexcept = default;

SculptingSession& SculptingSession::operator=(SculptingSession&&) noexcept = default;

const Parameters& SculptingSession::parameters() const { return data_->now.parameters; }

void SculptingSession::set(int parameter, double value) {
  apply({.kind = Kind::Set, .index = parameter, .value = value});
}

namespace {

Operation edit_of(Operation::Edit edit) {
  return {.kind = Kind::Edit, .edit = std::make_shared<const Operation::Edit>(std::move(edit))};
}

}  // namespace

void SculptingSession::add_parameter(ScalarParameter parameter) {
  apply(edit_of(Operation::AddParameter{std::move(parameter)}));
}

void SculptingSession::set_rule(const std::string& parameter,
                                std::vector<ScalarParameter::Term> rule_terms, double offset) {
  apply(edit_of(Operation::SetRule{parameter, std::move(rule_terms), offset}));
}

void SculptingSession::add(Operation::Item thing, std::vector<ScalarParameter> parameters) {
  apply(edit_of(Operation::Add{std::move(thing), std::move(parameters)}));
}

void SculptingSession::change(Constraint constraint) {
  apply(edit_of(Operation::Change{std::move(constraint)}));
}

void SculptingSession::remove(const std::string& name) { apply(edit_of(Operation::Remove{name})); }

void SculptingSession::set_line(const std::string& line, HermiteCurve curve) {
  apply(edit_of(Operation::SetLine{line, std::move(curve)}));
}

HermiteCurve SculptingSession::line(const std::string& name) const { return data_->line(name); }

std::vector<std::string> SculptingSession::names() const { return data_->names(); }

std::vector<SculptingSession::ActingItem> SculptingSession::items() const {
  const SessionDefinition& def = data_->system().def;
  std::vector<ActingItem> all;
  for (const auto& p : def.loads) all.push_back({p->load, p->foot_points, p});
  for (const auto& p : def.weights) all.push_back({p->weight, {}, p});
  for (const auto& p : def.constraints) {
    const bool line = std::holds_alternative<Constraint::LineNormal>(p->constraint.kind);
    all.push_back(
        {p->constraint, line ? std::vector<ModelPoint>() : std::vector{p->foot_point}, p});
  }
  for (const auto& p : def.moves) all.push_back({p->move, {}, p});
  return all;
}

SolveReport SculptingSession::solve_to_equilibrium() {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  const SolveReport report = d.recorded({}, [&] { return d.solve_to_equilibrium_or_keep(); });
  log(LogLevel::Debug, [&] {
    return "equilibrium after " + std::to_string(report.iterations) + " iterations, last change " +
           format_number(report.change);
  });
  return report;
}

SolveReport SculptingSession::solve_preview(int max_iterations, double tolerance) {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  return d.recorded({.kind = Kind::SolvePreview, .index = max_iterations, .value = tolerance}, [&] {
    if (d.now.in_motion)
      throw InputError(
          "no preview during a simulation: call step() to continue or stop_motion() to end it");
    return d.solve_preview(max_iterations, tolerance);
  });
}

void SculptingSession::start_motion(const Motion& motion) { apply(edit_of(motion)); }

SolveReport SculptingSession::step() {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  return d.recorded({.kind = Kind::Step}, [&] {
    // All consecutive steps of a motion are one step of the history.
    std::optional<detail::SessionState> before;
    if (d.now.in_motion && !d.coalesces) before = d.snapshot();
    const auto add_to_history = [&] {
      if (before) d.push_history(*std::move(before));
      d.coalesces = d.coalesces || d.now.in_motion;
    };
    try {
      const SolveReport report = d.step();
      add_to_history();
      return report;
    } catch (const CancelledError&) {
      throw;
    } catch (...) {
      add_to_history();
      throw;
    }
  });
}

void SculptingSession::stop_motion() { apply({.kind = Kind::StopMotion}); }

bool SculptingSession::in_motion() const { return data_->now.in_motion; }

void SculptingSession::set_time(double time) { apply({.kind = Kind::Time, .value = time}); }

bool SculptingSession::undo() {
  SessionData& d = *data_;
  d.record_operation({.kind = Kind::Undo});
  const UncancellableScope scope;
  if (!d.history.can_undo()) return false;
  d.restore_state(d.history.undo(d.snapshot(), d.options.history_bytes));
  return true;
}

bool SculptingSession::redo() {
  SessionData& d = *data_;
  d.record_operation({.kind = Kind::Redo});
  const UncancellableScope scope;
  if (!d.history.can_redo()) return false;
  d.restore_state(d.history.redo(d.snapshot(), d.options.history_bytes));
  return true;
}

void SculptingSession::clear_history() {
  data_->history.clear();
  data_->coalesces = false;
}

void SculptingSession::record(bool on) {
  data_->recording = on;
  if (on) data_->record.reserve(data_->record.size() + detail::kRecordPage);
}

const std::vector<Operation>& SculptingSession::recorded() const { return data_->record; }

void SculptingSession::apply(const Operation& op) {
  SessionData& d = *data_;
  switch (op.kind) {
    case Kind::Set:
      if (op.index < 0 || op.index >= d.now.parameters.count())
        throw InputError("found parameter number " + std::to_string(op.index) + ", expected 0 to " +
                         std::to_string(d.now.parameters.count() - 1));
      d.record_operation(op);
      d.change_values([&] { d.now.parameters.set(op.index, op.value); });
      return;
    case Kind::Time:
      d.record_operation(op);
      if (d.now.in_motion)
        throw InputError("the time cannot be set during a simulation: it advances with each step");
      if (!std::isfinite(op.value)) throw InputError("the time is not finite");
      d.change_values([&] { d.now.parameters.set_time(op.value); });
      return;
    case Kind::SolveToEquilibrium:
      solve_to_equilibrium();
      return;
    case Kind::SolvePreview:
      solve_preview(op.index, op.value);
      return;
    case Kind::Step:
      step();
      return;
    case Kind::StopMotion:
      d.record_operation(op);
      if (!d.now.in_motion) return;
      d.push_history(d.snapshot());
      d.now.in_motion = false;
      d.now.shape.v.setZero();
      return;
    case Kind::Undo:
      undo();
      return;
    case Kind::Redo:
      redo();
      return;
    case Kind::Edit:
      break;
  }
  if (!op.edit) throw InputError("an operation of kind Edit has no edit");
  if (const auto* refinement = std::get_if<Refinement>(op.edit.get())) {
    refine(*refinement);
    return;
  }
  const ProgressScope scope(d.progress);
  d.recorded(op, [&] {
    // The previous state is added to the history only if the edit succeeds.
    detail::SessionState before = d.snapshot();
    try {
      d.edit(*op.edit);
    } catch (...) {
      d.restore_state(std::move(before));
      throw;
    }
    d.push_history(std::move(before));
  });
}

int SculptingSession::replay(const std::vector<Operation>& operations) {
  const std::vector<Operation> all = operations;  // a copy, because it may be this session's own
                                                  // record
  int refused = 0;
  for (const Operation& op : all) {
    try {
      apply(op);
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {  // it threw when it was recorded, too
      ++refused;
    }
  }
  return refused;
}

RefinementReport SculptingSession::refine(const Refinement& refinement) {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  return d.recorded(edit_of(refinement), [&] {
    detail::SessionState before = d.snapshot();
    RefinementReport report;
    try {
      report = d.refine(refinement);
    } catch (...) {
      d.restore_state(std::move(before));
      throw;
    }
    if (report.triangles != report.triangles_before) d.push_history(std::move(before));
    return report;
  });
}

const ModelLayout& SculptingSession::layout() const { return data_->layout(); }

Points SculptingSession::dofs() const { return data_->absolute(data_->now.shape.x); }

SkinnedRegion SculptingSession::region(int r) const { return data_->skinned_region(r); }

std::vector<SkinnedRegion> SculptingSession::regions() const {
  std::vector<SkinnedRegion> all;
  for (int r = 0; r < layout().region_count(); ++r) all.push_back(region(r));
  return all;
}

void SculptingSession::draw(Frame& to) { data_->draw(to); }

const Frame& SculptingSession::frame() {
  data_->draw(data_->frame);
  return data_->frame;
}

double SculptingSession::residual() const {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  d.require_matrix();
  return d.engine.residual(d.system(), d.now.shape_values, d.now.shape.x) / d.size();
}

SurfaceEnergy SculptingSession::energy() const {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  d.read_values();
  SurfaceEnergy energy = d.engine.elastic_energy(d.system(), d.values, d.now.shape.x);
  energy.bending *= d.system().def.scale().energy_factor();
  energy.stretching *= d.system().def.scale().energy_factor();
  return energy;
}

double SculptingSession::total_energy() const {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  d.require_matrix();
  d.read_values();
  return d.engine.total_energy(d.system(), d.values, d.now.shape, d.now.in_motion) *
         d.system().def.scale().energy_factor();
}

std::vector<Reaction> SculptingSession::reactions() const {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  d.require_matrix();
  auto all = d.engine.reactions(d.system(), d.now.shape_values, d.now.shape.x);
  for (auto& reaction : all) reaction.force *= d.system().def.scale().reaction_factor();
  return all;
}

std::vector<PointCloudDistances> SculptingSession::scan_distances(const Points& before) const {
  const ProgressScope scope(data_->progress);
  return data_->engine.scan_distances(data_->system(), before, dofs());
}

double SculptingSession::enclosed_volume() const {
  SessionData& d = *data_;
  const ProgressScope scope(d.progress);
  return d.system().parts->pressure().volume(dofs(), {});
}

size_t SculptingSession::history_bytes() const { return data_->history.bytes(data_->now); }

using detail::SessionSystem;

detail::SessionState SessionData::snapshot() const {
  detail::SessionState copy = now;
  copy.system = std::make_shared<SessionSystem>(*now.system);
  return copy;
}

void SessionData::push_history(detail::SessionState before) {
  history.push(std::move(before), now, options.history_bytes);
  coalesces = false;
}

void SessionData::restore_state(detail::SessionState state) {
  const UncancellableScope scope;
  now = std::move(state);
  engine.bind(*now.system);
  update_value_names();
  coalesces = false;
  ++version;
}

void SessionData::record_operation(const Operation& op) {
  if (!recording) return;
  if (record.size() == record.capacity()) record.reserve(record.size() + detail::kRecordPage);
  record.push_back(op);
}

SkinnedRegion SessionData::skinned_region(int r) {
  SkinnedRegion region = layout().skinned(r, absolute(now.shape.x));
  const auto moved = [&](CharacterLine& line, HermiteCurve& fitted, bool embedded, size_t index) {
    const auto& moves = system().def.moves;
    if (std::none_of(moves.begin(), moves.end(),
                     [&](const auto& m) { return m->move.line == line.name; }))
      return;
    fitted = this->line(line.name);
    if (layout().against(layout().model_line(line.name), {r, embedded, static_cast<int>(index)}))
      fitted = fitted.backwards();
    line.curve = curve_from_hermite(fitted);
  };
  for (size_t i = 0; i < region.edge_aligned.size(); ++i)
    moved(region.edge_aligned[i].line, region.edge_aligned[i].fitted, false, i);
  for (size_t i = 0; i < region.embedded.size(); ++i) {
    EmbeddedLine& line = region.embedded[i];
    moved(line.line, line.fitted, true, i);
    // The pcurve needs the same nodes.
    if (line.pcurve.parameters() != line.fitted.parameters())
      line.pcurve = line.pcurve.with_nodes(line.fitted.parameters());
  }
  return region;
}

void SessionData::draw(Frame& to) {
  if (display.mesh != layout().mesh()) {
    const ProgressScope scope(progress);
    auto pattern = std::make_shared<DisplayTopology>();
    std::vector<Location>& locations = pattern->locations;
    for (int r = 0; r < layout().region_count(); ++r) {
      throw_if_cancelled();
      DisplayFacets own = facets(skinned_region(r), options.facets_per_edge);
      const int first = isize(locations);
      pattern->first_facet.push_back(isize(pattern->facets));
      pattern->first_line.push_back(isize(pattern->lines));
      for (const Location& where : own.tessellation.points)
        locations.push_back(layout().to_model_location(r, where));
      for (auto facet : own.tessellation.facets) {
        for (int& corner : facet) corner += first;
        pattern->facets.push_back(facet);
      }
      for (auto& line : own.lines) {
        for (auto& piece : line)
          for (int& point : piece) point += first;
        pattern->lines.push_back(std::move(line));
      }
    }
    pattern->first_facet.push_back(isize(pattern->facets));
    pattern->first_line.push_back(isize(pattern->lines));
    display.points =
        std::make_unique<DisplayPoints>(*layout().mesh(), layout().element(), locations);
    display.pattern = pattern;
    display.mesh = layout().mesh();
  }
  to.remeshed = to.pattern != display.pattern;
  to.pattern = display.pattern;
  const auto count = 3 * static_cast<size_t>(display.points->count());
  to.points.resize(count);
  to.normals.resize(count);
  to.moved = to.remeshed || shown != version;
  to.number = ++frames;
  display.points->evaluate(now.shape.x, system().origin(), to.points.data(), to.normals.data());
  shown = version;
}

SculptResult sculpt(const ModelLayout& layout, const StaticTask& task, const Progress& progress) {
  SessionOptions options;
  options.material = task.material;
  options.isotropic_alpha = options.isotropic_beta = false;
  options.units = task.units;
  options.fix_corners_only = task.fix_corners_only;
  options.tolerance = task.tolerance;
  options.max_iterations = task.max_iterations;
  options.history_bytes = 0;
  options.factor_reuse = FactorReuse::once;
  SculptingSession session(layout, options, progress);
  const Points alone = session.dofs();
  for (const Constraint& constraint : task.constraints) session.add(constraint);
  for (const AppliedLoad& applied : task.loads)
    session.add(applied.load, {{.name = applied.load.name, .value = applied.value}});
  const SolveReport report = session.solve_to_equilibrium();
  return {session.dofs(),
          session.energy(),
          report.iterations,
          report.change,
          session.reactions(),
          session.residual(),
          session.scan_distances(alone)};
}

}  // namespace batten
