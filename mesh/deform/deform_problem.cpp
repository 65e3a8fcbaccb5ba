// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/deform_problem.h"

#include <cmath>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

void check_vertices(const std::string& what, const std::vector<int>& vertices, int count,
                    bool may_be_empty = false) {
  if (vertices.empty() && !may_be_empty)
    throw InputError(what + " has no vertices, expected at least one");
  for (const int v : vertices)
    if (v < 0 || v >= count)
      throw InputError(what + ": found vertex " + std::to_string(v) + ", expected 0 to " +
                       std::to_string(count - 1));
}

void check_combination(const std::string& what, const VertexCombination& c, int count) {
  if (c.entries.empty()) throw InputError(what + " has no vertices, expected at least one");
  for (const auto& e : c.entries) {
    check_vertices(what, {e.vertex}, count);
    if (!std::isfinite(e.coefficient))
      throw InputError(what + " has a coefficient that is not finite");
  }
}

}  // namespace

VertexCombination VertexCombination::mean_of(const std::vector<int>& vertices) {
  VertexCombination mean;
  for (const int v : vertices)
    mean.entries.push_back({v, 1.0 / static_cast<double>(vertices.size())});
  return mean;
}

double VertexCombination::sum() const {
  double sum = 0;
  for (const auto& e : entries) sum += e.coefficient;
  return sum;
}

Vec3 VertexCombination::at(const Points& points) const {
  Vec3 sum = Vec3::Zero();
  for (const auto& e : entries) sum += e.coefficient * points.row(e.vertex).transpose();
  return sum;
}

Vec3 HandleTransform::operator()(const Vec3& p) const {
  return about + scale * rotated(rotation_vector, p - about) + translation;
}

std::vector<LinearConstraint> position_constraints(const std::string& name,
                                                   const std::vector<int>& vertices,
                                                   const std::vector<Vec3>& targets) {
  if (targets.size() != vertices.size())
    throw InputError("the chain '" + name + "': found " + std::to_string(targets.size()) +
                     " targets, expected " + std::to_string(vertices.size()) +
                     ", one for each vertex");
  std::vector<LinearConstraint> rows;
  for (size_t i = 0; i < vertices.size(); ++i)
    rows.push_back({name + ", vertex " + std::to_string(i + 1),
                    {{{vertices[i], 1.0}}},
                    targets[i],
                    -1,
                    std::nullopt});
  return rows;
}

DeformProblem expand_to_nodes(DeformProblem problem, const MeshTopology& topology) {
  if (topology.node_count() == topology.vertex_count()) return problem;
  problem.fixed = topology.expand_to_nodes(std::move(problem.fixed));
  if (problem.region) problem.region = topology.expand_to_nodes(std::move(*problem.region));
  for (Handle& h : problem.handles) h.vertices = topology.expand_to_nodes(std::move(h.vertices));
  for (FormFeature& f : problem.features)
    f.vertices = topology.expand_to_nodes(std::move(f.vertices));
  return problem;
}

void check(const DeformProblem& problem, int count) {
  std::set<std::pair<std::string, std::string>> names;  // a feature and a handle may have the same
                                                        // name
  const auto check_name = [&](const std::string& kind, const std::string& name) {
    if (name.empty()) throw InputError("found a " + kind + " without a name");
    if (!names.insert({kind, name}).second)
      throw InputError("found two " + kind + "s named '" + name + "', expected unique names");
  };
  check_vertices("the fixed region", problem.fixed, count, true);
  if (problem.region) check_vertices("the region of interest", *problem.region, count);
  for (const auto& h : problem.handles) {
    check_name("handle", h.name);
    check_vertices("handle '" + h.name + "'", h.vertices, count);
  }
  for (const auto& f : problem.features) {
    check_name("feature", f.name);
    check_vertices("feature '" + f.name + "'", f.vertices, count);
  }
  for (const auto& g : problem.point_constraints) {
    check_name("point constraint", g.name);
    check_combination("point constraint '" + g.name + "'", g.point, count);
    const double sum = g.point.sum();
    if (!(std::abs(sum - 1) < 1e-9 || std::abs(sum) < 1e-9))
      throw InputError("the coefficients of point constraint '" + g.name + "' sum to " +
                       format_number(sum) + ", expected 1, or 0 for a vector");
    if (!g.direction.allFinite() || !(g.direction.norm() > 0))
      throw InputError("the direction of point constraint '" + g.name +
                       "' has length 0 or is not finite");
  }
  for (const auto& group : problem.shared_rotations)
    for (const int f : group)
      if (f < 0 || f >= isize(problem.features))
        throw InputError("shared rotations: found feature " + std::to_string(f) +
                         ", expected 0 to " + std::to_string(problem.features.size() - 1));
  for (const auto& c : problem.chains) {
    check_name("chain", c.name);
    check_vertices("chain '" + c.name + "'", c.vertices, count);
    if (c.vertices.size() < 3)
      throw InputError("chain '" + c.name + "' has " + std::to_string(c.vertices.size()) +
                       " vertices, expected at least three");
    if (!(c.width > 0) || !std::isfinite(c.width))
      throw InputError("chain '" + c.name + "' has width " + format_number(c.width) +
                       ", expected a width above 0");
  }
  for (const auto& r : problem.rows) {
    check_name("linear constraint", r.name);
    check_combination("linear constraint '" + r.name + "'", r.combination, count);
    if (r.rotates_with != -1)
      check_vertices("linear constraint '" + r.name + "'", {r.rotates_with}, count);
    if (!(r.target.array().abs() < 1e100).all())
      throw InputError("linear constraint '" + r.name + "' has a target that is not finite");
    if (r.weight && !(*r.weight > 0 && std::isfinite(*r.weight)))
      throw InputError("linear constraint '" + r.name + "' has weight " + format_number(*r.weight) +
                       ", expected a weight above 0, or none for a hard constraint");
  }
  const bool positioned =
      std::any_of(problem.rows.begin(), problem.rows.end(), [](const LinearConstraint& row) {
        return !row.connects && std::abs(row.combination.sum()) > 1e-9;
      });
  if (problem.fixed.empty() && problem.handles.empty() && !problem.region && !positioned)
    throw InputError("found no fixed nodes and no handles, expected one of them");
}

void check(const DeformProblem& problem, const DeformEdit& edit) {
  const auto count = [](const char* what, size_t found, size_t expected) {
    if (found != expected)
      throw InputError("the edit has " + std::to_string(found) + " " + what + ", expected " +
                       std::to_string(expected));
  };
  // The squares of larger numbers would overflow.
  const auto is_usable = [](const Vec3& v) { return (v.array().abs() < 1e100).all(); };
  count("transformations of handles", edit.handles.size(), problem.handles.size());
  if (!edit.feature_scales.empty())
    count("scales of features", edit.feature_scales.size(), problem.features.size());
  if (!edit.constraint_origins.empty())
    count("origins of point constraints", edit.constraint_origins.size(),
          problem.point_constraints.size());
  if (!edit.targets.empty()) count("targets", edit.targets.size(), problem.rows.size());
  for (size_t h = 0; h < edit.handles.size(); ++h) {
    const HandleTransform& m = edit.handles[h];
    if (!is_usable(m.about) || !is_usable(m.rotation_vector) || !is_usable(m.translation) ||
        !(m.scale < 1e100) || !(m.scale > 0))
      throw InputError("the transformation of handle '" + problem.handles[h].name +
                       "' has a value that is not finite or above 1e100, or a scale that is not "
                       "above 0");
  }
  for (size_t f = 0; f < edit.feature_scales.size(); ++f)
    if (!(edit.feature_scales[f] > 0) || !(edit.feature_scales[f] < 1e100))
      throw InputError("the scale of feature '" + problem.features[f].name + "' is " +
                       format_number(edit.feature_scales[f]) + ", expected a number above 0");
  for (size_t k = 0; k < edit.constraint_origins.size(); ++k)
    if (!is_usable(edit.constraint_origins[k]))
      throw InputError("the origin of point constraint '" + problem.point_constraints[k].name +
                       "' is not finite");
  for (size_t k = 0; k < edit.targets.size(); ++k)
    if (!is_usable(edit.targets[k]))
      throw InputError("the target of linear constraint '" + problem.rows[k].name +
                       "' is not finite");
}

void check(const DeformProblem& problem, const DeformEditRates& rates) {
  const auto count = [](const char* what, size_t found, size_t expected) {
    if (found != expected)
      throw InputError("found " + std::to_string(found) + " rates of " + what + ", expected " +
                       std::to_string(expected));
  };
  count("handles", rates.handles.size(), problem.handles.size());
  count("scales of features", rates.feature_scales.size(), problem.features.size());
  count("origins of point constraints", rates.constraint_origins.size(),
        problem.point_constraints.size());
  count("targets", rates.targets.size(), problem.rows.size());
  double sum = 0;  // NaN and infinity remain
  for (const auto& h : rates.handles)
    sum += h.translation.norm() + h.rotation_vector.norm() + std::abs(h.scale);
  for (const double s : rates.feature_scales) sum += std::abs(s);
  for (const auto* points : {&rates.constraint_origins, &rates.targets})
    for (const Vec3& p : *points) sum += p.norm();
  if (!std::isfinite(sum)) throw InputError("rates: found a number that is not finite");
}

DeformEditRates::DeformEditRates(const DeformProblem& problem)
    : handles(problem.handles.size()),
      feature_scales(problem.features.size(), 0),
      constraint_origins(problem.point_constraints.size(), Vec3::Zero()),
      targets(problem.rows.size(), Vec3::Zero()) {}

}  // namespace batten
