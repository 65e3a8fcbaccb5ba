#include "batten/apps/commands/meshes/mesh_source.h"

#include <algorithm>
#include <map>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/selection.h"

namespace batten {

MeshSource read_source(const std::filesystem::path& path) {
  MeshFile file = MeshFile::read(path);
  try {
    PreparedMesh prepared =
        prepare(file.shells(), [&](int v) { return std::to_string(file.node_label(v)); });
    return {std::move(file), std::move(prepared)};
  } catch (const InputError& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

Points node_positions(const Points& vertices, const MeshFile& file) {
  return vertices.topRows(file.shells().node_count());
}

namespace {

std::string format_position(const Vec3& p) {
  return "(" + format_number(p.x()) + ", " + format_number(p.y()) + ", " + format_number(p.z()) +
         ")";
}

std::string describe_box(const Box3& box) {
  return "from " + format_position(box.min()) + " to " + format_position(box.max());
}

std::string sets_text(const std::string& what, const std::vector<MeshFile::Set>& sets) {
  std::string text;
  for (const auto& s : sets)
    text += "  " + what + " '" + s.name + "'" + (s.title.empty() ? "" : " (" + s.title + ")") +
            ": " +
            (s.faces.empty() ? std::to_string(s.nodes.size()) + " nodes"
                             : std::to_string(s.faces.size()) + " faces") +
            "\n";
  return text;
}

/// Describes mesh components with their boxes, and the non-shell elements that connect them.
std::string parts_text(const MeshFile& file, const TriangleMesh& mesh) {
  const std::vector<int> part = node_components(mesh.topology());
  const int count = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  if (count < 2 && file.other_elements().empty()) return "";
  std::vector<Box3> boxes(count);
  std::vector<int> nodes(count, 0), lowest(count, -1);
  for (int v = 0; v < isize(part); ++v) {
    if (part[v] < 0) continue;
    boxes[part[v]].extend(mesh.point(v));
    ++nodes[part[v]];
    if (lowest[part[v]] < 0) lowest[part[v]] = v;
  }
  std::string text;
  for (int p = 0; p < count && count > 1; ++p)
    text += "  part " + std::to_string(p + 1) + ": " + std::to_string(nodes[p]) + " nodes, node " +
            std::to_string(file.node_label(lowest[p])) + " …, " + describe_box(boxes[p]) + "\n";
  // Non-shell nodes are grouped by their elements; each group reaches the components it is attached
  // to.
  DisjointSets hanging(part.size());
  for (const NonShellElement& e : file.other_elements()) {
    int first = -1;
    for (const int v : e.nodes)
      if (part[v] < 0) {
        if (first >= 0) hanging.unite(first, v);
        first = v;
      }
  }
  std::map<int, std::set<int>> reached;  // components, by the lowest node of a group
  for (const NonShellElement& e : file.other_elements())
    for (const int v : e.nodes)
      for (const int u : e.nodes)
        if (part[v] < 0 && part[u] >= 0) reached[hanging.find(v)].insert(part[u]);
  std::map<std::set<int>, std::map<std::string, int>> between;  // components, elements
  for (const NonShellElement& e : file.other_elements()) {
    std::set<int> parts;
    for (const int v : e.nodes)
      if (part[v] >= 0)
        parts.insert(part[v]);
      else
        parts.insert(reached[hanging.find(v)].begin(), reached[hanging.find(v)].end());
    ++between[parts][e.name];
  }
  for (const auto& [parts, elements] : between) {
    std::string where = parts.size() > 1 ? "between parts"
                        : parts.empty()  ? "not attached to a part"
                                         : "on part";
    for (const int p : parts) where += " " + std::to_string(p + 1);
    text += "  " + where + ":";
    for (const auto& [name, n] : elements)
      text += (name == elements.begin()->first ? " " : ", ") + std::to_string(n) + " " + name;
    text += "\n";
  }
  return text;
}

std::string describe_hole(const HoleMeasure& m) {
  return "centre " + format_position(m.centre) +
         (m.circular ? ", radius " + format_number(m.radius)
                     : ", not circular, perimeter " + format_number(m.perimeter) +
                           ", equivalent radius " + format_number(m.equivalent_radius));
}

}  // namespace

std::string mesh_info(const std::filesystem::path& path, const std::string& unit,
                      const FeatureDetectionOptions& proposals) {
  const MeshFile file = MeshFile::read(path);
  const ShellMesh& shells = file.shells();
  const MeshDiagnosis d = diagnose(shells);
  std::string text = file.format() + ": " + std::to_string(shells.node_count()) + " nodes, " +
                     std::to_string(shells.face_count()) + " faces in " +
                     std::to_string(d.components) + (d.components == 1 ? " part" : " parts") +
                     ", lengths in " + unit + "\n";
  for (const auto& w : file.warnings()) text += "  " + w + "\n";
  text += sets_text("set", file.sets()) + sets_text("property", file.properties());
  const auto name = [&](int v) { return std::to_string(file.node_label(v)); };
  const PreparedMesh prepared = [&] {
    try {
      return prepare(shells, name);
    } catch (const InputError& e) {
      throw InputError(path.string() + ": " + e.what() + "\n" + text);
    }
  }();
  const TriangleMesh& mesh = prepared.mesh;
  for (const auto& note : prepared.notes) text += "  " + note + "\n";
  text += "  " + describe_box(mesh.box()) + "\n" + parts_text(file, mesh);
  const QualitySummary q = summarize(shells, shells.points);
  text += "  worst aspect " + format_number(q.aspect.worst) + ", warpage " +
          format_number(q.warpage_degrees.worst) + " degrees, Jacobian " +
          format_number(q.jacobian.worst) + "\n";
  const auto& loops = mesh.topology().boundary_loops();
  for (size_t l = 0; l < loops.size(); ++l)
    text += "  loop " + std::to_string(l + 1) + ": " + std::to_string(loops[l].size()) +
            " nodes, " + describe_hole(measure_hole(mesh.points(), loops[l])) + "\n";
  for (const auto& p : detect_features(mesh, proposals))
    text += "  feature '" + p.name +
            "': " + std::to_string(mesh.topology().nodes_of(p.vertices).size()) + " nodes, " +
            describe_hole(p.measure) + "\n";
  return text;
}

}  // namespace batten
