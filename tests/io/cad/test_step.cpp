// SPDX-License-Identifier: MPL-2.0
// A STEP file represents the surface exactly, in one shell, with the numbers of the model.
#include "batten/io/step/step.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

/// A curved sheet of size `scale`: values and derivatives of a function at the dofs of an n×n mesh
/// whose inner vertices are displaced randomly.
Surface sheet(int n, double scale, TriangleElement kind = TriangleElement::HCT, double lift = 0) {
  const ParametricMesh square = ParametricMesh::unit_square(n);
  auto vertices = square.vertices();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> move(-0.2 / n, 0.2 / n);
  for (Vec2& p : vertices)
    if (p.minCoeff() > 0 && p.maxCoeff() < 1) p += Vec2(move(random), move(random));
  const auto mesh = std::make_shared<ParametricMesh>(vertices, square.triangles());

  const auto x = [&](const Vec2& p) -> Vec3 {
    return scale * Vec3(p.x() + 0.1 * std::sin(2 * p.y()), p.y() + 0.1 * p.x() * p.x(),
                        lift + 0.3 * std::sin(3 * p.x()) * std::cos(2 * p.y()));
  };
  const auto x_u = [&](const Vec2& p) -> Vec3 {
    return scale * Vec3(1, 0.2 * p.x(), 0.9 * std::cos(3 * p.x()) * std::cos(2 * p.y()));
  };
  const auto x_v = [&](const Vec2& p) -> Vec3 {
    return scale *
           Vec3(0.2 * std::cos(2 * p.y()), 1, -0.6 * std::sin(3 * p.x()) * std::sin(2 * p.y()));
  };
  return interpolated(mesh, kind,
                      [&](const Vec2& p) { return SurfaceJet{x(p), x_u(p), x_v(p), {}, {}, {}}; });
}

/// Faces that consist of a surface only.
std::vector<SkinnedRegion> without_boundary(const std::vector<const Surface*>& surfaces) {
  std::vector<SkinnedRegion> regions;
  for (const Surface* surface : surfaces) regions.push_back({"sheet", *surface, {}, 1, {}, {}});
  return regions;
}
std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions) {
  std::vector<const SkinnedRegion*> all;
  for (const SkinnedRegion& region : regions) all.push_back(&region);
  return all;
}
StepReport write(const fs::path& file, const std::vector<const Surface*>& surfaces, double unit,
                 const StepOptions& options = {}) {
  return write_step(file, pointers(without_boundary(surfaces)), unit, options);
}

void expect_exact(const StepReport& r, const Surface& surface) {
  const int triangles = surface.mesh().triangle_count();
  CHECK(r.valid);
  CHECK(r.shells == 1);
  CHECK(r.faces == 3 * triangles);
  CHECK(r.edges == surface.mesh().edge_count() + 3 * triangles);
  int rim = 0;
  for (const auto& edge : surface.mesh().edges()) rim += edge.boundary();
  CHECK(r.free_edges == rim);
  CHECK(r.unmeasured == 0);
  CHECK(r.max_gap <= 1e-13 * r.size);
  CHECK(r.max_normal_jump_deg <= 1e-9);
  REQUIRE(r.max_deviation);
  CHECK(*r.max_deviation <= 1e-13 * r.size);
  CHECK(r.area == Approx(surface.area()).epsilon(1e-6));
  CHECK(r.solids == 0);
  CHECK(r.closed_shells == 0);
  CHECK(r.warnings.empty());
}

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("A STEP file read back is the HCT surface, in millimetres, metres and inches",
          "[io][step]") {
  const fs::path folder = batten_test::scratch("step");
  const struct {
    double unit, scale;
    std::string declared;
  } cases[] = {{1e-3, 250, "SI_UNIT(.MILLI.,.METRE.)"},
               {1, 2.5, "SI_UNIT($,.METRE.)"},
               {0.0254, 10, "'INCH'"}};
  for (const auto& c : cases) {
    CAPTURE(c.unit);
    const Surface surface = sheet(4, c.scale);
    const fs::path file = folder / "sheet.step";
    expect_exact(write(file, {&surface}, c.unit, {.file = {.name = "sheet"}}), surface);
    CHECK(text_of(file).find(c.declared) != std::string::npos);
    // Read in another unit, the file has the same real size.
    const StepReport in_centimetres = check_step(file, 1e-2);
    CHECK(in_centimetres.size ==
          Approx(check_step(file, c.unit).size * c.unit / 1e-2).epsilon(1e-12));
    CHECK(!in_centimetres.max_deviation);
  }
}

TEST_CASE("A STEP file agrees with itself as written, before any reader repairs it", "[io][step]") {
  // OpenCASCADE reorients curves and loops that run the wrong way on reading; other readers may
  // not. This test therefore parses the text.
  const Surface surface = sheet(2, 1);
  const fs::path file = batten_test::scratch("step") / "sheet.step";
  write(file, {&surface}, 1);
  std::map<std::string, std::string> entities;
  std::string text = text_of(file);
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return std::isspace(c); }),
             text.end());
  std::istringstream statements(text);
  for (std::string statement; std::getline(statements, statement, ';');)
    if (const size_t equal = statement.find('='); statement[0] == '#')
      entities[statement.substr(0, equal)] = statement.substr(equal + 1);

  // The entities of a type, and the n-th entity that another one references.
  const auto is = [&](const std::string& id, const std::string& type) {
    return entities.at(id).rfind(type + "(", 0) == 0;
  };
  const auto ref = [&](const std::string& id, int n) {
    static const std::regex pattern("#[0-9]+");
    const std::string& body = entities.at(id);
    auto it = std::sregex_iterator(body.begin(), body.end(), pattern);
    std::advance(it, n);
    return it->str();
  };
  const auto point = [&](const std::string& id) {
    REQUIRE(is(id, "CARTESIAN_POINT"));
    std::string numbers = entities.at(id).substr(entities.at(id).find(",(") + 2);
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    std::istringstream in(numbers);
    Vec3 p = Vec3::Zero();
    in >> p.x() >> p.y() >> p.z();
    return p;
  };
  // Pcurve of an edge on a face's surface.
  const auto line_on = [&](const std::string& edge, const std::string& face) {
    const std::string curve = ref(edge, 2);
    const bool first = ref(ref(curve, 1), 0) == face;
    return ref(ref(ref(curve, first ? 1 : 2), 1), 0);
  };

  int edges = 0, faces = 0;
  std::map<std::string, int> uses, directions;
  for (const auto& [id, body] : entities) {
    const bool sense = body.size() > 4 && body.substr(body.size() - 4) == ".T.)";
    if (is(id, "EDGE_CURVE")) {
      ++edges;
      CHECK(sense);
      const std::string curve = ref(ref(id, 2), 0);
      CHECK((point(ref(ref(id, 0), 0)) - point(ref(curve, 0))).norm() <= 1e-15);
      CHECK((point(ref(ref(id, 1), 0)) - point(ref(curve, 3))).norm() <= 1e-15);
    }
    if (is(id, "ADVANCED_FACE")) {
      ++faces;
      CHECK(sense);
      const std::string bound = ref(id, 0), face = ref(id, 1), loop = ref(bound, 0);
      CHECK(entities[bound].find(".T.") != std::string::npos);
      double twice_area = 0;
      for (int e = 0; e < 3; ++e) {
        const std::string oriented = ref(loop, e), edge = ref(oriented, 0);
        const bool along = entities[oriented].find(".T.") != std::string::npos;
        ++uses[edge];
        directions[edge] += along ? 1 : -1;
        const std::string line = line_on(edge, face), curve = ref(ref(edge, 2), 0);
        Vec3 st[2];
        for (int end = 0; end < 2; ++end) {
          st[end] = point(ref(line, end));
          const int corner = st[end].x() == 1 ? 12 : st[end].y() == 1 ? 3 : 0;  // of 4×4 poles
          CHECK((point(ref(face, corner)) - point(ref(curve, 3 * end))).norm() <= 1e-15);
        }
        twice_area += (along ? 1 : -1) * (st[0].x() * st[1].y() - st[1].x() * st[0].y());
      }
      CHECK(twice_area == 1);  // one counter-clockwise loop around the triangle
    }
  }
  const int triangles = surface.mesh().triangle_count();
  CHECK(edges == surface.mesh().edge_count() + 3 * triangles);
  CHECK(faces == 3 * triangles);
  for (const auto& [edge, count] : uses) CHECK(std::abs(directions[edge]) == 2 - count);
}

TEST_CASE("Random dofs make an exact STEP file too", "[io][step]") {
  Surface surface = sheet(3, 1);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);
  Points q = surface.dofs();
  for (double& value : q.reshaped()) value += noise(random);
  surface = Surface(surface.shared_mesh(), TriangleElement::HCT, q);
  const fs::path file = batten_test::scratch("step") / "random.step";
  const StepReport r = write(file, {&surface}, 1e-3);
  CHECK(r.valid);
  CHECK(r.max_gap <= 1e-13 * r.size);
  CHECK(r.max_normal_jump_deg <= 1e-8);
  CHECK(*r.max_deviation <= 1e-13 * r.size);
}

TEST_CASE("Several surfaces are several shells of one STEP file", "[io][step]") {
  const Surface low = sheet(2, 1), high = sheet(3, 1, TriangleElement::HCT, 0.7);
  const StepReport r = write(batten_test::scratch("step") / "two.stp", {&low, &high}, 1e-3);
  CHECK(r.valid);
  CHECK(r.shells == 2);
  CHECK(r.faces == 3 * (low.mesh().triangle_count() + high.mesh().triangle_count()));
  CHECK(*r.max_deviation <= 1e-13 * r.size);
  CHECK(r.area == Approx(low.area() + high.area()).epsilon(1e-6));
}

TEST_CASE("The measurements of a STEP file agree with its contents", "[io][step]") {
  const fs::path folder = batten_test::scratch("step");
  const fs::path file = folder / "sheet.step";
  const Surface surface = sheet(2, 1), moved = sheet(2, 1, TriangleElement::HCT, 0.01);
  write(file, {&surface}, 1);

  SECTION("another surface is seen as a deviation") {
    const double deviation =
        *check_step(file, 1, pointers(without_boundary({&moved}))).max_deviation;
    CHECK(deviation > 0.005);  // displaced by 0.01 on an inclined sheet
    CHECK(deviation <= 0.01 + 1e-12);
  }
  SECTION("an edge that leaves its faces is seen as a gap") {
    std::string text = text_of(file);
    // The second point of the first edge curve: #a in (#..,#a,#..,#..).
    const size_t curve = text.find("B_SPLINE_CURVE_WITH_KNOTS('',3,(");
    REQUIRE(curve != std::string::npos);
    const size_t second = text.find(",#", curve) + 1;
    const std::string point = text.substr(second, text.find(',', second) - second);
    const size_t x = text.find("('',(", text.find("\n" + point + " = CARTESIAN_POINT")) + 5;
    text.replace(x, text.find(',', x) - x, "9.");
    std::ofstream(folder / "torn.step") << text;
    CHECK(check_step(folder / "torn.step", 1).max_gap > 0.1);
  }
}

TEST_CASE("A Z12 surface is refused, or written by HCT functions on request", "[io][step]") {
  const fs::path file = batten_test::scratch("step") / "z12.step";
  double coarse = 0;
  for (const int n : {4, 8}) {
    const Surface surface = sheet(n, 1, TriangleElement::Z12);
    CHECK_THROWS_AS(write(file, {&surface}, 1), InputError);
    const StepReport r = write(file, {&surface}, 1, {.z12_as_hct = true});
    CHECK(r.valid);
    CHECK(r.max_gap <= 1e-13);
    CHECK(*r.max_deviation > 1e-9);
    CHECK(*r.max_deviation < 1e-3);
    if (n == 8) CHECK(*r.max_deviation < coarse / 8);  // O(h⁴)
    coarse = *r.max_deviation;
  }
}

TEST_CASE("A STEP file is written whole or not at all", "[io][step]") {
  const fs::path folder = batten_test::scratch("step");
  const fs::path file = folder / "sheet.step";
  Surface surface = sheet(2, 1);
  std::ofstream(file) << "what was there before";

  Points collapsed = surface.dofs();
  for (int v : {0, 1})
    for (int d = 0; d < 3; ++d) collapsed.row(surface.dof_map().vertex(v, d)).setZero();
  const Surface pole(surface.shared_mesh(), TriangleElement::HCT, collapsed);
  CHECK_THROWS_WITH(write(file, {&pole}, 1), Catch::Contains("collapsed"));
  Points broken = surface.dofs();
  broken(0, 0) = std::nan("");
  const Surface not_finite(surface.shared_mesh(), TriangleElement::HCT, broken);
  CHECK_THROWS_WITH(write(file, {&not_finite}, 1), Catch::Contains("finite"));
  CHECK_THROWS_WITH(write(file, {&surface}, 0.3), Catch::Contains("expected one of um, mm"));
  CHECK_THROWS_AS(write(file, {}, 1), InputError);
  CHECK(text_of(file) == "what was there before");
  CHECK_THROWS_WITH(write(folder / "no" / "such.step", {&surface}, 1),
                    Catch::Contains("such.step"));
  CHECK_THROWS_WITH(check_step(file, 1), Catch::Contains("no shape"));
  CHECK_THROWS_WITH(check_step(folder / "none.step", 1), Catch::Contains("no such file"));

  write(file, {&surface}, 1);
  int files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++files;
  CHECK(files == 1);
}

TEST_CASE("Above 10,000 triangles the size of the STEP file is reported beforehand", "[io][step]") {
  const auto plane = [](int n) {
    const auto mesh = std::make_shared<ParametricMesh>(ParametricMesh::unit_square(n));
    return Surface(mesh, TriangleElement::HCT, Points::Zero(DofMap(*mesh).count(), 3));
  };
  const Surface at_limit = plane(70), above = plane(71);  // 9,800 and 10,082 triangles
  CHECK(step_size_warning(pointers(without_boundary({&at_limit}))).empty());
  CHECK_THAT(step_size_warning(pointers(without_boundary({&above}))),
             Catch::Contains("30246 faces and about 144 MB"));
  // The prediction holds for a written file.
  const Surface surface = sheet(6, 1);
  const StepReport r = write(batten_test::scratch("step") / "size.step", {&surface}, 1);
  CHECK(static_cast<double>(r.bytes) / r.faces == Approx(4750).epsilon(0.05));
}
