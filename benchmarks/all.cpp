// SPDX-License-Identifier: MPL-2.0
// The tasks of all other benchmarks at small sizes, in a few minutes, to detect slowdowns.
// Each task alternates with a reference computation that is independent of Batten (a dense
// factorization, a pass through memory, a sort). The ratio of both is compared with baseline.json:
// it depends little on the machine. Peers and accuracy belong to the other benchmarks.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/geometry.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/step/step.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/mesh_models.h"
#include "batten/tests/support/session_scenes.h"
#include "batten/tests/support/solver_matrices.h"
#include "bench.h"
#include "cases.h"

namespace {

namespace fs = std::filesystem;
using namespace batten;
using namespace batten::bench;

// Reference computation of a few milliseconds: arithmetic in the cache, memory traffic, branches.
void calibration() {
  static const MatX A = [] {
    MatX a = MatX::Random(160, 160);
    return MatX(a * a.transpose() + 160 * MatX::Identity(160, 160));
  }();
  static std::vector<double> from(1 << 20, 1.0), to(1 << 20, 2.0);
  static const std::vector<std::uint32_t> numbers = [] {
    std::mt19937 random(1);
    std::vector<std::uint32_t> n(30000);
    for (auto& x : n) x = random();
    return n;
  }();
  volatile double keep = Eigen::LLT<MatX>(A).matrixLLT()(159, 159);
  for (size_t i = 0; i < from.size(); ++i) to[i] = 0.5 * to[i] + from[i];
  std::vector<std::uint32_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  keep = keep + to[7] + sorted[7];
}

struct Task {
  std::string name;
  std::function<void()> work;
};

struct Measured {
  double seconds, ratio;  ///< medians; ratio: seconds over those of the reference computation
};

// Short tasks are repeated, for the resolution of the clock.
Measured measure(const Task& task) {
  constexpr double worth_timing = 0.03;
  constexpr int rounds = 7;
  task.work();
  int repeats = 1;
  while (cpu_seconds_of([&] {
           for (int i = 0; i < repeats; ++i) task.work();
         }) < worth_timing &&
         repeats < 4096)
    repeats *= 2;
  std::vector<double> times, ratios;
  for (int round = 0; round < rounds; ++round) {
    const auto unit = [] {
      return cpu_seconds_of([] {
               for (int i = 0; i < 4; ++i) calibration();
             }) /
             4;
    };
    const double before = unit();
    const double t = cpu_seconds_of([&] {
                       for (int i = 0; i < repeats; ++i) task.work();
                     }) /
                     repeats;
    const double after = unit();
    times.push_back(t);
    ratios.push_back(2 * t / (before + after));
  }
  return {median(times), median(ratios)};
}

SkinOptions edges(double length) {
  SkinOptions options;
  options.edge_length = length;
  return options;
}

void add_kernel_tasks(std::vector<Task>& tasks) {
  const auto square = std::make_shared<ParametricMesh>(ParametricMesh::unit_square(64));
  const auto assembler = std::make_shared<SurfaceAssembler>(*square, TriangleElement::HCT);
  const auto K = std::make_shared<SparseMatrix>(assembler->pattern());
  tasks.push_back({"assembly: constant material, 8,192 triangles", [=] {
                     (void)square;
                     assembler->stiffness(SurfaceStiffness::isotropic(0, 1), *K);
                   }});
  tasks.push_back({"assembly: varying material, 8,192 triangles", [=] {
                     (void)square;
                     assembler->stiffness(
                         [](const Vec2& p) { return SurfaceStiffness::isotropic(0, 1 + p.x()); },
                         *K);
                   }});
  tasks.push_back({"plate: clamped, 48 × 48", [] {
                     const ParametricMesh mesh = ParametricMesh::unit_square(48);
                     const SurfaceAssembler plate(mesh, TriangleElement::HCT);
                     const ConstrainedSolver solver(
                         batten_test::clamped_boundary(mesh),
                         plate.stiffness(SurfaceStiffness::isotropic(0, 1)),
                         nested_dissection_order(mesh));
                     solver.solve(plate.load(Vec3(0, 0, 1)));
                   }});
  const auto sheet = std::make_shared<SparseMatrix>(batten_test::holed_sheet(14600).normal);
  const auto cholesky = std::make_shared<SparseCholesky>();
  cholesky->analyze(*sheet);
  cholesky->factorize(*sheet);
  const auto b = std::make_shared<MatX>(MatX::Random(sheet->rows(), 3));
  tasks.push_back({"solve: analysis, 14,000 unknowns", [=] { SparseCholesky().analyze(*sheet); }});
  tasks.push_back({"solve: factorization", [=] { cholesky->factorize(*sheet); }});
  tasks.push_back({"solve: three columns", [=] { cholesky->solve_in_place(*b); }});
}

void add_curve_tasks(std::vector<Task>& tasks) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.003);
  std::vector<Vec3> helix;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.05 * i;
    helix.push_back(Vec3(std::cos(t), std::sin(t), 0.1 * t) +
                    Vec3(noise(random), noise(random), noise(random)));
  }
  tasks.push_back({"curves: fit of 200 points", [=] {
                     FitOptions options;
                     options.tolerance = 0.01;
                     fit_points("helix", helix, options);
                   }});
  tasks.push_back({"curves: fairing of 200 points", [=] { fair_points("helix", helix); }});
}

void add_skin_tasks(std::vector<Task>& tasks) {
  for (const CurvedLoop& c : {pentagon(), patch()})
    tasks.push_back({"fill: " + c.name, [c] {
                       ModelLayout({c.name, lines_of(c), edges(c.edge_length)}).minimize_energy({});
                     }});
  tasks.push_back({"skin: door with embedded curves",
                   [] { ModelLayout(batten_test::door_layout(27, 0.1)).minimize_energy({}); }});
  const auto door = std::make_shared<ModelLayout>(batten_test::door_layout(27, 0.1));
  const auto dofs = std::make_shared<Points>(door->minimize_energy({}));
  tasks.push_back({"skin: quality of the door", [=] { batten::measure(door->skinned(0, *dofs)); }});
  const auto lines = std::make_shared<std::vector<CharacterLine>>(wavy_grid(9, 9));
  const auto network = std::make_shared<CurveNetwork>(*lines);
  const auto found = std::make_shared<FoundRegions>(find_regions(*network));
  tasks.push_back({"network: contacts and edges of 20 curves", [=] { CurveNetwork n(*lines); }});
  tasks.push_back({"network: search for 81 faces", [=] { find_regions(*network); }});
  for (const bool smooth : {false, true})
    tasks.push_back({std::string("network: 81 faces, ") + (smooth ? "smooth" : "creases"), [=] {
                       ModelOptions options;
                       options.skin.edge_length = 0.03;
                       options.crease_angle_deg = smooth ? 180 : -1;
                       skin_network(*network, *found, options);
                     }});
}

void add_drag_tasks(std::vector<Task>& tasks) {
  const auto layout =
      std::make_shared<RegionLayout>("plate", arched_plate(), batten_test::skin(0.0222, 1e-4));
  tasks.push_back({"drag: first update and frame, 18,000 unknowns", [=] {
                     SculptingSession session(*layout, SessionOptions());
                     session.frame();
                   }});
  const auto session = std::make_shared<SculptingSession>(*layout, SessionOptions());
  session->add(Constraint{"pin", Constraint::Point{{0.43, 0.57, 0.1}, {0.43, 0.57, 0.1}}});
  session->add(Load{"push", Load::Uniform{{0, 0, 1}, {}}});
  session->add(Load{"lean", Load::Uniform{{1, 0, 0}, {}}});
  const auto drag = [&](const std::string& what, const std::string& parameter, double from,
                        double step) {
    const int index = session->parameters().index(parameter);
    tasks.push_back({"drag: " + what, [=, k = 0]() mutable {
                       session->set(index, from + step * (++k % 7));
                       session->solve_preview();
                       session->frame();
                     }});
  };
  drag("a point", "pin.z", 0.1, 0.01);
  drag("superposed loads", "push", 0, 0.1);
  drag("stiffness", "beta", 1, 0.1);
  const auto inflated = std::make_shared<SculptingSession>(*layout, SessionOptions());
  inflated->add(Load{"pressure", Load::Pressure{}});
  const int pressure = inflated->parameters().index("pressure");
  tasks.push_back({"drag: pressure", [=, k = 0]() mutable {
                     inflated->set(pressure, 5 + 0.2 * (++k % 7));
                     inflated->solve_preview();
                     inflated->frame();
                   }});
}

void add_deform_tasks(std::vector<Task>& tasks) {
  const batten_test::MeshModel model = batten_test::holed_panel(3457);
  const auto mesh = std::make_shared<TriangleMesh>(prepare(model.shells).mesh);
  DeformProblem problem;
  problem.fixed = model.fixed;
  problem.handles = {{"patch", model.handle}};
  for (const auto& f : model.features) problem.features.push_back({f.name, f.items});
  HandleTransform move;
  move.about = VertexCombination::mean_of(model.handle).at(mesh->points());
  move.rotation_vector = to_rotation_vector({1, 2, 0.5}, 0.5);
  move.translation = {0, 0, 60};
  const auto edit = std::make_shared<DeformEdit>();
  edit->handles = {move};
  tasks.push_back({"deform: first update, 3,457 vertices",
                   [=] { FormFeatureDeformer(*mesh, problem).deform(*edit); }});
  const auto deformer = std::make_shared<FormFeatureDeformer>(*mesh, problem);
  tasks.push_back({"deform: edit", [=, k = 0]() mutable {
                     edit->handles[0].translation.z() = 60 + (++k % 7);
                     deformer->deform(*edit);
                   }});
}

void add_file_tasks(std::vector<Task>& tasks, const fs::path& folder) {
  const auto region = [](const ModelLayout& layout) {
    return std::make_shared<SkinnedRegion>(layout.skinned(0, layout.minimize_energy({})));
  };
  const CurvedLoop c = pentagon();
  const auto five = region(ModelLayout({c.name, lines_of(c), edges(c.edge_length)}));
  const auto door = region(ModelLayout(batten_test::door_layout(27, 0.1)));
  tasks.push_back({"files: STEP of a pentagon, exact",
                   [=] { write_step(folder / "exact.step", {five.get()}, 0.001); }});
  tasks.push_back({"files: STEP of the door, one face", [=] {
                     StepFaceOptions options;
                     options.tolerance = 0.2;
                     write_step_faces(folder / "face.step", {door.get()}, 0.001, options);
                   }});
  tasks.push_back(
      {"files: vtp of the door", [=] { write_vtp(folder / "door.vtp", {door.get()}); }});
  tasks.push_back(
      {"files: vtu of the door", [=] { write_vtu(folder / "door.vtu", {door.get()}); }});
  tasks.push_back({"files: CalculiX deck of the door", [=] {
                     ShellDeck deck;
                     deck.thickness = 1;
                     deck.young = 210000;
                     deck.poisson = 0.3;
                     deck.supports = {ShellDeck::Support::clamped("outline")};
                     deck.pressure = 0.01;
                     write_calculix(folder / "door.inp", {door.get()}, deck);
                   }});
  if (!std::getenv("DISPLAY")) {
    std::printf("no display: pictures are skipped\n");
    return;
  }
  tasks.push_back({"files: picture of a pentagon", [=] {
                     PictureScene scene;
                     scene.regions = {five.get()};
                     draw_picture(folder / "pentagon.png", scene);
                   }});
}

nlohmann::json read_baseline(const std::string& file) {
  std::ifstream in(file);
  return in ? nlohmann::json::parse(in) : nlohmann::json::object();
}

}  // namespace

// bench_all BASELINE [PREFIX]: compares with the file; --new-baseline BASELINE writes it. PREFIX:
// only tasks whose name begins with it.
int main(int argc, char** argv) {
  one_thread();
  const bool renew = argc > 1 && std::string(argv[1]) == "--new-baseline";
  const std::string file = argc > 1 + renew ? argv[1 + renew] : BATTEN_BENCH_BASELINE;
  const std::string word = argc > 2 + renew ? argv[2 + renew] : "";
  const fs::path folder =
      fs::temp_directory_path() / ("batten_bench_all_" + std::to_string(getpid()));
  fs::create_directories(folder);

  std::vector<Task> tasks;
  add_kernel_tasks(tasks);
  add_curve_tasks(tasks);
  add_skin_tasks(tasks);
  add_drag_tasks(tasks);
  add_deform_tasks(tasks);
  add_file_tasks(tasks, folder);

  nlohmann::json baseline = read_baseline(file);
  Checks checks;
  Table table;
  table.add({"task", "ms", "relative time", "over baseline"});
  constexpr double most = 1.15;  // the variation on a virtual machine is a few percent
  for (const Task& task : tasks) {
    if (task.name.rfind(word, 0) != 0) continue;
    const Measured m = measure(task);
    std::optional<double> change;
    if (baseline.contains(task.name)) change = m.ratio / baseline[task.name].get<double>();
    table.add({task.name, text("%.3g", 1e3 * m.seconds), text("%.3g", m.ratio),
               change ? text("%.2f", *change) : "new"});
    if (renew)
      baseline[task.name] = std::round(m.ratio * 1e4) / 1e4;
    else
      checks.at_most(task.name + ": time over the baseline", change, most);
  }
  table.print();
  fs::remove_all(folder);
  if (renew) {
    std::ofstream(file) << baseline.dump(2) << "\n";
    std::printf("wrote %s\n", file.c_str());
  }
  checks.print("all");
}
