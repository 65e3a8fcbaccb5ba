// SPDX-License-Identifier: MPL-2.0
// Derivatives, variants and requirements of batten deform, on the command line.
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

const std::string kPanelFolder = BATTEN_SOURCE_DIR "/examples/11-panel/";

/// The panel, which becomes longer; without files for modes and pictures. Large fields, so that
/// decks can be compared.
std::string panel_scene(const std::string& more = "") {
  std::string text = contents(kPanelFolder + "edit.toml");
  text = text.substr(0, text.find("[modes]"));
  text.replace(text.find("panel.bdf"), 9, kPanelFolder + "panel.bdf");
  return text + more + "\n[output]\nmesh = \"longer.bdf\"\nlarge_field = true\n";
}

std::vector<std::string> words_of(const std::string& line, char separator) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, separator);) words.push_back(word);
  return words;
}

std::vector<std::vector<std::string>> csv_rows(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(contents(file));
  for (std::string line; std::getline(in, line);) rows.push_back(words_of(line, ','));
  return rows;
}

/// The large-field cards of a Nastran file: fields of 16 characters over two lines.
std::vector<std::vector<std::string>> large_field_cards(const fs::path& file) {
  std::vector<std::vector<std::string>> cards;
  std::istringstream in(contents(file));
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("$")) continue;
    REQUIRE(line.size() >= 8);
    if (line[0] != '*') cards.push_back({line.substr(0, line.find('*'))});
    for (size_t at = 8; at < line.size(); at += 16) {
      std::string field = line.substr(at, 16);
      field.erase(field.find_last_not_of(' ') + 1);
      cards.back().push_back(field);
    }
  }
  return cards;
}

batten::Points nodes(const fs::path& deck) { return batten::MeshFile::read(deck).shells().points; }

}  // namespace

TEST_CASE("derivatives are written as a table and as shape variables", "[apps][deform]") {
  const CliCase c("deform_derivatives");
  c.file("s.toml", panel_scene());
  const CliResult r = c.run({"deform", "s.toml", "--out", "out", "--derivatives", "d.csv",
                             "--derivatives", "d.bdf", "--derivatives", "d.npz", "--range",
                             "longer.right.x=0:40", "--range", "longer.right.angle=0:10"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(r.err.empty());
  const auto j = report(c, "out");
  CHECK(j["derivatives"]["parameters"] ==
        std::vector<std::string>{"longer.right.x", "longer.right.angle"});
  CHECK(j["derivatives"]["largest_error"].get<double>() < 1e-7);
  CHECK(contents(c / "d.npz").starts_with("PK"));

  const auto rows = csv_rows(c / "d.csv");
  REQUIRE(rows.size() == 1 + j["mesh"]["nodes"].get<size_t>());
  CHECK(rows[0][4] == "longer.right.x:dx");
  std::map<std::pair<int, long>, std::array<double, 3>> of_table;
  for (size_t i = 1; i < rows.size(); ++i)
    for (int p = 0; p < 2; ++p)
      for (int k = 0; k < 3; ++k)
        of_table[{p + 1, std::stol(rows[i][0])}][k] = std::stod(rows[i][4 + 3 * p + k]);

  // An independent reading of the cards: DVGRID, DVID, GID, CID, COEFF, N1, N2, N3.
  size_t desvars = 0;
  for (const auto& card : large_field_cards(c / "d.bdf")) {
    if (card[0] == "DESVAR") {
      CHECK(std::stod(card[3]) == (desvars == 0 ? 12 : 8));
      CHECK(std::stod(card[4]) == 0);
      CHECK(std::stod(card[5]) == (desvars == 0 ? 40 : 10));
      ++desvars;
      continue;
    }
    REQUIRE(card[0] == "DVGRID");
    CHECK(std::stod(card[3]) == 0);
    CHECK(std::stod(card[4]) == 1);
    const std::pair key{std::stoi(card[1]), std::stol(card[2])};
    for (int k = 0; k < 3; ++k)
      CHECK(std::stod(card[5 + k]) == Approx(of_table.at(key)[k]).epsilon(1e-8).margin(1e-11));
    of_table.erase(key);
  }
  CHECK(desvars == 2);
  CHECK(of_table.size() > 20);  // the fixed nodes have no card
  for (const auto& [key, rate] : of_table)
    CHECK(std::abs(rate[0]) + std::abs(rate[1]) + std::abs(rate[2]) < 1e-9);

  // A step along the derivative is the edit with another value, to second order.
  const CliResult other =
      c.run({"deform", "s.toml", "--out", "other", "--set", "longer.right.x=12.1"});
  REQUIRE(other.code == 0);
  const batten::Points step = nodes(c / "other/longer.bdf") - nodes(c / "out/longer.bdf");
  double largest = 0;
  for (size_t i = 1; i < rows.size(); ++i)
    for (int k = 0; k < 3; ++k)
      largest = std::max(
          largest, std::abs(step(static_cast<long>(i) - 1, k) - 0.1 * std::stod(rows[i][4 + k])));
  CHECK(largest < 1e-4);
  CHECK(step.cwiseAbs().maxCoeff() > 0.09);
}

TEST_CASE("variants are the decks of single runs, in a table", "[apps][deform]") {
  const CliCase c("deform_variants");
  c.file("s.toml", panel_scene("[[dimension]]\nname = \"length\"\ntype = \"distance\"\n"
                               "of = [\"left\", \"right\"]\ndirection = [1, 0, 0]\n"));
  const CliResult r = c.run({"deform", "s.toml", "--out", "out", "--doe", "lhs:3", "--range",
                             "longer.right.x=0:40", "--range", "longer.right.z=0:20"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  CHECK(j["variants"]["count"] == 3);
  CHECK(j["variants"]["failed"] == 0);
  const auto rows = csv_rows(c / "out/variants.csv");
  REQUIRE(rows.size() == 4);
  CHECK(rows[0] == std::vector<std::string>{"variant", "longer.right.x", "longer.right.z", "length",
                                            "largest_displacement", "worst_aspect",
                                            "worst_warpage_deg", "worst_jacobian", "inverted_faces",
                                            "status", "file"});
  const double length = j["dimensions"][0]["before"];
  for (int i = 1; i <= 3; ++i) {
    const auto& row = rows[static_cast<size_t>(i)];
    INFO(i);
    CHECK(row[9] == "ok");
    CHECK(row[10] == "variant-00" + std::to_string(i) + "/longer.bdf");
    CHECK(std::stod(row[3]) == Approx(length + std::stod(row[1])).epsilon(1e-9));
    const CliResult single =
        c.run({"deform", "s.toml", "--out", "single", "--set", "longer.right.x=" + row[1], "--set",
               "longer.right.z=" + row[2]});
    REQUIRE(single.code == 0);
    CHECK((nodes(c / "single/longer.bdf") - nodes(c / ("out/" + row[10]))).cwiseAbs().maxCoeff() <
          1e-9);
  }
}

TEST_CASE("variants that fail are listed, and the others are complete", "[apps][deform]") {
  const CliCase c("deform_failed_variants");
  c.file("s.toml", panel_scene("[[dimension]]\nname = \"length\"\ntype = \"distance\"\n"
                               "of = [\"left\", \"right\"]\n"
                               "[[require]]\ndimension = \"length\"\nat_least = 600\n"));
  c.file("wanted.csv",
         "\xef\xbb\xbf# pulls\r\nlonger.right.x; longer.right.z\r\n20;0\r\n\r\n-30;0\n");
  const CliResult r = c.run({"deform", "s.toml", "--out", "out", "--doe", "wanted.csv"});
  CHECK(r.code == 4);
  CHECK(r.err.find("1 of 2 variants failed, the first is variant 002: dimensions.length is") !=
        std::string::npos);
  const auto rows = csv_rows(c / "out/variants.csv");
  REQUIRE(rows.size() == 3);
  CHECK(rows[1][9] == "ok");
  CHECK(rows[2][9] != "ok");
  CHECK(fs::exists(c / "out/variant-001/longer.bdf"));

  const auto refused = [&](const std::vector<std::string>& more, const std::string& part) {
    std::vector<std::string> words = {"deform", "s.toml", "--out", "none"};
    words.insert(words.end(), more.begin(), more.end());
    const CliResult bad = c.run(words);
    INFO(bad.err);
    CHECK(bad.code == 1);
    CHECK(bad.err.find(part) != std::string::npos);
    CHECK_FALSE(fs::exists(c / "none"));
  };
  refused({"--doe", "lhs:5"}, "--range NAME=FROM:TO");
  refused({"--doe", "lhs:5", "--range", "longer.rihgt.x=0:1"}, "did you mean 'longer.right.x'");
  refused({"--range", "longer.right.x=0:1"}, "expected --doe or --derivatives");
  refused({"--derivatives", "d.txt"}, "expected .csv, .npz, or .bdf");
  refused({"--doe", "missing.csv"}, "missing.csv");
  c.file("short.csv", "longer.right.x,longer.right.z\n1\n");
  refused({"--doe", "short.csv"}, "short.csv:2: found 1 columns, expected 2");
  c.file("odd.csv", "longer.right.q\n1\n");
  refused({"--doe", "odd.csv"}, "longer.right.q");
}

TEST_CASE("a required dimension sets its parameter", "[apps][deform]") {
  const CliCase c("deform_required");
  const std::string dimension =
      "[[dimension]]\nname = \"length\"\ntype = \"distance\"\nof = [\"left\", \"right\"]\n"
      "[[require]]\ndimension = \"length\"\n";
  c.file("s.toml", panel_scene(dimension + "equal = 620\nadjust = \"longer.right.x\"\n"));
  const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
  INFO(r.err);
  CHECK(r.code == 0);
  CHECK(r.out.find("-> 620 mm, required = 620") != std::string::npos);
  const auto j = report(c, "out");
  CHECK(j["dimensions"][0]["after"].get<double>() == Approx(620).epsilon(1e-9));
  const CliCase none("deform_required_not");
  for (const auto& p : j["parameters"])
    if (p["name"] == "longer.right.x") CHECK(p["value"].get<double>() > 12);
  none.fails(panel_scene(dimension + "equal = 620\nadjust = \"longer.rihgt.x\"\n"), 1,
             {"did you mean 'longer.right.x'"}, {}, "deform");
  none.fails(panel_scene(dimension + "equal = 620\nat_most = 3\n"), 1,
             {"one of equal, at_most, at_least"}, {}, "deform");
  none.fails(panel_scene("[[require]]\ndimension = \"length\"\nequal = 3\n"), 1,
             {"found 'length', expected a [[dimension]] of this name"}, {}, "deform");
  none.fails(panel_scene(dimension + "equal = 0.001\nadjust = \"fuller.crown.z\"\n"), 3,
             {"found no value of 'fuller.crown.z'", "the nearest is"}, {}, "deform");
}
