// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/vertex_selector.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "batten/core/containers.h"
#include "batten/io/files/input_file.h"
#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/features/feature_lines.h"
#include "batten/mesh/selection.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

const MeshFile::Set& set_named(const std::vector<MeshFile::Set>& sets, const LocatedString& word,
                               const std::string& kind, const SceneSelections& scene) {
  std::vector<std::string> names;
  for (const auto& set : sets) {
    if (set.name == word.text || (!set.title.empty() && set.title == word.text)) return set;
    names.push_back(set.name);
  }
  throw InputError(scene.at(word.location) + "found the " + kind + " '" + word.text +
                   "', expected one of the mesh file: " +
                   (names.empty() ? "(it has none)" : comma_separated(names)) +
                   did_you_mean(word.text, names));
}

/// The nodes of a set, including those of its faces.
std::vector<int> with_faces(const MeshFile& file, const MeshFile::Set& set) {
  std::vector<int> vertices = set.nodes;
  for (const int f : set.faces)
    vertices.insert(vertices.end(), file.shells().face(f).begin(), file.shells().face(f).end());
  return vertices;
}

/// Reads a file of node numbers, and converts each to a vertex immediately.
template <class VertexOfLabel>
std::vector<int> vertices_of_file(const std::filesystem::path& file, const std::string& where,
                                  const VertexOfLabel& vertex_of_label) {
  std::istringstream in(read_input_file(file, "node numbers", where));
  std::vector<int> vertices;
  std::string line;
  for (int row = 1; std::getline(in, line); ++row) {
    line = line.substr(0, line.find('#'));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::string word;
    while (words >> word) {
      char* end = nullptr;
      const long label = std::strtol(word.c_str(), &end, 10);
      if (*end != '\0')
        throw InputError(file.string() + ":" + std::to_string(row) + ": found '" + word +
                         "', expected node numbers");
      vertices.push_back(vertex_of_label(label));
    }
  }
  return vertices;
}

}  // namespace

VertexSelector::VertexSelector(const SceneSelections& scene, const MeshFile& file,
                               const TriangleMesh& mesh)
    : scene_(scene), file_(file), mesh_(mesh) {}

const std::vector<DetectedFeature>& VertexSelector::proposals() {
  if (!proposed_) proposals_ = detect_features(mesh_, scene_.proposals);
  proposed_ = true;
  return proposals_;
}

const DetectedFeature* VertexSelector::proposal(const std::string& name) {
  for (const auto& p : proposals())
    if (p.name == name) return &p;
  return nullptr;
}

std::vector<std::string> VertexSelector::names() {
  std::vector<std::string> all;
  for (const auto& s : scene_.selections) all.push_back(s.name);
  for (const auto& c : scene_.cuts) all.push_back(c.name);
  for (const auto& p : proposals()) all.push_back(p.name);
  return all;
}

std::vector<LocatedString> VertexSelector::matching(const LocatedString& word) {
  if (word.text.find('*') == std::string::npos) return {word};
  std::vector<LocatedString> found;
  for (const auto& name : names())
    if (matches_wildcard(word.text, name) &&
        std::find(in_progress_.begin(), in_progress_.end(), name) == in_progress_.end())
      found.push_back({name, word.location});
  if (found.empty())
    throw InputError(scene_.at(word.location) + "found the pattern '" + word.text +
                     "', which matches no name, expected one of: " + comma_separated(names()));
  return found;
}

std::vector<int> VertexSelector::of(const std::vector<LocatedString>& words) {
  std::vector<int> all;
  for (const LocatedString& word : words)
    for (const LocatedString& name : matching(word)) all = union_of(all, of(name));
  return all;
}

std::vector<int> VertexSelector::of(const LocatedString& name) {
  if (const auto it = found_.find(name.text); it != found_.end()) return it->second;
  if (std::find(in_progress_.begin(), in_progress_.end(), name.text) != in_progress_.end())
    throw InputError(scene_.at(name.location) + "found the selection '" + name.text +
                     "' in its own definition, expected other selections");
  in_progress_.push_back(name.text);
  std::vector<int> vertices;
  bool known = false;
  for (const auto& rule : scene_.selections)
    if (rule.name == name.text) {
      vertices = select(rule);
      known = true;
    }
  for (const auto& rule : scene_.cuts)
    if (rule.name == name.text) {
      vertices = cut(rule);
      known = true;
    }
  if (!known) {
    if (const DetectedFeature* p = proposal(name.text))
      vertices = p->vertices;
    else
      throw InputError(scene_.at(name.location) + "found the name '" + name.text +
                       "', expected a selection or a detected feature: " +
                       comma_separated(names()) + did_you_mean(name.text, names()));
  }
  if (vertices.empty())
    throw InputError(scene_.at(name.location) + "found the selection '" + name.text +
                     "' without nodes, expected at least one node");
  in_progress_.pop_back();
  return found_[name.text] = mesh_.topology().nodes_of(std::move(vertices));
}

int VertexSelector::vertex_of_label(long label, const SourceLocation& location) const {
  const auto node = file_.node_of_label(label);
  if (!node)
    throw InputError(scene_.at(location) + "found node " + std::to_string(label) +
                     ", which the mesh does not have, expected a node number of the mesh file");
  return *node;
}

std::vector<int> VertexSelector::loop_of(const SelectionSpec& rule) const {
  const auto& loops = mesh_.topology().boundary_loops();
  if (*rule.loop > isize(loops))
    throw InputError(scene_.at(rule.location) + "found loop " + std::to_string(*rule.loop) +
                     ", expected 1 to " + std::to_string(loops.size()));
  return loops[*rule.loop - 1];
}

std::vector<int> VertexSelector::salient_region(const SelectionSpec& rule) {
  if (saliency_.size() == 0) saliency_ = mesh_saliency(mesh_);
  const auto& s = *rule.salient;
  const int picked =
      s.node ? vertex_of_label(*s.node, rule.location) : nearest_vertex(mesh_, *s.point);
  try {
    return grown_region(mesh_, saliency_, picked, s.threshold);
  } catch (const InputError& e) {
    throw InputError(scene_.at(rule.location) + "the selection '" + rule.name + "': " + e.what());
  }
}

std::vector<int> VertexSelector::part_of(const SelectionSpec& rule) const {
  const std::vector<int> parts = node_components(mesh_.topology());
  std::vector<int> vertices;
  for (int v = 0; v < isize(parts); ++v)
    if (parts[v] == *rule.part - 1) vertices.push_back(v);
  if (vertices.empty())
    throw InputError(scene_.at(rule.location) + "found part " + std::to_string(*rule.part) +
                     ", expected 1 to " +
                     std::to_string(*std::max_element(parts.begin(), parts.end()) + 1));
  return vertices;
}

std::vector<int> VertexSelector::within_distance(const SelectionSpec& rule) {
  const auto& g = *rule.geodesic;
  const std::vector<int> from = g.node ? std::vector<int>{vertex_of_label(*g.node, rule.location)}
                                : g.point ? std::vector<int>{nearest_vertex(mesh_, *g.point)}
                                          : of(g.of);
  return vertices_within(mesh_, from, g.distance);
}

std::vector<int> VertexSelector::listed_vertices(const SelectionSpec& rule) const {
  const auto vertex = [&](long label) { return vertex_of_label(label, rule.location); };
  std::vector<int> vertices;
  for (const long label : rule.nodes) vertices.push_back(vertex(label));
  if (rule.file.empty()) return vertices;
  const auto more = vertices_of_file(rule.file, scene_.at(rule.location), vertex);
  vertices.insert(vertices.end(), more.begin(), more.end());
  return vertices;
}

std::vector<int> VertexSelector::select(const SelectionSpec& rule) {
  std::vector<int> chosen;
  bool first = true;
  const auto meet = [&](std::vector<int> vertices) {
    vertices = mesh_.topology().nodes_of(std::move(vertices));
    chosen = first ? std::move(vertices) : intersection_of(chosen, vertices);
    first = false;
  };
  if (rule.box) meet(vertices_in_box(mesh_, rule.box->first, rule.box->second));
  if (rule.sphere) meet(vertices_in_sphere(mesh_, rule.sphere->first, rule.sphere->second));
  if (rule.plane)
    meet(vertices_beyond_plane(mesh_, rule.plane->through, rule.plane->normal, rule.plane->within));
  if (rule.loop) meet(loop_of(rule));
  if (rule.part) meet(part_of(rule));
  if (rule.salient) meet(salient_region(rule));
  if (rule.geodesic) meet(within_distance(rule));
  if (!rule.nodes.empty() || !rule.file.empty()) meet(listed_vertices(rule));
  if (!rule.set.text.empty())
    meet(with_faces(file_, set_named(file_.sets(), rule.set, "set", scene_)));
  if (!rule.property.text.empty())
    meet(with_faces(file_, set_named(file_.properties(), rule.property, "property", scene_)));
  if (!rule.any.empty()) meet(of(rule.any));
  if (first) {  // no condition selects everything
    std::vector<int> all(mesh_.vertex_count());
    std::iota(all.begin(), all.end(), 0);
    meet(all);
  }
  if (!rule.except.empty()) chosen = difference_of(chosen, of(rule.except));
  return rule.grow > 0 ? grown(mesh_.topology(), chosen, rule.grow) : chosen;
}

std::vector<int> VertexSelector::cut(const CutSpec& rule) {
  if (!rule.on.empty()) return stroke(rule);
  const std::vector<int> vertices = mesh_.topology().expand_to_nodes(of(rule.band));
  std::vector<char> in(mesh_.vertex_count(), 0);
  for (const int v : vertices) in[v] = 1;
  std::vector<int> band;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const auto& c = mesh_.triangles()[t];
    if (in[c[0]] && in[c[1]] && in[c[2]]) band.push_back(t);
  }
  CutOptions options = rule.options;
  if (rule.inside) options.feature_vertex = nearest_vertex(mesh_, *rule.inside);
  try {
    return cut_feature(mesh_, band, options).vertices;
  } catch (const InputError& e) {
    throw InputError(scene_.at(rule.location) + "the cut '" + rule.name + "': " + e.what());
  }
}

std::vector<int> VertexSelector::stroke(const CutSpec& rule) {
  const MeshTopology& topology = mesh_.topology();
  const auto on = topology.expand_to_nodes(of(rule.on)),
             beside = topology.expand_to_nodes(of(rule.beside));
  try {
    return stroke_cut(mesh_, on, beside, rule.options).vertices;
  } catch (const InputError& e) {
    throw InputError(scene_.at(rule.location) + "the cut '" + rule.name + "': " + e.what());
  }
}

std::vector<int> VertexSelector::path(const LineSpec& rule) {
  std::vector<int> stops;
  for (const long label : rule.nodes) stops.push_back(vertex_of_label(label, rule.location));
  for (const Vec3& p : rule.through) stops.push_back(nearest_vertex(mesh_, p));
  if (!rule.nodes.empty()) return stops;
  try {
    return crease_path(mesh_, stops, rule.closed);
  } catch (const InputError&) {
    throw InputError(scene_.at(rule.location) + "found the chain '" + rule.name +
                     "' between parts of the mesh that are not connected, expected one part");
  }
}

}  // namespace batten
