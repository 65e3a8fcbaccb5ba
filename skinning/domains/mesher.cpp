// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/domains/mesher.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/op_counter.h"

namespace batten {

ParametricMesh fan_mesh(const PlanarMeshInput& task, int refinements) {
  count(OpCounter::Triangulation);
  if (!task.inner.empty() || !task.holes.empty())
    throw InputError(
        "the fan mesher does not support inner curves and holes; use mesher = \"delaunay\"");
  std::vector<Vec2> vertices = task.points;
  // Centroid of the area.
  Vec2 centre = Vec2::Zero();
  double area = 0;
  for (const auto& [a, b] : task.outline) {
    const double cross = vertices[a].x() * vertices[b].y() - vertices[a].y() * vertices[b].x();
    area += 0.5 * cross;
    centre += cross / 6 * (vertices[a] + vertices[b]);
  }
  vertices.push_back(centre / area);
  const int middle = isize(vertices) - 1;
  std::vector<ParametricMesh::Triangle> triangles;
  for (const auto& [a, b] : task.outline) {
    const Vec2 p = vertices[a] - vertices[middle], q = vertices[b] - vertices[middle];
    if (!(p.x() * q.y() - p.y() * q.x() > 0))
      throw InputError(
          "the fan mesher needs a domain that is star-shaped about its centre; use "
          "mesher = \"delaunay\"");
    triangles.push_back({middle, a, b});
  }
  ParametricMesh mesh(std::move(vertices), std::move(triangles));
  for (int r = 0; r < refinements; ++r) mesh = mesh.refined();
  return mesh;
}

SizeField::SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths)
    : mesh_(std::move(mesh)), locator_(*mesh_), lengths_(std::move(lengths)) {}

double SizeField::at(const Vec2& uv) const {
  const Location where = locator_.locate(uv);
  const auto& corners = mesh_->triangles()[where.triangle];
  double length = 0;
  for (int k = 0; k < 3; ++k) length += where.L[k] * lengths_[corners[k]];
  return length;
}

double bytes_for_triangles(double triangles) {
  return 70e6 + 500 * triangles * std::log2(std::max(triangles, 2.0));
}

namespace {

// `bytes`: memory as a function of the number of triangles.
template <class Bytes>
void require_affordable(const std::string& means, double triangles, double edge_length,
                        const Bytes& bytes) {
  const double needed = bytes(triangles), left = available_memory();
  if (!(needed > left)) return;
  double affordable = triangles;
  while (affordable > 16 && bytes(affordable) > 0.5 * left) affordable /= 1.2;
  throw InputError(means + ", which need " + format_bytes(needed) + " of memory, but only " +
                   format_bytes(std::max(left, 0.0)) + " are available; edge_length = " +
                   format_number(edge_length * std::sqrt(triangles / affordable)) + " needs " +
                   format_bytes(bytes(affordable)));
}

std::string mesh_description(double edge_length, const std::string& what, double size,
                             double triangles) {
  return "edge_length = " + format_number(edge_length) + " on " + what + " of size " +
         format_number(size) + " creates about " + format_number(triangles) + " triangles";
}

}  // namespace

void require_mesh_size(double triangles, double edge_length, double size, const std::string& what) {
  const std::string means = mesh_description(edge_length, what, size, triangles);
  if (!(triangles <= kMaxTriangles))
    throw InputError(means + ", expected at most " + format_number(kMaxTriangles) +
                     "; check the unit");
  require_affordable(means, triangles, edge_length, bytes_for_triangles);
}

void require_model_size(double triangles, double edge_length, double size) {
  require_affordable(mesh_description(edge_length, "all faces of a network", size, triangles),
                     triangles, edge_length, [](double n) { return 70e6 + 2000 * n; });
}

double max_refined_triangles(double edge_length, double size) {
  constexpr double usual = 50'000, times = 10;
  return std::clamp(times * (size / edge_length) * (size / edge_length), usual, kMaxTriangles);
}

void require_tolerance(double tolerance, double size) {
  constexpr double min_fraction = 1e-9;
  if (tolerance >= min_fraction * size) return;
  throw InputError("found fit_tolerance = " + format_number(tolerance) + " for a size of " +
                   format_number(size) + ", expected " + format_number(min_fraction * size) +
                   " or more; check the unit");
}

}  // namespace batten
