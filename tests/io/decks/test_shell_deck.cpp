// SPDX-License-Identifier: MPL-2.0
// Decks for frequencies keep the mesh unchanged, and ccx gives the frequencies of plates.
#include "batten/io/decks/calculix_decks.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
namespace fs = std::filesystem;

namespace {

constexpr double kSide = 100;

/// n × n squares, or triangles of them with alternating diagonals.
ShellMesh plate(int n, bool triangles = false) {
  ShellMesh mesh;
  mesh.points.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.points.row(j * (n + 1) + i) << kSide * i / n, kSide * j / n, 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (!triangles) {
        mesh.add_face(std::array{a, b, c, d});
      } else if ((i + j) % 2) {
        mesh.add_face(std::array{a, b, c});
        mesh.add_face(std::array{a, c, d});
      } else {
        mesh.add_face(std::array{a, b, d});
        mesh.add_face(std::array{b, c, d});
      }
    }
  return mesh;
}

std::vector<int> rim(int n) {
  std::vector<int> nodes;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      if (i == 0 || j == 0 || i == n || j == n) nodes.push_back(j * (n + 1) + i);
  return nodes;
}

ModalDeck steel() {
  ModalDeck modes;
  modes.thickness = 1;
  modes.young = 210000;
  modes.poisson = 0.3;
  modes.density = 7.85e-9;
  modes.count = 4;
  modes.units = "mm, N, MPa, t, s";
  return modes;
}

/// Frequency of a plate from λ = ω a² √(ρ t / D), as in Leissa's tables.
double hertz(double lambda) {
  const ModalDeck m = steel();
  const double D = m.young * std::pow(m.thickness, 3) / (12 * (1 - m.poisson * m.poisson));
  return lambda * std::sqrt(D / (m.density * m.thickness)) / (2 * std::numbers::pi * kSide * kSide);
}

/// Data rows of the deck under each keyword line.
std::map<std::string, std::vector<std::string>> sections(const fs::path& path) {
  std::map<std::string, std::vector<std::string>> result;
  std::ifstream in(path);
  std::string keyword;
  for (std::string row; std::getline(in, row);) {
    if (row.starts_with("*")) {
      keyword = row;
      result[keyword];
    } else {
      result[keyword].push_back(row);
    }
  }
  return result;
}

bool have_ccx() {
  if (std::system("command -v ccx >/dev/null && command -v python3 >/dev/null") == 0) return true;
  WARN("ccx or python3 is not installed: decks were written but not run");
  return false;
}

std::vector<double> frequencies(const fs::path& deck) {
  const std::string command =
      "python3 '" BATTEN_SOURCE_DIR "/scripts/ccx_frequencies' '" + deck.string() + "'";
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe);
  std::string output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
  REQUIRE(pclose(pipe) == 0);
  std::vector<double> found;
  std::istringstream tokens(output);
  for (size_t mode; tokens >> mode;) {
    REQUIRE(mode == found.size() + 1);
    tokens >> found.emplace_back();
  }
  return found;
}

std::string message_of(const ShellMesh& mesh, const ModalDeck& modes) {
  try {
    write_modal_deck(batten_test::scratch("modes_errors") / "deck.inp", mesh, modes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a clamped plate has the frequencies of theory", "[io][calculix]") {
  const fs::path path = batten_test::scratch("clamped modes") / "plate.inp";
  ModalDeck modes = steel();
  modes.clamped = rim(14);
  write_modal_deck(path, plate(14), modes);
  CHECK(sections(path).count("** Rigid-body modes: 0") == 1);
  if (!have_ccx()) return;
  const std::array<double, 4> lambda{35.985, 73.394, 73.394, 108.22};
  const auto check = [&](double tolerance) {
    const auto found = frequencies(path);
    REQUIRE(found.size() == 4);
    for (size_t i = 0; i < 4; ++i) CHECK(found[i] == Approx(hertz(lambda[i])).epsilon(tolerance));
  };
  check(0.02);
  write_modal_deck(path, plate(14, true), modes);  // S6
  check(0.05);
  modes.elements = ModalDeck::Elements::Linear;  // S4
  modes.clamped = rim(24);
  write_modal_deck(path, plate(24), modes);
  check(0.025);
}

TEST_CASE("rigid motions of a free plate are not counted", "[io][calculix]") {
  const fs::path path = batten_test::scratch("free modes") / "plate.inp";
  write_modal_deck(path, plate(10), steel());
  CHECK(sections(path).count("** Rigid-body modes: 6") == 1);
  if (!have_ccx()) return;
  const auto found = frequencies(path);
  REQUIRE(found.size() == 4);
  const std::array<double, 4> lambda{13.468, 19.596, 24.270, 34.801};
  for (size_t i = 0; i < 4; ++i) CHECK(found[i] == Approx(hertz(lambda[i])).epsilon(0.01));
}

TEST_CASE("a deck has the mesh's own numbers", "[io][calculix]") {
  // A quad, a triangle written as a quad, a second-order triangle beside them, a collapsed face, a
  // node without a face, a disconnected part.
  ShellMesh mesh;
  mesh.points.resize(13, 3);
  mesh.points << 0, 0, 0, /**/ 1, 0, 0, /**/ 1, 1, 0, /**/ 0, 1, 0, /**/ 2, 0, 0.1,    //
      9, 9, 9, /**/ 0.5, 2, 0, /**/ 0.5, 1, 0.25, /**/ 0.8, 1.5, 0, /**/ 0.2, 1.5, 0,  //
      5, 5, 5, /**/ 6, 5, 5, /**/ 5, 6, 5;
  mesh.add_face(std::array{0, 1, 2, 3});
  mesh.add_face(std::array{1, 4, 2, 2});
  mesh.add_face(std::array{1, 1, 2, 2});
  mesh.add_face(std::array{3, 2, 6, 7, 8, 9}, true);
  mesh.add_face(std::array{10, 11, 12});
  ModalDeck modes = steel();
  modes.clamped = {1, 2, 5};
  const fs::path path = batten_test::scratch("mixed modes") / "deck.inp";
  write_modal_deck(path, mesh, modes);
  auto found = sections(path);
  CHECK(found.at("*ELEMENT,TYPE=S8R,ELSET=ALL") ==
        std::vector<std::string>{"1,1,2,3,4,14,15,8,16"});
  CHECK(found.at("*ELEMENT,TYPE=S6,ELSET=ALL") ==
        std::vector<std::string>{"2,2,5,3,17,18,15", "4,4,3,7,8,9,10", "5,11,12,13,19,20,21"});
  CHECK(found.at("*NSET,NSET=CLAMPED") == std::vector<std::string>{"2,3,15"});
  CHECK(found.at("*NODE,NSET=NALL").size() == 20);
  CHECK(found.at("*NODE,NSET=NALL").at(13) == "15,1,0.5,0");
  CHECK(found.count("** Rigid-body modes: 6") == 1);  // of the disconnected part
  CHECK(found.at("*FREQUENCY") == std::vector<std::string>{"10"});
  if (have_ccx()) CHECK(frequencies(path).size() == 4);

  modes.elements = ModalDeck::Elements::Linear;
  write_modal_deck(path, mesh, modes);
  found = sections(path);
  CHECK(found.at("*ELEMENT,TYPE=S4,ELSET=ALL") == std::vector<std::string>{"1,1,2,3,4"});
  CHECK(found.at("*ELEMENT,TYPE=S3,ELSET=ALL") ==
        std::vector<std::string>{"2,2,5,3", "5,11,12,13"});
  CHECK(found.at("*ELEMENT,TYPE=S6,ELSET=ALL") == std::vector<std::string>{"4,4,3,7,8,9,10"});
}

TEST_CASE("invalid decks for frequencies are refused with the reason", "[io][calculix]") {
  using Catch::Matchers::Contains;
  const ShellMesh mesh = plate(2);
  const ModalDeck good = steel();
  CHECK(message_of(mesh, good).empty());
  const auto with = [&](auto member, auto value) {
    ModalDeck modes = good;
    modes.*member = value;
    return message_of(mesh, modes);
  };
  CHECK_THAT(with(&ModalDeck::thickness, 0.0), Contains("thickness 0"));
  CHECK_THAT(with(&ModalDeck::young, std::nan("")), Contains("Young's modulus nan"));
  CHECK_THAT(with(&ModalDeck::density, -1.0), Contains("density -1"));
  CHECK_THAT(with(&ModalDeck::poisson, 0.5), Contains("Poisson's ratio 0.5"));
  CHECK_THAT(with(&ModalDeck::count, 0), Contains("0 requested frequencies"));
  CHECK_THAT(with(&ModalDeck::clamped, std::vector<int>{9}),
             Contains("clamped node 9") && Contains("nodes from 0 to 8"));
  CHECK_THAT(message_of(ShellMesh(), good), Contains("no faces"));
  ShellMesh bad = mesh;
  bad.add_face(std::array{0, 1, 2, 5, 4});
  CHECK_THAT(message_of(bad, good), Contains("face 4 (counted from 0) of 5 corners"));
  bad = mesh;
  bad.add_face(std::array{0, 1, 9});
  CHECK_THAT(message_of(bad, good), Contains("node 9 in face 4"));
  bad = mesh;
  bad.points(3, 1) = std::nan("");
  CHECK_THAT(message_of(bad, good), Contains("coordinate of node 3"));
}
