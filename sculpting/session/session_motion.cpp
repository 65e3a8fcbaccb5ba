
#include "batten/sculpting/session/session_engine.h"

namespace batten::live {

namespace {

// The value of a parameter at the share θ of a step.
double blended(const Motion& m, const std::vector<double>& from, const std::vector<double>& to,
               int parameter) {
  const auto p = static_cast<size_t>(parameter);
  return m.theta * to[p] + (1 - m.theta) * from[p];
}

}  // namespace

bool Engine::prepare_motion(System& system, const Motion& motion) {
  const bool same = system.moving && system.motion.dt == motion.dt &&
                    system.motion.density == motion.density &&
                    system.motion.damping == motion.damping && system.motion.theta == motion.theta;
  if (same && system.moving_coupling && system.moving_rows == system.loose) return false;
  if (!same) {
    const double inertia = system.def.scale().inertia() *
                           (motion.density / (motion.theta * motion.dt) + motion.damping);
    SparseMatrix S =
        inertia * system.parts->mass() + (motion.theta * motion.dt) * system.statics->matrix();
    system.moving = std::make_shared<LiveSystem>(*system.statics, std::move(S));
    system.motion = motion;
  }
  SparseMatrix U = SparseMatrix(system.reduction->D().transpose()) * system.loose->A;
  system.moving_coupling = std::make_shared<Coupling>(system.moving->factor(), std::move(U),
                                                      system.loose->rows, kDependent);
  system.moving_rows = system.loose;
  return true;
}

// Right-hand sides of the loose rows for one step: rates.
void Engine::aim_moving(System& system, const std::vector<double>& from,
                        const std::vector<double>& to, const Shape& shape) {
  const LooseRows& rows = *system.loose;
  if (rows.rows.empty()) return;
  const Motion& m = system.motion;
  const double ahead = (1 - m.theta) * m.dt;
  ae_.noalias() = rows.A.transpose() * e_;
  ax_.noalias() = rows.A.transpose() * shape.x;
  av_.noalias() = rows.A.transpose() * shape.v;
  long soft = 0;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    const auto& source = rows.sources[r];
    const Coupling::Row& row = rows.rows[r];
    const double at = row.of(ax_), lines = row.of(ae_);
    double& g = g_[static_cast<long>(r)];
    if (row.soft) {
      const Vec3 p = ax_.row(row.point).transpose() + system.origin();
      const double value = blended(m, from, to, source.parameter);
      const Pull pulled = pull(system, source, value, p + ahead * av_.row(row.point).transpose());
      wanted_[soft++] = m.theta * m.dt * pulled.stiffness;
      g = row.direction.dot(pulled.target - p) / (m.theta * m.dt) - lines;
      continue;
    }
    const double goal = source.kind == LooseRows::Source::Goal
                            ? to[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    g = (goal - at) / m.dt - lines;
  }
  if (soft > 0) system.moving_coupling->set_stiffness(wanted_);
  if (!system.moving_coupling->implied().empty()) {
    const auto [missed, row] = system.moving_coupling->contradiction(g_);
    if (missed * m.dt > kAgree * system.layout().size()) throw_conflict(system, to, row);
  }
}

void Engine::step(System& system, const std::vector<double>& from, const std::vector<double>& to,
                  Shape& shape) {
  const Motion& m = system.motion;
  anchored_ = false;
  right_values_.clear();  // e_ and ae_ become rates
  const double area = system.def.scale().inertia();
  LiveSystem& moving = *system.moving;

  // Followers act on the shape half way through the step; with θ = 1 on the one at its beginning,
  // so that a step of any length is stable.
  const double ahead = (1 - m.theta) * m.dt;
  // b = F - K x + ρ/(θ dt) M v.
  symmetric_times(system.statics->matrix(), shape.x, product_);
  F_ = -product_;
  if (m.density > 0) {
    symmetric_times(system.parts->mass(), shape.v, product_);
    F_ += (area * m.density / (m.theta * m.dt)) * product_;
  }
  next_ = shape.x + ahead * shape.v;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const double v = blended(m, from, to, system.load_parameter[l]);
    if (v == 0) continue;
    const BuiltLoad& load = *system.loads[l];
    if (load.F.rows() > 0) F_ += v * load.F;
    if (std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind))
      system.parts->pressure().add(next_, load.weights, v * load.scale, F_);
  }
  if (system.scan_load.rows() > 0) F_ += system.scan_load;
  if (system.rest_load.rows() > 0) F_ += system.rest_load;

  // Lines move at the rate that takes them to their places at the end of the step.
  lines_right(system, from, rate_);
  lines_right(system, to, right_);
  system.reduction->check(right_);
  rate_ = (right_ - rate_) / m.dt;
  if (system.reduction->from_right().nonZeros() > 0)
    e_.noalias() = system.reduction->from_right() * rate_;
  moving.start_load(rate_, y_);
  moving.add_load(F_, y_);

  aim_moving(system, from, to, shape);
  moving.solve(y_);
  system.moving_coupling->apply(y_, g_);
  moving.expand(y_, e_, next_);
  shape.x += m.dt * next_;
  shape.v += (next_ - shape.v) / m.theta;
}

void Engine::project(System& system, const std::vector<double>& values, Shape& shape) {
  anchored_ = false;
  right_values_.clear();
  // The right-hand sides are what the shape misses on its rows.
  lines_right(system, values, right_);
  system.reduction->check(right_);
  const auto correct = [&](Points& x, bool velocity) {
    for (size_t r = 0; r < system.line_rows->rows().size(); ++r) {
      const auto& row = system.line_rows->rows()[r];
      Vec3 is = Vec3::Zero();
      for (const auto& e : row.entries) is += e.coefficient * x.row(e.dof).transpose();
      const Vec3 wanted = velocity ? Vec3::Zero() : Vec3(right_.row(static_cast<long>(r)));
      rate_.row(static_cast<long>(r)) = wanted - is;
    }
    if (system.reduction->from_right().nonZeros() > 0)
      e_.noalias() = system.reduction->from_right() * rate_;
    system.statics->start_load(rate_, y_);
    const LooseRows& rows = *system.loose;
    ae_.noalias() = rows.A.transpose() * e_;
    ax_.noalias() = rows.A.transpose() * x;
    for (size_t r = 0; r < rows.rows.size(); ++r) {
      const auto& source = rows.sources[r];
      const Coupling::Row& row = rows.rows[r];
      double goal = 0;
      if (!velocity && source.kind == LooseRows::Source::Goal)
        goal = values[source.parameter] - system.origin()[source.coordinate];
      g_[static_cast<long>(r)] = row.soft ? 0 : goal - row.of(ax_) - row.of(ae_);
    }
    if (!velocity && !system.coupling->implied().empty()) {
      const auto [missed, row] = system.coupling->contradiction(g_);
      if (missed > kAgree * system.layout().size()) throw_conflict(system, values, row);
    }
    system.statics->solve(y_);
    system.coupling->apply(y_, g_);
    system.statics->expand(y_, e_, next_);
    x += next_;
  };
  correct(shape.x, false);
  correct(shape.v, true);
}

}  // namespace batten::live
