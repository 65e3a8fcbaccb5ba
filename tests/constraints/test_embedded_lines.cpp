// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/constrained_solver.h"
#include "batten/fem/refinement.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

struct ConstrainedLine {
  HermiteCurve pcurve, curve;
  std::vector<double> t;
};

// A plate on squares (possibly refined), trimmed by loops, constrained along curves.
struct Plate {
  TriangleElement kind;
  EmbeddedGrid grid;
  ConstraintSet set;
  std::vector<ConstrainedLine> lines;

  Plate(const ParametricMesh& mesh, const DomainLoops& loops,
        TriangleElement kind_ = TriangleElement::HCT)
      : kind(kind_), grid(mesh, loops), set(DofMap(*grid.mesh).count()) {}

  // x = u, y = v, z = 0 on the mesh's straight sides u, v = ±half; the slope across is free.
  void constrain_sides(double half) {
    const DofMap dofs(*grid.mesh);
    for (int v = 0; v < grid.mesh->vertex_count(); ++v) {
      const Vec2 p = grid.mesh->vertices()[v];
      const bool on_u = std::abs(std::abs(p.x()) - half) < 1e-12,
                 on_v = std::abs(std::abs(p.y()) - half) < 1e-12;
      if (!on_u && !on_v) continue;
      set.fix("side", dofs.vertex(v), {p.x(), p.y(), 0});
      if (on_v) set.fix("side", dofs.vertex(v, 1), {1, 0, 0});
      if (on_u) set.fix("side", dofs.vertex(v, 2), {0, 1, 0});
    }
  }
  ConstrainedLine& constrain(const HermiteCurve& pcurve, const HermiteCurve& curve,
                             const PointSpacing& spacing = {}, bool drop_first = false,
                             bool drop_last = false) {
    auto t = embedded_point_parameters(*grid.mesh, *grid.locator, pcurve, spacing);
    if (drop_first) t.erase(t.begin());
    if (drop_last) t.pop_back();
    lines.push_back({pcurve, curve, t});
    EmbeddedLineConstraints(*grid.mesh, kind, *grid.locator, set).points("line", pcurve, curve, t);
    return lines.back();
  }
  Surface solved(const Vec3& load = Vec3::Zero()) const {
    const SurfaceAssembler assembler(*grid.mesh, kind, grid.trim);
    return {
        grid.mesh, kind,
        ConstrainedSolver(set, assembler.stiffness(SurfaceStiffness{})).solve(assembler.load(load)),
        grid.trim};
  }
  Vec3 at(const Surface& s, double u, double v) const {
    return s.position(grid.locator->locate({u, v}));
  }
  // Largest distance between surface and curve over a part of it, 20 samples between points.
  double gap(const Surface& s, const ConstrainedLine& line, double from = 0, double to = 1) const {
    double largest = 0;
    const int n = 20 * static_cast<int>(line.t.size());
    for (int i = 0; i <= n; ++i) {
      const double t = line.pcurve.start() +
                       (line.pcurve.end() - line.pcurve.start()) * (from + (to - from) * i / n);
      const Vec3 c = line.pcurve.evaluate(t);
      largest = std::max(largest, (at(s, c.x(), c.y()) - line.curve.evaluate(t)).norm());
    }
    return largest;
  }
  double bending(const Surface& s, int coordinate = 2) const {
    double sum = 0;
    for (int t = 0; t < s.mesh().triangle_count(); ++t) {
      const TriangleRule rule = grid.trim->rule(t, kind == TriangleElement::HCT ? 2 : 8);
      for (long p = 0; p < rule.weights.size(); ++p) {
        const SurfaceJet j = s.jet({t, rule.L.row(p).transpose()});
        const double uu = j.x_uu[coordinate], uv = j.x_uv[coordinate], vv = j.x_vv[coordinate];
        sum += s.mesh().shape(t).area * rule.weights[p] * (uu * uu + 2 * uv * uv + vv * vv);
      }
    }
    return sum;
  }
  // Number of redundant equations; the largest entry of D.
  std::pair<int, double> reduction() const {
    const AffineReduction reduction(set);
    double largest = 0;
    const SparseMatrix& D = reduction.D();
    for (int k = 0; k < D.outerSize(); ++k)
      for (SparseMatrix::InnerIterator it(D, k); it; ++it)
        largest = std::max(largest, std::abs(it.value()));
    return {reduction.redundant_count(), largest};
  }
};

ParametricMesh side_squares(double half, double h) {
  const int n = static_cast<int>(std::round(2 * half / h));
  return squares({-half, -half}, h, n, n);
}

// A curve over its pcurve, at the height z(t).
HermiteCurve lifted(const HermiteCurve& pcurve,
                    const std::function<double(double t, int order)>& z) {
  const CurveMesh& mesh = pcurve.mesh();
  Points dofs = pcurve.dofs();
  for (int i = 0; i < mesh.node_count(); ++i) {
    const double t = pcurve.parameters()[static_cast<size_t>(i)];
    dofs(mesh.position_dof(i), 2) = z(t, 0);
    dofs(mesh.slope_out(i), 2) = z(t, 1);
  }
  return {mesh, dofs};
}

DomainLoops hole(double radius) {
  return DomainLoops({{circle({0, 0}, radius, 720, true)}}, DomainLoops::Background::Inside);
}

// The boundary of a hole around the origin at 0.1 + 0.05 cos 2t.
HermiteCurve wavy_rim(double radius) {
  return lifted(circle({0, 0}, radius, 720), [](double t, int order) {
    return order == 0 ? 0.1 + 0.05 * std::cos(2 * t) : -0.1 * std::sin(2 * t);
  });
}

struct HolePlate : Plate {
  HolePlate(const ParametricMesh& mesh, double radius, TriangleElement kind = TriangleElement::HCT,
            const PointSpacing& spacing = {})
      : Plate(mesh, hole(radius), kind) {
    constrain_sides(2);
    constrain(circle({0, 0}, radius, 720), wavy_rim(radius), spacing);
  }
};

HermiteCurve straight(const Vec2& p, const Vec2& q) {
  Points positions(2, 3), slopes(2, 3);
  positions << p.x(), p.y(), 0, q.x(), q.y(), 0;
  slopes.row(0) = slopes.row(1) = (positions.row(1) - positions.row(0)) / (q - p).norm();
  return {{0, (q - p).norm()}, positions, slopes};
}

// Radius 1.2 around (-0.7, -0.8), both ends inside [-1, 1]².
HermiteCurve rib() {
  return hermite(0.1, 1.4, 600, false, [](double t, int order) {
    return order == 0 ? Vec3(-0.7 + 1.2 * std::cos(t), -0.8 + 1.2 * std::sin(t), 0)
                      : Vec3(-1.2 * std::sin(t), 1.2 * std::cos(t), 0);
  });
}
HermiteCurve raised_rib() {
  return lifted(rib(), [](double t, int order) {
    return order == 0 ? 0.1 + 0.03 * std::sin(2 * t) : 0.06 * std::cos(2 * t);
  });
}

// Bisects triangles that a curve passes within `reach` of their own size, repeatedly.
ParametricMesh refined_at(ParametricMesh mesh, const HermiteCurve& curve, int rounds,
                          double reach = 1) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<char> marked;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const Vec2 c = mesh.shape(t).point(Vec3::Constant(1 / 3.));
      const double away = curve.closest_point(Vec3(c.x(), c.y(), 0)).distance;
      marked.push_back(away < reach * std::sqrt(2 * mesh.shape(t).area));
    }
    mesh = bisected(mesh, marked).mesh;
  }
  return mesh;
}

std::string list(const std::vector<double>& numbers) {
  std::string text;
  for (const double x : numbers) text += format_number(x) + "  ";
  return text;
}

}  // namespace

TEST_CASE("a plate with a supported boundary around its hole", "[constraints][embedded]") {
  for (const TriangleElement kind : kBothElements) {
    std::vector<double> gaps, energies;
    for (const double h : {1 / 4., 1 / 8., 1 / 16.}) {
      const HolePlate plate(side_squares(2, h), 0.5, kind);
      CHECK(plate.lines[0].t.size() == static_cast<size_t>(std::ceil(pi / (0.7 * h))));
      const Surface s = plate.solved();
      gaps.push_back(plate.gap(s, plate.lines[0]));
      energies.push_back(plate.bending(s) / 0.47156 - 1);
      double xy = 0, jacobian = 0;
      for (int t = 0; t < s.mesh().triangle_count(); ++t) {
        const TriangleRule rule = plate.grid.trim->rule(t, 2);
        for (long p = 0; p < rule.weights.size(); ++p) {
          const Location where{t, rule.L.row(p).transpose()};
          const SurfaceJet j = s.jet(where);
          xy = std::max(xy, (j.x.head<2>() - s.mesh().shape(t).point(where.L)).norm());
          jacobian = std::max(jacobian, std::abs(j.area_vector().z() - 1));
        }
      }
      // x = u, y = v up to rounding times the plate's condition number, h⁻⁴; the same without the
      // hole.
      const double rounding = (kind == TriangleElement::HCT ? 3e-12 : 3e-11) * std::pow(4 * h, -4);
      INFO(name(kind) << " h " << h << " xy " << xy << " J " << jacobian);
      CHECK(xy < rounding);
      CHECK(jacobian < 4 * rounding);
      const auto [dropped, largest] = plate.reduction();
      CHECK(dropped == 0);
      CHECK(largest <= 3);
    }
    INFO(name(kind) << " gaps " << list(gaps) << " energies " << list(energies));
    const double gap[] = {3.4e-4, 4.2e-5, 5.2e-6}, energy[] = {1.8e-2, 2.0e-3, 1.7e-4};
    for (size_t i = 0; i < 3; ++i) {
      CHECK(gaps[i] <= 1.2 * gap[i]);
      CHECK(std::abs(energies[i]) <= 1.2 * energy[i]);
    }
  }
}

TEST_CASE("a turned square plate, its corners inside elements", "[constraints][embedded]") {
  const double c = std::cos(pi / 6), s = std::sin(pi / 6);
  const auto corner = [&](double u, double v) { return Vec2(c * u - s * v, s * u + c * v); };
  const std::vector<Vec2> corners{corner(-.5, -.5), corner(.5, -.5), corner(.5, .5),
                                  corner(-.5, .5)};
  DomainLoops::Loop outline;
  for (size_t i = 0; i < 4; ++i) outline.push_back(straight(corners[i], corners[(i + 1) % 4]));
  for (const TriangleElement kind : kBothElements) {
    std::vector<double> errors;
    for (const double h : {1 / 4., 1 / 8., 1 / 16., 1 / 32.}) {
      const int n = static_cast<int>(std::round(1.5 / h)) + 2;
      const Vec2 origin = Vec2::Constant(-0.75 - h) + h * Vec2(0.13, 0.29);
      Plate plate(squares(origin, h, n, n), DomainLoops({outline}), kind);
      CHECK(plate.grid.trim->area() == Approx(1).epsilon(1e-12));
      for (const HermiteCurve& side : outline) plate.constrain(side, side, {}, true);
      ConstraintSet flat(plate.set.dof_count());
      for (const auto& row : plate.set.constraints()) flat.add("side", row.entries, Vec3::Zero());
      plate.set = flat;
      const auto [dropped, largest] = plate.reduction();
      CHECK(dropped == 0);
      CHECK(largest <= 3);
      const Surface w = plate.solved({0, 0, 1});
      errors.push_back(plate.at(w, 0, 0).z() / 0.00406235 - 1);
    }
    INFO(name(kind) << " errors " << list(errors));
    const double table[] = {3.2e-3, 8.1e-5, 2.1e-5, 4.5e-6};
    for (size_t i = 0; i < 4; ++i) CHECK(std::abs(errors[i]) <= 1.2 * table[i]);
  }
}

TEST_CASE("a hole's radius against the grid", "[constraints][embedded]") {
  std::vector<double> gaps;
  const double h = 1 / 4.;
  for (const double radius : {2 * h, h, h / 2}) {
    const HolePlate plate(side_squares(2, h), radius);
    const auto [dropped, largest] = plate.reduction();
    CHECK(dropped == 0);
    CHECK(largest <= 10);
    gaps.push_back(plate.gap(plate.solved(), plate.lines[0]));
  }
  INFO("gaps " << list(gaps));
  CHECK(gaps[0] <= 1.2 * 3.4e-4);
  CHECK(gaps[1] <= 1.2 * 1.3e-3);
  CHECK(gaps[2] <= 6e-3);  // six points around: refine the grid instead
}

TEST_CASE("refined towards a small hole, the gap falls as on a fine grid",
          "[constraints][embedded]") {
  const double h = 1 / 4.;
  for (const double radius : {0.5, 0.25, 0.125}) {
    std::vector<double> gaps;
    for (int rounds : {0, 2, 4, 6}) {
      const HolePlate plate(
          refined_at(side_squares(2, h), circle({0, 0}, radius, 720), rounds, 1.5), radius);
      const auto [dropped, largest] = plate.reduction();
      CHECK(plate.grid.trim->area() == Approx(16 + hole(radius).area()).epsilon(1e-12));
      INFO("radius " << radius << " rounds " << rounds << " D " << largest);
      CHECK(dropped == 0);
      CHECK(largest <= 10);
      gaps.push_back(plate.gap(plate.solved(), plate.lines[0]));
    }
    INFO("radius " << radius << " gaps " << list(gaps));
    for (size_t i = 1; i < gaps.size(); ++i) CHECK(gaps[i] < gaps[i - 1] / 2);
    CHECK(gaps.back() < gaps.front() / 50);
  }
}

TEST_CASE("a rib that ends inside the plate", "[constraints][embedded]") {
  for (const TriangleElement kind : kBothElements) {
    std::vector<double> middle, ends, more;
    for (const double h : {1 / 4., 1 / 8., 1 / 16., 1 / 32.}) {
      Plate plate(side_squares(1, h), DomainLoops(), kind), dense = plate;
      plate.constrain_sides(1);
      plate.constrain(rib(), raised_rib());
      dense.constrain_sides(1);
      PointSpacing spacing;
      spacing.extra_end_points = 2;
      dense.constrain(rib(), raised_rib(), spacing);
      CHECK(dense.lines[0].t.size() == plate.lines[0].t.size() + 4);
      const auto [dropped, largest] = plate.reduction();
      CHECK(dropped == 0);
      CHECK(largest <= 10);
      CHECK(dense.reduction().first == 0);
      const Surface s = plate.solved();
      middle.push_back(plate.gap(s, plate.lines[0], 0.1, 0.9));
      const Surface d = dense.solved();
      ends.push_back(
          std::max(plate.gap(s, plate.lines[0], 0, 0.1), plate.gap(s, plate.lines[0], 0.9, 1)));
      more.push_back(
          std::max(dense.gap(d, dense.lines[0], 0, 0.1), dense.gap(d, dense.lines[0], 0.9, 1)));
    }
    INFO(name(kind) << " middle " << list(middle) << " ends " << list(ends) << " more "
                    << list(more));
    for (size_t i = 1; i < 4; ++i) {
      CHECK(middle[i] <= middle[i - 1] / 6);
      CHECK(ends[i] <= ends[i - 1] / 1.5);
    }
    CHECK(ends[3] <= ends[0] / 12);
    for (size_t i = 0; i < 4; ++i) CHECK(more[i] <= 0.7 * ends[i]);
  }
}

TEST_CASE("a rib on a grid that is bisected towards it", "[constraints][embedded]") {
  Plate coarse(side_squares(1, 1 / 4.), DomainLoops());
  coarse.constrain_sides(1);
  coarse.constrain(rib(), raised_rib());
  const Surface s = coarse.solved();
  const double coarse_middle = coarse.gap(s, coarse.lines[0], 0.1, 0.9),
               coarse_all = coarse.gap(s, coarse.lines[0]);
  std::vector<double> middle, all;
  for (const int rounds : {1, 2, 3, 4, 6}) {
    Plate graded(refined_at(side_squares(1, 1 / 4.), rib(), rounds), DomainLoops());
    graded.constrain_sides(1);
    graded.constrain(rib(), raised_rib());
    const auto [dropped, largest] = graded.reduction();
    INFO("rounds " << rounds << " D " << largest);
    CHECK(dropped == 0);
    CHECK(largest <= 10);
    const Surface g = graded.solved();
    middle.push_back(graded.gap(g, graded.lines[0], 0.1, 0.9));
    all.push_back(graded.gap(g, graded.lines[0]));
  }
  INFO("coarse " << coarse_middle << " " << coarse_all << " middle " << list(middle) << " all "
                 << list(all));
  for (const double gap : middle) CHECK(gap <= 1.02 * coarse_middle);
  for (const double gap : all) CHECK(gap <= 1.02 * coarse_all);
  CHECK(middle.back() <= coarse_middle / 50);
}

TEST_CASE("the normal along an inner curve, by hat functions", "[constraints][embedded]") {
  std::vector<double> normals, slopes;
  for (const double h : {1 / 4., 1 / 8., 1 / 16.}) {
    for (const bool by_normal : {true, false}) {
      Plate plate(side_squares(1, h), DomainLoops());
      plate.constrain_sides(1);
      const HermiteCurve pcurve = rib(), curve = raised_rib();
      const ConstrainedLine line = plate.constrain(pcurve, curve);
      // Perpendicular to the curve, tilted by a tenth to its left.
      const auto wanted = [&](double t) -> Vec3 {
        const Vec3 along = curve.evaluate(t, 1);
        const Vec3 left(-along.y(), along.x(), 0);
        const Vec3 up = along.cross(left).normalized();
        return (up - (0.1 + 0.05 * std::sin(3 * t)) * left.normalized()).normalized();
      };
      EmbeddedLineConstraints rows(*plate.grid.mesh, plate.kind, *plate.grid.locator, plate.set);
      if (by_normal) {
        rows.normal("normal", pcurve, line.t, wanted);
      } else {
        // x_ν perpendicular to n, with a projection of length 1.
        rows.slope("slope", pcurve, line.t, [&](double t) {
          const Vec3 d = pcurve.evaluate(t, 1).normalized(), nu(-d.y(), d.x(), 0), n = wanted(t);
          return Vec3(nu.x(), nu.y(), -n.dot(nu) / n.z());
        });
      }
      CHECK(plate.reduction().first == 0);
      const Surface s = plate.solved();
      double squares = 0;
      const int samples = 400;
      for (int i = 0; i < samples; ++i) {
        const double t =
            pcurve.start() + (pcurve.end() - pcurve.start()) * (0.1 + 0.8 * i / samples);
        const Vec3 c = pcurve.evaluate(t);
        const double turn = std::acos(std::clamp(
            s.jet(plate.grid.locator->locate({c.x(), c.y()})).normal().dot(wanted(t)), -1., 1.));
        squares += turn * turn;
      }
      (by_normal ? normals : slopes).push_back(180 / pi * std::sqrt(squares / samples));
    }
  }
  INFO("normals " << list(normals) << " slopes " << list(slopes));
  const double table[] = {0.72, 0.17, 0.09};
  for (size_t i = 0; i < 3; ++i) {
    CHECK(normals[i] <= table[i]);
    CHECK(slopes[i] <= table[i]);
  }
}

TEST_CASE("two curves closer than an element keep their constraint equations and gaps",
          "[constraints][embedded]") {
  const double h = 1 / 8.;
  const auto at_radius = [](double r) {
    return hermite(0.1, 1.4, 600, false, [=](double t, int order) {
      return order == 0 ? Vec3(-0.7 + r * std::cos(t), -0.8 + r * std::sin(t), 0)
                        : Vec3(-r * std::sin(t), r * std::cos(t), 0);
    });
  };
  // Both on one smooth sheet.
  const auto on_sheet = [&](double r) {
    return lifted(at_radius(r), [=](double t, int order) {
      const double u = -0.7 + r * std::cos(t), v = -0.8 + r * std::sin(t);
      return order == 0 ? 0.2 * std::cos(1.2 * u) * std::cos(v)
                        : 0.24 * std::sin(1.2 * u) * std::cos(v) * r * std::sin(t) -
                              0.2 * std::cos(1.2 * u) * std::sin(v) * r * std::cos(t);
    });
  };
  for (const TriangleElement kind : kBothElements) {
    double alone = 0;
    for (const double distance : {0.0, 1.0, 0.7, 0.5, 0.3, 0.2, 0.1}) {
      Plate plate(side_squares(1, h), DomainLoops(), kind);
      plate.constrain_sides(1);
      plate.constrain(at_radius(1.1), on_sheet(1.1));
      if (distance > 0)
        plate.constrain(at_radius(1.1 + distance * h), on_sheet(1.1 + distance * h));
      const auto [dropped, largest] = plate.reduction();
      CHECK(dropped == 0);
      const Surface s = plate.solved();
      for (const ConstrainedLine& line : plate.lines) {
        const double gap = plate.gap(s, line, 0.1, 0.9);
        if (distance == 0) alone = gap;
        INFO(name(kind) << " distance " << distance << " gap " << gap << " alone " << alone << " D "
                        << largest);
        CHECK(gap <= 2 * alone);
        CHECK(largest <= 40);
      }
    }
  }
}

TEST_CASE("a curve along element edges, and slightly beside them", "[constraints][embedded]") {
  // For the curve, an edge has two dofs per vertex: more points would be contradictory or, slightly
  // beside the edge, determine the slopes across from differences of almost zero.
  for (const int n : {16, 64})
    for (const bool diagonal : {true, false}) {
      double energy = 0;
      for (const double off : {0.0, 1e-9, 1e-6, 1e-4, 1e-2}) {
        const double h = 2.0 / n;
        Plate plate(squares({-1, -1}, h, n, n), DomainLoops());
        const Vec2 p = diagonal ? Vec2(-1, -1 + off * h) : Vec2(-1, off * h);
        const Vec2 q = diagonal ? Vec2(1 - off * h, 1) : Vec2(1, off * h);
        const Vec2 d = (q - p).normalized();
        const HermiteCurve curve =
            hermite(0, (q - p).norm(), 400, false, [&](double t, int order) -> Vec3 {
              if (order == 1) return {d.x(), d.y(), 0.5 * std::cos(5 * t)};
              return {p.x() + t * d.x(), p.y() + t * d.y(), 0.1 * std::sin(5 * t)};
            });
        plate.set.fix("corner", DofMap(*plate.grid.mesh).vertex(n), {1, -1, 0});
        plate.constrain(straight(p, q), curve);
        CHECK(plate.reduction().first == 0);
        const Surface s = plate.solved();
        if (off == 0) energy = plate.bending(s);
        INFO("n " << n << (diagonal ? " diagonal" : " level") << " off " << off);
        CHECK(plate.bending(s) == Approx(energy).epsilon(1e-4));
        CHECK(plate.gap(s, plate.lines[0]) < 0.2 * h * h);
      }
    }
}

TEST_CASE("points of a curve are spaced by the triangles below them", "[constraints][embedded]") {
  const double h = 1 / 8.;
  const ParametricMesh uniform = side_squares(1, h);
  const TriangleLocator locator(uniform);
  const HermiteCurve arc = rib(), ring = circle({0.1, 0.05}, 0.6, 300);
  const auto steps = [](const HermiteCurve& c, const std::vector<double>& t) {
    std::vector<double> lengths;
    for (size_t i = 0; i + 1 < t.size() + (c.closed() ? 1 : 0); ++i) {
      const double to = i + 1 < t.size() ? t[i + 1] : c.end();
      double sum = 0;
      for (int k = 0; k < 40; ++k)
        sum += c.evaluate(t[i] + (to - t[i]) * (k + 0.5) / 40, 1).norm() * (to - t[i]) / 40;
      lengths.push_back(sum);
    }
    return lengths;
  };
  for (const HermiteCurve& c : {arc, ring}) {
    const auto t = embedded_point_parameters(uniform, locator, c);
    CHECK(t.front() == c.start());
    if (c.closed())
      CHECK(t.back() < c.end());
    else
      CHECK(t.back() == c.end());
    CHECK(std::is_sorted(t.begin(), t.end()));
    const auto lengths = steps(c, t);
    CHECK(lengths.size() == static_cast<size_t>(std::ceil(c.length() / (0.7 * h))));
    for (const double l : lengths) {
      CHECK(l <= 0.7 * h * 1.0001);
      CHECK(l >= 0.6 * h);
      CHECK(l == Approx(lengths[0]).epsilon(1e-3));
    }
    // Another spacing, and prescribed positions.
    const auto wide = embedded_point_parameters(uniform, locator, c, {1.0, 0});
    CHECK(wide.size() < t.size());
    const double forced = c.start() + 0.437 * (c.end() - c.start());
    const auto with =
        embedded_point_parameters(uniform, locator, c, {}, {forced, forced, c.end() + 1});
    CHECK(std::count(with.begin(), with.end(), forced) == 1);
    CHECK(std::adjacent_find(with.begin(), with.end(), std::greater_equal<>()) == with.end());
    for (const double l : steps(c, with)) {
      CHECK(l <= 0.7 * h * 1.0001);
      CHECK(l >= 0.35 * h);
    }
    const auto at_ends = embedded_point_parameters(uniform, locator, c, {}, {c.start(), c.end()});
    CHECK(at_ends.size() == t.size());
  }
  // Half steps at open ends only, with the requested number.
  PointSpacing ends;
  ends.extra_end_points = 3;
  CHECK(embedded_point_parameters(uniform, locator, ring, ends) ==
        embedded_point_parameters(uniform, locator, ring));
  const auto plain = steps(arc, embedded_point_parameters(uniform, locator, arc)),
             halved = steps(arc, embedded_point_parameters(uniform, locator, arc, ends));
  REQUIRE(halved.size() == plain.size() + 6);
  for (size_t i = 0; i < halved.size(); ++i)
    CHECK(halved[i] / plain[0] == Approx(i < 6 || i + 6 >= halved.size() ? 0.5 : 1).epsilon(0.01));
  // A curve without a length scale is also spaced by length.
  const HermiteCurve uneven = hermite(0, 1, 200, false, [](double s, int order) {
    const double t = s * s + 0.2 * s, slope = 2 * s + 0.2;
    return order == 0 ? Vec3(t - 0.6, 0.3 * t, 0) : Vec3(slope, 0.3 * slope, 0);
  });
  for (const double l : steps(uneven, embedded_point_parameters(uniform, locator, uneven))) {
    CHECK(l <= 0.7 * h * 1.001);
    CHECK(l >= 0.6 * h);
  }
  // A tiny loop is still closed.
  CHECK(embedded_point_parameters(uniform, locator, circle({0, 0}, 0.01, 40)).size() >= 6);
  // Graded: by the size of each triangle, from point to point.
  const ParametricMesh graded = refined_at(side_squares(1, 1 / 4.), circle({0.3, 0.2}, 0.1, 40), 6);
  const TriangleLocator on_graded(graded);
  for (const HermiteCurve& c : {arc, ring}) {
    const auto t = embedded_point_parameters(graded, on_graded, c);
    const auto lengths = steps(c, t);
    double smallest = 1e9, largest = 0;
    for (size_t i = 0; i < lengths.size(); ++i) {
      double finest = 1e9, coarsest = 0;
      for (int k = 0; k <= 20; ++k) {
        const double to = i + 1 < t.size() ? t[i + 1] : c.end();
        const Vec3 p = c.evaluate(t[i] + (to - t[i]) * k / 20);
        const double size =
            std::sqrt(2 * graded.shape(on_graded.locate({p.x(), p.y()}).triangle).area);
        finest = std::min(finest, size);
        coarsest = std::max(coarsest, size);
      }
      // The longest edge of a right triangle where the curve runs along it.
      CHECK(lengths[i] <= 0.73 * std::sqrt(2.0) * coarsest);
      CHECK(lengths[i] >= 0.35 * finest);
      smallest = std::min(smallest, lengths[i]);
      largest = std::max(largest, lengths[i]);
    }
    CHECK(largest > 2 * smallest);
  }
}

TEST_CASE("hat functions average the cross-boundary slope over both neighbours",
          "[constraints][embedded]") {
  const ParametricMesh mesh = side_squares(1, 0.25);
  const TriangleLocator locator(mesh);
  ConstraintSet set(DofMap(mesh).count());
  const HermiteCurve line = straight({-0.9, 0.05}, {0.9, 0.05});
  const std::vector<double> t{0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8};
  EmbeddedLineConstraints(mesh, TriangleElement::HCT, locator, set)
      .slope("slope", line, t, [](double s) { return Vec3(s, s * s, 1); });
  // w = u² v: the slope to the left of the curve is u², its mean under a hat function u_k² +
  // step²/6; half a hat at the ends, whose centroid is step/3 away.
  const VecX q = dofs_of(mesh, [](const Vec2& p) {
    return Vec3(p.x() * p.x() * p.y(), 2 * p.x() * p.y(), p.x() * p.x());
  });
  REQUIRE(set.constraints().size() == t.size());
  for (size_t k = 0; k < t.size(); ++k) {
    double row = 0;
    for (const auto& entry : set.constraints()[k].entries) row += entry.coefficient * q[entry.dof];
    const double step = 0.3, u = t[k] - 0.9;
    const double inward = k == 0 ? step / 3 : k + 1 == t.size() ? -step / 3 : 0;
    CHECK(row == Approx(u * u + 2 * u * inward + step * step / 6).epsilon(1e-12));
    const Vec3 value(t[k] + inward, t[k] * t[k] + 2 * t[k] * inward + step * step / 6, 1);
    CHECK((set.constraints()[k].value - value).norm() < 1e-13);
  }
}

TEST_CASE("rows off the mesh and sets of another mesh are refused", "[constraints][embedded]") {
  const ParametricMesh mesh = side_squares(1, 0.25);
  const TriangleLocator locator(mesh);
  ConstraintSet set(DofMap(mesh).count()), other(7);
  EmbeddedLineConstraints rows(mesh, TriangleElement::HCT, locator, set);
  const HermiteCurve away = circle({0, 0}, 1.1, 40);
  CHECK(error_message([&] { rows.points("rim", away, away, {0}); }).find("'rim' leaves the mesh") !=
        std::string::npos);
  CHECK(error_message(
            [&] { EmbeddedLineConstraints(mesh, TriangleElement::HCT, locator, other); }) != "");
  // The boundary edge belongs to the mesh.
  const HermiteCurve side = straight({-1, -1}, {1, -1});
  rows.points("side", side, side, embedded_point_parameters(mesh, locator, side));
  CHECK(set.constraints().size() == static_cast<size_t>(std::ceil(2 / (0.7 * 0.25))) + 1);
}
