// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/dimension_requirements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/errors.h"
#include "batten/scenes/meshes/morph_derivatives.h"

namespace batten {
namespace {

using Kind = DimensionSpec::Kind;
using Relation = RequirementSpec::Relation;

/// A value of this kind that a mesh of this size may have.
double typical_value(Kind kind, double size) {
  switch (kind) {
    case Kind::Angle:
      return 1;
    case Kind::Area:
      return size * size;
    case Kind::Volume:
      return size * size * size;
    case Kind::Mass:
      return 0;
    default:
      return size;
  }
}

/// One requirement with its dimension.
struct Requirement {
  const RequirementSpec* rule;
  const MeshDimension* dimension;
  double size;

  /// Value minus required value, relative to the largest of both and a typical value.
  double excess(const Points& points) const {
    const double value = dimension->value(points);
    return (value - rule->value) /
           std::max({std::abs(rule->value), std::abs(value), typical_value(dimension->kind(), size),
                     std::numeric_limits<double>::min()});
  }
  bool holds(const Points& points) const {
    const double off = excess(points);
    if (rule->relation == Relation::AtMost) return off <= kTolerance;
    if (rule->relation == Relation::AtLeast) return off >= -kTolerance;
    return is_equation_met(points);
  }
  /// For requirements of the active set, which are equations.
  bool is_equation_met(const Points& points) const {
    return std::abs(excess(points)) <= kTolerance;
  }
  static constexpr double kTolerance = 1e-9;
};

std::vector<Requirement> requirements_of(const DeformScene& scene,
                                         const std::vector<MeshDimension>& dimensions,
                                         double size) {
  std::vector<Requirement> all;
  for (const RequirementSpec& rule : scene.requirements) {
    const auto dimension =
        std::find_if(dimensions.begin(), dimensions.end(),
                     [&](const MeshDimension& d) { return d.name() == rule.dimension.text; });
    if (dimension != dimensions.end()) all.push_back({&rule, &*dimension, size});
  }
  return all;
}

Parameter parameter_named(const DeformScene& scene, const std::string& name) {
  for (Parameter& p : scene.parameters())
    if (p.name == name) return p;
  throw InputError("found no parameter '" + name + "'");
}

/// Newton's method for the requirements of the active set.
class RequirementSolver {
 public:
  RequirementSolver(MorphSolver& solver, DeformScene& scene, std::vector<Requirement> active)
      : solver_(solver), scene_(scene), active_(std::move(active)) {
    for (const Requirement& r : active_)
      parameters_.push_back(parameter_named(scene, r.rule->adjust.text));
  }

  void solve(const Progress& progress) {
    constexpr int most_iterations = 30;
    VecX residual = residual_at(VecX::Zero(count()));
    for (int iteration = 0; !all_hold(); ++iteration) {
      progress.update("requirements", static_cast<double>(iteration) / most_iterations);
      if (iteration == most_iterations || !step(residual)) fail();
    }
  }

 private:
  long count() const { return static_cast<long>(active_.size()); }
  bool all_hold() const {
    return std::all_of(active_.begin(), active_.end(),
                       [&](const Requirement& r) { return r.is_equation_met(solver_.shape()); });
  }

  /// The residual after a change of the parameters.
  VecX residual_at(const VecX& change) {
    DeformScene other = scene_;
    for (long p = 0; p < count(); ++p)
      other.set(parameters_[p].name, parameters_[p].value + change[p], "");
    const Points& points = solver_.solve(other);
    VecX residual(count());
    for (long r = 0; r < count(); ++r) residual[r] = active_[r].excess(points);
    return residual;
  }

  MatX jacobian() {
    MatX jacobian(count(), count());
    for (long p = 0; p < count(); ++p) {
      double h = parameter_step(parameters_[p], solver_.mesh().size());
      if (parameters_[p].min == 0) h = std::min(h, parameters_[p].value / 2);
      VecX change = VecX::Zero(count());
      change[p] = h;
      const VecX up = residual_at(change);
      jacobian.col(p) = (up - residual_at(-change)) / (2 * h);
    }
    return jacobian;
  }

  /// One damped Newton step; false if no step reduces the residual.
  bool step(VecX& residual) {
    const MatX slopes = jacobian();
    for (long p = 0; p < count(); ++p)
      if (!(slopes.col(p).cwiseAbs().maxCoeff() * scale_of(parameters_[p]) > 1e-12)) return false;
    const VecX full = -slopes.fullPivLu().solve(residual);
    constexpr int most_halvings = 12;
    double share = 1;
    for (int k = 0; k < most_halvings; ++k, share /= 2) {
      try {
        const VecX next = residual_at(share * full);
        if (!(next.norm() < residual.norm())) continue;
        for (long p = 0; p < count(); ++p) {
          parameters_[p].value += share * full[p];
          scene_.set(parameters_[p].name, parameters_[p].value, "");
        }
        residual = next;
        return true;
      } catch (const CancelledError&) {
        throw;
      } catch (const Error&) {
        continue;  // no solution there, or a value that is not permitted
      }
    }
    return false;
  }

  double scale_of(const Parameter& p) const {
    return 1e3 * parameter_step(p, solver_.mesh().size());
  }

  /// Names the requirement that is farthest from being met.
  [[noreturn]] void fail() {
    VecX residual = residual_at(VecX::Zero(count())).cwiseAbs();
    long worst = 0;
    residual.maxCoeff(&worst);
    const Requirement& r = active_[worst];
    const double value = r.dimension->value(solver_.shape());
    throw NoSolutionError(scene_.at(r.rule->location) + "found no value of '" +
                          parameters_[worst].name + "' for which '" + r.rule->dimension.text +
                          "' " + condition_text(*r.rule) + "; the nearest is " +
                          format_number(value) + " (off by " +
                          format_number(std::abs(value - r.rule->value)) + ") for " +
                          format_number(parameters_[worst].value));
  }

  MorphSolver& solver_;
  DeformScene& scene_;
  std::vector<Requirement> active_;
  std::vector<Parameter> parameters_;  // with their current values
};

}  // namespace

void meet_requirements(MorphSolver& solver, DeformScene& scene,
                       const std::vector<MeshDimension>& dimensions, const Progress& progress) {
  const DeformScene rules = scene;  // Requirement refers to its rules
  std::vector<Requirement> waiting = requirements_of(rules, dimensions, solver.mesh().size()),
                           active;
  std::erase_if(waiting, [](const Requirement& r) { return r.rule->adjust.text.empty(); });
  solver.solve(scene, progress);
  while (true) {
    const auto violated =
        std::stable_partition(waiting.begin(), waiting.end(), [&](const Requirement& r) {
          return r.rule->relation != Relation::Equal && r.holds(solver.shape());
        });
    if (violated == waiting.end()) return;
    active.insert(active.end(), violated, waiting.end());
    waiting.erase(violated, waiting.end());
    RequirementSolver(solver, scene, active).solve(progress);
  }
}

std::vector<FailedCheck> unmet_requirements(const DeformScene& scene,
                                            const std::vector<MeshDimension>& dimensions,
                                            const TriangleMesh& mesh, const Points& points) {
  std::vector<FailedCheck> failed;
  for (const Requirement& r : requirements_of(scene, dimensions, mesh.size()))
    if (!r.holds(points))
      failed.push_back({"dimensions." + r.rule->dimension.text,
                        "is " + format_number(r.dimension->value(points)) + ", required " +
                            condition_text(*r.rule)});
  return failed;
}

std::string condition_text(const RequirementSpec& rule) {
  const char* sign = rule.relation == Relation::Equal    ? "= "
                     : rule.relation == Relation::AtMost ? "<= "
                                                         : ">= ";
  return sign + format_number(rule.value);
}

}  // namespace batten
