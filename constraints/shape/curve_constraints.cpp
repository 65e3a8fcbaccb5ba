#include "batten/constraints/shape/curve_constraints.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/hermite_segment.h"

namespace batten {
namespace {

Vec3 unit(const std::string& name, const Vec3& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("constraint '" + name + "': a direction of length " + format_number(length));
  return v / length;
}

}  // namespace

CurveConstraints::CurveConstraints(const CurveMesh& mesh, ConstraintSet& set)
    : mesh_(mesh), set_(set) {
  if (set.dof_count() != mesh.dof_count())
    throw InputError("a constraint set of " + std::to_string(set.dof_count()) +
                     " dofs for a curve of " + std::to_string(mesh.dof_count()));
}

void CurveConstraints::uncoupled(const std::string& name, double u, int order, const Vec3& value) {
  const auto at = mesh_.locate(u);
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, order);
  const auto dof = mesh_.segment_dofs(at.segment);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 4; ++a)
    if (H[a] != 0) entries.push_back({dof[a], H[a]});
  set_.add(name, std::move(entries), value);
}

void CurveConstraints::point(const std::string& name, double u, const Vec3& position) {
  uncoupled(name, u, 0, position);
}

void CurveConstraints::derivative(const std::string& name, double u, const Vec3& derivative) {
  uncoupled(name, u, 1, derivative);
}

void CurveConstraints::zero_curvature(const std::string& name, double u) {
  uncoupled(name, u, 2, Vec3::Zero());
}

void CurveConstraints::direction(const std::string& name, double u, const Vec3& tau) {
  const Vec3 t = unit(name, tau);
  const auto at = mesh_.locate(u);
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, 1);
  const auto dof = mesh_.segment_dofs(at.segment);
  const Vec3 r = t.unitOrthogonal();
  for (const Vec3& across : {r, Vec3(t.cross(r))}) {
    std::vector<ConstraintSet::CoupledEntry> entries;
    for (int a = 0; a < 4; ++a)
      if (H[a] != 0) entries.push_back({dof[a], H[a] * across});
    set_.add_coupled(name, std::move(entries), 0);
  }
}

void CurveConstraints::in_plane(const std::string& name, const Vec3& through, const Vec3& normal) {
  const Vec3 n = unit(name, normal);
  for (int node = 0; node < mesh_.node_count(); ++node) {
    set_.add_coupled(name, {{mesh_.position_dof(node), n}}, n.dot(through));
    set_.add_coupled(name, {{mesh_.slope_out(node), n}}, 0);
    if (mesh_.is_corner(node)) set_.add_coupled(name, {{mesh_.slope_in(node), n}}, 0);
  }
}

void CurveConstraints::symmetric(const std::string& name, const Vec3& through, const Vec3& normal) {
  const Vec3 n = unit(name, normal);
  const double d = n.dot(through), whole = mesh_.end() - mesh_.start();
  const int count = mesh_.node_count();
  const auto image = [&](int node) {
    return mesh_.closed() ? (count - node) % count : count - 1 - node;
  };
  for (int i = 0; i < count; ++i) {
    const int j = image(i);
    const double mirrored =
        mesh_.closed() && i == 0 ? 0 : whole - (mesh_.parameters()[j] - mesh_.start());
    if (std::abs(mesh_.parameters()[i] - mesh_.start() - mirrored) > 1e-9 * whole ||
        mesh_.is_corner(i) != mesh_.is_corner(j))
      throw InputError("constraint '" + name + "': node " + std::to_string(i) +
                       " of the curve has no mirror image");
  }
  const Mat3 R = Mat3::Identity() - 2 * n * n.transpose();
  // a = sign R b + offset
  const auto pair = [&](int a, int b, double sign, const Vec3& offset) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = Vec3::Unit(axis);
      set_.add_coupled(name, {{a, e}, {b, -sign * (R * e)}}, e.dot(offset));
    }
  };
  for (int i = 0; i < count; ++i) {
    const int j = image(i);
    if (i < j) {
      pair(mesh_.position_dof(i), mesh_.position_dof(j), 1, 2 * d * n);
      pair(mesh_.slope_out(i), mesh_.slope_in(j), -1, Vec3::Zero());
      if (mesh_.is_corner(i)) pair(mesh_.slope_in(i), mesh_.slope_out(j), -1, Vec3::Zero());
    } else if (i == j) {
      set_.add_coupled(name, {{mesh_.position_dof(i), n}}, d);
      if (mesh_.is_corner(i)) {
        pair(mesh_.slope_in(i), mesh_.slope_out(i), -1, Vec3::Zero());
      } else {
        const Vec3 r = n.unitOrthogonal();
        set_.add_coupled(name, {{mesh_.slope_out(i), r}}, 0);
        set_.add_coupled(name, {{mesh_.slope_out(i), n.cross(r)}}, 0);
      }
    }
  }
}

}  // namespace batten
