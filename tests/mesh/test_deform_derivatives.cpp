// SPDX-License-Identifier: MPL-2.0
// Derivatives of form-feature preserving deformations: exact, and adjoint to each other.
#include <random>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten_test;

namespace {

/// A plate with holes, all kinds of constraints, and an edit that uses all numbers.
struct Example {
  Example() : model(plate_with_holes()), mesh(prepare(model.shells).mesh) {
    problem.fixed = model.fixed;
    problem.handles = {{"right", model.handle}, {"middle", {middle(0.3), middle(0.31)}}};
    for (const auto& f : model.features) problem.features.push_back({f.name, f.items});
    const auto centre = [&](int f) {
      return VertexCombination::mean_of(problem.features[f].vertices);
    };
    problem.point_constraints = {{"level", centre(0), PointConstraint::Kind::OnPlane, {0.2, 0, 1}},
                                 {"rail", centre(1), PointConstraint::Kind::OnLine, {1, 0.3, 0}}};
    const int a = middle(0.7), b = middle(0.75);
    problem.rows = {
        {.name = "soft",
         .combination = VertexCombination::mean_of({a}),
         .target = mesh.point(a),
         .weight = 50},
        {.name = "hard", .combination = centre(2), .target = centre(2).at(mesh.points())},
        {.name = "arrow",
         .combination = {{{b, 1}, {a, -1}}},
         .target = mesh.point(b) - mesh.point(a),
         .rotates_with = a,
         .weight = 3}};
    edit.handles.resize(2);
    edit.handles[0] = {mesh.point(model.handle[0]), {0.3, -0.7, 0.2}, {20, -5, 60}, 1.1};
    edit.handles[1] = {
        mesh.point(problem.handles[1].vertices[0]), {0.1, 0.4, 2.5}, {3, 4, 25}, 0.9};
    edit.feature_scales.assign(problem.features.size(), 1);
    edit.feature_scales[3] = 1.2;
    for (const PointConstraint& c : problem.point_constraints)
      edit.constraint_origins.push_back(c.point.at(mesh.points()) + Vec3(1, 2, 30));
    for (const LinearConstraint& row : problem.rows) edit.targets.push_back(row.target);
    edit.targets[0] += Vec3(2, 1, 12);
    edit.targets[1] += Vec3(-3, 2, 22);
  }

  /// A free vertex of the sheet that is in no feature.
  int middle(double fraction) const {
    std::vector<char> used(static_cast<size_t>(mesh.vertex_count()), 0);
    for (const int v : model.fixed) used[v] = 1;
    for (const int v : model.handle) used[v] = 1;
    for (const auto& f : model.features)
      for (const int v : f.items) used[v] = 1;
    int v = static_cast<int>(fraction * mesh.vertex_count());
    while (used[v]) ++v;
    return v;
  }

  MeshModel model;
  TriangleMesh mesh;
  DeformProblem problem;
  DeformEdit edit;
};

DeformEdit moved(DeformEdit edit, const DeformEditRates& rates, double step) {
  for (size_t h = 0; h < edit.handles.size(); ++h) {
    edit.handles[h].translation += step * rates.handles[h].translation;
    edit.handles[h].rotation_vector += step * rates.handles[h].rotation_vector;
    edit.handles[h].scale += step * rates.handles[h].scale;
  }
  for (size_t f = 0; f < edit.feature_scales.size(); ++f)
    edit.feature_scales[f] += step * rates.feature_scales[f];
  for (size_t k = 0; k < edit.constraint_origins.size(); ++k)
    edit.constraint_origins[k] += step * rates.constraint_origins[k];
  for (size_t r = 0; r < edit.targets.size(); ++r) edit.targets[r] += step * rates.targets[r];
  return edit;
}

/// Central differences of order six.
Points differences(FormFeatureDeformer& deformer, const DeformEdit& edit,
                   const DeformEditRates& rates, double h) {
  const auto odd = [&](int k) -> Points {
    const Points up = deformer.deform(moved(edit, rates, k * h));
    return up - deformer.deform(moved(edit, rates, -k * h));
  };
  return (45 * odd(1) - 9 * odd(2) + odd(3)) / (60 * h);
}

/// All rates as one list.
std::vector<double*> numbers_of(DeformEditRates& rates) {
  std::vector<double*> all;
  const auto add = [&](Vec3& v) {
    for (int c = 0; c < 3; ++c) all.push_back(&v[c]);
  };
  for (auto& h : rates.handles) {
    add(h.translation);
    add(h.rotation_vector);
    all.push_back(&h.scale);
  }
  for (double& s : rates.feature_scales) all.push_back(&s);
  for (auto* points : {&rates.constraint_origins, &rates.targets})
    for (Vec3& p : *points) add(p);
  return all;
}

}  // namespace

TEST_CASE("tangents equal differences for every number of an edit", "[mesh][deform]") {
  const Example e;
  FormFeatureDeformer deformer(e.mesh, e.problem);
  DeformEditRates rates(e.problem);
  const auto numbers = numbers_of(rates);
  int count = 0;  // of numbers that have an effect
  REQUIRE(numbers.size() == 2 * 7 + e.problem.features.size() + 3 * (2 + 3));
  for (size_t i = 0; i < numbers.size(); ++i) {
    INFO("number " << i);
    for (double* const number : numbers) *number = 0;
    *numbers[i] = 1;
    const Points expected = differences(deformer, e.edit, rates, 5e-3);
    deformer.deform(e.edit);
    const Points found = deformer.tangent(rates);
    const double largest = expected.cwiseAbs().maxCoeff();
    count += largest > 0;
    CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-9 * std::max(largest, 1.0));
  }
  // All but one: the plane does not depend on the y of its origin.
  CHECK(count == isize(numbers) - 1);
}

TEST_CASE("the gradient is the adjoint of the tangent", "[mesh][deform]") {
  const Example e;
  FormFeatureDeformer deformer(e.mesh, e.problem);
  deformer.deform(e.edit);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Points weights(e.mesh.vertex_count(), 3);
  for (double& w : weights.reshaped()) w = normal(random);
  DeformEditRates gradient = deformer.gradient(weights), rates(e.problem);
  const auto components = numbers_of(gradient), numbers = numbers_of(rates);
  for (size_t i = 0; i < numbers.size(); ++i) {
    INFO("number " << i);
    for (double* const number : numbers) *number = 0;
    *numbers[i] = 1;
    const Points tangent = deformer.tangent(rates);
    CHECK(std::abs(tangent.cwiseProduct(weights).sum() - *components[i]) <=
          1e-10 * tangent.norm() * weights.norm());
  }
}

TEST_CASE("derivatives need a solution, rates of the problem, and finite numbers",
          "[mesh][deform]") {
  const Example e;
  FormFeatureDeformer deformer(e.mesh, e.problem);
  DeformEditRates rates(e.problem);
  CHECK_THROWS_AS(deformer.tangent(rates), InputError);
  deformer.deform(e.edit);
  CHECK(deformer.tangent(rates).isZero(0));
  rates.targets[0][1] = std::nan("");
  CHECK_THROWS_AS(deformer.tangent(rates), InputError);
  rates.targets.pop_back();
  CHECK_THROWS_AS(deformer.tangent(rates), InputError);
  CHECK_THROWS_AS(deformer.gradient(Points::Zero(3, 3)), InputError);
  ShapeEstimate estimate;
  estimate.positions = e.mesh.points();
  deformer.deform(e.edit, estimate);
  CHECK_THROWS_AS(deformer.gradient(Points::Zero(e.mesh.vertex_count(), 3)), InputError);
}

TEST_CASE("the left Jacobian turns rates of rotation vectors into angular velocities", "[mesh]") {
  const Vec3 x(0.3, -1, 2), v(1, 2, -0.5);
  for (const double angle : {0.0, 1e-9, 1e-4, 0.9e-3, 1.1e-3, 0.5, 3.0, 7.0}) {
    const Vec3 omega = angle * Vec3(1, -2, 0.5).normalized();
    const double h = 1e-3;
    Vec3 expected = Vec3::Zero();
    for (const auto& [k, weight] : {std::pair{1, 45}, {2, -9}, {3, 1}})
      expected +=
          weight * (rotated(omega + k * h * x, v) - rotated(omega - k * h * x, v)) / (60 * h);
    CHECK((left_jacobian(omega, x).cross(rotated(omega, v)) - expected).norm() < 1e-11);
  }
}
