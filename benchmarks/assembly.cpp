// SPDX-License-Identifier: MPL-2.0
// Stiffness assembly per triangle: Batten's two triangles and GetFEM's HCT.
// All sides use the same mesh and energy ∬ b (w_uu² + 2 w_uv² + w_vv²), with b = 1 or b = 1 + u²/2
// + v, assembled in a matrix that already has its pattern. Checked by the energy of a cubic
// polynomial, exact for every side (the sum of 25,000 cancelling terms has about 1e-8 of rounding).
#include <cmath>
#include <memory>
#include <random>

#include "batten/benchmarks/getfem_hct.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/surface_assembler.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;

constexpr int squares = 64, rounds = 7;

double cubic(const Vec2& p) {
  const double u = p.x(), v = p.y();
  return u * u * u - 2 * u * u * v + 3 * u * v * v + v * v * v / 2 - u * v;
}
Vec2 cubic_gradient(const Vec2& p) {
  const double u = p.x(), v = p.y();
  return {3 * u * u - 4 * u * v + 3 * v * v - v, -2 * u * u + 6 * u * v + 1.5 * v * v - u};
}
Vec3 cubic_second(const Vec2& p) {  // uu, uv, vv
  const double u = p.x(), v = p.y();
  return {6 * u - 4 * v, -4 * u + 6 * v - 1, 6 * u + 3 * v};
}
double coefficient(const Vec2& p) { return 1 + p.x() * p.x() / 2 + p.y(); }

double exact_energy(bool varying) {
  const SegmentRule rule = gauss_legendre(4);
  double sum = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const Vec2 p(rule.s[i], rule.s[j]);
      const Vec3 d = cubic_second(p);
      sum += rule.weights[i] * rule.weights[j] * (varying ? coefficient(p) : 1) *
             (d[0] * d[0] + 2 * d[1] * d[1] + d[2] * d[2]);
    }
  return sum;
}

VecX cubic_dofs(const ParametricMesh& mesh) {
  const DofMap dofs(mesh);
  VecX q(dofs.count());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2 gradient = cubic_gradient(mesh.vertices()[v]);
    q[dofs.vertex(v)] = cubic(mesh.vertices()[v]);
    q[dofs.vertex(v, 1)] = gradient.x();
    q[dofs.vertex(v, 2)] = gradient.y();
  }
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const Vec2 mid = 0.5 * (mesh.vertices()[edge.low] + mesh.vertices()[edge.high]);
    q[dofs.edge(e)] = cubic_gradient(mid).dot(mesh.edge_normal(e));
  }
  return q;
}

// Moves inner vertices by up to 20 % of a square's side.
ParametricMesh perturbed_square(int n) {
  const ParametricMesh regular = ParametricMesh::unit_square(n);
  std::mt19937 generator(1);
  std::vector<Vec2> vertices = regular.vertices();
  const auto move = [&] { return 0.2 / n * (2.0 * generator() / 4294967296.0 - 1); };
  for (Vec2& p : vertices)
    if (p.minCoeff() > 1e-9 && p.maxCoeff() < 1 - 1e-9) p += Vec2(move(), move());
  return {std::move(vertices), regular.triangles()};
}

struct Figures {
  double hct, z12, hct_varying, z12_varying;             // seconds per mesh
  std::optional<double> peer, peer_varying;              // the fastest way
  double worst_energy_error = 0, peer_energy_error = 0;  // relative
};

Figures measure_mesh(const std::string& name, const ParametricMesh& mesh) {
  const auto constant = SurfaceStiffness::isotropic(0, 1);
  const auto field = [](const Vec2& p) { return SurfaceStiffness::isotropic(0, coefficient(p)); };
  const SurfaceAssembler hct(mesh, TriangleElement::HCT), z12(mesh, TriangleElement::Z12);
  SparseMatrix K = hct.pattern();
  Figures f;

  const VecX q = cubic_dofs(mesh);
  const auto check = [&](bool varying) {
    const double energy = q.dot(K.selfadjointView<Eigen::Lower>() * q);
    f.worst_energy_error =
        std::max(f.worst_energy_error, std::abs(energy / exact_energy(varying) - 1));
  };
  for (const SurfaceAssembler* a : {&hct, &z12}) {
    a->stiffness(constant, K);
    check(false);
    a->stiffness(field, K);
    check(true);
  }

  std::vector<std::function<void()>> works = {
      [&] { hct.stiffness(constant, K); }, [&] { z12.stiffness(constant, K); },
      [&] { hct.stiffness(field, K); }, [&] { z12.stiffness(field, K); }};
  std::vector<std::string> names = {"Batten HCT constant", "Batten Z12 constant",
                                    "Batten HCT varying", "Batten Z12 varying"};
  std::unique_ptr<GetfemHct> peer;
  if (!getfem_version().empty()) {
    peer = std::make_unique<GetfemHct>(mesh);
    for (const bool varying : {false, true})
      for (const GetfemAssemblyMode assembly_mode :
           {GetfemAssemblyMode::Language, GetfemAssemblyMode::Classical}) {
        peer->stiffness(assembly_mode, varying);
        f.peer_energy_error = std::max(f.peer_energy_error,
                                       std::abs(peer->energy(cubic) / exact_energy(varying) - 1));
        works.push_back(
            [&peer, assembly_mode, varying] { peer->stiffness(assembly_mode, varying); });
        names.push_back(std::string("GetFEM HCT ") + (varying ? "varying, " : "constant, ") +
                        (assembly_mode == GetfemAssemblyMode::Language ? "weak-form language"
                                                                       : "classical assembly"));
      }
  }

  const std::vector<double> time = side_by_side(rounds, works);
  f.hct = time[0];
  f.z12 = time[1];
  f.hct_varying = time[2];
  f.z12_varying = time[3];
  if (peer) {
    f.peer = std::min(time[4], time[5]);
    f.peer_varying = std::min(time[6], time[7]);
  }

  Table table;
  table.add({name + ", " + std::to_string(mesh.triangle_count()) + " triangles", "us per triangle",
             "GetFEM's best time over it"});
  for (size_t w = 0; w < works.size(); ++w) {
    const auto& best = names[w].find("varying") == std::string::npos ? f.peer : f.peer_varying;
    table.add({names[w], text("%.3f", 1e6 * time[w] / mesh.triangle_count()),
               best ? text("%.1f", *best / time[w]) : "none"});
  }
  table.print();
  return f;
}

}  // namespace

int main() {
  one_thread();
  if (getfem_version().empty())
    std::printf("GetFEM is missing from this build: its checks fail.\n\n");
  else
    std::printf("GetFEM %s. Processor time on one thread, medians.\n\n", getfem_version().c_str());

  const Figures figures[] = {measure_mesh("regular", ParametricMesh::unit_square(squares)),
                             measure_mesh("perturbed", perturbed_square(squares))};

  // The check uses the worse of the two meshes.
  const auto speedup = [&](auto ours, auto theirs) -> std::optional<double> {
    std::optional<double> least;
    for (const Figures& f : figures) {
      if (!(f.*theirs)) return std::nullopt;
      const double times = *(f.*theirs) / f.*ours;
      if (!least || times < *least) least = times;
    }
    return least;
  };
  Checks checks;
  checks.at_least("HCT, constant: times as fast as GetFEM", speedup(&Figures::hct, &Figures::peer),
                  30);
  checks.at_least("Z12, constant: times as fast as GetFEM", speedup(&Figures::z12, &Figures::peer),
                  30);
  checks.at_least("HCT, varying: times as fast as GetFEM",
                  speedup(&Figures::hct_varying, &Figures::peer_varying), 10);
  checks.at_most("energy of a cubic, largest relative error",
                 std::max(figures[0].worst_energy_error, figures[1].worst_energy_error), 1e-6);
  checks.at_most("energy of a cubic by GetFEM, largest relative error",
                 figures[0].peer ? std::optional(std::max(figures[0].peer_energy_error,
                                                          figures[1].peer_energy_error))
                                 : std::nullopt,
                 1e-6);
  checks.print("assembly");
}
