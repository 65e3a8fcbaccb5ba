// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/abaqus_connections.h"

#include <algorithm>
#include <unordered_set>

#include "batten/core/errors.h"

namespace batten {

using Kind = NonShellElement::Kind;

bool AbaqusConnections::read(const Keyword& keyword, AbaqusLines& lines) {
  const std::string& name = keyword.name;
  const size_t first = connections_.size();
  if (name == "RIGID BODY") {
    read_rigid_body(keyword, lines);
  } else if (name == "MPC") {
    read_mpc(keyword, lines);
  } else if (name == "EQUATION") {
    read_equation(keyword, lines);
  } else if (name == "COUPLING") {
    coupling_ = keyword;
  } else if (name == "KINEMATIC" || name == "DISTRIBUTING") {
    Connection& connection = add(name == "KINEMATIC" ? Kind::Rigid : Kind::Interpolation, keyword);
    connection.first.push_back({By::Nodes, coupling_.value("REF NODE")});
    connection.rest.push_back({By::Surface, coupling_.value("SURFACE")});
  } else if (name == "KINEMATIC COUPLING") {
    Connection& connection = add(Kind::Rigid, keyword);
    connection.first.push_back({By::Nodes, keyword.value("REF NODE")});
    read_coupling_data(connection, false, lines);
  } else if (name == "DISTRIBUTING COUPLING") {
    Connection& connection = add(Kind::Interpolation, keyword);
    connection.first.push_back({By::Faces, keyword.value("ELSET")});
    read_coupling_data(connection, true, lines);
  } else if (name == "TIE" || name == "SHELL TO SOLID COUPLING" ||
             (name == "CONTACT PAIR" && keyword.has("TIED"))) {
    read_ties(keyword, lines);
  } else if (name == "FASTENER" || name == "EMBEDDED ELEMENT") {
    unread_.push_back("*" + name + " is not followed (" +
                      file_.line_name(file_.offset(keyword.line), 0) +
                      "); parts that only it connects need handles or features of their own");
  } else if (name == "SURFACE") {
    read_surface(keyword, lines);
  } else {
    return false;
  }
  for (size_t i = first; i < connections_.size(); ++i)
    for (auto* terms : {&connections_[i].first, &connections_[i].rest})
      for (Term& term : *terms) term.shift = shift_;
  while (lines.next_data()) {
  }
  return true;
}

void AbaqusConnections::add_coupling_node(std::string_view elset, long node) {
  coupling_nodes_[upper(elset)] = node;
}

AbaqusConnections::Connection& AbaqusConnections::add(Kind kind, const Keyword& keyword) {
  deck_.count_other_element("*" + keyword.name);
  connections_.push_back({kind, "*" + keyword.name, keyword.line, {}, {}});
  return connections_.back();
}

void AbaqusConnections::read_rigid_body(const Keyword& keyword, AbaqusLines&) {
  Connection& connection = add(Kind::Rigid, keyword);
  connection.first.push_back({By::Nodes, keyword.value("REF NODE")});
  for (const char* set : {"NSET", "PIN NSET", "TIE NSET"})
    if (keyword.has(set)) connection.rest.push_back({By::Nodes, keyword.value(set)});
  if (keyword.has("ELSET")) connection.rest.push_back({By::Faces, keyword.value("ELSET")});
}

void AbaqusConnections::read_mpc(const Keyword& keyword, AbaqusLines& lines) {
  while (lines.next_data()) {
    const std::vector<std::string_view> values = comma_values(lines.line());
    const std::string type = upper(values[0]);
    // For these types, the last node is the independent one.
    const bool rigid = type == "BEAM" || type == "LINK" || type == "PIN" || type == "TIE";
    Connection& connection = add(rigid ? Kind::Rigid : Kind::Other, keyword);
    connection.where = lines.line();
    for (size_t i = 1; i < values.size(); ++i)
      if (!values[i].empty() && values[i] != "0") connection.rest.push_back({By::Nodes, values[i]});
    if (!rigid || connection.rest.empty()) continue;
    connection.first.push_back(connection.rest.back());
    connection.rest.pop_back();
  }
}

void AbaqusConnections::read_equation(const Keyword& keyword, AbaqusLines& lines) {
  // The data lines of REMOVE name terms of equations, not equations.
  if (keyword.has("REMOVE")) return;
  while (lines.next_data()) {
    const std::string_view where = lines.line();
    const long terms = file_.integer(comma_values(where)[0], "the count of terms of an equation");
    Connection& connection = add(Kind::Other, keyword);
    connection.where = where;
    for (long i = 0; i < terms;) {
      if (!lines.next_data())
        file_.fail(where, "found an equation with missing terms, expected as many as stated");
      // Up to four terms per line: node, degree of freedom, coefficient.
      const std::vector<std::string_view> values = comma_values(lines.line());
      for (size_t k = 0; k < values.size() && i < terms; k += 3) {
        if (values[k].empty()) continue;
        connection.rest.push_back({By::Nodes, values[k]});
        ++i;
      }
    }
  }
}

void AbaqusConnections::read_coupling_data(Connection& connection, bool weights,
                                           AbaqusLines& lines) {
  while (lines.next_data()) {
    const std::vector<std::string_view> values = comma_values(lines.line());
    double weight = 1;
    if (weights && values.size() > 1 && !values[1].empty()) weight = file_.real(values[1]);
    connection.rest.push_back({By::Nodes, values[0], weight});
  }
}

void AbaqusConnections::read_surface(const Keyword& keyword, AbaqusLines& lines) {
  Surface& surface = surfaces_[upper(keyword.value("NAME"))];
  surface.of_nodes = upper(keyword.value("TYPE")) == "NODE";
  while (lines.next_data()) {
    const std::vector<std::string_view> values = comma_values(lines.line());
    surface.parts.push_back({values[0], values.size() > 1 ? upper(values[1]) : ""});
  }
}

void AbaqusConnections::read_ties(const Keyword& keyword, AbaqusLines& lines) {
  double reach = 0;
  if (!parse_real(keyword.value("POSITION TOLERANCE"), reach)) reach = 0;
  const std::string_view name = keyword.value(keyword.has("NAME") ? "NAME" : "CONSTRAINT NAME");
  while (lines.next_data()) {
    const std::vector<std::string_view> values = comma_values(lines.line());
    if (values.size() < 2) continue;
    ties_.push_back({"*" + keyword.name + " " + std::string(name.empty() ? values[0] : name),
                     values[0], values[1], reach});
  }
}

namespace {

/// Corners of the sides S1, S2, … of solids with 4, 6 and 8 corners.
std::vector<int> side_of_solid(const NonShellElement& solid, const std::string& side) {
  using Sides = std::vector<std::vector<int>>;
  static const Sides tetrahedron{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}},
      wedge{{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
      hexahedron{{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                 {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  const size_t count = solid.nodes.size();
  const Sides& sides = count == 4 || count == 10   ? tetrahedron
                       : count == 6 || count == 15 ? wedge
                                                   : hexahedron;
  const bool known = side.size() == 2 && side[0] == 'S' && side[1] >= '1' &&
                     side[1] < '1' + static_cast<char>(sides.size());
  if (!known || count < 4) return solid.nodes;
  std::vector<int> nodes;
  for (const int i : sides[static_cast<size_t>(side[1] - '1')])
    if (i < static_cast<int>(count)) nodes.push_back(solid.nodes[static_cast<size_t>(i)]);
  return nodes;
}

}  // namespace

/// Resolves the names in a deck to node indices.
class AbaqusConnections::Finder {
 public:
  Finder(const AbaqusConnections& all, const TextMeshContent& mesh, const Sets& sets,
         const Others& others = {})
      : all_(all), mesh_(mesh), sets_(sets), others_(others) {}

  /// Returns false if some of the nodes do not exist in the mesh.
  bool find(const Term& term) {
    weight_ = term.weight;
    shift_ = term.shift;
    switch (term.by) {
      case By::Nodes:
        return add_nodes(term.entity);
      case By::Faces:
        return add_faces(term.entity, "");
      default:
        return add_surface(term.entity);
    }
  }
  bool find(const std::vector<Term>& terms) {
    return std::all_of(terms.begin(), terms.end(), [&](const Term& term) { return find(term); });
  }
  bool find_surface(std::string_view entity) { return add_surface(entity); }
  std::vector<int> nodes;
  std::vector<double> weights;
  std::vector<int> faces;  ///< shells of surfaces

 private:
  void add(int node) {
    if (!seen_.insert(node).second) return;
    nodes.push_back(node);
    weights.push_back(weight_);
  }

  /// The name of the element set in upper case, without the name of the instance.
  std::string element_set(std::string_view entity) const {
    const auto names = local_names(entity);
    for (const std::string_view name : names)
      if (sets_(upper(name), true) || all_.coupling_nodes_.contains(upper(name)))
        return upper(name);
    return upper(names.back());
  }

  bool add_nodes(std::string_view entity) {
    // The name of a set may contain dots.
    for (const std::string_view name : local_names(entity)) {
      long label = 0;
      if (parse_integer(name, label)) {
        const bool of_instance = name.size() < entity.size();
        const auto node = mesh_.node_labels.find(label + (of_instance ? 0 : shift_));
        if (node) add(*node);
        return node.has_value();
      }
      const auto set = sets_(upper(name), false);
      if (!set) continue;
      for (const int node : *set) add(node);
      return true;
    }
    return false;
  }

  /// Adds all nodes of faces, or those of one edge if `side` is "E1" to "E4".
  bool add_faces(std::string_view entity, const std::string& side) {
    const std::string name = element_set(entity);
    if (const auto node = all_.coupling_nodes_.find(name); node != all_.coupling_nodes_.end()) {
      const auto index = mesh_.node_labels.find(node->second);
      if (index) add(*index);
      return index.has_value();
    }
    long label = 0;
    std::optional<std::vector<int>> faces;
    if (parse_integer(name, label)) {
      const auto face = mesh_.face_labels.find(label);
      faces = face ? std::vector<int>{*face} : std::vector<int>();  // a face of a solid has none
    } else {
      faces = sets_(name, true);
    }
    if (!faces) return false;
    this->faces.insert(this->faces.end(), faces->begin(), faces->end());
    if (others_)
      for (const int e : others_(name))
        for (const int node : side_of_solid(mesh_.other_elements[static_cast<size_t>(e)], side))
          add(node);
    const bool edge = side.size() == 2 && side[0] == 'E' && side[1] >= '1' && side[1] <= '4';
    std::vector<int> found;
    for (const int f : *faces) {
      const auto all = mesh_.shells.face(f), corners = mesh_.shells.corners(f);
      const auto k = static_cast<size_t>(edge ? side[1] - '1' : 0);
      if (!edge) {
        found.insert(found.end(), all.begin(), all.end());
      } else if (k < corners.size()) {
        found.push_back(corners[k]);
        found.push_back(corners[(k + 1) % corners.size()]);
        if (mesh_.shells.second_order(f)) found.push_back(all[corners.size() + k]);
      }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const int node : found) add(node);
    return true;
  }

  bool add_surface(std::string_view entity) {
    auto surface = all_.surfaces_.end();
    for (const std::string_view name : local_names(entity))
      if (surface == all_.surfaces_.end()) surface = all_.surfaces_.find(upper(name));
    if (surface == all_.surfaces_.end()) return false;
    for (const auto& [part, side] : surface->second.parts)
      if (!(surface->second.of_nodes ? add_nodes(part) : add_faces(part, side))) return false;
    return true;
  }

  const AbaqusConnections& all_;
  const TextMeshContent& mesh_;
  const Sets& sets_;
  const Others others_;
  std::unordered_set<int> seen_;
  double weight_ = 1;
  long shift_ = 0;
};

/// The side with shells is followed. If both have shells, the first (slave) follows the second.
void AbaqusConnections::finish_ties(TextMeshContent& mesh, const Sets& sets,
                                    const Others& others) const {
  for (const Tie& tie : ties_) {
    Finder first(*this, mesh, sets, others), second(*this, mesh, sets, others);
    if (!first.find_surface(tie.first) || !second.find_surface(tie.second)) {
      mesh.warnings.push_back(tie.name + " is not followed: its surfaces are not known");
      continue;
    }
    if (first.faces.empty() && second.faces.empty()) {
      mesh.warnings.push_back(tie.name + " connects no shells: its " +
                              format_count(static_cast<long>(first.nodes.size()), "node") +
                              " move only with their own elements");
      continue;
    }
    Finder& leader = second.faces.empty() ? first : second;
    Finder& follower = second.faces.empty() ? second : first;
    SurfaceTie found{SurfaceTie::Kind::Tie, tie.name, follower.nodes, {leader.faces}, tie.reach};
    mesh.ties.push_back(std::move(found));
  }
}

void AbaqusConnections::finish(TextMeshContent& mesh, const Sets& sets, const Others& others,
                               bool all_here) const {
  mesh.warnings.insert(mesh.warnings.end(), unread_.begin(), unread_.end());
  finish_ties(mesh, sets, others);
  for (const Connection& connection : connections_) {
    Finder first(*this, mesh, sets, others), rest(*this, mesh, sets, others);
    if (!first.find(connection.first) || !rest.find(connection.rest)) {
      if (all_here)
        file_.fail(connection.where, "found " + connection.name +
                                         " with unknown nodes, expected nodes and sets "
                                         "of the deck");
      mesh.warnings.push_back(connection.name + " is not followed: its nodes are not known (" +
                              file_.line_name(file_.offset(connection.where), 0) + ")");
      continue;
    }
    NonShellElement element{connection.kind, connection.name, 0, first.nodes, {}};
    // With several independent nodes, none is the leading one.
    if (first.nodes.size() != 1) element.kind = Kind::Other;
    for (size_t i = 0; i < rest.nodes.size(); ++i) {
      if (first.nodes.size() == 1 && rest.nodes[i] == first.nodes[0]) continue;
      element.nodes.push_back(rest.nodes[i]);
      if (element.kind == Kind::Interpolation) element.weights.push_back(rest.weights[i]);
    }
    if (!element.nodes.empty()) mesh.other_elements.push_back(std::move(element));
  }
}

}  // namespace batten
