#include "batten/apps/commands/exchange/file_kinds.h"

#include <fstream>
#include <string>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/apps/commands/sequences/sequence_info.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"

namespace batten {
namespace {

/// Lines and meshes share endings: a mesh has faces, a Nastran deck grid points.
bool is_mesh_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  if (ending != ".obj" && ending != ".dat") return MeshFile::can_read(file);
  std::ifstream in(file);
  for (std::string row; std::getline(in, row);)
    if (ending == ".obj" ? row.starts_with("f ")
                         : row.starts_with("GRID") || row.starts_with("BEGIN BULK"))
      return true;
  return false;
}

}  // namespace

FileKind file_kind(const std::filesystem::path& file) {
  if (file.extension() == ".toml") return FileKind::Scene;
  if (is_mesh_file(file)) return FileKind::Mesh;
  if (is_sequence_file(file)) return FileKind::Sequence;
  switch (line_file_kind(file)) {
    case LineFileKind::None:
      return FileKind::None;
    case LineFileKind::Cad:
      return FileKind::Cad;
    default:
      return FileKind::Lines;
  }
}

}  // namespace batten
