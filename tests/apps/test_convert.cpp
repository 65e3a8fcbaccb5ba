// SPDX-License-Identifier: MPL-2.0
// batten convert and batten info on CAD files.
#include <cmath>

#include "batten/io/lines/drawing.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;
using batten::Drawing;
using batten::read_drawing;
using batten::Vec3;

namespace {

const fs::path kSeeds = fs::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds";

const char* const kSquare =
    "unit = \"mm\"\nname = \"square\"\n"
    "[[curve]]\nname = \"a\"\npoints = [[0,0,0],[100,0,0]]\n"
    "[[curve]]\nname = \"b\"\npoints = [[100,0,0],[100,100,0]]\n"
    "[[curve]]\nname = \"c\"\npoints = [[100,100,0],[0,100,0]]\n"
    "[[curve]]\nname = \"d\"\npoints = [[0,100,0],[0,0,0]]\n"
    "[output]\nstep = \"s.step\"\n";

bool contains_text(const std::string& text, const std::string& part) {
  INFO(text << "\nexpected: " << part);
  const bool found = text.find(part) != std::string::npos;
  CHECK(found);
  return found;
}

/// The text of a tetrahedron with groups, as OBJ.
const char* const kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng base\nf 1 3 2\n"
    "g sides\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

}  // namespace

TEST_CASE("files that a scene writes are listed by info and converted with their names",
          "[apps][convert]") {
  const CliCase c("convert_own");
  c.file("s.toml", kSquare);
  REQUIRE(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  const CliResult info = c.run({"info", "out/s.step"});
  CHECK(info.code == 0);
  for (const char* part :
       {"STEP AP214, in mm: 1 product, 1 face", "part 'square', 1 face", "name 'square': 1 face",
        "name 'a': 1 edge", "area 10000 mm²", "valid, area 10000"})
    contains_text(info.out, part);
  const CliResult step =
      c.run({"convert", "out/s.step", "t.stp", "--schema", "ap242", "--unit", "inch"});
  INFO(step.err);
  CHECK(step.code == 0);
  contains_text(step.out, "written     t.stp: STEP AP242, in in: 1 product, 1 face");
  contains_text(contents(c / "t.stp"), "ADVANCED_FACE('square'");
  const CliResult iges = c.run({"convert", "t.stp", "t.igs", "--unit", "mm"});
  CHECK(iges.code == 0);
  contains_text(iges.err, "IGES cannot store names of edges between faces: 4 are lost");
  contains_text(c.run({"info", "t.igs"}).out, "name 'square': 1 face");
  // A scene in metres is written in metres.
  std::string metres = kSquare;
  metres.replace(metres.find("mm"), 2, "m");
  c.file("m.toml", metres);
  REQUIRE(c.run({"run", "m.toml", "--out", "m"}).code == 0);
  const std::string large = c.run({"info", "m/s.step"}).out;
  contains_text(large, "STEP AP214, in m: 1 product, 1 face");
  contains_text(large, "area 10000 m²");
  // The curves of the file, by name; they give the same surface again.
  const CliResult lines = c.run({"convert", "out/s.step", "lines.csv"});
  CHECK(lines.code == 0);
  contains_text(contents(c / "lines.csv"), ",a\n");
  CHECK(c.run({"skin", "t.stp", "--unit", "mm", "--out", "again"}).code == 0);
}

TEST_CASE("triangles of CAD faces state their chord and their deviation", "[apps][convert]") {
  const CliCase c("convert_mesh");
  c.file("s.toml", kSquare);
  REQUIRE(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  for (const std::string ending : {"stl", "obj", "ply", "off", "vtp", "vtu"}) {
    INFO(ending);
    const CliResult r = c.run({"convert", "out/s.step", "t." + ending, "--unit", "m"});
    INFO(r.err);
    CHECK(r.code == 0);
    contains_text(r.out, "in m, ");
    contains_text(r.out, "of the faces, chord 0.000141421 m (0.001 of the size)");
    const auto mesh = batten::MeshFile::read(c / ("t." + ending)).shells();
    CHECK(mesh.points.maxCoeff() == Approx(0.1).epsilon(1e-6));
  }
  contains_text(contents(c / "t.obj"), "g square\n");
  CHECK(c.run({"convert", "out/s.step", "t.glb"}).code == 0);
  const CliResult fine = c.run({"convert", "out/s.step", "u.obj", "--chord", "1e-9"});
  CHECK(fine.code == 1);
  contains_text(fine.err, "expected 1e-7 of the size or more");
  CHECK_FALSE(fs::exists(c / "u.obj"));
}

TEST_CASE("meshes are converted into each other, with their groups", "[apps][convert]") {
  const CliCase c("convert_meshes");
  c.file("t.obj", kTetrahedron);
  std::string last = "t.obj";
  for (const std::string ending : {"vtp", "stl", "ply", "off", "vtu", "obj"}) {
    const std::string next = "u." + ending;
    const CliResult r = c.run({"convert", last, next});
    INFO(r.err);
    CHECK(r.code == 0);
    contains_text(r.out, "coordinates unchanged");
    const auto mesh = batten::MeshFile::read(c / next);
    CHECK(mesh.shells().face_count() == 4);
    CHECK(mesh.shells().node_count() == 4);
    last = next;
  }
  CHECK(c.run({"convert", "t.obj", "v.obj", "--from-unit", "in", "--unit", "mm"}).code == 0);
  const auto mesh = batten::MeshFile::read(c / "v.obj");
  CHECK(mesh.shells().points.maxCoeff() == 25.4);
  REQUIRE(mesh.sets().size() == 2);
  CHECK(mesh.sets()[1].name == "sides");
  CHECK(mesh.sets()[1].faces == std::vector<int>{1, 2, 3});
  CHECK(c.run({"convert", (kSeeds / "meshes/sheet.bdf").string(), "deck.stl"}).code == 0);
}

TEST_CASE("meshes become GLB and 3MF in their units, with colours on the way", "[apps][convert]") {
  const CliCase c("convert_glb");
  c.file("t.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
  c.file("t.obj", "mtllib t.mtl\nusemtl blue\n" + std::string(kTetrahedron) +
                      "usemtl red\ng sides\nf 1 2 3\n");
  const CliResult glb = c.run({"convert", "t.obj", "t.glb", "--from-unit", "cm"});
  INFO(glb.err);
  CHECK(glb.code == 0);
  contains_text(glb.out, "t.glb: 4 nodes, 5 faces, cm to m");
  const std::string text = contents(c / "t.glb");
  contains_text(text, "\"name\":\"base\"");
  contains_text(text, "\"max\":[0.009999999776482582,0.009999999776482582,0.0]");
  contains_text(text, "\"name\":\"#ff0000\"");
  contains_text(text, "\"name\":\"#0000ff\"");
  CHECK(c.run({"convert", "t.obj", "t.3mf", "--from-unit", "in"}).code == 0);
  // The colours of faces of a CAD file become those of its triangles; two files are made of OBJ.
  c.file("two.toml",
         "unit = \"mm\"\nname = \"two\"\n\n"
         "[[curve]]\nname = \"a\"\npoints = [[0,0,0],[10,0,0],[10,10,0],[0,10,0],[0,0,0]]\n"
         "[[curve]]\nname = \"b\"\npoints = [[0,0,0],[10,10,0]]\n[output]\nstep = \"s.step\"\n");
  REQUIRE(c.run({"run", "two.toml", "--out", "two"}).code == 0);
  contains_text(c.run({"convert", "two/s.step", "s.obj"}).out, ", colours in s.mtl");
  contains_text(contents(c / "s.mtl"), "newmtl 8cb4d9\n");
  contains_text(contents(c / "s.obj"), "usemtl e6b46e\n");
  CHECK(c.run({"convert", "two/s.step", "s.ply"}).code == 0);
  contains_text(contents(c / "s.ply"), "property uchar red\n");
  const CliResult printed = c.run({"convert", "two/s.step", "s.3mf"});
  INFO(printed.err);
  CHECK(printed.code == 0);
  contains_text(printed.out, "in mm, ");
}

TEST_CASE("curves are converted between formats and into CAD files", "[apps][convert]") {
  const CliCase c("convert_lines");
  c.file("l.csv",
         "name,x,y,z\nrail,0,0,0\nrail,10,0,0\nrail,20,5,0\nrail,30,5,1\nrib,0,0,0\nrib,0,7,0\n");
  const CliResult step = c.run({"convert", "l.csv", "l.step", "--from-unit", "cm", "--unit", "mm"});
  INFO(step.err);
  CHECK(step.code == 0);
  contains_text(c.run({"info", "l.step"}).out, "rib   length 70  from (0, 0, 0) to (0, 70, 0)");
  CHECK(c.run({"convert", "l.csv", "n.step", "--schema", "ap242"}).code == 0);
  contains_text(c.run({"info", "n.step"}).out, "STEP AP242, in mm: 1 product, 2 curves");
  CHECK(c.run({"convert", "l.step", "l.iges"}).code == 0);
  CHECK(c.run({"convert", "l.iges", "back.csv", "--unit", "cm"}).code == 0);
  contains_text(contents(c / "back.csv"), ",rib\n");
  CHECK(c.run({"convert", "l.step", "l.obj"}).code == 0);  // without faces: curves
  contains_text(contents(c / "l.obj"), "\nl 1 2 ");
  CHECK(c.run({"convert", (kSeeds / "drawings/plate.svg").string(), "plate.step"}).code == 0);
}

TEST_CASE("names, units and cubic curves survive conversions between drawings", "[apps][convert]") {
  const CliCase c("convert_drawings");
  c.file("l.csv",
         "x,y,z,curve\n0,0,0,left <1>\n10,2,0,left <1>\n20,5,0,left <1>\n30,5,0,left <1>\n"
         "0,0,0,\"Größe, \"\"2\"\"\"\n0,7,0,\"Größe, \"\"2\"\"\"\n9,7,0,\"Größe, \"\"2\"\"\"\n");
  const auto convert = [&](const std::string& from, const std::string& to) {
    const CliResult r = c.run({"convert", from, to});
    INFO(from << " to " << to << "\n" << r.err);
    CHECK(r.code == 0);
    CHECK(r.err.empty());
    return r.out;
  };
  CHECK(c.run({"convert", "l.csv", "a.dxf", "--from-unit", "in"}).code == 0);
  CHECK(convert("a.dxf", "a.svg").find("assumed") == std::string::npos);
  contains_text(convert("a.svg", "b.dxf"), "2 curves, in in");
  const Drawing a = read_drawing(c / "a.dxf"), b = read_drawing(c / "b.dxf");
  CHECK(a.unit_in_metres == 0.0254);
  CHECK(b.unit_in_metres == 0.0254);
  REQUIRE(a.lines.size() == 2);
  REQUIRE(b.lines.size() == 2);
  for (const Drawing& drawing : {a, b}) {
    CHECK(drawing.lines[0].name == "left <1>");
    CHECK(drawing.lines[1].name == "Größe, \"2\"");
    CHECK(drawing.lines[1].points == std::vector<Vec3>{{0, 0, 0}, {0, 7, 0}, {9, 7, 0}});
  }
  // The parameters of the curves differ, but not their cubic pieces.
  const auto &before = a.lines[0].curve, &after = b.lines[0].curve;
  REQUIRE(before);
  REQUIRE(after);
  const std::vector<double> t = before->breaks(), s = after->breaks();
  REQUIRE(t.size() == s.size());
  for (size_t i = 0; i + 1 < t.size(); ++i)
    for (const double part : {0.0, 0.3, 0.9})
      CHECK((before->evaluate(t[i] + part * (t[i + 1] - t[i])) -
             after->evaluate(s[i] + part * (s[i + 1] - s[i])))
                .norm() < 1e-12 * 30);
  // Names pass through CAD files, and curves in space do not fit into an SVG file.
  convert("b.dxf", "c.step");
  convert("c.step", "d.iges");
  convert("d.iges", "e.csv");
  contains_text(contents(c / "e.csv"), ",left <1>\n");
  contains_text(contents(c / "e.csv"), ",\"Größe, \"\"2\"\".1\"\n");
  c.file("space.csv", "0,0,0\n10,0,1\n20,5,0\n");
  const CliResult refused = c.run({"convert", "space.csv", "a.svg"});
  CHECK(refused.code == 1);
  contains_text(refused.err, "write a .dxf file");
  CHECK(read_drawing(c / "a.svg").lines.size() == 2);
  CHECK(c.run({"fair", "l.csv", "--out", "fair.svg"}).code == 0);
  contains_text(contents(c / "fair.svg"), "inkscape:label=\"left &lt;1&gt;\"");
}

TEST_CASE("conversions that are not supported are refused with the reason", "[apps][convert]") {
  const CliCase c("convert_refused");
  c.file("t.obj", kTetrahedron);
  c.file("s.toml", kSquare);
  c.file("l.csv", "0,0,0\n10,0,0\n20,5,0\n");
  c.file("old.step", "old");
  const auto refused = [&](const std::vector<std::string>& words, const std::string& part) {
    std::vector<std::string> all = {"convert"};
    all.insert(all.end(), words.begin(), words.end());
    const CliResult r = c.run(all);
    INFO(r.err);
    CHECK(r.code == 1);
    contains_text(r.err, part);
  };
  refused({"t.obj", "old.step"}, "use `batten fit`");
  CHECK(contents(c / "old.step") == "old");
  refused({"t.obj", "t.obj"}, "found an input file of this command as output file");
  refused({"t.obj", "t.rad"}, "expected one of: .3mf, .bdf, .fem, .glb, .inp");
  refused({"t.obj", "t.glb"}, "expected --from-unit, the unit of the coordinates");
  refused({"t.obj", "t.3mf", "--from-unit", "in", "--unit", "in"}, ".3mf is in mm");
  refused({"t.obj", "t.stl", "--unit", "m"},
          "found --unit m for a file that states no length unit");
  refused({"l.csv", "l.stl"}, "for curves, expected one of: .curves");
  refused({"s.toml", "s.step"}, "expected a CAD file");
  refused({"none.step", "s.iges"}, "no such file");
  refused({(kSeeds / "cad/square.step").string(), "s.pdf"}, "for a CAD file, expected one of");
  refused({(kSeeds / "cad/square.step").string(), "s.iges", "--from-unit", "m"},
          "CAD files state their unit");
  refused({"t.obj", "s.stl", "--schema", "ap203"}, "ap203");
  CHECK_FALSE(fs::exists(c / "t.rad"));
}

TEST_CASE("real CAD files keep their contents in every format", "[apps][convert]") {
  const fs::path data = optional_data("step-parts");
  if (data.empty()) {
    WARN("no step-parts beside the project: skipped");
    return;
  }
  const CliCase c("convert_real");
  const CliResult info = c.run({"info", (data / "dm1-id-214.stp").string()});
  contains_text(info.out, "STEP AP214, in in: 8 products, 7 solids, 48 faces, closed");
  contains_text(info.out,
                "    part 'bolt' as 'bolt_4', 1 solid, 5 faces, at (0.39587, -0.334646, 1.37795), "
                "#ffa800");
  for (const std::string part : {"dm1-id-214", "io1-cm-214"})
    for (const std::string to : {"a.step", "a.iges", "a.brep", "a.stl", "a.glb"}) {
      INFO(part << " to " << to);
      const CliResult r = c.run({"convert", (data / (part + ".stp")).string(), to});
      INFO(r.out << r.err);
      CHECK(r.code == 0);
      if (to == "a.stl") contains_text(r.out, ", closed");
    }
}

TEST_CASE("hulls of IGES files are meshed without cracks", "[apps][convert]") {
  const fs::path data = optional_data("lines-ship-iges");
  if (data.empty()) {
    WARN("no lines-ship-iges beside the project: skipped");
    return;
  }
  const CliCase c("convert_hulls");
  for (const char* hull : {"kvlcc2m", "series_60", "singolo", "wigley"}) {
    INFO(hull);
    const CliResult r =
        c.run({"convert", (data / (std::string(hull) + ".iges")).string(), "h.stl"});
    INFO(r.out << r.err);
    CHECK(r.code == 0);
    contains_text(r.out, "in m, ");
  }
}
