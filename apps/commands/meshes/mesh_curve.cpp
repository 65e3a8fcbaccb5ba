#include "batten/apps/commands/meshes/mesh_curve.h"

#include <algorithm>

#include "batten/constraints/shape/curve_constraints.h"

namespace batten {
namespace {

ConstraintSet held_ends(const HermiteCurve& curve, CurveRule::Ends ends) {
  ConstraintSet set(curve.mesh().dof_count());
  if (curve.closed() || ends == CurveRule::Ends::Free) return set;
  CurveConstraints rows(curve.mesh(), set);
  for (const double u : {curve.start(), curve.end()}) {
    rows.point("ends", u, curve.evaluate(u));
    if (ends == CurveRule::Ends::Clamped) rows.derivative("ends", u, curve.evaluate(u, 1));
  }
  return set;
}

}  // namespace

MeshCurve shape_curve(const DeformScene& scene, const CurveRule& rule, VertexSelector& select,
                      const TriangleMesh& mesh) {
  MeshCurve result;
  result.name = rule.line.name;
  result.vertices = select.path(rule.line);
  std::vector<Vec3> points;
  for (const int v : result.vertices) points.push_back(mesh.point(v));
  FairOptions options = rule.fair;
  options.closed = rule.line.closed;
  options.hold_ends = !rule.line.closed;
  try {
    const HermiteCurve given = curve_as_given(rule.line.name, points, options);
    if (!rule.faired) {
      options.balance = FairOptions::Balance::Wavelength;
      options.wavelength = 1e-6 * given.length();  // the curve through the vertices
    }
    const FairCurve fair = fair_points(rule.line.name, points, options);
    result.fairing = fair.deviation;
    result.wavelength = fair.wavelength;
    result.before = fairness(given);
    result.curve = fair.curve;
    if (!rule.loads.empty()) {
      CurveMaterial material;
      material.alpha = {rule.alpha};
      material.beta = {rule.beta};
      DeformableCurve deformable(fair.curve, held_ends(fair.curve, rule.ends), material,
                                 rule.loads);
      result.curve = deformable.solve();
    }
    for (const double u : fair.parameters) {
      result.targets.push_back(result.curve.evaluate(u));
      result.largest_shift =
          std::max(result.largest_shift, (result.targets.back() - fair.curve.evaluate(u)).norm());
    }
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(scene.at(rule.line.place) + "the curve '" + rule.line.name +
                          "': " + e.what());
  } catch (const InputError& e) {
    throw InputError(scene.at(rule.line.place) + e.what());
  }
  result.after = fairness(result.curve);
  return result;
}

double distance_from(const MeshCurve& curve, const Points& p) {
  double worst = 0;
  for (const int v : curve.vertices)
    worst = std::max(worst, curve.curve.closest_point(p.row(v).transpose()).distance);
  return worst;
}

}  // namespace batten
