// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/mesh_dimension.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {
namespace {

using Kind = DimensionSpec::Kind;

/// The triangles of a mesh whose vertices all belong to `nodes` (all triangles, if it is empty).
std::vector<std::array<int, 3>> triangles_within(const TriangleMesh& mesh,
                                                 const std::vector<int>& nodes) {
  if (nodes.empty()) return mesh.triangles();
  std::vector<char> in(static_cast<size_t>(mesh.vertex_count()), 0);
  for (const int v : nodes) in[v] = 1;
  std::vector<std::array<int, 3>> within;
  for (const auto& t : mesh.triangles())
    if (std::all_of(t.begin(), t.end(), [&](int v) { return in[mesh.topology().node_of(v)] != 0; }))
      within.push_back(t);
  return within;
}

/// True if every edge belongs to two triangles of opposite direction.
bool encloses_volume(const std::vector<std::array<int, 3>>& triangles, const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> balance;  // per undirected edge: uses along minus against
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : triangles)
    for (size_t k = 0; k < 3; ++k) {
      const int a = mesh.topology().node_of(t[k]), b = mesh.topology().node_of(t[(k + 1) % 3]);
      const auto edge = std::minmax(a, b);
      balance[edge] += a < b ? 1 : -1;
      ++uses[edge];
    }
  return std::all_of(uses.begin(), uses.end(), [&](const auto& edge) {
    return edge.second == 2 && balance.at(edge.first) == 0;
  });
}

}  // namespace

MeshDimension::MeshDimension(const DeformScene& scene, const DimensionSpec& rule,
                             const std::vector<FormFeature>& features, VertexSelector& select,
                             const TriangleMesh& mesh)
    : rule_(rule) {
  for (const LocatedString& name : rule.of)
    parts_.push_back(part_of(scene, name, features, select, mesh));
  if (parts_.empty()) parts_.push_back({{}, false, false, mesh.triangles()});
  check(scene, mesh);
}

MeshDimension::Part MeshDimension::part_of(const DeformScene& scene, const LocatedString& name,
                                           const std::vector<FormFeature>& features,
                                           VertexSelector& select, const TriangleMesh& mesh) const {
  Part part;
  const bool needs_faces = rule_.kind != Kind::Distance && rule_.kind != Kind::Radius;
  const DetectedFeature* proposal = select.proposal(name.text);
  if (proposal && !proposal->loop.empty() && rule_.kind <= Kind::Angle) {
    for (const int v : proposal->loop) part.vertices.push_back(mesh.topology().node_of(v));
    part.hole = true;
    part.circular = measure_hole(mesh.points(), part.vertices).circular;
    return part;
  }
  const auto feature = std::find_if(features.begin(), features.end(),
                                    [&](const FormFeature& f) { return f.name == name.text; });
  part.vertices = feature != features.end() ? feature->vertices : select.of(name);
  if (needs_faces) {
    part.triangles = triangles_within(mesh, part.vertices);
    if (part.triangles.empty())
      throw InputError(scene.at(name.location) + "found '" + name.text +
                       "', which contains no whole face, expected one with faces for the "
                       "dimension '" +
                       rule_.name + "'");
  }
  return part;
}

void MeshDimension::check(const DeformScene& scene, const TriangleMesh& mesh) const {
  const std::string where = scene.at(rule_.location) + "the dimension '" + rule_.name + "': ";
  const Part& part = parts_.front();
  if (rule_.kind == Kind::Radius) {
    constexpr double tolerance = 0.02;
    const HoleMeasure measure = measure_hole(mesh.points(), part.vertices);
    Box3 box;  // an arc of 60 degrees is as long as the radius
    for (const int v : part.vertices) box.extend(mesh.point(v));
    const bool arc =
        measure.roundness <= tolerance * measure.radius && box.diagonal().norm() >= measure.radius;
    if (!(part.hole ? part.circular : arc))
      throw InputError(where + "found vertices that deviate by " +
                       format_number(measure.roundness) +
                       " from a circle, expected a circular hole, or an arc of 60 degrees or more");
  }
  if (rule_.kind == Kind::Volume && !encloses_volume(part.triangles, mesh))
    throw InputError(where +
                     "found a surface that is not closed, expected one that encloses a volume");
}

Vec3 MeshDimension::centre(const Part& part, const Points& points) {
  return part.circular ? measure_hole(points, part.vertices).centre
                       : VertexCombination::mean_of(part.vertices).at(points);
}

Vec3 MeshDimension::area_vector(const Part& part, const Points& points) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [a, b, c] : part.triangles)
    sum += Vec3(points.row(b) - points.row(a)).cross(Vec3(points.row(c) - points.row(a))) / 2;
  return sum;
}

Vec3 MeshDimension::axis(const Part& part, const Points& points) {
  return part.hole ? measure_hole(points, part.vertices).axis : area_vector(part, points);
}

double MeshDimension::area(const Part& part, const Points& points) {
  double sum = 0;
  for (const auto& [a, b, c] : part.triangles)
    sum +=
        Vec3(points.row(b) - points.row(a)).cross(Vec3(points.row(c) - points.row(a))).norm() / 2;
  return sum;
}

double MeshDimension::value(const Points& points) const {
  const Part& part = parts_.front();
  switch (rule_.kind) {
    case Kind::Distance: {
      const Vec3 d = centre(parts_[1], points) - centre(part, points);
      return rule_.direction ? rule_.direction->dot(d) : d.norm();
    }
    case Kind::Radius:
      return measure_hole(points, part.vertices).radius;
    case Kind::Angle: {
      const Vec3 a = axis(part, points), b = axis(parts_[1], points);
      return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
    }
    case Kind::Area:
      return area(part, points);
    case Kind::Volume: {
      const RowPoints from_centre = points.rowwise() - points.colwise().mean();
      return std::abs(enclosed_volume(part.triangles, from_centre));
    }
    case Kind::Mass:
      return area(part, points) * rule_.thickness * rule_.density;
  }
  return 0;
}

std::vector<MeshDimension> mesh_dimensions(const DeformScene& scene,
                                           const std::vector<FormFeature>& features,
                                           VertexSelector& select, const TriangleMesh& mesh) {
  std::vector<MeshDimension> dimensions;
  for (const DimensionSpec& rule : scene.dimensions)
    dimensions.emplace_back(scene, rule, features, select, mesh);
  return dimensions;
}

}  // namespace batten
