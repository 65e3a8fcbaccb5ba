// SPDX-License-Identifier: MPL-2.0
// batten deform: ties, spot welds, adhesives and reference points follow the sheets they belong to.
#include <cmath>
#include <map>
#include <sstream>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/triangle_mesh.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/calculix_decks.h"

using namespace batten_test;
using batten::MeshFile;
using batten::Points;
using batten::Vec3;

namespace {

/// A grid of nodes and quads in a plane z = const, written in the syntax of a deck.
struct Sheet {
  int first_node, first_element, nx, ny;
  double x, y, z, step;

  int node(int i, int j) const { return first_node + i + (nx + 1) * j; }
  template <class Node>
  void nodes(const Node& node_at) const {
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) node_at(node(i, j), Vec3(x + step * i, y + step * j, z));
  }
  template <class Quad>
  void quads(const Quad& quad) const {
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        quad(first_element + i + nx * j,
             std::array{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
  }
  std::string abaqus_nodes() const {
    std::ostringstream text;
    text.precision(17);
    text << "*NODE\n";
    nodes([&](int id, const Vec3& p) {
      text << id << ", " << p.x() << ", " << p.y() << ", " << p.z() << "\n";
    });
    return text.str();
  }
  std::string abaqus_quads(const std::string& set) const {
    std::string text = "*ELEMENT, TYPE=S4, ELSET=" + set + "\n";
    quads([&](int id, const std::array<int, 4>& n) {
      text += std::to_string(id);
      for (const int v : n) text += ", " + std::to_string(v);
      text += "\n";
    });
    return text;
  }
};

const Sheet kBase{1, 1, 40, 12, 0, 0, 0, 5}, kDoubler{2001, 2001, 12, 8, 71, 11, 1.5, 4.7};

std::string tied_deck(const Sheet& base, const Sheet& doubler, const std::string& more) {
  return base.abaqus_nodes() + doubler.abaqus_nodes() + base.abaqus_quads("BASE") +
         doubler.abaqus_quads("DOUBLER") +
         "*SURFACE, NAME=SBASE, TYPE=ELEMENT\nBASE, SPOS\n"
         "*SURFACE, NAME=SDOUB, TYPE=ELEMENT\nDOUBLER, SNEG\n" +
         more;
}

std::string scene(const std::string& deck, const std::string& edit) {
  return "unit = \"mm\"\nmesh = \"" + deck +
         "\"\n[[select]]\nname = \"left\"\nbox = [[-1, -1, -9], [10.1, 99, 9]]\n"
         "[[select]]\nname = \"right\"\nbox = [[194.9, -1, -9], [999, 99, 9]]\n"
         "[[select]]\nname = \"all\"\nbox = [[-1, -1, -9], [999, 99, 9]]\n" +
         edit;
}

const std::string kLiftRight =
    "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\ntranslate = [10, 0, 30]\n";
const std::string kTurnAll =
    "[[edit]]\n[[edit.handle]]\nname = \"all\"\nrotate = { axis = [1, 2, 3], angle = 90 }\n"
    "about = [3, 4, 5]\n";

/// The edited deck, read back.
struct Edited {
  Edited(const CliCase& c, const std::string& deck, const std::string& edit)
      : result(run(c, deck, edit)),
        before(MeshFile::read(c / deck)),
        after(MeshFile::read(c / ("out/" + fs::path(deck).stem().string() + "-deformed" +
                                  fs::path(deck).extension().string()))) {}
  static CliResult run(const CliCase& c, const std::string& deck, const std::string& edit) {
    c.file("edit.toml", scene(deck, edit));
    const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
    INFO(r.out << r.err);
    REQUIRE(r.code == 0);
    return r;
  }
  Vec3 old_place(long label) const {
    return before.shells().points.row(*before.node_of_label(label)).transpose();
  }
  Vec3 place(long label) const {
    return after.shells().points.row(*after.node_of_label(label)).transpose();
  }
  double moved(long label) const { return (place(label) - old_place(label)).norm(); }
  /// Distance of a node from the faces of a sheet after the edit.
  double distance(long label, const Sheet& sheet) const {
    batten::ShellMesh faces;
    faces.points = after.shells().points;
    for (int f = 0; f < after.shells().face_count(); ++f) {
      const long number = after.face_label(f);
      if (number >= sheet.first_element && number < sheet.first_element + sheet.nx * sheet.ny)
        faces.add_face(after.shells().face(f));
    }
    const batten::TriangleTree tree(batten::prepare(faces).mesh);
    return tree.nearest(place(label))->distance;
  }

  CliResult result;
  MeshFile before, after;
};

}  // namespace

TEST_CASE("a doubler that is tied to a sheet goes with it, the gap stays", "[apps][deform]") {
  const CliCase c("tie");
  c.file("tie.inp", tied_deck(kBase, kDoubler,
                              "*TIE, NAME=GLUE, POSITION TOLERANCE=2.\n"
                              "SDOUB, SBASE\n"));
  for (const std::string mode : {"estimated", "harmonic", "nonlinear"}) {
    INFO(mode);
    std::string edit = kLiftRight;
    edit.insert(edit.find("[[edit.handle]]"), "rotation_mode = \"" + mode + "\"\n");
    const Edited e(c, "tie.inp", edit);
    CHECK(e.result.err.find("not moved") == std::string::npos);
    for (int j = 0; j <= kDoubler.ny; j += 2)
      for (int i = 0; i <= kDoubler.nx; i += 3) {
        CHECK(e.moved(kDoubler.node(i, j)) > 1);
        CHECK(e.distance(kDoubler.node(i, j), kBase) == Approx(1.5).margin(0.02));
      }
  }
  const Edited e(c, "tie.inp", kTurnAll);
  for (int i = 0; i <= kDoubler.nx; ++i)
    CHECK(e.distance(kDoubler.node(i, 3), kBase) == Approx(1.5).margin(1e-9));
}

TEST_CASE("features of tied sheets keep their shape, and what is too far is named",
          "[apps][deform]") {
  const CliCase c("tie_feature");
  c.file("tie.inp", tied_deck(kBase, kDoubler, "*TIE, NAME=GLUE\nSDOUB, SBASE\n"));
  const std::string feature =
      "[[select]]\nname = \"patch\"\nbox = [[85, 20, 1], [100, 35, 2]]\n[[feature]]\n"
      "name = \"patch\"\n";
  const Edited e(c, "tie.inp", feature + kLiftRight);
  CHECK(report(c, "out")["features"][0]["max_rigid_error"].get<double>() < 1e-12);
  for (int i = 0; i <= kDoubler.nx; i += 4)
    CHECK(e.distance(kDoubler.node(i, 4), kBase) == Approx(1.5).margin(0.05));

  Sheet far = kDoubler;
  far.z = 30;
  c.file("far.inp", tied_deck(kBase, far, "*TIE, NAME=GLUE\nSDOUB, SBASE\n"));
  const CliResult r = Edited::run(c, "far.inp", kLiftRight);
  CHECK(r.err.find("*TIE GLUE: 117 nodes of 117 not attached, up to 30") != std::string::npos);
}

TEST_CASE("spot welds join their sheets and keep their length", "[apps][deform]") {
  const CliCase c("weld");
  const Sheet lower{1, 1, 32, 8, 0, 0, 0, 5}, upper{2001, 2001, 32, 8, 60, 0, 2, 5};
  std::ostringstream deck;
  deck << "*KEYWORD\n*NODE\n";
  const auto node = [&](int id, const Vec3& p) {
    deck << id << "," << p.x() << "," << p.y() << "," << p.z() << "\n";
  };
  lower.nodes(node);
  upper.nodes(node);
  for (int k = 0; k < 3; ++k) {
    node(5001 + 2 * k, Vec3(82 + 25 * k, 18, 0.1));
    node(5002 + 2 * k, Vec3(82 + 25 * k, 18, 1.9));
  }
  deck << "*ELEMENT_SHELL\n";
  for (const Sheet& sheet : {lower, upper})
    sheet.quads([&](int id, const std::array<int, 4>& n) {
      deck << id << "," << (id < 2000 ? 1 : 2);
      for (const int v : n) deck << "," << v;
      deck << "\n";
    });
  deck << "*ELEMENT_BEAM\n";
  for (int k = 0; k < 3; ++k)
    deck << 9001 + k << ",3," << 5001 + 2 * k << "," << 5002 + 2 * k << ",0\n";
  deck << "*CONTACT_SPOTWELD\n3,11,3,0\n\n\n*END\n";
  c.file("weld.k", deck.str());
  const Edited e(c, "weld.k", kLiftRight);
  for (int k = 0; k < 3; ++k) {
    const long a = 5001 + 2 * k, b = a + 1;
    CHECK(e.moved(a) > 1);
    CHECK((e.place(b) - e.place(a)).norm() == Approx(1.8).margin(1e-9));
    CHECK(e.distance(a, lower) == Approx(0.1).margin(1e-9));
    CHECK(e.distance(b, upper) == Approx(0.1).margin(1e-9));
  }
}

TEST_CASE("adhesive solids carry the second sheet", "[apps][deform]") {
  const CliCase c("adhesive");
  const Sheet lower{1, 1, 40, 8, 0, 0, 0, 5}, upper{2001, 2001, 10, 8, 72, 0, 2, 5};
  const Sheet glue{3001, 3001, 8, 4, 76, 8, 0.4, 4}, glue_top{4001, 0, 8, 4, 76, 8, 1.6, 4};
  std::string solids = "*ELEMENT, TYPE=C3D8, ELSET=GLUE\n";
  glue.quads([&](int id, const std::array<int, 4>& n) {
    solids += std::to_string(id);
    for (const int shift : {0, 1000})
      for (const int v : n) solids += ", " + std::to_string(v + shift);
    solids += "\n";
  });
  c.file("glue.inp", glue.abaqus_nodes() + glue_top.abaqus_nodes() +
                         tied_deck(lower, upper,
                                   solids + "*SURFACE, NAME=BOTTOM\nGLUE, S1\n*SURFACE, NAME=TOP\n"
                                            "GLUE, S2\n*TIE, NAME=A\nBOTTOM, SBASE\n*TIE, NAME=B\n"
                                            "TOP, SDOUB\n"));
  const Edited e(c, "glue.inp", kLiftRight);
  for (int i = 0; i <= upper.nx; i += 2) CHECK(e.moved(upper.node(i, 4)) > 1);
  for (int i = 0; i <= glue.nx; i += 2) {
    CHECK(e.distance(glue.node(i, 2), lower) == Approx(0.4).margin(0.01));
    CHECK(e.distance(glue_top.node(i, 2), upper) == Approx(0.4).margin(0.01));
    CHECK((e.place(glue_top.node(i, 2)) - e.place(glue.node(i, 2))).norm() ==
          Approx(1.2).margin(0.02));
  }
}

TEST_CASE("the reference point of an assembly goes with its coupling", "[apps][deform]") {
  const CliCase c("assembly_point");
  const Sheet sheet{1, 1, 40, 4, 0, 0, 0, 5};
  c.file("cae.inp", "*PART, NAME=P\n" + sheet.abaqus_nodes() + sheet.abaqus_quads("E") +
                        "*NSET, NSET=RIM\n205, 204, 203\n*END PART\n*ASSEMBLY, NAME=A\n"
                        "*INSTANCE, NAME=P-1, PART=P\n*END INSTANCE\n"
                        "*NODE\n1, 210., 10., 15.\n*NSET, NSET=RP\n1,\n"
                        "*NSET, NSET=ENDS, INSTANCE=P-1\n41, 82, 123, 164, 205\n"
                        "*SURFACE, TYPE=NODE, NAME=S\nENDS, 1.\n"
                        "*COUPLING, CONSTRAINT NAME=C, REF NODE=RP, SURFACE=S\n*KINEMATIC\n"
                        "*END ASSEMBLY\n*STEP\n*STATIC\n*CLOAD\nRP, 3, 10.\n*END STEP\n");
  c.file("edit.toml", scene("cae.inp", kLiftRight));
  const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const MeshFile after = MeshFile::read(c / "out/cae-deformed.inp");
  // Numbers of the assembly follow those of the part.
  const Vec3 point = after.shells().points.row(*after.node_of_label(1001)).transpose();
  CHECK((point - Vec3(220, 10, 45)).norm() < 1e-9);
}

TEST_CASE("a relation and the scale of another feature do not contradict each other",
          "[apps][deform]") {
  const CliCase c("relation_scale");
  const std::string plate =
      std::string(BATTEN_SOURCE_DIR) + "/examples/10-plate-with-holes/plate.obj";
  for (const char* move : {"[20, 0, 0]", "[20, 0, 60]", "[-40, 10, 110]"}) {
    INFO(move);
    c.file("edit.toml",
           "unit = \"mm\"\nmesh = \"" + plate +
               "\"\n[[select]]\nname = \"left\"\nbox = [[0, 0, -1], [0, 300, 1]]\ngrow = 1\n"
               "[[select]]\nname = \"right\"\nbox = [[300, 0, -1], [300, 300, 1]]\ngrow = 1\n"
               "[[features]]\nof = [\"hole-*\"]\n[[relation]]\nname = \"r\"\n"
               "type = \"distance\"\nof = [\"hole-1\", \"hole-2\"]\n[[edit]]\nfixed = \"left\"\n"
               "[[edit.handle]]\nname = \"right\"\ntranslate = " +
               move + "\n[[edit.scale]]\nfeature = \"hole-3\"\nfactor = 1.2\n");
    const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
    INFO(r.err);
    CHECK(r.code == 0);
  }
}

TEST_CASE("position constraints alone move a mesh", "[apps][deform]") {
  const CliCase c("pulls");
  const Sheet sheet{1, 1, 40, 4, 0, 0, 0, 5};
  c.file("a.inp", sheet.abaqus_nodes() + sheet.abaqus_quads("E"));
  c.file("edit.toml",
         "unit = \"mm\"\nmesh = \"a.inp\"\n[[position_constraint]]\nname = \"a\"\n"
         "node = 1\nto = [5, 0, 3]\n[[edit]]\n");
  const CliResult r = c.run({"deform", "edit.toml", "--out", "out", "--set", "a.z=4"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const MeshFile after = MeshFile::read(c / "out/a-deformed.inp");
  CHECK((after.shells().points.row(*after.node_of_label(100)) -
         MeshFile::read(c / "a.inp").shells().points.row(99) - Vec3(5, 0, 4).transpose())
            .norm() < 1e-9);
}

TEST_CASE("what nothing connects is named with its number and distance", "[apps][deform]") {
  const CliCase c("left_behind");
  const Sheet sheet{1, 1, 40, 4, 0, 0, 0, 5};
  c.file("a.inp", sheet.abaqus_nodes() + "*NODE\n901, 190., 10., 20.\n902, 2., 10., 3.\n" +
                      sheet.abaqus_quads("E"));
  const CliResult r = Edited::run(c, "a.inp", kLiftRight);
  CHECK(r.err.find("1 node of no element (901) stay") != std::string::npos);
}

TEST_CASE("what hangs on a rigid element of two nodes turns with the shells", "[apps][deform]") {
  // The free turn of the element, about its line, is that of the rotation.
  const CliCase c("two_nodes");
  std::string deck = "BEGIN BULK\n";
  const auto grid = [&](int id, const Vec3& p) {
    deck += "GRID," + std::to_string(id) + ",," + std::to_string(p.x()) + "," +
            std::to_string(p.y()) + "," + std::to_string(p.z()) + "\n";
  };
  const Sheet sheet{1, 1, 4, 4, 0, 0, 0, 5};
  sheet.nodes(grid);
  sheet.quads([&](int id, const std::array<int, 4>& n) {
    deck += "CQUAD4," + std::to_string(id) + ",1";
    for (const int v : n) deck += "," + std::to_string(v);
    deck += "\n";
  });
  grid(901, Vec3(25, 10, 0));
  grid(902, Vec3(25, 10, 6));
  deck += "RBAR,801,15,901,123456\nCBAR,802,2,901,902,1.,0.,0.\nCONM2,803,902,,1.\nENDDATA\n";
  c.file("a.bdf", deck);
  c.file("edit.toml",
         "unit = \"mm\"\nmesh = \"a.bdf\"\n[[select]]\nname = \"shell\"\n"
         "property = \"1\"\n[[edit]]\n[[edit.handle]]\nname = \"shell\"\n"
         "rotate = { axis = [1, 0, 0], angle = 90 }\nabout = [20, 10, 0]\n"
         "[output]\nlarge_field = true\n");
  const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const MeshFile after = MeshFile::read(c / "out/a-deformed.bdf");
  const auto place = [&](long label) {
    return Vec3(after.shells().points.row(*after.node_of_label(label)).transpose());
  };
  CHECK((place(901) - Vec3(25, 10, 0)).norm() < 1e-9);
  CHECK((place(902) - Vec3(25, 4, 0)).norm() < 1e-9);
}

TEST_CASE("no edit changes no byte, whatever the method", "[apps][deform]") {
  const CliCase c("no_edit");
  c.file("tie.inp", tied_deck(kBase, kDoubler, "*TIE, NAME=GLUE\nSDOUB, SBASE\n"));
  const MeshFile mesh = MeshFile::read(c / "tie.inp");
  // Coordinates that no format holds exactly.
  batten::ShellMesh shells = mesh.shells();
  for (int i = 0; i < shells.node_count(); ++i) shells.points(i, 2) += 0.1 * std::sin(0.37 * i);
  std::vector<std::string> names{"tie.inp"};
  for (const char* extension : {".obj", ".off", ".ply", ".stl", ".vtp", ".vtu"}) {
    names.push_back("a" + std::string(extension));
    batten::write_mesh(c / names.back(), shells);
  }
  for (const std::string& name : names)
    for (const std::string mode : {"estimated", "dual", "nonlinear", "harmonic"}) {
      INFO(name << " " << mode);
      c.file("edit.toml",
             scene(name, "[[edit]]\nfixed = \"left\"\nrotation_mode = \"" + mode +
                             "\"\n[[edit.handle]]\nname = \"right\"\ntranslate = [0, 0, 0]\n"
                             "rotate = { axis = [0, 0, 1], angle = 0 }\n"));
      const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
      INFO(r.err);
      REQUIRE(r.code == 0);
      const fs::path file(name);
      CHECK(contents(c / ("out/" + file.stem().string() + "-deformed" +
                          file.extension().string())) == contents(c / name));
    }
}

namespace {

/// Displacements of the nodes of the set TIP by ccx, in global coordinates.
std::map<int, Vec3> displacements_by_ccx(const fs::path& deck) {
  const fs::path folder = deck.parent_path();
  const std::string job = deck.stem().string();
  REQUIRE(std::system(("cd '" + folder.string() + "' && OMP_NUM_THREADS=1 ccx -i " + job +
                       " > ccx.log 2>&1")
                          .c_str()) == 0);
  std::map<int, Vec3> found;
  std::ifstream in(folder / (job + ".dat"));
  for (std::string line; std::getline(in, line);) {
    std::istringstream row(line);
    int node = 0;
    Vec3 u;
    if (row >> node >> u.x() >> u.y() >> u.z()) found[node] = u;
  }
  return found;
}

}  // namespace

TEST_CASE("a whole body that is turned has the same displacements in ccx", "[apps][deform]") {
  if (!have_ccx()) return;
  const CliCase c("turned");
  const Sheet sheet{1, 1, 10, 4, 0, 0, 0, 5};
  // Orthotropic, with a fibre direction; the load along the axes of a transform; beams with a
  // section direction along one edge.
  c.file("body.inp",
         sheet.abaqus_nodes() + sheet.abaqus_quads("E") +
             "*ELEMENT, TYPE=B31, ELSET=B\n901, 1, 2\n902, 2, 3\n903, 3, 4\n904, 4, 5\n"
             "*NSET, NSET=TIP\n11, 22, 33, 44, 55\n*NSET, NSET=ROOT\n1, 12, 23, 34, 45\n"
             "*TRANSFORM, NSET=TIP, TYPE=R\n0.8, 0.6, 0., -0.6, 0.8, 0.\n"
             "*ORIENTATION, NAME=FIBRE\n1., 0.3, 0., 0., 1., 0.\n"
             "*MATERIAL, NAME=PLY\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
             "140000., 9000., 9000., .3, .3, .4, 5000., 5000.,\n3200., 293.\n"
             "*MATERIAL, NAME=ST\n*ELASTIC\n210000., .3\n"
             "*SHELL SECTION, ELSET=E, MATERIAL=PLY, ORIENTATION=FIBRE\n1.\n"
             "*BEAM SECTION, ELSET=B, MATERIAL=ST, SECTION=RECT\n3., 1.\n0., 0.2, 1.\n"
             "*BOUNDARY\nROOT, 1, 6\n*STEP\n*STATIC\n*CLOAD\nTIP, 1, 2.\nTIP, 3, 1.\n"
             "*NODE PRINT, NSET=TIP, GLOBAL=YES\nU\n*END STEP\n");
  const Edited e(c, "body.inp", kTurnAll);
  const batten::Mat3 R = Eigen::AngleAxisd(std::acos(-1) / 2, Vec3(1, 2, 3).normalized()).matrix();
  const auto before = displacements_by_ccx(c / "body.inp"),
             after = displacements_by_ccx(c / "out/body-deformed.inp");
  REQUIRE(before.size() == 5);
  double largest = 0;
  for (const auto& [node, u] : before) largest = std::max(largest, u.norm());
  CHECK(largest > 0.1);
  for (const auto& [node, u] : before) CHECK((after.at(node) - R * u).norm() < 1e-6 * largest);
}
