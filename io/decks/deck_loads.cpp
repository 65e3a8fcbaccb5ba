// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/deck_loads.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "batten/elements/quadrature.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

// Consistent nodal loads ∬ N f dA, with quadratic shape functions N and the area element dA of the
// true surface.
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
        // The map of the element to (u, v) is quadratic as well.
        // Derivatives along L0 - L2, L1 - L2.
        Vec2 at = Vec2::Zero(), d0 = Vec2::Zero(), d1 = Vec2::Zero();
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

// The third corner and the midpoints of an element edge's triangle, seen from the edge.
struct EdgeTriangle {
  int third, middle_of_second, middle_of_first;  // nodes: corner, midpoints of its edges
};

// The triangle at each edge (first, second corner), in the first face that contains it.
std::map<std::pair<int, int>, EdgeTriangle> edge_triangles(const ModelElements& model) {
  std::map<std::pair<int, int>, EdgeTriangle> found;
  for (size_t r = 0; r < model.regions.size(); ++r)
    for (const auto& t : model.regions[r].triangles) {
      std::array<int, 6> n;
      for (size_t a = 0; a < 6; ++a) n[a] = model.node[r][t[a]];
      for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3, k = (i + 2) % 3;
        found.try_emplace({n[i], n[j]}, EdgeTriangle{n[k], n[3 + j], n[3 + k]});
        found.try_emplace({n[j], n[i]}, EdgeTriangle{n[k], n[3 + k], n[3 + j]});
      }
    }
  return found;
}

// A quadrature point of a curve: its element edge, shape functions and length.
struct CurveSample {
  std::array<int, 3> nodes;  // first end, second end, midpoint
  std::array<double, 3> functions;
  ShellDeck::CurvePoint at;
  double length;
};

// An edge of an element, as the part from `from` to `to` of the parabolic edge of a triangle.
struct EdgePart {
  std::array<int, 3> nodes;
  double from, to;
};
std::vector<EdgePart> element_edges(const DeckDiscretization& elements,
                                    const std::array<int, 3>& edge) {
  const auto& [a, b, m] = edge;
  const auto first = elements.quarters.find({a, m}), second = elements.quarters.find({b, m});
  if (first == elements.quarters.end() || second == elements.quarters.end()) return {{edge, 0, 1}};
  return {{{a, m, first->second}, 0, 0.5}, {{m, b, second->second}, 0.5, 1}};
}

// Visits the quadrature points of the edges of elements on a curve. `outwards`: whether to find
// CurvePoint::outwards.
template <class Visit>
void for_each_curve_sample(const ModelElements& model, const DeckDiscretization& elements,
                           const std::string& line, const std::optional<Box3>& box, bool outwards,
                           const Visit& visit) {
  constexpr int points = 4;
  static const SegmentRule rule = gauss_legendre(points);
  std::map<std::pair<int, int>, EdgeTriangle> triangles;
  if (outwards) triangles = edge_triangles(model);
  const auto& x = model.positions;
  const auto quadratic = [](double s) {
    return std::array<double, 3>{(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)};
  };
  for (const auto& of : model.lines) {
    if (of.name != line) continue;
    for (const auto& edge : of.edges)
      for (const EdgePart& part : element_edges(elements, edge))
        for (int p = 0; p < points; ++p) {
          const double s = std::lerp(part.from, part.to, rule.s[p]);
          const auto& [a, b, m] = edge;
          const std::array<double, 3> N = quadratic(s);
          CurveSample sample{part.nodes, quadratic(rule.s[p]), {}, 0};
          sample.at.x = N[0] * x[a] + N[1] * x[b] + N[2] * x[m];
          if (box && !box->contains(sample.at.x)) continue;
          const Vec3 along = (4 * s - 3) * x[a] + (4 * s - 1) * x[b] + (4 - 8 * s) * x[m];
          sample.length = (part.to - part.from) * rule.weights[p] * along.norm();
          sample.at.tangent = along.normalized();
          if (outwards) {
            // The derivative of the element towards its third corner.
            const EdgeTriangle& t = triangles.at({a, b});
            const Vec3 in = -(1 - s) * (4 * (1 - s) - 1) * x[a] - s * (4 * s - 1) * x[b] -
                            x[t.third] - 8 * s * (1 - s) * x[m] + 4 * s * x[t.middle_of_second] +
                            4 * (1 - s) * x[t.middle_of_first];
            sample.at.outwards = (in.dot(sample.at.tangent) * sample.at.tangent - in).normalized();
          }
          visit(sample);
        }
  }
}

Points area_forces_of(const SkinnedRegion& region, const QuadraticElements& elements,
                      const std::function<Vec3(const Vec3& x, const Vec3& n)>& f) {
  Points forces = area_forces(region.surface, elements, f);
  // At the vertices of flat triangles the integral vanishes; drop the rounding error.
  const double rounding = 1e-14 * forces.cwiseAbs().maxCoeff();
  for (long i = 0; i < forces.rows(); ++i)
    if (forces.row(i).cwiseAbs().maxCoeff() <= rounding) forces.row(i).setZero();
  return forces;
}

// Part of a model.
struct Part {
  std::vector<std::string> lines;
  std::string region;
  std::optional<Box3> box;
};

// Integrals of the shape functions times the unit vectors f(x, n) over a curve or an area.
std::map<int, Vec3> nodal_vectors(const std::vector<const SkinnedRegion*>& regions,
                                  const ModelElements& model, const DeckDiscretization& elements,
                                  const Part& part, const std::function<Vec3(const Vec3& n)>& f) {
  std::map<int, Vec3> sums;
  const auto at = [&](int node) -> Vec3& {
    return sums.try_emplace(node, Vec3::Zero()).first->second;
  };
  for (const std::string& line : part.lines)
    for_each_curve_sample(model, elements, line, part.box, false, [&](const CurveSample& sample) {
      for (size_t k = 0; k < 3; ++k)
        at(sample.nodes[k]) += sample.functions[k] * sample.length * f(Vec3::Zero());
    });
  if (!part.lines.empty()) return sums;
  for (size_t r = 0; r < regions.size(); ++r) {
    if (!part.region.empty() && regions[r]->name != part.region) continue;
    const Points forces =
        area_forces_of(*regions[r], model.regions[r], [&](const Vec3& x, const Vec3& n) -> Vec3 {
          return part.box && !part.box->contains(x) ? Vec3::Zero() : f(n);
        });
    for (long i = 0; i < forces.rows(); ++i)
      if (!forces.row(i).isZero(0)) at(model.node[r][i]) += forces.row(i).transpose();
  }
  return sums;
}

void add_spread_load(const std::vector<const SkinnedRegion*>& regions, const ModelElements& model,
                     const DeckDiscretization& elements, const ShellDeck::SpreadLoad& load,
                     std::map<int, NodalLoad>& loads) {
  const std::map<int, Vec3> weights =
      nodal_vectors(regions, model, elements, {load.lines, load.region, load.box},
                    [](const Vec3&) -> Vec3 { return Vec3::UnitX(); });
  double size = 0;
  Vec3 centre = Vec3::Zero();
  for (const auto& [node, w] : weights) {
    size += w.x();
    centre += w.x() * elements.positions[node];
  }
  centre /= size;
  Mat3 inertia = Mat3::Zero();
  for (const auto& [node, w] : weights) {
    const Vec3 r = elements.positions[node] - centre;
    inertia += w.x() * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  const Vec3 rotation = inertia.completeOrthogonalDecomposition().solve(load.moment);
  for (const auto& [node, w] : weights)
    loads[node].force +=
        w.x() * (load.force / size + rotation.cross(elements.positions[node] - centre));
}

}  // namespace

std::map<int, NodalLoad> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                     const ModelElements& model, const DeckDiscretization& elements,
                                     const ShellDeck& deck) {
  std::map<int, NodalLoad> loads;
  for (size_t r = 0; r < regions.size() && deck.area_force; ++r) {
    const Points forces = area_forces_of(
        *regions[r], model.regions[r],
        [&](const Vec3& x, const Vec3& n) { return deck.area_force(regions[r]->name, x, n); });
    for (long i = 0; i < forces.rows(); ++i)
      if (!forces.row(i).isZero(0)) loads[model.node[r][i]].force += forces.row(i).transpose();
  }
  for (const auto& load : deck.line_loads)
    for_each_curve_sample(
        model, elements, load.line, load.box, true, [&](const CurveSample& sample) {
          const Vec3 none = Vec3::Zero();
          const Vec3 force = sample.length * (load.force ? load.force(sample.at) : none);
          const Vec3 moment = sample.length * (load.moment ? load.moment(sample.at) : none);
          for (size_t k = 0; k < 3; ++k) {
            loads[sample.nodes[k]].force += sample.functions[k] * force;
            loads[sample.nodes[k]].moment += sample.functions[k] * moment;
          }
        });
  for (const auto& load : deck.spread_loads) add_spread_load(regions, model, elements, load, loads);
  for (const auto& f : deck.point_forces)
    loads[nearest_node(model.positions, f.at)].force += f.force;
  return loads;
}

std::vector<NodalSpring> deck_springs(const std::vector<const SkinnedRegion*>& regions,
                                      const ModelElements& model,
                                      const DeckDiscretization& elements, const ShellDeck& deck) {
  std::vector<NodalSpring> springs;
  const auto add = [&](int node, const Vec3& direction, double stiffness) {
    if (stiffness > 0) springs.push_back({node, direction, stiffness});
  };
  for (const ShellDeck::Spring& of : deck.springs) {
    Part part{{}, of.region, of.box};
    if (!of.line.empty()) part.lines.push_back(of.line);
    for (int c = 0; c < 3; ++c) {
      if (!(of.stiffness[c] > 0)) continue;
      if (of.point) {
        add(nearest_node(model.positions, *of.point), Vec3::Unit(c), of.stiffness[c]);
        continue;
      }
      for (const auto& [node, w] : nodal_vectors(regions, model, elements, part,
                                                 [](const Vec3&) -> Vec3 { return Vec3::UnitX(); }))
        add(node, Vec3::Unit(c), of.stiffness[c] * w.x());
    }
    if (of.foundation > 0)
      for (const auto& [node, w] :
           nodal_vectors(regions, model, elements, part, [](const Vec3& n) { return n; }))
        add(node, w.normalized(), of.foundation * w.norm());
  }
  return springs;
}

}  // namespace batten
