// SPDX-License-Identifier: MPL-2.0
// Deforming a panel with 16 flanged holes: time to the first update, time of an edit, and
// distortion of the holes, compared with CGAL's Surface_mesh_deformation and the KKT reference
// solver.
#include <Eigen/Geometry>
#include <memory>
#include <numbers>

#include "batten/benchmarks/cgal_deform.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/editing/mesh_editor.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/kkt_deformation.h"
#include "batten/tests/support/mesh_models.h"
#include "bench.h"

using namespace batten;
using namespace batten::bench;

namespace {

/// The patch in the middle of the panel is lifted and rotated; two strips are fixed.
struct Edit {
  batten_test::MeshModel model;
  TriangleMesh mesh;
  std::vector<int> region;  // all free vertices
  Points targets;           // of the vertices of the handle

  explicit Edit(int vertices)
      : model(batten_test::holed_panel(vertices)), mesh(prepare(model.shells).mesh) {
    std::vector<char> held(static_cast<size_t>(mesh.vertex_count()), 0);
    for (const int v : model.fixed) held[v] = 1;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (!held[v]) region.push_back(v);
    Vec3 middle = Vec3::Zero();
    for (const int v : model.handle)
      middle += mesh.point(v) / static_cast<double>(model.handle.size());
    const Eigen::AngleAxisd rotation_vector(std::numbers::pi / 6, Vec3(1, 2, 0.5).normalized());
    targets.resize(static_cast<long>(model.handle.size()), 3);
    for (long i = 0; i < targets.rows(); ++i)
      targets.row(i) =
          (middle + Vec3(0, 0, 60) + rotation_vector * (mesh.point(model.handle[i]) - middle))
              .transpose();
  }

  /// Largest distance of the handle's and the fixed vertices from their targets.
  double target_error(const Points& deformed) const {
    double worst = 0;
    for (size_t i = 0; i < model.handle.size(); ++i)
      worst = std::max(worst,
                       (deformed.row(model.handle[i]) - targets.row(static_cast<long>(i))).norm());
    for (const int v : model.fixed)
      worst = std::max(worst, (deformed.row(v).transpose() - mesh.point(v)).norm());
    return worst;
  }

  /// Largest distance of a hole's boundary from its original after the best-fit rigid motion,
  /// relative to the radius; the worst hole.
  double hole_drift(const Points& deformed) const {
    double worst = 0;
    for (const auto& rim : model.rims) {
      const auto n = static_cast<long>(rim.items.size());
      Eigen::Matrix3Xd before(3, n), after(3, n);
      for (long i = 0; i < n; ++i) {
        before.col(i) = mesh.point(rim.items[i]);
        after.col(i) = deformed.row(rim.items[i]).transpose();
      }
      const Vec3 middle = before.rowwise().mean();
      const double radius = (before.col(0) - middle).norm();
      const Eigen::Matrix4d motion = Eigen::umeyama(before, after, false);
      const Eigen::Matrix3Xd moved =
          (motion.topLeftCorner<3, 3>() * before).colwise() + motion.topRightCorner<3, 1>();
      worst = std::max(worst, (moved - after).colwise().norm().maxCoeff() / radius);
    }
    return worst;
  }
};

/// A method: set-up, and the cost of each edit.
struct DeformMethod {
  std::string name;
  std::function<void()> prepare;
  std::function<Points()> edit;
};

/// Set-up and factorization as printed by Masuda et al. 2006, on a 1.5 GHz Pentium M.
struct PublishedTime {
  int vertices;
  double seconds;
};
const std::vector<PublishedTime> kPublished = {{3337, 0.86}, {13974, 4.69}};

enum class RigidFeatures { Flanges, Rims };

/// The same edit with the holes kept.
struct FormFeatureEdit {
  DeformProblem problem;
  DeformEdit edit;
  std::unique_ptr<FormFeatureDeformer> deformer;

  FormFeatureEdit(const Edit& e, RigidFeatures rigid_features) {
    problem.fixed = e.model.fixed;
    problem.handles = {{"patch", e.model.handle}};
    for (const auto& f : rigid_features == RigidFeatures::Flanges ? e.model.features : e.model.rims)
      problem.features.push_back({f.name, f.items});
    HandleTransform move;
    move.about = VertexCombination::mean_of(e.model.handle).at(e.mesh.points());
    move.rotation_vector = to_rotation_vector({1, 2, 0.5}, std::numbers::pi / 6);
    move.translation = {0, 0, 60};
    edit.handles = {move};
  }
  double rigid_error(const Edit& e) const {
    double worst = 0;
    for (const auto& f : problem.features)
      worst = std::max(
          worst, fit_similarity(e.mesh.points(), deformer->positions(), f.vertices).max_error);
    return worst;
  }
};

std::vector<DeformMethod> peers(const Edit& e) {
  const std::vector<std::pair<std::string, CgalEnergy>> energies{
      {"ARAP", CgalEnergy::Arap},
      {"spokes and rims", CgalEnergy::SpokesAndRims},
      {"smoothed rotations", CgalEnergy::SreArap}};
  const std::vector<std::pair<std::string, CgalSolver>> solvers{
      {"SparseLU (default)", CgalSolver::SparseLu},
      {"SimplicialLDLT", CgalSolver::Simplicial},
      {"CHOLMOD", CgalSolver::Cholmod}};
  std::vector<DeformMethod> methods;
  for (const auto& [energy_name, energy] : energies)
    for (const auto& [solver_name, solver] : solvers) {
      // The factor does not depend on the energy: one energy suffices for the comparison of
      // solvers.
      if (!cgal_has(solver) ||
          (solver != CgalSolver::SparseLu && energy != CgalEnergy::SpokesAndRims))
        continue;
      const auto cgal = std::make_shared<CgalDeform>(energy, solver, e.mesh.points(),
                                                     e.mesh.triangles(), e.region, e.model.handle);
      methods.push_back({"CGAL " + energy_name + ", " + solver_name, [cgal] { cgal->preprocess(); },
                         [cgal, &e] { return cgal->edit(e.targets); }});
    }
  return methods;
}

/// The same edit in an editor, whose flanges rotate with the sheet around them: one frame of a drag,
/// and the converged solution, beside deform() with prescribed rotations.
void compare_editor(int vertices, int rounds, Checks& checks) {
  const auto model = batten_test::holed_panel(vertices);
  const PreparedMesh prepared = prepare(model.shells);
  const Edit e(vertices);
  FormFeatureEdit bare(e, RigidFeatures::Flanges);
  bare.deformer = std::make_unique<FormFeatureDeformer>(e.mesh, bare.problem);
  MeshEditor editor(prepared, prepared.mesh.points(), bare.problem);
  editor.set(bare.edit);
  editor.solve_to_equilibrium();
  const Points converged = editor.shape();
  constexpr int frames = 40;
  int frame = 0;
  const auto drag = [&] {
    frame = frame % frames + 1;
    DeformEdit edit = bare.edit;
    const double fraction = static_cast<double>(frame) / frames;
    edit.handles[0].translation *= fraction;
    edit.handles[0].rotation_vector *= fraction;
    editor.set(edit);
    editor.solve_preview();
  };
  const auto times =
      side_by_side(rounds * frames, {[&] { bare.deformer->deform(bare.edit); }, drag});
  while (frame != frames) drag();
  const double behind = (editor.shape() - converged).cwiseAbs().maxCoeff() / e.mesh.size();
  editor.set(bare.edit);
  const auto whole = side_by_side(rounds, {[&] { editor.solve_to_equilibrium(); }});
  std::printf(
      "%d vertices, flanges rotate with the sheet: deform() %.2f ms, one frame of a drag %.2f ms "
      "(behind the converged shape by %.2g of the size), converged %.1f ms in %d iterations\n",
      e.mesh.vertex_count(), 1e3 * times[0], 1e3 * times[1], behind, 1e3 * whole[0],
      editor.statistics().iterations);
  checks.at_most(text("%d vertices: frame of a drag over deform()", vertices), times[1] / times[0],
                 2);
}

void compare(int vertices, int rounds, Checks& checks) {
  const Edit e(vertices);
  std::vector<DeformMethod> methods;
  std::vector<std::shared_ptr<FormFeatureEdit>> own;
  for (const RigidFeatures rigid_features : {RigidFeatures::Flanges, RigidFeatures::Rims}) {
    const auto b = std::make_shared<FormFeatureEdit>(e, rigid_features);
    own.push_back(b);
    methods.push_back({std::string("Batten, ") +
                           (rigid_features == RigidFeatures::Flanges ? "flanges" : "boundaries") +
                           " kept",
                       [b, &e] {
                         b->deformer = std::make_unique<FormFeatureDeformer>(e.mesh, b->problem);
                         b->deformer->deform(b->edit);
                       },
                       [b] { return b->deformer->deform(b->edit); }});
  }
  const size_t first_peer = methods.size();
  for (DeformMethod& method : peers(e)) methods.push_back(std::move(method));

  std::vector<std::function<void()>> preparations, edits;
  std::vector<Points> results(methods.size());
  for (size_t w = 0; w < methods.size(); ++w) {
    preparations.push_back(methods[w].prepare);
    edits.push_back([&, w] { results[w] = methods[w].edit(); });
  }
  const auto preparation = side_by_side(rounds, preparations);
  for (size_t w = 0; w < methods.size(); ++w) edits[w]();  // starting from rest
  const std::vector<Points> first = results;
  const auto edit = side_by_side(rounds, edits);

  std::printf("%d vertices, %zu fixed, %zu in the handle, %zu holes; CGAL: 5 iterations per edit\n",
              e.mesh.vertex_count(), e.model.fixed.size(), e.model.handle.size(),
              e.model.rims.size());
  const auto c = own[0]->deformer->counts();
  std::printf("flanges kept: %d feature equations, %d unknowns, %ld entries of the factor\n\n",
              c.feature_constraints, c.unknowns, c.factor_entries);
  Table table;
  table.add({"ms", "set-up", "edit", "hole distortion", "handle error"});
  for (size_t w = 0; w < methods.size(); ++w)
    table.add({methods[w].name,
               text("%.1f", 1e3 * preparation[w]) + (w < first_peer ? " with first update" : ""),
               text("%.2f", 1e3 * edit[w]), text("%.2g of the radius", e.hole_drift(first[w])),
               text("%.0e", e.target_error(first[w]))});
  {
    // The set-up of its equations is part of its time.
    Points expected;
    const double t =
        cpu_seconds_of([&] { expected = deform_by_kkt(*own[0]->deformer, own[0]->edit); });
    own[0]->deformer->correct();
    table.add({"KKT reference solver, flanges", text("%.1f with first update", 1e3 * t), "",
               text("%.2g of the radius", e.hole_drift(expected)),
               text("%.0e", e.target_error(expected))});
    checks.at_most(text("%d vertices: difference from the KKT solver over the size", vertices),
                   (expected - own[0]->deformer->positions()).cwiseAbs().maxCoeff() / e.mesh.size(),
                   1e-9);
  }
  for (const PublishedTime& p : kPublished)
    if (std::abs(p.vertices - e.mesh.vertex_count()) < 0.1 * p.vertices)
      table.add({text("Masuda 2006, %d vertices", p.vertices),
                 text("%.0f without solve", 1e3 * p.seconds), "", "", ""});
  table.print();

  // First CGAL's ORIGINAL_ARAP with the solver of its manual.
  const bool peer = methods.size() > first_peer;
  const auto ratio = [&](const std::vector<double>& times, bool inverse) {
    std::optional<double> worst;
    for (size_t w = 0; w < first_peer && peer; ++w) {
      const double r = inverse ? times[first_peer] / times[w] : times[w] / times[first_peer];
      worst = !worst ? r : inverse ? std::min(*worst, r) : std::max(*worst, r);
    }
    return worst;
  };
  if (vertices > 10000) {
    const bool large = vertices > 100000;
    checks.at_most(text("%d vertices: first update over CGAL's set-up", vertices),
                   ratio(preparation, false), large ? 2.5 : 2);
    checks.at_least(text("%d vertices: edits, CGAL's time over Batten's", vertices),
                    ratio(edit, true), large ? 10 : 20);
  }
  double error = 0;
  for (const auto& b : own) error = std::max(error, b->rigid_error(e));
  checks.at_most(text("%d vertices: rigidity error of features", vertices), error, 1e-12);
}

}  // namespace

int main() {
  one_thread();
  if (cgal_version().empty())
    std::printf("built without CGAL\n\n");
  else
    std::printf("CGAL %s\n\n", cgal_version().c_str());
  Checks checks;
  compare(3300, 5, checks);
  compare(14000, 5, checks);
  compare(101000, 3, checks);
  compare_editor(14000, 3, checks);
  compare_editor(101000, 1, checks);
  checks.print("deform");
  return 0;
}
