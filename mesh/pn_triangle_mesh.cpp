// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/pn_triangle_mesh.h"

#include <algorithm>
#include <cmath>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

constexpr double kWeightTolerance = 1e-9;  // tolerance on barycentric coordinates

/// Barycentric coordinates with negative entries (rounding, or beyond an edge) set to 0, and
/// rescaled to sum 1.
Vec3 clamped_to_triangle(Vec3 w) {
  w = w.cwiseMax(0);
  return w / w.sum();
}

Vec3 normal_of(const PnTriangle::Jet& jet, const Vec3& otherwise) {
  const Vec3 n = jet.u.cross(jet.v);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : otherwise;
}

}  // namespace

/// Result of the closest-point iteration in one triangle.
struct PnTriangleMesh::FootPoint {
  ClosestPoint found;
  double distance = 0;
  int exit_corner = -1;  // corner opposite to the edge through which the iteration left; -1: it
                         // stayed inside
};

PnTriangleMesh::PnTriangleMesh(TriangleMesh mesh, std::vector<PnTriangle::Corners> normals)
    : mesh_(std::move(mesh)), normals_(std::move(normals)), search_(mesh_) {
  if (normals_.empty()) return;
  if (isize(normals_) != mesh_.triangle_count())
    throw InputError("found normals of " + std::to_string(normals_.size()) +
                     " triangles, expected " + std::to_string(mesh_.triangle_count()));
  constexpr double straight = 1e-12;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const Vec3 flat = mesh_.area_vector(t).normalized();
    const auto& n = normals_[t];
    curved_.push_back(std::any_of(
        n.begin(), n.end(), [&](const Vec3& corner) { return (corner - flat).norm() > straight; }));
  }
}

PnTriangle PnTriangleMesh::triangle(int t) const {
  const auto& [a, b, c] = mesh_.triangles()[t];
  const Vec3 flat = mesh_.area_vector(t).normalized();
  return {{mesh_.point(a), mesh_.point(b), mesh_.point(c)},
          curved(t) ? normals_[t] : PnTriangle::Corners{flat, flat, flat}};
}

bool PnTriangleMesh::on_boundary(int t, const Vec3& weights) const {
  for (int corner = 0; corner < 3; ++corner)
    if (weights[corner] < kWeightTolerance && mesh_.topology().across(t, corner) < 0) return true;
  return false;
}

PnTriangleMesh::FootPoint PnTriangleMesh::foot_point(int t, const Vec3& p, Vec3 w) const {
  const PnTriangle surface = triangle(t);
  constexpr int most_steps = 12;
  // Limits in barycentric coordinates.
  constexpr double longest = 0.5, outside = -0.5, step_tolerance = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const auto jet = surface.jet(w);
    const Vec3 miss = jet.x - p;
    const Vec2 slope(jet.u.dot(miss), jet.v.dot(miss));
    Mat2 flat, H;
    flat << jet.u.dot(jet.u), jet.u.dot(jet.v), jet.u.dot(jet.v), jet.v.dot(jet.v);
    H << jet.uu.dot(miss), jet.uv.dot(miss), jet.uv.dot(miss), jet.vv.dot(miss);
    H += flat;
    // Beyond the centre of curvature the Hessian is not positive definite: use the Gauss-Newton
    // step, which still descends.
    if (!(H.determinant() > 1e-3 * flat.determinant() && H.trace() > 0)) H = flat;
    if (!(H.determinant() > 0)) break;
    Vec2 move = -(H.inverse() * slope);
    if (move.norm() > longest) move *= longest / move.norm();
    w += Vec3(-move.sum(), move[0], move[1]);
    if (w.minCoeff() < outside || move.norm() < step_tolerance) break;
  }
  int exit_corner = 0;
  if (w.minCoeff(&exit_corner) < -kWeightTolerance) return foot_point_on_edge(t, exit_corner, p, w);
  FootPoint foot_point;
  w = clamped_to_triangle(w);
  const auto jet = surface.jet(w);
  foot_point.found = {t, w, jet.x, normal_of(jet, mesh_.area_vector(t).normalized()),
                      on_boundary(t, w)};
  foot_point.distance = (jet.x - p).norm();
  return foot_point;
}

PnTriangleMesh::FootPoint PnTriangleMesh::foot_point_on_edge(int t, int corner, const Vec3& p,
                                                             Vec3 w) const {
  const PnTriangle surface = triangle(t);
  const int from = (corner + 1) % 3, to = (corner + 2) % 3;
  w[corner] = 0;
  w = clamped_to_triangle(w);
  constexpr int most_steps = 12;
  constexpr double step_tolerance = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const auto jet = surface.jet(w);
    Vec3 direction = Vec3::Zero();
    direction[from] = -1;
    direction[to] = 1;
    const Vec3 tangent = direction[1] * jet.u + direction[2] * jet.v, miss = jet.x - p;
    const Vec3 bend = direction[1] * direction[1] * jet.uu +
                      2 * direction[1] * direction[2] * jet.uv +
                      direction[2] * direction[2] * jet.vv;
    double H = tangent.squaredNorm() + bend.dot(miss);
    if (!(H > 1e-3 * tangent.squaredNorm())) H = tangent.squaredNorm();
    if (!(H > 0)) break;
    const double at = std::clamp(w[to] - tangent.dot(miss) / H, 0.0, 1.0);
    const double move = std::abs(at - w[to]);
    w[to] = at;
    w[from] = 1 - at;
    if (move < step_tolerance) break;
  }
  FootPoint foot_point;
  const auto jet = surface.jet(w);
  foot_point.found = {t, w, jet.x, normal_of(jet, mesh_.area_vector(t).normalized()),
                      on_boundary(t, w)};
  foot_point.distance = (jet.x - p).norm();
  foot_point.exit_corner = corner;
  return foot_point;
}

std::optional<PnTriangleMesh::ClosestPoint> PnTriangleMesh::nearest(
    const Vec3& p, const std::optional<Vec3>& side) const {
  const auto first = search_.nearest(p, side);
  if (!first) return {};
  if (normals_.empty())
    return ClosestPoint{first->triangle, first->weights, first->at,
                        mesh_.area_vector(first->triangle).normalized(),
                        on_boundary(first->triangle, first->weights)};
  constexpr size_t max_triangles = 8;
  std::vector<int> seen;
  int t = first->triangle;
  Vec3 weights = first->weights;
  std::optional<FootPoint> best;
  while (seen.size() < max_triangles) {
    seen.push_back(t);
    const FootPoint here = foot_point(t, p, weights);
    if (best && side && !(here.found.normal.dot(*side) > 0)) break;
    if (!best || here.distance < best->distance) best = here;
    if (here.exit_corner < 0) break;
    const int next = mesh_.topology().across(t, here.exit_corner);
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

PnTriangle::PnTriangle(const Corners& points, const Corners& normals) {
  Vec3 edges = Vec3::Zero(), middle = Vec3::Zero();
  for (size_t c = 0; c < 3; ++c) b_[c] = points[c];
  for (size_t c = 0; c < 3; ++c) {
    const size_t d = (c + 1) % 3;
    const Vec3 &p = points[c], &q = points[d];
    b_[3 + 2 * c] = (2 * p + q - (q - p).dot(normals[c]) * normals[c]) / 3;
    b_[4 + 2 * c] = (2 * q + p - (p - q).dot(normals[d]) * normals[d]) / 3;
    edges += (b_[3 + 2 * c] + b_[4 + 2 * c]) / 6;
    middle += p / 3;
  }
  b_[9] = edges + (edges - middle) / 2;
}

PnTriangle::Jet PnTriangle::jet(const Vec3& w) const {
  const auto mean = [&w](const Vec3& a, const Vec3& b, const Vec3& c) -> Vec3 {
    return w[0] * a + w[1] * b + w[2] * c;
  };
  // De Casteljau's algorithm: control points of the three quadratics, then of the tangent plane.
  const Vec3 r00 = mean(b_[0], b_[3], b_[8]), r11 = mean(b_[4], b_[1], b_[5]),
             r22 = mean(b_[7], b_[6], b_[2]), r01 = mean(b_[3], b_[4], b_[9]),
             r12 = mean(b_[9], b_[5], b_[6]), r02 = mean(b_[8], b_[9], b_[7]);
  const Vec3 q0 = mean(r00, r01, r02), q1 = mean(r01, r11, r12), q2 = mean(r02, r12, r22);
  Jet jet;
  jet.x = mean(q0, q1, q2);
  jet.u = 3 * (q1 - q0);
  jet.v = 3 * (q2 - q0);
  jet.uu = 6 * (r11 - 2 * r01 + r00);
  jet.vv = 6 * (r22 - 2 * r02 + r00);
  jet.uv = 6 * (r12 - r01 - r02 + r00);
  return jet;
}

namespace {

SparseMatrix positive_laplacian(const TriangleMesh& mesh) {
  constexpr double least = 0.01, most = 100;
  const auto& edges = mesh.topology().edges();
  const std::vector<double> cotangents = edge_cotangents(mesh);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t e = 0; e < edges.size(); ++e) {
    // A triangle of zero area has no cotangent; the comparison then fails and `least` is used.
    const double w = cotangents[e] > least ? std::min(cotangents[e], most) : least;
    entries.emplace_back(edges[e].low, edges[e].low, w);
    entries.emplace_back(edges[e].high, edges[e].high, w);
    entries.emplace_back(edges[e].high, edges[e].low, -w);
  }
  SparseMatrix L(mesh.vertex_count(), mesh.vertex_count());
  L.setFromTriplets(entries.begin(), entries.end());
  return L;
}

TriangleMesh laid_flat(const TriangleMesh& mesh,
                       const std::function<Vec2(const Vec3&)>& boundary_parameter) {
  const MeshTopology& topology = mesh.topology();
  if (topology.component_count() != 1)
    throw InputError("flattening: found a surface of " +
                     std::to_string(topology.component_count()) +
                     " unconnected parts, expected one");
  ConstraintSet parameters(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (topology.on_boundary(v)) {
      const Vec2 parameter = boundary_parameter(mesh.point(v));
      parameters.fix("boundary", v, {parameter.x(), parameter.y(), 0});
    } else if (topology.neighbours(v).empty()) {
      parameters.fix("not connected", v, Vec3::Zero());
    }
  }
  if (parameters.constraints().empty())
    throw InputError("flattening: found a closed surface, expected one with free edges");
  return mesh.with_points(solve_constrained(parameters, positive_laplacian(mesh),
                                            Points::Zero(mesh.vertex_count(), 3)));
}

}  // namespace

HarmonicMap::HarmonicMap(const PnTriangleMesh& mesh,
                         const std::function<Vec2(const Vec3&)>& boundary_parameter)
    : mesh_(mesh), flat_(laid_flat(mesh.mesh(), boundary_parameter)), search_(flat_) {}

Vec3 HarmonicMap::surface_point(const Vec2& parameter) const {
  const auto found = search_.nearest({parameter.x(), parameter.y(), 0});
  return mesh_.triangle(found->triangle).at(found->weights);
}

}  // namespace batten
