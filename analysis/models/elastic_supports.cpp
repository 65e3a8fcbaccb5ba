#include "batten/analysis/models/elastic_supports.h"

#include <Eigen/Geometry>

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_quadrature.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// Springs of one place: along the axes, and along n.
void add_at(const ElasticSupport& support, const ConstraintEntries& position, double weight,
            const Vec3& n, ShellSprings& springs) {
  const auto add = [&](const Vec3& direction, double stiffness) {
    if (stiffness > 0) springs.add(support.name, along(direction, position), stiffness * weight, 0);
  };
  for (int c = 0; c < 3; ++c) add(Vec3::Unit(c), support.stiffness[c]);
  add(n, support.normal);
}

void add_on_area(const ModelLayout& model, const Points& shape, const ElasticSupport& support,
                 ShellSprings& springs) {
  constexpr int degree = 4;
  bool any = false;
  const Surface surface = model.surface(shape);
  const TabulatedRule whole(surface.kind(), symmetric_triangle_rule(degree + 2));
  for_each_part_point(model, surface, support.part, whole, degree, [&](const PartPoint& at) {
    any = true;
    if (at.area.norm() > 0)
      add_at(support, at.entries(), at.area.norm(), at.area.normalized(), springs);
  });
  if (!any) throw InputError("elastic support '" + support.name + "' holds nothing of the surface");
}

}  // namespace

void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs) {
  const std::string who = "elastic support '" + support.name + "': ";
  if (!support.stiffness.allFinite() || support.stiffness.minCoeff() < 0 ||
      !(support.normal >= 0) || !(support.stiffness.sum() + support.normal > 0))
    throw InputError(who + "found no stiffness above 0");
  if (support.position) {
    add_at(support, shape_functions_at(model, support.position->where), 1, Vec3::Zero(), springs);
  } else if (!support.line.empty()) {
    LineSides sides(model);
    const JoinEdge side = sides(model.model_line(support.line));
    bool any = false;
    for_each_line_point(side, side, [&](double f, double dl) {
      if (support.part.box && !support.part.box->contains(point_on_line(side, shape, f))) return;
      any = true;
      ConstraintEntries position;
      side.add_at(f, 0, 0, 1, position);
      add_at(support, position, dl, Vec3::Zero(), springs);
    });
    if (!any) throw InputError(who + "has a box that holds nothing of the line");
  } else {
    add_on_area(model, shape, support, springs);
  }
}

}  // namespace batten
