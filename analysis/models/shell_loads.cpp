#include "batten/analysis/models/shell_loads.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/assembly.h"
#include "batten/fem/line_load.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {

Points area_force(const ModelLayout& model, const Points& shape, const AreaForce& force,
                  const std::vector<int>& regions) {
  for (const int r : regions)
    if (r < 0 || r >= model.region_count())
      throw InputError("a load on region " + std::to_string(r) + " of " +
                       std::to_string(model.region_count()));
  const Surface surface = model.surface(shape);
  const Trim* trim = surface.trim().get();
  constexpr int degree = 6, order = 5;
  const TriangleRule whole =
      surface.kind() == TriangleElement::HCT ? split_triangle(degree) : six_duffy(order);
  Points F = Points::Zero(shape.rows(), 3);
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (!regions.empty() &&
        std::find(regions.begin(), regions.end(), model.region_of(t)) == regions.end())
      continue;
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const bool cut = trim && trim->side(t) == Trim::Side::Cut;
    const TriangleRule rule = cut ? trim->rule(t, degree) : whole;
    const TriangleShape geometry = surface.mesh().shape(t);
    const C1Triangle triangle(surface.kind(), geometry);
    const Eigen::Matrix<double, 12, 3> q = surface.triangle_dofs(t);
    const auto dofs = surface.dof_map().triangle(surface.mesh(), t);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Tabulation N = triangle.evaluate(rule.L.row(p));
      const Vec3 x = q.transpose() * N.col(kW);
      const Vec3 area = Vec3(q.transpose() * N.col(kU)).cross(Vec3(q.transpose() * N.col(kV)));
      const double size = area.norm();
      if (!(size > 0)) continue;
      const Vec3 f = rule.weights[p] * geometry.area * size * force(x, area / size);
      for (int m = 0; m < 12; ++m) F.row(dofs[m]) += N(m, kW) * f.transpose();
    }
  }
  return F;
}

Points line_force(const ModelLayout& model, const std::string& line, const Vec3& per_length) {
  const LineSide& side = model.model_line(line).sides[0];
  const ParametricMesh& mesh = *model.region(side.region).mesh();
  const VecX load =
      line_load(mesh, model.element(), TriangleLocator(mesh), model.image(side), model.curve(side));
  return model.spread(side.region, load) * per_length.transpose();
}

Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   double per_length) {
  LineSides sides(model);
  const JoinEdge side = sides(model.model_line(line));
  const LineRotation rotation(side, shape);
  Points F = Points::Zero(shape.rows(), 3);
  over_line(side, side, [&](double f, double dl) {
    CoupledEntries row;
    rotation.at_fraction(f, per_length * dl, row);
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
