// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/mesh_targets/mesh_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/features/feature_lines.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {
namespace {

class MeshTarget : public TargetSurface {
 public:
  explicit MeshTarget(PnTriangleMesh mesh) : mesh_(std::move(mesh)) {}

  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        mesh_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return Nearest{found->at, found->normal, found->on_boundary};
  }

  std::vector<Nearest> samples() const override {
    constexpr double spacing = 0.01;  // relative to the size
    constexpr int most = 64;
    const TriangleMesh& flat = mesh_.mesh();
    const double step = spacing * flat.size();
    std::vector<Nearest> points;
    for (int t = 0; t < flat.triangle_count(); ++t) {
      const auto& [a, b, c] = flat.triangles()[t];
      const Vec3 u = flat.point(b) - flat.point(a), v = flat.point(c) - flat.point(a);
      const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
      const Vec3 normal = u.cross(v).normalized();
      const PnTriangle triangle = mesh_.triangle(t);
      const int n = std::clamp(static_cast<int>(std::ceil(longest / step)), 1, most);
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
          const double s = (i + 1.0 / 3) / n, r = (j + 1.0 / 3) / n;
          points.push_back({triangle.at({1 - s - r, s, r}), normal, false});
        }
    }
    return points;
  }

  Parametrization parametrize(const std::function<Vec2(const Vec3&)>& rim) const override {
    try {
      return [map = std::make_shared<HarmonicMap>(mesh_, rim)](const Vec2& place) {
        return map->surface_point(place);
      };
    } catch (const InputError&) {
      return {};  // closed, or not connected
    }
  }

 private:
  PnTriangleMesh mesh_;
};

/// True for a degenerate triangle of a CAD face: no point is nearest to its interior.
bool is_needle(const ShellMesh& mesh, int f) {
  constexpr double least_height = 1e-9;  // relative to the longest edge
  const auto corners = mesh.face(f);
  const Vec3 a = mesh.points.row(corners[0]), u = mesh.points.row(corners[1]).transpose() - a,
             v = mesh.points.row(corners[2]).transpose() - a;
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  return u.cross(v).norm() <= least_height * longest;
}

/// Normals of curved facets at the corners of the prepared triangles.
std::vector<PnTriangle::Corners> corner_normals(const TargetFaces& faces,
                                                const PreparedMesh& prepared) {
  std::vector<PnTriangle::Corners> normals;
  if (std::none_of(faces.normals.begin(), faces.normals.end(), [](const auto& n) { return !!n; }))
    return normals;
  for (int t = 0; t < prepared.mesh.triangle_count(); ++t) {
    const Vec3 flat = prepared.mesh.area_vector(t).normalized();
    const int f = prepared.face_of_triangle[t];
    PnTriangle::Corners& corners = normals.emplace_back(PnTriangle::Corners{flat, flat, flat});
    if (!faces.normals[f]) continue;
    for (size_t c = 0; c < 3; ++c) {
      const int node = prepared.mesh.topology().node_of(prepared.mesh.triangles()[t][c]);
      for (size_t k = 0; k < 3; ++k) {
        if (faces.shells.face(f)[k] != node) continue;
        const Vec3& n = (*faces.normals[f])[k];
        corners[c] = n.dot(flat) < 0 ? Vec3(-n) : n;
      }
    }
  }
  return normals;
}

/// The parts of the target: CAD faces by index, followed by patches of meshes.
std::map<int, std::vector<int>> parts_of(const TargetFaces& faces, const PreparedMesh& prepared) {
  std::map<int, std::vector<int>> parts;
  std::vector<int> number(prepared.mesh.triangle_count());
  bool meshes = false;
  for (int t = 0; t < isize(number); ++t)
    meshes |= (number[t] = faces.part[prepared.face_of_triangle[t]]) < 0;
  if (meshes) {
    const FeatureLines features = feature_lines(prepared.mesh);
    for (int p = 0; p < isize(features.patches); ++p)
      for (const int t : features.patches[p].triangles)
        if (number[t] < 0) number[t] = faces.next_part + p;
  }
  for (int t = 0; t < isize(number); ++t) parts[number[t]].push_back(t);
  return parts;
}

/// Some triangles as a separate mesh.
PnTriangleMesh part_of(const PnTriangleMesh& whole, const std::vector<int>& triangles) {
  TargetFaces part;
  std::map<int, int> number;
  std::vector<Vec3> points;
  for (const int t : triangles) {
    std::array<int, 3> corners = whole.mesh().triangles()[t];
    for (int& corner : corners) {
      const auto [at, added] = number.try_emplace(corner, isize(points));
      if (added) points.push_back(whole.mesh().point(corner));
      corner = at->second;
    }
    part.shells.add_face(corners);
    part.normals.emplace_back();
    if (whole.curved(t)) part.normals.back() = whole.normals(t);
  }
  part.shells.points.resize(isize(points), 3);
  for (int i = 0; i < isize(points); ++i) part.shells.points.row(i) = points[i];
  const PreparedMesh prepared = prepare(part.shells);
  return PnTriangleMesh(prepared.mesh, corner_normals(part, prepared));
}

}  // namespace

void TargetFaces::append(const ShellMesh& more, double scale,
                         const std::vector<PnTriangle::Corners>& corners,
                         const std::vector<int>& faces) {
  const int first = shells.node_count();
  Points points(first + more.node_count(), 3);
  points << shells.points, scale * more.points;
  shells.points = std::move(points);
  const int first_part = next_part;
  for (int f = 0; f < more.face_count(); ++f) {
    if (!corners.empty() && is_needle(more, f)) continue;
    std::vector<int> nodes(more.face(f).begin(), more.face(f).end());
    for (int& node : nodes) node += first;
    shells.add_face(nodes, more.second_order(f));
    normals.emplace_back();
    if (!corners.empty()) normals.back() = corners[f];
    part.push_back(faces.empty() ? -1 : first_part + faces[f]);
    next_part = std::max(next_part, part.back() + 1);
  }
}

TargetParts target_parts(const TargetFaces& faces) {
  const PreparedMesh prepared = prepare(faces.shells);
  PnTriangleMesh whole(prepared.mesh, corner_normals(faces, prepared));
  TargetParts result;
  const auto parts = parts_of(faces, prepared);
  if (parts.size() > 1)
    for (const auto& [number, triangles] : parts)
      result.parts.push_back(std::make_shared<MeshTarget>(part_of(whole, triangles)));
  result.whole = std::make_shared<MeshTarget>(std::move(whole));
  return result;
}

}  // namespace batten
