// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_derivatives.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

/// The formulas for one parameter, from solutions at six other values of it.
class ParameterDifferences {
 public:
  ParameterDifferences(MorphSolver& solver, const DeformScene& scene, const Parameter& parameter,
                       const std::vector<MeshDimension>& dimensions, const Points& here)
      : solver_(solver),
        scene_(scene),
        parameter_(parameter),
        dimensions_(dimensions),
        here_(here),
        size_(solver.mesh().size()) {}

  MorphDerivative derivative() {
    MorphDerivative best = at_step(suitable_step());
    constexpr double good = 1e-8, reduction = 2;
    constexpr int attempts = 2;
    for (int k = 0; k < attempts && best.error > good; ++k) {
      step_ /= reduction;
      MorphDerivative next = at_step(step_);
      if (next.error < best.error) best = std::move(next);
    }
    return best;
  }

 private:
  Points shape(double change) {
    DeformScene other = scene_;
    other.set(parameter_.name, parameter_.value + change, "");
    return solver_.solve(other);
  }

  /// The step that displaces a vertex by about 0.1 % of the size of the mesh.
  double suitable_step() {
    constexpr double target = 1e-3, no_effect = 1e-13, most_growth = 1e3, of_scale = 0.05;
    const double first = parameter_step(parameter_, size_);
    const double effect = (shape(first) - here_).cwiseAbs().maxCoeff() / size_;
    step_ = effect > no_effect ? first * std::min(target / effect, most_growth) : first;
    if (parameter_.min == 0) step_ = std::min(step_, of_scale * parameter_.value);
    return step_;
  }

  MorphDerivative at_step(double h) {
    std::array<Points, 3> rise;  // f(kh) - f(-kh) for k = 1, 2, 4
    std::array<VecX, 3> dimension_rise;
    for (size_t k = 0; k < 3; ++k) {
      const double step = std::ldexp(h, static_cast<int>(k));
      rise[k] = shape(step);
      dimension_rise[k] = values(rise[k]);
      const Points below = shape(-step);
      rise[k] -= below;
      dimension_rise[k] -= values(below);
    }
    const auto order_four = [h](const auto& near, const auto& far, double factor) {
      return ((8 * near - far) / (12 * factor * h)).eval();
    };
    const auto order_six = [&](const auto& of) {
      return ((16 * order_four(of[0], of[1], 1) - order_four(of[1], of[2], 2)) / 15).eval();
    };
    MorphDerivative result;
    result.parameter = parameter_;
    result.rate = order_six(rise);
    const VecX of_dimensions = order_six(dimension_rise);
    result.dimensions.assign(of_dimensions.begin(), of_dimensions.end());
    const double largest = result.rate.cwiseAbs().maxCoeff();
    if (largest > 0)
      result.error =
          (result.rate - order_four(rise[0], rise[1], 1)).cwiseAbs().maxCoeff() / largest;
    return result;
  }

  VecX values(const Points& points) const {
    VecX values(static_cast<long>(dimensions_.size()));
    for (size_t d = 0; d < dimensions_.size(); ++d)
      values[static_cast<long>(d)] = dimensions_[d].value(points);
    return values;
  }

  MorphSolver& solver_;
  const DeformScene& scene_;
  const Parameter& parameter_;
  const std::vector<MeshDimension>& dimensions_;
  const Points& here_;
  double size_, step_ = 0;
};

}  // namespace

double parameter_step(const Parameter& parameter, double size) {
  constexpr double relative = 1e-3, degrees = 0.1;
  if (parameter.name.ends_with(".angle")) return degrees;
  const bool length = parameter.name.ends_with(".x") || parameter.name.ends_with(".y") ||
                      parameter.name.ends_with(".z");
  if (length) return relative * size;
  return relative * (parameter.value != 0 ? std::abs(parameter.value) : 1);
}

std::vector<MorphDerivative> morph_derivatives(MorphSolver& solver, const DeformScene& scene,
                                               const std::vector<Parameter>& parameters,
                                               const std::vector<MeshDimension>& dimensions,
                                               const Progress& progress) {
  const Points here = solver.solve(scene);
  std::vector<MorphDerivative> derivatives;
  for (const Parameter& parameter : parameters) {
    progress.update("derivatives", static_cast<double>(derivatives.size()) /
                                       static_cast<double>(parameters.size()));
    try {
      derivatives.push_back(
          ParameterDifferences(solver, scene, parameter, dimensions, here).derivative());
    } catch (const CancelledError&) {
      throw;
    } catch (const Error& e) {
      derivatives.push_back({parameter, {}, {}, 0, e.what()});
    }
  }
  solver.solve(scene);
  return derivatives;
}

}  // namespace batten
