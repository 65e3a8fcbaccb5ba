// SPDX-License-Identifier: MPL-2.0
// Feature regions that rotate with the surrounding sheet: cost of set-up and edit compared with
// CGAL's smoothed rotations, and changes of lengths and angles inside and outside the regions.
#include <memory>

#include "batten/benchmarks/cgal_deform.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/regions/feature_region_deformer.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/mesh_models.h"
#include "region_distortion.h"
#if BATTEN_BENCH_IO
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/support/test_data.h"
#endif

using namespace batten;
using namespace batten::bench;

namespace {

/// The panel of `deform`: two strips are fixed, the patch in the middle is lifted without rotation.
struct Edit {
  batten_test::MeshModel model;
  TriangleMesh mesh;
  std::vector<Handle> handles;
  std::vector<HandleTransform> moves;
  std::vector<FeatureRegion> regions;  // flanges
  std::vector<int> movable;
  Points targets;

  explicit Edit(int vertices)
      : model(batten_test::holed_panel(vertices)),
        mesh(prepare(model.shells).mesh),
        handles({{"patch", model.handle}}) {
    HandleTransform lift;
    lift.translation = {0, 0, 60};
    moves = {lift};
    for (const auto& f : model.features) regions.push_back({f.name, {}, f.items});
    std::vector<char> held(mesh.vertex_count(), 0);
    for (const int v : model.fixed) held[v] = 1;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (!held[v]) movable.push_back(v);
    targets.resize(static_cast<long>(model.handle.size()), 3);
    for (long i = 0; i < targets.rows(); ++i)
      targets.row(i) = lift(mesh.point(model.handle[i])).transpose();
  }

  /// Largest distance of moved and fixed vertices from their targets, relative to the size.
  double target_error(const Points& p) const {
    double worst = 0;
    for (size_t i = 0; i < model.handle.size(); ++i)
      worst = std::max(worst, (p.row(model.handle[i]) - targets.row(static_cast<long>(i))).norm());
    for (const int v : model.fixed)
      worst = std::max(worst, (p.row(v).transpose() - mesh.point(v)).norm());
    return worst / mesh.size();
  }
  /// Largest deviation of a region from a rigid copy of itself, relative to its size.
  double rigidity_error(const Points& p) const {
    double worst = 0;
    for (const auto& region : regions)
      worst = std::max(worst, fit_similarity(mesh.points(), p, region.vertices, 1).max_error);
    return worst;
  }
};

/// An estimate and hard regions.
template <class Estimate, class Options>
struct ConstrainedDeformer {
  const Edit& e;
  Options options;
  std::unique_ptr<Estimate> estimate;
  std::unique_ptr<FeatureRegionDeformer> hard;

  ConstrainedDeformer(const Edit& edit, const Options& wanted) : e(edit), options(wanted) {}
  void set_up() {
    if constexpr (std::is_same_v<Estimate, DualLaplacianDeformer>)
      estimate = std::make_unique<Estimate>(e.mesh, std::vector<std::vector<int>>{}, e.model.fixed,
                                            e.handles, options);
    else
      estimate = std::make_unique<Estimate>(e.mesh, e.model.fixed, e.handles, options);
    hard = std::make_unique<FeatureRegionDeformer>(e.mesh, e.regions, e.model.fixed, e.handles);
  }
  Points edit() { return hard->deform(estimate->deform(e.moves), e.moves); }
};
using Dual = ConstrainedDeformer<DualLaplacianDeformer, DualLaplacianOptions>;
using Nonlinear = ConstrainedDeformer<ArapDeformer, ArapOptions>;

const std::vector<int> kIterations = {5, 10};

/// A method with each number of iterations.
struct DeformMethod {
  std::string name;
  bool own = true;
  std::function<void()>
      set_up;  // up to the first update with kIterations[0] iterations; CGAL: preprocess()
  std::vector<std::function<Points()>> edits;
  std::function<std::string()> to_rest;  // ms and iterations until convergence
};

std::string at_rest(double time, int iterations, bool converged) {
  return text("%.0f in %d%s", 1e3 * time, iterations, converged ? "" : ", not converged");
}

template <class Kind, class Options>
DeformMethod batten_method(const std::string& name, const Edit& e, Options options) {
  std::vector<std::shared_ptr<Kind>> all;
  for (const int iterations : kIterations) {
    Options capped = options;
    capped.max_iterations = iterations;
    capped.tolerance = 0;
    all.push_back(std::make_shared<Kind>(e, capped));
    if (iterations != kIterations[0]) all.back()->set_up();
  }
  DeformMethod method{name, true, [first = all[0]] { first->set_up(), first->edit(); }, {}, {}};
  for (const auto& kind : all) method.edits.emplace_back([kind] { return kind->edit(); });
  method.to_rest = [&e, options] {
    Kind kind(e, options);
    kind.set_up();
    const double time = cpu_seconds_of([&] { kind.edit(); });
    const IterationReport& report = kind.estimate->report();
    return at_rest(time, report.iterations, report.converged);
  };
  return method;
}

/// CGAL one iteration at a time: while a vertex moves by more than the tolerance of Batten, up to
/// 3000 iterations or half a minute.
std::string cgal_at_rest(CgalDeform& cgal, const Edit& e) {
  cgal.preprocess();
  Points before = e.mesh.points();
  double time = 0;
  for (int iterations = 1;; ++iterations) {
    Points p;
    time += cpu_seconds_of([&] { p = cgal.edit(e.targets, 1); });
    const bool rests =
        (p - before).rowwise().norm().maxCoeff() < ArapOptions{}.tolerance * e.mesh.size();
    if (rests || iterations == 3000 || time > 30) return at_rest(time, iterations, rests);
    before = std::move(p);
  }
}

DeformMethod peer(const std::string& name, const Edit& e, CgalSolver solver) {
  const auto cgal = std::make_shared<CgalDeform>(CgalEnergy::SreArap, solver, e.mesh.points(),
                                                 e.mesh.triangles(), e.movable, e.model.handle);
  DeformMethod method{name, false, [cgal] { cgal->preprocess(); }, {}, {}};
  for (const int iterations : kIterations)
    method.edits.emplace_back([cgal, &e, iterations] { return cgal->edit(e.targets, iterations); });
  method.to_rest = [cgal, &e] { return cgal_at_rest(*cgal, e); };
  return method;
}

/// Median times and errors.
struct Times {
  std::vector<double> set_up;
  std::vector<std::vector<double>> edits;       // per number of iterations and method
  double target_error = 0, rigidity_error = 0;  // the worst

  /// Speed relative to another method at the same number of iterations, the worst ratio.
  double faster(size_t own, size_t other) const {
    double worst = 1e99;
    for (const auto& edit : edits) worst = std::min(worst, edit[other] / edit[own]);
    return worst;
  }
};

Times measured(const Edit& e, const std::vector<DeformMethod>& methods, int repeats) {
  Times times;
  std::vector<std::function<void()>> works;
  for (const DeformMethod& method : methods) works.push_back(method.set_up);
  times.set_up = side_by_side(repeats, works);
  std::vector<Points> results(methods.size());
  for (size_t k = 0; k < kIterations.size(); ++k) {
    works.clear();
    for (size_t w = 0; w < methods.size(); ++w)
      works.emplace_back([&, w] { results[w] = methods[w].edits[k](); });
    times.edits.push_back(side_by_side(repeats, works));
    for (size_t w = 0; w < methods.size(); ++w) {
      times.target_error = std::max(times.target_error, e.target_error(results[w]));
      if (methods[w].own)
        times.rigidity_error = std::max(times.rigidity_error, e.rigidity_error(results[w]));
    }
  }
  return times;
}

void print(const Edit& e, const std::vector<DeformMethod>& methods, const Times& times) {
  std::printf("%d vertices, %zu flanged holes kept, a patch lifted without rotation\n",
              e.mesh.vertex_count(), e.regions.size());
  Table table;
  table.add({"ms", "set-up", "edit, 5 iterations", "10 iterations", "to convergence"});
  for (size_t w = 0; w < methods.size(); ++w) {
    const bool slower_peer = !methods[w].own && w + 1 < methods.size();
    table.add({methods[w].name,
               text("%.1f", 1e3 * times.set_up[w]) + (methods[w].own ? " with first update" : ""),
               text("%.2f", 1e3 * times.edits[0][w]), text("%.2f", 1e3 * times.edits[1][w]),
               slower_peer ? "" : methods[w].to_rest()});
  }
  table.print();
  for (size_t other = 2; other < methods.size(); ++other)
    std::printf("edits against %s: dual Laplacian %.2f, nonlinear %.2f times as fast\n",
                methods[other].name.c_str(), times.faster(0, other), times.faster(1, other));
  std::printf("\n");
}

void compare(int vertices, int repeats, Checks& checks) {
  const Edit e(vertices);
  std::vector<DeformMethod> methods = {
      batten_method<Dual>("dual Laplacian, hard regions", e, DualLaplacianOptions{}),
      batten_method<Nonlinear>("nonlinear, hard regions", e, ArapOptions{})};
  const bool has_peer = !cgal_version().empty();
  if (has_peer) methods.push_back(peer("CGAL, SparseLU (default)", e, CgalSolver::SparseLu));
  if (has_peer && cgal_has(CgalSolver::Cholmod))
    methods.push_back(peer("CGAL, CHOLMOD", e, CgalSolver::Cholmod));
  const Times times = measured(e, methods, repeats);
  print(e, methods, times);
  std::optional<double> faster;
  if (has_peer) faster = times.faster(0, 2);
  checks.at_least(text("%d vertices: edits, CGAL's time over Batten's, dual Laplacian", vertices),
                  faster, 3);
  checks.at_most(text("%d vertices: error of handles over the size", vertices), times.target_error,
                 1e-12);
  checks.at_most(text("%d vertices: rigidity error of regions over their size", vertices),
                 times.rigidity_error, 1e-12);
}

void check_distortion(const batten_test::FeaturedModel& model, double& hard, Checks& checks) {
  const DistortionSummary kept = distortion_of(model);
  checks.at_most(model.name + ": largest edge change inside, soft", kept.soft, 0.01);
  checks.at_most(model.name + ": mean edge change outside, hard over its estimate", kept.outside,
                 1.2);
  if (kept.tilt_apart)
    checks.at_most(model.name + ": angle between region and sheet, degrees", kept.tilt_apart, 1);
  hard = std::max(hard, kept.hard);
}

/// Real meshes that are not part of the repository.
std::vector<batten_test::FeaturedModel> real_models() {
  std::vector<batten_test::FeaturedModel> models;
#if BATTEN_BENCH_IO
  for (const char* file : {"meshes-cgal/cactus.off", "meshes-cgal/hand.off", "meshes-cgal/head.off",
                           "meshes-geometry-central/spot.ply"}) {
    const auto path = batten_test::optional_data(file);
    if (path.empty())
      std::printf("skipped: %s is missing (BATTEN_TEST_DATA)\n\n", file);
    else
      models.push_back(
          pushed_sideways(path.filename().string(), prepare(MeshFile::read(path).shells()).mesh));
  }
#else
  std::printf("skipped: real meshes (built without file formats)\n\n");
#endif
  return models;
}

}  // namespace

int main() {
  one_thread();
  if (cgal_version().empty())
    std::printf("built without CGAL\n\n");
  else
    std::printf("CGAL %s, SRE_ARAP\n\n", cgal_version().c_str());
  Checks checks;
  compare(3300, 5, checks);
  compare(14000, 5, checks);
  compare(101000, 3, checks);

  double hard = 0;
  check_distortion(batten_test::lifted_panel(80), hard, checks);
  check_distortion(batten_test::wall_with_letters(20), hard, checks);
  check_distortion(batten_test::arm_with_suckers(72), hard, checks);
  check_distortion(batten_test::twisted_bar(12), hard, checks);
  for (const auto& model : real_models()) check_distortion(model, hard, checks);
  checks.at_most("all models: largest edge change inside, hard", hard, 1e-10);
  checks.print("regions");
  return 0;
}
