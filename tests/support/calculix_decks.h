// SPDX-License-Identifier: MPL-2.0
// Parses CalculiX decks for tests: their rows, their mesh, and results of ccx.
#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/eigen.h"
#include "batten/tests/support/catch.h"

namespace batten_test {

using namespace batten;

using DeckSections = std::map<std::string, std::vector<std::vector<std::string>>>;

/// Data rows of the deck under each keyword line, as fields.
inline DeckSections sections(const std::filesystem::path& path) {
  DeckSections result;
  std::ifstream in(path);
  std::string keyword;
  for (std::string row; std::getline(in, row);) {
    if (row.starts_with("**")) continue;
    if (row.starts_with("*")) {
      keyword = row;
      result[keyword];
      continue;
    }
    std::vector<std::string> fields;
    std::stringstream stream(row);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    result[keyword].push_back(fields);
  }
  return result;
}

inline Vec3 vector_of(const std::vector<std::string>& fields, size_t first) {
  return {std::stod(fields.at(first)), std::stod(fields.at(first + 1)),
          std::stod(fields.at(first + 2))};
}

inline bool have_ccx() {
  if (std::system("command -v ccx >/dev/null && command -v python3 >/dev/null") == 0) return true;
  WARN("ccx or python3 is not installed: decks were written but not run");
  return false;
}

/// The mesh of a deck, with the node numbers of the file.
struct DeckMeshBuilder {
  std::map<int, Vec3> nodes;
  std::vector<std::array<int, 6>> elements;
  std::map<std::array<int, 3>, int> edges;    ///< ascending ends, middle: elements
  std::map<std::string, std::set<int>> sets;  ///< node sets

  explicit DeckMeshBuilder(const DeckSections& deck) {
    for (const auto& row : deck.at("*NODE,NSET=NALL"))
      nodes[std::stoi(row.at(0))] = vector_of(row, 1);
    for (const auto& row : deck.at("*ELEMENT,TYPE=S6,ELSET=ALL")) {
      auto& nodes_of = elements.emplace_back();
      for (size_t i = 0; i < 6; ++i) nodes_of[i] = std::stoi(row.at(i + 1));
      for (size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax(nodes_of[i], nodes_of[(i + 1) % 3]);
        ++edges[{low, high, nodes_of[3 + i]}];
      }
    }
    for (const auto& [keyword, rows] : deck)
      if (keyword.starts_with("*NSET,NSET="))
        for (const auto& row : rows)
          for (const auto& field : row) sets[keyword.substr(11)].insert(std::stoi(field));
  }

  /// Number of edges per number of adjacent elements.
  std::map<int, int> edges_by_count() const {
    std::map<int, int> result;
    for (const auto& [edge, count] : edges) ++result[count];
    return result;
  }
  /// The same for the edges whose three nodes are in a set.
  std::map<int, int> edges_in(const std::string& set) const {
    std::map<int, int> result;
    const std::set<int>& in = sets.at(set);
    for (const auto& [edge, count] : edges)
      if (in.count(edge[0]) && in.count(edge[1]) && in.count(edge[2])) ++result[count];
    return result;
  }
  /// Smallest distance of two nodes over the diagonal of the bounding box.
  double closest_nodes() const {
    std::vector<Vec3> all;
    for (const auto& [id, x] : nodes) all.push_back(x);
    std::sort(all.begin(), all.end(), [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    const double size = all.back().x() - all.front().x();
    double least = size;
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t j = i + 1; j < all.size() && all[j].x() - all[i].x() < least; ++j)
        least = std::min(least, (all[j] - all[i]).norm());
    return least / size;
  }
};

/// Sum of the deck's nodal forces and of its pressures on flat elements with straight edges: a
/// third of each at each mid-side node. `at_supports`: the part on supported nodes.
struct DeckForces {
  Vec3 all = Vec3::Zero(), at_supports = Vec3::Zero();

  explicit DeckForces(const DeckSections& deck) {
    const DeckMeshBuilder mesh(deck);
    std::set<int> supported;
    for (const auto& row : deck.at("*BOUNDARY"))
      for (const int node : mesh.sets.at(row.at(0))) supported.insert(node);
    const auto add = [&](int node, const Vec3& force) {
      all += force;
      if (supported.count(node)) at_supports += force;
    };
    if (deck.count("*CLOAD"))
      for (const auto& row : deck.at("*CLOAD"))
        add(std::stoi(row.at(0)), std::stod(row.at(2)) * Vec3::Unit(std::stoi(row.at(1)) - 1));
    if (!deck.count("*DLOAD")) return;
    for (const auto& row : deck.at("*DLOAD")) {
      size_t first = 0, last = mesh.elements.size();
      if (row.at(0) != "ALL") {
        const auto& range = deck.at("*ELSET,ELSET=" + row[0] + ",GENERATE").at(0);
        first = static_cast<size_t>(std::stoi(range.at(0))) - 1;
        last = static_cast<size_t>(std::stoi(range.at(1)));
      }
      for (size_t e = first; e < last; ++e) {
        const auto& n = mesh.elements[e];
        const Vec3 a = mesh.nodes.at(n[0]), b = mesh.nodes.at(n[1]), c = mesh.nodes.at(n[2]);
        for (size_t i = 3; i < 6; ++i) add(n[i], std::stod(row.at(2)) / 6 * (b - a).cross(c - a));
      }
    }
  }
};

/// Runs ccx on a copy of the deck: the sum of forces at supported nodes. These are the internal
/// forces there: reactions plus the loads on these nodes.
inline Vec3 supporting_force(const std::filesystem::path& deck) {
  const DeckSections rows = sections(deck);
  const DeckMeshBuilder mesh(rows);
  std::set<int> supported;  // ccx would count nodes in two sets twice
  for (const auto& row : rows.at("*BOUNDARY"))
    for (const int node : mesh.sets.at(row.at(0))) supported.insert(node);
  std::ifstream in(deck);
  const auto job = deck.parent_path() / "totals";
  std::ofstream out(job.string() + ".inp");
  for (std::string row; std::getline(in, row);) {
    if (row == "*STEP") {
      out << "*NSET,NSET=SUPPORTED_\n";
      for (const int node : supported) out << node << ",\n";
    }
    if (row == "*END STEP") out << "*NODE PRINT,NSET=SUPPORTED_,TOTALS=ONLY\nRF\n";
    out << row << '\n';
  }
  out.close();
  const std::string command =
      "cd '" + deck.parent_path().string() + "' && ccx -i totals >totals.log";
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream answer(job.string() + ".dat");
  std::string row;
  while (std::getline(answer, row) && row.find("total force") == std::string::npos) {
  }
  Vec3 force = Vec3::Zero();
  answer >> force[0] >> force[1] >> force[2];
  REQUIRE(answer);
  return force;
}

}  // namespace batten_test
