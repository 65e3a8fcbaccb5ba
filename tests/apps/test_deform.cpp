// SPDX-License-Identifier: MPL-2.0
// batten deform on the command line.
#include <cmath>
#include <numbers>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten_test;

namespace {

const std::string kPlate = BATTEN_SOURCE_DIR "/examples/10-plate-with-holes/";
const std::string kPanel = BATTEN_SOURCE_DIR "/examples/11-panel/";

std::string without_pictures(const std::string& file) {
  std::string text = contents(file);
  return text.substr(0, text.find("[[picture]]"));
}

/// A square of 4 × 4 quads in [0, 4]², with a scene that lacks only its edits.
const std::string kHead =
    "unit = \"mm\"\nmesh = \"grid.off\"\n"
    "[[select]]\nname = \"left\"\nbox = [[0,0,-1],[0,4,1]]\n"
    "[[select]]\nname = \"right\"\nbox = [[4,0,-1],[4,4,1]]\n";
const std::string kMove =
    "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
    "translate = [0, 0, 1]\n";

void put_grid(const CliCase& c) {
  std::string off = "OFF\n25 16 0\n";
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) off += std::to_string(i) + " " + std::to_string(j) + " 0\n";
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const int a = 5 * j + i;
      off += "4 " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 6) +
             " " + std::to_string(a + 5) + "\n";
    }
  c.file("grid.off", off);
}

}  // namespace

TEST_CASE("the plate's tutorials pass their checks", "[apps][deform]") {
  // The file of the example is the model of the tests.
  const CliCase c("deform_plate");
  batten::write_mesh(c / "plate.obj", plate_with_holes().shells);
  CHECK(contents(c / "plate.obj") == contents(kPlate + "plate.obj"));
  for (const std::string name :
       {"free", "turned", "stretched", "direction", "plane", "line", "line-turning"}) {
    INFO(name);
    c.file(name + ".toml", without_pictures(kPlate + name + ".toml"));
    const CliResult r = c.run({"deform", name + ".toml", "--out", name});
    CHECK(r.code == 0);
    CHECK(r.err.empty());
    const auto j = report(c, name);
    CHECK(j["hard_constraints"]["max_residual"].get<double>() < 1e-13);
    CHECK(j["failed_checks"].empty());
    CHECK(j["features"].size() == (name == "free" ? 0 : 5));
    for (const auto& f : j["features"]) CHECK(f["max_rigid_error"].get<double>() < 1e-13);
    double out_of_round = 0;
    for (const auto& h : j["holes"]) {
      if (h["nodes"] == 200) continue;  // the outer boundary
      const auto &before = h["before"], &after = h["after"];
      out_of_round =
          std::max(out_of_round, after["roundness"].get<double>() / before["radius"].get<double>());
      if (name != "free")
        CHECK(std::abs(after["radius"].get<double>() / before["radius"].get<double>() - 1) < 1e-12);
    }
    CHECK((out_of_round > 0.01) == (name == "free"));
    CHECK(j["displacement"]["largest"].get<double>() > 80);
    CHECK(fs::exists(c / (name + "/" + name + ".obj")));
    CHECK(fs::exists(c / (name + "/" + name + ".vtp")));
  }
}

TEST_CASE("the panel's deck comes back with other coordinates and nothing else", "[apps][deform]") {
  const CliCase c("deform_panel");
  fs::copy(kPanel + "panel.bdf", c / "panel.bdf");
  c.file("edit.toml", without_pictures(kPanel + "edit.toml"));
  const CliResult r = c.run({"run", "edit.toml", "--out", "out"});  // `run` accepts edits, too
  REQUIRE(r.code == 0);
  CHECK(r.err.find("large_field") != std::string::npos);
  std::istringstream before(contents(c / "panel.bdf")), after(contents(c / "out/panel-longer.bdf"));
  int changed = 0;
  for (std::string a, b; std::getline(before, a);) {
    REQUIRE(std::getline(after, b));
    REQUIRE(a.size() == b.size());
    if (a == b) continue;
    ++changed;
    CHECK(a.starts_with("GRID    "));
    CHECK(a.substr(0, 24) == b.substr(0, 24));
  }
  CHECK(after.peek() == EOF);
  CHECK(changed > 5000);
  // The written file keeps the shape of holes within the rounding of eight columns.
  const auto file = batten::MeshFile::read(c / "out/panel-longer.bdf");
  const auto mesh = batten::prepare(file.shells()).mesh;
  const auto j = report(c, "out");
  int round = 0;
  for (const auto& h : j["holes"]) {
    if (!h["before"]["circular"]) continue;
    ++round;
    const auto m = batten::measure_hole(mesh.points(),
                                        mesh.topology().boundary_loops()[h["loop"].get<int>() - 1]);
    CHECK(m.radius == Approx(h["before"]["radius"].get<double>()).epsilon(1e-5));
    CHECK(m.roundness < 2e-4);
  }
  CHECK(round == 4);
  CHECK(j["edits"].size() == 2);
  CHECK(j["edits"][0]["moving_nodes"].get<int>() < 1000);
  for (const auto& edit : j["edits"]) {
    CHECK(edit["unknowns"].get<int>() > 0);
    CHECK(edit["unknowns"].get<int>() <= edit["moving_nodes"].get<int>());
    CHECK(edit["feature_constraints"].get<int>() > 0);
    CHECK(edit["feature_constraints"].get<int>() <= edit["hard_constraints"].get<int>());
    CHECK(edit["hard_residual"].get<double>() < 1e-12);
    CHECK(edit["last_correction"].get<double>() < 1e-9);
    CHECK(edit["converged"].get<bool>());
    CHECK(edit["setup_s"].get<double>() > 0);
    CHECK(edit["edit_s"].get<double>() > 0);
  }
  for (const char* deck : {"out/before.inp", "out/after.inp"})
    CHECK(contents(c / deck).find("*FREQUENCY") != std::string::npos);

  // Large field format: two lines per node, sixteen columns per number.
  c.file("wide.toml", without_pictures(kPanel + "edit.toml") + "\n");
  std::string wide = contents(c / "wide.toml");
  wide.insert(wide.find("[output]") + 9, "large_field = true\n");
  c.file("wide.toml", wide);
  REQUIRE(c.run({"deform", "wide.toml", "--out", "wide"}).code == 0);
  CHECK(report(c, "wide")["file_rounding"].get<double>() < 1e-9);
}

TEST_CASE("door, grill and sheet pass their checks, and their files are the models",
          "[apps][deform]") {
  const CliCase c("deform_parts");
  const std::string folder = BATTEN_SOURCE_DIR "/examples/12-door-grill-sheet/";
  for (const auto& [name, model] :
       {std::pair{"door", door_panel()}, {"grill", grill()}, {"sheet", sheet_with_cavities()}}) {
    batten::write_mesh(c / (std::string(name) + ".obj"), model.shells);
    CHECK(contents(c / (std::string(name) + ".obj")) == contents(folder + name + ".obj"));
  }
  for (const std::string name : {"door-free", "door", "grill", "sheet-free", "sheet"}) {
    INFO(name);
    c.file(name + ".toml", without_pictures(folder + name + ".toml"));
    REQUIRE(c.run({"deform", name + ".toml", "--out", name}).code == 0);
    const auto j = report(c, name);
    CHECK(j["features"].size() == (name.ends_with("free") ? 0
                                   : name == "door"       ? 3
                                   : name == "grill"      ? 21
                                                          : 16));
    for (const auto& f : j["features"]) {
      CHECK(f["max_rigid_error"].get<double>() < 1e-13);
      CHECK(f["scale"].get<double>() == Approx(name == "grill" ? 1.1 : 1).epsilon(1e-12));
      if (name == "grill") CHECK(f["rotation_deg"].get<double>() < 1e-6);
      if (name == "sheet") CHECK(f["rotation_deg"].get<double>() > 5);
    }
  }
}

TEST_CASE("the same mesh in every format gives the same result", "[apps][deform]") {
  const CliCase c("deform_formats");
  const auto model = plate_with_holes();
  double expected = 0;
  for (const std::string ending : {"obj", "off", "ply", "vtp", "vtu", "stl"}) {
    batten::write_mesh(c / ("plate." + ending), model.shells);
    std::string text = without_pictures(kPlate + "turned.toml");
    text.replace(text.find("plate.obj"), 9, "plate." + ending);
    text = text.substr(0, text.find("[output]"));
    c.file(ending + ".toml", text);
    INFO(ending);
    const CliResult r = c.run({"deform", ending + ".toml", "--out", ending});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const double moved = report(c, ending)["displacement"]["largest"];
    if (expected == 0) expected = moved;
    // STL: single precision; quads become triangles.
    CHECK(moved == Approx(expected).epsilon(ending == "stl" ? 2e-2 : 1e-9));
    CHECK(fs::exists(c / (ending + "/plate-deformed." + ending)));
    batten::MeshFile::read(c / (ending + "/plate-deformed." + ending));
  }
}

TEST_CASE("constraints in conflict: exit 2, all of them named, nothing written", "[apps][deform]") {
  const CliCase c("deform_conflict");
  put_grid(c);
  const std::string strut =
      "[[select]]\nname = \"strut\"\nbox = [[0,2,0],[4,2,0]]\n"
      "[[feature]]\nname = \"strut\"\n";
  c.fails(kHead + strut + kMove, 2, {"'fixed'", "'right'", "'strut'"}, {}, "deform");
  c.fails(kHead + strut +
              "[[constraint]]\nname = \"g\"\nof = \"left\"\n"
              "plane = { normal = [0,0,1], origin = [0,0,3] }\n" +
              "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n",
          2, {"'g'", "'fixed'"}, {}, "deform");
}

TEST_CASE("invalid scenes of edits: exit 1, the position, what was expected", "[apps][deform]") {
  const CliCase c("deform_bad");
  put_grid(c);
  const auto fails = [&](const std::string& scene, const std::vector<std::string>& parts) {
    c.fails(scene, 1, parts, {}, "deform");
  };
  fails("", {"s.toml:1:1", "empty file"});
  fails("unit = \"mm\"\n", {"mesh"});
  fails(kHead, {"[[edit]]"});
  fails(kHead + kMove + "[output]\nmesh = \"a.obj\"\n", {"a.obj", ".off"});
  fails(kHead + kMove + "[output]\nmesh = \"../a.off\"\n", {"without folders"});
  fails("unit = \"mm\"\nmesh = \"none.off\"\n" + kMove, {"none.off"});
  fails(kHead + "[[edit]]\nfixed = \"lefft\"\n", {"s.toml:10", "'lefft'", "did you mean 'left'"});
  fails(kHead + "[[edit]]\nname = \"nothing\"\n", {"found no fixed nodes and no handles"});
  fails(
      kHead + "[[select]]\nname = \"far\"\nbox = [[9,9,9],[10,10,10]]\n[[edit]]\nfixed = \"far\"\n",
      {"found the selection 'far' without nodes"});
  fails(kHead +
            "[[select]]\nname = \"a\"\nany = \"b\"\n[[select]]\nname = \"b\"\nany = \"a\"\n"
            "[[edit]]\nfixed = \"a\"\n",
        {"in its own definition"});
  fails(kHead + "[[select]]\nname = \"l\"\nloop = 3\n[[edit]]\nfixed = \"l\"\n",
        {"loop 3", "1 to 1"});
  fails(kHead + "[[select]]\nname = \"n\"\nnodes = [99]\n[[edit]]\nfixed = \"n\"\n", {"node 99"});
  fails(kHead + "[[select]]\nname = \"n\"\nset = \"S\"\n[[edit]]\nfixed = \"n\"\n",
        {"the set 'S'", "it has none"});
  fails(kHead + "[[features]]\nof = \"hole-*\"\n" + kMove, {"which matches no name"});
  fails(kHead + "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\nscale = 0\n",
        {"scale"});
  fails(kHead + "[[edit]]\nfixed = \"left\"\n[[edit.scale]]\nfeature = \"x\"\nfactor = 2\n",
        {"'x'"});
  fails(kHead + "[[cut]]\nname = \"c\"\nband = \"left\"\n[[feature]]\nname = \"c\"\n" + kMove,
        {"the cut 'c'", "the band has no triangles"});
  fails(kHead + kMove + "[[featur]]\n", {"'featur'", "did you mean 'feature'"});
  fails(kHead + kMove +
            "[modes]\nthickness = 1\nyoung = 1\npoisson = 0.7\ndensity = 1\n"
            "after = \"a.inp\"\n",
        {"0.7"});
  c.fails(kHead + kMove, 1, {"'edit-1.right.w'", "edit-1.right.x"}, {"--set", "edit-1.right.w=3"},
          "deform");
  // A mesh that cannot be deformed.
  c.file("grid.off", "OFF\n5 2 0\n0 0 0\n4 0 0\n0 1 0\n0 -1 0\n2 0 0\n3 0 1 2\n3 0 1 4\n");
  fails(kHead + kMove, {"grid.off", "without area"});
  put_grid(c);
  std::string nan = contents(c / "grid.off");
  nan.replace(nan.find("2 2 0"), 5, "2 nan 0");
  c.file("grid.off", nan);
  fails(kHead + kMove, {"grid.off"});
}

TEST_CASE("parameters are set from outside, an edit that folds the mesh is reported",
          "[apps][deform]") {
  const CliCase c("deform_set");
  put_grid(c);
  c.file("s.toml", kHead + kMove);
  REQUIRE(c.run({"deform", "s.toml", "--out", "a", "--set", "edit-1.right.z=3", "--set",
                 "edit-1.right.angle=0"})
              .code == 0);
  CHECK(report(c, "a")["displacement"]["largest"].get<double>() == Approx(3));
  const CliResult info = c.run({"info", "s.toml"});
  CHECK(info.code == 0);
  CHECK(info.out.find("edit-1.right.z = 1") != std::string::npos);
  CHECK(info.out.find("loop 1: 16 nodes") != std::string::npos);
  // The handle moves beyond the fixed strip.
  c.file("s.toml", kHead + "[[select]]\nname = \"strip\"\nany = \"left\"\ngrow = 1\n" +
                       "[[edit]]\nfixed = \"strip\"\n[[edit.handle]]\nname = \"right\"\n");
  const CliResult folded = c.run({"deform", "s.toml", "--out", "b", "--set", "edit-1.right.x=-9",
                                  "--set", "edit-1.right.z=0"});
  CHECK(folded.code == 4);
  CHECK(folded.err.find("quality.inverted") != std::string::npos);
  CHECK(fs::exists(c / "b/grid-deformed.off"));
}

TEST_CASE("selections contain the specified nodes", "[apps][deform]") {
  const CliCase c("deform_select");
  put_grid(c);
  const auto moved = [&](const std::string& rule) {
    c.file("ids.txt", "6, 7 # two of them\n8\n");
    c.file("s.toml", kHead + "[[select]]\nname = \"it\"\n" + rule +
                         "\n[[edit]]\nfixed = \"it\"\n[[edit.handle]]\nname = \"h\"\n"
                         "vertices = \"all\"\ntranslate = [0,0,1]\n"
                         "[[select]]\nname = \"all\"\nexcept = \"it\"\n");
    const CliResult r = c.run({"deform", "s.toml", "--out", "o"});
    INFO(r.err);
    REQUIRE((r.code == 0 || r.code == 4));
    const auto file = batten::MeshFile::read(c / "o/grid-deformed.off");
    std::vector<int> still;
    for (int v = 0; v < 25; ++v)
      if (file.shells().points(v, 2) == 0) still.push_back(v);
    return still;
  };
  using V = std::vector<int>;
  CHECK(moved("nodes = [0, 24]") == V{0, 24});
  CHECK(moved("file = \"ids.txt\"") == V{6, 7, 8});
  CHECK(moved("sphere = { centre = [2, 2, 0], radius = 1 }") == V{7, 11, 12, 13, 17});
  CHECK(moved("plane = { origin = [3, 0, 0], normal = [1, 0, 0] }\nbox = [[0,0,0],[4,1,0]]") ==
        V{3, 4, 8, 9});
  CHECK(moved("geodesic = { node = 0, distance = 1.1 }") == V{0, 1, 5});
  CHECK(moved("geodesic = { point = [4, 4, 0], distance = 1.1 }") == V{19, 23, 24});
  CHECK(moved("any = [\"left\", \"right\"]\nexcept = \"left\"") == V{4, 9, 14, 19, 24});
  CHECK(moved("nodes = [0]\ngrow = 1") == V{0, 1, 5, 6});
  CHECK(moved("loop = 1").size() == 16);
}

TEST_CASE("Abaqus and LS-DYNA decks: properties and sets are selections, coordinates change only",
          "[apps][deform]") {
  const CliCase c("deform_decks");
  const auto model = plate_with_holes();
  const auto& shells = model.shells;
  std::vector<int> pid(shells.face_count(), 1);
  for (size_t part = 0; part < model.parts.size(); ++part)
    for (const int f : model.parts[part].items) pid[f] = static_cast<int>(part) + 1;
  char text[128];
  std::string inp = "** a plate\n*HEADING\nplate\n*NODE, NSET=NALL\n";
  std::string key = "$ a plate\n*KEYWORD\n*TITLE\nplate\n*NODE\n$#   nid               x\n";
  for (int v = 0; v < shells.node_count(); ++v) {
    const auto p = shells.points.row(v);
    std::snprintf(text, sizeof text, "%d, %.6f, %.6f, %.6f\n", 10 * v + 7, p[0], p[1], p[2]);
    inp += text;
    std::snprintf(text, sizeof text, "%8d%16.9g%16.9g%16.9g%8d%8d\n", 10 * v + 7, p[0], p[1], p[2],
                  0, 0);
    key += text;
  }
  key += "*ELEMENT_SHELL\n";
  std::string sections, parts;
  for (size_t part = 1; part <= model.parts.size(); ++part) {
    const std::string id = std::to_string(part);
    inp += "*ELEMENT, TYPE=S4, ELSET=P" + id + "\n";
    for (int f = 0; f < shells.face_count(); ++f)
      if (pid[f] == static_cast<int>(part)) {
        inp += std::to_string(f + 1);
        for (const int v : shells.face(f)) inp += ", " + std::to_string(10 * v + 7);
        inp += "\n";
      }
    sections += "*SHELL SECTION, ELSET=P" + id + ", MATERIAL=STEEL\n0.8\n";
    parts += "*PART\npart " + id + "\n" + std::string(9, ' ') + id + "         1         1\n";
  }
  inp += "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.85e-9\n" + sections +
         "*NSET, NSET=LEFT\n";
  std::string left = "*SET_NODE_LIST\n         1\n";
  for (size_t i = 0; i < model.fixed.size(); ++i) {
    inp += std::to_string(10 * model.fixed[i] + 7) + "\n";
    std::snprintf(text, sizeof text, "%10d%s", 10 * model.fixed[i] + 7, i % 8 == 7 ? "\n" : "");
    left += text;
  }
  inp += "*BOUNDARY\nLEFT, 1, 6\n*STEP\n*FREQUENCY\n2\n*END STEP\n";
  for (int f = 0; f < shells.face_count(); ++f) {
    std::snprintf(text, sizeof text, "%8d%8d%8d%8d%8d%8d\n", f + 1, pid[f],
                  10 * shells.face(f)[0] + 7, 10 * shells.face(f)[1] + 7,
                  10 * shells.face(f)[2] + 7, 10 * shells.face(f)[3] + 7);
    key += text;
  }
  key += parts + left + "\n*END\n";
  c.file("plate.inp", inp);
  c.file("plate.k", key);
  for (const std::string ending : {"inp", "k"}) {
    INFO(ending);
    const std::string set = ending == "inp" ? "LEFT" : "1", property = ending == "inp" ? "P1" : "1";
    c.file("s.toml", "unit = \"mm\"\nmesh = \"plate." + ending +
                         "\"\n[[select]]\nname = \"left\"\nset = \"" + set +
                         "\"\n[[select]]\nname = \"sheet\"\nproperty = \"" + property +
                         "\"\n[[select]]\nname = \"right\"\nany = \"sheet\"\n"
                         "box = [[299, 0, -1], [300, 300, 1]]\n[[features]]\nof = \"hole-*\"\n"
                         "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
                         "translate = [0, 0, 40]\n");
    const CliResult r = c.run({"deform", "s.toml", "--out", ending});
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(report(c, ending)["features"].size() == 5);
    std::istringstream before(ending == "inp" ? inp : key);
    std::istringstream after(contents(c / (ending + "/plate-deformed." + ending)));
    int changed = 0, row = 0, first = 0, last = 0;
    for (std::string a, b; std::getline(before, a);) {
      ++row;
      REQUIRE(std::getline(after, b));
      if (a == b) continue;
      if (changed++ == 0) first = row;
      last = row;
      if (ending == "k")
        CHECK((a.size() == b.size() && a.substr(0, 8) == b.substr(0, 8) &&
               a.substr(56) == b.substr(56)));
      if (ending == "inp") CHECK(a.substr(0, a.find(',')) == b.substr(0, b.find(',')));
    }
    CHECK(after.peek() == EOF);
    CHECK(changed > 2000);
    CHECK(last - first < shells.node_count());  // the block of nodes
    // Exact if the fields are wide enough.
    const double rounding = report(c, ending)["file_rounding"];
    CHECK((ending == "inp" ? rounding < 1e-12 : rounding < 1e-6));
  }
}

TEST_CASE("a feature cut out of a band by the program", "[apps][deform]") {
  const CliCase c("deform_cut");
  batten::write_mesh(c / "sheet.obj", sheet_with_cavities().shells);
  const auto scene = [](const std::string& cut) {
    return "unit = \"mm\"\nmesh = \"sheet.obj\"\n"
           "[[select]]\nname = \"outer\"\nsphere = { centre = [150, 150, 0], radius = 38 }\n"
           "[[select]]\nname = \"floor\"\nsphere = { centre = [150, 150, -8], radius = 16 }\n"
           "[[select]]\nname = \"band\"\nany = \"outer\"\nexcept = \"floor\"\n" +
           cut +
           "[[feature]]\nname = \"cavity\"\n"
           "[[select]]\nname = \"left\"\nbox = [[-1,-1,-1],[1,401,1]]\n"
           "[[select]]\nname = \"right\"\nbox = [[399,-1,-1],[401,401,1]]\n"
           "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\ntranslate = [0,0,60]\n";
  };
  c.file("s.toml", scene("[[cut]]\nname = \"cavity\"\nband = \"band\"\nconvex = 1\n"));
  const CliResult r = c.run({"deform", "s.toml", "--out", "o"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "o");
  CHECK(j["features"][0]["nodes"].get<int>() > 30);
  CHECK(j["features"][0]["max_rigid_error"].get<double>() < 1e-13);
  c.fails(scene("[[cut]]\nname = \"cavity\"\nband = \"outer\"\n"), 1,
          {"the cut 'cavity'", "the band separates 1 part"}, {}, "deform");
}

TEST_CASE(
    "a curve drives its vertices exactly, by its loads and parameters, and errors are reported",
    "[apps][deform]") {
  const CliCase c("deform_curve");
  put_grid(c);
  const std::string curve =
      "[[curve]]\nname = \"rib\"\nnodes = [10, 11, 12, 13, 14]\nfaired = false\n"
      "[[curve.spring]]\nname = \"lift\"\nat = [2, 2, 0]\nto = [2, 2, 1]\nstiffness = 1e6\n";
  const std::string edit = "[[edit]]\nfixed = \"left\"\n";
  const auto heights = [&](const std::string& folder) {
    const batten::MeshFile file = batten::MeshFile::read(c / (folder + "/grid-deformed.off"));
    return std::pair(file.shells().points(12, 2), file.shells().points(10, 2));
  };
  c.file("s.toml", kHead + curve + edit);
  CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(heights("out").first == Approx(1).epsilon(1e-3));
  CHECK(std::abs(heights("out").second) < 1e-12);  // clamped
  const auto j = report(c, "out");
  CHECK(j["curves"][0]["max_residual"].get<double>() < 1e-14);
  CHECK(j["curves"][0]["largest_displacement"].get<double>() == Approx(1).epsilon(1e-3));
  // A quarter of it: the spring is as stiff as the curve (192 for a clamped beam), times a third.
  r = c.run({"run", "s.toml", "--out", "soft", "--set", "rib.lift=64"});
  REQUIRE(r.code == 0);
  CHECK(heights("soft").first == Approx(0.25).epsilon(1e-3));
  CHECK(c.run({"info", "s.toml"}).out.find("rib.lift") != std::string::npos);

  const CliCase d("deform_curve_wrong");
  put_grid(d);
  d.fails(kHead + curve + "ends = \"clampd\"\n" + edit, 1, {"'ends'", "spring"});
  d.fails(kHead + "[[curve]]\nname = \"rib\"\n" + edit, 1, {"neither points nor nodes"});
  d.fails(kHead + "[[curve]]\nname = \"rib\"\nnodes = [11, 12, 13]\nends = \"clampd\"\n" + edit, 1,
          {"clamped"});
  d.fails(kHead +
              "[[curve]]\nname = \"rib\"\nnodes = [11, 12, 13]\ndeviation = 1\nwavelength = 2\n" +
              edit,
          1, {"more than one fairing option"});
  d.fails(kHead + curve + edit, 1, {"'rib.lift'", "0"}, {"--set", "rib.lift=-1"});
  // A contradictory constraint on a vertex of the curve is a conflict, and is named.
  d.fails(kHead + curve + "[[position_constraint]]\nname = \"other\"\nnode = 12\nto = [2, 2, 5]\n" +
              edit,
          2, {"'other'", "rib, vertex 3"});
}
