// SPDX-License-Identifier: MPL-2.0
// Writes a mesh and reads it again.
#include <batten/io/meshes/mesh_file.h>

#include <cstdio>

int main() {
  batten::ShellMesh mesh;
  mesh.points.resize(3, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  mesh.add_face(std::array{0, 1, 2});
  batten::write_mesh("consumer.vtu", mesh);
  const batten::ShellMesh read = batten::MeshFile::read("consumer.vtu").shells();
  std::printf("%d nodes, %d faces\n", read.node_count(), read.face_count());
  return read.points == mesh.points && read.face_count() == 1 ? 0 : 1;
}
