// SPDX-License-Identifier: MPL-2.0
// Constraints that are added, moved and removed during a session.
#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

Constraint pin(const std::string& name, const Vec3& at, const Vec3& goal) {
  return {name, Constraint::Point{at, goal}};
}

// N(where), N_u or N_v as entries on dofs.
std::vector<ConstraintSet::Entry> row(const ModelLayout& layout, const Location& where,
                                      Derivative d) {
  const auto dof = DofMap(*layout.mesh()).triangle(*layout.mesh(), where.triangle);
  const Tabulation N =
      C1Triangle(layout.element(), layout.mesh()->shape(where.triangle)).evaluate(where.L);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 12; ++a)
    if (N(a, d) != 0) entries.push_back({dof[a], N(a, d)});
  return entries;
}

std::vector<ConstraintSet::CoupledEntry> along(const std::vector<ConstraintSet::Entry>& entries,
                                               const Vec3& direction) {
  std::vector<ConstraintSet::CoupledEntry> all;
  for (const auto& e : entries) all.push_back({e.dof, e.coefficient * direction});
  return all;
}

// Vertex numbers of a mesh-aligned curve.
std::vector<int> vertices_of(const ModelLayout& layout, const std::string& line) {
  for (const EdgeAlignedLine& aligned_line : layout.region(0).edge_aligned())
    if (aligned_line.line.name == line) return aligned_line.vertices;
  throw std::runtime_error("no run " + line);
}

}  // namespace

TEST_CASE("constraints added and removed at random: the solution of the independent KKT system",
          "[sculpting][session]") {
  const RegionLayout layout = patch_layout(0.35);
  SculptingSession session(layout, {});
  const Surface rest = shape_of(session);
  const ConstraintSet lines = independent_constraints(layout.line_constraints());
  session.add(Load{"f", Load::Uniform{{0, 0.5, 2}, {}}}, {slider("f", 1)});
  session.solve_to_equilibrium();
  const Matrices matrices(layout);
  const Points F = matrices.assembler.load(Vec3(layout.size() * Vec3(0, 0.5, 2)));
  struct Added {
    Constraint constraint;
    Location where;
  };
  std::vector<Added> all;
  Random random(5);
  const std::vector<Vec2> places = {{0.3, 0.3}, {0.55, 0.8}, {1.2, 0.4}, {1.3, 0.9}, {0.4, 0.55}};
  size_t next = 0;
  for (int n = 0; n < 30; ++n) {
    const bool adds = all.empty() || (all.size() < places.size() && random() > -0.2);
    if (adds) {
      while (std::any_of(all.begin(), all.end(), [&](const Added& a) {
        return a.constraint.name == "c" + std::to_string(next % places.size());
      }))
        ++next;
      const Vec2 uv = places[next % places.size()];
      const auto foot_point = shape_of(session).closest_point({uv.x(), uv.y(), 0.2});
      const Vec3 at = shape_of(session).position(foot_point.where);
      const std::string name = "c" + std::to_string(next % places.size());
      const Added a =
          n % 2 == 0
              ? Added{{name, Constraint::Point{at, at + Vec3(0.01, 0, 0.05 * random())}},
                      foot_point.where}
              : Added{{name, Constraint::Normal{at, Vec3(0.1 * random(), 0.1 * random(), 1)}},
                      foot_point.where};
      session.add(a.constraint);
      all.push_back(a);
    } else {
      const size_t k = static_cast<size_t>(random.between(0, 0.999) * all.size());
      session.remove(all[k].constraint.name);
      all.erase(all.begin() + static_cast<long>(k));
    }
    // Each is at the closest point of its position, computed on the shape when it was added.
    ConstraintSet set = lines;
    for (const Added& a : all) {
      const auto& c = a.constraint;
      if (const auto* p = std::get_if<Constraint::Point>(&c.kind)) {
        set.add(c.name, row(layout, a.where, kW), p->goal);
      } else {
        const Vec3 normal = std::get<Constraint::Normal>(c.kind).normal;
        for (const Derivative d : {kU, kV})
          set.add_coupled(c.name, along(row(layout, a.where, d), normal), 0);
      }
    }
    const Points expected = solve_kkt(set, matrices.K, F);
    INFO("operation " << n << " with " << all.size()
                      << " constraints: " << difference(expected, session.dofs()));
    CHECK(difference(expected, session.dofs()) < 1e-7);
    CHECK(session.residual() < 1e-12);
  }
  CHECK(difference(rest.dofs(), session.dofs()) > 0.01);
}

TEST_CASE("a point dragged by its parameters is at its target, the others stay at theirs",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.25), {});
  const Surface rest = shape_of(session);
  const auto a = rest.closest_point({0.4, 0.6, 0.3}), b = rest.closest_point({1.2, 0.6, 0.3});
  const Vec3 pa = rest.position(a.where), pb = rest.position(b.where);
  session.add(pin("a", pa, pa));
  session.add(pin("b", pb, pb + Vec3(0, 0, 0.1)));
  for (int n = 1; n <= 20; ++n) {
    const double z = pa.z() + 0.02 * n;
    session.set("a.z", z);
    session.set("a.x", pa.x() + 0.005 * n);
    const SolveReport answer = session.solve_preview();
    CHECK(answer.iterations == 1);
    CHECK_FALSE(answer.factored);
    const Surface shape = shape_of(session);
    CHECK((shape.position(a.where) - Vec3(pa.x() + 0.005 * n, pa.y(), z)).norm() < 1e-12);
    CHECK((shape.position(b.where) - pb - Vec3(0, 0, 0.1)).norm() < 1e-12);
    CHECK(session.residual() < 1e-12);
  }
  session.change(pin("b", pa + 0.5 * (pb - pa), pb));
  CHECK(session.residual() < 1e-12);
  CHECK(session.parameters().value("b.z") == pb.z());
  session.remove("a");
  session.remove("b");
  CHECK(difference(session.dofs(), rest.dofs()) < 1e-12);
  CHECK_FALSE(session.parameters().has("a.x"));
}

TEST_CASE("normals and tangents hold where they were put", "[sculpting][session]") {
  SculptingSession session(patch_layout(0.25), {});
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}}, {slider("f", 2)});
  session.solve_to_equilibrium();
  const Surface before = shape_of(session);
  const auto a = before.closest_point({0.4, 0.5, 0.3});
  const Vec3 n = Vec3(0.2, -0.1, 1).normalized(), tau(1, 0.2, 0.4);
  session.add(Constraint{"n", Constraint::Normal{before.position(a.where), 5 * n}});
  const Surface leaning = shape_of(session);
  const auto b = leaning.closest_point({1.2, 0.7, 0.3});
  session.add(Constraint{"t", Constraint::Tangent{leaning.position(b.where), {1, 0.5}, tau}});
  for (const double f : {2.0, -3.0}) {
    session.set("f", f);
    session.solve_to_equilibrium();
    const Surface shape = shape_of(session);
    CHECK(shape.jet(a.where).normal().cross(n).norm() < 1e-9);
    const SurfaceJet jet = shape.jet(b.where);
    CHECK((jet.x_u + 0.5 * jet.x_v).normalized().cross(tau.normalized()).norm() < 1e-9);
  }
}

TEST_CASE("a conflict names its constraints and leaves every bit as it was",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.3), {});
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}}, {slider("f", 2)});
  const Surface rest = shape_of(session);
  const Vec3 at = rest.position(rest.closest_point({0.4, 0.6, 0.3}).where);
  session.add(pin("first", at, at));
  session.solve_to_equilibrium();
  const Points before = session.dofs();
  const auto names = session.names();
  const auto values = session.parameters().values();
  const Vec3 where = shape_of(session).position(shape_of(session).closest_point(at).where);
  try {
    session.add(pin("second", where, at + Vec3(0, 0, 0.3)));
    FAIL("no conflict");
  } catch (const ConflictError& e) {
    CHECK_THAT(e.what(), Contains("second") && Contains("first"));
  }
  CHECK(same_bits(before, session.dofs()));
  CHECK(session.names() == names);
  CHECK(session.parameters().values() == values);
  // Contradicting a curve.
  const Vec3 on_line = session.line("bottom").evaluate(0.3);
  try {
    session.add(pin("third", on_line, on_line + Vec3(0, 0, 1)));
    FAIL("no conflict");
  } catch (const ConflictError& e) {
    CHECK_THAT(e.what(), Contains("third") && Contains("bottom"));
  }
  CHECK(same_bits(before, session.dofs()));
  // A duplicate is no conflict until one of them moves.
  session.add(pin("again", where, at));
  CHECK(difference(before, session.dofs()) < 1e-11);
  session.set("again.z", at.z() + 0.1);
  CHECK_THROWS_AS(session.solve_preview(), ConflictError);
  CHECK(difference(before, session.dofs()) < 1e-11);
  CHECK(session.parameters().value("again.z") == at.z());
}

TEST_CASE("the rib: a curve displaced along the normal, exactly, while its neighbourhood blends",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.15), {});
  const Surface rest = shape_of(session);
  const ModelLayout& layout = session.layout();
  const std::vector<int> vertices = vertices_of(layout, "rib");
  // Isolation: the tangent planes along the rib do not change.
  session.add(Constraint{"plane", Constraint::LineNormal{"rib", {}}});
  CHECK(difference(session.dofs(), rest.dofs()) < 1e-9);
  session.add(LineOffset{"raise", "rib", {}, 0.25});
  for (const double height : {0.03, 0.08, -0.05}) {
    session.set("raise", height);
    const SolveReport answer = session.solve_preview();
    CHECK(answer.iterations == 1);
    CHECK_FALSE(answer.factored);
    const Surface shape = shape_of(session);
    const HermiteCurve line = session.line("rib");
    double on_line = 0, off_normal = 0, highest = 0, turned = 0;
    for (size_t i = 0; i < vertices.size(); ++i) {
      const int v = vertices[i];
      const Vec3 x = shape.dofs().row(3 * v), x0 = rest.dofs().row(3 * v);
      on_line = std::max(on_line, line.closest_point(x).distance);
      const auto at = [&](const Surface& s) {
        return Vec3(
            Vec3(s.dofs().row(3 * v + 1)).cross(Vec3(s.dofs().row(3 * v + 2))).normalized());
      };
      const Vec3 d = x - x0;
      off_normal = std::max(off_normal, (d - d.dot(at(rest)) * at(rest)).norm());
      highest = std::max(highest, std::abs(d.norm()));
      if (i > 0 && i + 1 < vertices.size())
        turned = std::max(turned, at(shape).cross(at(rest)).norm());
    }
    CHECK(on_line < 1e-10);
    CHECK(off_normal < 2e-3 * std::abs(height));
    CHECK(highest == Approx(std::abs(height)).epsilon(1e-6));
    // The ends of a rib with a fade are fixed.
    CHECK((shape.dofs().row(3 * vertices.front()) - rest.dofs().row(3 * vertices.front())).norm() <
          1e-12);
    // Fixed across the curve; along it, the curve itself rotates them.
    INFO("normals turned by " << turned);
    INFO("residual " << session.residual());
    CHECK(session.residual() < 1e-11);
    double between = 0;
    for (int k = 0; k <= 100; ++k)
      between = std::max(
          between,
          shape.closest_point(line.evaluate(line.start() + (line.end() - line.start()) * k / 100))
              .distance);
    CHECK(between < 1e-9);
    const SkinQuality quality = measure(session.region());
    CHECK(quality.max_normal_jump_deg < 1e-4);
    CHECK(quality.max_line_residual < 1e-10);
  }
  session.set("raise", 0);
  session.solve_preview();
  CHECK(difference(session.dofs(), rest.dofs()) < 1e-9);
}

TEST_CASE("without its tangent planes held, the surface turns at the rib, with them it does not",
          "[sculpting][session]") {
  const auto turned = [](bool isolated) {
    SculptingSession session(patch_layout(0.2), {});
    const Surface rest = shape_of(session);
    if (isolated) session.add(Constraint{"plane", Constraint::LineNormal{"rib", {}}});
    session.add(Load{"f", Load::Uniform{{0, 0, 1}, {Area::Painted{{{{1.3, 0.6, 0.2}, 0.6, 1}}}}}},
                {slider("f", 40)});
    session.solve_to_equilibrium();
    const Surface shape = shape_of(session);
    double most = 0;
    for (const int v : vertices_of(session.layout(), "rib")) {
      const auto normal = [&](const Surface& s) {
        return Vec3(
            Vec3(s.dofs().row(3 * v + 1)).cross(Vec3(s.dofs().row(3 * v + 2))).normalized());
      };
      most = std::max(most, normal(shape).cross(normal(rest)).norm());
    }
    return most;
  };
  CHECK(turned(false) > 0.01);
  CHECK(turned(true) < 1e-9);
}

TEST_CASE("curves move by right-hand sides only, and the surface follows", "[sculpting][session]") {
  SculptingSession session(patch_layout(0.25), {});
  const Points rest = session.dofs();
  const HermiteCurve rib = session.line("rib");
  Points dofs = rib.dofs();
  for (int i = 1; i + 1 < rib.node_count(); ++i)
    dofs(rib.mesh().position_dof(i), 2) += 0.05 * std::sin(pi * i / (rib.node_count() - 1));
  const HermiteCurve moved(rib.mesh(), dofs);
  session.set_line("rib", moved);
  const Surface shape = shape_of(session);
  double worst = 0;
  for (int k = 0; k <= 50; ++k) {
    const Vec3 p = moved.evaluate(moved.start() + (moved.end() - moved.start()) * k / 50);
    worst = std::max(worst, shape.closest_point(p).distance);
  }
  CHECK(worst < 1e-9);
  CHECK(session.residual() < 1e-12);
  session.set_line("rib", rib);
  CHECK(difference(session.dofs(), rest) < 1e-12);
}

TEST_CASE("an inner curve is added and removed", "[sculpting][session]") {
  SculptingSession session(disc_layout(0.25), {});
  const Points rest = session.dofs();
  std::vector<Vec3> points;
  for (int i = 0; i <= 10; ++i)
    points.emplace_back(-0.5 + 0.1 * i, 0.1 * std::sin(0.5 * i), 0.1 * std::sin(0.3 * i));
  session.add(
      CharacterLine{"swage", curve_through_points("swage", points), CharacterLine::Role::Inner});
  CHECK(session.residual() < 1e-10);
  const Surface shape = shape_of(session);
  const HermiteCurve line = session.line("swage");
  double worst = 0;
  for (int k = 0; k <= 40; ++k)
    worst = std::max(
        worst,
        shape.closest_point(line.evaluate(line.start() + (line.end() - line.start()) * k / 40))
            .distance);
  CHECK(worst < 5e-3);
  session.add(LineOffset{"lift", "swage", Vec3(0, 0, 1), 0.2});
  session.set("lift", 0.1);
  session.solve_preview();
  CHECK(session.residual() < 1e-10);
  CHECK_THROWS_WITH(session.remove("swage"), Contains("'lift'"));
  session.remove("lift");
  session.remove("swage");
  CHECK(session.residual() < 1e-10);
}

namespace {

// Largest distance between the shapes of a session, at the centres of triangles inside the trim.
double moved(const SculptingSession& session, const Points& before) {
  const ModelLayout& layout = session.layout();
  const Surface now = shape_of(session),
                then(layout.mesh(), layout.element(), before, layout.trim());
  double largest = 0;
  for (int t = 0; t < layout.mesh()->triangle_count(); ++t) {
    const Location where{t, Vec3::Constant(1.0 / 3)};
    if (now.trim() && now.trim()->area_fraction(t) < 0.5) continue;
    largest = std::max(largest, (now.position(where) - then.position(where)).norm());
  }
  return largest;
}

// Display points: inside of faces, on their curves and at corners, in single precision.
std::vector<Vec3> display_points(SculptingSession& session) {
  std::vector<Vec3> points;
  const Frame& frame = session.frame();
  for (size_t i = 0; i + 2 < frame.points.size(); i += 3)
    points.emplace_back(frame.points[i], frame.points[i + 1], frame.points[i + 2]);
  return points;
}

// Boundaries of element edges and embedded ones, inner curves of both kinds, periodic domains.
std::vector<ModelLayout> layouts_with_curves() {
  return {patch_layout(0.4), disc_layout(0.4), tube_layout(0.6), door_layout(400)};
}

}  // namespace

TEST_CASE("points of the display hold the surface where it is, also on curves and at corners",
          "[sculpting][session]") {
  for (const ModelLayout& layout : layouts_with_curves()) {
    SculptingSession session(layout, {});
    session.add(Load{"p", Load::Pressure{}}, {slider("p", 1)});
    session.solve_to_equilibrium();
    const Points before = session.dofs();
    const std::vector<Vec3> points = display_points(session);
    for (size_t i = 0; i < points.size(); i += 3) {
      INFO(layout.lines().front().name << ", point " << i);
      session.add(pin("hold", points[i], points[i]));
      CHECK(session.residual() < 1e-10);
      CHECK(moved(session, before) < 2e-7 * layout.size());
      REQUIRE(session.undo());
    }
  }
}

TEST_CASE("a goal beside a curve is rounding below 1e-6 of the size, and a conflict above it",
          "[sculpting][session]") {
  Random random(4);
  for (const ModelLayout& layout : layouts_with_curves()) {
    SculptingSession session(layout, {});
    const Points before = session.dofs();
    const std::vector<Vec3> points = display_points(session);
    for (double d = 1e-12; d < 2e-3; d *= 10) {
      int conflicts = 0;
      for (size_t i = 0; i < points.size(); i += 5) {
        const Vec3 goal =
            points[i] + d * layout.size() * Vec3(random(), random(), random()).normalized();
        try {
          session.add(pin("hold", goal, goal));
          CHECK(session.residual() < 1e-10);
          // No slope is steep: the surface moves by not much more than the point.
          CHECK(moved(session, before) < (2e-7 + 10 * d) * layout.size());
          REQUIRE(session.undo());
        } catch (const ConflictError& e) {
          ++conflicts;
          CHECK(e.conflicts().front().amount > 1e-6 * layout.size());
          CHECK(e.conflicts().front().amount < (2e-7 + 1.1 * d) * layout.size());
        }
      }
      INFO(layout.lines().front().name << ", " << d);
      if (d < 5e-7) CHECK(conflicts == 0);
      if (d > 5e-6) CHECK(conflicts > 0);
    }
  }
}

TEST_CASE("a point can be held twice, and a normal where curves fix it", "[sculpting][session]") {
  SculptingSession session(patch_layout(0.3), {});
  const Points before = session.dofs();
  const std::vector<Vec3> points = display_points(session);
  const Frame frame = session.frame();
  for (size_t i = 0; i < points.size(); i += 7) {
    const Vec3 normal(frame.normals[3 * i], frame.normals[3 * i + 1], frame.normals[3 * i + 2]);
    session.add(pin("one", points[i], points[i]));
    session.add(pin("two", points[i] + Vec3(1e-7, -1e-7, 0), points[i]));
    session.add(Constraint{"normal", Constraint::Normal{points[i], normal}});
    CHECK(session.residual() < 1e-10);
    CHECK(moved(session, before) < 1e-6 * session.layout().size());
    for (int n = 0; n < 3; ++n) REQUIRE(session.undo());
  }
}
