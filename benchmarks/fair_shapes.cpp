// SPDX-License-Identifier: MPL-2.0
#include "fair_shapes.h"

#include <cmath>
#include <map>
#include <numbers>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/join.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/random_outlines.h"
#include "batten/tests/support/test_model_builder.h"

namespace batten::bench {
namespace {

using std::numbers::pi;

// Calls visit(point) for some points of each triangle.
template <class Visit>
void for_each_point(const Surface& surface, const Visit& visit) {
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(2.8, 0.1, 0.1), Vec3(0.1, 1.5, 1.4)})
      visit(surface.position({t, L / 3}));
}

double farthest(const AnalyticShape& shape, const Surface& surface) {
  double worst = 0;
  for_each_point(
      surface, [&](const Vec3& x) { worst = std::max(worst, shape.surface.closest(x).distance); });
  return worst;
}

// Bilinearly blended Coons patch of the four sides, as built by many programs.
double coons_distance(const AnalyticShape& shape) {
  const Formula& x = shape.surface;
  constexpr int n = 24;
  double worst = 0;
  for (int i = 1; i < n; ++i)
    for (int j = 1; j < n; ++j) {
      const double s = 1.0 * i / n, t = 1.0 * j / n;
      const Vec3 corners =
          (1 - s) * ((1 - t) * x(0, 0) + t * x(0, 1)) + s * ((1 - t) * x(1, 0) + t * x(1, 1));
      const Vec3 place =
          (1 - s) * x(0, t) + s * x(1, t) + (1 - t) * x(s, 0) + t * x(s, 1) - corners;
      worst = std::max(worst, x.closest(place).distance);
    }
  return worst;
}

bool is_cyclide(const AnalyticShape& shape) {
  return shape.name != "saddle" && shape.name != "helicoid strip" && shape.name != "ruled";
}

std::vector<AnalyticShape> more_shapes() {
  using Space = Formula::Space;
  return {{"cone 120", Formula([](const Jet& s, const Jet& t) {
             const Jet a = Jet(2 * pi / 3) * s, r = Jet(1) - Jet(0.6) * t;
             return Space{r * cos(a), r * sin(a), Jet(1.2) * t};
           })},
          {"oblique cylinder", Formula([](const Jet& s, const Jet& t) {
             const Jet a = Jet(2 * pi / 3) * s;
             return Space{cos(a), sin(a), Jet(0.3) * cos(a) + Jet(1.5) * t};
           })},
          {"ruled", Formula([](const Jet& s, const Jet& t) {
             return Space{Jet(2) * s, Jet(1.5) * t,
                          s * (Jet(1) - s) * (Jet(1.6) - Jet(1.2) * t) + Jet(0.2) * t};
           })},
          {"torus half", Formula([](const Jet& s, const Jet& t) {
             const Jet a = Jet(pi) * s, b = Jet(pi) * (t - Jet(0.5));
             const Jet r = Jet(2) + Jet(0.7) * cos(b);
             return Space{r * cos(a), r * sin(a), Jet(0.7) * sin(b)};
           })}};
}

}  // namespace

void compare_fair(std::vector<AnalyticShape> shapes, const char* only, Checks& checks) {
  for (AnalyticShape& shape : more_shapes())
    if (!only || shape.name.find(only) != std::string::npos) shapes.push_back(std::move(shape));
  std::printf(
      "Boundary curves alone, fair = \"variation\": distance from the exact surface over the "
      "size.\n\n");
  Table table;
  table.add({"fair shape", "triangles", "bending", "variation", "Coons", "factorizations",
             "seconds", "curvature variation"});
  for (const AnalyticShape& shape : shapes) {
    double fair_at_500 = 0, bending_at_500 = 0;
    for (int g = 0; g < 4; ++g) {
      SkinOptions options;
      options.edge_length = 2 * shape.coarse * std::pow(0.5, g);
      options.tolerance = 0.01 * std::pow(options.edge_length, 4);
      const ModelLayout model(RegionLayout(shape.name, shape.boundary(), options));
      const Points start = model.minimize_energy({});
      MinimumVariationSurface fair;
      const double t =
          cpu_seconds_of([&] { fair = fair_shape(model, start, model.line_constraints()); });
      const double size = model.size();
      const double bending = farthest(shape, model.surface(start)) / size;
      const double varied = farthest(shape, model.surface(fair.dofs)) / size;
      const int triangles = model.mesh()->triangle_count();
      if (triangles < 600 || g == 0) {
        fair_at_500 = varied;
        bending_at_500 = bending;
      }
      const bool square = shape.domain == AnalyticShape::Domain::Square;
      table.add({g == 0 ? shape.name : "", std::to_string(triangles), text("%.1e", bending),
                 text("%.1e", varied), square ? text("%.1e", coons_distance(shape) / size) : "",
                 std::to_string(fair.factorizations), text("%.3f", t),
                 text("%.2e", fair.start_functional) + " -> " + text("%.2e", fair.functional)});
    }
    if (is_cyclide(shape))
      checks.at_most(shape.name + ": fair shape's distance from the exact surface over the size",
                     fair_at_500, shape.domain == AnalyticShape::Domain::Annulus ? 5e-3 : 1e-3);
    else
      checks.at_most(shape.name + ": fair shape's distance over that of bending energy",
                     fair_at_500 / bending_at_500, 1);
  }
  table.print();
}

namespace {

struct Joined {
  std::string name;
  batten_test::TestModelBuilder patches;
  std::vector<std::tuple<std::string, int, int>> joins;
  std::function<double(const Vec3&)> distance;
};

void add_line(batten_test::TestModelBuilder& p, const std::string& name, const Vec3& a,
              const Vec3& b) {
  p.add(batten_test::prescribed_line(name, curve_through_points(name, {a, b}), 3,
                                     p.options.edge_length));
}
void add_arc(batten_test::TestModelBuilder& p, const std::string& name, const Vec3& a,
             const Vec3& b, const Vec3& centre = Vec3::Zero()) {
  p.add(batten_test::prescribed_line(
      name,
      curve_from_formula(0, pi / 2,
                         [=](double t, int order) -> Vec3 {
                           if (order == 0) return centre + a * std::cos(t) + b * std::sin(t);
                           return order == 1 ? Vec3(-a * std::sin(t) + b * std::cos(t))
                                             : Vec3(-a * std::cos(t) - b * std::sin(t));
                         }),
      3, p.options.edge_length));
}

std::vector<Joined> joined_shapes(double h) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const auto sphere = [](const Vec3& p) { return std::abs(p.norm() - 1); };
  const auto cylinder = [](const Vec3& p) { return std::abs(std::hypot(p.x(), p.y()) - 1); };
  std::vector<Joined> all;
  all.push_back({"two octants", batten_test::octants(h), {{"zx", 0, 1}}, sphere});

  Joined quarters{"two quarter cylinders", {}, {{"middle", 0, 1}}, cylinder};
  batten_test::TestModelBuilder& q = quarters.patches;
  q.options.edge_length = h;
  const Vec3 up = 1.5 * z;
  add_arc(q, "low1", x, y);
  add_arc(q, "low2", y, -x);
  add_arc(q, "high1", x, y, up);
  add_arc(q, "high2", y, -x, up);
  add_line(q, "first", x, x + up);
  add_line(q, "middle", y, y + up);
  add_line(q, "last", -x, -x + up);
  q.region({"low1", "middle", "high1", "first"});
  q.region({"low2", "last", "high2", "middle"});
  all.push_back(std::move(quarters));

  Joined cap{"cap on cylinder", {}, {{"rim", 0, 1}}, [=](const Vec3& p) {
               return p.z() > 0 ? sphere(p) : cylinder(p);
             }};
  batten_test::TestModelBuilder& c = cap.patches;
  c.options.edge_length = h;
  const Vec3 down = -1.2 * z;
  add_arc(c, "rim", x, y);
  add_arc(c, "yz", y, z);
  add_arc(c, "zx", z, x);
  add_line(c, "side1", x, x + down);
  add_line(c, "side2", y, y + down);
  add_arc(c, "foot", x, y, down);
  c.region({"rim", "yz", "zx"});
  c.region({"-rim", "side1", "foot", "side2"});
  all.push_back(std::move(cap));

  Joined half{"hemisphere of four octants",
              {},
              {{"up1", 3, 0}, {"up2", 0, 1}, {"up3", 1, 2}, {"up4", 2, 3}},
              sphere};
  batten_test::TestModelBuilder& s = half.patches;
  s.options.edge_length = h;
  const Vec3 around[4] = {x, y, -x, -y};
  for (int k = 0; k < 4; ++k) {
    add_arc(s, "rim" + std::to_string(k + 1), around[k], around[(k + 1) % 4]);
    add_arc(s, "up" + std::to_string(k + 1), around[k], z);
  }
  for (int k = 0; k < 4; ++k)
    s.region({"rim" + std::to_string(k + 1), "up" + std::to_string((k + 1) % 4 + 1),
              "up" + std::to_string(k + 1)});
  all.push_back(std::move(half));
  return all;
}

}  // namespace

void compare_joined(Checks& checks) {
  std::printf("Several faces with smooth edges: radius 1, curvature jump in 1/radius.\n\n");
  Table table;
  table.add({"joined", "triangles", "bending", "variation", "angle", "jump, bending",
             "jump, variation", "factorizations", "seconds"});
  for (const Joined& shape : joined_shapes(0.15)) {
    std::vector<JoinLine> lines;
    for (const auto& [name, a, b] : shape.joins)
      lines.push_back(shape.patches.join_line(name, a, b));
    const ModelLayout model = shape.patches.model(lines);
    const Points start = model.minimize_energy({});
    MinimumVariationSurface fair;
    const double t =
        cpu_seconds_of([&] { fair = fair_shape(model, start, model.line_constraints()); });
    const auto measured = [&](const Points& dofs, double& distance, double& jump) {
      std::vector<SkinnedRegion> regions;
      for (int r = 0; r < model.region_count(); ++r) regions.push_back(model.skinned(r, dofs));
      std::vector<const SkinnedRegion*> made;
      for (const SkinnedRegion& region : regions) made.push_back(&region);
      for_each_point(model.surface(dofs),
                     [&](const Vec3& x) { distance = std::max(distance, shape.distance(x)); });
      double angle = 0;
      for (const JoinLine& line : lines) {
        const JoinQuality quality = measure_join(made, line);
        angle = std::max(angle, quality.max_deg);
        jump = std::max(jump, quality.median_curvature_jump);
      }
      return angle;
    };
    double bending = 0, varied = 0, jump_before = 0, jump = 0;
    measured(start, bending, jump_before);
    const double angle = measured(fair.dofs, varied, jump);
    table.add({shape.name, std::to_string(model.mesh()->triangle_count()), text("%.1e", bending),
               text("%.1e", varied), text("%.4f", angle), text("%.2e", jump_before),
               text("%.2e", jump), std::to_string(fair.factorizations), text("%.3f", t)});
    checks.at_most(shape.name + ": distance from the exact surface over the radius", varied, 1e-3);
    checks.at_most(shape.name + ": angle at smooth edges, degrees", angle, 0.1);
  }
  table.print();
}

namespace {

CharacterLine line_through(const std::string& name, const std::vector<Vec3>& points) {
  CharacterLine line;
  line.name = name;
  line.curve = curve_through_points(name, points, 60);
  return line;
}

CharacterLine circle(const std::string& name, double radius, double z) {
  std::vector<Vec3> points;
  constexpr int pieces = 48;
  for (int i = 0; i <= pieces; ++i) {
    const double a = 2 * pi * (i % pieces) / pieces;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return line_through(name, points);
}

// Volume between the surface and flat caps over circles in z = 0 and z = h.
double volume_of(const Surface& surface, double cap, double h) {
  const SurfaceAssembler assembler(surface.mesh(), surface.kind(), surface.trim());
  const double side =
      surface.dofs().cwiseProduct(assembler.pressure_load(surface.dofs())).sum() / 3;
  return std::abs(side) + pi * cap * cap * h / 3;
}

// An annulus between two circles: the largest error of the radius, relative to the larger one, and
// the volume relative to the exact one.
void compare_annulus(const char* name, double r0, double r1, double h, double edge,
                     double (*radius_at)(double z), const std::vector<CharacterLine>& more,
                     double target, Table& table, Checks& checks) {
  std::vector<CharacterLine> lines{circle("low", r0, 0), circle("high", r1, h)};
  lines.insert(lines.end(), more.begin(), more.end());
  SkinOptions options;
  options.edge_length = edge;
  const ModelLayout model(RegionLayout(name, lines, options));
  const Points start = model.minimize_energy({});
  MinimumVariationSurface fair;
  const double t =
      cpu_seconds_of([&] { fair = fair_shape(model, start, model.line_constraints()); });
  const auto error = [&](const Points& dofs) {
    double worst = 0;
    for_each_point(model.surface(dofs), [&](const Vec3& x) {
      worst = std::max(worst, std::abs(std::hypot(x.x(), x.y()) - radius_at(x.z())));
    });
    return worst / std::max(r0, r1);
  };
  const double varied = error(fair.dofs);
  double volume = 0;
  constexpr int slices = 10000;
  for (int i = 0; i < slices; ++i) {
    const double r = radius_at(h * (i + 0.5) / slices);
    volume += pi * r * r * h / slices;
  }
  const double fraction = volume_of(model.surface(fair.dofs), r1, h) / volume;
  table.add({name, std::to_string(model.mesh()->triangle_count()), text("%.1e", error(start)),
             text("%.1e", varied),
             text("%.4f", volume_of(model.surface(start), r1, h) / volume) + ", " +
                 text("%.4f", fraction),
             std::to_string(fair.factorizations), text("%.3f", t)});
  checks.at_most(std::string(name) + ": largest error of the radius", varied, target);
  checks.at_most(std::string(name) + ": error of the volume", std::abs(fraction - 1), target);
}

// NACA 0012, chords of 100 and 60 at a distance of 300: upper half between two sections and two
// rails.
void compare_wing(Table& table, Checks& checks) {
  const auto section = [](double chord, double sweep, double y) {
    std::vector<Vec3> points;
    constexpr int pieces = 32;
    for (int i = 0; i <= pieces; ++i) {
      const double x = 0.5 * (1 - std::cos(pi * i / pieces));
      const double z = 0.6 * (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x +
                              0.2843 * x * x * x - 0.1036 * x * x * x * x);
      points.emplace_back(sweep + chord * x, y, chord * std::max(0.0, z));
    }
    return points;
  };
  const std::vector<Vec3> root = section(100, 0, 0), tip = section(60, 20, 300);
  const std::vector<CharacterLine> lines{
      line_through("root", root), line_through("trailing", {root.back(), tip.back()}),
      line_through("tip", tip), line_through("leading", {tip.front(), root.front()})};
  SkinOptions options;
  options.edge_length = 12;
  const auto layout = std::make_shared<const ModelLayout>(RegionLayout("wing", lines, options));
  const Points start = layout->minimize_energy({});
  LoftedModel loft;
  const double t =
      cpu_seconds_of([&] { loft = loft_model(layout, {"root"}, 2 * layout->tolerance()); });
  const auto crown = [&](const ModelLayout& model, const Points& dofs) {
    double height = 0;
    for_each_point(model.surface(dofs), [&](const Vec3& x) {
      if (std::abs(x.y() - 150) < 10) height = std::max(height, x.z());
    });
    return height;
  };
  const double ruled = 0.06 * 80;  // of the section at half the span
  const double lofted = crown(*loft.layout, loft.dofs);
  table.add({"wing, crown at mid-span", std::to_string(loft.layout->mesh()->triangle_count()),
             text("%.2f", crown(*layout, start)), text("%.2f (loft)", lofted), "", "1",
             text("%.3f", t)});
  checks.at_least("wing: crown at mid-span over that of a ruled surface", lofted / ruled, 0.98);
}

}  // namespace

void compare_sections(Checks& checks) {
  std::printf("Sections: largest error of the radius, over the radius.\n\n");
  Table table;
  table.add({"sections", "triangles", "bending", "variation", "volume over the exact one, both",
             "factorizations", "seconds"});
  compare_annulus(
      "can", 33, 33, 120, 12, [](double) { return 33.0; }, {}, 5e-3, table, checks);
  compare_annulus(
      "tube", 10, 10, 150, 5, [](double) { return 10.0; }, {}, 5e-3, table, checks);
  compare_annulus(
      "frustum", 40, 25, 60, 10, [](double z) { return 40 - z / 4; }, {}, 5e-3, table, checks);
  std::vector<Vec3> meridian;
  for (int i = 0; i <= 16; ++i) {
    const double a = std::asin(0.6) * (i / 8.0 - 1);
    meridian.emplace_back(50 * std::cos(a), 0, 30 + 50 * std::sin(a));
  }
  CharacterLine line = line_through("meridian", meridian);
  line.role = CharacterLine::Role::Inner;
  compare_annulus(
      "sphere's band with a meridian", 40, 40, 60, 8,
      [](double z) { return std::sqrt(2500 - (z - 30) * (z - 30)); }, {line}, 1e-2, table, checks);
  compare_wing(table, checks);
  table.print();
}

void compare_random(Checks& checks) {
  batten_test::Random random(7);
  int skinned = 0, faired = 0, far = 0, spoiled = 0;
  double worst_move = 0, worst_residual = 0, slowest = 0, seconds = 0, triangles = 0;
  std::map<std::string, int> failed;
  constexpr int outlines = 300;
  for (int k = 0; k < outlines; ++k) {
    const auto lines = batten_test::random_lines(random);
    std::shared_ptr<const ModelLayout> layout;
    Points start;
    try {
      layout = std::make_shared<const ModelLayout>(RegionLayout("random", lines, {}));
      start = layout->minimize_energy({});
    } catch (const Error&) {
      continue;  // no surface: its message is checked by other tests
    }
    ++skinned;
    SurfaceModel model;
    model.regions.emplace_back().plan.name = "random";
    model.regions[0].layout_index = 0;
    FairingResult fair;
    std::string why;
    const double t = cpu_seconds_of([&] {
      try {
        fair = fair_model(model, layout, start, 0.1);
      } catch (const Error& e) {
        why = e.what();
      }
    });
    if (!why.empty()) {
      ++failed[why.substr(0, why.find(" (pivot"))];
      continue;
    }
    ++faired;
    const double count = fair.layout->mesh()->triangle_count();
    seconds += t;
    triangles += count;
    slowest = std::max(slowest, 1000 * t / count);
    const double move = fair.surface.max_move / layout->size();
    far += move > 0.1;
    worst_move = std::max(worst_move, move);
    worst_residual = std::max(worst_residual, fair.surface.max_residual / layout->size());
    const SkinQuality before = measure(layout->skinned(0, start)),
                      after = measure(fair.layout->skinned(0, fair.surface.dofs));
    spoiled += after.min_jacobian_ratio <= 0 && before.min_jacobian_ratio > 0;
  }
  std::printf(
      "%d random outlines with holes and ribs: %d have a surface, %d are faired (%.2f s for 1,000 "
      "triangles on average, %.2f at most), %d move by more than a tenth of the size (at most "
      "%.2f), %d become inverted\n",
      outlines, skinned, faired, 1000 * seconds / triangles, slowest, far, worst_move, spoiled);
  int unnamed = 0;
  for (const auto& [why, count] : failed) {
    std::printf("  %d not faired: %s\n", count, why.c_str());
    unnamed += why.empty() ? count : 0;
  }
  std::printf("\n");
  checks.at_most("random outlines: largest displacement over the size", worst_move, 0.5);
  checks.at_most("random outlines: largest residual over the size", worst_residual, 1e-10);
  checks.at_most("random outlines: surfaces that become inverted", spoiled, 0);
  checks.at_most("random outlines: failures without a reason", unnamed, 0);
  checks.at_most("random outlines: seconds for 1,000 triangles at most", slowest, 10);
}

}  // namespace batten::bench
