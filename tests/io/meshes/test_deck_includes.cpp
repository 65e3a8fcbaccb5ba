// SPDX-License-Identifier: MPL-2.0
// Decks in several files: read as one, written side by side.
#include <algorithm>

#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

using Files = std::map<std::string, std::string>;

/// Writes files into an empty folder.
fs::path folder_with(const std::string& name, const Files& files) {
  const fs::path folder = scratch(name);
  for (const auto& [file, text] : files) {
    fs::create_directories((folder / file).parent_path());
    std::ofstream(folder / file, std::ios::binary) << text;
  }
  return folder;
}

Files files_in(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = bytes_of(entry.path());
  return files;
}

/// The error of reading a file tree, with "@" for the folder.
std::string read_error_in(const Files& files, const std::string& main) {
  const fs::path folder = folder_with("includes_wrong", files);
  try {
    MeshFile::read(folder / main);
  } catch (const InputError& error) {
    std::string message = error.what();
    for (size_t at; (at = message.find(folder.string())) != message.npos;)
      message.replace(at, folder.string().size(), "@");
    return message;
  }
  return "no mistake";
}

const Files kNastran{
    {"main.bdf",
     "SOL 101\nINCLUDE 'control.txt'\nBEGIN BULK\nINCLUDE 'parts/\n         nodes.bdf'\n"
     "GRID    4               0.      1.      0.\ninclude \"parts/shells.bdf\" $ the shells\n"
     "ENDDATA\n"},
    {"control.txt", "CEND\nTITLE = x\n"},
    {"parts/nodes.bdf",
     "$ nodes\nGRID    1               0.      0.      0.\nINCLUDE more/last.dat\n"
     "GRID    3               1.      1.      0.\n"},
    {"parts/more/last.dat",
     "GRID*                  2                             1.0             0.0"
     "\n*                    0.0\n"},
    {"parts/shells.bdf", "CQUAD4  1       1       1       2       3       4\n"}};

const Files kAbaqus{
    {"main.inp",
     "*HEADING\nx\n*NODE\n*INCLUDE, INPUT=parts/nodes.inp\n3,1.,1.,0.\n*Node, input=\"last.inp\"\n"
     "*include,\ninput=parts/shells.inp\n*STEP\n*END STEP\n"},
    {"parts/nodes.inp", "1,0.,0.,0.\n** a comment\n2,1.,0.,0.\n"},
    {"last.inp", "4,0.,1.,0.\n"},
    {"parts/shells.inp", "*ELEMENT,TYPE=S4\n*INCLUDE,INPUT=parts/element.inp\n"},
    {"parts/element.inp", "1,1,2,3,4\n"}};

const Files kDyna{
    {"main.k",
     "*KEYWORD\n*INCLUDE_PATH\nlib\n*INCLUDE\n$ two files\nparts/nodes.k\npar +\nts/shells.k\n"
     "*NODE\n       4             0.0             1.0             0.0\n*END\n"},
    {"parts/nodes.k",
     "*KEYWORD\n*NODE\n       1             0.0             0.0             0.0\n*INCLUDE "
     "+\nwide.k\n"
     "*NODE\n       3             1.0             1.0             0.0\n*END\nwhat follows\n"},
    {"lib/wide.k",
     "*KEYWORD\n*NODE\n                   2                 1.0                 0.0"
     "                 0.0\n"},
    {"parts/shells.k", "*ELEMENT_SHELL\n       1       1       1       2       3       4\n"}};

}  // namespace

TEST_CASE("included files are read at their position and written beside the deck", "[io][decks]") {
  for (const auto& [main, files, inner] :
       {std::tuple{std::string("main.bdf"), kNastran, std::string("parts/more/last.dat")},
        std::tuple{std::string("main.inp"), kAbaqus, std::string("parts/nodes.inp")},
        std::tuple{std::string("main.k"), kDyna, std::string("lib/wide.k")}}) {
    INFO(main);
    const fs::path folder = folder_with("includes", files), out = scratch("includes_out");
    const MeshFile file = MeshFile::read(folder / main);
    REQUIRE(file.shells().node_count() == 4);
    REQUIRE(file.shells().face_count() == 1);
    for (long label = 1; label <= 4; ++label)
      CHECK(file.shells().points.row(*file.node_of_label(label)) ==
            Vec3(label == 2 || label == 3, label > 2, 0).transpose());
    CHECK(file.included_files().size() + 1 == files.size());
    CHECK(file.warnings() == MeshFile::read(folder / main).warnings());
    // No motion: the same bytes in all files.
    CHECK(file.write(out / main, file.shells().points).largest == 0);
    CHECK(files_in(out) == files);
    // One node moves, then all: only files of moved nodes change.
    Points points = file.shells().points;
    points(*file.node_of_label(2), 2) = 0.25;
    file.write(out / main, points);
    const Files written = files_in(out);
    for (const auto& [name, text] : files) {
      INFO(name);
      CHECK((written.at(name) == text) == (name != inner));
    }
    CHECK(MeshFile::read(out / main).shells().points == points);
    points = moved(file, 0.1, 1);
    const auto rounding = file.write(out / main, points);
    CHECK((MeshFile::read(out / main).shells().points - points).cwiseAbs().maxCoeff() ==
          rounding.largest);
    CHECK(files_in(out).size() == files.size());
  }
}

TEST_CASE("included files: messages name the right file and line", "[io][decks]") {
  Files files = kNastran;
  files["parts/more/last.dat"] = "\nGRID,2,,1.x,0.,0.\n";
  CHECK(read_error_in(files, "main.bdf") ==
        "@/parts/more/last.dat:2:9: found '1.x', expected a number");
  files["parts/more/last.dat"] = "$\nGRID,1,,1.,0.,0.\n";
  CHECK(read_error_in(files, "main.bdf") ==
        "@/parts/more/last.dat:2:6: found node 1 a second time, the first is in line 2 of "
        "@/parts/nodes.bdf");
  files["parts/more/last.dat"] = "INCLUDE '../nodes.bdf'\n";
  CHECK(
      read_error_in(files, "main.bdf") ==
      "@/main.bdf:4: @/parts/nodes.bdf:3: @/parts/more/last.dat:1: found @/parts/nodes.bdf, which "
      "includes itself, expected includes without a cycle");
  files["parts/more/last.dat"] = "$\nINCLUDE 'none.bdf'\n";
  CHECK(
      read_error_in(files, "main.bdf") ==
      "@/main.bdf:4: @/parts/nodes.bdf:3: @/parts/more/last.dat:2: @/parts/more/none.bdf: found no "
      "such file, expected an included file");
  files["parts/more/last.dat"] = "INCLUDE 'none.bdf\n";
  CHECK(read_error_in(files, "main.bdf") ==
        "@/parts/more/last.dat:1:1: found 'INCLUDE 'none.bdf' without its second quote, expected "
        "one");
  Files abaqus = kAbaqus;
  abaqus["parts/element.inp"] = "1,1,2,3,9\n";
  CHECK(read_error_in(abaqus, "main.inp") ==
        "@/parts/element.inp:1:1: found node 9 in element 1, expected the number of a node");
  abaqus["parts/element.inp"] = "*INCLUDE,INPUT=main.inp\n";
  CHECK_THAT(read_error_in(abaqus, "main.inp"), Contains("@/main.inp, which includes itself"));
  abaqus["parts/element.inp"] = "*INCLUDE\n";
  CHECK(read_error_in(abaqus, "main.inp") ==
        "@/parts/element.inp:1:1: found no name of a file, expected one");
  Files dyna = kDyna;
  dyna["lib/wide.k"] = "*KEYWORD I10=Y\n";
  CHECK_THAT(read_error_in(dyna, "main.k"),
             Contains("@/lib/wide.k:1:1: found '*KEYWORD I10=Y' in a file that is included in "
                      "another format"));
}

TEST_CASE("files that include others again and again have an end", "[io][decks]") {
  Files files;
  for (int i = 0; i < 30; ++i) {
    const std::string next = "INCLUDE 'f" + std::to_string(i + 1) + ".bdf'\n";
    files["f" + std::to_string(i) + ".bdf"] = next + next;
  }
  files["f30.bdf"] = "$\n";
  CHECK_THAT(read_error_in(files, "f0.bdf"), Contains("found more files than are followed"));
}

TEST_CASE("included files above the deck's folder keep their place relative to the deck",
          "[io][decks]") {
  const Files tree{{"model/deck/main.bdf",
                    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nINCLUDE '../../shared/node.bdf'\n"
                    "CTRIA3,1,1,1,2,3\nINCLUDE '../material.bdf'\n"},
                   {"shared/node.bdf", "GRID,3,,0.,1.,0.\n"},
                   {"model/material.bdf", "$\n"}};
  const fs::path folder = folder_with("includes_above", tree);
  const MeshFile file = MeshFile::read(folder / "model/deck/main.bdf");
  for (const std::string& warning : file.warnings())
    CHECK(warning.find("not written") == std::string::npos);
  CHECK(file.folder_in_tree() == fs::path("model/deck"));
  Points points = file.shells().points;
  points(2, 2) = 0.5;
  const fs::path out = scratch("includes_above_out");
  fs::create_directories(out / "model/deck");
  file.write(out / "model/deck/main.bdf", points);
  const Files written = files_in(out);
  CHECK(written.at("shared/node.bdf") == "GRID,3,,0.,1.,.5\n");
  CHECK(written.at("model/material.bdf") == tree.at("model/material.bdf"));
  CHECK(MeshFile::read(out / "model/deck/main.bdf").shells().points == points);
  // Beside the old deck, unchanged files are used again, and changed ones refuse.
  CHECK_THROWS_WITH(file.write(folder / "model/deck/new.bdf", points),
                    Contains("node.bdf: found a file of the deck that was read"));
  points = file.shells().points;
  points(0, 2) = 0.5;
  file.write(folder / "model/deck/new.bdf", points);
  Files expected = tree;
  expected["model/deck/new.bdf"] = bytes_of(folder / "model/deck/new.bdf");
  CHECK(files_in(folder) == expected);
  CHECK(MeshFile::read(folder / "model/deck/new.bdf").shells().points == points);
}

TEST_CASE("files that are included by absolute paths stay where they are", "[io][decks]") {
  const fs::path folder = folder_with("includes_absolute", {{"node.bdf", "GRID,3,,0.,1.,0.\n"}});
  std::ofstream(folder / "whole.bdf") << "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nINCLUDE '"
                                      << (folder / "node.bdf").string() << "'\nCTRIA3,1,1,1,2,3\n";
  const MeshFile file = MeshFile::read(folder / "whole.bdf");
  CHECK(file.included_files().empty());
  CHECK(std::any_of(file.warnings().begin(), file.warnings().end(), [](const auto& warning) {
    return warning.find("refers to it by the same name") != warning.npos;
  }));
  Points points = file.shells().points;
  points(2, 2) = 0.5;
  CHECK_THROWS_WITH(file.write(folder / "w.bdf", points), Contains("node.bdf: node 3 moves"));
}

TEST_CASE("a deck of several files is never written over one that was read", "[io][decks]") {
  const fs::path folder = folder_with("includes_over", kNastran);
  const MeshFile file = MeshFile::read(folder / "main.bdf");
  const Points points = moved(file, 0.1, 1);
  CHECK_THROWS_WITH(file.write(folder / "other.bdf", points),
                    Contains("found a file of the deck that was read, expected another folder"));
  CHECK(files_in(folder) == kNastran);
  // Likewise if a program would find it there.
  const fs::path hidden = scratch("includes_over_hidden");
  CHECK_THROWS_WITH(file.write(hidden / "other.bdf", points, {false, folder}),
                    Contains("found a file of the deck that was read, expected another folder"));
  CHECK(files_in(hidden).empty());
  // The deck is not written under the name of a file that it includes.
  const fs::path out = scratch("includes_over_out");
  Files renamed{{"main.bdf", "GRID,1\nGRID,2,,1.\nGRID,3,,,1.\nINCLUDE 'shells.bdf'\n"},
                {"shells.bdf", "CTRIA3,1,1,1,2,3\n"}};
  const MeshFile two = MeshFile::read(folder_with("includes_name", renamed) / "main.bdf");
  CHECK_THROWS_WITH(two.write(out / "shells.bdf", two.shells().points),
                    Contains("found the name of an included file, expected another"));
  CHECK(files_in(out).empty());
}

TEST_CASE("LS-DYNA: *INCLUDE_TRANSFORM is followed where it changes nothing", "[io][decks]") {
  const std::string nodes = "*KEYWORD\n*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n*INCLUDE_TRANSFORM\nnode.k\n";
  const std::string shell = "*ELEMENT_SHELL\n1,1,1,2,3\n*END\n";
  const auto deck = [&](const std::string& cards) {
    return Files{{"main.k", nodes + cards + shell}, {"node.k", "*NODE\n3,0.,1.,0.\n"}};
  };
  CHECK(read_error_in(deck(""), "main.k") == "no mistake");
  CHECK(read_error_in(
            deck("         0         0         0         0         0         0         0\n"
                 "         0\n       1.0       1.0       1.0         1         1\n         0\n"),
            "main.k") == "no mistake");
  CHECK(read_error_in(deck("       100\n"), "main.k") ==
        "@/main.k:7:8: found '100' of *INCLUDE_TRANSFORM, expected an untransformed "
        "include");
  CHECK_THAT(read_error_in(deck("0\n0\n1.,1.,.001\n"), "main.k"), Contains("found '.001' of"));
  CHECK_THAT(read_error_in(deck("0\n0\n1.,1.,1.\n7\n"), "main.k"), Contains("found '7' of"));
}
