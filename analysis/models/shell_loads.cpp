// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_loads.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_quadrature.h"
#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {

namespace {

const TabulatedRule& load_rule(TriangleElement kind) {
  static const TabulatedRule split(TriangleElement::HCT, split_triangle_rule(6)),
      duffy(TriangleElement::Z12, six_duffy_rule(5));
  return kind == TriangleElement::HCT ? split : duffy;
}

// The matrix of a × b as a function of b.
Mat3 cross_matrix(const Vec3& a) {
  Mat3 A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

[[noreturn]] void throw_nothing_in(const Box3& box) {
  const auto corner = [](const Vec3& p) {
    return "[" + format_number(p.x()) + ", " + format_number(p.y()) + ", " + format_number(p.z()) +
           "]";
  };
  throw EmptyPartError("found no part of the surface or curve in the box from " +
                       corner(box.min()) + " to " + corner(box.max()) +
                       ", expected a box that contains a part of it");
}

// Sums force(point) over a part, weighted with the shape functions.
template <class Force>
Points integrate_over_area(const ModelLayout& model, const Points& shape, const ShellPart& part,
                           const Force& force) {
  const Surface surface = model.surface(shape);
  Points F = Points::Zero(shape.rows(), 3);
  bool any = false;
  constexpr int degree = 6;
  for_each_part_point(model, surface, part, load_rule(surface.kind()), degree,
                      [&](const PartPoint& position) {
                        any = true;
                        if (!(position.area.norm() > 0)) return;
                        const Vec3 f = force(position);
                        for (int m = 0; m < 12; ++m)
                          F.row(position.dofs[m]) += position.functions[m] * f.transpose();
                      });
  if (part.box && !any) throw_nothing_in(*part.box);
  return F;
}

// Calls visit(side, f, dl) along a curve.
template <class Visit>
void along_line(const ModelLayout& model, const Points& shape, const std::string& line,
                const std::optional<Box3>& box, const Visit& visit) {
  LineSides sides(model);
  const JoinEdge side = sides(model.model_line(line));
  bool any = false;
  for_each_line_point(side, side, [&](double f, double dl) {
    if (box && !box->contains(point_on_line(side, shape, f))) return;
    any = true;
    visit(side, f, dl);
  });
  if (box && !any) throw_nothing_in(*box);
}

// Adds a force at a fraction of a curve to a load vector.
void add_force(const JoinEdge& side, double f, const Vec3& force, Points& F) {
  ConstraintEntries position;
  side.add_at(f, 0, 0, 1, position);
  for (const auto& e : position) F.row(e.dof) += e.coefficient * force.transpose();
}

// A derivative of the shape at a fraction of a curve: across y + along dx/dt (JoinEdge::add_at()).
Vec3 derivative(const JoinEdge& side, const Points& shape, double f, double across, double along) {
  ConstraintEntries entries;
  side.add_at(f, across, along, 0, entries);
  return value_of(entries, shape);
}

// Whether a face lies to the left of a curve, in the direction of JoinEdge; nullopt if the curve is
// not part of the boundary of the face.
std::optional<bool> face_is_left(const RegionLayout& region, const LineSide& side) {
  for (const auto& loop : region.boundary())
    for (const BoundarySegment& segment : loop) {
      const bool embedded = segment.kind == BoundarySegment::Kind::Embedded;
      if (embedded != side.embedded || segment.index != side.index) continue;
      const bool opposite =
          embedded && region.embedded()[static_cast<size_t>(side.index)].opposite_to_prescribed;
      return segment.reversed == opposite;
    }
  return std::nullopt;
}

}  // namespace

Points surface_traction(const ModelLayout& model, const Points& shape, const SurfaceTraction& force,
                        const ShellPart& part) {
  return integrate_over_area(model, shape, part, [&](const PartPoint& position) -> Vec3 {
    return position.area.norm() * force(position.x, position.area.normalized());
  });
}

SparseMatrix follower_stiffness(const ModelLayout& model, const Points& shape,
                                const std::function<PressureAt(const Vec3& x)>& pressure,
                                const ShellPart& part) {
  const Surface surface = model.surface(shape);
  const auto n = static_cast<int>(shape.rows());
  using Block = Eigen::Matrix<double, 36, 36>;  // rows and columns 3 m + c
  std::vector<Triplet> entries;
  Block sum = Block::Zero();
  std::array<int, 12> dofs{};
  int triangle = -1;
  const auto flush = [&] {
    if (triangle < 0) return;
    for (int i = 0; i < 36; ++i)
      for (int j = 0; j < 36; ++j) {
        const int row = i % 3 * n + dofs[i / 3], column = j % 3 * n + dofs[j / 3];
        if (row >= column) entries.emplace_back(row, column, 0.5 * (sum(i, j) + sum(j, i)));
      }
    sum.setZero();
  };
  constexpr int degree = 6;
  for_each_part_point(
      model, surface, part, load_rule(surface.kind()), degree, [&](const PartPoint& at) {
        if (at.where.triangle != triangle) {
          flush();
          triangle = at.where.triangle;
          dofs = at.dofs;
        }
        const PressureAt p = pressure(at.x);
        const Mat3 of_u = -at.weight * p.value * cross_matrix(at.x_v),
                   of_v = at.weight * p.value * cross_matrix(at.x_u),
                   of_value = at.area * p.gradient.transpose();
        for (int k = 0; k < 12; ++k) {
          const Mat3 change =
              at.slopes(k, 0) * of_u + at.slopes(k, 1) * of_v + at.functions[k] * of_value;
          for (int m = 0; m < 12; ++m) sum.block<3, 3>(3 * m, 3 * k) += at.functions[m] * change;
        }
      });
  flush();
  SparseMatrix S(3 * n, 3 * n);
  S.setFromTriplets(entries.begin(), entries.end());
  return S;
}

Points body_load(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const AccelerationField& acceleration) {
  return integrate_over_area(model, shape, {}, [&](const PartPoint& position) -> Vec3 {
    const ShellSection& s = sections[sections.size() == 1 ? 0 : position.where.triangle];
    return position.area.norm() * s.density() * s.thickness_at(position.where.L) *
           acceleration(position.x);
  });
}

Points gravity_load(const ModelLayout& model, const Points& shape,
                    const std::vector<ShellSection>& sections, const Vec3& acceleration) {
  return body_load(model, shape, sections, [&](const Vec3&) { return acceleration; });
}

Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const LineTraction& per_length, const std::optional<Box3>& box) {
  Points F = Points::Zero(shape.rows(), 3);
  along_line(model, shape, line, box, [&](const JoinEdge& side, double f, double dl) {
    add_force(side, f, dl * per_length(point_on_line(side, shape, f)), F);
  });
  return F;
}

Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const Vec3& per_length, const std::optional<Box3>& box) {
  return line_force(model, shape, line, LineTraction([&](const Vec3&) { return per_length; }), box);
}

Points edge_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const LineIntensity& per_length, const std::optional<Box3>& box) {
  const ModelLine& found = model.model_line(line);
  const LineSide& only = found.sides[0];
  const std::optional<bool> left = face_is_left(*model.regions()[only.region], only);
  if (found.sides.size() != 1 || !left)
    throw InputError("found an edge force on '" + line +
                     "', expected a curve that is the edge of exactly one face");
  Points F = Points::Zero(shape.rows(), 3);
  along_line(model, shape, line, box, [&](const JoinEdge& side, double f, double dl) {
    // The first side of a curve is the left one; see LineSides.
    const Vec3 y = derivative(side, shape, f, 1, 0), along = derivative(side, shape, f, 0, 1);
    const Vec3 tangent = along.normalized(), across = y - y.dot(tangent) * tangent;
    if (!(across.norm() > 0))
      throw InputError("the surface is singular along '" + line +
                       "': it has no tangent plane there");
    const double force = dl * per_length(point_on_line(side, shape, f));
    add_force(side, f, (*left ? -1 : 1) * force * across.normalized(), F);
  });
  return F;
}

Points edge_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  double per_length, const std::optional<Box3>& box) {
  return edge_force(model, shape, line, LineIntensity([&](const Vec3&) { return per_length; }),
                    box);
}

Points spread_load(const ModelLayout& model, const Points& shape,
                   const std::function<Points(const LineTraction& f)>& load, const Vec3& force,
                   const Vec3& moment) {
  // The load vector of an even force f is w fᵀ, with the integrals w of the shape functions.
  const VecX w = load([](const Vec3&) -> Vec3 { return Vec3::UnitX(); }).col(0);
  const double size = w.dot(model.position_dofs());
  const Vec3 c = shape.transpose() * w / size;
  Points F = w * (force / size).transpose();
  if (moment.isZero(0)) return F;
  Points turning[3];
  Mat3 inertia;
  for (int k = 0; k < 3; ++k) {
    turning[k] = load([&](const Vec3& p) -> Vec3 { return Vec3::Unit(k).cross(p - c); });
    inertia.col(k) = resultant(model, shape, turning[k]).moment;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(inertia);
  constexpr double straight = 1e-9;
  Vec3 rotation = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = axes.eigenvectors().col(k);
    const double about = axis.dot(moment);
    if (axes.eigenvalues()[k] > straight * axes.eigenvalues()[2])
      rotation += about / axes.eigenvalues()[k] * axis;
    else if (std::abs(about) > straight * moment.norm())
      throw InputError(
          "found a total moment about the direction of a straight curve, expected one "
          "perpendicular to it; or 'moment', a moment per length about the curve");
  }
  for (int k = 0; k < 3; ++k) F += rotation[k] * turning[k];
  return F;
}

Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   const LineIntensity& per_length, const std::optional<Box3>& box) {
  Points F = Points::Zero(shape.rows(), 3);
  along_line(model, shape, line, box, [&](const JoinEdge& side, double f, double dl) {
    CoupledEntries row;
    LineRotation(side, shape).at_fraction(f, per_length(point_on_line(side, shape, f)) * dl, row);
    for (const auto& e : row) F.row(e.dof) += e.coefficient.transpose();
  });
  return F;
}

Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   double per_length, const std::optional<Box3>& box) {
  return line_moment(model, shape, line, LineIntensity([&](const Vec3&) { return per_length; }),
                     box);
}

ShellLocation nearest_location(const ModelLayout& model, const Points& shape, const Vec3& p) {
  const auto found = ModelProjector(model, shape).nearest_inside(p);
  return {found.at, model.to_model_location(found.at.region, found.where), found.distance};
}

Points point_force(const ModelLayout& model, const ShellLocation& position, const Vec3& force) {
  Points F = Points::Zero(DofMap(*model.mesh()).count(), 3);
  for (const auto& e : shape_functions_at(model, position.where))
    F.row(e.dof) += e.coefficient * force.transpose();
  return F;
}

Resultant resultant(const ModelLayout& model, const Points& shape, const Points& F) {
  Resultant sum;
  sum.force = F.transpose() * model.position_dofs();
  for (long m = 0; m < F.rows(); ++m) sum.moment += Vec3(shape.row(m)).cross(Vec3(F.row(m)));
  return sum;
}

ForceMagnitudes magnitudes(const ModelLayout& model, const Points& shape, const Points& F) {
  const VecX positions = model.position_dofs();
  const Vec3 c = centre(model, shape);
  ForceMagnitudes sum;
  for (long m = 0; m < F.rows(); ++m) {
    const Vec3 force = F.row(m), x = shape.row(m);
    sum.force += positions[m] * force.norm();
    sum.moment += (x - positions[m] * c).cross(force).norm();
  }
  return sum;
}

Vec3 centre(const ModelLayout& model, const Points& shape) {
  const VecX positions = model.position_dofs();
  return shape.transpose() * positions / std::max(positions.sum(), 1.0);
}

}  // namespace batten
