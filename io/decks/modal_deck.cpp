// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/decks/ccx_text.h"
#include "batten/io/files/atomic_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

void expect(bool good, const std::string& found, const std::string& expected) {
  if (!good) throw InputError("modal deck: found " + found + ", expected " + expected);
}

void check(const ShellMesh& mesh, const ModalDeck& modes) {
  const auto above_zero = [](const std::string& what, double x) {
    expect(std::isfinite(x) && x > 0, what + " " + format_number(x), "a number above 0");
  };
  above_zero("thickness", modes.thickness);
  above_zero("Young's modulus", modes.young);
  above_zero("density", modes.density);
  expect(modes.poisson > -1 && modes.poisson < 0.5,
         "Poisson's ratio " + format_number(modes.poisson), "a number between -1 and 0.5");
  expect(modes.count > 0, std::to_string(modes.count) + " requested frequencies", "1 or more");
  const auto in_range = [&](int node) { return node >= 0 && node < mesh.node_count(); };
  const std::string range = "nodes from 0 to " + std::to_string(mesh.node_count() - 1);
  for (const int node : modes.clamped)
    expect(in_range(node), "clamped node " + std::to_string(node), range);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const std::string name = "face " + std::to_string(f) + " (counted from 0)";
    const size_t corners = mesh.corners(f).size();
    expect(corners == 3 || corners == 4, name + " of " + std::to_string(corners) + " corners",
           "triangles and quads");
    for (const int node : mesh.face(f)) {
      expect(in_range(node), "node " + std::to_string(node) + " in " + name, range);
      expect(mesh.points.row(node).allFinite(),
             "a coordinate of node " + std::to_string(node) + " that is not finite",
             "finite coordinates");
    }
  }
}

/// The nodes and elements of the deck.
class Elements {
 public:
  Elements(const ShellMesh& mesh, const ModalDeck& modes) : points_(mesh.points) {
    // Collect existing mid-side nodes first, because adjacent linear faces must use them too.
    for (int f = 0; f < mesh.face_count(); ++f) {
      const auto nodes = mesh.face(f);
      const size_t k = nodes.size() / 2;
      for (size_t i = 0; mesh.second_order(f) && i < k; ++i)
        middle_[std::minmax({nodes[i], nodes[(i + 1) % k]})] = nodes[k + i];
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
      std::vector<int> nodes{mesh.face(f).begin(), mesh.face(f).end()};
      if (!mesh.second_order(f)) {
        drop_repeated(nodes);
        if (nodes.size() < 3) continue;
        if (modes.elements == ModalDeck::Elements::Quadratic) add_middles(nodes);
      }
      by_type_[nodes.size()].push_back({f, nodes});
    }
    for (const auto& [size, list] : by_type_)
      for (const auto& element : list)
        used_.insert(used_.end(), element.nodes.begin(), element.nodes.end());
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    expect(!used_.empty(), "no faces", "triangles or quads");
    find_clamped(modes.clamped);
  }

  void write(std::ostream& out) const {
    static const std::map<size_t, const char*> types{{3, "S3"}, {4, "S4"}, {6, "S6"}, {8, "S8R"}};
    out << "*NODE,NSET=NALL\n";
    for (const int v : used_) out << v + 1 << ',' << ccx_vector(point(v)) << '\n';
    for (const auto& [size, list] : by_type_) {
      out << "*ELEMENT,TYPE=" << types.at(size) << ",ELSET=ALL\n";
      for (const auto& element : list) {
        out << element.face + 1 << ',';
        write_ccx_ids(out, element.nodes);
      }
    }
  }

  const std::vector<int>& clamped() const { return clamped_; }

  /// Number of rigid-body modes: six for each connected component without a clamped node.
  int rigid_body_modes() const {
    DisjointSets pieces(static_cast<size_t>(node_count()));
    for (const auto& [size, list] : by_type_)
      for (const auto& element : list)
        for (const int v : element.nodes) pieces.unite(v, element.nodes[0]);
    std::vector<char> constrained(static_cast<size_t>(node_count()), 0);
    for (const int v : clamped_) constrained[pieces.find(v)] = 1;
    return 6 * static_cast<int>(std::count_if(used_.begin(), used_.end(), [&](int v) {
             return pieces.find(v) == v && !constrained[v];
           }));
  }

 private:
  struct Element {
    int face;
    std::vector<int> nodes;
  };

  static void drop_repeated(std::vector<int>& nodes) {
    std::vector<int> kept;
    for (const int v : nodes)
      if (std::find(kept.begin(), kept.end(), v) == kept.end()) kept.push_back(v);
    nodes = kept;
  }

  int node_count() const { return static_cast<int>(points_.rows() + added_.size()); }
  Vec3 point(int v) const {
    return v < points_.rows() ? Vec3(points_.row(v).transpose()) : added_[v - points_.rows()];
  }

  void add_middles(std::vector<int>& nodes) {
    const size_t k = nodes.size();
    for (size_t i = 0; i < k; ++i) {
      const int a = nodes[i], b = nodes[(i + 1) % k];
      const auto [found, fresh] = middle_.try_emplace(std::minmax({a, b}), node_count());
      if (fresh) added_.push_back((point(a) + point(b)) / 2);
      nodes.push_back(found->second);
    }
  }

  void find_clamped(const std::vector<int>& wanted) {
    std::vector<char> constrained(static_cast<size_t>(node_count()), 0);
    for (const int v : wanted) constrained[v] = 1;
    for (const auto& [ends, v] : middle_)
      if (v >= points_.rows() && constrained[ends.first] && constrained[ends.second])
        constrained[v] = 1;
    std::copy_if(used_.begin(), used_.end(), std::back_inserter(clamped_),
                 [&](int v) { return constrained[v]; });
  }

  const Points& points_;
  std::vector<Vec3> added_;
  // Mid-side node of each edge (lower node, higher node).
  std::map<std::pair<int, int>, int> middle_;
  std::map<size_t, std::vector<Element>> by_type_;  // by number of nodes
  std::vector<int> used_, clamped_;
};

}  // namespace

void write_modal_deck(const fs::path& path, const ShellMesh& mesh, const ModalDeck& modes) {
  check(mesh, modes);
  const Elements elements(mesh, modes);
  const int rigid = elements.rigid_body_modes();
  write_file_atomically(path, [&](std::ostream& out) {
    out << "** Natural frequencies of a shell, written by Batten\n";
    if (!modes.units.empty()) out << "** Units: " << one_line(modes.units) << '\n';
    out << "** Rigid-body modes: " << rigid << '\n';
    elements.write(out);
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(modes.young) << ',' << ccx_number(modes.poisson) << "\n*DENSITY\n"
        << ccx_number(modes.density) << "\n*SHELL SECTION,ELSET=ALL,MATERIAL=SHELL\n"
        << ccx_number(modes.thickness) << '\n';
    if (!elements.clamped().empty()) {
      out << "*NSET,NSET=CLAMPED\n";
      write_ccx_ids(out, elements.clamped());
      out << "*BOUNDARY\nCLAMPED,1,6\n";
    }
    out << "*STEP\n*FREQUENCY\n" << modes.count + rigid << "\n*NODE FILE,OUTPUT=2D\nU\n*END STEP\n";
  });
}

}  // namespace batten
