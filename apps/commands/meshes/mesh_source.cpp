#include "batten/apps/commands/meshes/mesh_source.h"

#include "batten/core/errors.h"

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

}  // namespace batten
