#include <algorithm>
#include <functional>
#include <optional>

#include "batten/elements/quadrature.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/decks/calculix_elements.h"

namespace batten {
namespace {

// ∬ N f dA of each node, N the quadratic shape functions, dA of the true surface.
template <class Force>
Points area_forces(const Surface& surface, const QuadraticElements& facets, const Force& f) {
  static const TriangleRule split = split_triangle_rule(6), whole = symmetric_triangle_rule(8);
  const TriangleRule& rule = facets.is_element_mesh ? split : whole;
  std::optional<TriangleLocator> locator;
  if (!facets.is_element_mesh) locator.emplace(surface.mesh());
  Points forces = Points::Zero(static_cast<long>(facets.nodes.size()), 3);
  for (size_t t = 0; t < facets.triangles.size(); ++t) {
    const auto& n = facets.triangles[t];
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p).transpose();
      const double N[6] = {L[0] * (2 * L[0] - 1), L[1] * (2 * L[1] - 1), L[2] * (2 * L[2] - 1),
                           4 * L[0] * L[1],       4 * L[1] * L[2],       4 * L[2] * L[0]};
      Location where{static_cast<int>(t), L};
      double parametric;
      if (locator) {
        // The element's place in (u, v) is quadratic as well.
        Vec2 at = Vec2::Zero(), d0 = Vec2::Zero(), d1 = Vec2::Zero();  // along L0 - L2, L1 - L2
        const double N0[6] = {4 * L[0] - 1, 0,         1 - 4 * L[2],
                              4 * L[1],     -4 * L[1], 4 * (L[2] - L[0])},
                     N1[6] = {0,        4 * L[1] - 1,      1 - 4 * L[2],
                              4 * L[0], 4 * (L[2] - L[1]), -4 * L[0]};
        for (int a = 0; a < 6; ++a) {
          const Vec2 uv = surface.mesh().image_near(facets.uv[n[a]], facets.uv[n[0]]);
          at += N[a] * uv;
          d0 += N0[a] * uv;
          d1 += N1[a] * uv;
        }
        parametric = 0.5 * (d0.x() * d1.y() - d0.y() * d1.x());
        where = locator->locate(at);
      } else {
        parametric = surface.mesh().shape(where.triangle).area;
      }
      const SurfaceJet jet = surface.jet(where);
      const Vec3 area = rule.weights[p] * parametric * jet.area_vector();
      if (!(area.norm() > 0)) continue;
      const Vec3 force = area.norm() * f(jet.x, area.normalized());
      for (int a = 0; a < 6; ++a) forces.row(n[a]) += N[a] * force.transpose();
    }
  }
  return forces;
}

// Along the parabolas of a line's edges.
void add_line_force(const ModelElements& model, const ShellDeck::LineForce& force,
                    const std::function<Vec3&(int)>& at) {
  constexpr int points = 4;
  static const SegmentRule rule = gauss_legendre(points);
  for (const auto& line : model.lines) {
    if (line.name != force.line) continue;
    for (const auto& [a, b, m] : line.edges)
      for (int p = 0; p < points; ++p) {
        const double s = rule.s[p];
        const double N[3] = {(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)},
                     d[3] = {4 * s - 3, 4 * s - 1, 4 - 8 * s};
        Vec3 x = Vec3::Zero(), along = Vec3::Zero();
        for (int k = 0; k < 3; ++k) {
          const Vec3& place = model.positions[k == 0 ? a : k == 1 ? b : m];
          x += N[k] * place;
          along += d[k] * place;
        }
        if (force.box && !force.box->contains(x)) continue;
        const Vec3 f = rule.weights[p] * along.norm() * force.per_length;
        at(a) += N[0] * f;
        at(b) += N[1] * f;
        at(m) += N[2] * f;
      }
  }
}

}  // namespace

std::map<int, Vec3> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                const ModelElements& model, const ShellDeck& deck) {
  std::map<int, Vec3> force;
  const auto at = [&](int node) -> Vec3& {
    return force.try_emplace(node, Vec3::Zero()).first->second;
  };
  for (size_t r = 0; r < regions.size() && deck.area_force; ++r) {
    const Points forces = area_forces(
        regions[r]->surface, model.regions[r],
        [&](const Vec3& x, const Vec3& n) { return deck.area_force(regions[r]->name, x, n); });
    // At vertices of flat triangles the integral is zero; what is left there is rounding.
    const double rounding = 1e-14 * forces.cwiseAbs().maxCoeff();
    for (long i = 0; i < forces.rows(); ++i)
      if (forces.row(i).cwiseAbs().maxCoeff() > rounding)
        at(model.node[r][i]) += forces.row(i).transpose();
  }
  for (const auto& f : deck.line_forces) add_line_force(model, f, at);
  for (const auto& f : deck.point_forces) {
    const auto nearest = std::min_element(
        model.positions.begin(), model.positions.end(), [&](const Vec3& a, const Vec3& b) {
          return (a - f.at).squaredNorm() < (b - f.at).squaredNorm();
        });
    at(static_cast<int>(nearest - model.positions.begin())) += f.force;
  }
  return force;
}

}  // namespace batten
