// SPDX-License-Identifier: MPL-2.0
#include "region_distortion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "batten/benchmarks/cgal_deform.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/regions/feature_region_deformer.h"
#include "batten/mesh/selection.h"

namespace batten::bench {
namespace {

using batten_test::FeaturedModel;

constexpr int kMostOfCgal = 3000;

/// Weighted mean and maximum.
struct Sum {
  Spread spread;
  long count = 0;
  void add(double value) {
    spread.most = std::max(spread.most, value);
    spread.mean += value;
    ++count;
  }
  Spread result() const {
    return {spread.most, spread.mean / static_cast<double>(std::max(1L, count))};
  }
};

double angle_at(const Points& p, int a, int b, int c) {
  const Vec3 u = (p.row(b) - p.row(a)).transpose(), v = (p.row(c) - p.row(a)).transpose();
  return std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / std::numbers::pi;
}

/// Triangles inside regions, and vertices with prescribed positions.
struct Parts {
  std::vector<char> inside, held;

  explicit Parts(const FeaturedModel& m)
      : inside(m.mesh.triangle_count(), 0), held(m.mesh.vertex_count(), 0) {
    for (const auto& region : m.regions)
      for (const int t : faces_of(m.mesh, region)) inside[t] = 1;
    for (const int v : m.fixed) held[v] = 1;
    for (const auto& handle : m.handles)
      for (const int v : handle.vertices) held[v] = 1;
  }
};

Distortion measured(const TriangleMesh& mesh, const Points& after, const Parts& parts) {
  Sum edges[2], angles[2];
  for (const auto& e : mesh.topology().edges()) {
    if (parts.held[e.low] && parts.held[e.high]) continue;
    const bool inside =
        (e.left >= 0 && parts.inside[e.left]) || (e.right >= 0 && parts.inside[e.right]);
    const double before = (mesh.point(e.low) - mesh.point(e.high)).norm();
    edges[inside].add(std::abs((after.row(e.low) - after.row(e.high)).norm() / before - 1));
  }
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& v = mesh.triangles()[t];
    if (parts.held[v[0]] && parts.held[v[1]] && parts.held[v[2]]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
      angles[parts.inside[t] != 0].add(
          std::abs(angle_at(after, a, b, c) - angle_at(mesh.points(), a, b, c)));
    }
  }
  return {edges[1].result(), angles[1].result(), edges[0].result(), angles[0].result()};
}

/// The harmonic field of the handles' rotations, regions as form features.
Points harmonic(const FeaturedModel& m) {
  DeformProblem problem;
  problem.fixed = m.fixed;
  problem.handles = m.handles;
  for (const auto& region : m.regions)
    problem.features.push_back(
        {region.name, vertices_of_triangles(m.mesh.topology(), faces_of(m.mesh, region))});
  FormFeatureDeformer deformer(m.mesh, problem);
  DeformEdit edit;
  edit.handles = m.moves;
  return deformer.deform(edit);
}

/// CGAL's smoothed rotations: the handle is dragged to its target in ten steps, then until no
/// vertex moves by more than 1e-6 of the size, as for Batten, which takes a tenth of the
/// iterations.
Points by_cgal(const FeaturedModel& m, int& iterations) {
  std::vector<int> controls, region(m.mesh.vertex_count());
  std::iota(region.begin(), region.end(), 0);
  auto fixed = m.fixed;
  std::sort(fixed.begin(), fixed.end());
  region = difference_of(region, fixed);
  for (const auto& handle : m.handles)
    controls.insert(controls.end(), handle.vertices.begin(), handle.vertices.end());
  const auto targets = [&](double fraction) {
    Points at(static_cast<long>(controls.size()), 3);
    long row = 0;
    for (size_t h = 0; h < m.handles.size(); ++h) {
      HandleTransform move = m.moves[h];
      move.rotation_vector *= fraction;
      move.translation *= fraction;
      for (const int v : m.handles[h].vertices) at.row(row++) = move(m.mesh.point(v)).transpose();
    }
    return at;
  };
  CgalDeform cgal(CgalEnergy::SreArap,
                  cgal_has(CgalSolver::Cholmod) ? CgalSolver::Cholmod : CgalSolver::SparseLu,
                  m.mesh.points(), m.mesh.triangles(), region, controls);
  cgal.preprocess();
  for (int step = 1; step < 10; ++step) cgal.edit(targets(0.1 * step), 5);
  const Points there = targets(1);
  Points p = cgal.edit(there, 1), before;
  iterations = 1;
  do {
    before = p;
    p = cgal.edit(there, 1);
  } while (++iterations < kMostOfCgal &&
           (p - before).rowwise().norm().maxCoeff() > 1e-6 * m.mesh.size());
  return p;
}

/// The rows of one model's table.
class DistortionTable {
 public:
  explicit DistortionTable(const FeaturedModel& m) : m_(m), parts_(m) {
    std::vector<std::string> head = {"largest / mean change", "edges inside",   "angles inside",
                                     "edges outside",         "angles outside", "iterations"};
    if (!m.ring.empty()) head.emplace_back("region to sheet, deg");
    table_.add(head);
  }
  Distortion add(const std::string& name, const Points& p, const std::string& iterations = "") {
    const Distortion d = measured(m_.mesh, p, parts_);
    const auto percent = [](const Spread& s) {
      return text("%.2g / %.2g %%", 100 * s.most, 100 * s.mean);
    };
    const auto degrees = [](const Spread& s) { return text("%.2g / %.2g°", s.most, s.mean); };
    std::vector<std::string> row = {name,
                                    percent(d.edges_inside),
                                    degrees(d.angles_inside),
                                    percent(d.edges_outside),
                                    degrees(d.angles_outside),
                                    iterations};
    if (!m_.ring.empty())
      row.push_back(text("%.2f, %.2f", batten_test::tilt_degrees(p, m_.regions[0].vertices),
                         batten_test::tilt_degrees(p, m_.ring)));
    table_.add(row);
    return d;
  }
  void print() const { table_.print(); }

 private:
  const FeaturedModel& m_;
  Parts parts_;
  Table table_;
};

std::string iterations_of(const IterationReport& report) {
  return std::to_string(report.iterations) + (report.converged ? "" : ", not converged");
}

}  // namespace

DistortionSummary distortion_of(const FeaturedModel& m) {
  std::printf("%s: %d vertices, %zu regions\n", m.name.c_str(), m.mesh.vertex_count(),
              m.regions.size());
  DistortionTable rows(m);
  DualLaplacianDeformer dual(m.mesh, {}, m.fixed, m.handles);
  ArapDeformer nonlinear(m.mesh, m.fixed, m.handles);
  FeatureRegionOptions soft_kind;
  soft_kind.kind = FeatureRegionOptions::Kind::Soft;
  FeatureRegionDeformer soft(m.mesh, m.regions, m.fixed, m.handles, soft_kind);
  FeatureRegionDeformer hard(m.mesh, m.regions, m.fixed, m.handles);

  DistortionSummary kept;
  rows.add("harmonic, form features", harmonic(m));
  const Points estimate = dual.deform(m.moves);
  const double of_estimate =
      rows.add("dual Laplacian", estimate, iterations_of(dual.report())).edges_outside.mean;
  rows.add("rough", soft.deform_per_face(estimate, m.moves));
  kept.soft = rows.add("soft", soft.deform(estimate, m.moves)).edges_inside.most;
  const Points final_hard = hard.deform(estimate, m.moves);
  Distortion d = rows.add("hard", final_hard);
  kept.hard = d.edges_inside.most;
  kept.outside = d.edges_outside.mean / of_estimate;
  if (!m.ring.empty())
    kept.tilt_apart = std::abs(batten_test::tilt_degrees(final_hard, m.regions[0].vertices) -
                               batten_test::tilt_degrees(final_hard, m.ring));
  const Points other = nonlinear.deform(m.moves);
  const double of_other =
      rows.add("nonlinear", other, iterations_of(nonlinear.report())).edges_outside.mean;
  d = rows.add("nonlinear, then hard", hard.deform(other, m.moves));
  kept.hard = std::max(kept.hard, d.edges_inside.most);
  kept.nonlinear_outside = d.edges_outside.mean / of_other;
  if (!cgal_version().empty()) {
    int iterations = 0;
    const Points p = by_cgal(m, iterations);
    rows.add("CGAL, smoothed rotations", p,
             text("%d", iterations) + (iterations < kMostOfCgal ? "" : ", not converged"));
  }
  rows.print();
  return kept;
}

FeaturedModel pushed_sideways(const std::string& name, const TriangleMesh& mesh) {
  FeaturedModel m{name, mesh, {}, {}, {}, {}};
  const double size = mesh.size();
  const Vec3 low = mesh.points().colwise().minCoeff(), high = mesh.points().colwise().maxCoeff();
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const auto fraction = [&](const Vec3& p) { return (p[axis] - low[axis]) / (high - low)[axis]; };
  m.fixed = batten_test::vertices_where(mesh, [&](const Vec3& p) { return fraction(p) < 0.1; });
  m.handles = {
      {"end", batten_test::vertices_where(mesh, [&](const Vec3& p) { return fraction(p) > 0.9; })}};
  HandleTransform move;
  move.translation = 0.15 * size * Vec3::Unit((axis + 1) % 3);
  m.moves = {move};

  const VecX saliency = mesh_saliency(mesh);
  std::vector<int> order(mesh.vertex_count());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return saliency[a] > saliency[b]; });
  const Parts parts(m);
  std::vector<int> centres;
  for (const int v : order) {
    if (m.regions.size() == 5) break;
    if (mesh.topology().triangles_of(v).empty() ||
        std::any_of(centres.begin(), centres.end(),
                    [&](int c) { return (mesh.point(c) - mesh.point(v)).norm() < 0.2 * size; }))
      continue;
    FeatureRegion region{"place " + std::to_string(m.regions.size() + 1),
                         {},
                         vertices_within(mesh, {v}, 0.05 * size)};
    const auto corners = vertices_of_triangles(mesh.topology(), faces_of(mesh, region));
    if (std::any_of(corners.begin(), corners.end(), [&](int c) { return parts.held[c]; })) continue;
    centres.push_back(v);
    m.regions.push_back(std::move(region));
  }
  if (m.regions.size() < 3) throw std::logic_error(name + ": fewer than three salient vertices");
  return m;
}

}  // namespace batten::bench
