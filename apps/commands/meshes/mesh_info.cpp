#include "batten/apps/commands/meshes/mesh_info.h"

#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/proposals.h"
#include "batten/mesh/prepare.h"
#include "batten/mesh/quality.h"

namespace batten {

std::string mesh_info(const std::filesystem::path& path, const std::string& unit) {
  const MeshFile file = MeshFile::read(path);
  const ShellMesh& shells = file.shells();
  const MeshDiagnosis d = diagnose(shells);
  std::string text = file.format() + ": " + std::to_string(shells.node_count()) + " nodes, " +
                     std::to_string(shells.face_count()) + " faces in " +
                     std::to_string(d.components) + (d.components == 1 ? " part" : " parts") +
                     ", lengths in " + unit + "\n";
  for (const auto& w : file.warnings()) text += "  " + w + "\n";
  const auto list = [&](const std::string& what, const std::vector<MeshFile::Set>& sets) {
    for (const auto& s : sets)
      text += "  " + what + " '" + s.name + "'" + (s.title.empty() ? "" : " (" + s.title + ")") +
              ": " +
              (s.faces.empty() ? std::to_string(s.nodes.size()) + " nodes"
                               : std::to_string(s.faces.size()) + " faces") +
              "\n";
  };
  list("set", file.sets());
  list("property", file.properties());
  const auto name = [&](int v) { return std::to_string(file.node_label(v)); };
  const PreparedMesh prepared = [&] {
    try {
      return prepare(shells, name);
    } catch (const InputError& e) {
      throw InputError(path.string() + ": " + e.what() + "\n" + text);
    }
  }();
  for (const auto& note : prepared.notes) text += "  " + note + "\n";
  const QualitySummary q = summarize(shells, shells.points);
  text += "  worst aspect " + number(q.aspect.worst) + ", warpage " +
          number(q.warpage_degrees.worst) + " degrees, Jacobian " + number(q.jacobian.worst) + "\n";
  const auto where = [](const HoleMeasure& m) {
    return "centre (" + number(m.centre[0]) + ", " + number(m.centre[1]) + ", " +
           number(m.centre[2]) + ")" +
           (m.circular ? ", radius " + number(m.radius)
                       : ", perimeter " + number(m.perimeter) + ", no circle");
  };
  const auto& loops = prepared.mesh.topology().boundary_loops();
  for (size_t l = 0; l < loops.size(); ++l)
    text += "  loop " + std::to_string(l + 1) + ": " + std::to_string(loops[l].size()) +
            " nodes, " + where(measure_hole(shells.points, loops[l])) + "\n";
  for (const auto& p : propose_features(prepared.mesh))
    text += "  feature '" + p.name + "': " + std::to_string(p.vertices.size()) + " nodes, " +
            where(p.measure) + "\n";
  return text;
}

}  // namespace batten
