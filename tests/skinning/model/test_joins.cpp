// SPDX-License-Identifier: MPL-2.0
// Smooth edges between faces on prescribed curves.
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/surfaces/model_joins.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_model_builder.h"

using namespace batten;
using namespace batten_test;

namespace {

struct Joined {
  std::vector<JoinPlan> plans;
  std::vector<SkinnedRegion> regions;
  std::vector<JoinQuality> angles;
  double worst = 0;
};

// `rests`: the rest shape consists of the sweeps of the faces, instead of being flat.
Joined join(const TestModelBuilder& p, const std::vector<JoinLine>& join_lines,
            bool rests = false) {
  Joined result;
  ModelLayout model = p.model(join_lines);
  if (rests) {
    const ModelLayout apart(model.metadata(), model.regions(), {});
    model.plan_joins(apart.minimize_energy({}, rest_dofs(apart)));
  }
  result.plans = model.join_plans();
  const Points dofs = model.minimize_energy({}, rests ? rest_dofs(model) : Points());
  for (int r = 0; r < model.region_count(); ++r) result.regions.push_back(model.skinned(r, dofs));
  std::vector<const SkinnedRegion*> all;
  for (const auto& r : result.regions) all.push_back(&r);
  for (const JoinLine& s : join_lines) {
    result.angles.push_back(measure_join(all, s));
    result.worst = std::max(result.worst, result.angles.back().max_deg);
  }
  return result;
}

// A curve at height f over a straight line of the plane.
template <class F>
std::shared_ptr<const InputCurve> over(const Vec2& a, const Vec2& b, const F& f) {
  return curve_from_formula(0, 1, [=](double t, int order) -> Vec3 {
    const auto at = [&](double s) {
      const Vec2 p = a + s * (b - a);
      return Vec3(p.x(), p.y(), f(p));
    };
    constexpr double step = 1e-4;
    if (order == 0) return at(t);
    if (order == 1) return (at(t + step) - at(t - step)) / (2 * step);
    return (at(t + step) - 2 * at(t) + at(t - step)) / (step * step);
  });
}

double wave(const Vec2& p) { return 0.2 * std::sin(2 * p.x() + 0.5) * std::cos(1.5 * p.y()); }

}  // namespace

TEST_CASE("octants of a sphere share tangent planes along their curve, with h³ between vertices",
          "[skinning][model]") {
  std::vector<double> worst;
  for (const double h : {0.4, 0.2, 0.1}) {
    const TestModelBuilder p = octants(h);
    const auto result = join(p, {p.join_line("zx", 0, 1)});
    REQUIRE(result.plans[0].rejection_reason.empty());
    CHECK_FALSE(result.plans[0].constant());
    for (const JoinEnd& end : result.plans[0].ends) {
      CHECK(end.gamma == Approx(1).epsilon(1e-9));
      CHECK(std::abs(end.delta) == Approx(2 / std::sqrt(3.0)).epsilon(1e-9));
      CHECK(end.plane_angle_deg < 1e-9);
      CHECK_FALSE(end.open);
    }
    worst.push_back(result.worst);
    for (const SkinnedRegion& r : result.regions) CHECK(measure(r).max_line_residual < 1e-12);
  }
  CHECK(worst[0] < 0.1);
  CHECK(std::log2(worst[0] / worst[1]) > 2.5);
  CHECK(std::log2(worst[1] / worst[2]) > 2.5);
}

TEST_CASE("faces that unfold into one plane are C1 across their curve to rounding",
          "[skinning][model]") {
  // Two squares of a bent, non-planar sheet: right angles, so that γ and δ are constant.
  TestModelBuilder p;
  p.options.edge_length = 0.2;
  const auto f = [](const Vec2& q) { return 0.2 * std::cos(std::numbers::pi * q.x()); };
  const auto flat = [&](const std::string& name, Vec2 a, Vec2 b) {
    p.add(prescribed_line(name, over(a, b, f), 2, 0.2));
  };
  flat("left", {0, 0}, {0, 1});
  flat("middle", {1, 0}, {1, 1});
  flat("right", {2, 0}, {2, 1});
  flat("bottom 1", {0, 0}, {1, 0});
  flat("bottom 2", {1, 0}, {2, 0});
  flat("top 1", {0, 1}, {1, 1});
  flat("top 2", {1, 1}, {2, 1});
  p.region({"bottom 1", "middle", "top 1", "left"});
  p.region({"bottom 2", "right", "top 2", "middle"});
  const auto result = join(p, {p.join_line("middle", 0, 1)});
  REQUIRE(result.plans[0].rejection_reason.empty());
  CHECK(result.plans[0].constant());
  CHECK(result.worst < 1e-5);
}

TEST_CASE("two joined faces are the same as one face with an inner curve", "[skinning][model]") {
  const double h = 0.1;
  TestModelBuilder p;
  p.options.edge_length = h;
  const auto line = [&](const std::string& name, Vec2 a, Vec2 b) {
    p.add(prescribed_line(name, over(a, b, wave), 2, h));
  };
  line("left", {0, 0}, {0, 1});
  line("middle", {1, 0}, {1, 1});
  line("right", {2, 0}, {2, 1});
  line("bottom 1", {0, 0}, {1, 0});
  line("bottom 2", {1, 0}, {2, 0});
  line("top 1", {0, 1}, {1, 1});
  line("top 2", {1, 1}, {2, 1});
  p.region({"bottom 1", "middle", "top 1", "left"});
  p.region({"bottom 2", "right", "top 2", "middle"});
  const auto joined = join(p, {p.join_line("middle", 0, 1)});
  REQUIRE(joined.plans[0].rejection_reason.empty());
  CHECK(joined.worst < 0.05);

  std::vector<CharacterLine> lines;
  for (const auto& [name, l] : p.lines) {
    CharacterLine copy = l;
    copy.prescribed.reset();
    copy.role = name == "middle" ? CharacterLine::Role::Inner : CharacterLine::Role::Outline;
    lines.push_back(copy);
  }
  SkinOptions options;
  options.edge_length = h;
  const RegionLayout whole("whole", lines, options);
  const SkinnedRegion surface = whole.region(ModelLayout(whole).minimize_energy({}));
  const auto far = [&](const SkinnedRegion& r) {
    double most = 0;
    for (int t = 0; t < r.surface.mesh().triangle_count(); t += 3)
      most = std::max(most, surface.surface.closest_point(r.surface.position({t})).distance);
    return most;
  };
  // With creases, it would deviate by some percent of the height of 0.2.
  for (const auto& r : joined.regions) CHECK(far(r) < 2e-3);
  const SkinnedRegion crease = p.layouts[0]->region(p.first[0]);
  CHECK(far(crease) > 4 * far(joined.regions[0]));
}

TEST_CASE("four faces around an intersection, three around a T-junction: smooth along all curves",
          "[skinning][model]") {
  const double h = 0.15;
  for (const bool tee : {false, true}) {
    TestModelBuilder p;
    p.options.edge_length = h;
    const auto line = [&](const std::string& name, Vec2 a, Vec2 b) {
      p.add(prescribed_line(name, over(a, b, wave), 2, h));
    };
    line("w1", {0, 0}, {0, 1});
    line("w2", {0, 1}, {0, 2});
    line("e1", {2, 0}, {2, 1});
    line("e2", {2, 1}, {2, 2});
    line("s1", {0, 0}, {0.9, 0});
    line("s2", {0.9, 0}, {2, 0});
    line("m1", {0, 1}, {0.9, 1});
    line("m2", {0.9, 1}, {2, 1});
    line("v1", {0.9, 0}, {0.9, 1});
    // The segments of one curve have the same slope where they meet.
    const auto same_slope = [&](const std::string& a, const std::string& b) {
      auto ga = std::make_shared<PrescribedCurve>(*p.lines.at(a).prescribed),
           gb = std::make_shared<PrescribedCurve>(*p.lines.at(b).prescribed);
      const int last = ga->curve.node_count() - 1;
      Points da = ga->curve.dofs(), db = gb->curve.dofs();
      const long ia = ga->curve.mesh().slope_in(last), ib = gb->curve.mesh().slope_out(0);
      const Vec3 mean = 2 * (da.row(ia) + db.row(ib)).transpose().normalized();
      da.row(ia) = mean;
      db.row(ib) = mean;
      ga->curve = HermiteCurve(ga->curve.mesh(), da);
      gb->curve = HermiteCurve(gb->curve.mesh(), db);
      p.lines.at(a).prescribed = ga;
      p.lines.at(b).prescribed = gb;
    };
    same_slope("m1", "m2");
    same_slope("w1", "w2");
    same_slope("e1", "e2");
    same_slope("s1", "s2");
    if (!tee) {
      line("n1", {0, 2}, {0.9, 2});
      line("n2", {0.9, 2}, {2, 2});
      line("v2", {0.9, 1}, {0.9, 2});
      same_slope("v1", "v2");
      same_slope("n1", "n2");
    } else {
      line("n", {0, 2}, {2, 2});
    }
    p.region({"s1", "v1", "m1", "w1"});
    p.region({"s2", "e1", "m2", "v1"});
    if (tee) {
      p.region({"m1", "m2", "e2", "n", "w2"});
    } else {
      p.region({"m1", "v2", "n1", "w2"});
      p.region({"m2", "e2", "n2", "v2"});
    }
    std::vector<JoinLine> join_lines = {p.join_line("v1", 0, 1), p.join_line("m1", 0, 2)};
    if (tee) {
      join_lines.push_back(p.join_line("m2", 1, 2));
    } else {
      join_lines.push_back(p.join_line("m2", 1, 3));
      join_lines.push_back(p.join_line("v2", 2, 3));
    }
    const auto result = join(p, join_lines);
    for (const JoinPlan& plan : result.plans) {
      INFO(plan.join_line.name << " " << plan.ends[0].plane_angle_deg << " "
                               << plan.ends[1].plane_angle_deg);
      CHECK(plan.rejection_reason.empty());
      CHECK_FALSE(plan.ends[0].open);
      CHECK_FALSE(plan.ends[1].open);
    }
    CHECK(result.worst < 0.1);
    if (tee) CHECK(!result.plans[1].ends[1].set[1].empty());
  }
}

TEST_CASE("a node without a tangent plane stays a crease, the curve away from it is smooth",
          "[skinning][model]") {
  // The far end of the shared curve: its neighbours deviate by 10 degrees to either side.
  const double h = 0.1, lift = std::tan(10 * std::numbers::pi / 180);
  TestModelBuilder p;
  p.options.edge_length = h;
  const auto line = [&](const std::string& name, Vec3 a, Vec3 b) {
    p.add(prescribed_line(name, curve_through_points(name, {a, b}), 2, h));
  };
  line("middle", {0, 0, 0}, {0, 1, 0});
  line("s1", {0, 0, 0}, {-1, 0, 0});
  line("s2", {0, 0, 0}, {1, 0, 0});
  line("n1", {0, 1, 0}, {-1, 1, lift});
  line("n2", {0, 1, 0}, {1, 1, lift});
  line("w", {-1, 0, 0}, {-1, 1, lift});
  line("e", {1, 0, 0}, {1, 1, lift});
  p.region({"-middle", "s1", "w", "n1"});
  p.region({"middle", "n2", "e", "s2"});
  const auto result = join(p, {p.join_line("middle", 0, 1)});
  const JoinPlan& plan = result.plans[0];
  REQUIRE(plan.rejection_reason.empty());
  CHECK_FALSE(plan.ends[0].open);
  CHECK(plan.ends[1].open);
  CHECK(plan.ends[1].plane_angle_deg == Approx(20).epsilon(1e-6));
  std::vector<const SkinnedRegion*> all{&result.regions[0], &result.regions[1]};
  const JoinQuality angle = measure_join(all, p.join_line("middle", 0, 1), {false, true});
  CHECK(angle.max_deg == Approx(20).epsilon(1e-6));
  CHECK(angle.max_inside_deg < 0.5);
}

TEST_CASE("faces that double back on each other are not joined", "[skinning][model]") {
  const double h = 0.2;
  TestModelBuilder p;
  p.options.edge_length = h;
  const auto line = [&](const std::string& name, Vec3 a, Vec3 b) {
    p.add(prescribed_line(name, curve_through_points(name, {a, b}), 2, h));
  };
  line("middle", {0, 0, 0}, {0, 1, 0});
  line("s1", {0, 0, 0}, {1, 0, 0.2});
  line("s2", {0, 0, 0}, {1, 0, -0.2});
  line("n1", {0, 1, 0}, {1, 1, 0.2});
  line("n2", {0, 1, 0}, {1, 1, -0.2});
  line("e1", {1, 0, 0.2}, {1, 1, 0.2});
  line("e2", {1, 0, -0.2}, {1, 1, -0.2});
  p.region({"middle", "n1", "e1", "s1"});
  p.region({"-middle", "n2", "e2", "s2"});
  const auto plans = p.plan({p.join_line("middle", 0, 1)});
  CHECK_THAT(plans[0].rejection_reason, Catch::Matchers::Contains("faces differ by 157"));
}

namespace {

/// An arch over the shared curve, on the wave.
Vec3 gluing_correction(double t) {
  const Vec2 q(t, 0.5 * std::sin(std::numbers::pi * t));
  return Vec3(q.x(), q.y(), wave(q));
}
std::shared_ptr<const InputCurve> bow_on_wave() {
  return curve_from_formula(0, 1, [](double t, int order) -> Vec3 {
    constexpr double d = 1e-4;
    if (order == 0) return gluing_correction(t);
    if (order == 1) return (gluing_correction(t + d) - gluing_correction(t - d)) / (2 * d);
    return (gluing_correction(t + d) - 2 * gluing_correction(t) + gluing_correction(t - d)) /
           (d * d);
  });
}

}  // namespace

TEST_CASE("a curve that one face has embedded is smooth on average", "[skinning][model]") {
  std::vector<double> before, after, rested;
  for (const double h : {0.2, 0.1, 0.05}) {
    TestModelBuilder p;
    p.options.edge_length = h;
    const auto line = [&](const std::string& name, Vec2 a, Vec2 b) {
      p.add(prescribed_line(name, over(a, b, wave), 2, h));
    };
    line("shared", {0, 0}, {1, 0});
    line("w", {0, 0}, {0, -1});
    line("s", {0, -1}, {1, -1});
    line("e", {1, -1}, {1, 0});
    // With only two corners, a face has no polygonal domain.
    p.add(prescribed_line("bow", bow_on_wave(), 2, h));
    // Along the shared curve, and against it.
    p.region(h == 0.1 ? std::vector<std::string>{"bow", "shared"}
                      : std::vector<std::string>{"shared", "bow"});
    p.region({"w", "s", "e", "shared"});
    REQUIRE(p.layouts[0]->domain() != SkinOptions::Domain::Polygon);
    const JoinLine join_line = p.join_line("shared", 0, 1);
    REQUIRE((join_line.sides[0].embedded && !join_line.sides[1].embedded));
    const auto result = join(p, {join_line});
    INFO(result.plans[0].rejection_reason);
    REQUIRE(result.plans[0].rejection_reason.empty());
    const SkinnedRegion a = p.layouts[0]->region(p.first[0]), b = p.layouts[1]->region(p.first[1]);
    before.push_back(measure_join({&a, &b}, join_line).mean_deg);
    after.push_back(result.angles[0].mean_deg);
    rested.push_back(join(p, {join_line}, true).angles[0].mean_deg);
  }
  CAPTURE(before, after, rested);
  for (size_t i = 0; i < after.size(); ++i) {
    CHECK(after[i] < before[i] / 30);
    // The rest shapes meet at 60 degrees, without stress at any edge.
    CHECK(rested[i] < 60.0 / 20);
  }
  CHECK(after[2] < 0.5 * after[0]);
}

namespace {

/// Two faces at a curve: one with two corners, where the curve is embedded, and a square.
void add_bow_and_square(TestModelBuilder& p, const std::shared_ptr<const InputCurve>& arch) {
  const auto line = [&](const std::string& name, Vec2 a, Vec2 b) {
    p.add(prescribed_line(name, over(a, b, wave), 2, 0.2));
  };
  line("shared", {0, 0}, {1, 0});
  line("w", {0, 0}, {0, -1});
  line("s", {0, -1}, {1, -1});
  line("e", {1, -1}, {1, 0});
  p.add(prescribed_line("bow", arch, 2, 0.2));
  p.region({"shared", "bow"});
  p.region({"w", "s", "e", "shared"});
}

}  // namespace

TEST_CASE("an embedded curve ends as a crease if only the edge beside its end keeps an angle",
          "[skinning][model]") {
  TestModelBuilder p;
  p.options.edge_length = 0.2;
  add_bow_and_square(p, bow_on_wave());
  // Surfaces with a flat rest shape meet at larger angles than those with sweeps as rest shapes.
  const ModelLayout resting = p.model({p.join_line("shared", 0, 1)});
  ModelMetadata metadata = resting.metadata();
  metadata.rest = false;
  const ModelLayout coarse(metadata, resting.regions(), resting.join_plans());
  const SurfaceStiffness material;
  const Points before = coarse.minimize_energy(material);
  int opened = 0;
  for (const double limit : {0.3, 0.1, 0.03, 0.01, 0.003}) {
    CAPTURE(limit);
    const JoinedModel made = refine_embedded_joins(
        {std::make_shared<const ModelLayout>(coarse), before}, material, limit);
    const JoinPlan& plan = made.layout->join_plans()[0];
    if (plan.rejected()) continue;
    const SkinnedRegion a = made.layout->skinned(0, made.dofs),
                        b = made.layout->skinned(1, made.dofs);
    const auto angle = [&](bool start, bool end) {
      return measure_join({&a, &b}, plan.join_line, {start, end}).max_inside_deg;
    };
    const bool start = plan.ends[0].open, end = plan.ends[1].open;
    // The exact number of ends.
    CHECK((angle(start, end) <= limit || (!start && !end && angle(true, true) > limit)));
    if (start) CHECK(angle(false, end) > limit);
    if (end) CHECK(angle(start, false) > limit);
    if (!start && !end) continue;
    ++opened;
    CHECK(std::max(plan.ends[0].plane_angle_deg, plan.ends[1].plane_angle_deg) >=
          angle(false, false));
    ModelLayout again = *made.layout;
    again.plan_joins(made.dofs);
    for (size_t e = 0; e < 2; ++e) {
      CHECK(again.join_plans()[0].ends[e].open == plan.ends[e].open);
      CHECK(again.join_plans()[0].ends[e].creased == plan.ends[e].creased);
    }
  }
  CHECK(opened > 0);
}

TEST_CASE(
    "refining the joins of one group leaves the model at least energy, and others as they were",
    "[skinning][model]") {
  TestModelBuilder p;
  p.options.edge_length = 0.2;
  const auto line = [&](const std::string& name, Vec2 a, Vec2 b) {
    p.add(prescribed_line(name, over(a, b, wave), 2, 0.2));
  };
  add_bow_and_square(
      p, curve_through_points(
             "bow", {gluing_correction(0), gluing_correction(0.2), gluing_correction(0.4),
                     gluing_correction(0.6), gluing_correction(0.8), gluing_correction(1)}));
  // Two more faces share mesh-aligned edges, far away.
  line("middle", {4, 0}, {4, 1});
  line("s1", {3, 0}, {4, 0});
  line("n1", {3, 1}, {4, 1});
  line("w1", {3, 0}, {3, 1});
  line("s2", {4, 0}, {5, 0});
  line("n2", {4, 1}, {5, 1});
  line("e2", {5, 0}, {5, 1});
  p.region({"s1", "middle", "n1", "w1"});
  p.region({"s2", "e2", "n2", "middle"});
  const ModelLayout coarse = p.model({p.join_line("shared", 0, 1), p.join_line("middle", 2, 3)});
  for (const JoinPlan& plan : coarse.join_plans()) {
    INFO(plan.rejection_reason);
    REQUIRE(!plan.rejected());
  }
  const auto groups = join_groups(coarse.regions(), coarse.join_plans());
  REQUIRE(groups.size() == 2);
  CHECK(groups[0].regions == std::vector<int>{0, 1});
  CHECK(groups[1].regions == std::vector<int>{2, 3});
  CHECK(groups[1].plans[0].join_line.sides[1].region == 1);
  CHECK(is_same_problem(groups[1], groups[1]));
  CHECK(!is_same_problem(groups[0], groups[1]));

  const SurfaceStiffness material;
  const Points before = coarse.minimize_energy(material, rest_dofs(coarse));
  const JoinedModel refined =
      refine_embedded_joins({std::make_shared<const ModelLayout>(coarse), before}, material, 1e-6);
  REQUIRE(refined.layout->mesh()->triangle_count() > coarse.mesh()->triangle_count());
  const Points whole = refined.layout->minimize_energy(material, rest_dofs(*refined.layout));
  CHECK((refined.dofs - whole).cwiseAbs().maxCoeff() < 1e-8);
  for (const int r : {2, 3}) {
    CHECK(refined.layout->regions()[r] == coarse.regions()[r]);
    CHECK(refined.layout->region_dofs(r, refined.dofs) == coarse.region_dofs(r, before));
  }
}
