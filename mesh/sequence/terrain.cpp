#include "batten/mesh/sequence/terrain.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

Vec3 unit(const Vec3& up) {
  if (!(up.norm() > 0) || !up.allFinite()) throw InputError("terrain: up is no direction");
  return up.normalized();
}

}  // namespace

Terrain::Terrain(TriangleMesh mesh, const Vec3& up) : mesh_(std::move(mesh)), up_(unit(up)) {
  across_[0] = up_.unitOrthogonal();
  across_[1] = up_.cross(across_[0]);
  const MeshTopology& topology = mesh_.topology();
  normals_ = Points::Zero(topology.node_count(), 3);
  Box2 box;
  bool seen = false;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const Vec3 area = mesh_.area_vector(t);
    seen = seen || area.dot(up_) != 0;
    for (const int v : mesh_.triangles()[t]) {
      normals_.row(topology.node_of(v)) += (area.dot(up_) < 0 ? -1 : 1) * area.transpose();
      box.extend(to_plane(mesh_.point(v)));
    }
  }
  if (!seen) throw InputError("terrain: no triangle is seen from above");
  cells_ = std::clamp(static_cast<int>(std::sqrt(mesh_.triangle_count())), 1, 4096);
  low_ = box.min();
  step_ = box.sizes() / cells_;
  // Counted, then written: the triangles of cell c are list_[start_[c]] … .
  start_.assign(static_cast<size_t>(cells_) * cells_ + 1, 0);
  for (const bool counts : {true, false}) {
    for (int t = mesh_.triangle_count() - 1; t >= 0; --t) {
      Box2 around;
      for (const int v : mesh_.triangles()[t]) around.extend(to_plane(mesh_.point(v)));
      for (int j = cell(around.min().y(), 1); j <= cell(around.max().y(), 1); ++j)
        for (int i = cell(around.min().x(), 0); i <= cell(around.max().x(), 0); ++i) {
          int& at = start_[static_cast<size_t>(j) * cells_ + i];
          if (counts)
            ++at;
          else
            list_[--at] = t;
        }
    }
    if (!counts) break;
    for (size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    list_.resize(start_.back());
  }
}

int Terrain::cell(double x, int axis) const {
  return static_cast<int>(
      std::clamp(std::floor((x - low_[axis]) / step_[axis]), 0.0, cells_ - 1.0));
}

std::optional<Terrain::SurfacePoint> Terrain::surface_point(const Vec3& p) const {
  const Vec2 q = to_plane(p);
  if (!q.allFinite()) return {};
  const size_t c = static_cast<size_t>(cell(q.y(), 1)) * cells_ + cell(q.x(), 0);
  std::optional<SurfacePoint> highest;
  for (int i = start_[c]; i < start_[c + 1]; ++i) {
    const std::array<int, 3>& corners = mesh_.triangles()[list_[i]];
    Vec2 corner[3];
    for (int j = 0; j < 3; ++j) corner[j] = to_plane(mesh_.point(corners[j])) - q;
    Vec3 L(cross(corner[1], corner[2]), cross(corner[2], corner[0]), cross(corner[0], corner[1]));
    if (L.sum() == 0) continue;
    L /= L.sum();
    if (!(L.minCoeff() >= -1e-12)) continue;  // so that no line falls between two triangles
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
    for (int j = 0; j < 3; ++j) {
      at += L[j] * mesh_.point(corners[j]);
      normal += L[j] * normals_.row(mesh_.topology().node_of(corners[j])).transpose().normalized();
    }
    if (!highest || at.dot(up_) > highest->at.dot(up_))
      highest = SurfacePoint{at, normal.normalized()};
  }
  return highest;
}

}  // namespace batten
