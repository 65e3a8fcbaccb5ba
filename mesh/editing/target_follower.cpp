// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/editing/target_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

double mean_edge_length(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& edge : mesh.topology().edges())
    sum += (mesh.point(edge.high) - mesh.point(edge.low)).norm();
  return sum / std::max<double>(1, static_cast<double>(mesh.topology().edges().size()));
}

/// Sums of the area vectors of the triangles at each vertex.
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh, const Points& shape) {
  std::vector<Vec3> normals(static_cast<size_t>(mesh.vertex_count()), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles()) {
    const Vec3 normal = Vec3(shape.row(b) - shape.row(a)).cross(Vec3(shape.row(c) - shape.row(a)));
    for (const int v : {a, b, c}) normals[v] += normal;
  }
  return normals;
}

}  // namespace

TargetFollower::TargetFollower(const TriangleMesh& mesh, std::vector<int> vertices,
                               ClosestTargetPoint closest, const TargetFollowerOptions& options)
    : mesh_(&mesh),
      vertices_(std::move(vertices)),
      closest_(std::move(closest)),
      options_(options),
      areas_(mixed_areas(mesh)) {
  constexpr double edges = 2, of_size = 0.1;
  if (options_.smoothing == 0) options_.smoothing = edges * mean_edge_length(mesh);
  if (options_.reach == 0) options_.reach = of_size * mesh.size();
  const std::vector<Vec3> normals = vertex_normals(mesh, mesh.points());
  std::erase_if(vertices_, [&](int v) { return normals[v].norm() == 0; });  // no face
  orient(mesh.points());
  find_vertices(mesh.points());
  if (with_spring_.empty())
    throw InputError("found no vertex of the mesh within " + format_number(options_.reach) +
                     " of the target, expected a target at the mesh: check its unit and position");
}

// The majority decides, by area.
void TargetFollower::orient(const Points& shape) {
  const std::vector<Vec3> normals = vertex_normals(*mesh_, shape);
  VecX agreement = VecX::Zero(static_cast<long>(vertices_.size()));
  parallel_for_each<64>(isize(vertices_), [&](int k) {
    const int v = vertices_[k];
    const auto found = closest_(shape.row(v).transpose(), Vec3::Zero());
    if (found && (found->at - shape.row(v).transpose()).norm() <= options_.reach)
      agreement[k] = found->normal.dot(normals[v]);
  });
  orientation_ = agreement.sum() < 0 ? -1 : 1;
}

std::vector<std::optional<Vec3>> TargetFollower::find(const Points& shape,
                                                      const std::vector<int>& vertices) const {
  constexpr double cosine = 0.5;  // of 60 degrees
  const std::vector<Vec3> normals = vertex_normals(*mesh_, shape);
  std::vector<std::optional<Vec3>> found(vertices.size());
  parallel_for_each<64>(isize(vertices), [&](int k) {
    const int v = vertices[k];
    const Vec3 p = shape.row(v).transpose(), normal = orientation_ * normals[v].normalized();
    const auto point = closest_(p, normal);
    if (!point || point->at_boundary || !(point->normal.dot(normal) > cosine)) return;
    if ((point->at - p).norm() <= options_.reach + std::abs(options_.offset))
      found[k] = point->at + options_.offset * point->normal;
  });
  return found;
}

bool TargetFollower::find_vertices(const Points& shape) {
  const auto found = find(shape, vertices_);
  std::vector<int> with_spring;
  for (size_t k = 0; k < vertices_.size(); ++k)
    if (found[k]) with_spring.push_back(vertices_[k]);
  if (with_spring == with_spring_) return false;
  with_spring_ = std::move(with_spring);
  return true;
}

std::vector<LinearConstraint> TargetFollower::springs(const std::string& name,
                                                      DeformProblem::Weighting weighting) const {
  const double stiffness = std::pow(options_.smoothing, -4);
  std::vector<LinearConstraint> springs;
  for (const int v : with_spring_)
    springs.push_back(
        {name + " at vertex " + std::to_string(v),
         {{{v, 1.0}}},
         mesh_->point(v),
         -1,
         weighting == DeformProblem::Weighting::Area ? stiffness * areas_[v] : stiffness});
  return springs;
}

std::vector<Vec3> TargetFollower::closest_points(const Points& shape) const {
  const auto found = find(shape, with_spring_);
  std::vector<Vec3> ends(with_spring_.size());
  for (size_t k = 0; k < ends.size(); ++k)
    ends[k] = found[k] ? *found[k] : Vec3(shape.row(with_spring_[k]).transpose());
  return ends;
}

TargetDistance TargetFollower::distance(const Points& shape) const {
  const auto found = find(shape, vertices_);
  TargetDistance distance;
  double sum = 0;
  for (size_t k = 0; k < vertices_.size(); ++k) {
    if (!found[k]) {
      ++distance.ignored;
      continue;
    }
    const double d = (*found[k] - shape.row(vertices_[k]).transpose()).norm();
    ++distance.vertices;
    sum += d * d;
    distance.largest = std::max(distance.largest, d);
  }
  if (distance.vertices > 0) distance.rms = std::sqrt(sum / distance.vertices);
  return distance;
}

}  // namespace batten
