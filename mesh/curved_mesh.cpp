#include "batten/mesh/curved_mesh.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr double kHair = 1e-9;  // of weights

/// Weights without those that rounding or an edge made negative.
Vec3 inside(Vec3 w) {
  w = w.cwiseMax(0);
  return w / w.sum();
}

Vec3 normal_of(const CurvedTriangle::Jet& jet, const Vec3& otherwise) {
  const Vec3 n = jet.u.cross(jet.v);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : otherwise;
}

}  // namespace

/// Where a way to the surface ends in one triangle.
struct CurvedMesh::Foot {
  Found found;
  double distance = 0;
  int out = -1;  // the corner opposite to the edge over which the way leaves
};

CurvedMesh::CurvedMesh(TriangleMesh mesh, std::vector<CurvedTriangle::Corners> normals)
    : mesh_(std::move(mesh)), normals_(std::move(normals)), search_(mesh_) {
  if (normals_.empty()) return;
  if (count_of(normals_) != mesh_.triangle_count())
    throw InputError("normals of " + std::to_string(normals_.size()) + " triangles, expected " +
                     std::to_string(mesh_.triangle_count()));
  constexpr double straight = 1e-12;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const Vec3 flat = mesh_.area_vector(t).normalized();
    const auto& n = normals_[t];
    curved_.push_back(std::any_of(
        n.begin(), n.end(), [&](const Vec3& corner) { return (corner - flat).norm() > straight; }));
  }
}

CurvedTriangle CurvedMesh::triangle(int t) const {
  const auto& [a, b, c] = mesh_.triangles()[t];
  const Vec3 flat = mesh_.area_vector(t).normalized();
  return {{mesh_.point(a), mesh_.point(b), mesh_.point(c)},
          curved(t) ? normals_[t] : CurvedTriangle::Corners{flat, flat, flat}};
}

bool CurvedMesh::at_rim(int t, const Vec3& weights) const {
  for (int corner = 0; corner < 3; ++corner)
    if (weights[corner] < kHair && mesh_.topology().across(t, corner) < 0) return true;
  return false;
}

CurvedMesh::Foot CurvedMesh::foot(int t, const Vec3& p, Vec3 w) const {
  const CurvedTriangle surface = triangle(t);
  constexpr int most_steps = 12;
  constexpr double longest = 0.5, outside = -0.5, settled = 1e-12;  // of weights
  for (int step = 0; step < most_steps; ++step) {
    const auto jet = surface.jet(w);
    const Vec3 miss = jet.x - p;
    const Vec2 slope(jet.u.dot(miss), jet.v.dot(miss));
    Mat2 flat, H;
    flat << jet.u.dot(jet.u), jet.u.dot(jet.v), jet.u.dot(jet.v), jet.v.dot(jet.v);
    H << jet.uu.dot(miss), jet.uv.dot(miss), jet.uv.dot(miss), jet.vv.dot(miss);
    H += flat;
    // Beyond the centre of curvature the way there is longest: Gauss and Newton's step leads down.
    if (!(H.determinant() > 1e-3 * flat.determinant() && H.trace() > 0)) H = flat;
    if (!(H.determinant() > 0)) break;
    Vec2 move = -(H.inverse() * slope);
    if (move.norm() > longest) move *= longest / move.norm();
    w += Vec3(-move.sum(), move[0], move[1]);
    if (w.minCoeff() < outside || move.norm() < settled) break;
  }
  int out = 0;
  if (w.minCoeff(&out) < -kHair) return foot_on_edge(t, out, p, w);
  Foot foot;
  w = inside(w);
  const auto jet = surface.jet(w);
  foot.found = {t, w, jet.x, normal_of(jet, mesh_.area_vector(t).normalized()), at_rim(t, w)};
  foot.distance = (jet.x - p).norm();
  return foot;
}

CurvedMesh::Foot CurvedMesh::foot_on_edge(int t, int corner, const Vec3& p, Vec3 w) const {
  const CurvedTriangle surface = triangle(t);
  const int from = (corner + 1) % 3, to = (corner + 2) % 3;
  w[corner] = 0;
  w = inside(w);
  constexpr int most_steps = 12;
  constexpr double settled = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const auto jet = surface.jet(w);
    Vec3 way = Vec3::Zero();
    way[from] = -1;
    way[to] = 1;
    const Vec3 tangent = way[1] * jet.u + way[2] * jet.v, miss = jet.x - p;
    const Vec3 bend =
        way[1] * way[1] * jet.uu + 2 * way[1] * way[2] * jet.uv + way[2] * way[2] * jet.vv;
    double H = tangent.squaredNorm() + bend.dot(miss);
    if (!(H > 1e-3 * tangent.squaredNorm())) H = tangent.squaredNorm();
    if (!(H > 0)) break;
    const double at = std::clamp(w[to] - tangent.dot(miss) / H, 0.0, 1.0);
    const double move = std::abs(at - w[to]);
    w[to] = at;
    w[from] = 1 - at;
    if (move < settled) break;
  }
  Foot foot;
  const auto jet = surface.jet(w);
  foot.found = {t, w, jet.x, normal_of(jet, mesh_.area_vector(t).normalized()), at_rim(t, w)};
  foot.distance = (jet.x - p).norm();
  foot.out = corner;
  return foot;
}

std::optional<CurvedMesh::Found> CurvedMesh::nearest(const Vec3& p,
                                                     const std::optional<Vec3>& side) const {
  const auto first = search_.nearest(p, side);
  if (!first) return {};
  if (normals_.empty())
    return Found{first->triangle, first->weights, first->at,
                 mesh_.area_vector(first->triangle).normalized(),
                 at_rim(first->triangle, first->weights)};
  constexpr size_t most_triangles = 8;
  std::vector<int> seen;
  int t = first->triangle;
  Vec3 weights = first->weights;
  std::optional<Foot> best;
  while (seen.size() < most_triangles) {
    seen.push_back(t);
    const Foot here = foot(t, p, weights);
    if (best && side && !(here.found.normal.dot(*side) > 0)) break;
    if (!best || here.distance < best->distance) best = here;
    if (here.out < 0) break;
    const int next = mesh_.topology().across(t, here.out);
    if (next < 0 || std::find(seen.begin(), seen.end(), next) != seen.end()) break;
    Vec3 there = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        if (mesh_.triangles()[t][c] == mesh_.triangles()[next][d]) there[d] = here.found.weights[c];
    if (!(there.sum() > 0)) there.setConstant(1.0 / 3);
    t = next;
    weights = there;
  }
  return best->found;
}

}  // namespace batten
