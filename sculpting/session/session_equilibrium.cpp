#include <algorithm>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

using detail::SessionDefinition;

void SessionData::mark_converged() {
  now.converged_x = now.shape.x;
  now.converged_rest = system().rest;
  now.converged_values = now.shape_values = values;
  now.fresh.assign(values.size(), 0);
}

// Goes back to parameters and shape of the last answer that converged.
void SessionData::restore_converged() {
  if (now.converged_values.size() != static_cast<size_t>(now.parameters.count())) return;
  read_values();
  for (size_t p = 0; p < values.size(); ++p) {
    const ScalarParameter& own = now.parameters.all()[p];
    if (!now.fresh[p])
      values[p] = now.converged_values[p];
    else if (system().roles[p] != detail::kNothing)  // as near to no action as its range lets it
      values[p] = std::clamp(now.converged_values[p], own.min, own.max);
  }
  now.parameters.restore(values, now.parameters.time());
  now.shape_values = now.converged_values;
  now.shape.x = now.converged_x;
  engine.reset_acceleration();
  if (system().rest != now.converged_rest) engine.set_rest_shape(system(), now.converged_rest);
  ++version;
  read_values();
  engine.prepare_matrix(system(), values);
}

// Goes from the last good values to these in steps, which are halved where the shape does not
// settle.
detail::SessionEngine::SolveStatus SessionData::step_loads(
    const std::vector<double>& goal) {
  const std::vector<double> start = now.converged_values;
  Points reached_x = now.converged_x;
  double reached = 0, step = 0.5;
  detail::SessionEngine::SolveStatus total;
  constexpr double smallest = 1.0 / 256, nothing = 1e-9;  // of what was reached; of the way
  while (reached < 1) {
    if (progress.cancelled && progress.cancelled()) throw CancelledError();
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
    throw NoSolutionError("the shape does not settle within " +
                          std::to_string(options.max_iterations) +
                          " iterations (more alpha or beta, or less pressure)");
  throw NoSolutionError("past the limit at " + moved + ": " + format_number(100 * reached) +
                        " % of the way the shape settles, beyond that it does not within " +
                        std::to_string(options.max_iterations) +
                        " iterations (more alpha or beta, or less pressure)");
}

bool SessionData::has_scans() {
  for (const auto& load : system().def.loads)
    if (std::holds_alternative<Load::PointCloudSprings>(load->load.kind)) return true;
  return false;
}

// Plans smooth joins again where moved lines have turned tangents at nodes, so that γ and δ change.
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
      if (progress.cancelled && progress.cancelled()) throw CancelledError();
      const bool scans = has_scans();
      if (scans && !engine.update_scan_foot_points(system(), now.shape.x) && round > 0) break;
      answer.factored |= engine.prepare_matrix(system(), values);
      Points from = now.shape.x;
      auto run = engine.solve_preview(system(), values, now.shape.x, options.max_iterations,
                                      options.tolerance, false);
      answer.iterations += run.iterations;
      if (!run.converged) {
        const bool can_go_back = now.converged_values.size() == values.size();
        if (!can_go_back) {
          now.shape.x = from;
          throw NoSolutionError("the shape does not settle within " +
                                std::to_string(options.max_iterations) +
                                " iterations (more alpha or beta, or less pressure)");
        }
        const std::vector<double> goal = values;
        run = step_loads(goal);
        answer.iterations += run.iterations;
      }
      answer.change = run.change;
      mark_converged();
      if (!scans) break;
    }
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
      throw NoSolutionError("the surface runs off under these values: past the limit");
    now.shape_values = values;
    version += run.change != 0;
    if (run.converged) mark_converged();
  } catch (const Error&) {
    restore_converged();
    throw;
  }
  answer.time = now.parameters.time();
  return answer;
}

SolveReport SessionData::step() {
  if (!now.in_motion) throw InputError("a step of a surface that was not set in motion");
  SolveReport answer;
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
        now.shape.x.cwiseAbs().maxCoeff() > 1e6 * (size() + now.converged_x.cwiseAbs().maxCoeff()))
      throw NoSolutionError("the surface runs off at time " + format_number(now.parameters.time()) +
                            ": past the limit of its loads");
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

}  // namespace batten
