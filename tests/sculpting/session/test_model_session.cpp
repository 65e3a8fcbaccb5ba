// SPDX-License-Identifier: MPL-2.0
// Sessions on models of several faces: smooth edges during motion, curves that move all adjacent
// faces, and models of one face that equal this face.
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface_assembler.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/session_scenes.h"
#include "batten/tests/support/test_model_builder.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

double angle_at(const SculptingSession& session, const std::string& line) {
  const JoinPlan* plan = session.layout().join_plan(line);
  REQUIRE(plan);
  const auto made = session.regions();
  std::vector<const SkinnedRegion*> all;
  for (const auto& r : made) all.push_back(&r);
  return measure_join(all, plan->join_line, {plan->ends[0].open, plan->ends[1].open})
      .max_inside_deg;
}

// Largest distance of the surfaces from a curve, on all of its sides.
double off_line(const SculptingSession& session, const std::string& line) {
  double most = 0;
  for (const SkinnedRegion& region : session.regions())
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
      if (aligned_line.line.name == line) {
        SkinnedRegion one = region;
        one.edge_aligned = {aligned_line};
        one.embedded.clear();
        most = std::max(most, measure(one).max_line_residual);
      }
  return most;
}

ModelLayout two_octants(double h) {
  const TestModelBuilder p = octants(h);
  return p.model({p.join_line("zx", 0, 1)});
}

// A box without its top and bottom: four walls, all edges creases, its corners at ±1.
TestModelBuilder walls(double h) {
  TestModelBuilder p;
  p.options.edge_length = h;
  p.size = 3.4;
  const Vec3 c[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const auto line = [&](const std::string& name, const Vec3& a, const Vec3& b) {
    p.add(prescribed_line(name, curve_through_points(name, {a, b}), 2, h));
  };
  const Vec3 up(0, 0, 1);
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i);
    line("low " + n, c[i], c[(i + 1) % 4]);
    line("high " + n, c[i] + up, c[(i + 1) % 4] + up);
    line("post " + n, c[i], c[i] + up);
  }
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i), next = std::to_string((i + 1) % 4);
    p.region({"low " + n, "post " + next, "high " + n, "post " + n});
  }
  return p;
}

}  // namespace

TEST_CASE("a model of one face is the face: the same bits", "[sculpting][session]") {
  const RegionLayout region = patch_layout(0.3);
  const ModelLayout model({region.name(), region.size(), region.tolerance(), region.origin()},
                          {std::make_shared<const RegionLayout>(region)}, {});
  Points shapes[2];
  for (int i = 0; i < 2; ++i) {
    SculptingSession session(i ? model : ModelLayout(region), {});
    session.add(Load{"p", Load::Pressure{}}, {slider("p", 3)});
    session.solve_to_equilibrium();
    shapes[i] = session.dofs();
  }
  CHECK(same_bits(shapes[0], shapes[1]));
}

TEST_CASE("two octants joined smoothly under pressure are symmetric, and converge",
          "[sculpting][session]") {
  std::vector<Vec3> tops;
  for (const double h : {0.4, 0.2, 0.1}) {
    INFO("h = " << h);
    SculptingSession pair(two_octants(h), {});
    const Points rest = pair.dofs();
    pair.add(Load{"p", Load::Pressure{}}, {slider("p", -20)});
    pair.solve_to_equilibrium();
    CHECK(difference(pair.dofs(), rest) > 0.05);
    const SkinnedRegion a = pair.region(0), b = pair.region(1);
    // A half turn about x + z maps the octants to each other, including their meshes.
    double lopsided = 0;
    for (int t = 0; t < a.surface.mesh().triangle_count(); t += 5) {
      const Vec3 x = a.surface.position({t});
      lopsided = std::max(lopsided, b.surface.closest_point({x.z(), -x.y(), x.x()}).distance);
    }
    CHECK(lopsided < 1e-8);
    CHECK(angle_at(pair, "zx") < 0.1);
    // The intersection with the ray through the middle of the octant.
    const Surface::ClosestPoint middle = a.surface.closest_point(Vec3(1, 1, 1).normalized());
    tops.push_back(a.surface.position(middle.where));
  }
  const double coarse = (tops[1] - tops[0]).norm(), fine = (tops[2] - tops[1]).norm();
  INFO(coarse << " " << fine);
  CHECK(fine < 0.5 * coarse);
  CHECK(fine < 2e-3);
}

TEST_CASE("two faces that unfold into one plane, under pressure, are the one face",
          "[sculpting][session]") {
  // Over [0, 2] × [0, 1], with an inner curve at 1 in both models.
  const auto high = [](const Vec2& p) { return 0.2 * std::sin(1.5 * p.x()) * std::cos(p.y()); };
  const auto lifted = [&](const Vec2& a, const Vec2& b) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 8; ++i) {
      const Vec2 p = a + (b - a) * i / 8.0;
      points.emplace_back(p.x(), p.y(), high(p));
    }
    return curve_through_points("line", points);
  };
  std::vector<double> apart;
  for (const double h : {0.4, 0.2, 0.1}) {
    TestModelBuilder p;
    p.options.edge_length = h;
    for (const auto& [name, a, b] : {std::tuple<const char*, Vec2, Vec2>{"s1", {0, 0}, {1, 0}},
                                     {"s2", {1, 0}, {2, 0}},
                                     {"e", {2, 0}, {2, 1}},
                                     {"n2", {2, 1}, {1, 1}},
                                     {"n1", {1, 1}, {0, 1}},
                                     {"w", {0, 1}, {0, 0}},
                                     {"middle", {1, 0}, {1, 1}}})
      p.add(prescribed_line(name, lifted(a, b), 4, h));
    std::vector<CharacterLine> lines;
    for (auto [name, line] : p.lines) {
      line.prescribed.reset();
      line.role = name == "middle" ? CharacterLine::Role::Inner : CharacterLine::Role::Outline;
      lines.push_back(line);
    }
    // The outline starts with the curve along u.
    std::swap(lines[0], *std::find_if(lines.begin(), lines.end(),
                                      [](const auto& l) { return l.name == "s1"; }));
    const RegionLayout whole("whole", lines, p.options);
    p.size = whole.size();
    p.region({"s1", "middle", "n1", "w"});
    p.region({"s2", "e", "n2", "middle"});
    SculptingSession pair(p.model({p.join_line("middle", 0, 1)}), {}), one(whole, {});
    for (SculptingSession* session : {&pair, &one}) {
      session->add(Load{"p", Load::Pressure{}}, {slider("p", 400)});
      session->solve_to_equilibrium();
    }
    const Surface all = one.region().surface;
    double most = 0, moved = 0;
    for (const SkinnedRegion& r : pair.regions())
      for (int t = 0; t < r.surface.mesh().triangle_count(); t += 3) {
        const Vec3 x = r.surface.position({t});
        most = std::max(most, all.closest_point(x).distance);
        moved = std::max(moved, std::abs(x.z() - high(x.head<2>())));
      }
    CHECK(moved > 0.02);
    apart.push_back(most);
  }
  INFO(apart[0] << " " << apart[1] << " " << apart[2]);
  CHECK(apart[2] < 0.5 * apart[1]);
  CHECK(apart[2] < 1e-3);
}

TEST_CASE("a smooth join holds after every operation, at every update", "[sculpting][session]") {
  SculptingSession session(two_octants(0.1), {});
  const double rest = angle_at(session, "zx");
  session.add(Load{"on one", Load::Pressure{Area{Area::Everywhere{}, {"region 1"}}}});
  session.add(Load{"on all", Load::Pressure{}});
  session.add(StiffnessField{
      "stiff", StiffnessField::Kind::Bending, {Area::Painted{{{Vec3(0.7, 0, 0.7), 0.5, 1}}}}, {}});
  session.add(LineOffset{"ridge", "zx", {}, 0.3});
  const Vec3 at = session.region(0).surface.position({7});
  session.add(Constraint{"pin", Constraint::Point{at, at}});
  double worst = 0, off = 0;
  const auto look = [&] {
    worst = std::max(worst, angle_at(session, "zx"));
    off = std::max(off, off_line(session, "zx"));
    CHECK(session.residual() < 1e-10);
  };
  for (int i = 1; i <= 4; ++i) {
    session.set("on one", 8 * i);
    session.solve_preview(1);
    look();
    session.set("ridge", 0.02 * i);
    session.solve_preview(1);
    look();
    session.set("stiff", 5 * i);
    session.solve_preview();
    look();
    session.set("pin.x", at.x() + 0.01 * i);
    session.set("on all", -5 * i);
    session.solve_preview();
    look();
  }
  session.start_motion({.dt = 0.05});
  session.set("on all", 15);
  for (int i = 0; i < 10; ++i) {
    session.step();
    look();
  }
  session.stop_motion();
  CHECK(worst < std::max(rest, 0.1) + 0.05);
  CHECK(off < 1e-10);
  // The curve is at its offset position.
  const HermiteCurve moved = session.line("zx");
  CHECK((moved.evaluate(0.5 * moved.end()).norm()) == Approx(1.08).epsilon(1e-3));
}

TEST_CASE("a pressure on one face reaches others only by the join, one without faces acts on all",
          "[sculpting][session]") {
  const TestModelBuilder p = walls(0.25);
  SculptingSession session(p.model({}), {});
  const Points rest = session.dofs();
  session.add(Load{"one", Load::Pressure{Area{Area::Everywhere{}, {"region 2"}}}},
              {slider("one", 5)});
  session.solve_to_equilibrium();
  for (int r = 0; r < 4; ++r) {
    const double moved =
        (session.layout().region_dofs(r, session.dofs()) - session.layout().region_dofs(r, rest))
            .cwiseAbs()
            .maxCoeff();
    if (r == 1)
      CHECK(moved > 1e-3);
    else
      CHECK(moved < 1e-12);
  }
  session.set("one", 0);
  session.add(Load{"all", Load::Pressure{}}, {slider("all", 5)});
  session.solve_to_equilibrium();
  // A quarter turn maps the four walls to each other.
  const auto made = session.regions();
  const auto bulge = [&](int r) {
    double most = 0;
    for (int t = 0; t < made[static_cast<size_t>(r)].surface.mesh().triangle_count(); ++t) {
      const Vec3 x = made[static_cast<size_t>(r)].surface.position({t});
      most = std::max({most, std::abs(x.x()) - 1, std::abs(x.y()) - 1});
    }
    return most;
  };
  CHECK(bulge(0) > 1e-3);
  for (int r = 1; r < 4; ++r) CHECK(bulge(r) == Approx(bulge(0)).epsilon(1e-6));
  CHECK_THROWS_WITH(session.add(Load{"x", Load::Pressure{Area{Area::Everywhere{}, {"region 9"}}}}),
                    Contains("no face 'region 9'") && Contains("did you mean"));
}

TEST_CASE("a shared crease moves with both faces, and along the normal it needs a direction",
          "[sculpting][session]") {
  const TestModelBuilder p = walls(0.25);
  SculptingSession session(p.model({}), {});
  CHECK_THROWS_WITH(session.add(LineOffset{"m", "post 1", {}, 0.4}),
                    Contains("crease 'post 1'") && Contains("add a direction"));
  session.add(LineOffset{"m", "post 1", Vec3(1, -1, 0), 0.4}, {slider("m", 0.2)});
  session.solve_to_equilibrium();
  CHECK(off_line(session, "post 1") < 1e-12);
  int sides = 0;
  const HermiteCurve moved = session.line("post 1");
  for (const SkinnedRegion& region : session.regions())
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned) {
      if (aligned_line.line.name != "post 1") continue;
      ++sides;
      CHECK((aligned_line.fitted.evaluate(0.5) - moved.evaluate(0.5)).norm() < 1e-14);
    }
  CHECK(sides == 2);
  CHECK((moved.evaluate(0.5 * moved.end()) - Vec3(1.2, -1.2, 0.5)).norm() < 1e-12);
  // As a whole it would be separated from the curves that end there: they are named.
  session.add(LineOffset{"n", "post 2", Vec3(1, 1, 0), 0});
  session.set("n", 0.1);
  CHECK_THROWS_AS(session.solve_to_equilibrium(), ConflictError);
}

TEST_CASE("refinement halves both sides of a curve alike, and joins stay", "[sculpting][session]") {
  SculptingSession session(two_octants(0.4), {});
  session.add(Load{"p", Load::Pressure{}}, {slider("p", 10)});
  session.solve_to_equilibrium();
  const double before = angle_at(session, "zx");
  const Vec3 place = session.line("zx").evaluate(0.8);
  const RefinementReport report = session.refine({Refinement::Brush{{{place, 0.3, 1}}}});
  CHECK(report.triangles > report.triangles_before);
  const auto made = session.regions();
  std::vector<std::vector<double>> at;
  for (const SkinnedRegion& region : made)
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
      if (aligned_line.line.name == "zx") at.push_back(aligned_line.parameters);
  REQUIRE(at.size() == 2);
  CHECK(at[0] == at[1]);
  CHECK(at[0].size() > 4);
  CHECK(angle_at(session, "zx") < 1.01 * before);
  CHECK(session.residual() < 1e-12);
  REQUIRE(session.undo());
  CHECK(angle_at(session, "zx") == before);
}

TEST_CASE("a model fixed at its corners stays connected along its curves", "[sculpting][session]") {
  SessionOptions options;
  options.fix_corners_only = true;
  for (const bool box : {false, true}) {
    const TestModelBuilder p = walls(0.25);
    SculptingSession session(box ? p.model({}) : two_octants(0.2), options);
    session.add(Load{"p", Load::Pressure{}}, {slider("p", 1)});
    session.solve_to_equilibrium();
    CHECK(session.residual() < 1e-12);
    // Positions on both sides of every curve are the same, also between vertices.
    for (const ModelLine& line : session.layout().lines()) {
      if (line.sides.size() < 2) continue;
      const SkinnedRegion a = session.region(line.sides[0].region),
                          b = session.region(line.sides[1].region);
      const EdgeAlignedLine& aligned_line =
          a.edge_aligned[static_cast<size_t>(line.sides[0].index)];
      double apart = 0;
      for (const int v : aligned_line.vertices) {
        const Vec3 x = a.surface.dofs().row(3 * v);
        apart = std::max(apart, b.surface.closest_point(x).distance);
      }
      CHECK(apart < 1e-10);
    }
    if (!box) CHECK(angle_at(session, "zx") < 0.1);
  }
}

TEST_CASE("a model's update is the solution of the KKT system", "[sculpting][session]") {
  const ModelLayout model = two_octants(0.4);
  const ConstraintSet rows = independent_constraints(model.line_constraints());
  const SurfaceAssembler assembler(*model.mesh(), model.element(), model.trim());
  SparseMatrix K = assembler.pattern();
  assembler.stiffness(model.scale_to_regions({SurfaceStiffness{}}), K);
  const Points F = assembler.load(model.domain_scale()) * Vec3(0, 0, 3).transpose();
  const Points expected = solve_kkt(rows, K, F);
  StaticTask task;
  task.loads = {{Load{"f", Load::Uniform{{0, 0, 1}, {}}}, 3 / model.size()}};
  const SculptResult result = sculpt(model, task);
  CHECK(difference(result.dofs, expected) < 1e-9);
}

TEST_CASE("curves that rotate the tangents at a node have their joins planned again at equilibrium",
          "[sculpting][session]") {
  // A strip of two squares; its far sides are lifted, and the curve between them rotates with them.
  TestModelBuilder p;
  const double h = 0.2;
  p.options.edge_length = h;
  p.size = 2;
  const auto line = [&](const std::string& name, Vec3 a, Vec3 b) {
    p.add(prescribed_line(name, curve_through_points(name, {a, 0.5 * (a + b), b}), 2, h));
  };
  line("middle", {0, 0, 0}, {0, 1, 0});
  line("s1", {0, 0, 0}, {-1, 0, 0});
  line("s2", {0, 0, 0}, {1, 0, 0});
  line("n1", {0, 1, 0}, {-1, 1, 0});
  line("n2", {0, 1, 0}, {1, 1, 0});
  line("w", {-1, 0, 0}, {-1, 1, 0});
  line("e", {1, 0, 0}, {1, 1, 0});
  p.region({"-middle", "s1", "w", "n1"});
  p.region({"middle", "n2", "e", "s2"});
  SculptingSession session(p.model({p.join_line("middle", 0, 1)}), {});
  // Both sides of the strip bend equally: tangents at the nodes stay in one plane, and rotate.
  const auto bent = [&](const std::string& name, double by) {
    const HermiteCurve old = session.layout().line(name);
    Points dofs = old.dofs();
    const double span = old.end() - old.start();
    for (int n = 0; n < old.node_count(); ++n) {
      const double s = (old.parameters()[static_cast<size_t>(n)] - old.start()) / span;
      dofs(old.mesh().position_dof(n), 2) += by * s * (1 - s);
      dofs(old.mesh().slope_out(n), 2) += by * (1 - 2 * s) / span;
    }
    return HermiteCurve(old.mesh(), dofs);
  };
  for (const auto& [name, by] :
       {std::pair<const char*, double>{"s1", 0.5}, {"s2", -0.5}, {"n1", 0.2}, {"n2", -0.2}})
    session.set_line(name, bent(name, by));
  const SolveReport answer = session.solve_to_equilibrium();
  CHECK(session.layout().gluing_change(session.dofs()) < 1e-7);
  CHECK(angle_at(session, "middle") < 0.1);
  CHECK(answer.converged);
}

TEST_CASE("a node whose planes differ within the tolerance of joins is no reason to plan again",
          "[sculpting][session]") {
  // Two squares, the outer corner of one lifted: their planes differ by 0.05 degrees at a node.
  TestModelBuilder p;
  const double h = 0.25, lift = std::tan(0.05 * pi / 180);
  p.options.edge_length = h;
  const auto line = [&](const std::string& name, Vec3 a, Vec3 b) {
    p.add(prescribed_line(name, curve_through_points(name, {a, b}), 2, h));
  };
  line("middle", {0, 0, 0}, {0, 1, 0});
  line("s1", {0, 0, 0}, {-1, 0, 0});
  line("s2", {0, 0, 0}, {1, 0, 0});
  line("n1", {0, 1, 0}, {-1, 1, 0});
  line("n2", {0, 1, 0}, {1, 1, lift});
  line("w", {-1, 0, 0}, {-1, 1, 0});
  line("e", {1, 0, 0}, {1, 1, lift});
  p.region({"-middle", "s1", "w", "n1"});
  p.region({"middle", "n2", "e", "s2"});
  const ModelLayout model = p.model({p.join_line("middle", 0, 1)});
  REQUIRE(model.join_plan("middle"));
  CHECK(model.join_plan("middle")->ends[1].plane_angle_deg == Approx(0.05).epsilon(1e-6));
  SculptingSession session(model, {});
  session.add(Load{"p", Load::Pressure{}}, {slider("p", 1)});
  CHECK_FALSE(session.solve_to_equilibrium().joins_planned);
}
