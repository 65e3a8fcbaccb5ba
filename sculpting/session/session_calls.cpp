#include "batten/sculpting/session/session.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

using live::Definition;
using Kind = Operation::Kind;

// -- the session ----------------------------------------------------------------------------------

SculptingSession::SculptingSession(ModelLayout layout, const SessionOptions& options,
                                   const Progress& progress)
    : data_(std::make_unique<Data>()) {
  Data& d = *data_;
  d.options = options;
  if (!(options.tolerance > 0) || options.most_iterations < 1 || options.facets_per_edge < 1)
    throw InputError("a session needs a tolerance above 0, and 1 or more iterations and facets");
  Parameters& p = d.now.parameters;
  const auto material = [&](const std::string& name, bool one, double uu, double uv, double vv) {
    const double least = name == "alpha" ? -infinity : 0;
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
  Definition def;
  def.origin = layout.origin();
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  def.units = options.units;
  def.hold_corners = options.hold_corners;
  def.expected = options.expected;
  progress.at("solving", 0);
  d.now.system = live::build(std::move(def), p, nullptr);
  d.engine.bind(*d.now.system);
  d.name_values();
  d.now.shape.x = d.now.shape.v = Points::Zero(d.now.system->dofs(), 3);
  d.now.good_x = d.now.shape.x;
  d.settle();
  d.progress = progress;
  progress.at("solving", 1);
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

void SculptingSession::add_parameter(NamedValue parameter) {
  apply(edit_of(Operation::AddParameter{std::move(parameter)}));
}

void SculptingSession::drive(const std::string& parameter, std::vector<NamedValue::Share> follows,
                             double offset) {
  apply(edit_of(Operation::Drive{parameter, std::move(follows), offset}));
}

void SculptingSession::add(Operation::Thing thing, std::vector<NamedValue> parameters) {
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

Answer SculptingSession::settle() {
  data_->note({});
  return data_->settle();
}

Answer SculptingSession::answer(int most_iterations, double tolerance) {
  Data& d = *data_;
  d.note({.kind = Kind::Answer, .index = most_iterations, .value = tolerance});
  if (d.now.in_motion)
    throw InputError("an answer of a surface in motion: step() goes on, stop_motion() ends it");
  return d.quick(most_iterations, tolerance);
}

void SculptingSession::start_motion(const Motion& motion) { apply(edit_of(motion)); }

Answer SculptingSession::step() {
  Data& d = *data_;
  d.note({.kind = Kind::Step});
  if (d.now.in_motion) d.remember_start();
  return d.step();
}

void SculptingSession::stop_motion() { apply({.kind = Kind::Rest}); }

bool SculptingSession::in_motion() const { return data_->now.in_motion; }

void SculptingSession::set_time(double time) { apply({.kind = Kind::Time, .value = time}); }

bool SculptingSession::undo() {
  data_->note({.kind = Kind::Undo});
  return data_->go(data_->undone_to, data_->redone_to);
}

bool SculptingSession::redo() {
  data_->note({.kind = Kind::Redo});
  return data_->go(data_->redone_to, data_->undone_to);
}

void SculptingSession::record(bool on) {
  data_->recording = on;
  if (on) data_->record.reserve(data_->record.size() + live::kPage);
}

const std::vector<Operation>& SculptingSession::recorded() const { return data_->record; }

void SculptingSession::apply(const Operation& op) {
  Data& d = *data_;
  switch (op.kind) {
    case Kind::Set:
      if (op.index < 0 || op.index >= d.now.parameters.count())
        throw InputError("there is no parameter " + std::to_string(op.index));
      d.note(op);
      d.change_values([&] { d.now.parameters.set(op.index, op.value); });
      return;
    case Kind::Time:
      d.note(op);
      if (d.now.in_motion) throw InputError("the time of a motion goes on by its steps");
      if (!std::isfinite(op.value)) throw InputError("a time that is not finite");
      d.change_values([&] { d.now.parameters.set_time(op.value); });
      return;
    case Kind::Settle:
      settle();
      return;
    case Kind::Answer:
      answer(op.index, op.value);
      return;
    case Kind::Step:
      step();
      return;
    case Kind::Rest:
      d.note(op);
      if (!d.now.in_motion) return;
      d.remember(d.saved());
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
  if (!op.edit) throw InputError("an operation without its edit");
  if (const auto* refinement = std::get_if<Refinement>(op.edit.get())) {
    refine(*refinement);
    return;
  }
  d.note(op);
  // The history gets the state before, once it is known that the edit can be done.
  live::State before = d.saved();
  try {
    d.edit(*op.edit);
  } catch (...) {
    d.put_back(std::move(before));
    throw;
  }
  d.remember(std::move(before));
}

int SculptingSession::replay(const std::vector<Operation>& operations) {
  const std::vector<Operation> all = operations;  // it may be this session's own record
  int refused = 0;
  for (const Operation& op : all) {
    try {
      apply(op);
    } catch (const Error&) {  // it threw then
      ++refused;
    }
  }
  return refused;
}

RefinementReport SculptingSession::refine(const Refinement& refinement) {
  Data& d = *data_;
  d.note(edit_of(refinement));
  live::State before = d.saved();
  RefinementReport report;
  try {
    report = d.refine(refinement);
  } catch (...) {
    d.put_back(std::move(before));
    throw;
  }
  if (report.triangles != report.triangles_before) d.remember(std::move(before));
  return report;
}

const ModelLayout& SculptingSession::layout() const { return data_->layout(); }

Points SculptingSession::dofs() const { return data_->absolute(data_->now.shape.x); }

SkinnedRegion SculptingSession::region(int r) const { return data_->made(r); }

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
  Data& d = *data_;
  return d.engine.residual(d.system(), d.now.shape_values, d.now.shape.x) / d.size();
}

SurfaceEnergy SculptingSession::energy() const {
  Data& d = *data_;
  d.read_values();
  SurfaceEnergy energy = d.engine.elastic_energy(d.system(), d.values, d.now.shape.x);
  energy.bending *= d.system().def.scale().of_energies();
  energy.stretching *= d.system().def.scale().of_energies();
  return energy;
}

double SculptingSession::total_energy() const {
  Data& d = *data_;
  d.read_values();
  return d.engine.total_energy(d.system(), d.values, d.now.shape, d.now.in_motion) *
         d.system().def.scale().of_energies();
}

std::vector<Reaction> SculptingSession::reactions() const {
  Data& d = *data_;
  auto all = d.engine.reactions(d.system(), d.now.shape_values, d.now.shape.x);
  for (auto& reaction : all) reaction.force *= d.system().def.scale().of_reactions();
  return all;
}

std::vector<ScanDistances> SculptingSession::scan_distances(const Points& before) const {
  return data_->engine.scan_distances(data_->system(), before, dofs());
}

double SculptingSession::enclosed_volume() const {
  Data& d = *data_;
  return d.system().parts->pressure().volume(dofs(), {});
}

size_t SculptingSession::history_bytes() const { return data_->bytes(); }

}  // namespace batten
