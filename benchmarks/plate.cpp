// SPDX-License-Identifier: MPL-2.0
// A clamped plate from the mesh to the solution: Batten compared with GetFEM and FreeFEM.
// Δ²w = f on the unit square, w = sin²(πx) sin²(πy), n × n squares cut along the same diagonals,
// the HCT triangle on all sides. Time: mesh, stiffness, load, boundary conditions, factor and
// solution. Each program measures the H2 seminorm of the error with a fine rule, outside of the
// timing.
#include <cmath>
#include <numbers>
#include <sstream>

#include "batten/benchmarks/getfem_hct.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/clamped_boundary.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;
using std::numbers::pi;

double plate_load(const Vec2& p) {
  const double cu = std::cos(2 * pi * p.x()), cv = std::cos(2 * pi * p.y());
  return 4 * std::pow(pi, 4) * (4 * cu * cv - cu - cv);
}

Vec3 exact_second(const Vec2& p) {  // uu, uv, vv
  const double su = std::sin(pi * p.x()), sv = std::sin(pi * p.y());
  return pi * pi *
         Vec3(2 * std::cos(2 * pi * p.x()) * sv * sv,
              std::sin(2 * pi * p.x()) * std::sin(2 * pi * p.y()),
              2 * std::cos(2 * pi * p.y()) * su * su);
}

double h2_error(const SurfaceAssembler& assembler, const Points& w) {
  const ParametricMesh& mesh = assembler.mesh();
  const TriangleRule rule = split_triangle_rule(8);
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const C1Triangle element(assembler.kind(), mesh.shape(t));
    const auto dof = assembler.dofs().triangle(mesh, t);
    Vec12 q;
    for (int a = 0; a < 12; ++a) q[a] = w(dof[a], 0);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p);
      const Vec3 error = element.evaluate(L).rightCols<3>().transpose() * q -
                         exact_second(element.shape().point(L));
      sum += element.shape().area * rule.weights[p] *
             (error[0] * error[0] + 2 * error[1] * error[1] + error[2] * error[2]);
    }
  }
  return std::sqrt(sum);
}

PlateRun batten_plate(int n) {
  PlateRun run;
  const double start = seconds();
  const ParametricMesh mesh = ParametricMesh::unit_square(n);
  const double meshed = seconds();
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  SparseMatrix K = assembler.stiffness(SurfaceStiffness::isotropic(0, 1));
  const double assembled = seconds();
  // The degree that the peers use.
  const Points F =
      assembler.load([](const Location&, const Vec2& p) { return Vec3(plate_load(p), 0, 0); }, 4);
  const double loaded = seconds();
  const ConstrainedSolver solver(batten_test::clamped_boundary(mesh), std::move(K),
                                 nested_dissection_order(mesh));
  const Points w = solver.solve(F);
  run.solve = seconds() - loaded;
  run.mesh = meshed - start;
  run.stiffness = assembled - meshed;
  run.load = loaded - assembled;
  run.unknowns = solver.reduction().free_count();
  run.h2_error = h2_error(assembler, w);
  return run;
}

// Nothing if FreeFEM is missing or fails. The time excludes its start and the parsing of the
// script.
std::optional<PlateRun> freefem_plate(int n, const std::string& solver) {
  // Debian's package keeps its plug-ins in a folder that its own settings do not contain.
  const std::string command =
      "FF_LOADPATH=/usr/lib/freefem++ OPENBLAS_NUM_THREADS=1 OMP_THREAD_LIMIT=1 "
      "FreeFem++ -nw -v 0 '" BATTEN_BENCH_EDP "' " +
      solver + " " + std::to_string(n) + " 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return std::nullopt;
  std::string output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
  pclose(pipe);
  const size_t at = output.find("BATTEN ");
  if (at == std::string::npos) return std::nullopt;
  std::istringstream numbers(output.substr(at + 7));
  PlateRun run;
  if (!(numbers >> run.mesh >> run.stiffness >> run.load >> run.solve >> run.h2_error >>
        run.unknowns))
    return std::nullopt;
  return run;
}

PlateRun middle(const std::vector<PlateRun>& runs) {
  const auto of = [&](double PlateRun::*stage) {
    std::vector<double> values;
    for (const PlateRun& r : runs) values.push_back(r.*stage);
    return median(std::move(values));
  };
  PlateRun run = runs.front();
  run.mesh = of(&PlateRun::mesh);
  run.stiffness = of(&PlateRun::stiffness);
  run.load = of(&PlateRun::load);
  run.solve = of(&PlateRun::solve);
  return run;
}

struct Side {
  std::string name;
  std::function<std::optional<PlateRun>(int n)> run;
};

}  // namespace

int main() {
  one_thread();
  const bool getfem = !getfem_version().empty();
  const bool freefem = freefem_plate(4, "CHOLMOD").has_value();
  std::printf("GetFEM %s, FreeFEM %s. Processor time on one thread, medians, milliseconds.\n\n",
              getfem ? getfem_version().c_str() : "is missing", freefem ? "found" : "is missing");

  std::vector<Side> sides = {{"Batten", batten_plate}};
  if (getfem) {
    const auto peer = [](GetfemAssemblyMode assembly_mode, GetfemSolver solver) {
      return [=](int n) {
        return getfem_plate(ParametricMesh::unit_square(n), assembly_mode, solver);
      };
    };
    sides.push_back(
        {"GetFEM classical, gmm MUMPS", peer(GetfemAssemblyMode::Classical, GetfemSolver::Gmm)});
    sides.push_back(
        {"GetFEM language, gmm MUMPS", peer(GetfemAssemblyMode::Language, GetfemSolver::Gmm)});
    sides.push_back({"GetFEM language, MUMPS positive",
                     peer(GetfemAssemblyMode::Language, GetfemSolver::Positive)});
  }
  if (freefem)
    for (const char* solver : {"UMFPACK", "CHOLMOD", "MUMPS"})
      sides.push_back(
          {std::string("FreeFEM ") + solver, [solver](int n) { return freefem_plate(n, solver); }});

  Checks checks;
  for (const int n : {32, 64, 128}) {
    const int rounds = n == 128 ? 3 : 5;
    const int warm_up = n == 32 ? 1 : 0;
    std::vector<std::vector<PlateRun>> runs(sides.size());
    for (int round = -warm_up; round < rounds; ++round)
      for (size_t s = 0; s < sides.size(); ++s)
        if (const auto run = sides[s].run(n); run && round >= 0) runs[s].push_back(*run);

    Table table;
    table.add({"n = " + std::to_string(n), "mesh", "stiffness", "load", "solve", "total",
               "over Batten's time", "H2 error"});
    const PlateRun ours = middle(runs[0]);
    std::optional<double> fastest[2], error[2];  // GetFEM, FreeFEM
    for (size_t s = 0; s < sides.size(); ++s) {
      if (runs[s].empty()) continue;
      const PlateRun run = middle(runs[s]);
      table.add({sides[s].name, text("%.1f", 1e3 * run.mesh), text("%.1f", 1e3 * run.stiffness),
                 text("%.1f", 1e3 * run.load), text("%.1f", 1e3 * run.solve),
                 text("%.1f", 1e3 * run.total()), text("%.2f", run.total() / ours.total()),
                 text("%.8g", run.h2_error)});
      if (s == 0) continue;
      const int peer = sides[s].name.starts_with("GetFEM") ? 0 : 1;
      if (!error[peer] || run.h2_error < *error[peer]) error[peer] = run.h2_error;
      // GetFEM's matrix with MUMPS called directly is listed, but not part of a check.
      if (sides[s].name.ends_with("positive")) continue;
      if (!fastest[peer] || run.total() < *fastest[peer]) fastest[peer] = run.total();
    }
    table.print();
    const auto over = [](std::optional<double> a, double b) {
      return a ? std::optional(*a / b) : std::nullopt;
    };
    const std::string size = "n = " + std::to_string(n);
    checks.at_least(size + ": GetFEM's time with MUMPS over Batten's",
                    over(fastest[0], ours.total()), n == 32 ? 3 : 4);
    checks.at_most(size + ": H2 error over GetFEM's",
                   error[0] ? std::optional(ours.h2_error / *error[0]) : std::nullopt, 1.0001);
    checks.at_most(size + ": H2 error over FreeFEM's",
                   error[1] ? std::optional(ours.h2_error / *error[1]) : std::nullopt, 1.0001);
  }
  checks.print("plate");
}
