// Deforming a holed panel: preparation, edits, and what becomes of the holes; beside CGAL's
// Surface_mesh_deformation.
#include <Eigen/Geometry>
#include <memory>
#include <numbers>

#include "batten/mesh/prepare.h"
#include "batten/tests/mesh_models.h"
#include "bench.h"
#include "cgal_deform_peer.h"

using namespace batten;
using namespace batten::bench;

namespace {

/// The panel's patch in the middle is lifted and turned, its two strips are held.
struct Edit {
  batten_test::MeshModel model;
  TriangleMesh mesh;
  std::vector<int> region;  // all vertices that are not held
  Points targets;           // of the handle's vertices

  explicit Edit(int vertices)
      : model(batten_test::holed_panel(vertices)), mesh(prepare(model.shells).mesh) {
    std::vector<char> held(static_cast<size_t>(mesh.vertex_count()), 0);
    for (const int v : model.fixed) held[v] = 1;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (!held[v]) region.push_back(v);
    Vec3 middle = Vec3::Zero();
    for (const int v : model.handle)
      middle += mesh.point(v) / static_cast<double>(model.handle.size());
    const Eigen::AngleAxisd turn(std::numbers::pi / 6, Vec3(1, 2, 0.5).normalized());
    targets.resize(static_cast<long>(model.handle.size()), 3);
    for (long i = 0; i < targets.rows(); ++i)
      targets.row(i) =
          (middle + Vec3(0, 0, 60) + turn * (mesh.point(model.handle[i]) - middle)).transpose();
  }

  /// Largest distance of the handle's and the held vertices from where they should be.
  double missed(const Points& deformed) const {
    double worst = 0;
    for (size_t i = 0; i < model.handle.size(); ++i)
      worst = std::max(worst,
                       (deformed.row(model.handle[i]) - targets.row(static_cast<long>(i))).norm());
    for (const int v : model.fixed)
      worst = std::max(worst, (deformed.row(v).transpose() - mesh.point(v)).norm());
    return worst;
  }

  /// Largest distance of a hole's rim from its original after the best motion without scaling,
  /// over the radius; the worst hole.
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

/// A way to deform: what is done once, what each edit costs.
struct Way {
  std::string name;
  std::function<void()> prepare;
  std::function<Points()> edit;
};

std::vector<Way> peers(const Edit& e) {
  const std::vector<std::pair<std::string, CgalEnergy>> energies{
      {"ARAP", CgalEnergy::Arap},
      {"spokes and rims", CgalEnergy::SpokesAndRims},
      {"smoothed rotations", CgalEnergy::SreArap}};
  const std::vector<std::pair<std::string, CgalSolver>> solvers{
      {"SparseLU (default)", CgalSolver::SparseLu},
      {"SimplicialLDLT", CgalSolver::Simplicial},
      {"CHOLMOD", CgalSolver::Cholmod}};
  std::vector<Way> ways;
  for (const auto& [energy_name, energy] : energies)
    for (const auto& [solver_name, solver] : solvers) {
      // The factor does not know the energy: one energy shows what other solvers do.
      if (!cgal_has(solver) ||
          (solver != CgalSolver::SparseLu && energy != CgalEnergy::SpokesAndRims))
        continue;
      const auto cgal = std::make_shared<CgalDeform>(energy, solver, e.mesh.points(),
                                                     e.mesh.triangles(), e.region, e.model.handle);
      ways.push_back({"CGAL " + energy_name + ", " + solver_name, [cgal] { cgal->preprocess(); },
                      [cgal, &e] { return cgal->edit(e.targets); }});
    }
  return ways;
}

void compare(int vertices, int rounds) {
  const Edit e(vertices);
  const std::vector<Way> ways = peers(e);
  std::vector<std::function<void()>> preparations, edits;
  std::vector<Points> results(ways.size());
  for (size_t w = 0; w < ways.size(); ++w) {
    preparations.push_back(ways[w].prepare);
    edits.push_back([&, w] { results[w] = ways[w].edit(); });
  }
  const auto preparation = side_by_side(rounds, preparations);
  for (size_t w = 0; w < ways.size(); ++w) edits[w]();  // from rest
  const std::vector<Points> first = results;
  const auto edit = side_by_side(rounds, edits);

  std::printf("%d vertices, %zu held, %zu in the handle, %zu holes; 5 iterations an edit\n\n",
              e.mesh.vertex_count(), e.model.fixed.size(), e.model.handle.size(),
              e.model.rims.size());
  Table table;
  table.add({"ms", "preparation", "an edit", "holes out of shape", "handle missed by"});
  for (size_t w = 0; w < ways.size(); ++w)
    table.add({ways[w].name, text("%.1f", 1e3 * preparation[w]), text("%.1f", 1e3 * edit[w]),
               text("%.2g of the radius", e.hole_drift(first[w])),
               text("%.0e", e.missed(first[w]))});
  table.print();
}

}  // namespace

int main() {
  one_thread();
  if (cgal_version().empty())
    std::printf("built without CGAL\n\n");
  else
    std::printf("CGAL %s\n\n", cgal_version().c_str());
  compare(3300, 5);
  compare(14000, 3);
  compare(101000, 1);
  Promises promises;
  promises.print("deform");
  return 0;
}
