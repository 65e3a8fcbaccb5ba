#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::live {

namespace {

// Changes below this share of the size that do not fall any more are rounding.
constexpr double kFloor = 1e-9;
// After a change above this times the size in one iteration no shape comes back.
constexpr double kRunOff = 1e6;

}  // namespace

bool Engine::is_linear(const System& system, const std::vector<double>& values) const {
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    const bool follows = std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind) ||
                         (system.roles[p] & kSpring && system.roles[p] & kPressure);
    if (follows && values[p] != 0) return false;
  }
  return true;
}

void Engine::map(System& system, const std::vector<double>& values, const Points& x, Points& to) {
  y_ = base_;
  bool pressed = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    if (!std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind)) continue;
    const double v = values[system.load_parameter[l]];
    if (v == 0) continue;
    if (!pressed) F_.setZero();
    pressed = true;
    system.parts->pressure().add(x, system.loads[l]->weights, v * system.loads[l]->scale, F_);
  }
  if (pressed) system.statics->add_load(F_, y_);
  aim_springs(system, values, x);
  system.statics->solve(y_);
  system.coupling->apply(y_, g_);
  system.statics->expand(y_, e_, to);
}

// Where only linear loads moved since the anchor, the answer is its shape and a response to each
// load.
bool Engine::superpose(System& system, const std::vector<double>& values, Points& x, Run& run) {
  for (size_t p = 0; p < values.size(); ++p)
    if (values[p] != anchor_values_[p] && (system.roles[p] & ~unsigned(kLinear)) != 0) return false;
  if (x_is_anchor_) anchor_ = x;
  x_is_anchor_ = false;
  next_ = anchor_;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    if (system.loads[l]->reduced.rows() == 0 || values[p] == anchor_values_[p]) continue;
    if (!known_response_[l]) {
      // The answer to the load alone: rows at zero, springs as stiff as they are.
      y_ = system.loads[l]->reduced;
      system.statics->solve(y_);
      g_.setZero();
      system.coupling->apply(y_, g_);
      responses_[l].resize(x.rows(), 3);
      responses_[l].noalias() = system.reduction->D() * y_;
      known_response_[l] = 1;
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
bool Engine::trusts_guess(double first_change, double tolerance, Run& run) {
  constexpr double careful = 5;
  constexpr int most_unseen = 3;
  const double expected = careful * gain_ * first_change;
  run.expected = run.iterations == 1 && gain_ > 0 && unseen_ < most_unseen && expected <= tolerance;
  unseen_ = run.expected ? unseen_ + 1 : 0;
  if (run.expected) {
    run.change = expected;
    run.converged = true;
  }
  return run.expected;
}

Engine::Run Engine::answer(System& system, const std::vector<double>& values, Points& x, int most,
                           double tolerance, bool may_superpose) {
  const double size = system.layout().size();
  Run run;
  const bool linear = is_linear(system, values);
  if (linear && may_superpose && anchored_ && superpose(system, values, x, run)) return run;
  anchored_ = false;
  prepare_right(system, values);
  secants_.begin();
  double fallen = std::numeric_limits<double>::infinity();
  int since_least = 0;
  double first_change = 0;
  while (run.iterations < most) {
    map(system, values, x, next_);
    ++run.iterations;
    run.change = change_between(next_, x) / size;
    if (!(run.change < kRunOff)) {  // NaN too
      run.ran_off = true;
      secants_.clear();
      return run;
    }
    // Rounding leaves a floor, higher on cut and graded meshes: there the change stops falling.
    since_least = run.change < 0.5 * fallen ? 0 : since_least + 1;
    if (since_least == 0) fallen = run.change;
    const bool at_floor = since_least >= 4 && fallen <= kFloor;
    run.converged = linear || run.change <= tolerance || at_floor;
    if (run.iterations == 1) first_change = run.change;
    if (run.iterations == 2 && may_superpose)
      gain_ = std::max(0.5 * gain_, run.change / first_change);
    // A last pair keeps the secants fresh for the next answer.
    if (!run.converged || run.iterations > 1) secants_.learn(x, next_);
    if (!run.converged) secants_.guess(next_);
    x.swap(next_);
    if (run.converged) break;
    if (may_superpose)
      trusts_guess(first_change, tolerance, run);
    else
      unseen_ = 0;
    // A guess keeps the rows only as well as the differences that it is made of.
    if (run.expected || run.iterations == most) put_on_rows(system, x);
    if (run.expected) break;
  }
  if (linear) {
    anchor_values_ = values;
    anchored_ = x_is_anchor_ = true;
  }
  return run;
}

double Engine::change_between(const Points& a, const Points& b) const {
  double largest = 0, all = 0;
  for (int c = 0; c < 3; ++c) {
    largest = std::max(largest, ((a.col(c) - b.col(c)).cwiseAbs().cwiseProduct(felt_)).maxCoeff());
    all += a.col(c).sum();
  }
  return std::isfinite(all) ? largest : std::numeric_limits<double>::quiet_NaN();
}

void Engine::put_on_rows(const System& system, Points& x) {
  const auto& free = system.reduction->free_dofs();
  for (int c = 0; c < 3; ++c)
    for (size_t f = 0; f < free.size(); ++f) y_(static_cast<long>(f), c) = x(free[f], c);
  system.coupling->project(y_, g_);
  system.statics->expand(y_, e_, x);
}

bool Engine::follow_scans(System& system, const Points& x) {
  bool moved = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::Scan>(&system.def.loads[l]->load.kind);
    if (!scan) continue;
    const ModelProjector projector(system.layout(),
                                   x + system.parts->ones * system.origin().transpose());
    auto& feet = system.scan_feet[l];
    auto& used = system.scan_used[l];
    const bool first = feet.empty();
    feet.resize(scan->points.size());
    used.resize(scan->points.size());
    for (size_t i = 0; i < feet.size(); ++i) {
      const Vec3& p = scan->points[i];
      const auto closest = projector.nearest(p);
      // On the rim the way to a point beyond it is not at right angles to the surface.
      const SurfaceJet jet = projector.surface(closest.at.region).jet(closest.where);
      const Vec3 across = p - jet.x;
      const char use = closest.inside && (across.norm() <= 1e-9 * system.layout().size() ||
                                          std::abs(across.normalized().dot(jet.normal())) > 0.7);
      moved = moved || first || use != used[i] || closest.at.region != feet[i].region ||
              !((closest.at.uv - feet[i].uv).norm() < 1e-6);
      feet[i] = closest.at;
      used[i] = use;
    }
  }
  if (moved) outdate(system);
  return moved;
}

}  // namespace batten::live
