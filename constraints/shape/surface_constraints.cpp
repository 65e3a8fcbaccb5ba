#include "batten/constraints/shape/surface_constraints.h"

#include <Eigen/Geometry>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

Vec3 unit(const std::string& name, const char* what, const Vec3& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("constraint '" + name + "': the " + what + " has no direction");
  return v / length;
}

}  // namespace

SurfaceConstraints::SurfaceConstraints(const ParametricMesh& mesh, TriangleElement kind,
                                       ConstraintSet& set)
    : mesh_(mesh), kind_(kind), set_(set), dofs_(mesh) {
  if (set.dof_count() != dofs_.count())
    throw InputError("constraints on " + std::to_string(set.dof_count()) +
                     " dofs for a mesh with " + std::to_string(dofs_.count()));
}

void SurfaceConstraints::point(const std::string& name, int vertex, const Vec3& position) {
  set_.fix(name, dofs_.vertex(vertex), position);
}

void SurfaceConstraints::point(const std::string& name, const Location& where,
                               const Vec3& position) {
  const Vec12 N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L).col(kW);
  const auto dof = dofs_.triangle(mesh_, where.triangle);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 12; ++a)
    if (N[a] != 0) entries.push_back({dof[a], N[a]});
  set_.add(name, std::move(entries), position);
}

void SurfaceConstraints::tangent(const std::string& name, int vertex, const Vec2& s,
                                 const Vec3& tau) {
  const Vec3 direction = unit(name, "tangent", tau);
  if (!(s.norm() > 0)) throw InputError("constraint '" + name + "': no parametric direction");
  const Vec2 p = s.normalized();
  const Vec3 r1 = direction.unitOrthogonal(), r2 = direction.cross(r1);
  for (const Vec3& r : {r1, r2})
    set_.add_coupled(
        name, {{dofs_.vertex(vertex, 1), p.x() * r}, {dofs_.vertex(vertex, 2), p.y() * r}}, 0);
}

void SurfaceConstraints::normal(const std::string& name, int vertex, const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  set_.add_coupled(name, {{dofs_.vertex(vertex, 1), direction}}, 0);
  set_.add_coupled(name, {{dofs_.vertex(vertex, 2), direction}}, 0);
}

void SurfaceConstraints::add_slope_constraint(const std::string& name, const Location& where,
                                              const Vec2& s, const Vec3& r) {
  const Tabulation N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L);
  const auto dof = dofs_.triangle(mesh_, where.triangle);
  std::vector<ConstraintSet::CoupledEntry> entries;
  for (int a = 0; a < 12; ++a)
    if (const double slope = s.x() * N(a, kU) + s.y() * N(a, kV); slope != 0)
      entries.push_back({dof[a], slope * r});
  set_.add_coupled(name, std::move(entries), 0);
}

void SurfaceConstraints::tangent(const std::string& name, const Location& where, const Vec2& s,
                                 const Vec3& tau) {
  const Vec3 direction = unit(name, "tangent", tau);
  if (!(s.norm() > 0)) throw InputError("constraint '" + name + "': no parametric direction");
  const Vec3 r1 = direction.unitOrthogonal(), r2 = direction.cross(r1);
  for (const Vec3& r : {r1, r2}) add_slope_constraint(name, where, s.normalized(), r);
}

void SurfaceConstraints::normal(const std::string& name, const Location& where, const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  add_slope_constraint(name, where, Vec2::UnitX(), direction);
  add_slope_constraint(name, where, Vec2::UnitY(), direction);
}

void SurfaceConstraints::curve(const std::string& name, const std::vector<int>& vertices,
                               const std::vector<double>& parameters, const HermiteCurve& curve,
                               const Vec2& direction) {
  if (vertices.size() != parameters.size() || vertices.size() < 2)
    throw InputError("constraint '" + name + "': " + std::to_string(vertices.size()) +
                     " vertices and " + std::to_string(parameters.size()) + " parameters");
  const Vec2 t = direction.normalized();
  const double run = mesh_.chain_vector(vertices).dot(t);
  const double speed = (parameters.back() - parameters.front()) / run;
  const bool around = vertices.front() == vertices.back();
  for (size_t i = 0; i + around < vertices.size(); ++i) {
    const int v = vertices[i];
    set_.fix(name, dofs_.vertex(v), curve.evaluate(parameters[i]));
    set_.add(name, {{dofs_.vertex(v, 1), t.x()}, {dofs_.vertex(v, 2), t.y()}},
             speed * curve.evaluate(parameters[i], 1));
  }
}

void SurfaceConstraints::constant_normal(const std::string& name, const std::vector<int>& edges,
                                         const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  for (const int e : edges) {
    const auto& edge = mesh_.edges()[e];
    set_.add_coupled(
        name, {{dofs_.vertex(edge.high), direction}, {dofs_.vertex(edge.low), -direction}}, 0);
    for (const int v : {edge.low, edge.high}) normal(name, v, n);
    set_.add_coupled(name, {{dofs_.edge(e), direction}}, 0);
  }
}

void SurfaceConstraints::varying_normal(const std::string& name, const std::vector<int>& edges,
                                        const std::function<Vec3(int, double)>& n,
                                        bool edge_curve_is_fixed) {
  for (const int e : edges) {
    const auto& edge = mesh_.edges()[e];
    const Vec2 t = mesh_.edge_tangent(e), nu = mesh_.edge_normal(e);
    const double length = mesh_.edge_length(e);
    for (const auto& [v, s] : {std::pair(edge.low, 0.0), std::pair(edge.high, 1.0)}) {
      const Vec3 direction = unit(name, "normal", n(e, s));
      for (const Vec2& d : edge_curve_is_fixed ? std::vector<Vec2>{nu} : std::vector<Vec2>{nu, t})
        set_.add_coupled(
            name,
            {{dofs_.vertex(v, 1), d.x() * direction}, {dofs_.vertex(v, 2), d.y() * direction}}, 0);
    }
    const Vec3 middle = unit(name, "normal", n(e, 0.5));
    set_.add_coupled(name, {{dofs_.edge(e), middle}}, 0);
    if (edge_curve_is_fixed) continue;
    // Tangential slope at the middle of the cubic: 3/2 (w_b - w_a)/length - (w_t,a + w_t,b)/4.
    std::vector<ConstraintSet::CoupledEntry> row = {
        {dofs_.vertex(edge.high), 1.5 / length * middle},
        {dofs_.vertex(edge.low), -1.5 / length * middle}};
    for (const int v : {edge.low, edge.high})
      for (int d = 0; d < 2; ++d) row.push_back({dofs_.vertex(v, 1 + d), -0.25 * t[d] * middle});
    set_.add_coupled(name, std::move(row), 0);
  }
}

}  // namespace batten
