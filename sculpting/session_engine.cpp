#include "batten/sculpting/session_engine.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "batten/core/errors.h"
#include "batten/sculpting/change_weights.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::live {
namespace {

// Hard rows of which less is left than this, of their size, beside lines and other rows: they could
// be met by a surface full of waves only.
constexpr double kDependent = 1e-5;
// Over the size: rows that others imply must agree to this.
constexpr double kAgree = 5e-11;
// Over the size: changes below this that do not fall any more are rounding.
constexpr double kFloor = 1e-9;
// Over the size: in one iteration, no shape comes back from there.
constexpr double kRunOff = 1e6;

std::vector<SurfaceStiffness> materials(const Model& model, const std::vector<double>& values) {
  const auto at = [&](int p) { return values[static_cast<size_t>(p)]; };
  SurfaceStiffness base;
  base.alpha = Mat2::Zero();
  base.alpha(0, 0) = at(model.alpha[0]);
  base.alpha(1, 1) = at(model.alpha[2]);
  if (model.alpha[0] != model.alpha[1]) base.alpha(0, 1) = base.alpha(1, 0) = at(model.alpha[1]);
  base.beta = Vec3(at(model.beta[0]), at(model.beta[1]), at(model.beta[2]));
  const auto triangles = static_cast<size_t>(model.parts->mesh->triangle_count());
  std::vector<SurfaceStiffness> all(model.weights.empty() ? 1 : triangles, base);
  for (size_t w = 0; w < model.weights.size(); ++w) {
    const double value = at(model.weight_parameter[w]);
    if (value == 0) continue;
    const BuiltWeight& built = *model.weights[w];
    const bool bends = model.def.weights[w]->weight.kind == WeightField::Kind::Bending;
    for (size_t t = 0; t < triangles; ++t) {
      // Where a line has no say there is no direction.
      if (!built.directions.empty() && built.directions[t].isZero(0)) continue;
      const double weight = value * built.weights[static_cast<long>(t)];
      const double alpha = bends ? 0 : weight, beta = bends ? weight : 0;
      all[t] += built.directions.empty()
                    ? SurfaceStiffness::isotropic(alpha, beta)
                    : SurfaceStiffness::directional(built.directions[t], alpha, beta);
    }
  }
  for (SurfaceStiffness& m : all) {
    if (!m.is_valid())
      throw InputError("alpha must be positive semi-definite and beta not negative, everywhere");
    m = model.def.scale().material(m);
  }
  return model.layout().on_regions(std::move(all));
}

}  // namespace

void symmetric_times(const SparseMatrix& S, const Points& x, Points& out) {
  out.setZero();
  const int* starts = S.outerIndexPtr();
  const int* rows = S.innerIndexPtr();
  const double* values = S.valuePtr();
  for (int c = 0; c < 3; ++c) {
    const double* in = x.col(c).data();
    double* to = out.col(c).data();
    for (int j = 0; j < S.cols(); ++j) {
      double sum = 0;
      for (int k = starts[j]; k < starts[j + 1]; ++k) {
        const int i = rows[k];
        sum += values[k] * in[i];
        if (i != j) to[i] += values[k] * in[j];
      }
      to[j] += sum;
    }
  }
}

void Engine::bind(const Model& model) {
  const int n = model.dofs(), m = model.reduction->free_count();
  const auto points = model.loose->A.cols();
  const auto rows = static_cast<long>(model.loose->rows.size());
  right_.setZero(model.base_right.rows(), 3);
  rate_.setZero(model.base_right.rows(), 3);
  hd_.setZero(m, 3);
  base_.setZero(m, 3);
  y_.setZero(m, 3);
  for (Points* p : {&e_, &next_, &F_, &product_}) p->setZero(n, 3);
  ae_.setZero(points, 3);
  ax_.setZero(points, 3);
  av_.setZero(points, 3);
  g_.setZero(rows);
  long soft = 0;
  for (const auto& row : model.loose->rows) soft += row.soft;
  stiffness_.setConstant(soft, -1);
  wanted_.setZero(soft);
  std::vector<int> sample;
  for (int v = 0; v < model.parts->mesh->vertex_count(); ++v)
    sample.push_back(model.parts->assembler.dofs().vertex(v));
  secants_.resize(n, std::move(sample));
  gain_ = 0;
  felt_ = change_weights(*model.parts->mesh, model.parts->trim.get());
  responses_.clear();
  responses_.resize(model.loads.size());
  known_response_.assign(model.loads.size(), 0);
  anchored_ = false;
  right_values_.clear();
}

void Engine::forget() {
  secants_.clear();
  gain_ = 0;
  stiffness_.setConstant(-1);
  known_response_.assign(known_response_.size(), 0);
  anchored_ = false;
}

bool Engine::prepare_matrix(Model& model, const std::vector<double>& values) {
  bool fits = model.statics && model.matrix_values.size() == values.size();
  for (size_t p = 0; fits && p < values.size(); ++p)
    if (model.roles[p] & kMatrix) fits = values[p] == model.matrix_values[p];
  if (fits && model.coupling && model.coupled_rows == model.loose) return false;
  anchored_ = false;
  right_values_.clear();
  known_response_.assign(known_response_.size(), 0);
  const MeshParts& parts = *model.parts;
  std::shared_ptr<const LooseRows> older_rows;
  std::shared_ptr<Coupling> older;
  if (!fits) {
    const auto all = materials(model, values);
    SparseMatrix K = parts.assembler.pattern();
    if (all.size() == 1)
      parts.assembler.stiffness(all[0], K);
    else
      parts.assembler.stiffness(all, K);
    model.measured_load.resize(0, 3);
    for (size_t l = 0; l < model.loads.size(); ++l) {
      const auto* measured = std::get_if<Load::Springs>(&model.def.loads[l]->load.kind);
      if (!measured || model.measured_feet[l].empty()) continue;
      if (model.measured_load.rows() == 0) model.measured_load = Points::Zero(model.dofs(), 3);
      const double value = values[static_cast<size_t>(model.load_parameter[l])];
      if (!(value >= 0))
        throw InputError("load '" + model.def.loads[l]->load.name + "' has springs of stiffness " +
                         number(value) + ": it must not be below 0");
      const double k = value / static_cast<double>(measured->points.size());
      for (size_t i = 0; i < measured->points.size(); ++i) {
        if (!model.measured_used[l][i]) continue;
        const Location where = parts.at(model.measured_feet[l][i]);
        const Vec12 N =
            C1Triangle(parts.kind, parts.mesh->shape(where.triangle)).evaluate(where.L).col(kW);
        const auto dof = parts.assembler.dofs().triangle(*parts.mesh, where.triangle);
        for (int a = 0; a < 12; ++a) {
          model.measured_load.row(dof[a]) +=
              k * N[a] * (measured->points[i] - model.origin()).transpose();
          for (int b = 0; b < 12; ++b)
            if (dof[a] >= dof[b]) K.coeffRef(dof[a], dof[b]) += k * N[a] * N[b];
        }
      }
    }
    if (model.measured_load.rows() > 0)
      model.measured_reduced = model.reduction->D().transpose() * model.measured_load;
    // A factor that the history keeps must stay; one of our own takes other numbers in place.
    if (model.statics && model.statics.use_count() == 1)
      model.statics->set_matrix(std::move(K));
    else
      model.statics = model.statics ? std::make_shared<LiveSystem>(*model.statics, std::move(K))
                                    : std::make_shared<LiveSystem>(model.reduction, std::move(K),
                                                                   parts.vertices, model.def.expected);
    model.matrix_values = values;
    model.moving.reset();
    model.moving_coupling.reset();
  } else {
    older = model.coupling;
    older_rows = model.coupled_rows;
  }
  // The solves of things that stand already are kept.
  const LooseRows& rows = *model.loose;
  std::vector<int> known(static_cast<size_t>(rows.A.cols()), -1);
  if (older)
    for (const auto& block : rows.blocks)
      for (const auto& other : older_rows->blocks)
        if (other.owner == block.owner &&
            other.end_point - other.first_point == block.end_point - block.first_point)
          for (int k = block.first_point; k < block.end_point; ++k)
            known[static_cast<size_t>(k)] = other.first_point + k - block.first_point;
  SparseMatrix U = SparseMatrix(model.reduction->D().transpose()) * rows.A;
  model.coupling = older ? std::make_shared<Coupling>(model.statics->factor(), std::move(U),
                                                      rows.rows, *older, known, kDependent)
                         : std::make_shared<Coupling>(model.statics->factor(), std::move(U),
                                                      rows.rows, kDependent);
  model.coupled_rows = model.loose;
  model.moving_coupling.reset();
  stiffness_.setConstant(-1);
  return !fits;
}

// -- right-hand sides -----------------------------------------------------------------------------

void Engine::lines_right(const Model& model, const std::vector<double>& values, MatX& right) const {
  right = model.base_right;
  for (size_t i = 0; i < model.move_right.size(); ++i)
    if (const double v = values[static_cast<size_t>(model.move_parameter[i])]; v != 0)
      right += v * *model.move_right[i];
}

void Engine::loose_right(const Model& model, const std::vector<double>& values) {
  const LooseRows& rows = *model.loose;
  if (rows.rows.empty()) return;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    const auto& source = rows.sources[r];
    const Coupling::Row& row = rows.rows[r];
    if (row.soft) continue;
    const double goal =
        source.kind == LooseRows::Source::Goal
            ? values[static_cast<size_t>(source.parameter)] - model.origin()[source.coordinate]
            : 0;
    g_[static_cast<long>(r)] = goal - row.of(ae_);
  }
  if (model.coupling->implied().empty()) return;
  const auto [missed, row] = model.coupling->contradiction(g_);
  if (missed > kAgree * model.layout().size()) throw_conflict(model, values, row);
}

// All rows at once, lines and loose ones, with their names.
ConstraintSet Engine::all_rows(const Model& model, const std::vector<double>& values) const {
  ConstraintSet all(model.dofs());
  MatX right;
  lines_right(model, values, right);
  const auto& names = model.line_rows->names();
  const auto& lines = model.line_rows->rows();
  for (size_t r = 0; r < lines.size(); ++r)
    all.add(names[static_cast<size_t>(lines[r].name)], lines[r].entries,
            right.row(static_cast<long>(r)));
  const LooseRows& loose = *model.loose;
  for (size_t r = 0; r < loose.rows.size(); ++r) {
    if (loose.rows[r].soft) continue;
    std::vector<ConstraintSet::CoupledEntry> entries;
    loose.rows[r].terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(loose.A, point); it; ++it)
        entries.push_back({static_cast<int>(it.row()), it.value() * n});
    });
    const auto& source = loose.sources[r];
    const double goal =
        source.kind == LooseRows::Source::Goal
            ? values[static_cast<size_t>(source.parameter)] - model.origin()[source.coordinate]
            : 0;
    all.add_coupled(loose.name_of(static_cast<int>(r)), std::move(entries), goal);
  }
  return all;
}

void Engine::throw_conflict(const Model& model, const std::vector<double>& values, int row) const {
  // The elimination knows which rows make up another; it is asked only now.
  const ConstraintSet all = all_rows(model, values);
  const LooseRows& loose = *model.loose;
  const AffineReduction check(all, AffineReduction::Values::Given, kDependent);
  throw ConflictError({{{loose.name_of(row), "the lines or constraints beside it"},
                        model.coupling->contradiction(g_).first}});
}

void Engine::prepare_right(Model& model, const std::vector<double>& values) {
  // Of the lines: only when they moved.
  bool stands = right_values_.size() == values.size() && right_matrix_ == model.statics.get();
  for (size_t p = 0; stands && p < values.size(); ++p)
    stands = (model.roles[p] & kRight) == 0 || values[p] == right_values_[p];
  if (!stands) {
    right_values_.clear();
    lines_right(model, values, right_);
    model.reduction->check(right_);
    if (model.reduction->from_right().nonZeros() > 0)
      e_.noalias() = model.reduction->from_right() * right_;
    model.statics->start_load(right_, hd_);
    ae_.noalias() = model.loose->A.transpose() * e_;
    right_values_ = values;
    right_matrix_ = model.statics.get();
  }
  loose_right(model, values);
  base_ = hd_;
  add_linear(model, values, base_);
}

void Engine::add_linear(const Model& model, const std::vector<double>& values, MatX& to) const {
  for (size_t l = 0; l < model.loads.size(); ++l)
    if (const double v = values[static_cast<size_t>(model.load_parameter[l])];
        v != 0 && model.loads[l]->reduced.rows() > 0)
      to += v * model.loads[l]->reduced;
  if (model.measured_load.rows() > 0) to += model.measured_reduced;
}

namespace {

// The point of a spring's target that is nearest to p.
Vec3 nearest_of(const Load::Pulls& springs, int spring, const Vec3& p) {
  if (const auto* places = std::get_if<Load::Pulls::Places>(&springs.target))
    return places->to[static_cast<size_t>(spring)];
  if (const auto* curve = std::get_if<Load::Pulls::Curve>(&springs.target))
    return curve->curve.evaluate(curve->curve.closest_point(p).u);
  const auto& plane = std::get<Load::Pulls::Plane>(springs.target);
  const Vec3 n = plane.normal.normalized();
  return p - n.dot(p - plane.through) * n;
}

}  // namespace

Engine::Pull Engine::pull(const Model& model, const LooseRows::Source& source, double value,
                          const Vec3& p) const {
  const auto& placed = *model.def.loads[static_cast<size_t>(source.load)];
  const auto& springs = std::get<Load::Pulls>(placed.load.kind);
  Vec3 target = nearest_of(springs, source.spring, p);
  const double distance = (p - target).norm();
  double stiffness = value;
  if (springs.falloff > 0) stiffness *= std::exp(-std::pow(distance / springs.falloff, 2));
  if (springs.rest_length > 0 && distance > 0)
    target += springs.rest_length / distance * (p - target);
  return {stiffness, target};
}

void Engine::aim_springs(Model& model, const std::vector<double>& values, const Points& x) {
  const LooseRows& rows = *model.loose;
  const auto& soft = model.coupling->soft();
  if (soft.empty()) return;
  ax_.noalias() = rows.A.transpose() * x;
  for (size_t k = 0; k < soft.size(); ++k) {
    const auto r = static_cast<size_t>(soft[k]);
    const Coupling::Row& row = rows.rows[r];
    const double value = values[static_cast<size_t>(rows.sources[r].parameter)];
    if (!(value >= 0))
      throw InputError("springs '" + rows.name_of(soft[k]) + "' have the stiffness " +
                       number(value) + ": it must not be below 0");
    const Vec3 p = ax_.row(row.point).transpose() + model.origin();
    const Pull to = pull(model, rows.sources[r], value, p);
    wanted_[static_cast<long>(k)] = to.stiffness;
    g_[static_cast<long>(r)] =
        row.direction.dot(to.target - model.origin() - Vec3(ae_.row(row.point)));
  }
  if (wanted_ != stiffness_) {
    model.coupling->set_stiffness(wanted_);
    stiffness_ = wanted_;
    // Responses to loads were those of softer or stiffer springs.
    known_response_.assign(known_response_.size(), 0);
  }
}

// -- static answers -------------------------------------------------------------------------------

bool Engine::is_linear(const Model& model, const std::vector<double>& values) const {
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const auto p = static_cast<size_t>(model.load_parameter[l]);
    const bool follows = std::holds_alternative<Load::Pressure>(model.def.loads[l]->load.kind) ||
                         (model.roles[p] & kSpring && model.roles[p] & kPressure);
    if (follows && values[p] != 0) return false;
  }
  return true;
}

void Engine::map(Model& model, const std::vector<double>& values, const Points& x, Points& to) {
  y_ = base_;
  bool pressed = false;
  for (size_t l = 0; l < model.loads.size(); ++l) {
    if (!std::holds_alternative<Load::Pressure>(model.def.loads[l]->load.kind)) continue;
    const double v = values[static_cast<size_t>(model.load_parameter[l])];
    if (v == 0) continue;
    if (!pressed) F_.setZero();
    pressed = true;
    model.parts->pressure().add(x, model.loads[l]->weights, v * model.loads[l]->scale, F_);
  }
  if (pressed) model.statics->add_load(F_, y_);
  aim_springs(model, values, x);
  model.statics->solve(y_);
  model.coupling->apply(y_, g_);
  model.statics->expand(y_, e_, to);
}

Engine::Run Engine::answer(Model& model, const std::vector<double>& values, Points& x, int most,
                           double tolerance, bool may_superpose) {
  const double size = model.layout().size();
  Run run;
  const bool linear = is_linear(model, values);
  if (linear && may_superpose && anchored_) {
    bool only_loads = true;
    for (size_t p = 0; only_loads && p < values.size(); ++p)
      only_loads = values[p] == anchor_values_[p] || (model.roles[p] & ~unsigned(kLinear)) == 0;
    if (only_loads) {
      if (x_is_anchor_) anchor_ = x;
      x_is_anchor_ = false;
      next_ = anchor_;
      for (size_t l = 0; l < model.loads.size(); ++l) {
        const auto p = static_cast<size_t>(model.load_parameter[l]);
        if (model.loads[l]->reduced.rows() == 0 || values[p] == anchor_values_[p]) continue;
        if (!known_response_[l]) {
          // The answer to the load alone: rows at zero, springs as stiff as they are.
          y_ = model.loads[l]->reduced;
          model.statics->solve(y_);
          g_.setZero();
          model.coupling->apply(y_, g_);
          responses_[l].resize(x.rows(), 3);
          responses_[l].noalias() = model.reduction->D() * y_;
          known_response_[l] = 1;
          ++run.iterations;
        }
        next_ += (values[p] - anchor_values_[p]) * responses_[l];
      }
      run.change = change_between(next_, x) / size;
      x.swap(next_);
      run.converged = run.superposed = true;
      return run;
    }
  }
  anchored_ = false;
  prepare_right(model, values);
  secants_.begin();
  double fallen = std::numeric_limits<double>::infinity();
  int since_least = 0;
  double first_change = 0;
  while (run.iterations < most) {
    map(model, values, x, next_);
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
    // In a drag, the last answers tell how much the first guess brings: one iteration less, looked
    // at again every few answers.
    constexpr double careful = 5;
    constexpr int most_unseen = 3;
    const double expected = careful * gain_ * first_change;
    run.expected = may_superpose && run.iterations == 1 && gain_ > 0 && unseen_ < most_unseen &&
                   expected <= tolerance;
    unseen_ = run.expected ? unseen_ + 1 : 0;
    if (run.expected) {
      run.change = expected;
      run.converged = true;
    }
    // A guess keeps the rows only as well as the differences that it is made of.
    if (run.expected || run.iterations == most) put_on_rows(model, x);
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

void Engine::put_on_rows(const Model& model, Points& x) {
  const auto& free = model.reduction->free_dofs();
  for (int c = 0; c < 3; ++c)
    for (size_t f = 0; f < free.size(); ++f) y_(static_cast<long>(f), c) = x(free[f], c);
  model.coupling->project(y_, g_);
  model.statics->expand(y_, e_, x);
}

bool Engine::follow_measured(Model& model, const Points& x) {
  bool moved = false;
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const auto* measured = std::get_if<Load::Springs>(&model.def.loads[l]->load.kind);
    if (!measured) continue;
    const ModelProjector projector(model.layout(),
                                   x + model.parts->ones * model.origin().transpose());
    auto& feet = model.measured_feet[l];
    auto& used = model.measured_used[l];
    const bool first = feet.empty();
    feet.resize(measured->points.size());
    used.resize(measured->points.size());
    for (size_t i = 0; i < feet.size(); ++i) {
      const Vec3& p = measured->points[i];
      const auto closest = projector.nearest(p);
      // On the rim the way to a point beyond it is not at right angles to the surface.
      const SurfaceJet jet = projector.surface(closest.at.region).jet(closest.where);
      const Vec3 across = p - jet.x;
      const char use = closest.inside && (across.norm() <= 1e-9 * model.layout().size() ||
                                          std::abs(across.normalized().dot(jet.normal())) > 0.7);
      moved = moved || first || use != used[i] || closest.at.region != feet[i].region ||
              !((closest.at.uv - feet[i].uv).norm() < 1e-6);
      feet[i] = closest.at;
      used[i] = use;
    }
  }
  if (moved) outdate(model);
  return moved;
}

// -- motion ---------------------------------------------------------------------------------------

bool Engine::prepare_motion(Model& model, const Motion& motion) {
  const bool same = model.moving && model.motion.dt == motion.dt &&
                    model.motion.density == motion.density &&
                    model.motion.damping == motion.damping && model.motion.theta == motion.theta;
  if (same && model.moving_coupling && model.moving_rows == model.loose) return false;
  if (!same) {
    const double inertia = model.def.scale().inertia() *
                           (motion.density / (motion.theta * motion.dt) + motion.damping);
    SparseMatrix S =
        inertia * model.parts->mass() + (motion.theta * motion.dt) * model.statics->matrix();
    model.moving = std::make_shared<LiveSystem>(*model.statics, std::move(S));
    model.motion = motion;
  }
  SparseMatrix U = SparseMatrix(model.reduction->D().transpose()) * model.loose->A;
  model.moving_coupling = std::make_shared<Coupling>(model.moving->factor(), std::move(U),
                                                     model.loose->rows, kDependent);
  model.moving_rows = model.loose;
  return true;
}

void Engine::step(Model& model, const std::vector<double>& from, const std::vector<double>& to,
                  Shape& shape) {
  const Motion& m = model.motion;
  anchored_ = false;
  right_values_.clear();  // e_ and ae_ become rates
  const double s = model.layout().size();
  const double area = model.def.scale().inertia();
  LiveSystem& system = *model.moving;
  const auto blended = [&](size_t p) { return m.theta * to[p] + (1 - m.theta) * from[p]; };

  // Followers act on the shape half way through the step; with θ = 1 on the one at its beginning,
  // so that a step of any length is stable.
  const double ahead = (1 - m.theta) * m.dt;
  // b = F - K x + ρ/(θ dt) M v.
  symmetric_times(model.statics->matrix(), shape.x, product_);
  F_ = -product_;
  if (m.density > 0) {
    symmetric_times(model.parts->mass(), shape.v, product_);
    F_ += (area * m.density / (m.theta * m.dt)) * product_;
  }
  next_ = shape.x + ahead * shape.v;
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const double v = blended(static_cast<size_t>(model.load_parameter[l]));
    if (v == 0) continue;
    const BuiltLoad& load = *model.loads[l];
    if (load.F.rows() > 0) F_ += v * load.F;
    if (std::holds_alternative<Load::Pressure>(model.def.loads[l]->load.kind))
      model.parts->pressure().add(next_, load.weights, v * load.scale, F_);
  }
  if (model.measured_load.rows() > 0) F_ += model.measured_load;

  // Lines move at the rate that takes them to their places at the end of the step.
  lines_right(model, from, rate_);
  lines_right(model, to, right_);
  model.reduction->check(right_);
  rate_ = (right_ - rate_) / m.dt;
  if (model.reduction->from_right().nonZeros() > 0)
    e_.noalias() = model.reduction->from_right() * rate_;
  system.start_load(rate_, y_);
  system.add_load(F_, y_);

  const LooseRows& rows = *model.loose;
  if (!rows.rows.empty()) {
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
        const Vec3 p = ax_.row(row.point).transpose() + model.origin();
        const double value = blended(static_cast<size_t>(source.parameter));
        const Pull pulled = pull(model, source, value, p + ahead * av_.row(row.point).transpose());
        wanted_[soft++] = m.theta * m.dt * pulled.stiffness;
        g = row.direction.dot(pulled.target - p) / (m.theta * m.dt) - lines;
        continue;
      }
      const double goal =
          source.kind == LooseRows::Source::Goal
              ? to[static_cast<size_t>(source.parameter)] - model.origin()[source.coordinate]
              : 0;
      g = (goal - at) / m.dt - lines;
    }
    if (soft > 0) model.moving_coupling->set_stiffness(wanted_);
    if (!model.moving_coupling->implied().empty()) {
      const auto [missed, row] = model.moving_coupling->contradiction(g_);
      if (missed * m.dt > kAgree * s) throw_conflict(model, to, row);
    }
  }
  system.solve(y_);
  model.moving_coupling->apply(y_, g_);
  system.expand(y_, e_, next_);
  shape.x += m.dt * next_;
  shape.v += (next_ - shape.v) / m.theta;
}

void Engine::project(Model& model, const std::vector<double>& values, Shape& shape) {
  anchored_ = false;
  right_values_.clear();
  // x: the rows' residuals are what is missing.
  lines_right(model, values, right_);
  model.reduction->check(right_);
  const auto correct = [&](Points& x, bool velocity) {
    for (size_t r = 0; r < model.line_rows->rows().size(); ++r) {
      const auto& row = model.line_rows->rows()[r];
      Vec3 is = Vec3::Zero();
      for (const auto& e : row.entries) is += e.coefficient * x.row(e.dof).transpose();
      const Vec3 wanted = velocity ? Vec3::Zero() : Vec3(right_.row(static_cast<long>(r)));
      rate_.row(static_cast<long>(r)) = wanted - is;
    }
    if (model.reduction->from_right().nonZeros() > 0)
      e_.noalias() = model.reduction->from_right() * rate_;
    model.statics->start_load(rate_, y_);
    const LooseRows& rows = *model.loose;
    ae_.noalias() = rows.A.transpose() * e_;
    ax_.noalias() = rows.A.transpose() * x;
    for (size_t r = 0; r < rows.rows.size(); ++r) {
      const auto& source = rows.sources[r];
      const Coupling::Row& row = rows.rows[r];
      double goal = 0;
      if (!velocity && source.kind == LooseRows::Source::Goal)
        goal = values[static_cast<size_t>(source.parameter)] - model.origin()[source.coordinate];
      g_[static_cast<long>(r)] = row.soft ? 0 : goal - row.of(ax_) - row.of(ae_);
    }
    if (!velocity && !model.coupling->implied().empty()) {
      const auto [missed, row] = model.coupling->contradiction(g_);
      if (missed > kAgree * model.layout().size()) throw_conflict(model, values, row);
    }
    model.statics->solve(y_);
    model.coupling->apply(y_, g_);
    model.statics->expand(y_, e_, next_);
    x += next_;
  };
  correct(shape.x, false);
  correct(shape.v, true);
}

// -- what there is to know ------------------------------------------------------------------------

double Engine::residual(const Model& model, const std::vector<double>& values, const Points& x) {
  lines_right(model, values, rate_);
  double largest = 0;
  const auto note = [&](double missed) {
    if (!(missed <= largest) && !std::isnan(largest)) largest = missed;
  };
  const auto& lines = model.line_rows->rows();
  for (size_t r = 0; r < lines.size(); ++r) {
    Vec3 is = Vec3::Zero();
    for (const auto& e : lines[r].entries) is += e.coefficient * x.row(e.dof).transpose();
    note((is - rate_.row(static_cast<long>(r)).transpose()).cwiseAbs().maxCoeff());
  }
  const LooseRows& rows = *model.loose;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (rows.rows[r].soft) continue;
    double is = 0;
    rows.rows[r].terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(rows.A, point); it; ++it)
        is += it.value() * n.dot(Vec3(x.row(it.row())));
    });
    const auto& source = rows.sources[r];
    const double goal =
        source.kind == LooseRows::Source::Goal
            ? values[static_cast<size_t>(source.parameter)] - model.origin()[source.coordinate]
            : 0;
    note(std::abs(is - goal));
  }
  return largest;
}

SurfaceEnergy Engine::elastic_energy(const Model& model, const std::vector<double>& values,
                                     const Points& x) {
  const auto part = [&](bool bends) {
    auto all = materials(model, values);
    all.resize(static_cast<size_t>(model.parts->mesh->triangle_count()), all[0]);
    for (SurfaceStiffness& m : all) {
      if (bends)
        m.alpha.setZero();
      else
        m.beta = m.beta_mixed = Vec3::Zero();
    }
    SparseMatrix K = model.parts->assembler.pattern();
    model.parts->assembler.stiffness(all, K);
    symmetric_times(K, x, product_);
    return x.cwiseProduct(product_).sum();
  };
  return {part(false), part(true)};
}

std::vector<Reaction> Engine::reactions(const Model& model, const std::vector<double>& values,
                                        const Points& x) {
  symmetric_times(model.statics->matrix(), x, product_);
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const double v = values[static_cast<size_t>(model.load_parameter[l])];
    if (v == 0) continue;
    if (model.loads[l]->F.rows() > 0) product_ -= v * model.loads[l]->F;
    if (std::holds_alternative<Load::Pressure>(model.def.loads[l]->load.kind))
      model.parts->pressure().add(x, model.loads[l]->weights, -v * model.loads[l]->scale, product_);
  }
  if (model.measured_load.rows() > 0) product_ -= model.measured_load;
  const LooseRows& rows = *model.loose;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (!rows.rows[r].soft) continue;
    Vec3 p = model.origin();
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      p += it.value() * x.row(it.row()).transpose();
    const double value = values[static_cast<size_t>(rows.sources[r].parameter)];
    const Pull to = pull(model, rows.sources[r], value, p);
    const Vec3& n = rows.rows[r].direction;
    const Vec3 force = to.stiffness * n.dot(p - to.target) * n;
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      product_.row(it.row()) += it.value() * force.transpose();
  }
  std::vector<Reaction> all;
  for (const auto& named : named_reactions(all_rows(model, values), product_))
    all.push_back({named.name, named.forces.transpose() * model.parts->ones});
  return all;
}

std::vector<SpringDistances> Engine::spring_distances(const Model& model, const Points& before,
                                                      const Points& now) const {
  std::vector<SpringDistances> all;
  std::optional<ModelProjector> on_before, on_now;
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const auto* springs = std::get_if<Load::Springs>(&model.def.loads[l]->load.kind);
    if (!springs) continue;
    if (!on_now) {
      on_before.emplace(model.layout(), before);
      on_now.emplace(model.layout(), now);
    }
    SpringDistances s;
    s.name = model.def.loads[l]->load.name;
    s.points = static_cast<int>(springs->points.size());
    for (size_t i = 0; i < springs->points.size(); ++i) {
      if (i >= model.measured_used[l].size() || !model.measured_used[l][i]) {
        ++s.left_out;
        continue;
      }
      const double was = on_before->nearest(springs->points[i]).distance,
                   is = on_now->nearest(springs->points[i]).distance;
      s.before_max = std::max(s.before_max, was);
      s.max = std::max(s.max, is);
      s.before_rms += was * was;
      s.rms += is * is;
    }
    const double used = std::max(1, s.points - s.left_out);
    s.before_rms = std::sqrt(s.before_rms / used);
    s.rms = std::sqrt(s.rms / used);
    all.push_back(s);
  }
  return all;
}

// 2 ∫ φ(ρ) (ρ - r₀) dρ from r₀ to r: what a spring of stiffness 1 stores.
double Engine::stretch_energy(const Model& model, const LooseRows::Source& source,
                              const Vec3& p) const {
  const auto& springs =
      std::get<Load::Pulls>(model.def.loads[static_cast<size_t>(source.load)]->load.kind);
  const double r = (p - nearest_of(springs, source.spring, p)).norm(), rest = springs.rest_length,
               falloff = springs.falloff;
  if (falloff == 0) return (r - rest) * (r - rest);
  const auto phi = [&](double at) { return std::exp(-(at / falloff) * (at / falloff)); };
  return falloff * falloff * (phi(rest) - phi(r)) -
         rest * falloff * std::sqrt(std::numbers::pi) *
             (std::erf(r / falloff) - std::erf(rest / falloff));
}

double Engine::total_energy(const Model& model, const std::vector<double>& values,
                            const Shape& shape, bool moving) {
  symmetric_times(model.statics->matrix(), shape.x, product_);
  for (size_t l = 0; l < model.loads.size(); ++l) {
    const double v = values[static_cast<size_t>(model.load_parameter[l])];
    if (model.loads[l]->F.rows() > 0 && v != 0) product_ -= 2 * v * model.loads[l]->F;
    // Along a fixed rim, ⅔ of the work that the pressure would do on the shape as it is.
    if (std::holds_alternative<Load::Pressure>(model.def.loads[l]->load.kind) && v != 0) {
      F_.setZero();
      model.parts->pressure().add(shape.x, model.loads[l]->weights, v * model.loads[l]->scale, F_);
      product_ -= (2.0 / 3) * F_;
    }
  }
  if (model.measured_load.rows() > 0) product_ -= 2 * model.measured_load;
  double energy = shape.x.cwiseProduct(product_).sum();
  const LooseRows& rows = *model.loose;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (!rows.rows[r].soft) continue;
    Vec3 p = model.origin();
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      p += it.value() * shape.x.row(it.row()).transpose();
    const double value = values[static_cast<size_t>(rows.sources[r].parameter)];
    // One potential a spring, not a row.
    if (rows.sources[r].coordinate <= 0)
      energy += value * stretch_energy(model, rows.sources[r], p);
  }
  if (moving && model.motion.density > 0) {
    symmetric_times(model.parts->mass(), shape.v, product_);
    energy +=
        model.def.scale().inertia() * model.motion.density * shape.v.cwiseProduct(product_).sum();
  }
  return energy;
}

}  // namespace batten::live
