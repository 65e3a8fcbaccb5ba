// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/stiffeners.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "batten/analysis/models/line_sides.h"
#include "batten/core/cancellation.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void require_positive(const std::string& what, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError("stiffener: found " + what + " = " + format_number(value) +
                     ", expected a number above 0");
}

double cube(double x) { return x * x * x; }

}  // namespace

StiffenerSection StiffenerSection::rectangle(double width, double height) {
  require_positive("width", width);
  require_positive("height", height);
  StiffenerSection s;
  s.area = width * height;
  s.inertia = width * cube(height) / 12;
  s.lateral_inertia = height * cube(width) / 12;
  const double a = std::max(width, height), b = std::min(width, height), r = b / a;
  s.torsion = a * cube(b) * (1.0 / 3 - 0.21 * r * (1 - r * r * r * r / 12));
  s.foot = height / 2;
  for (const double z : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) s.fibres.emplace_back(z * height, y * width);
  return s;
}

StiffenerSection StiffenerSection::circle(double radius) { return tube(radius, radius); }

StiffenerSection StiffenerSection::tube(double radius, double wall) {
  require_positive("radius", radius);
  require_positive("wall", wall);
  if (wall > radius)
    throw InputError("stiffener: found wall = " + format_number(wall) +
                     ", expected at most the radius");
  const double inner = radius - wall, pi = std::numbers::pi;
  StiffenerSection s;
  s.area = pi * (radius * radius - inner * inner);
  s.inertia = s.lateral_inertia = pi / 4 * (std::pow(radius, 4) - std::pow(inner, 4));
  s.torsion = 2 * s.inertia;
  s.foot = radius;
  constexpr int around = 8;
  for (int k = 0; k < around; ++k)
    s.fibres.emplace_back(radius * std::sin(2 * pi * k / around),
                          radius * std::cos(2 * pi * k / around));
  return s;
}

StiffenerSection StiffenerSection::tee(double web_height, double web_thickness, double flange_width,
                                       double flange_thickness) {
  require_positive("height of the web", web_height);
  require_positive("thickness of the web", web_thickness);
  require_positive("width of the flange", flange_width);
  require_positive("thickness of the flange", flange_thickness);
  const double web = web_height * web_thickness, flange = flange_width * flange_thickness,
               top = web_height + flange_thickness;
  StiffenerSection s;
  s.area = web + flange;
  s.foot = (web * web_height / 2 + flange * (web_height + flange_thickness / 2)) / s.area;
  s.inertia = web_thickness * cube(web_height) / 12 + web * std::pow(s.foot - web_height / 2, 2) +
              flange_width * cube(flange_thickness) / 12 +
              flange * std::pow(web_height + flange_thickness / 2 - s.foot, 2);
  s.lateral_inertia =
      web_height * cube(web_thickness) / 12 + flange_thickness * cube(flange_width) / 12;
  s.torsion = (web_height * cube(web_thickness) + flange_width * cube(flange_thickness)) / 3;
  for (const double y : {-0.5, 0.5}) {
    s.fibres.emplace_back(-s.foot, y * web_thickness);
    s.fibres.emplace_back(top - s.foot, y * flange_width);
    s.fibres.emplace_back(web_height - s.foot, y * flange_width);
  }
  return s;
}

StiffenerSection StiffenerSection::on_side(double side, double surface) const {
  StiffenerSection s = *this;
  s.eccentricity = surface + side * foot;
  for (Vec2& fibre : s.fibres) fibre.x() *= side;
  return s;
}

namespace {

void require_stiffener(const Stiffener& stiffener) {
  const StiffenerSection& s = stiffener.section;
  const auto check = [&](const char* what, double value, bool may_vanish) {
    if (!(may_vanish ? value >= 0 : value > 0) || !std::isfinite(value))
      throw InputError("stiffener '" + stiffener.name + "': found " + what + " = " +
                       format_number(value) + ", expected a number " +
                       (may_vanish ? "of 0 or more" : "above 0"));
  };
  check("young", s.young, false);
  check("shear modulus", s.shear_modulus, false);
  check("area", s.area, false);
  check("inertia", s.inertia, true);
  check("lateral inertia", s.lateral_inertia, true);
  check("torsion", s.torsion, true);
  check("density", s.density, true);
  if (!std::isfinite(s.eccentricity) || !std::isfinite(s.expansion))
    throw InputError("stiffener '" + stiffener.name +
                     "': found an eccentricity or an expansion that is not finite");
}

/// A linear form of the displacement: Σ_k column(k) · ∂_k U, with the derivatives of Tabulation.
using Form = Eigen::Matrix<double, 3, kDerivatives>;

/// The surface and the derivatives of a curve on it at a point. t: parameter of the curve.
class StiffenerFrame {
 public:
  /// `velocity`, `acceleration`: first and second derivatives of (u, v) with respect to t.
  StiffenerFrame(const SurfaceJet& jet, const Vec2& velocity, const Vec2& acceleration)
      : p_(velocity), pp_(acceleration) {
    const Vec3 area = jet.area_vector();
    n = area.normalized();
    const Vec3 x_ut = p_.x() * jet.x_uu + p_.y() * jet.x_uv,
               x_vt = p_.x() * jet.x_uv + p_.y() * jet.x_vv;
    x_t = p_.x() * jet.x_u + p_.y() * jet.x_v;
    x_tt = p_.x() * x_ut + p_.y() * x_vt + pp_.x() * jet.x_u + pp_.y() * jet.x_v;
    Mat3 frame, rate;
    frame << jet.x_u, jet.x_v, n;
    const Mat3 inverse = frame.inverse();
    n_t = -n.dot(x_ut) * inverse.row(0).transpose() - n.dot(x_vt) * inverse.row(1).transpose();
    rate << x_ut, x_vt, n_t;
    const Mat3 inverse_rate = -inverse * rate * inverse;
    for (int a = 0; a < 2; ++a) {
      dual_[a] = inverse.row(a).transpose();
      dual_t_[a] = inverse_rate.row(a).transpose();
    }
    const double speed = x_t.norm();
    tau = x_t / speed;
    b = n.cross(tau);
    const Vec3 tau_t = (x_tt - x_tt.dot(tau) * tau) / speed;
    b_t = n_t.cross(tau) + n.cross(tau_t);
  }

  // w · U_t and w · U_tt.
  Form slope(const Vec3& w) const {
    Form form = Form::Zero();
    form.col(kU) = p_.x() * w;
    form.col(kV) = p_.y() * w;
    return form;
  }
  Form second(const Vec3& w) const {
    Form form = Form::Zero();
    form.col(kU) = pp_.x() * w;
    form.col(kV) = pp_.y() * w;
    form.col(kUU) = p_.x() * p_.x() * w;
    form.col(kUV) = 2 * p_.x() * p_.y() * w;
    form.col(kVV) = p_.y() * p_.y() * w;
    return form;
  }
  // w · g and w · g_t for the change g of the normal: g = -Σ_α (n · U_α) a^α.
  Form normal(const Vec3& w) const {
    Form form = Form::Zero();
    form.col(kU) = -w.dot(dual_[0]) * n;
    form.col(kV) = -w.dot(dual_[1]) * n;
    return form;
  }
  Form normal_rate(const Vec3& w) const {
    const double wu = w.dot(dual_[0]), wv = w.dot(dual_[1]);
    Form form = Form::Zero();
    form.col(kU) = -wu * n_t - w.dot(dual_t_[0]) * n;
    form.col(kV) = -wv * n_t - w.dot(dual_t_[1]) * n;
    form.col(kUU) = -wu * p_.x() * n;
    form.col(kUV) = -(wu * p_.y() + wv * p_.x()) * n;
    form.col(kVV) = -wv * p_.y() * n;
    return form;
  }
  // The rotation of the tangent about the normal, b · U_t/|x_t|, and its derivative.
  Form drill() const { return slope(b) / x_t.norm(); }
  Form drill_rate() const {
    const double speed = x_t.norm();
    return (slope(b_t) + second(b)) / speed - slope(b) * x_tt.dot(tau) / (speed * speed);
  }
  // w · φ_t for the rotation φ = n × g + drill n.
  Form rotation_rate(const Vec3& w) const {
    return normal(w.cross(n_t)) + normal_rate(w.cross(n)) + w.dot(n) * drill_rate() +
           w.dot(n_t) * drill();
  }

  Vec3 n, n_t, x_t, x_tt, tau, b, b_t;

 private:
  Vec2 p_, pp_;
  Vec3 dual_[2], dual_t_[2];
};

}  // namespace

Stiffeners::Stiffeners(const ModelLayout& model, const Points& shape,
                       std::vector<Stiffener> stiffeners)
    : dof_count_(shape.rows()), stiffeners_(std::move(stiffeners)) {
  if (stiffeners_.empty()) return;
  LineSides sides(model);
  const ParametricMesh& mesh = *model.mesh();
  const Surface surface = model.surface(shape);
  for (size_t k = 0; k < stiffeners_.size(); ++k) {
    require_stiffener(stiffeners_[k]);
    const ModelLine& line = model.model_line(stiffeners_[k].line);
    const JoinEdge side = sides(line);
    const int first = model.first_triangle(line.sides[0].region);
    for_each_line_point(side, side, [&](double f, double dl) {
      poll_every<1024>(static_cast<long>(points_.size()));
      Location where = side.where(f);
      where.triangle += first;
      const SurfaceJet jet = surface.jet(where);
      const StiffenerFrame at(jet, side.along_uv(f), side.along_uv_rate(f));
      const double e = stiffeners_[k].section.eccentricity;
      const Vec3 along = at.x_t + e * at.n_t;  // of the centroid line
      const double speed = along.norm();
      constexpr double singular = 1e-9;
      if (!along.allFinite() || !(speed > singular * at.x_t.norm()))
        throw InputError("stiffener '" + stiffeners_[k].name +
                         "': its centroid line is singular, because its eccentricity is the radius "
                         "of curvature of the surface");
      const Vec3 tau = along / speed;
      const std::array<Form, kStrains> forms = {
          (at.slope(tau) + e * at.normal_rate(tau)) / speed, at.rotation_rate(at.b) / speed,
          at.rotation_rate(at.n) / speed, at.rotation_rate(at.tau) / speed};
      Point point;
      point.stiffener = static_cast<int>(k);
      point.length = dl * speed / at.x_t.norm();
      point.at = jet.x + e * at.n;
      point.vertices = mesh.triangles()[where.triangle];
      point.L = where.L;
      point.dofs = DofMap(mesh).triangle(mesh, where.triangle);
      const Tabulation N =
          C1Triangle(model.element(), mesh.shape(where.triangle)).evaluate(where.L);
      for (int s = 0; s < kStrains; ++s)
        point.strains[static_cast<size_t>(s)] = N * forms[static_cast<size_t>(s)].transpose();
      point.position = N.col(kW);
      const Vec2 velocity = side.along_uv(f) / speed;
      point.slope = velocity.x() * N.col(kU) + velocity.y() * N.col(kV);
      points_.push_back(std::move(point));
    });
  }
}

double Stiffeners::stiffness(const Point& point, int strain) const {
  const StiffenerSection& s = stiffeners_[static_cast<size_t>(point.stiffener)].section;
  switch (strain) {
    case Axial:
      return s.young * s.area;
    case Bending:
      return s.young * s.inertia;
    case LateralBending:
      return s.young * s.lateral_inertia;
    default:
      return s.shear_modulus * s.torsion;
  }
}

void Stiffeners::add_to(ShellSprings& springs) const {
  for (const Point& point : points_)
    for (int s = 0; s < kStrains; ++s) {
      const double k = stiffness(point, s) * point.length;
      if (k == 0) continue;
      ShellSprings::Entries entries;
      for (int m = 0; m < 12; ++m)
        entries.push_back({point.dofs[static_cast<size_t>(m)],
                           point.strains[static_cast<size_t>(s)].row(m).transpose()});
      springs.add("stiffener " + stiffeners_[static_cast<size_t>(point.stiffener)].name, entries, k,
                  0, ShellSprings::Kind::Stiffener);
    }
}

// Adds 12×12 matrices of the points, block(point), to the lower triangle of a matrix.
template <class Block>
void Stiffeners::add_blocks(const Block& block, SparseMatrix& matrix) const {
  if (points_.empty()) return;
  std::vector<Triplet> entries;
  for (const Point& point : points_) {
    const Mat12 values = block(point);
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j)
        if (const int row = point.dofs[static_cast<size_t>(i)],
            column = point.dofs[static_cast<size_t>(j)];
            row >= column)
          entries.emplace_back(row, column, values(i, j));
  }
  SparseMatrix sum(matrix.rows(), matrix.cols());
  sum.setFromTriplets(entries.begin(), entries.end());
  matrix += sum;
}

void Stiffeners::add_mass(SparseMatrix& M) const {
  add_blocks(
      [&](const Point& point) -> Mat12 {
        const StiffenerSection& s = stiffeners_[static_cast<size_t>(point.stiffener)].section;
        return s.density * s.area * point.length * point.position * point.position.transpose();
      },
      M);
}

double Stiffeners::mass() const {
  double sum = 0;
  for (const Point& point : points_) {
    const StiffenerSection& s = stiffeners_[static_cast<size_t>(point.stiffener)].section;
    sum += s.density * s.area * point.length;
  }
  return sum;
}

Points Stiffeners::body_load(const std::function<Vec3(const Vec3& x)>& acceleration) const {
  Points F = Points::Zero(dof_count_, 3);
  for (const Point& point : points_) {
    const StiffenerSection& s = stiffeners_[static_cast<size_t>(point.stiffener)].section;
    const Vec3 force = s.density * s.area * point.length * acceleration(point.at);
    for (int m = 0; m < 12; ++m)
      F.row(point.dofs[static_cast<size_t>(m)]) += point.position[m] * force.transpose();
  }
  return F;
}

double Stiffeners::temperature_at(const Point& point, const ShellTemperature& temperature) const {
  if (temperature.empty()) return 0;
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    sum += point.L[i] * temperature.middle[point.vertices[static_cast<size_t>(i)]];
  return sum;
}

Points Stiffeners::thermal_load(const ShellTemperature& temperature) const {
  Points F = Points::Zero(dof_count_, 3);
  for (const Point& point : points_) {
    const double prevented = stiffness(point, Axial) * point.length *
                             stiffeners_[static_cast<size_t>(point.stiffener)].section.expansion *
                             temperature_at(point, temperature);
    for (int m = 0; m < 12; ++m)
      F.row(point.dofs[static_cast<size_t>(m)]) += prevented * point.strains[Axial].row(m);
  }
  return F;
}

std::array<double, Stiffeners::kStrains> Stiffeners::strains_at(
    const Point& point, const Points& q, const ShellTemperature& temperature) const {
  std::array<double, kStrains> strains = {};
  for (int s = 0; s < kStrains; ++s)
    for (int m = 0; m < 12; ++m)
      strains[static_cast<size_t>(s)] += point.strains[static_cast<size_t>(s)].row(m).dot(
          q.row(point.dofs[static_cast<size_t>(m)]));
  strains[Axial] -= stiffeners_[static_cast<size_t>(point.stiffener)].section.expansion *
                    temperature_at(point, temperature);
  return strains;
}

void Stiffeners::add_geometric_stiffness(const Points& q, const ShellTemperature& temperature,
                                         SparseMatrix& G) const {
  add_blocks(
      [&](const Point& point) -> Mat12 {
        const double force = stiffness(point, Axial) * strains_at(point, q, temperature)[Axial];
        return force * point.length * point.slope * point.slope.transpose();
      },
      G);
}

double Stiffeners::energy(const Points& q, const ShellTemperature& temperature) const {
  double sum = 0;
  for (const Point& point : points_) {
    const auto strains = strains_at(point, q, temperature);
    for (int s = 0; s < kStrains; ++s)
      sum +=
          0.5 * point.length * stiffness(point, s) * std::pow(strains[static_cast<size_t>(s)], 2);
  }
  return sum;
}

std::vector<StiffenerResult> Stiffeners::results(const Points& q,
                                                 const ShellTemperature& temperature) const {
  using Member = double StiffenerForces::*;
  constexpr std::array<Member, kStrains> members = {
      &StiffenerForces::axial, &StiffenerForces::bending, &StiffenerForces::lateral_bending,
      &StiffenerForces::torque};
  std::vector<StiffenerResult> results;
  std::vector<int> of(stiffeners_.size());  // curves in pieces have one name
  for (size_t k = 0; k < stiffeners_.size(); ++k) {
    const auto known = std::find_if(results.begin(), results.end(), [&](const StiffenerResult& r) {
      return r.name == stiffeners_[k].name;
    });
    of[k] = static_cast<int>(known - results.begin());
    if (known != results.end()) continue;
    constexpr double far = std::numeric_limits<double>::infinity();
    results.push_back(
        {stiffeners_[k].name, 0, Vec3::Zero(), {far, far, far, far}, {-far, -far, -far, -far}});
  }
  for (const Point& point : points_) {
    StiffenerResult& result =
        results[static_cast<size_t>(of[static_cast<size_t>(point.stiffener)])];
    const auto strains = strains_at(point, q, temperature);
    for (int s = 0; s < kStrains; ++s) {
      const double force = stiffness(point, s) * strains[static_cast<size_t>(s)];
      const Member member = members[static_cast<size_t>(s)];
      result.least.*member = std::min(result.least.*member, force);
      result.largest.*member = std::max(result.largest.*member, force);
    }
    const StiffenerSection& section = stiffeners_[static_cast<size_t>(point.stiffener)].section;
    for (const Vec2& fibre : section.fibres) {
      const double stress = section.young * (strains[Axial] + fibre.x() * strains[Bending] -
                                             fibre.y() * strains[LateralBending]);
      if (std::abs(stress) <= std::abs(result.largest_stress)) continue;
      result.largest_stress = stress;
      result.stress_at = point.at;
    }
  }
  return results;
}

}  // namespace batten
