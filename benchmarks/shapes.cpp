// SPDX-License-Identifier: MPL-2.0
// Surfaces with a formula from curves alone: cylinder strips up to 350 degrees, annuli, an octant
// of a sphere, a saddle, a helicoid, a torus.
// First from the boundary alone: the surface converges to the minimiser of its own energy, which is
// not the exact surface. Then with inner curves on the exact surface, and with its normals along
// the boundary. OpenCASCADE's filling of the same boundary is the peer.
// Finally, `batten skin` on the 35 expected shapes (expected.cpp).
#include <cmath>
#include <numbers>
#include <optional>

#include "analytic_shapes.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "bench.h"
#include "expected.h"
#include "fair_shapes.h"
#include "occ_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;

constexpr int grids = 3;

struct SkinnedShape {
  SkinnedRegion region;
  SkinQuality quality;
  double tolerance = 0, seconds = 0;
  int triangles() const { return region.surface.mesh().triangle_count(); }
};

using AddConstraints = std::function<void(const RegionLayout& layout, ConstraintSet& set)>;

SkinnedShape skin(const AnalyticShape& shape, const std::vector<CharacterLine>& lines, double edge,
                  double tolerance, const AddConstraints& more = {}) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = tolerance;
  std::optional<RegionLayout> layout;
  Points dofs;
  const double t = cpu_seconds_of([&] {
    layout.emplace(shape.name, lines, options);
    ConstraintSet set = layout->line_constraints();
    if (more) more(*layout, set);
    const ModelLayout model(*layout);
    const VecX ones = model.position_dofs();
    const SurfaceAssembler assembler(*model.mesh(), model.element(), model.trim());
    const ConstrainedSolver solver(set.translated(ones, model.origin()),
                                   assembler.stiffness(SurfaceStiffness{}), model.dof_order());
    dofs = solver.solve(Points::Zero(ones.size(), 3)) + ones * model.origin().transpose();
  });
  SkinnedRegion region = layout->region(std::move(dofs));
  const SkinQuality quality = measure(region);
  return {std::move(region), quality, layout->tolerance(), t};
}

// For mesh-aligned curves: small enough that fits do not hide the order.
double fit_tolerance(double edge) { return 0.01 * std::pow(edge, 4); }

struct FormulaComparison {
  double distance = 0;
  int flipped = 0;  ///< normals more than a right angle from the exact ones
};
FormulaComparison compare_with_formula(const AnalyticShape& shape, const Surface& surface) {
  FormulaComparison a;
  const int n = surface.mesh().triangle_count(), step = std::max(1, n / 1200);
  int along = 0, against = 0;
  for (int t = 0; t < n; t += step)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(2.8, 0.1, 0.1), Vec3(0.1, 1.5, 1.4)}) {
      const SurfaceJet jet = surface.jet({t, L / 3});
      const auto foot_point = shape.surface.closest(jet.x);
      a.distance = std::max(a.distance, foot_point.distance);
      ++(foot_point.normal.dot(jet.area_vector()) > 0 ? along : against);
    }
  a.flipped = std::min(along, against);
  return a;
}

// x = f(v) (cos u, sin u) between two equal circles of radius 1, u and v in units of the radius:
// f'''' - 2 f'' + f = 0, f'' = 0 at the circles, so f = a cosh v + b v sinh v.
double distance_from_tube(const Surface& surface, double height) {
  const double h = height / 2, c = std::cosh(h), s = std::sinh(h);
  Mat2 A;
  A << c, h * s, c, 2 * c + h * s;
  const Vec2 ab = A.inverse() * Vec2(1, 0);
  double worst = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(3, 0, 0), Vec3(0, 1.5, 1.5)}) {
      const Vec3 x = surface.position({t, L / 3});
      const double v = x.z() - h, f = ab[0] * std::cosh(v) + ab[1] * v * std::sinh(v);
      worst = std::max(worst, std::abs(std::hypot(x.x(), x.y()) - f));
    }
  return worst;
}

// Largest difference at equal (u, v).
double difference(const Surface& a, const Surface& b) {
  const TriangleLocator locator(b.mesh());
  double worst = 0;
  for (int t = 0; t < a.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(3, 0, 0), Vec3(0, 1.5, 1.5)}) {
      const Vec2 uv = a.mesh().shape(t).point(L / 3);
      worst = std::max(worst, (a.position({t, L / 3}) - b.position(locator.locate(uv))).norm());
    }
  return worst;
}

// The exact normals along all sides.
void add_normals(const AnalyticShape& shape, const RegionLayout& layout, ConstraintSet& set) {
  SurfaceConstraints rows(*layout.mesh(), layout.element(), set);
  for (const EdgeAlignedLine& aligned_line : layout.edge_aligned()) {
    if (aligned_line.line.role != CharacterLine::Role::Outline) continue;
    const auto normal = [&](int e, double s) {
      const size_t k =
          static_cast<size_t>(std::find(aligned_line.edges.begin(), aligned_line.edges.end(), e) -
                              aligned_line.edges.begin());
      const bool from_low = layout.mesh()->edges()[e].low == aligned_line.vertices[k];
      const double f = from_low ? s : 1 - s;
      return shape.surface
          .closest(aligned_line.fitted.evaluate(
              aligned_line.parameters[k] +
              f * (aligned_line.parameters[k + 1] - aligned_line.parameters[k])))
          .normal;
    };
    rows.varying_normal("normal along " + aligned_line.line.name, aligned_line.edges, normal, true);
  }
}

// Smallest distance between two parts of the surface.
double nearest(const SkinnedRegion& region, const EdgeAlignedLine& a, const EdgeAlignedLine& b) {
  double least = 1e100;
  const auto at = [&](int v) {
    return Vec3(region.surface.dofs().row(region.surface.dof_map().vertex(v)));
  };
  for (const int v : a.vertices)
    for (const int w : b.vertices) least = std::min(least, (at(v) - at(w)).norm());
  return least;
}

std::vector<std::string> quality_text(const SkinQuality& q, int flipped) {
  return {text("%.1e", q.max_line_residual), std::to_string(flipped),
          text("%.3f", q.min_jacobian_ratio), text("%.2f", q.max_shear),
          text("%.3f", q.rms_strain)};
}
const std::vector<std::string> quality_head = {"curve residual", "flipped", "min Jacobian",
                                               "max shear", "rms strain"};

void add(Table& table, std::vector<std::string> row, const std::vector<std::string>& more) {
  row.insert(row.end(), more.begin(), more.end());
  table.add(std::move(row));
}

struct WorstQuality {
  double residual = 0, gap = 0;
  int flipped = 0;
  void take(const SkinnedShape& made, int flips) {
    residual = std::max(residual, made.quality.max_line_residual);
    gap = std::max(gap, made.quality.max_line_gap / made.tolerance);
    flipped += flips;
  }
};

}  // namespace

// With an argument: only the shapes whose names contain it; "expected": only the table of expected
// shapes.
int main(int argc, char** argv) {
  one_thread();
  if (argc > 1 && std::string(argv[1]) == "expected") {
    Checks alone;
    compare_expected(alone);
    alone.print("shapes");
    return 0;
  }
  std::printf("Processor time on one thread. Lengths in units of the shapes, of size 2 to 4.\n\n");
  std::vector<AnalyticShape> shapes = analytic_shapes();
  if (argc > 1)
    std::erase_if(shapes, [&](const AnalyticShape& shape) {
      return shape.name.find(argv[1]) == std::string::npos;
    });
  Checks checks;
  WorstQuality worst;
  std::vector<SkinnedShape> finest;

  std::printf("Boundary curves alone.\n\n");
  Table alone;
  add(alone,
      {"boundary alone", "edge", "triangles", "from own minimiser", "order", "from exact",
       "seconds"},
      quality_head);
  for (const AnalyticShape& shape : shapes) {
    const auto lines = shape.boundary();
    std::vector<SkinnedShape> made;
    for (int g = 0; g <= grids; ++g) {
      const double edge = shape.coarse * std::pow(0.5, g);
      made.push_back(skin(shape, lines, edge, fit_tolerance(edge)));
    }
    std::vector<double> errors;
    for (int g = 0; g < grids; ++g) {
      const Surface& s = made[static_cast<size_t>(g)].region.surface;
      errors.push_back(shape.name == "rings, equal" ? distance_from_tube(s, 1.2)
                                                    : difference(s, made.back().region.surface));
      const FormulaComparison a = compare_with_formula(shape, s);
      worst.take(made[static_cast<size_t>(g)], a.flipped);
      const bool exact = errors.back() < 1e-11;
      add(alone,
          {g == 0 ? shape.name : "", format_number(shape.coarse * std::pow(0.5, g)),
           std::to_string(made[static_cast<size_t>(g)].triangles()), text("%.2e", errors.back()),
           g == 0 || exact
               ? ""
               : text("%.2f", std::log2(errors[static_cast<size_t>(g) - 1] / errors.back())),
           text("%.2e", a.distance), text("%.3f", made[static_cast<size_t>(g)].seconds)},
          quality_text(made[static_cast<size_t>(g)].quality, a.flipped));
    }
    // Corners limit the order: r² log r at right angles (order 2), r^1.5 at the saddle's 120
    // degrees.
    checks.at_least(shape.name + ": order of convergence to its own minimiser",
                    0.5 * std::log2(errors.front() / errors.back()),
                    shape.name == "saddle" ? 1.3 : 1.8);
    if (shape.name == "cylinder 350") {
      const auto& edge_aligned = made.back().region.edge_aligned;
      const double apart = nearest(made.back().region, edge_aligned[1], edge_aligned[3]);
      std::printf(
          "Distance between the ends of the 350 degree strip: %.6f; of the curves: %.6f.\n\n",
          apart, 2 * std::sin(5 * std::numbers::pi / 180));
      checks.at_least("cylinder 350: distance between its ends over that of the curves",
                      apart / (2 * std::sin(5 * std::numbers::pi / 180)), 0.999);
    }
    made.pop_back();
    finest.push_back(made.back());
  }
  alone.print();

  compare_fair(shapes, argc > 1 ? argv[1] : nullptr, checks);
  if (argc > 1 && std::string(argv[1]) == "random") compare_random(checks);
  if (argc < 2) {
    compare_joined(checks);
    compare_sections(checks);
  }

  std::printf("With inner curves on the exact surface: distance from it.\n\n");
  Table inner;
  add(inner,
      {"inner curves", "curves", "edge", "triangles", "embedded", "from exact", "gap", "allowed",
       "seconds"},
      quality_head);
  for (size_t i = 0; i < shapes.size(); ++i) {
    const AnalyticShape& shape = shapes[i];
    if (shape.domain == AnalyticShape::Domain::Annulus) continue;
    double with_three = 0, with_nine = 1e100;  // on the middle grid
    for (const auto& [n, g] : {std::pair{3, 0}, {3, 1}, {3, 2}, {5, 1}, {9, 1}}) {
      const double edge = 1.6 * shape.coarse * std::pow(0.5, g);
      auto lines = shape.boundary();
      for (CharacterLine& line : shape.inner(n)) lines.push_back(std::move(line));
      try {
        const SkinnedShape made = skin(shape, lines, edge, 1e-3 * std::pow(0.25, g));
        const FormulaComparison a = compare_with_formula(shape, made.region.surface);
        worst.take(made, a.flipped);
        if (g == 1 && n == 3) with_three = a.distance;
        if (g == 1 && n == 9) with_nine = a.distance;
        add(inner,
            {n == 3 && g == 0 ? shape.name : "", std::to_string(n), format_number(edge),
             std::to_string(made.triangles()), std::to_string(made.region.embedded.size()),
             text("%.2e", a.distance), text("%.2e", made.quality.max_line_gap),
             text("%.2e", made.tolerance), text("%.3f", made.seconds)},
            quality_text(made.quality, a.flipped));
      } catch (const Error& e) {
        inner.add({shape.name, std::to_string(n), format_number(edge), "refused"});
        std::printf("%s, %d curves, edge %g: %s\n\n", shape.name.c_str(), n, edge, e.what());
      }
    }
    const double without = compare_with_formula(shape, finest[i].region.surface).distance;
    checks.at_most(
        shape.name + ": distance from the exact surface with three inner curves over none",
        with_three / without, 1);
    checks.at_most(
        shape.name + ": distance from the exact surface with nine inner curves over three",
        with_nine / with_three, 0.5);
  }
  inner.print();

  std::printf("With exact normals along the boundary: distance from the exact surface.\n\n");
  Table normals;
  add(normals, {"boundary and normals", "edge", "triangles", "from exact", "seconds"},
      quality_head);
  for (const AnalyticShape& shape : shapes)
    for (int g = 0; g < grids; ++g) {
      const double edge = shape.coarse * std::pow(0.5, g);
      try {
        const SkinnedShape made =
            skin(shape, shape.boundary(), edge, fit_tolerance(edge),
                 [&](const RegionLayout& l, ConstraintSet& set) { add_normals(shape, l, set); });
        const FormulaComparison a = compare_with_formula(shape, made.region.surface);
        worst.take(made, a.flipped);
        add(normals,
            {g == 0 ? shape.name : "", format_number(edge), std::to_string(made.triangles()),
             text("%.2e", a.distance), text("%.3f", made.seconds)},
            quality_text(made.quality, a.flipped));
      } catch (const Error& e) {
        normals.add({shape.name, format_number(edge), "refused"});
        std::printf("%s, edge %g: %s\n\n", shape.name.c_str(), edge,
                    std::string(e.what()).substr(0, 300).c_str());
      }
    }
  normals.print();

  if (!occ_version().empty()) {
    std::printf("OpenCASCADE %s's filling of the same boundary curves.\n\n", occ_version().c_str());
    Table peer;
    peer.add({"filling", "tolerance", "from exact", "Batten's", "from curves", "points inside",
              "poles", "seconds", "message"});
    for (size_t i = 0; i < shapes.size(); ++i) {
      const AnalyticShape& shape = shapes[i];
      std::vector<std::vector<HermiteCurve>> loops;
      for (const auto& pieces : finest[i].region.boundary) {
        loops.emplace_back();
        for (const BoundarySegment& piece : pieces)
          loops.back().push_back(boundary_curve(finest[i].region, piece));
      }
      for (const OccFillingSettings& s :
           {OccFillingSettings{"", 1e-4, 15, 9}, OccFillingSettings{"", 1e-5, 15, 60}}) {
        std::unique_ptr<OccFilling> filling;
        const double t = cpu_seconds_of(
            [&] { filling = std::make_unique<OccFilling>(loops, std::vector<HermiteCurve>{}, s); });
        const double ours = compare_with_formula(shape, finest[i].region.surface).distance;
        if (!filling->done()) {
          peer.add({shape.name, format_number(s.tolerance), "-", text("%.2e", ours), "-", "-", "-",
                    text("%.2f", t), filling->error_message()});
          continue;
        }
        double distance = 0, to_lines = 0;
        const auto points = filling->points(40);
        for (const Vec3& p : points)
          distance = std::max(distance, shape.surface.closest(p).distance);
        for (const auto& loop : loops)
          for (const HermiteCurve& c : loop)
            for (int k = 0; k <= 40; ++k)
              to_lines = std::max(
                  to_lines,
                  filling->distance(c.evaluate(c.start() + (c.end() - c.start()) * k / 40)));
        peer.add({shape.name, format_number(s.tolerance), text("%.2e", distance),
                  text("%.2e", ours), text("%.2e", to_lines), std::to_string(points.size()),
                  text("%d x %d", filling->poles()[0], filling->poles()[1]), text("%.2f", t),
                  filling->error_message().empty() ? "done" : filling->error_message()});
      }
    }
    peer.print();
  }

  if (argc < 2) compare_expected(checks);

  checks.at_most("largest distance from mesh-aligned curves over the size", worst.residual, 1e-10);
  checks.at_most("largest gap of embedded curves over the tolerance", worst.gap, 1);
  checks.at_most("flipped normals", worst.flipped, 0);
  checks.print("shapes");
}
