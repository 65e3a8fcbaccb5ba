#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

namespace {

// Changes below this share of the size that do not fall any more are rounding.
constexpr double kRoundingFloor = 1e-9;
// After a change above this times the size in one iteration no shape comes back.
constexpr double kDivergence = 1e6;

}  // namespace

bool SessionEngine::is_linear(const SessionSystem& system,
                              const std::vector<double>& values) const {
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    const bool follows = std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind) ||
                         (system.roles[p] & kSpring && system.roles[p] & kPressure);
    if (follows && values[p] != 0) return false;
  }
  return true;
}

void SessionEngine::map(SessionSystem& system, const std::vector<double>& values, const Points& x,
                        Points& to) {
  y_ = base_;
  bool has_pressure = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    if (!std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind)) continue;
    const double v = values[system.load_parameter[l]];
    if (v == 0) continue;
    if (!has_pressure) F_.setZero();
    has_pressure = true;
    system.parts->pressure().add(x, system.loads[l]->weights, v * system.loads[l]->scale, F_);
  }
  if (has_pressure) system.statics->add_load(F_, y_);
  set_spring_targets(system, values, x);
  system.statics->solve(y_);
  system.coupling->apply(y_, g_);
  system.statics->expand(y_, e_, to);
}

// Where only linear loads moved since the anchor, the answer is its shape and a response to each
// load.
bool SessionEngine::superpose(SessionSystem& system, const std::vector<double>& values, Points& x,
                              SolveStatus& run) {
  for (size_t p = 0; p < values.size(); ++p)
    if (values[p] != anchor_values_[p] && (system.roles[p] & ~unsigned(kLinear)) != 0) return false;
  if (x_is_anchor_) anchor_ = x;
  x_is_anchor_ = false;
  next_ = anchor_;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    if (system.loads[l]->reduced.rows() == 0 || values[p] == anchor_values_[p]) continue;
    if (!response_is_known_[l]) {
      // The answer to the load alone: rows at zero, springs as stiff as they are.
      y_ = system.loads[l]->reduced;
      system.statics->solve(y_);
      g_.setZero();
      system.coupling->apply(y_, g_);
      responses_[l].resize(x.rows(), 3);
      responses_[l].noalias() = system.reduction->D() * y_;
      response_is_known_[l] = 1;
      ++run.iterations;
    }
    next_ += (values[p] - anchor_values_[p]) * responses_[l];
  }
  run.change = change_between(next_, x) / system.layout().size();
  x.swap(next_);
  run.converged = run.superposed = true;
  return true;
}

// In a drag the last answers tell how good the first guess is. It is then taken without a second
// iteration, but for every fourth answer, which measures again.
bool SessionEngine::accept_first_iterate(double first_change, double tolerance, SolveStatus& run) {
  constexpr double careful = 5;
  constexpr int most_unseen = 3;
  const double expected = careful * contraction_ratio_ * first_change;
  run.change_is_estimated = run.iterations == 1 && contraction_ratio_ > 0 &&
                            unmeasured_count_ < most_unseen && expected <= tolerance;
  unmeasured_count_ = run.change_is_estimated ? unmeasured_count_ + 1 : 0;
  if (run.change_is_estimated) {
    run.change = expected;
    run.converged = true;
  }
  return run.change_is_estimated;
}

SessionEngine::SolveStatus SessionEngine::solve_preview(SessionSystem& system,
                                                        const std::vector<double>& values,
                                                        Points& x, int most, double tolerance,
                                                        bool may_superpose) {
  const double size = system.layout().size();
  SolveStatus run;
  const bool linear = is_linear(system, values);
  if (linear && may_superpose && anchored_ && superpose(system, values, x, run)) return run;
  anchored_ = false;
  prepare_rhs(system, values);
  accelerator_.begin();
  double least_change = std::numeric_limits<double>::infinity();
  int iterations_since_least = 0;
  double first_change = 0;
  while (run.iterations < most) {
    map(system, values, x, next_);
    ++run.iterations;
    run.change = change_between(next_, x) / size;
    if (!(run.change < kDivergence)) {  // NaN too
      run.diverged = true;
      accelerator_.clear();
      return run;
    }
    // Rounding leaves a floor, higher on cut and graded meshes: there the change stops falling.
    iterations_since_least = run.change < 0.5 * least_change ? 0 : iterations_since_least + 1;
    if (iterations_since_least == 0) least_change = run.change;
    const bool at_floor = iterations_since_least >= 4 && least_change <= kRoundingFloor;
    run.converged = linear || run.change <= tolerance || at_floor;
    if (run.iterations == 1) first_change = run.change;
    if (run.iterations == 2 && may_superpose)
      contraction_ratio_ = std::max(0.5 * contraction_ratio_, run.change / first_change);
    // A last pair keeps the secants fresh for the next answer.
    if (!run.converged || run.iterations > 1) accelerator_.add_iterate(x, next_);
    if (!run.converged) accelerator_.extrapolate(next_);
    x.swap(next_);
    if (run.converged) break;
    if (may_superpose)
      accept_first_iterate(first_change, tolerance, run);
    else
      unmeasured_count_ = 0;
    // A guess keeps the rows only as well as the differences that it is made of.
    if (run.change_is_estimated || run.iterations == most) project_onto_constraints(system, x);
    if (run.change_is_estimated) break;
  }
  if (linear) {
    anchor_values_ = values;
    anchored_ = x_is_anchor_ = true;
  }
  return run;
}

double SessionEngine::change_between(const Points& a, const Points& b) const {
  double largest = 0, all = 0;
  for (int c = 0; c < 3; ++c) {
    largest =
        std::max(largest, ((a.col(c) - b.col(c)).cwiseAbs().cwiseProduct(dof_weights_)).maxCoeff());
    all += a.col(c).sum();
  }
  return std::isfinite(all) ? largest : std::numeric_limits<double>::quiet_NaN();
}

void SessionEngine::project_onto_constraints(const SessionSystem& system, Points& x) {
  const auto& free = system.reduction->free_dofs();
  for (int c = 0; c < 3; ++c)
    for (size_t f = 0; f < free.size(); ++f) y_(static_cast<long>(f), c) = x(free[f], c);
  system.coupling->project(y_, g_);
  system.statics->expand(y_, e_, x);
}

bool SessionEngine::update_scan_foot_points(SessionSystem& system, const Points& x) {
  bool moved = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan) continue;
    const ModelProjector projector(system.layout(),
                                   x + system.parts->ones * system.origin().transpose());
    auto& foot_points = system.scan_foot_points[l];
    auto& used = system.scan_used[l];
    const bool first = foot_points.empty();
    foot_points.resize(scan->points.size());
    used.resize(scan->points.size());
    for (size_t i = 0; i < foot_points.size(); ++i) {
      const Vec3& p = scan->points[i];
      const auto closest = projector.nearest(p);
      // On the rim the way to a point beyond it is not at right angles to the surface.
      const SurfaceJet jet = projector.surface(closest.at.region).jet(closest.where);
      const Vec3 across = p - jet.x;
      const char use = closest.inside && (across.norm() <= 1e-9 * system.layout().size() ||
                                          std::abs(across.normalized().dot(jet.normal())) > 0.7);
      moved = moved || first || use != used[i] || closest.at.region != foot_points[i].region ||
              !((closest.at.uv - foot_points[i].uv).norm() < 1e-6);
      foot_points[i] = closest.at;
      used[i] = use;
    }
  }
  if (moved) invalidate_matrix(system);
  return moved;
}

}  // namespace batten::detail
