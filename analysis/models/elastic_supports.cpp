#include "batten/analysis/models/elastic_supports.h"

#include <Eigen/Geometry>

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// Springs of one place: along the axes, and along n.
void add_at(const ElasticSupport& support, const RowEntries& place, double share, const Vec3& n,
            LineSprings& springs) {
  const auto add = [&](const Vec3& direction, double stiffness) {
    if (stiffness > 0) springs.add(support.name, along(direction, place), stiffness * share, 0);
  };
  for (int c = 0; c < 3; ++c) add(Vec3::Unit(c), support.stiffness[c]);
  add(n, support.normal);
}

void add_on_area(const ModelLayout& model, const Points& shape, const ElasticSupport& support,
                 LineSprings& springs) {
  const Surface surface = model.surface(shape);
  const Trim* trim = surface.trim().get();
  constexpr int degree = 4;
  const TriangleRule whole = symmetric_triangle(degree + 2);
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (support.region >= 0 && model.region_of(t) != support.region) continue;
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const bool cut = trim && trim->side(t) == Trim::Side::Cut;
    const TriangleRule rule = cut ? trim->rule(t, degree) : whole;
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Location where{t, rule.L.row(p).transpose()};
      const Vec3 area = surface.jet(where).area_vector();
      if (!(area.norm() > 0)) continue;
      add_at(support, functions_at(model, where),
             rule.weights[p] * surface.mesh().shape(t).area * area.norm(), area.normalized(),
             springs);
    }
  }
}

}  // namespace

void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, LineSprings& springs) {
  const std::string who = "elastic support '" + support.name + "': ";
  if (!support.stiffness.allFinite() || support.stiffness.minCoeff() < 0 ||
      !(support.normal >= 0) || !(support.stiffness.sum() + support.normal > 0))
    throw InputError(who + "found no stiffness above 0");
  if (support.region >= model.region_count())
    throw InputError(who + "found region " + std::to_string(support.region) + " of " +
                     std::to_string(model.region_count()));
  if (support.place) {
    add_at(support, functions_at(model, support.place->where), 1, Vec3::Zero(), springs);
  } else if (!support.line.empty()) {
    LineSides sides(model);
    const JoinEdge side = sides(model.model_line(support.line));
    over_line(side, side, [&](double f, double dl) {
      RowEntries place;
      side.add_at(f, 0, 0, 1, place);
      add_at(support, place, dl, Vec3::Zero(), springs);
    });
  } else {
    add_on_area(model, shape, support, springs);
  }
}

}  // namespace batten
