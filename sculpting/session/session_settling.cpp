#include <algorithm>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

using live::Definition;

void SculptingSession::Data::mark_good() {
  now.good_x = now.shape.x;
  now.good_rest = system().rest;
  now.good_values = now.shape_values = values;
  now.fresh.assign(values.size(), 0);
}

// Goes back to parameters and shape of the last answer that converged.
void SculptingSession::Data::fall_back() {
  if (now.good_values.size() != static_cast<size_t>(now.parameters.count())) return;
  read_values();
  for (size_t p = 0; p < values.size(); ++p) {
    const NamedValue& own = now.parameters.all()[p];
    if (!now.fresh[p])
      values[p] = now.good_values[p];
    else if (system().roles[p] != live::kNothing)  // as near to no action as its range lets it
      values[p] = std::clamp(now.good_values[p], own.min, own.max);
  }
  now.parameters.restore(values, now.parameters.time());
  now.shape_values = now.good_values;
  now.shape.x = now.good_x;
  engine.forget();
  if (system().rest != now.good_rest) engine.set_rest(system(), now.good_rest);
  ++version;
  read_values();
  engine.prepare_matrix(system(), values);
}

// Goes from the last good values to these in steps, which are halved where the shape does not
// settle.
live::Engine::Run SculptingSession::Data::in_steps(const std::vector<double>& goal) {
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
    engine.prepare_matrix(system(), values);
    const auto run = engine.answer(system(), values, now.shape.x, options.most_iterations,
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
        (system().roles[p] != live::kNothing || now.parameters.all()[p].follows.empty()))
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

bool SculptingSession::Data::has_scans() {
  for (const auto& load : system().def.loads)
    if (std::holds_alternative<Load::Scan>(load->load.kind)) return true;
  return false;
}

// Plans smooth joins again where moved lines have turned tangents at nodes, so that γ and δ change.
bool SculptingSession::Data::plan_joins() {
  constexpr double same = 1e-7;
  if (layout().join_plans().empty() || system().def.hold_corners ||
      !(layout().join_misfit(absolute(now.shape.x)) > same))
    return false;
  ModelLayout next = layout();
  next.plan_joins(absolute(now.shape.x));
  Definition def = system().def;
  def.layout = std::make_shared<const ModelLayout>(std::move(next));
  rebuild(std::move(def));
  return true;
}

Answer SculptingSession::Data::settle(bool anew) {
  Answer answer = settle_once(anew);
  constexpr int most_plans = 4;
  for (int i = 0; i < most_plans && plan_joins(); ++i) {
    const int before = answer.iterations;
    answer = settle_once(anew);
    answer.iterations += before;
    answer.joins_planned = true;
  }
  return answer;
}

Answer SculptingSession::Data::settle_once(bool anew) {
  Answer answer;
  try {
    read_values();
    find_rest(anew);
    constexpr int most_rounds = 20;
    for (int round = 0; round < most_rounds; ++round) {
      if (progress.cancelled && progress.cancelled()) throw CancelledError();
      const bool scans = has_scans();
      if (scans && !engine.follow_scans(system(), now.shape.x) && round > 0) break;
      answer.factored |= engine.prepare_matrix(system(), values);
      Points from = now.shape.x;
      auto run = engine.answer(system(), values, now.shape.x, options.most_iterations,
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
      if (!scans) break;
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

Answer SculptingSession::Data::quick(int most, double tolerance) {
  Answer answer;
  read_values();
  try {
    answer.factored = engine.prepare_matrix(system(), values);
    const auto run =
        engine.answer(system(), values, now.shape.x, std::max(1, most), tolerance, true);
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

Answer SculptingSession::Data::step() {
  if (!now.in_motion) throw InputError("a step of a surface that was not set in motion");
  Answer answer;
  // From the values that the shape has been made with.
  before = now.shape_values;
  const double time = now.parameters.time();
  now.parameters.set_time(time + now.motion.dt);
  read_values();
  try {
    answer.factored = engine.prepare_matrix(system(), values);
    answer.factored |= engine.prepare_motion(system(), now.motion);
    engine.step(system(), before, values, now.shape);
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

}  // namespace batten
