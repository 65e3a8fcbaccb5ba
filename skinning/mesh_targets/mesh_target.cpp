// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/mesh_targets/mesh_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/features/feature_lines.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/skinning/target/primitive_projection.h"

namespace batten {
namespace {

/// The analytic faces of some triangles.
struct AnalyticParts {
  std::vector<FittedPrimitive> primitives;
  std::vector<int> of_triangle;  ///< index into `primitives`, or -1; empty: no analytic faces
  double deviation = 0;          ///< largest distance of the triangles from their faces
  /// For each triangle with a corner on an edge of its face: the primitives of the other faces there.
  std::map<int, std::vector<const FittedPrimitive*>> beside = {};
  /// For each primitive, 1 if its face has the outward normals of the primitive, else -1.
  std::vector<double> sides = {};

  const FittedPrimitive* primitive_of(int triangle) const {
    if (of_triangle.empty() || of_triangle[triangle] < 0) return nullptr;
    const FittedPrimitive& found = primitives[of_triangle[triangle]];
    return found.kind == FittedPrimitive::Kind::Free ? nullptr : &found;
  }
  bool one_face() const {
    return primitives.size() == 1 &&
           std::none_of(of_triangle.begin(), of_triangle.end(), [](int at) { return at < 0; });
  }

  /// Finds the sides of the primitives. Near an apex, the triangles may be on the wrong side.
  void find_sides(const TriangleMesh& mesh) {
    sides.assign(primitives.size(), 0);
    for (int t = 0; t < isize(of_triangle); ++t) {
      if (!primitive_of(t)) continue;
      const auto& [a, b, c] = mesh.triangles()[t];
      const Vec3 middle = (mesh.point(a) + mesh.point(b) + mesh.point(c)) / 3;
      sides[of_triangle[t]] += primitive_of(t)->normal(middle).dot(mesh.area_vector(t));
    }
    for (double& side : sides) side = side < 0 ? -1 : 1;
  }

  /// Finds the faces beside each triangle.
  void find_beside(const TriangleMesh& mesh) {
    if (primitives.size() < 2) return;
    std::vector<std::map<int, int>> at_vertex(mesh.vertex_count());  // face → one of its triangles
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (const int v : mesh.triangles()[t]) at_vertex[v].emplace(of_triangle[t], t);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      std::map<int, int> others;
      for (const int v : mesh.triangles()[t])
        for (const auto& other : at_vertex[v])
          if (other.first != of_triangle[t]) others.insert(other);
      for (const auto& [face, triangle] : others)
        if (const FittedPrimitive* primitive = primitive_of(triangle)) beside[t].push_back(primitive);
    }
  }
};

class MeshTarget : public TargetSurface {
 public:
  MeshTarget(PnTriangleMesh mesh, AnalyticParts exact)
      : mesh_(std::move(mesh)), exact_(std::move(exact)) {
    exact_.find_sides(mesh_.mesh());
    exact_.find_beside(mesh_.mesh());
  }

  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        mesh_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return exact({found->at, found->normal, found->on_boundary}, found->triangle, p);
  }

  const FittedPrimitive* primitive() const override {
    return exact_.one_face() ? exact_.primitive_of(0) : nullptr;
  }
  bool is_analytic() const override { return exact_.one_face(); }

  std::vector<Nearest> samples() const override {
    constexpr double spacing = 0.01;  // relative to the size
    constexpr int most = 64;
    const TriangleMesh& flat = mesh_.mesh();
    const double step = spacing * flat.size();
    const auto count = [&](double length) {
      return std::clamp(static_cast<int>(std::ceil(length / step)), 1, most);
    };
    std::vector<Nearest> points;
    for (int t = 0; t < flat.triangle_count(); ++t) {
      const std::array<int, 3>& corners = flat.triangles()[t];
      const auto length = [&](size_t c) {  // of the edge opposite to a corner
        return (flat.point(corners[(c + 2) % 3]) - flat.point(corners[(c + 1) % 3])).norm();
      };
      size_t top = 0;
      for (const size_t c : {1, 2})
        if (length(c) > length(top)) top = c;
      const double height = flat.area_vector(t).norm() / length(top);  // twice the area over the base
      const Vec3 normal = flat.area_vector(t).normalized();
      const PnTriangle triangle = mesh_.triangle(t);
      const int rows = count(height);
      for (int row = 0; row < rows; ++row) {
        const double up = (row + 1.0 / 3) / rows;
        const int columns = count((1 - up) * length(top));
        for (int column = 0; column < columns; ++column) {
          const double along = (1 - up) * (column + 0.5) / columns;
          Vec3 weights;
          weights[top] = up;
          weights[(top + 1) % 3] = 1 - up - along;
          weights[(top + 2) % 3] = along;
          const Vec3 x = triangle.at(weights);
          points.push_back(exact({x, normal, false}, t, x));
        }
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
  /// Replaces the closest point of a triangle to p by that of its face's primitive or, at an edge,
  /// of the nearest face there. Keeps it if p is beyond the boundary, where the two differ by more
  /// than the triangles from the primitives.
  Nearest exact(const Nearest& of_triangle, int triangle, const Vec3& p) const {
    const FittedPrimitive* own = exact_.primitive_of(triangle);
    if (!own) return of_triangle;
    Nearest best = of_triangle;
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](const FittedPrimitive& primitive) {
      const PrimitiveProjection found = project_onto(primitive, p);
      const double distance = (p - found.at).norm();
      // The foot points of a point off the surface differ by the angle between the normals.
      constexpr double off_surface = 0.1;
      const double slack = 2 * exact_.deviation + off_surface * distance;
      if (!((found.at - of_triangle.at).norm() <= slack) || distance >= least) return;
      least = distance;
      best.at = found.at;
      if (&primitive == own) best.normal = exact_.sides[exact_.of_triangle[triangle]] * found.normal;
    };
    consider(*own);
    if (const auto beside = exact_.beside.find(triangle); beside != exact_.beside.end())
      for (const FittedPrimitive* primitive : beside->second) consider(*primitive);
    return best;
  }

  PnTriangleMesh mesh_;
  AnalyticParts exact_;
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

namespace {

/// The analytic faces of triangles of a prepared mesh.
AnalyticParts analytic_parts(const TargetFaces& faces, const PreparedMesh& prepared,
                             const std::vector<int>& triangles) {
  AnalyticParts result;
  if (faces.analytic.empty()) return result;
  result.deviation = faces.deviation;
  std::map<int, int> index;
  for (const int t : triangles) {
    const int part = faces.part[prepared.face_of_triangle[t]];
    const auto primitive = faces.analytic.find(part);
    int at = -1;
    if (primitive != faces.analytic.end()) {
      at = index.emplace(part, isize(result.primitives)).first->second;
      if (at == isize(result.primitives)) result.primitives.push_back(primitive->second);
    }
    result.of_triangle.push_back(at);
  }
  return result;
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
  std::vector<int> all(prepared.mesh.triangle_count());
  std::iota(all.begin(), all.end(), 0);
  AnalyticParts exact = analytic_parts(faces, prepared, all);
  if (parts.size() > 1)
    for (const auto& [number, triangles] : parts)
      result.parts.push_back(std::make_shared<MeshTarget>(
          part_of(whole, triangles), analytic_parts(faces, prepared, triangles)));
  result.whole = std::make_shared<MeshTarget>(std::move(whole), std::move(exact));
  if (parts.size() == 1 && result.whole->is_analytic()) result.parts = {result.whole};
  return result;
}

}  // namespace batten
