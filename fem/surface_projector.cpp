// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface_projector.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "batten/core/cancellation.h"
#include "batten/elements/bernstein_cubics.h"
#include "batten/elements/c1_triangle.h"

namespace batten {

SurfaceProjector::SurfaceProjector(const Surface& surface)
    : surface_(surface), locator_(surface.mesh()) {
  const ParametricMesh& mesh = surface.mesh();
  std::vector<char> seen(mesh.vertex_count(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<16384>(t);
    for (int i = 0; i < 3; ++i)
      if (!seen[mesh.triangles()[t][i]]++) where_.push_back({t, Vec3::Unit(i)});
    where_.push_back({t, Vec3::Constant(1.0 / 3)});
  }
  samples_.resize(static_cast<long>(where_.size()), 3);
  for (long i = 0; i < samples_.rows(); ++i) {
    poll_every<4096>(i);
    samples_.row(i) = surface.position(where_[i]);
  }
}

Surface::ClosestPoint SurfaceProjector::nearest(const Vec3& p) const {
  long best = 0;
  (samples_.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&best);
  return nearest(p, where_[best]);
}

Surface::ClosestPoint SurfaceProjector::nearest(const Vec3& p, const Location& start) const {
  const ParametricMesh& mesh = surface_.mesh();
  Location where = start;
  double distance = (surface_.position(where) - p).norm();
  for (int step = 0; step < 60; ++step) {
    const SurfaceJet jet = surface_.jet(where);
    const Vec3 d = jet.x - p;
    Mat2 G, H;
    G << jet.x_u.dot(jet.x_u), jet.x_u.dot(jet.x_v), jet.x_u.dot(jet.x_v), jet.x_v.dot(jet.x_v);
    H << jet.x_uu.dot(d), jet.x_uv.dot(d), jet.x_uv.dot(d), jet.x_vv.dot(d);
    H += G;
    // Newton step if the distance is convex, otherwise a Gauss-Newton step.
    const bool convex = H(0, 0) > 0 && H.determinant() > 1e-2 * G.determinant();
    const Vec2 move = -(convex ? H : G).ldlt().solve(Vec2(jet.x_u.dot(d), jet.x_v.dot(d)));
    if (!move.allFinite()) break;
    const Vec2 uv = mesh.shape(where.triangle).point(where.L);
    // A step that increases the distance is halved; at the boundary of the mesh it ends on the
    // boundary.
    double moved = 0;
    for (double part = 1; part > 1e-3; part *= 0.5) {
      const Location next = locator_.locate(uv + part * move);
      const double reached = (surface_.position(next) - p).norm();
      if (reached > distance) continue;
      moved = (mesh.shape(next.triangle).point(next.L) - uv).norm();
      where = next;
      distance = reached;
      break;
    }
    if (moved < 1e-12 * (1 + uv.norm())) break;
  }
  return {where, distance};
}

SurfaceEvaluator::SurfaceEvaluator(Surface surface)
    : surface_(std::move(surface)), locator_(surface_.mesh()) {
  if (surface_.kind() != TriangleElement::HCT) return;
  cubics_.reserve(3 * static_cast<size_t>(surface_.mesh().triangle_count()));
  for (int t = 0; t < surface_.mesh().triangle_count(); ++t) {
    poll_every<2048>(t);
    const C1Triangle element(surface_.kind(), surface_.mesh().shape(t));
    for (int sub = 0; sub < 3; ++sub)
      cubics_.emplace_back(element.bezier(sub, surface_.triangle_dofs(t)).transpose());
  }
}

Vec3 SurfaceEvaluator::position(const Location& where) const {
  if (cubics_.empty()) return surface_.position(where);
  const HctSubtriangle at(where.L);
  return cubics_[3 * static_cast<size_t>(where.triangle) + at.sub].lazyProduct(
      bernstein_cubics(at.local));
}

}  // namespace batten
