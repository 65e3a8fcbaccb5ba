// SPDX-License-Identifier: MPL-2.0
// Other programs read the same curves from a curve file, and files are written completely or not at
// all.
#include "batten/io/lines/curve_files.h"

#include <BRep_Tool.hxx>
#include <Geom_BSplineCurve.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include <cmath>
#include <numbers>
#include <random>

#include "batten/io/cad/occ_settings.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/pictures/comb_pictures.h"
#include "batten/io/pictures/display.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
namespace fs = std::filesystem;
using Catch::Matchers::Contains;

namespace {

/// A generic C1 curve: uneven segments, no symmetry, size about 100.
HermiteCurve any_curve(int segments, bool closed, std::vector<int> corners, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> between(-1, 1);
  std::vector<double> u = {0.3};
  for (int s = 0; s < segments; ++s) u.push_back(u.back() + 1.5 + between(random));
  CurveMesh mesh(u, closed, std::move(corners));
  Points dofs(mesh.dof_count(), 3);
  for (int d = 0; d < mesh.dof_count(); ++d)
    dofs.row(d) << 50 * between(random), 50 * between(random), 50 * between(random);
  return {mesh, dofs};
}

/// A single cubic divided into segments: C3 at its nodes.
HermiteCurve cut_cubic() {
  HermiteCurve whole({0, 4}, (Points(2, 3) << 0, 0, 0, 30, 10, 5).finished(),
                     (Points(2, 3) << 10, 5, 0, 3, -9, 4).finished());
  return whole.with_nodes({1, 1.5, 3});
}

HermiteCurve circle(double radius, int segments) {
  std::vector<double> u;
  for (int s = 0; s <= segments; ++s) u.push_back(2 * std::numbers::pi * radius * s / segments);
  CurveMesh mesh(u, true);
  Points dofs(mesh.dof_count(), 3);
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double angle = 2 * std::numbers::pi * n / segments;
    dofs.row(mesh.position_dof(n)) << radius * std::cos(angle), radius * std::sin(angle), 1;
    dofs.row(mesh.slope_out(n)) << -std::sin(angle), std::cos(angle), 0;
  }
  return {mesh, dofs};
}

std::vector<NamedCurve> many() {
  std::vector<NamedCurve> curves = {{"open", any_curve(7, false, {}, 1), {}, {}},
                                    {"cornered rail", any_curve(6, false, {2, 5}, 2), {}, {}},
                                    {"loop", any_curve(5, true, {}, 3), {}, {}},
                                    {"kinked loop", any_curve(6, true, {1, 4}, 4), {}, {}},
                                    {"seam is a corner", any_curve(4, true, {0}, 5), {}, {}},
                                    {"one cubic", cut_cubic(), {}, {}}};
  for (NamedCurve& c : curves)
    for (int i = 0; i <= 11; ++i)
      c.parameters.push_back(c.curve.start() + (c.curve.end() - c.curve.start()) * i / 11);
  return curves;
}

const NamedCurve kDot{"dot", {}, {}, {{1, 2, 3}}};

bool has_python(const std::string& module) {
  if (std::system(("/usr/bin/python3 -c 'import " + module + "' > /dev/null 2>&1").c_str()) == 0)
    return true;
  WARN("skipped: python3 has no module " << module);
  return false;
}

/// Output of a script to `out`, one number per token (OpenCASCADE prints to the standard output).
std::vector<double> numbers_of(const std::string& script, const fs::path& folder) {
  std::ofstream(folder / "script.py") << "out = open('numbers', 'w')\n" << script;
  const auto out = folder / "numbers";
  const std::string command =
      "cd '" + folder.string() + "' && /usr/bin/python3 script.py > talk 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(out);
  return {std::istream_iterator<double>(in), {}};
}

}  // namespace

TEST_CASE("points come back as they were written, and as many", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_text");
  const std::string ending = GENERATE(".curves", ".csv", ".obj");
  const auto curves = many();
  CHECK(write_curves(folder / ("a" + ending), curves).empty() == (ending != ".curves"));
  const auto lines = read_point_lines(folder / ("a" + ending));
  REQUIRE(lines.size() == curves.size());
  for (size_t i = 0; i < lines.size(); ++i) {
    REQUIRE(lines[i].points.size() == curves[i].parameters.size());
    for (size_t k = 0; k < lines[i].points.size(); ++k)
      CHECK(lines[i].points[k] == curves[i].curve.evaluate(curves[i].parameters[k]));
    if (ending != ".curves") CHECK(lines[i].name == curves[i].name);
  }
}

TEST_CASE("consecutive coincident points are written once", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_repeats");
  auto curves = many();
  auto& u = curves.front().parameters;
  const size_t before = u.size();
  u.insert(u.begin() + 2, u[1]);
  CHECK(write_curves(folder / "a.csv", curves).empty());
  CHECK(read_point_lines(folder / "a.csv").front().points.size() == before);
}

TEST_CASE("a curve of one point is written where possible, and named where not", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_dot");
  auto curves = many();
  curves.insert(curves.begin() + 2, kDot);
  CHECK_THAT(write_curves(folder / "a.curves", curves).at(0), Contains("names of the curves"));
  CHECK(write_curves(folder / "a.vtp", curves).empty());
  const auto lines = read_point_lines(folder / "a.curves");
  REQUIRE(lines.size() == curves.size());
  CHECK(lines[2].points == kDot.points);
  for (const char* file : {"a.csv", "a.obj", "a.dxf", "a.step", "a.igs"}) {
    const auto notes = write_curves(folder / file, curves);
    REQUIRE(notes.size() == 1);
    CHECK_THAT(notes[0], Contains("'dot' is not written") && Contains(file));
    CHECK_THAT(error_message([&] { write_curves(folder / file, {kDot}); }),
               Contains("no curve to write"));
  }
  CHECK(read_point_lines(folder / "a.csv").size() == curves.size() - 1);
}

TEST_CASE("CAD files hold exactly the curves, named, in the model's unit", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_cad");
  const std::string ending = GENERATE(".step", ".stp", ".iges", ".igs");
  const double metres = GENERATE(1e-3, 1.0, 0.0254);
  const auto curves = many();
  write_curves(folder / ("a" + ending), curves, {metres});
  const auto lines = read_cad_lines(folder / ("a" + ending), metres);
  const std::vector<std::string> names = {
      "open",          "cornered rail.1", "cornered rail.2",  "cornered rail.3", "loop",
      "kinked loop.1", "kinked loop.2",   "seam is a corner", "one cubic"};
  REQUIRE(lines.size() == names.size());
  const std::vector<size_t> of = {0, 1, 1, 1, 2, 3, 3, 4, 5};
  double worst = 0, covered = 0, whole = 0;
  for (const NamedCurve& c : curves) whole += c.curve.end() - c.curve.start();
  for (size_t i = 0; i < lines.size(); ++i) {
    CHECK(lines[i].name == names[i]);
    const InputCurve& read = *lines[i].curve;
    const HermiteCurve& curve = curves[of[i]].curve;
    CHECK(read.piecewise_cubic());
    covered += read.end() - read.start();
    for (int k = 1; k < 200; ++k) {
      const double u = read.start() + (read.end() - read.start()) * k / 200;
      worst = std::max(worst, (read.evaluate(u) - curve.evaluate(u)).norm());
      worst = std::max(worst, (read.evaluate(u, 1) - curve.evaluate(u, 1)).norm());
    }
  }
  // IGES readers may keep fewer digits of the unit than of the coordinates.
  CHECK(worst < 1e-9 * 100);
  CHECK(covered == Approx(whole).epsilon(1e-12));
  // In another unit the numbers differ, the lengths are equal.
  const auto other = read_cad_lines(folder / ("a" + ending), 1e-3);
  const Vec3 p = other[0].curve->evaluate(other[0].curve->start());
  CHECK((p * 1e-3 - curves[0].curve.position(0) * metres).norm() < 1e-9 * 100 * metres);
}

TEST_CASE("knots are no more than the curve's smoothness asks for", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_knots");
  write_curves(folder / "a.step", {{"C1", any_curve(7, false, {}, 1), {}, {}},
                                   {"C3", cut_cubic(), {}, {}},
                                   {"loop", any_curve(5, true, {}, 3), {}, {}}});
  OccSettings occ;
  occ.set_unit("MM");
  STEPControl_Reader reader;
  REQUIRE(reader.ReadFile((folder / "a.step").c_str()) == IFSelect_RetDone);
  reader.TransferRoots();
  std::vector<Handle(Geom_BSplineCurve)> splines;
  std::vector<bool> one_vertex;
  for (TopExp_Explorer it(reader.OneShape(), TopAbs_EDGE); it.More(); it.Next()) {
    double a, b;
    splines.push_back(
        Handle(Geom_BSplineCurve)::DownCast(BRep_Tool::Curve(TopoDS::Edge(it.Current()), a, b)));
    REQUIRE_FALSE(splines.back().IsNull());
  }
  REQUIRE(splines.size() == 3);
  for (size_t i = 0; i < 3; ++i) {
    const auto& s = splines[i];
    CHECK(s->Degree() == 3);
    CHECK_FALSE(s->IsRational());
    for (int k = 2; k < s->NbKnots(); ++k) CHECK(s->Multiplicity(k) == (i == 1 ? 1 : 2));
  }
  CHECK(splines[0]->NbPoles() == 2 * 8);
  CHECK(splines[1]->NbPoles() == 4 + 3);
  CHECK_FALSE(splines[0]->IsClosed());
  CHECK(splines[2]->IsClosed());
}

TEST_CASE("VTK's Python reads polylines with their curvature", "[io][curves]") {
  if (!has_python("vtk")) return;
  const fs::path folder = batten_test::scratch("curve_vtp");
  write_curves(folder / "a.vtp", {{"circle", circle(20, 64), {}, {}},
                                  {"cornered", any_curve(6, false, {2, 5}, 2), {}, {}},
                                  kDot});
  const auto n = numbers_of(R"(
import vtk
r = vtk.vtkXMLPolyDataReader(); r.SetFileName("a.vtp"); r.Update(); d = r.GetOutput()
names = d.GetCellData().GetAbstractArray("Name")
assert [names.GetValue(i) for i in range(3)] == ["circle", "cornered", "dot"]
closed = d.GetCellData().GetArray("Closed")
print(d.GetNumberOfCells(), *[d.GetCell(i).GetNumberOfPoints() for i in range(3)], closed.GetTuple1(0), closed.GetTuple1(1), file=out)
k, v, u = [d.GetPointData().GetArray(a) for a in ("Curvature", "Curvature_vector", "u")]
worst = 0
for j in range(d.GetCell(0).GetNumberOfPoints()):
    i = d.GetCell(0).GetPointId(j); p = d.GetPoint(i); w = v.GetTuple3(i)
    worst = max(worst, abs(k.GetTuple1(i) - 1 / 20), max(abs(w[a] + p[a] / 400) for a in (0, 1)), abs(w[2]))
print(worst, u.GetTuple1(d.GetCell(0).GetPointId(0)), u.GetTuple1(d.GetCell(0).GetPointId(d.GetCell(0).GetNumberOfPoints() - 1)), file=out)
)",
                            folder);
  REQUIRE(n.size() == 9);
  CHECK(n[0] == 3);
  CHECK(n[1] > 400);
  CHECK(n[2] > 400);
  CHECK(n[3] == 2);
  CHECK(n[4] == 1);
  CHECK(n[5] == 0);
  CHECK(n[6] < 1e-4);  // distance of the cubic from the circle
  CHECK(n[7] == 0);
  CHECK(n[8] == Approx(2 * std::numbers::pi * 20).epsilon(1e-12));
}

TEST_CASE("Gmsh opens the STEP and IGES curves with their lengths", "[io][curves]") {
  if (!has_python("gmsh")) return;
  const fs::path folder = batten_test::scratch("curve_gmsh");
  const std::vector<NamedCurve> curves = {{"circle", circle(20, 64), {}, {}},
                                          {"open", any_curve(7, false, {}, 1), {}, {}},
                                          {"loop", any_curve(5, true, {}, 3), {}, {}}};
  for (const char* file : {"a.step", "a.igs"}) {
    write_curves(folder / file, curves);
    const auto n = numbers_of(std::string(R"(
import gmsh
gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.importShapes(")") + file +
                                  R"("); gmsh.model.occ.synchronize()
print(*sorted(gmsh.model.occ.getMass(*e) for e in gmsh.model.getEntities(1)), file=out)
)",
                              folder);
    std::vector<double> lengths;
    for (const NamedCurve& c : curves) lengths.push_back(c.curve.length());
    std::sort(lengths.begin(), lengths.end());
    REQUIRE(n.size() == lengths.size());
    for (size_t i = 0; i < n.size(); ++i)
      CHECK(n[i] == Approx(lengths[i]).epsilon(2e-3));  // Gmsh's measurement is approximate
  }
}

TEST_CASE("curve files are written whole or not at all", "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_whole");
  const auto curves = many();
  CHECK_THAT(error_message([&] { write_curves(folder / "a.stp2", curves); }),
             Contains("'.stp2'") && Contains("did you mean '.stp'"));
  CHECK_THAT(error_message([&] { write_curves(folder / "a", curves); }), Contains("no extension"));
  CHECK_THAT(error_message([&] { write_curves(folder / "a.step", curves, {0.123}); }),
             Contains("unit"));
  auto broken = curves;
  broken[1].parameters[3] = std::nan("");
  broken.push_back({"far", {}, {}, {{INFINITY, 0, 0}}});
  for (const std::string& ending : curve_file_extensions()) {
    const fs::path file = folder / ("old" + ending);
    std::ofstream(file) << "old";
    CHECK_THAT(error_message([&] { write_curves(file, broken); }),
               Contains("cornered rail") || Contains("far"));
    CHECK_FALSE(
        error_message([&] { write_curves(folder / "none" / ("a" + ending), curves); }).empty());
    CHECK_FALSE(error_message([&] { write_curves(file, {}); }).empty());
    CHECK(std::string(std::istreambuf_iterator<char>(*std::make_unique<std::ifstream>(file)), {}) ==
          "old");
  }
  CHECK(std::distance(fs::directory_iterator(folder), {}) ==
        static_cast<long>(curve_file_extensions().size()));
}

TEST_CASE("curvature combs are drawn, the same each time, and nothing without a curve",
          "[io][curves]") {
  const fs::path folder = batten_test::scratch("curve_combs");
  CombPicture picture;
  picture.unit = "mm";
  CHECK_THAT(error_message([&] { draw_combs(folder / "a.png", picture); }), Contains("no panel"));
  picture.panels = {{"wild", {any_curve(9, false, {4}, 7)}, {{0, 0, 0}}, {}},
                    {"round", {circle(20, 64)}, {}, {{{20, 0, 1}, 5}}}};
  picture.scale_panel = 2;
  CHECK_THAT(error_message([&] { draw_combs(folder / "a.png", picture); }),
             Contains("scale panel"));
  picture.scale_panel = 1;
  auto hollow = picture;
  hollow.panels[0].curves = {HermiteCurve()};
  CHECK_THAT(error_message([&] { draw_combs(folder / "a.png", hollow); }), Contains("'wild'"));
  if (!error_message([] { require_display(); }).empty()) {
    CHECK_THAT(error_message([&] { draw_combs(folder / "a.png", picture); }),
               Contains("no display"));
    CHECK(fs::is_empty(folder));
    WARN("skipped: no display");
    return;
  }
  const auto bytes = [&](const std::string& name, const std::optional<PictureSize>& size = {}) {
    draw_combs(folder / name, picture, size);
    std::ifstream in(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  // The size is in bytes 16 to 23 of the header.
  const auto size_of = [](const std::string& png) {
    const auto uint32_at = [&](size_t at) {
      int value = 0;
      for (size_t i = at; i < at + 4; ++i) value = 256 * value + static_cast<unsigned char>(png[i]);
      return value;
    };
    return std::pair(uint32_at(16), uint32_at(20));
  };
  const std::string a = bytes("a.png");
  CHECK(a.size() > 20000);
  CHECK(a == bytes("b.png"));
  CHECK(size_of(a).first == 1600);
  CHECK(size_of(bytes("c.png", PictureSize{400, 300})) == std::pair(400, 300));
  // Another scale of the comb or another view gives a different picture.
  picture.scale_panel = 0;
  CHECK(bytes("d.png") != a);
  picture.scale_panel = 1;
  picture.view = {0, 10};
  CHECK(bytes("e.png") != a);
}
