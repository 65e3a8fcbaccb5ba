// SPDX-License-Identifier: MPL-2.0
// Conversion of CAD files: names, colours, layers, locations and sizes are preserved.
#include "batten/io/cad/cad_convert.h"

#include <BinTools.hxx>

#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/tests/io/cad/cad_files.h"
#include "batten/tests/support/error_message.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

std::map<std::string, int> faces_by_name(const std::vector<CadAttribute>& uses) {
  std::map<std::string, int> result;
  for (const CadAttribute& use : uses)
    if (use.faces > 0) result[use.name] = use.faces;
  return result;
}

void check_same(const CadContents& a, const CadContents& b) {
  const double unit = b.unit_in_metres / a.unit_in_metres;
  CHECK(b.faces == a.faces);
  CHECK(b.solids == a.solids);
  CHECK(b.closed_shells == a.closed_shells);
  CHECK(b.size * unit == Approx(a.size).epsilon(1e-9));
  CHECK(b.area * unit * unit == Approx(a.area).epsilon(1e-7));
  CHECK(b.volume * std::pow(unit, 3) == Approx(a.volume).epsilon(1e-7));
}

/// Two blocks, one of them translated and rotated, as an assembly "pair" of instances "left" and
/// "right"; the block is on the layer "metal".
Handle(TDocStd_Document) pair_of_blocks(TopoDS_Shape& whole) {
  const Handle(TDocStd_Document) document = document_of({painted("block", drilled_block())});
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence free;
  shapes->GetFreeShapes(free);
  const TDF_Label block = free.First();
  XCAFDoc_DocumentTool::LayerTool(document->Main())->SetLayer(block, "metal");
  const TDF_Label pair = shapes->NewShape();
  TDataStd_Name::Set(pair, "pair");
  gp_Trsf turn, translation;
  turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), std::acos(-1.0) / 6);
  translation.SetTranslation(gp_Vec(100, 20, 5));
  TDataStd_Name::Set(shapes->AddComponent(pair, block, TopLoc_Location()), "left");
  TDataStd_Name::Set(shapes->AddComponent(pair, block, TopLoc_Location(translation * turn)),
                     "right");
  shapes->UpdateAssemblies();
  whole = XCAFDoc_ShapeTool::GetShape(pair);
  return document;
}

}  // namespace

TEST_CASE("names and colours of faces survive from STEP over IGES and AP242 to STEP", "[io][cad]") {
  const fs::path folder = scratch("cad_names");
  const fs::path first = written(folder / "a.step", painted("block", drilled_block()));
  const CadContents before = read_cad_contents(first);
  CHECK(before.format == "STEP AP214");
  CHECK(before.unit_stated);
  REQUIRE(before.products.size() == 1);
  CHECK(before.products[0].name == "block");
  CHECK(before.solids == 1);
  CHECK(before.faces == 7);
  CHECK(before.volume == Approx(40 * 30 * 20 - std::acos(-1.0) * 25 * 20).epsilon(1e-9));
  CHECK(faces_by_name(before.names).size() == 7);
  CHECK(faces_by_name(before.colours) ==
        std::map<std::string, int>{{"#ff0000", 4}, {"#00ff00", 3}});

  convert_cad(first, folder / "b.iges");
  CadConvertOptions ap242;
  ap242.ap242 = true;
  convert_cad(folder / "b.iges", folder / "c.step", ap242);
  convert_cad(folder / "c.step", folder / "d.stp");
  for (const char* name : {"b.iges", "c.step", "d.stp"}) {
    INFO(name);
    const CadContents after = read_cad_contents(folder / name);
    check_same(before, after);
    CHECK(faces_by_name(after.names) == faces_by_name(before.names));
    CHECK(faces_by_name(after.colours) == faces_by_name(before.colours));
  }
  CHECK(read_cad_contents(folder / "c.step").format == "STEP AP242");
  CHECK(read_cad_contents(folder / "d.stp").format == "STEP AP214");
}

TEST_CASE("names in other alphabets survive in STEP", "[io][cad]") {
  const fs::path folder = scratch("cad_letters");
  CadPart part = painted("Tür", drilled_block());
  part.faces[0].name = "Größe 山";
  const CadContents read = read_cad_contents(written(folder / "a.step", part));
  CHECK(read.products.at(0).name == "Tür");
  CHECK(faces_by_name(read.names).count("Größe 山") == 1);
}

TEST_CASE("an assembly keeps its instances, their positions and layers in STEP, its solids in IGES",
          "[io][cad]") {
  const fs::path folder = scratch("cad_assembly");
  TopoDS_Shape whole;
  const auto document = pair_of_blocks(whole);
  const fs::path first = written(folder / "a.step", document, whole);
  convert_cad(first, folder / "b.step");
  for (const char* name : {"a.step", "b.step"}) {
    INFO(name);
    const CadContents c = read_cad_contents(folder / name);
    REQUIRE(c.products.size() == 3);
    CHECK(c.products[0].name == "pair");
    CHECK(c.products[0].assembly);
    CHECK(c.products[1].name == "block");
    CHECK(c.products[1].instance_name == "left");
    CHECK(c.products[2].instance_name == "right");
    CHECK(c.products[1].translation.isZero());
    CHECK((c.products[2].translation - Vec3(100, 20, 5)).norm() < 1e-9);
    CHECK(c.products[2].rotation_deg == Approx(30));
    CHECK(c.solids == 2);
    CHECK(faces_by_name(c.names).at("face 3") == 2);
    REQUIRE(c.layers.size() == 1);
    CHECK(c.layers[0].name == "metal");
  }
  const CadConversion iges = convert_cad(first, folder / "c.iges");
  check_same(iges.before, iges.after);
  CHECK(faces_by_name(iges.after.names) == faces_by_name(iges.before.names));
  REQUIRE(iges.notes.size() == 1);
  CHECK_THAT(iges.notes[0], Contains("IGES has no assemblies"));
}

TEST_CASE("the same part in mm, m and inches has the same geometry, and files declare their unit",
          "[io][cad]") {
  const fs::path folder = scratch("cad_units");
  const CadPart part = painted("block", drilled_block());
  const fs::path first = written(folder / "mm.step", part);
  const auto reference = read_cad_lines(first, 1e-3);
  for (const std::string ending : {".step", ".iges"})
    for (const auto& [unit, metres] : {std::pair("m", 1.0), std::pair("in", 0.0254)}) {
      const fs::path file = folder / (std::string(unit) + ending);
      INFO(file);
      CadConvertOptions options;
      options.unit_in_metres = metres;
      const CadConversion c = convert_cad(first, file, options);
      CHECK(c.after.unit_in_metres == Approx(metres).epsilon(1e-12));
      CHECK(c.after.unit_stated);
      check_same(c.before, c.after);
      CHECK(format_unit(c.after.unit_in_metres) == unit);
      const auto lines = read_cad_lines(file, 1e-3);
      REQUIRE(lines.size() >= reference.size());
      double largest = 0;
      for (const auto& line : reference) {
        const Vec3 p = line.curve->evaluate(line.curve->start());
        double nearest = 1e9;
        for (const auto& other : lines)
          for (const double t : {other.curve->start(), other.curve->end()})
            nearest = std::min(nearest, (other.curve->evaluate(t) - p).norm());
        largest = std::max(largest, nearest);
      }
      CHECK(largest < 1e-7);
      // And written directly in that unit.
      const CadContents direct = read_cad_contents(
          written(folder / (std::string("direct_") + unit + ending), part, metres));
      CHECK(direct.size == Approx(c.after.size).epsilon(1e-9));
    }
}

TEST_CASE("a STEP file without a unit is reported to be in mm", "[io][cad]") {
  const fs::path folder = scratch("cad_no_unit");
  const fs::path first = written(folder / "a.step", painted("block", drilled_block()));
  std::ostringstream text;
  text << std::ifstream(first).rdbuf();
  std::string changed = text.str();
  const size_t at = changed.find("GLOBAL_UNIT_ASSIGNED_CONTEXT");
  REQUIRE(at != std::string::npos);
  const size_t end = changed.find("))", at);
  changed.replace(at, end - at + 2, "GLOBAL_UNIT_ASSIGNED_CONTEXT(())");
  std::ofstream(folder / "b.step") << changed;
  const CadContents c = read_cad_contents(folder / "b.step");
  CHECK_FALSE(c.unit_stated);
  REQUIRE(c.notes.size() == 1);
  CHECK_THAT(c.notes[0], Contains("no length unit: assumed mm"));
}

TEST_CASE("BREP is read wherever STEP is, and loses names only", "[io][cad]") {
  const fs::path folder = scratch("cad_brep");
  const fs::path step = written(folder / "a.step", painted("block", drilled_block()));
  const CadConversion c = convert_cad(step, folder / "a.brep");
  check_same(c.before, c.after);
  CHECK(c.after.names.empty());
  CHECK(c.after.format == "BREP");
  REQUIRE(c.notes.size() == 1);
  CHECK_THAT(c.notes[0], Contains("names, colours, layers and products are lost"));
  const fs::path brep = folder / "a.brep";
  CHECK(read_cad_lines(brep, 1e-3).size() == read_cad_lines(step, 1e-3).size());
  const auto faces = read_cad_surfaces(brep, 1e-2);
  REQUIRE(faces.size() == 7);
  size_t first = 0;
  CHECK(distance(faces, Vec3(2, 1.5, 1), first) == Approx(0.5));  // from the axis of the hole
  CHECK(measure_continuity(brep, 1e-3).free_edges == 0);
  // In inches its numbers are 25.4 times smaller; the format cannot store the unit.
  CadConvertOptions inches;
  inches.unit_in_metres = 0.0254;
  convert_cad(step, folder / "in.brep", inches);
  CHECK(read_cad_contents(folder / "in.brep").size * 25.4 == Approx(c.before.size).epsilon(1e-9));
}

TEST_CASE("BREP in binary form is read as its text is", "[io][cad]") {
  const SandboxScope child;
  const fs::path folder = scratch("cad_binary");
  const TopoDS_Shape shape = drilled_block();
  written(folder / "text.brep", painted("block", shape));
  {
    std::ofstream out(folder / "binary.brep", std::ios::binary);
    BinTools::Write(shape, out);
  }
  const CadContents text = read_cad_contents(folder / "text.brep"),
                    binary = read_cad_contents(folder / "binary.brep");
  CHECK(binary.format == text.format);
  check_same(text, binary);
  CHECK(binary.volume == Approx(text.volume).epsilon(1e-12));
  const auto a = read_cad_lines(folder / "text.brep", 1e-3),
             b = read_cad_lines(folder / "binary.brep", 1e-3);
  REQUIRE(a.size() == b.size());
  for (size_t i = 0; i < a.size(); ++i)
    CHECK((a[i].curve->evaluate(a[i].curve->start()) - b[i].curve->evaluate(b[i].curve->start()))
              .norm() < 1e-13);
  const CadConversion c = convert_cad(folder / "binary.brep", folder / "a.step");
  check_same(c.before, c.after);
}

TEST_CASE("a conversion that fails leaves nothing, and keeps an older file", "[io][cad]") {
  const fs::path folder = scratch("cad_refused");
  std::ofstream(folder / "bad.step") << "ISO-10303-21;\nHEADER;\nENDSEC;\nEND-ISO-10303-21;\n";
  std::ofstream(folder / "old.iges") << "old";
  CHECK_THAT(error_message([&] { convert_cad(folder / "bad.step", folder / "old.iges"); }),
             Contains("bad.step"));
  CHECK(fs::file_size(folder / "old.iges") == 3);
  CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 2);
  const fs::path step = written(folder / "a.step", painted("block", drilled_block()));
  CHECK_THAT(error_message([&] { convert_cad(step, folder / "a.sldprt"); }), Contains("'.sldprt'"));
  CadConvertOptions fathoms;
  fathoms.unit_in_metres = 1.8288;
  CHECK_THAT(error_message([&] { convert_cad(step, folder / "a.iges", fathoms); }),
             Contains("expected one of um, mm"));
  CHECK_FALSE(fs::exists(folder / "a.iges"));
}
