// SPDX-License-Identifier: MPL-2.0
// Curves become edges between nodes, whatever their order, direction and unit.
#include "batten/skinning/network/curve_network.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/network/contacts.h"
#include "batten/skinning/network/sampled_curve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using batten_test::error_message;
using Kind = NetworkDiagnostic::Kind;

namespace {

CharacterLine straight(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, bezier_curve(a, (2 * a + b) / 3, (a + 2 * b) / 3, b)};
}

CharacterLine through(const std::string& name, const std::vector<Vec3>& points,
                      double corner_angle = 20) {
  return {name, curve_through_points(name, points, corner_angle)};
}

CharacterLine circle(const std::string& name, const Vec3& centre, double r) {
  return {name, curve_from_formula(0, 2 * std::numbers::pi, [=](double t, int order) -> Vec3 {
            const double a = t + order * std::numbers::pi / 2;
            const Vec3 p = r * Vec3(std::cos(a), std::sin(a), 0);
            return order == 0 ? Vec3(centre + p) : p;
          })};
}

// A bowl over the square from -0.1 to 1.1: m curves along x, n along y, which intersect.
std::vector<CharacterLine> bowl(int m, int n) {
  std::vector<CharacterLine> lines;
  for (int d = 0; d < 2; ++d)
    for (int i = 0; i < (d ? n : m); ++i) {
      const double at = static_cast<double>(i) / ((d ? n : m) - 1);
      lines.push_back({(d ? "y" : "x") + std::to_string(i),
                       curve_from_formula(-0.1, 1.1, [=](double t, int order) -> Vec3 {
                         const Vec3 p = order == 0   ? Vec3(t, at, t * t + 0.5 * at * at)
                                        : order == 1 ? Vec3(1, 0, 2 * t)
                                                     : Vec3(0, 0, 2);
                         return d ? (order == 0 ? Vec3(at, t, at * at + 0.5 * t * t)
                                                : Vec3(p[1], p[0], 0.5 * p[2]))
                                  : p;
                       })});
    }
  return lines;
}

/// Another curve with mapped points, forwards or reversed; mapped linearly.
class Mapped final : public InputCurve {
 public:
  Mapped(std::shared_ptr<const InputCurve> curve, double scale, const Vec3& move, bool back)
      : curve_(std::move(curve)), scale_(scale), move_(move), back_(back) {}
  double start() const override { return back_ ? -curve_->end() : curve_->start(); }
  double end() const override { return back_ ? -curve_->start() : curve_->end(); }
  Vec3 evaluate(double t, int order) const override {
    const Vec3 p = scale_ * curve_->evaluate(back_ ? -t : t, order);
    return order == 0 ? Vec3(p + move_) : back_ && order == 1 ? Vec3(-p) : p;
  }
  std::vector<double> breaks() const override {
    auto all = curve_->breaks();
    if (back_) {
      std::reverse(all.begin(), all.end());
      for (double& b : all) b = -b;
    }
    return all;
  }
  bool piecewise_cubic() const override { return curve_->piecewise_cubic(); }

 private:
  std::shared_ptr<const InputCurve> curve_;
  double scale_;
  Vec3 move_;
  bool back_;
};

std::vector<CharacterLine> mapped(std::vector<CharacterLine> lines, double scale,
                                  const Vec3& move = Vec3::Zero()) {
  for (auto& line : lines) line.curve = std::make_shared<Mapped>(line.curve, scale, move, false);
  return lines;
}

// Edges by the names of their curves, nodes and partners: everything but non-integer numbers.
std::string combinatorics(const CurveNetwork& network) {
  std::string text;
  for (const auto& edge : network.edges()) {
    text += network.lines()[edge.line].name;
    for (const int e : {0, 1})
      text += " " + std::to_string(edge.nodes[e]) + " on " +
              std::to_string(edge.continuation[e].edge) + "." +
              std::to_string(edge.continuation[e].end);
    text += " segments " + std::to_string(edge.curve.segment_count()) + "\n";
  }
  return text;
}

// Largest difference of dofs and positions over the size, or infinity.
double difference(const CurveNetwork& a, const CurveNetwork& b, double b_over_a = 1) {
  if (combinatorics(a) != combinatorics(b)) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (size_t i = 0; i < a.edges().size(); ++i)
    most = std::max(
        most,
        (a.edges()[i].curve.dofs() - b.edges()[i].curve.dofs() / b_over_a).cwiseAbs().maxCoeff());
  for (size_t i = 0; i < a.nodes().size(); ++i)
    most = std::max(most, (a.nodes()[i].position - b.nodes()[i].position / b_over_a).norm());
  return most / a.size();
}

int count(const CurveNetwork& network, Kind kind) {
  return static_cast<int>(std::count_if(network.diagnostics().begin(), network.diagnostics().end(),
                                        [&](const auto& f) { return f.kind == kind; }));
}

const NetworkDiagnostic& single_diagnostic(const CurveNetwork& network, Kind kind) {
  const auto it = std::find_if(network.diagnostics().begin(), network.diagnostics().end(),
                               [&](const auto& f) { return f.kind == kind; });
  REQUIRE(it != network.diagnostics().end());
  return *it;
}

bool names(const NetworkDiagnostic& finding, const std::string& line) {
  return std::find(finding.lines.begin(), finding.lines.end(), line) != finding.lines.end();
}

// Invariants of every network.
void check_invariants(const CurveNetwork& network) {
  const double size = network.size();
  std::set<std::pair<int, bool>> ends;
  for (int n = 0; n < static_cast<int>(network.nodes().size()); ++n) {
    CHECK_FALSE(network.nodes()[n].ends.empty());
    for (const EdgeEnd& e : network.nodes()[n].ends) {
      CHECK(network.edges()[e.edge].nodes[e.end] == n);
      CHECK(ends.insert({e.edge, e.end}).second);
    }
  }
  CHECK(ends.size() == 2 * network.edges().size());
  for (int i = 0; i < static_cast<int>(network.edges().size()); ++i) {
    const NetworkEdge& edge = network.edges()[i];
    const HermiteCurve& curve = edge.curve;
    const int last = curve.node_count() - 1;
    CHECK(curve.dofs().allFinite());
    CHECK(curve.position(0) == network.nodes()[edge.nodes[0]].position);
    CHECK(curve.position(last) == network.nodes()[edge.nodes[1]].position);
    for (const double u : curve.parameters()) {
      const double steps = u * (1 << 30);
      CHECK(steps == std::round(steps));
    }
    CHECK(curve.end() == Approx(edge.length / size).margin(1e-9));
    for (int k = 0; k <= last; ++k) CHECK(curve.slope_out(k).norm() == Approx(size).epsilon(1e-12));
    const auto slope = [&](const EdgeEnd& e) {
      const HermiteCurve& c = network.edges()[e.edge].curve;
      return e.end ? Vec3(-c.slope_in(c.node_count() - 1)) : c.slope_out(0);
    };
    for (const bool end : {false, true})
      if (const EdgeEnd q = edge.continuation[end]; q.edge >= 0) {
        CHECK(network.edges()[q.edge].continuation[q.end] == EdgeEnd{i, end});
        CHECK(network.edges()[q.edge].nodes[q.end] == edge.nodes[end]);
        CHECK(slope({i, end}) == -slope(q));
      }
  }
}

}  // namespace

TEST_CASE("m by n curves that cross have mn nodes where they do, and ends", "[skinning][network]") {
  for (const auto& [m, n] : {std::pair(2, 2), {3, 5}, {7, 4}}) {
    const CurveNetwork network(bowl(m, n));
    CHECK(network.nodes().size() == static_cast<size_t>(m * n + 2 * (m + n)));
    CHECK(network.edges().size() == static_cast<size_t>(m * (n + 1) + n * (m + 1)));
    CHECK(count(network, Kind::Crossing) == m * n);
    CHECK(count(network, Kind::Dangling) == 2 * (m + n));
    CHECK(network.diagnostics().size() == static_cast<size_t>(m * n + 2 * (m + n)));
    check_invariants(network);
    // Intersections are exactly on both curves, so edges stay within the fit of the input.
    for (const auto& node : network.nodes()) {
      const Vec3 p = node.position;
      CHECK(p.z() == Approx(p.x() * p.x() + 0.5 * p.y() * p.y()).margin(1e-12));
      if (node.ends.size() == 4)
        for (const EdgeEnd& e : node.ends)
          CHECK(network.edges()[e.edge].continuation[e.end].edge >= 0);
    }
    for (const auto& edge : network.edges()) CHECK(edge.deviation <= 1e-4 * network.size());
  }
}

TEST_CASE("An edge lies on its curve and its parameter is arc length over size",
          "[skinning][network]") {
  const CurveNetwork network({circle("c", {1, 2, 3}, 1)});
  REQUIRE(network.edges().size() == 1);
  CHECK(network.nodes().size() == 1);
  CHECK(network.diagnostics().empty());
  const NetworkEdge& edge = network.edges()[0];
  CHECK(edge.length == Approx(2 * std::numbers::pi).epsilon(1e-12));
  CHECK(edge.continuation[0] == EdgeEnd{0, true});
  CHECK(edge.name == "c");
  double off = 0, uneven = 0;
  for (int k = 0; k <= 1000; ++k) {
    const double u = edge.curve.end() * k / 1000;
    off = std::max(off, std::abs((edge.curve.evaluate(u) - Vec3(1, 2, 3)).norm() - 1));
    uneven = std::max(uneven, std::abs(edge.curve.evaluate(u, 1).norm() / network.size() - 1));
  }
  CHECK(off <= edge.deviation + 1e-6 * network.size());
  CHECK(edge.deviation <= 1e-4 * network.size());
  CHECK(uneven < 5e-3);
  check_invariants(network);
  // Wherever the input seam of a closed curve is, the network's seam is at the same point.
  const CurveNetwork turned(
      {{"c", curve_from_formula(1, 1 + 2 * std::numbers::pi, [](double t, int order) -> Vec3 {
          const double a = t + order * std::numbers::pi / 2;
          return (order == 0 ? Vec3(1, 2, 3) : Vec3(0, 0, 0)) + Vec3(std::cos(a), std::sin(a), 0);
        })}});
  CHECK((turned.nodes()[0].position - network.nodes()[0].position).norm() < 1e-12);
}

TEST_CASE("The fit converges with the fourth power of its segments", "[skinning][network]") {
  const auto error = [](double fit) {
    NetworkOptions options;
    options.fit_tolerance = fit;
    const CurveNetwork network({circle("c", Vec3::Zero(), 1)}, options);
    return std::pair(network.edges()[0].curve.segment_count(), network.edges()[0].deviation);
  };
  const auto [n1, e1] = error(1e-3);
  const auto [n2, e2] = error(1e-6);
  CHECK(n2 > n1);
  CHECK(std::log(e1 / e2) / std::log(static_cast<double>(n2) / n1) == Approx(4).margin(0.2));
}

TEST_CASE("The order of curves changes no bit, their direction next to nothing",
          "[skinning][network]") {
  auto lines = bowl(4, 5);
  lines.push_back(through("wave", {{0, 0, 0}, {0.3, 0.4, 0.2}, {0.5, 0.2, 0.6}, {1, 1, 1.5}}));
  lines.push_back(circle("ring", {0.5, 0.5, 0.4}, 0.3));
  lines.push_back(through(
      "eight", {{0, 0, 2}, {1, 1, 2}, {2, 0, 2}, {2, 1, 2}, {1, 0, 2}, {0, 1, 2}, {0, 0, 2}}));
  const CurveNetwork network(lines);
  check_invariants(network);
  std::mt19937 random(3);
  for (int round = 0; round < 10; ++round) {
    std::shuffle(lines.begin(), lines.end(), random);
    const CurveNetwork shuffled(lines);
    CHECK(difference(network, shuffled) == 0);
    REQUIRE(network.diagnostics().size() == shuffled.diagnostics().size());
    for (size_t i = 0; i < network.diagnostics().size(); ++i)
      CHECK(network.diagnostics()[i].text == shuffled.diagnostics()[i].text);
    for (size_t i = 0; i < network.edges().size(); ++i)
      CHECK(network.edges()[i].name == shuffled.edges()[i].name);
    auto turned = lines;
    for (auto& line : turned)
      if (random() % 2) line.curve = std::make_shared<Mapped>(line.curve, 1, Vec3::Zero(), true);
    CHECK(difference(network, CurveNetwork(turned)) < 1e-12);
  }
  // Reversed as points, and as control points.
  std::vector<Vec3> points = {{0, 0, 0}, {1, 0.2, 0.1}, {1.7, 1, 0.4}, {2, 2.2, 0}};
  const Vec3 a(0, 1, 0.2), b(1, 0.3, 0.4), c(1.2, 1.3, -0.4), d(2, 1, 0.3);
  const CurveNetwork forth({through("p", points), {"b", bezier_curve(a, b, c, d)}});
  std::reverse(points.begin(), points.end());
  const CurveNetwork back({{"b", bezier_curve(d, c, b, a)}, through("p", points)});
  CHECK(difference(forth, back) < 1e-12);
  CHECK(forth.edges()[0].reversed != back.edges()[0].reversed);
}

TEST_CASE("Millimetres and metres make the same parameters, far from the origin the same arcs",
          "[skinning][network]") {
  auto lines = bowl(3, 4);
  lines.push_back(circle("ring", {0.4, 0.5, 0.4}, 0.3));
  lines.push_back(straight("end", {0.5, 0.5, 2}, {0.3, 0.1, 0.0950001}));
  const CurveNetwork metres(lines), millimetres(mapped(lines, 1000));
  CHECK(difference(metres, millimetres, 1000) < 1e-12);
  for (size_t i = 0; i < metres.edges().size(); ++i)
    CHECK(metres.edges()[i].curve.parameters() == millimetres.edges()[i].curve.parameters());
  const CurveNetwork far(mapped(lines, 1, Vec3(3e6, -5e6, 1e6)));
  CHECK(combinatorics(far) == combinatorics(metres));
}

TEST_CASE("The size includes the curve between a few evenly spaced parameters",
          "[skinning][network]") {
  // A straight curve with a narrow peak, in one smooth segment, twice as high as it is long.
  const auto peak = [](double t, int order) -> Vec3 {
    const double x = (t - 0.4) / 0.03, e = 2 * std::exp(-x * x);
    if (order == 0) return {t, 0, e};
    if (order == 1) return {1, 0, -2 * x / 0.03 * e};
    return {0, 0, (4 * x * x - 2) / (0.03 * 0.03) * e};
  };
  const CurveNetwork network(
      {{"peak", curve_from_formula(0, 1, peak)}, straight("across", {0.3, 0, 1}, {0.5, 0, 1})}, {});
  CHECK(network.size() == Approx(std::hypot(1, 2)).epsilon(1e-3));
  int crossings = 0;
  for (const auto& node : network.nodes()) crossings += node.ends.size() == 4;
  CHECK(crossings == 2);
}

TEST_CASE("Ends within the tolerance become one node, beyond it they are named",
          "[skinning][network]") {
  const auto lines_with = [](double gap) {
    // Three sides of a triangle; the gap at the corner (1, 0, 0).
    return std::vector{straight("a", {0, 0, 0}, {1 - gap, 0, 0}),
                       straight("b", {1, 0, 0}, {1, 1, 0}), straight("c", {1, 1, 0}, {0, 0, 0})};
  };
  NetworkOptions options;
  options.tolerance = 0.01;
  const CurveNetwork exact(lines_with(0), options);
  CHECK(exact.nodes().size() == 3);
  CHECK(exact.diagnostics().empty());
  for (const double gap : {1e-7, 0.001, 0.009}) {
    const CurveNetwork network(lines_with(gap), options);
    CHECK(combinatorics(network) == combinatorics(exact));
    CHECK(count(network, Kind::EndsJoined) == 1);
    CHECK(single_diagnostic(network, Kind::EndsJoined).distance == Approx(gap).epsilon(1e-6));
    CHECK(single_diagnostic(network, Kind::EndsJoined).repaired);
    for (const auto& edge : network.edges()) CHECK(edge.deviation <= 0.5 * gap + 1e-12);
    check_invariants(network);
  }
  for (const double gap : {0.011, 0.03, 0.049}) {
    const CurveNetwork network(lines_with(gap), options);
    CHECK(network.nodes().size() == 4);
    const auto& miss = single_diagnostic(network, Kind::NearMiss);
    CHECK((names(miss, "a") && names(miss, "b")));
    CHECK_FALSE(miss.repaired);
    CHECK(miss.distance == Approx(gap).epsilon(1e-9));
    CHECK(count(network, Kind::NearMiss) == 1);
    CHECK(count(network, Kind::Dangling) == 2);
  }
  CHECK(count(CurveNetwork(lines_with(0.1), options), Kind::NearMiss) == 0);
}

TEST_CASE("A node does not grow along a chain of ends", "[skinning][network]") {
  // Ends in a row at distances of 0.8 tolerances: three of them are within the tolerance of their
  // mean.
  NetworkOptions options;
  options.tolerance = 0.01;
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 6; ++i)
    lines.push_back(
        straight("l" + std::to_string(i), {0.008 * i, 0, 0}, {0.4 * i - 1, 0.01 * i * i, 1}));
  const CurveNetwork network(lines, options);
  CHECK(network.nodes().size() == 8);
  CHECK(count(network, Kind::EndsJoined) == 2);
  REQUIRE(count(network, Kind::NearMiss) == 1);
  CHECK((names(single_diagnostic(network, Kind::NearMiss), "l2") &&
         names(single_diagnostic(network, Kind::NearMiss), "l3")));
  for (const auto& edge : network.edges()) CHECK(edge.deviation <= options.tolerance * (1 + 1e-9));
  check_invariants(network);

  // Where many curves intersect within a few tolerances, the choice of nodes depends on an order,
  // which is not that of the input.
  std::vector<CharacterLine> tangle, backwards;
  for (int i = 0; i < 6; ++i) {
    const Vec3 a(0.008 * i, 0, 0), b(std::cos(0.3 + 0.5 * i), std::sin(0.3 + 0.5 * i), 0.1 * i);
    tangle.push_back(straight("l" + std::to_string(i), a, b));
    backwards.insert(backwards.begin(), straight("l" + std::to_string(i), b, a));
  }
  const CurveNetwork tangled(tangle, options);
  check_invariants(tangled);
  CHECK(count(tangled, Kind::NearMiss) > 0);
  CHECK(difference(tangled, CurveNetwork(backwards, options)) < 1e-12);
}

TEST_CASE("Ends that a third one joins do not miss each other", "[skinning][network]") {
  NetworkOptions options;
  options.tolerance = 0.01;
  const CurveNetwork network(
      {straight("a", {-0.009, 0, 0}, {-1, 0, 0.1}), straight("b", {0, 0, 0}, {0, 1, 0}),
       straight("c", {0.009, 0, 0}, {1, 0, 0.2})},
      options);
  CHECK(network.nodes().size() == 4);
  CHECK(count(network, Kind::NearMiss) == 0);
  REQUIRE(count(network, Kind::EndsJoined) == 1);
  CHECK(single_diagnostic(network, Kind::EndsJoined).distance == Approx(0.018));
  check_invariants(network);
}

TEST_CASE("An end on the middle of a curve splits it there", "[skinning][network]") {
  NetworkOptions options;
  options.tolerance = 0.01;
  for (const double short_by : {0.0, 0.006, -0.006, 0.02}) {
    const CurveNetwork network(
        {straight("bar", {0, 0, 0}, {1, 0, 0}), straight("post", {0.4, short_by, 0}, {0.4, 1, 0})},
        options);
    if (short_by == 0.02) {
      CHECK(network.edges().size() == 2);
      CHECK(names(single_diagnostic(network, Kind::NearMiss), "post"));
      CHECK(single_diagnostic(network, Kind::NearMiss).distance == Approx(0.02));
      CHECK(count(network, Kind::Disconnected) == 1);
      continue;
    }
    REQUIRE(network.edges().size() == 3);
    CHECK(network.nodes().size() == 4);
    CHECK(count(network, Kind::EndOnLine) == 1);
    CHECK(single_diagnostic(network, Kind::EndOnLine).distance ==
          Approx(std::abs(short_by)).margin(1e-12));
    CHECK(count(network, Kind::Crossing) == 0);
    // The point of the curve itself; the curve continues straight, the post has no partner.
    const auto bar = network.edges_of("bar");
    REQUIRE(bar.size() == 2);
    CHECK(network.edges()[bar[0]].name == "bar.1");
    CHECK(network.edges_of("bar.2") == std::vector{bar[1]});
    for (const auto& node : network.nodes())
      if (node.ends.size() == 3) CHECK((node.position - Vec3(0.4, 0, 0)).norm() < 1e-12);
    const NetworkEdge& post = network.edges()[network.edges_of("post")[0]];
    CHECK(post.continuation[0].edge + post.continuation[1].edge == -2);
    CHECK(network.edges()[bar[0]].continuation[0].edge +
              network.edges()[bar[0]].continuation[1].edge ==
          bar[1] - 1);
    check_invariants(network);
  }
}

TEST_CASE("Names number the edges of a curve in its given direction", "[skinning][network]") {
  std::vector<CharacterLine> lines = {straight("l", {3, 0, 0}, {0, 0, 0})};
  for (const double x : {0.5, 1.2, 2.0})
    lines.push_back(straight("c" + format_number(x), {x, -1, 0}, {x, 1, 0}));
  const CurveNetwork network(lines);
  double before = 3;
  for (const int i : network.edges_of("l")) {
    const auto& edge = network.edges()[i];
    const double x = network.nodes()[edge.nodes[!edge.reversed]].position.x();
    CHECK(x < before);
    before = x;
  }
  CHECK(network.edges_of("l").size() == 4);
  CHECK(network.direction({network.edges_of("l.1")[0], false}).cross(Vec3::UnitX()).norm() < 1e-12);
  CHECK(error_message([&] { network.edges_of("c0.6"); }).find("c0.5") != std::string::npos);
}

TEST_CASE("Two curves may cross several times, and one itself", "[skinning][network]") {
  const auto wave = curve_from_formula(0, 4 * std::numbers::pi, [](double t, int order) -> Vec3 {
    return order == 0   ? Vec3(t, std::sin(t), 0)
           : order == 1 ? Vec3(1, std::cos(t), 0)
                        : Vec3(0, -std::sin(t), 0);
  });
  const CurveNetwork network({{"wave", wave}, straight("axis", {-1, 0, 0}, {13.5, 0, 0})});
  // At 0 and 4π the wave ends on the axis, between them it intersects it at π, 2π, 3π.
  CHECK(count(network, Kind::Crossing) == 3);
  CHECK(count(network, Kind::EndOnLine) == 2);
  CHECK(network.edges_of("wave").size() == 4);
  CHECK(network.edges_of("axis").size() == 6);
  check_invariants(network);

  const CurveNetwork bow({{"bow", bezier_curve({0, 0, 0}, {3, 2, 0}, {-2, 2, 0}, {1, 0, 0})}});
  CHECK(count(bow, Kind::SelfCrossing) == 1);
  REQUIRE(bow.edges().size() == 3);
  CHECK(bow.nodes().size() == 3);
  for (const auto& node : bow.nodes())
    if (node.ends.size() == 4) CHECK(node.position.x() == Approx(0.5).epsilon(1e-12));
  check_invariants(bow);
}

TEST_CASE("Curves are split at corners, and continue within the angle", "[skinning][network]") {
  const CurveNetwork square(
      {through("square", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}})});
  CHECK(square.edges().size() == 4);
  CHECK(square.nodes().size() == 4);
  CHECK(square.diagnostics().empty());
  for (const auto& edge : square.edges())
    CHECK(edge.continuation[0].edge + edge.continuation[1].edge == -2);

  for (const double degrees : {0.0, 4.0, 19.0, 21.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const CurveNetwork network({straight("a", {-1, 0, 0}, {0, 0, 0}),
                                straight("b", {0, 0, 0}, {std::cos(angle), std::sin(angle), 0})});
    REQUIRE(network.edges().size() == 2);
    const bool joined = network.edges()[0].continuation[0].edge >= 0 ||
                        network.edges()[0].continuation[1].edge >= 0;
    CHECK(joined == (degrees < 20));
    for (const auto& edge : network.edges()) CHECK(edge.deviation <= 0.55 * network.tolerance());
    check_invariants(network);
  }
}

TEST_CASE("A closed curve that others meet is split at them only", "[skinning][network]") {
  const CurveNetwork network({circle("c", Vec3::Zero(), 1), straight("l", {-1, 0, 0}, {0, 1, 0}),
                              straight("far", {3, 0, 0}, {4, 0, 0})});
  CHECK(network.edges_of("c").size() == 2);
  CHECK(network.nodes().size() == 4);
  REQUIRE(count(network, Kind::Disconnected) == 1);
  CHECK(single_diagnostic(network, Kind::Disconnected).lines == std::vector<std::string>{"far"});
  // It continues at both nodes, also across the seam.
  for (const int i : network.edges_of("c"))
    for (const int e : {0, 1}) CHECK(network.edges()[i].continuation[e].edge >= 0);
  check_invariants(network);

  const CurveNetwork one({circle("c", Vec3::Zero(), 1), straight("l", {1, 0, 0}, {1, 0, 2})});
  CHECK(one.edges().size() == 2);
  CHECK(one.nodes().size() == 2);
  check_invariants(one);
}

TEST_CASE("Curves that run along others are kept once, and named", "[skinning][network]") {
  const auto base = bowl(3, 3);
  const CurveNetwork single(base);
  auto doubled = base;
  doubled.push_back(base[1]);
  doubled.back().name = "x1 again";
  // And a reversed one with a small offset.
  doubled.push_back(
      {"y0 again", std::make_shared<Mapped>(base[3].curve, 1, Vec3(2e-4, 0, 1e-4), true)});
  const CurveNetwork network(doubled);
  CHECK(network.nodes().size() == single.nodes().size());
  CHECK(network.edges().size() == single.edges().size());
  REQUIRE(count(network, Kind::Duplicate) == 2);
  CHECK(count(network, Kind::Overlap) == 0);
  CHECK(network.edges_of("x1 again") == network.edges_of("x1"));
  check_invariants(network);

  // Hundreds of equal curves cost no more than one: they have no contacts with each other.
  auto many = base;
  for (int i = 0; i < 500; ++i) {
    many.push_back(base[1]);
    many.back().name = "x1 again " + std::to_string(i);
  }
  const CurveNetwork often(many);
  CHECK(often.edges().size() == single.edges().size());
  CHECK(count(often, Kind::Duplicate) == 500);
  CHECK(often.edges_of("x1 again 499") == often.edges_of("x1"));
  check_invariants(often);

  // A curve that runs back and forth over itself has as many contacts as pairs of its segments.
  std::vector<Vec3> fro;
  for (int i = 0; i < 4000; ++i) fro.emplace_back(i % 10 < 5 ? i % 5 : 5 - i % 5, 1e-7 * i, 0);
  CHECK_THROWS_WITH(CurveNetwork({through("fro", fro)}),
                    Catch::Matchers::Contains("drawn several times"));

  // Two straight curves share the part from 1 to 2.
  const CurveNetwork part(
      {straight("a", {0, 0, 0}, {2, 0, 0}), straight("b", {1, 0, 0}, {3, 0, 0})});
  CHECK(part.nodes().size() == 4);
  CHECK(part.edges().size() == 3);
  CHECK(count(part, Kind::Overlap) == 1);
  CHECK(part.edges_of("a").size() == 2);
  CHECK(part.edges_of("b").size() == 2);
  check_invariants(part);

  // A curve that leaves another one at its middle.
  const CurveNetwork leaving(
      {straight("a", {0, 0, 0}, {4, 0, 0}),
       through("b", {{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}, {1.5, 0, 0}, {2, 0, 0}, {3, 1, 0}})});
  CHECK(leaving.nodes().size() == 4);
  CHECK(leaving.edges().size() == 3);
  CHECK(count(leaving, Kind::Overlap) == 1);

  const CurveNetwork rings({circle("r", Vec3::Zero(), 1), circle("s", Vec3::Zero(), 1)});
  CHECK(rings.edges().size() == 1);
  CHECK(count(rings, Kind::Duplicate) == 1);

  // Tangency is not an overlap: a circle on its tangent.
  const CurveNetwork touch({circle("c", {0, 1, 0}, 1), straight("t", {-2, 0, 0}, {2, 0, 0})});
  CHECK(count(touch, Kind::Overlap) == 0);
  CHECK(count(touch, Kind::Crossing) == 1);
  CHECK(touch.edges().size() == 3);
}

TEST_CASE("Curves that pass each other are not joined, but named when near",
          "[skinning][network]") {
  NetworkOptions options;
  options.tolerance = 0.01;
  for (const auto& [height, joined, named] :
       {std::tuple(0.009, true, false), {0.02, false, true}, {0.06, false, false}}) {
    const CurveNetwork network({straight("under", {-1, 0, 0}, {1, 0, 0}),
                                straight("over", {0, -1, height}, {0, 1, height})},
                               options);
    CHECK(count(network, Kind::Crossing) == joined);
    CHECK(count(network, Kind::NearMiss) == named);
    CHECK(network.edges().size() == (joined ? 4U : 2U));
    if (joined) {
      for (const auto& edge : network.edges()) CHECK(edge.deviation <= 0.5 * height + 1e-12);
    } else {
      CHECK(count(network, Kind::Disconnected) == 1);
    }
    check_invariants(network);
  }
}

TEST_CASE("Pieces shorter than the tolerance are left out", "[skinning][network]") {
  NetworkOptions options;
  options.tolerance = 0.01;
  // A tiny curve near a corner, and an intersection just before the end of a curve.
  const CurveNetwork network(
      {straight("a", {0, 0, 0}, {1, 0, 0}), straight("b", {1, 0, 0}, {1, 1, 0}),
       straight("dot", {1.002, 0, 0}, {1.007, 0, 0}), straight("c", {0.5, -0.008, 0}, {0.5, 1, 0})},
      options);
  CHECK(network.edges().size() == 4);
  CHECK(names(single_diagnostic(network, Kind::Short), "dot"));
  CHECK(single_diagnostic(network, Kind::Short).repaired);
  CHECK(count(network, Kind::EndOnLine) == 1);
  CHECK(network.edges_of("dot").empty());
  check_invariants(network);
}

TEST_CASE("Invalid networks are refused with the reason", "[skinning][network]") {
  const auto line = straight("l", {0, 0, 0}, {1, 0, 0});
  CHECK(error_message([] { CurveNetwork({}); }).find("no") != std::string::npos);
  CHECK(error_message([&] { CurveNetwork({line, line}); }).find("'l'") != std::string::npos);
  CHECK(error_message([] { CurveNetwork({{"x", nullptr}}); }).find("'x'") != std::string::npos);
  const auto dot = straight("dot", {1, 1, 1}, {1, 1, 1});
  CHECK(error_message([&] { CurveNetwork({line, dot}); }).find("zero length") != std::string::npos);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e200})
    CHECK(error_message([&] {
            CurveNetwork({line, straight("bad", {0, 0, 0}, {bad, 0, 0})});
          }).find("'bad'") != std::string::npos);
  for (const double bad : {-1.0, std::nan(""), 5.0}) {
    NetworkOptions options;
    options.tolerance = bad;
    CHECK(error_message([&] { CurveNetwork({line}, options); }).find("tolerance") !=
          std::string::npos);
  }
  NetworkOptions options;
  options.corner_angle = -3;
  CHECK(error_message([&] { CurveNetwork({line}, options); }).find("corner_angle") !=
        std::string::npos);
  Progress progress;
  progress.cancelled = [] { return true; };
  CHECK_THROWS_AS(CurveNetwork({line}, {}, progress), CancelledError);
}

TEST_CASE("Random networks keep their invariants, shuffled bit by bit", "[skinning][network]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 240; ++round) {
    const int mode = round % 5;  // in space, in a plane, on a grid, near few points, on one line
    const auto point = [&] {
      Vec3 p(unit(random), unit(random), unit(random));
      if (mode == 1) p[2] = 0;
      if (mode == 2) p = (2 * p).array().round() / 2;
      if (mode == 3) p = Vec3(std::round(p[0]), std::round(p[1]), 0) + 1e-3 * p;
      if (mode == 4) p = Vec3(p[0], 0, 0);
      return p;
    };
    std::vector<CharacterLine> lines;
    const int n = 1 + static_cast<int>(random() % 9);
    for (int i = 0; i < n; ++i) {
      const std::string name = "l" + std::to_string(i);
      try {
        switch (random() % 4) {
          case 0:
            lines.push_back({name, bezier_curve(point(), point(), point(), point())});
            break;
          case 1:
            lines.push_back(through(name, {point(), point()}));
            break;
          case 2: {
            std::vector<Vec3> points;
            for (int k = 0; k < 4; ++k) points.push_back(point());
            if (random() % 3 == 0) points.push_back(points[0]);
            lines.push_back(through(name, points, random() % 2 ? 20 : 170));
            break;
          }
          default:
            if (!lines.empty()) lines.push_back({name, lines[random() % lines.size()].curve});
        }
      } catch (const InputError&) {  // points that coincide
      }
    }
    NetworkOptions options;
    if (random() % 3 == 0) options.tolerance = 0.02 * std::pow(10, 2 * (unit(random) - 1));
    try {
      const CurveNetwork network(lines, options);
      check_invariants(network);
      std::shuffle(lines.begin(), lines.end(), random);
      CHECK(difference(network, CurveNetwork(lines, options)) == 0);
    } catch (const InputError&) {  // all curves shorter than the tolerance
    }
  }
}

TEST_CASE("curves whose ends stop short of each other get the tolerance that joins them",
          "[skinning][network]") {
  // A hand-drawn box: each edge ends beside its corners.
  for (const double gap : {0.0, 0.002, 0.012, 0.05}) {
    std::vector<CharacterLine> lines;
    for (int k = 0; k < 12; ++k) {
      const int axis = k / 4;
      Vec3 a = Vec3::Zero();
      a[(axis + 1) % 3] = k % 2;
      a[(axis + 2) % 3] = k / 2 % 2;
      a[axis] = gap;
      Vec3 b = a;
      b[axis] = 1 - gap;
      const std::string name = "edge " + std::to_string(k);
      lines.push_back({name, curve_through_points(name, {a, b})});
    }
    const CurveNetwork network(lines);
    CAPTURE(gap);
    CHECK(joined_fraction(lines) == network.joined_fraction());
    const double size = network.size();
    if (gap < 1e-3) {
      CHECK(network.joined_fraction() == 1);
      CHECK(network.tolerance() == Approx(1e-3 * size));
    } else {
      CHECK(network.joined_fraction() == 0);
    }
    // Ends at a corner are apart by gap √2.
    if (gap == 0.002 || gap == 0.012) {
      CHECK(network.nodes().size() == 8);
      CHECK(network.tolerance() < 2 * std::numbers::sqrt2 * gap);
    }
    if (gap == 0.05) CHECK(network.tolerance() == Approx(1e-3 * size));  // too large
    NetworkOptions stated;
    stated.tolerance = 1e-4 * size;
    CHECK(CurveNetwork(lines, stated).tolerance() == 1e-4 * size);
  }
}

TEST_CASE("the gap of an end is the distance of the nearest other curve", "[skinning][network]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(0, 1);
  const auto point = [&] { return Vec3(anywhere(random), anywhere(random), anywhere(random)); };
  std::vector<std::pair<Vec3, Vec3>> segments;
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 80; ++i) {
    const Vec3 a = point();
    segments.emplace_back(a, a + 0.3 * (point() - Vec3::Constant(0.5)));
    lines.push_back(straight("l" + std::to_string(i), segments[i].first, segments[i].second));
  }
  const auto sampled = detail::make_sampled_curves(lines, 20).sampled_curves;
  constexpr double reach = 0.1;
  const std::vector<double> gaps = detail::end_gaps(sampled, reach);
  REQUIRE(gaps.size() == 2 * sampled.size());
  double worst = 0;
  int found = 0;
  for (size_t k = 0; k < gaps.size(); ++k) {
    const auto& own = sampled[k / 2];
    double expected = std::numeric_limits<double>::infinity();
    for (int i = 0; i < isize(segments); ++i) {
      const auto& [a, b] = segments[i];
      const Vec3 p = own.end_point(k % 2);
      const double along = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      if (i != own.line) expected = std::min(expected, (a + along * (b - a) - p).norm());
    }
    if (expected > reach) {
      CHECK(gaps[k] > 1e300);
    } else {
      worst = std::max(worst, std::abs(gaps[k] - expected));
      ++found;
    }
  }
  CHECK(worst < 1e-12);
  CHECK(found > 40);
}

TEST_CASE("curves that cross and extend slightly beyond are not taken as hand-drawn",
          "[skinning][network]") {
  // A grid whose curves end 1 % of the size beyond the last intersection, and not close to another
  // end.
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 4; ++i) {
    const double x = i / 3.0;
    lines.push_back(straight("x" + std::to_string(i), {x, -0.014, 0}, {x, 1.014, 0}));
    lines.push_back(straight("y" + std::to_string(i), {-0.014, x, 0}, {1.014, x, 0}));
  }
  const CurveNetwork network(lines);
  CHECK(network.joined_fraction() == 1);
  CHECK(network.tolerance() == Approx(1e-3 * network.size()));
  CHECK(count(network, Kind::Crossing) == 16);
}

TEST_CASE("curves that cross far more often than they end are not taken as hand-drawn",
          "[skinning][network]") {
  // A grid whose outer curves are 1.5 % of the size inside the ends of the others, duplicated at
  // the same distance: a tolerance of that gap would join the duplicates.
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 8; ++i)
    for (const double beside : {0.0, 0.021}) {
      const double x = i / 7.0 + beside;
      const std::string name = std::to_string(lines.size());
      lines.push_back(straight("x" + name, {x, -0.024, 0}, {x, 1.045, 0.003}));
      lines.push_back(straight("y" + name, {-0.024, x, 0}, {1.045, x, 0.003}));
    }
  const CurveNetwork network(lines);
  CHECK(network.joined_fraction() > 0.5);
  CHECK(joined_fraction(lines) == network.joined_fraction());
  CHECK(network.tolerance() == Approx(1e-3 * network.size()));
}

TEST_CASE("the tolerance of a hand-drawn network ignores ends that are not meant to meet",
          "[skinning][network]") {
  // The sides of a hexagon, too short at both ends by 0.4 to 0.6; a short curve that ends 3 below
  // one.
  std::vector<CharacterLine> lines;
  const auto add = [&](const Vec3& a, const Vec3& b) {
    const std::string name = "line " + std::to_string(lines.size());
    lines.push_back({name, curve_through_points(name, {a, b})});
  };
  const auto corner = [](int k) {
    return Vec3(100 * std::cos(k * std::numbers::pi / 3), 100 * std::sin(k * std::numbers::pi / 3),
                0);
  };
  for (int k = 0; k < 6; ++k) {
    const Vec3 along = (corner(k + 1) - corner(k)).normalized();
    const double gap = 0.4 + 0.04 * k;
    add(corner(k) + gap * along, corner(k + 1) - gap * along);
  }
  add({0, 83.6, 0}, {0, 20, 0});
  const CurveNetwork network(lines);
  // 14 ends: 12 at corners, one 3 below the upper side, one far from everything.
  CHECK(network.joined_fraction() == 0);
  CHECK(network.tolerance() > 0.6);
  CHECK(network.tolerance() < 1.4 * 2 * 0.6);
}
