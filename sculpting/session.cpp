#include "batten/sculpting/session.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "batten/core/errors.h"
#include "batten/fem/curvature_jumps.h"
#include "batten/fem/surface_transfer.h"
#include "batten/sculpting/area.h"
#include "batten/sculpting/session_engine.h"
#include "batten/skinning/facets.h"

namespace batten {
namespace {

using live::Definition;
using live::Model;
using live::Shape;
using Kind = Operation::Kind;

// All that undo puts back.
struct State {
  std::shared_ptr<Model> model;
  Parameters parameters;
  Shape shape;
  bool in_motion = false;
  Motion motion;
  std::vector<double> shape_values;  // of the parameters, when the shape was made
  // The last answer that converged.
  Points good_x;
  std::vector<double> good_values;
  std::vector<char> fresh;  // parameters that have not acted on the shape yet: good at 0
};

const char* const kAxes[] = {".x", ".y", ".z"};
constexpr size_t kMostUndone = 256;
constexpr size_t kPage = 4096;

struct Display {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const DisplayPattern> pattern;
  std::unique_ptr<DisplayPoints> points;
};

template <class Things, class Name>
int find(const Things& things, const Name& name_of, const std::string& name) {
  for (size_t i = 0; i < things.size(); ++i)
    if (name_of(*things[i]) == name) return static_cast<int>(i);
  return -1;
}
const std::string& name_of(const live::PlacedLoad& p) { return p.load.name; }
const std::string& name_of(const live::PlacedWeight& p) { return p.weight.name; }
const std::string& name_of(const live::PlacedConstraint& p) { return p.constraint.name; }
const std::string& name_of(const live::PlacedMove& p) { return p.move.name; }

template <class Things>
int index_of(const Things& things, const std::string& name) {
  return find(
      things, [](const auto& p) -> const std::string& { return name_of(p); }, name);
}

}  // namespace

struct SculptingSession::Data {
  SessionOptions options;
  State now;
  std::deque<State> undone_to, redone_to;
  bool joins = false;  // what is set or stepped now belongs to the last step of the history
  bool recording = false;
  std::vector<Operation> record;
  live::Engine engine;
  std::vector<double> values, before;
  std::vector<std::string> value_names;
  Display display;
  Frame frame;
  long frames = 0, version = 0, shown = -1;  // the version of the shape that was drawn
  Progress progress;

  Model& model() { return *now.model; }
  const ModelLayout& layout() { return now.model->layout(); }
  double size() { return layout().size(); }
  Points absolute(const Points& x) {
    return x + model().parts->ones * model().origin().transpose();
  }
  Surface surface() { return layout().surface(absolute(now.shape.x)); }

  // -- history ------------------------------------------------------------------------------------
  State saved() const {
    State copy = now;
    copy.model = std::make_shared<Model>(*now.model);
    return copy;
  }
  void remember(State before) {
    redone_to.clear();
    undone_to.push_back(std::move(before));
    joins = false;
    while (undone_to.size() > kMostUndone ||
           (undone_to.size() > 1 && bytes() > options.history_bytes))
      undone_to.pop_front();
  }
  // A step of the history, unless a drag or a motion goes on that has one already.
  void remember_start() {
    if (joins) return;
    remember(saved());
    joins = true;
  }
  size_t bytes() const {
    std::set<const void*> seen;
    size_t sum = 0;
    for (const auto* list : {&undone_to, &redone_to})
      for (const State& s : *list)
        sum += live::bytes_of(*s.model, seen) +
               8 * static_cast<size_t>(s.shape.x.size() + s.shape.v.size() + s.good_x.size());
    return sum;
  }
  void put_back(State state) {
    now = std::move(state);
    engine.bind(*now.model);
    name_values();
    joins = false;
    ++version;
  }
  bool go(std::deque<State>& from, std::deque<State>& to) {
    if (from.empty()) return false;
    to.push_back(saved());
    State state = std::move(from.back());
    from.pop_back();
    put_back(std::move(state));
    return true;
  }
  void note(const Operation& op) {
    if (!recording) return;
    if (record.size() == record.capacity()) record.reserve(record.size() + kPage);
    record.push_back(op);
  }

  // A parameter that refuses its value leaves no step behind.
  template <class Change>
  void change_values(const Change& change) {
    if (joins) {
      change();
      return;
    }
    State before = saved();
    change();
    remember(std::move(before));
    joins = true;
  }

  // -- answers ------------------------------------------------------------------------------------
  void read_values() { values = now.parameters.values(); }
  void mark_good() {
    now.good_x = now.shape.x;
    now.good_values = now.shape_values = values;
    now.fresh.assign(values.size(), 0);
  }
  // Parameters and shape of the last answer that converged.
  void fall_back() {
    if (now.good_values.size() != static_cast<size_t>(now.parameters.count())) return;
    read_values();
    for (size_t p = 0; p < values.size(); ++p) {
      const NamedValue& own = now.parameters.all()[p];
      if (!now.fresh[p])
        values[p] = now.good_values[p];
      else if (model().roles[p] != live::kNothing)  // as near to no action as its range lets it
        values[p] = std::clamp(now.good_values[p], own.min, own.max);
    }
    now.parameters.restore(values, now.parameters.time());
    now.shape_values = now.good_values;
    now.shape.x = now.good_x;
    engine.forget();
    ++version;
    read_values();
    engine.prepare_matrix(model(), values);
  }

  // Towards the values in steps of the way from the last good ones.
  live::Engine::Run in_steps(const std::vector<double>& goal) {
    const std::vector<double> start = now.good_values;
    Points reached_x = now.good_x;
    double reached = 0, step = 0.5;
    live::Engine::Run total;
    constexpr double smallest = 1.0 / 256, nothing = 1e-9;  // of what was reached; of the way
    while (reached < 1) {
      if (progress.cancelled && progress.cancelled()) throw CancelledError();
      const double target = std::min(1.0, reached + step);
      for (size_t p = 0; p < goal.size(); ++p)
        values[p] = target == 1 ? goal[p] : start[p] + target * (goal[p] - start[p]);
      now.shape.x = reached_x;
      engine.forget();
      engine.prepare_matrix(model(), values);
      const auto run = engine.answer(model(), values, now.shape.x, options.most_iterations,
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
          (model().roles[p] != live::kNothing || now.parameters.all()[p].follows.empty()))
        moved += (moved.empty() ? "" : ", ") + ("'" + now.parameters.all()[p].name + "' = ") +
                 number(goal[p]) + " (" + number(start[p] + reached * (goal[p] - start[p])) +
                 " was reached)";
    if (moved.empty())
      throw NoSolutionError("the shape does not settle within " +
                            std::to_string(options.most_iterations) +
                            " iterations (more alpha or beta, or less pressure)");
    throw NoSolutionError("past the limit at " + moved + ": " + number(100 * reached) +
                          " % of the way the shape settles, beyond that it does not within " +
                          std::to_string(options.most_iterations) +
                          " iterations (more alpha or beta, or less pressure)");
  }

  bool has_measured() {
    for (const auto& load : model().def.loads)
      if (std::holds_alternative<Load::Springs>(load->load.kind)) return true;
    return false;
  }

  // Where the lines that moved have turned tangents at nodes, γ and δ of smooth joins are others.
  bool plan_joins() {
    constexpr double same = 1e-7;
    if (layout().seams().empty() || model().def.hold_corners ||
        !(layout().seam_misfit(absolute(now.shape.x)) > same))
      return false;
    ModelLayout next = layout();
    next.plan_seams(absolute(now.shape.x));
    Definition def = model().def;
    def.layout = std::make_shared<const ModelLayout>(std::move(next));
    rebuild(std::move(def));
    return true;
  }

  Answer settle() {
    Answer answer = settle_once();
    constexpr int most_plans = 4;
    for (int i = 0; i < most_plans && plan_joins(); ++i) {
      const int before = answer.iterations;
      answer = settle_once();
      answer.iterations += before;
      answer.joins_planned = true;
    }
    return answer;
  }

  Answer settle_once() {
    Answer answer;
    try {
      read_values();
      constexpr int most_rounds = 20;
      for (int round = 0; round < most_rounds; ++round) {
        if (progress.cancelled && progress.cancelled()) throw CancelledError();
        const bool measured = has_measured();
        if (measured && !engine.follow_measured(model(), now.shape.x) && round > 0) break;
        answer.factored |= engine.prepare_matrix(model(), values);
        Points from = now.shape.x;
        auto run = engine.answer(model(), values, now.shape.x, options.most_iterations,
                                 options.tolerance, false);
        answer.iterations += run.iterations;
        if (!run.converged) {
          const bool can_go_back = now.good_values.size() == values.size();
          if (!can_go_back) {
            now.shape.x = from;
            throw NoSolutionError("the shape does not settle within " +
                                  std::to_string(options.most_iterations) +
                                  " iterations (more alpha or beta, or less pressure)");
          }
          const std::vector<double> goal = values;
          run = in_steps(goal);
          answer.iterations += run.iterations;
        }
        answer.change = run.change;
        mark_good();
        if (!measured) break;
      }
    } catch (const Error&) {
      fall_back();
      throw;
    }
    now.shape.v.setZero();
    joins = false;
    ++version;
    answer.time = now.parameters.time();
    return answer;
  }

  Answer quick(int most, double tolerance) {
    Answer answer;
    read_values();
    try {
      answer.factored = engine.prepare_matrix(model(), values);
      const auto run =
          engine.answer(model(), values, now.shape.x, std::max(1, most), tolerance, true);
      answer.converged = run.converged;
      answer.iterations = run.iterations;
      answer.change = run.change;
      answer.superposed = run.superposed;
      answer.expected = run.expected;
      if (run.ran_off)
        throw NoSolutionError("the surface runs off under these values: past the limit");
      now.shape_values = values;
      version += run.change != 0;
      if (run.converged) mark_good();
    } catch (const Error&) {
      fall_back();
      throw;
    }
    answer.time = now.parameters.time();
    return answer;
  }

  Answer step() {
    if (!now.in_motion) throw InputError("a step of a surface that was not set in motion");
    Answer answer;
    // From the values that the shape has been made with.
    before = now.shape_values;
    const double time = now.parameters.time();
    now.parameters.set_time(time + now.motion.dt);
    read_values();
    try {
      answer.factored = engine.prepare_matrix(model(), values);
      answer.factored |= engine.prepare_motion(model(), now.motion);
      engine.step(model(), before, values, now.shape);
      if (!now.shape.x.allFinite() ||
          now.shape.x.cwiseAbs().maxCoeff() > 1e6 * (size() + now.good_x.cwiseAbs().maxCoeff()))
        throw NoSolutionError("the surface runs off at time " + number(now.parameters.time()) +
                              ": past the limit of its loads");
    } catch (const Error&) {
      now.shape.v.setZero();
      now.parameters.restore(before, time);
      fall_back();
      throw;
    }
    ++version;
    mark_good();
    answer.iterations = 1;
    answer.time = now.parameters.time();
    return answer;
  }

  // -- edits --------------------------------------------------------------------------------------
  void rebuild(Definition def) {
    // Values by name: numbers of parameters change.
    struct Known {
      std::string name;
      double good, shape;
      char fresh;
    };
    std::vector<Known> known;
    for (size_t i = 0; i < now.good_values.size(); ++i)
      known.push_back({value_names[i], now.good_values[i], now.shape_values[i], now.fresh[i]});
    now.model = live::build(std::move(def), now.parameters, now.model.get());
    engine.bind(model());
    name_values();
    // What is new has not acted on the shape yet.
    const auto& parameters = now.parameters.all();
    now.good_values.resize(parameters.size());
    now.shape_values.resize(parameters.size());
    now.fresh.resize(parameters.size());
    for (size_t p = 0; p < parameters.size(); ++p) {
      const auto it = std::find_if(known.begin(), known.end(),
                                   [&](const Known& k) { return k.name == parameters[p].name; });
      const bool goal = model().roles[p] & live::kGoal;
      const double start = goal ? now.parameters.value(static_cast<int>(p)) : 0;
      const Known k = it != known.end() ? *it : Known{"", start, start, 1};
      now.good_values[p] = k.good;
      now.shape_values[p] = k.shape;
      now.fresh[p] = k.fresh;
    }
  }
  // Of which parameter each value is.
  void name_values() {
    value_names.clear();
    for (const NamedValue& p : now.parameters.all()) value_names.push_back(p.name);
  }

  // After the rows changed: on the static shape, or in motion as near as can be.
  void hold() {
    read_values();
    if (!now.in_motion) {
      settle();
      return;
    }
    engine.prepare_matrix(model(), values);
    engine.project(model(), values, now.shape);
    ++version;
    mark_good();
  }
  // After loads changed: the shape stays as it is, for the values that it was made with.
  void stay() {
    read_values();
    engine.prepare_matrix(model(), values);
  }

  void require_free_name(const std::string& name) {
    if (name.empty()) throw InputError("something that acts on the surface has no name");
    const Definition& d = model().def;
    if (index_of(d.loads, name) >= 0 || index_of(d.weights, name) >= 0 ||
        index_of(d.constraints, name) >= 0 || index_of(d.moves, name) >= 0 ||
        layout().has_line(name))
      throw InputError("two things have the name '" + name + "'");
  }

  void add_parameters(const std::string& name, std::vector<NamedValue> given,
                      const std::vector<std::string>& wanted, const std::vector<double>& start) {
    for (const NamedValue& g : given)
      if (std::find(wanted.begin(), wanted.end(), g.name) == wanted.end())
        throw InputError("'" + name + "' has no parameter '" + g.name + "'");
    for (size_t i = 0; i < wanted.size(); ++i) {
      const auto it = std::find_if(given.begin(), given.end(),
                                   [&](const NamedValue& g) { return g.name == wanted[i]; });
      NamedValue value;
      value.name = wanted[i];
      value.value = start[i];
      now.parameters.add(it == given.end() ? value : *it);
    }
  }

  void add(const Load& load, const std::vector<NamedValue>& parameters) {
    require_free_name(load.name);
    Definition def = model().def;
    def.loads.push_back(
        std::make_shared<const live::PlacedLoad>(live::place(load, def, surface())));
    add_parameters(load.name, parameters, {load.name}, {0});
    rebuild(std::move(def));
    stay();
  }
  void add(const WeightField& weight, const std::vector<NamedValue>& parameters) {
    require_free_name(weight.name);
    Definition def = model().def;
    def.weights.push_back(
        std::make_shared<const live::PlacedWeight>(live::place(weight, def, surface())));
    add_parameters(weight.name, parameters, {weight.name}, {0});
    rebuild(std::move(def));
    stay();
  }
  void add(const Constraint& constraint, const std::vector<NamedValue>& parameters) {
    require_free_name(constraint.name);
    Definition def = model().def;
    def.constraints.push_back(
        std::make_shared<const live::PlacedConstraint>(live::place(constraint, def, surface())));
    std::vector<std::string> wanted;
    std::vector<double> start;
    if (const auto* point = std::get_if<Constraint::Point>(&constraint.kind))
      for (int c = 0; c < 3; ++c) {
        wanted.push_back(constraint.name + kAxes[c]);
        start.push_back(point->goal[c]);
      }
    add_parameters(constraint.name, parameters, wanted, start);
    rebuild(std::move(def));
    hold();
  }
  void add(const LineMove& move, const std::vector<NamedValue>& parameters) {
    require_free_name(move.name);
    Definition def = model().def;
    def.moves.push_back(
        std::make_shared<const live::PlacedMove>(live::place(move, def, surface())));
    add_parameters(move.name, parameters, {move.name}, {0});
    rebuild(std::move(def));
    hold();
  }
  void add(const CharacterLine& line, const std::vector<NamedValue>& parameters) {
    if (!parameters.empty()) throw InputError("line '" + line.name + "' has no parameters");
    require_free_name(line.name);
    require_lines("added");
    ModelLayout layout = this->layout();
    layout.add_inner(line, absolute(now.shape.x));
    move_to(std::move(layout));
  }

  void require_lines(const char* what) {
    if (model().def.hold_corners)
      throw InputError(std::string("lines cannot be ") + what + " here: only the corners are held");
  }

  // On a layout with other meshes or other lines; the shape is carried over.
  CarriedOver move_to(ModelLayout layout) {
    const auto carry = [&](const Points& absolute_dofs) {
      CarriedOver all;
      std::vector<Points> each;
      for (int r = 0; r < layout.region_count(); ++r) {
        const RegionLayout& from = this->layout().region(r);
        CarriedOver own =
            carried_over(Surface(from.mesh(), from.element(),
                                 this->layout().region_dofs(r, absolute_dofs), from.trim()),
                         *layout.region(r).mesh());
        all.max_displacement = std::max(all.max_displacement, own.max_displacement);
        each.push_back(std::move(own.dofs));
      }
      all.dofs = layout.all_dofs(each);
      return all;
    };
    bool other_mesh = false;
    for (int r = 0; r < layout.region_count(); ++r)
      other_mesh = other_mesh || layout.region(r).mesh() != this->layout().region(r).mesh();
    Definition def = model().def;
    CarriedOver carried;
    Shape shape = now.shape;
    if (other_mesh) {
      carried = carry(absolute(now.shape.x));
      if (now.in_motion) shape.v = carry(now.shape.v).dofs;
      // Places that things refer to go along.
      std::vector<std::pair<live::SharedPoints, live::SharedPoints>> moved;
      const auto along = [&](live::SharedPoints& on) {
        if (!on) return;
        for (const auto& [old, made] : moved)
          if (old == on) {
            on = made;
            return;
          }
        auto made = std::make_shared<const Points>(carry(*on).dofs);
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
    if (other_mesh && !layout.seams().empty()) layout.plan_seams(carried.dofs);
    def.layout = std::make_shared<const ModelLayout>(std::move(layout));
    rebuild(std::move(def));
    if (other_mesh) {
      VecX ones = model().parts->ones;
      shape.x = carried.dofs - ones * model().origin().transpose();
      if (!now.in_motion) shape.v = Points::Zero(shape.x.rows(), 3);
      now.shape = std::move(shape);
      now.good_x = now.shape.x;
    }
    hold();
    return carried;
  }

  void change(const Constraint& constraint) {
    Definition def = model().def;
    const int at = index_of(def.constraints, constraint.name);
    if (at < 0)
      throw InputError("there is no constraint '" + constraint.name + "'" +
                       near_to(constraint.name));
    auto& placed = def.constraints[static_cast<size_t>(at)];
    if (placed->constraint.kind.index() != constraint.kind.index())
      throw InputError("constraint '" + constraint.name +
                       "' changes its place or direction, not its kind: remove it first");
    placed =
        std::make_shared<const live::PlacedConstraint>(live::place(constraint, def, surface()));
    if (const auto* point = std::get_if<Constraint::Point>(&constraint.kind))
      for (int c = 0; c < 3; ++c) now.parameters.set(constraint.name + kAxes[c], point->goal[c]);
    rebuild(std::move(def));
    hold();
  }

  std::vector<std::string> names() {
    std::vector<std::string> all;
    const Definition& d = model().def;
    for (const auto& p : d.loads) all.push_back(name_of(*p));
    for (const auto& p : d.weights) all.push_back(name_of(*p));
    for (const auto& p : d.constraints) all.push_back(name_of(*p));
    for (const auto& p : d.moves) all.push_back(name_of(*p));
    for (int r = 0; r < layout().region_count(); ++r)
      for (const EmbeddedLine& line : layout().region(r).embedded())
        if (line.line.role == CharacterLine::Role::Inner) all.push_back(line.line.name);
    return all;
  }
  std::string near_to(const std::string& name) {
    const std::string near = nearest_word(name, names());
    return near.empty() ? "" : "; did you mean '" + near + "'?";
  }

  void remove(const std::string& name) {
    Definition def = model().def;
    const int held = index_of(def.constraints, name);
    const bool was_point =
        held >= 0 && std::holds_alternative<Constraint::Point>(
                         def.constraints[static_cast<size_t>(held)]->constraint.kind);
    const auto take = [&](auto& things) {
      const int at = index_of(things, name);
      if (at >= 0) things.erase(things.begin() + at);
      return at >= 0;
    };
    const bool load = take(def.loads), weight = !load && take(def.weights),
               constraint = !load && !weight && take(def.constraints),
               move = !load && !weight && !constraint && take(def.moves);
    if (load || weight || move) now.parameters.remove(name);
    if (constraint && was_point)
      for (const char* axis : kAxes) now.parameters.remove(name + axis);
    if (load || weight || constraint || move) {
      rebuild(std::move(def));
      if (load || weight)
        stay();
      else
        hold();
      return;
    }
    if (!layout().has_line(name))
      throw InputError("there is nothing with the name '" + name + "' to remove" + near_to(name));
    refuse_if_used(name);
    ModelLayout layout = this->layout();
    layout.remove_inner(name);
    move_to(std::move(layout));
  }

  void refuse_if_used(const std::string& line) {
    const auto refuse = [&](const std::string& user) {
      throw InputError("line '" + line + "' cannot be removed: '" + user + "' refers to it");
    };
    const auto near = [&](const Area& area) {
      const auto* at = std::get_if<Area::NearLine>(&area.where);
      return at && at->line == line;
    };
    for (const auto& p : model().def.loads) {
      if (const auto* l = std::get_if<Load::Line>(&p->load.kind); l && l->line == line)
        refuse(p->load.name);
      if (const auto* l = std::get_if<Load::Pressure>(&p->load.kind); l && near(l->area))
        refuse(p->load.name);
      if (const auto* l = std::get_if<Load::Uniform>(&p->load.kind); l && near(l->area))
        refuse(p->load.name);
    }
    for (const auto& p : model().def.weights) {
      const auto* along = p->weight.along ? std::get_if<std::string>(&*p->weight.along) : nullptr;
      if (near(p->weight.area) || (along && *along == line)) refuse(p->weight.name);
    }
    for (const auto& p : model().def.constraints)
      if (const auto* c = std::get_if<Constraint::LineNormal>(&p->constraint.kind);
          c && c->line == line)
        refuse(p->constraint.name);
    for (const auto& p : model().def.moves)
      if (p->move.line == line) refuse(p->move.name);
  }

  void set_line(const std::string& name, const HermiteCurve& curve) {
    require_lines("edited");
    ModelLayout layout = this->layout();
    layout.set_line(name, curve);
    Definition def = model().def;
    def.layout = std::make_shared<const ModelLayout>(std::move(layout));
    rebuild(std::move(def));
    hold();
  }

  void start_motion(const Motion& m) {
    if (!(m.dt > 0) || !std::isfinite(m.dt))
      throw InputError("a time step of " + number(m.dt) + ": expected one above 0");
    if (!(m.density >= 0) || !(m.damping >= 0) || !(m.density + m.damping > 0) ||
        !std::isfinite(m.density + m.damping))
      throw InputError("density " + number(m.density) + " and damping " + number(m.damping) +
                       ": expected both 0 or more, and not both 0");
    if (!(m.theta >= 0.5) || !(m.theta <= 1))
      throw InputError("theta = " + number(m.theta) + ": expected 0.5 to 1");
    now.motion = m;
    now.in_motion = true;
    now.shape.v.setZero();
    read_values();
    engine.prepare_matrix(model(), values);
    engine.prepare_motion(model(), m);
  }

  RefinementReport refine(const Refinement& refinement);
  HermiteCurve line(const std::string& name);
  SkinnedRegion made(int region);
  void draw(Frame& to);
  double elastic_energy(const Points& x) {
    const SurfaceEnergy e = engine.elastic_energy(model(), values, x);
    return (e.stretching + e.bending) * model().def.scale().of_energies();
  }
  void edit(const Operation::Edit& edit);
};

namespace {

// Triangles that a refinement halves.
std::vector<char> marks(const Refinement& refinement, const ModelLayout& layout,
                        const Surface& surface, const std::vector<double>& jumps) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> marked(static_cast<size_t>(mesh.triangle_count()), 0);
  const auto longest = [&](int t) {
    double length = 0;
    const auto& v = mesh.triangles()[static_cast<size_t>(t)];
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = surface.dofs().row(surface.dof_map().vertex(v[static_cast<size_t>(i)])),
                 b = surface.dofs().row(
                     surface.dof_map().vertex(v[static_cast<size_t>((i + 1) % 3)]));
      length = std::max(length, (a - b).norm());
    }
    return length;
  };
  const double smallest = refinement.smallest;
  const auto mark = [&](int t) {
    if (longest(t) > 2 * smallest) marked[static_cast<size_t>(t)] = 1;
  };
  if (const auto* brush = std::get_if<Refinement::Brush>(&refinement.where)) {
    if (brush->strokes.empty()) throw InputError("a refinement by brush without strokes");
    for (const auto& stroke : brush->strokes) {
      if (!stroke.at.allFinite() || !(stroke.radius > 0) || !std::isfinite(stroke.radius))
        throw InputError("a refinement stroke needs a place and a radius above 0");
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& L : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(.5, .5, 0),
                              Vec3(0, .5, .5), Vec3(.5, 0, .5), Vec3(1. / 3, 1. / 3, 1. / 3)})
          nearest = std::min(nearest, (surface.position({t, L}) - stroke.at).norm());
        if (nearest < stroke.radius) mark(t);
      }
    }
    return marked;
  }
  const double share = std::get<Refinement::Jumps>(refinement.where).share;
  if (!(share > 0 && share <= 1))
    throw InputError("a refinement of the share " + number(share) +
                     " of the jumps: expected above 0, at most 1");
  std::vector<int> order(jumps.size());
  for (size_t t = 0; t < order.size(); ++t) order[t] = static_cast<int>(t);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return jumps[static_cast<size_t>(a)] > jumps[static_cast<size_t>(b)];
  });
  double sum = 0, taken = 0;
  for (const double j : jumps) sum += j;
  for (const int t : order) {
    if (!(taken < share * sum)) break;
    taken += jumps[static_cast<size_t>(t)];
    mark(t);
  }
  return marked;
}

}  // namespace

RefinementReport SculptingSession::Data::refine(const Refinement& refinement) {
  RefinementReport report;
  report.triangles_before = layout().mesh()->triangle_count();
  Refinement wanted = refinement;
  if (!(wanted.smallest >= 0) || !std::isfinite(wanted.smallest))
    throw InputError("a smallest edge of " + number(wanted.smallest) + ": expected 0 or more");
  if (wanted.smallest == 0) wanted.smallest = size() / 2000;
  const Surface surface = this->surface();
  std::vector<double> jumps;
  if (std::holds_alternative<Refinement::Jumps>(wanted.where)) {
    // In the units of the whole model: a region's own count (S/s_r)².
    for (int r = 0; r < layout().region_count(); ++r) {
      const VecX own = curvature_jumps(made(r).surface);
      const double scale = layout().domain_scale().size() > 0
                               ? layout().domain_scale()[layout().first_triangle(r)]
                               : 1;
      for (long t = 0; t < own.size(); ++t) jumps.push_back(own[t] / scale);
    }
  }
  const std::vector<char> marked = marks(wanted, layout(), surface, jumps);
  read_values();
  report.energy_before = report.energy_carried = report.energy_settled =
      elastic_energy(now.shape.x);
  report.triangles = report.triangles_before;
  ModelLayout layout = this->layout();
  if (!layout.refine(marked)) return report;
  if (layout.mesh()->triangle_count() > wanted.most_triangles)
    throw InputError("the refinement would make " +
                     std::to_string(layout.mesh()->triangle_count()) + " triangles, more than " +
                     std::to_string(wanted.most_triangles));
  report.triangles = layout.mesh()->triangle_count();
  const CarriedOver carried = move_to(std::move(layout));
  report.max_displacement = carried.max_displacement / size();
  report.energy_settled = elastic_energy(now.shape.x);
  report.energy_carried =
      elastic_energy(carried.dofs - model().parts->ones * model().origin().transpose());
  return report;
}

void SculptingSession::Data::edit(const Operation::Edit& edit) {
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
    rebuild(model().def);
    stay();
  } else if (const auto* rule = std::get_if<Operation::Drive>(&edit)) {
    now.parameters.drive(rule->parameter, rule->follows, rule->offset);
  }
}

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
    constexpr double infinity = std::numeric_limits<double>::infinity();
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
  d.now.model = live::build(std::move(def), p, nullptr);
  d.engine.bind(*d.now.model);
  d.name_values();
  d.now.shape.x = d.now.shape.v = Points::Zero(d.now.model->dofs(), 3);
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
  Operation op;
  op.kind = Kind::Set;
  op.index = parameter;
  op.value = value;
  apply(op);
}

namespace {

Operation edit_of(Operation::Edit edit) {
  Operation op;
  op.kind = Kind::Edit;
  op.edit = std::make_shared<const Operation::Edit>(std::move(edit));
  return op;
}

}  // namespace

void SculptingSession::add_parameter(NamedValue parameter) {
  apply(edit_of(Operation::AddParameter{std::move(parameter)}));
}
void SculptingSession::drive(const std::string& parameter, std::vector<NamedValue::Share> follows,
                             double offset) {
  apply(edit_of(Operation::Drive{parameter, std::move(follows), offset}));
}
void SculptingSession::add(Load load, std::vector<NamedValue> parameters) {
  apply(edit_of(Operation::Add{std::move(load), std::move(parameters)}));
}
void SculptingSession::add(WeightField weight, std::vector<NamedValue> parameters) {
  apply(edit_of(Operation::Add{std::move(weight), std::move(parameters)}));
}
void SculptingSession::add(Constraint constraint, std::vector<NamedValue> parameters) {
  apply(edit_of(Operation::Add{std::move(constraint), std::move(parameters)}));
}
void SculptingSession::add(LineMove move, std::vector<NamedValue> parameters) {
  apply(edit_of(Operation::Add{std::move(move), std::move(parameters)}));
}
void SculptingSession::add(CharacterLine line) {
  apply(edit_of(Operation::Add{std::move(line), {}}));
}
void SculptingSession::change(Constraint constraint) {
  apply(edit_of(Operation::Change{std::move(constraint)}));
}
void SculptingSession::remove(const std::string& name) { apply(edit_of(Operation::Remove{name})); }
void SculptingSession::set_line(const std::string& line, HermiteCurve curve) {
  apply(edit_of(Operation::SetLine{line, std::move(curve)}));
}

HermiteCurve SculptingSession::Data::line(const std::string& name) {
  HermiteCurve curve = layout().line(name);
  const Definition& def = model().def;
  for (size_t i = 0; i < def.moves.size(); ++i)
    if (def.moves[i]->move.line == name)
      curve = live::sum(curve, def.moves[i]->displacement,
                        now.parameters.value(model().move_parameter[i]));
  return curve;
}

HermiteCurve SculptingSession::line(const std::string& name) const { return data_->line(name); }

std::vector<std::string> SculptingSession::names() const { return data_->names(); }

Answer SculptingSession::settle() {
  data_->note({});
  return data_->settle();
}

Answer SculptingSession::answer(int most_iterations, double tolerance) {
  Data& d = *data_;
  Operation op;
  op.kind = Kind::Answer;
  op.index = most_iterations;
  op.value = tolerance;
  d.note(op);
  if (d.now.in_motion)
    throw InputError("an answer of a surface in motion: step() goes on, stop_motion() ends it");
  return d.quick(most_iterations, tolerance);
}

void SculptingSession::start_motion(const Motion& motion) { apply(edit_of(motion)); }

Answer SculptingSession::step() {
  Data& d = *data_;
  Operation op;
  op.kind = Kind::Step;
  d.note(op);
  if (d.now.in_motion) d.remember_start();
  return d.step();
}

void SculptingSession::stop_motion() {
  Operation op;
  op.kind = Kind::Rest;
  apply(op);
}

bool SculptingSession::in_motion() const { return data_->now.in_motion; }

void SculptingSession::set_time(double time) {
  Operation op;
  op.kind = Kind::Time;
  op.value = time;
  apply(op);
}

bool SculptingSession::undo() {
  Operation op;
  op.kind = Kind::Undo;
  data_->note(op);
  return data_->go(data_->undone_to, data_->redone_to);
}

bool SculptingSession::redo() {
  Operation op;
  op.kind = Kind::Redo;
  data_->note(op);
  return data_->go(data_->redone_to, data_->undone_to);
}

void SculptingSession::record(bool on) {
  data_->recording = on;
  if (on) data_->record.reserve(data_->record.size() + kPage);
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
  State before = d.saved();
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
  State before = d.saved();
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

SkinnedRegion SculptingSession::Data::made(int r) {
  SkinnedRegion region = layout().skinned(r, absolute(now.shape.x));
  const auto moved = [&](CharacterLine& line, HermiteCurve& fitted, bool embedded, size_t index) {
    const auto& moves = model().def.moves;
    if (std::none_of(moves.begin(), moves.end(),
                     [&](const auto& m) { return m->move.line == line.name; }))
      return;
    fitted = this->line(line.name);
    if (layout().against(layout().model_line(line.name), {r, embedded, static_cast<int>(index)}))
      fitted = fitted.backwards();
    line.curve = curve_from_hermite(fitted);
  };
  for (size_t i = 0; i < region.runs.size(); ++i)
    moved(region.runs[i].line, region.runs[i].fitted, false, i);
  for (size_t i = 0; i < region.embedded.size(); ++i) {
    EmbeddedLine& line = region.embedded[i];
    moved(line.line, line.fitted, true, i);
    // An image of the same nodes.
    if (line.image.parameters() != line.fitted.parameters())
      line.image = line.image.with_nodes(line.fitted.parameters());
  }
  return region;
}

SkinnedRegion SculptingSession::region(int r) const { return data_->made(r); }

std::vector<SkinnedRegion> SculptingSession::regions() const {
  std::vector<SkinnedRegion> all;
  for (int r = 0; r < layout().region_count(); ++r) all.push_back(region(r));
  return all;
}

void SculptingSession::Data::draw(Frame& to) {
  if (display.mesh != layout().mesh()) {
    auto pattern = std::make_shared<DisplayPattern>();
    std::vector<Location> places;
    for (int r = 0; r < layout().region_count(); ++r) {
      DisplayFacets own = facets(made(r), options.facets_per_edge);
      const int first = static_cast<int>(places.size());
      for (const Location& where : own.tessellation.points)
        places.push_back(layout().in_model(r, where));
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
    display.pattern = pattern;
    display.points = std::make_unique<DisplayPoints>(*layout().mesh(), layout().element(), places);
    display.mesh = layout().mesh();
  }
  to.remeshed = to.pattern != display.pattern;
  to.pattern = display.pattern;
  const auto count = 3 * static_cast<size_t>(display.points->count());
  to.points.resize(count);
  to.normals.resize(count);
  to.moved = to.remeshed || shown != version;
  to.number = ++frames;
  display.points->evaluate(now.shape.x, model().origin(), to.points.data(), to.normals.data());
  shown = version;
}

void SculptingSession::draw(Frame& to) { data_->draw(to); }

const Frame& SculptingSession::frame() {
  data_->draw(data_->frame);
  return data_->frame;
}

double SculptingSession::residual() const {
  Data& d = *data_;
  return d.engine.residual(d.model(), d.now.shape_values, d.now.shape.x) / d.size();
}

SurfaceEnergy SculptingSession::energy() const {
  Data& d = *data_;
  d.read_values();
  SurfaceEnergy energy = d.engine.elastic_energy(d.model(), d.values, d.now.shape.x);
  energy.bending *= d.model().def.scale().of_energies();
  energy.stretching *= d.model().def.scale().of_energies();
  return energy;
}

double SculptingSession::total_energy() const {
  Data& d = *data_;
  d.read_values();
  return d.engine.total_energy(d.model(), d.values, d.now.shape, d.now.in_motion) *
         d.model().def.scale().of_energies();
}

std::vector<Reaction> SculptingSession::reactions() const {
  Data& d = *data_;
  auto all = d.engine.reactions(d.model(), d.now.shape_values, d.now.shape.x);
  for (auto& reaction : all) reaction.force *= d.model().def.scale().of_reactions();
  return all;
}

std::vector<SpringDistances> SculptingSession::spring_distances(const Points& before) const {
  return data_->engine.spring_distances(data_->model(), before, dofs());
}

double SculptingSession::enclosed_volume() const {
  Data& d = *data_;
  return d.model().parts->pressure().volume(dofs(), {});
}

size_t SculptingSession::history_bytes() const { return data_->bytes(); }

}  // namespace batten
