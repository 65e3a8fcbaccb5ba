// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/document_view.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/io/meshes/corner_normals.h"
#include "batten/mesh/triangle_mesh.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

std::array<Vec3, 2> DocumentView::box() const {
  std::optional<Box3> box;
  for (const Polyline& line : lines)
    for (const Vec3& p : line.points) {
      if (!box) box.emplace(p);
      box->extend(p);
    }
  if (!box) return {Vec3::Zero(), Vec3::Zero()};
  return {box->min(), box->max()};
}

const DocumentView::Table* DocumentView::table(const SceneTable& name) const {
  for (const Table& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

std::string DocumentView::free_name(const std::string& beginning) const {
  for (int number = 1;; ++number) {
    const std::string name = beginning + " " + std::to_string(number);
    if (std::none_of(tables.begin(), tables.end(),
                     [&](const Table& table) { return table.name.name == name; }))
      return name;
  }
}

MeshDisplay::MeshDisplay(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines) {
  CornerNormals corners = corner_normals(mesh.points(), mesh.triangles());
  auto pattern = std::make_shared<DisplayTopology>();
  vertices_ = std::move(corners.nodes);
  pattern->facets = std::move(corners.of);
  std::vector<int> point_of(mesh.vertex_count(), -1);
  for (int p = isize(vertices_) - 1; p >= 0; --p) point_of[vertices_[p]] = p;
  for (const std::vector<int>& line : lines) {
    std::vector<int> points;
    for (const int v : line)
      if (point_of[v] >= 0) points.push_back(point_of[v]);
    pattern->lines.push_back({std::move(points)});
  }
  pattern->first_facet = {0, isize(pattern->facets)};
  pattern->first_line = {0, isize(pattern->lines)};
  pattern_ = std::move(pattern);
}

void MeshDisplay::draw(const Points& shape, Frame& frame) const {
  const size_t size = 3 * vertices_.size();
  frame.remeshed = frame.pattern != pattern_;
  frame.pattern = pattern_;
  frame.points.resize(size);
  frame.normals.assign(size, 0.0F);
  for (size_t p = 0; p < vertices_.size(); ++p)
    for (int k = 0; k < 3; ++k)
      frame.points[3 * p + k] = static_cast<float>(shape(vertices_[p], k));
  for (const auto& facet : pattern_->facets) {
    const auto at = [&](int corner) -> Vec3 { return shape.row(vertices_[facet[corner]]); };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0));
    for (const int p : facet)
      for (int k = 0; k < 3; ++k) frame.normals[3 * p + k] += static_cast<float>(area[k]);
  }
  for (size_t i = 0; i < size; i += 3) {
    float* n = frame.normals.data() + i;
    const float length = std::hypot(n[0], n[1], n[2]);
    for (int k = 0; k < 3 && length > 0; ++k) n[k] /= length;
  }
  ++frame.number;
  frame.moved = true;
}

}  // namespace batten
