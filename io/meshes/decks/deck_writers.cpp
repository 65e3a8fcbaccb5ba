// SPDX-License-Identifier: MPL-2.0
// Writes a mesh as a new deck for Abaqus and CalculiX, or for Nastran: nodes, shells and sets.
#include <algorithm>
#include <array>
#include <cctype>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/meshes/mesh_source_text.h"

namespace batten {
namespace {

/// A shell element of a deck: corners, then midside nodes. Nodes are counted from 1.
struct DeckShell {
  std::vector<int> nodes;
  int set = -1;  ///< index of its set; -1: none
};

/// The elements of a mesh. Polygons with more than four corners are split into triangles; a quad
/// with a repeated corner is a triangle. Faces with fewer than three different corners are left out.
std::vector<DeckShell> shells_of(const MeshOutput& output) {
  const ShellMesh& mesh = output.mesh;
  const std::vector<int> sets = set_of_faces(mesh, output.sets);
  std::vector<DeckShell> shells;
  const auto add = [&](std::vector<int> nodes, int face) {
    for (int& node : nodes) ++node;
    shells.push_back({std::move(nodes), sets[face]});
  };
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (is_degenerate(mesh, f)) continue;
    std::vector<int> nodes(mesh.face(f).begin(), mesh.face(f).end());
    if (mesh.second_order(f)) {
      add(nodes, f);
      continue;
    }
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (nodes.front() == nodes.back()) nodes.pop_back();
    if (nodes.size() <= 4)
      add(nodes, f);
    else
      for (const auto& [a, b, c] : triangles_of(mesh, f))
        if (a != b && b != c && c != a) add({a, b, c}, f);
  }
  return shells;
}

constexpr std::array<size_t, 4> kNodeCounts = {3, 4, 6, 8};

/// Names of sets that solvers accept: letters, digits, '_' and '-', with a letter first, in capitals,
/// at most 80 characters, all different.
std::vector<std::string> deck_names(const std::vector<MeshSet>& sets) {
  constexpr size_t longest = 72;  // leaves room for a number
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const MeshSet& set : sets) {
    std::string name = set.title.empty() ? set.name : set.title;
    for (char& c : name) {
      const auto letter = static_cast<unsigned char>(c);
      c = std::isalnum(letter) && letter < 128 ? static_cast<char>(std::toupper(letter))
          : c == '-'                           ? '-'
                                               : '_';
    }
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name.front()))) name = "S" + name;
    name.resize(std::min(name.size(), longest));
    std::string unique = name;
    for (int n = 2; !taken.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
    names.push_back(std::move(unique));
  }
  return names;
}

}  // namespace

bool is_degenerate(const ShellMesh& mesh, int face) {
  const auto corners = mesh.corners(face);
  return std::set<int>(corners.begin(), corners.end()).size() < 3;
}

void write_abaqus_mesh(const MeshOutput& output) {
  constexpr std::array<const char*, 4> types = {"S3", "S4", "S6", "S8R"};
  constexpr int width = 20, numbers_per_line = 16;
  const std::vector<DeckShell> shells = shells_of(output);
  const std::vector<std::string> names = deck_names(output.sets);
  write_file_atomically(output.path, [&](std::ostream& out) {
    out << "** Mesh written by Batten: nodes, shells and element sets. Add materials, sections and "
           "steps.\n*NODE\n";
    for (int i = 0; i < output.mesh.node_count(); ++i) {
      out << i + 1;
      for (int c = 0; c < 3; ++c) out << ", " << fixed_real(output.mesh.points(i, c), width, false);
      out << '\n';
    }
    for (size_t k = 0; k < types.size(); ++k) {
      bool first = true;
      for (size_t e = 0; e < shells.size(); ++e) {
        if (shells[e].nodes.size() != kNodeCounts[k]) continue;
        if (std::exchange(first, false)) out << "*ELEMENT, TYPE=" << types[k] << '\n';
        out << e + 1;
        for (const int node : shells[e].nodes) out << ", " << node;
        out << '\n';
      }
    }
    for (size_t s = 0; s < names.size(); ++s) {
      int count = 0;
      for (size_t e = 0; e < shells.size(); ++e) {
        if (shells[e].set != static_cast<int>(s)) continue;
        if (count == 0) out << "*ELSET, ELSET=" << names[s];
        out << (count++ % numbers_per_line == 0 ? "\n" : ", ") << e + 1;
      }
      if (count > 0) out << '\n';
    }
  });
}

void write_nastran_mesh(const MeshOutput& output) {
  constexpr std::array<const char*, 4> cards = {"CTRIA3", "CQUAD4", "CTRIA6", "CQUAD8"};
  constexpr int width = 16;
  const std::vector<DeckShell> shells = shells_of(output);
  const std::vector<std::string> names = deck_names(output.sets);
  const auto property = [](const DeckShell& shell) { return shell.set + 2; };  // 1: no set
  write_file_atomically(output.path, [&](std::ostream& out) {
    out << "$ Mesh written by Batten: nodes and shells. Add a PSHELL and a material for each "
           "property.\n";
    for (size_t s = 0; s < names.size(); ++s) out << "$ PID " << s + 2 << ": " << names[s] << '\n';
    out << "BEGIN BULK\n";
    const auto field = [&](std::string text) {
      text.resize(width, ' ');
      out << text;
    };
    for (int i = 0; i < output.mesh.node_count(); ++i) {
      out << "GRID*   ";
      field(std::to_string(i + 1));
      field("");
      for (int c = 0; c < 3; ++c) {
        if (c == 2) out << "\n*       ";
        field(fixed_real(output.mesh.points(i, c), width, true));
      }
      out << '\n';
    }
    for (size_t e = 0; e < shells.size(); ++e) {
      const std::vector<int>& nodes = shells[e].nodes;
      const auto kind = std::find(kNodeCounts.begin(), kNodeCounts.end(), nodes.size());
      out << cards[static_cast<size_t>(kind - kNodeCounts.begin())] << ',' << e + 1 << ','
          << property(shells[e]);
      constexpr size_t first_line = 6;
      for (size_t k = 0; k < nodes.size(); ++k) out << (k == first_line ? ",\n," : ",") << nodes[k];
      out << '\n';
    }
    out << "ENDDATA\n";
  });
}

}  // namespace batten
