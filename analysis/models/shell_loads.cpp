#include "batten/analysis/models/shell_loads.h"

#include <Eigen/Geometry>

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_places.h"
#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/assembly.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {

namespace {

const TabulatedRule& load_rule(TriangleElement kind) {
  static const TabulatedRule split(TriangleElement::HCT, split_triangle(6)),
      duffy(TriangleElement::Z12, six_duffy(5));
  return kind == TriangleElement::HCT ? split : duffy;
}

[[noreturn]] void nothing_in(const Box3& box) {
  const auto corner = [](const Vec3& p) {
    return "[" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) + "]";
  };
  throw EmptyPartError("found nothing in the box from " + corner(box.min()) + " to " +
                       corner(box.max()) + ", expected a box that holds a part of it");
}

// Σ force(place) over a part, on the functions there.
template <class Force>
Points over_area(const ModelLayout& model, const Points& shape, const ShellPart& part,
                 const Force& force) {
  const Surface surface = model.surface(shape);
  Points F = Points::Zero(shape.rows(), 3);
  bool any = false;
  constexpr int degree = 6;
  over_part(model, surface, part, load_rule(surface.kind()), degree, [&](const PartPlace& place) {
    any = true;
    if (!(place.area.norm() > 0)) return;
    const Vec3 f = force(place);
    for (int m = 0; m < 12; ++m) F.row(place.dofs[m]) += place.functions[m] * f.transpose();
  });
  if (part.box && !any) nothing_in(*part.box);
  return F;
}

// Calls visit(side, f, dl) along a line.
template <class Visit>
void along_line(const ModelLayout& model, const Points& shape, const std::string& line,
                const std::optional<Box3>& box, const Visit& visit) {
  LineSides sides(model);
  const JoinEdge side = sides(model.model_line(line));
  bool any = false;
  over_line(side, side, [&](double f, double dl) {
    if (box && !box->contains(place_of(side, shape, f))) return;
    any = true;
    visit(side, f, dl);
  });
  if (box && !any) nothing_in(*box);
}

}  // namespace

Points area_force(const ModelLayout& model, const Points& shape, const AreaForce& force,
                  const ShellPart& part) {
  return over_area(model, shape, part, [&](const PartPlace& place) -> Vec3 {
    return place.area.norm() * force(place.x, place.area.normalized());
  });
}

Points weight(const ModelLayout& model, const Points& shape,
              const std::vector<ShellSection>& sections, const Vec3& acceleration) {
  return over_area(model, shape, {}, [&](const PartPlace& place) -> Vec3 {
    const ShellSection& s = sections[sections.size() == 1 ? 0 : place.where.triangle];
    return place.area.norm() * s.material.density * s.thickness_at(place.where.L) * acceleration;
  });
}

Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const Vec3& per_length, const std::optional<Box3>& box) {
  Points F = Points::Zero(shape.rows(), 3);
  along_line(model, shape, line, box, [&](const JoinEdge& side, double f, double dl) {
    RowEntries place;
    side.add_at(f, 0, 0, dl, place);
    for (const auto& e : place) F.row(e.dof) += e.coefficient * per_length.transpose();
  });
  return F;
}

Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   double per_length, const std::optional<Box3>& box) {
  Points F = Points::Zero(shape.rows(), 3);
  along_line(model, shape, line, box, [&](const JoinEdge& side, double f, double dl) {
    CoupledEntries row;
    LineRotation(side, shape).at_fraction(f, per_length * dl, row);
    for (const auto& e : row) F.row(e.dof) += e.coefficient.transpose();
  });
  return F;
}

ShellPlace nearest_place(const ModelLayout& model, const Points& shape, const Vec3& p) {
  const auto found = ModelProjector(model, shape).nearest_inside(p);
  return {found.at, model.in_model(found.at.region, found.where), found.distance};
}

Points point_force(const ModelLayout& model, const ShellPlace& place, const Vec3& force) {
  Points F = Points::Zero(DofMap(*model.mesh()).count(), 3);
  for (const auto& e : functions_at(model, place.where))
    F.row(e.dof) += e.coefficient * force.transpose();
  return F;
}

Resultant resultant(const ModelLayout& model, const Points& shape, const Points& F) {
  Resultant sum;
  sum.force = F.transpose() * model.position_dofs();
  for (long m = 0; m < F.rows(); ++m) sum.moment += Vec3(shape.row(m)).cross(Vec3(F.row(m)));
  return sum;
}

}  // namespace batten
