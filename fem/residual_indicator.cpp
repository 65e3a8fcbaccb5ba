#include "batten/fem/residual_indicator.h"

#include <array>
#include <vector>

#include "batten/core/parallel_chunks.h"
#include "batten/elements/reference_triangle.h"

namespace batten {
namespace {

constexpr int kGauss = 3;
using Second = Eigen::Matrix<double, 12, 3>;  // ∂11, ∂12, ∂22 of the reference functions

// Second derivatives along the edges, and along the spokes from either side: [edge i][Gauss point
// from V_i+1 to V_i+2], [spoke from V_i][side: the sub-triangles i+1, i+2][Gauss point from V_i].
struct Tables {
  SegmentRule gauss = gauss_legendre(kGauss);
  Second edge[3][kGauss];
  Second spoke[3][2][kGauss];
  Vec3 on_edge[3][kGauss], on_spoke[3][kGauss];

  explicit Tables(TriangleElement kind) {
    const Vec3 centre = Vec3::Constant(1.0 / 3);
    for (int i = 0; i < 3; ++i)
      for (int g = 0; g < kGauss; ++g) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double s = gauss.s[g];
        on_edge[i][g] = (1 - s) * Vec3::Unit(j) + s * Vec3::Unit(k);
        on_spoke[i][g] = (1 - s) * Vec3::Unit(i) + s * centre;
        edge[i][g] = second(kind, on_edge[i][g]);
        if (kind != TriangleElement::HCT) continue;
        for (const int side : {0, 1}) {
          // Linear in the sub-triangle: from two points inside of it, one twice as far in.
          const int sub = (i + 1 + side) % 3;
          const Vec3 inwards =
              (Vec3::Unit((sub + 1) % 3) + Vec3::Unit((sub + 2) % 3) + centre) / 3 - on_spoke[i][g];
          spoke[i][side][g] = 2 * second(kind, on_spoke[i][g] + 0.5 * inwards) -
                              second(kind, on_spoke[i][g] + inwards);
        }
      }
  }

 private:
  static Second second(TriangleElement kind, const Vec3& L) {
    return reference_functions(kind, L).rightCols<3>();
  }
};

const Tables& tables(TriangleElement kind) {
  static const Tables hct(TriangleElement::HCT), z12(TriangleElement::Z12);
  return kind == TriangleElement::HCT ? hct : z12;
}

}  // namespace

VecX residual_indicator(const Surface& surface) {
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  const Tables& table = tables(surface.kind());
  const auto counts = [&](int t, const TriangleShape& shape, const Vec3& L) {
    if (!trim || trim->side(t) == Trim::Side::Inside) return true;
    return trim->side(t) == Trim::Side::Cut && trim->loops().contains(shape.point(L));
  };

  using Along = std::array<Vec3, kGauss>;  // x_uu + x_vv
  std::vector<std::array<Along, 3>> edges(mesh.triangle_count());
  VecX eta = VecX::Zero(mesh.triangle_count());
  parallel_for_each<256>(mesh.triangle_count(), [&](int t) {
    const TriangleShape shape = mesh.shape(t);
    const Eigen::Matrix<double, 12, 3> q =
        C1Triangle(surface.kind(), shape).pull_back(surface.triangle_dofs(t));
    const DerivativeMap map(shape);
    const Vec3 laplacian = (map.second.row(0) + map.second.row(2)).transpose();
    const auto at = [&](const Second& N) -> Vec3 { return q.transpose() * (N * laplacian); };
    for (int i = 0; i < 3; ++i)
      for (int g = 0; g < kGauss; ++g) edges[t][i][g] = at(table.edge[i][g]);
    if (surface.kind() != TriangleElement::HCT) return;
    const Vec2 centre = shape.point(Vec3::Constant(1.0 / 3));
    for (int i = 0; i < 3; ++i) {
      const double h2 = (shape.vertex[i] - centre).squaredNorm();
      for (int g = 0; g < kGauss; ++g)
        if (counts(t, shape, table.on_spoke[i][g]))
          eta[t] += h2 * table.gauss.weights[g] *
                    (at(table.spoke[i][0][g]) - at(table.spoke[i][1][g])).squaredNorm();
    }
  });
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    if (edge.boundary()) continue;
    const auto [t, other] = edge.triangle;
    if (trim && (trim->side(t) == Trim::Side::Outside || trim->side(other) == Trim::Side::Outside))
      continue;
    const TriangleShape shape = mesh.shape(t);
    const int i = edge.local[0], k = edge.local[1];
    const double length = mesh.edge_length(e);
    double jump2 = 0;
    // The two triangles run along the edge in opposite directions.
    for (int g = 0; g < kGauss; ++g)
      if (counts(t, shape, table.on_edge[i][g]))
        jump2 += table.gauss.weights[g] *
                 (edges[t][i][g] - edges[other][k][kGauss - 1 - g]).squaredNorm();
    const double half = 0.5 * length * length * jump2;
    eta[t] += half;
    eta[other] += half;
  }
  return eta;
}

}  // namespace batten
