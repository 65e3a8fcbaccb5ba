// Where the nodes of an Abaqus part are: systems of coordinates and the part's instance. Internal.
#pragma once

#include <map>
#include <string>

#include "batten/io/meshes/abaqus_lines.h"
#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {

class AbaqusCoordinates {
 public:
  explicit AbaqusCoordinates(MeshSourceText& file) : file_(file) {}

  /// *SYSTEM: its lines of data say in which system *NODE gives coordinates from now on.
  void read_system(const Keyword& keyword, AbaqusLines& lines);
  /// *INSTANCE of the part: its lines of data move all nodes, then turn them about a line.
  void read_instance(AbaqusLines& lines);
  /// Whether the instance is somewhere else than the part.
  bool is_instance_transformed() const { return moves_; }
  /// The index of the system of the nodes that follow, with the value of SYSTEM=; -1: global.
  int system_of(const Keyword& node_keyword);
  /// Moves the nodes of a finished mesh to their places. `systems`: of each node, as system_of()
  /// gave them.
  void transform_nodes(TextMeshContent& mesh, std::vector<int> systems) const;

  /// *PARAMETER: numbers by name, which stand in "<name>".
  void read_parameters(AbaqusLines& lines);
  /// The number that a coordinate stands for; `parameter` says whether it is one by name.
  double real(std::string_view value, bool& parameter) const;

 private:
  MeshSourceText& file_;
  CoordinateFrame frame_;  // of *SYSTEM
  bool local_ = false;
  std::vector<CoordinateSystemDefinition> plans_;
  std::map<std::string, double> parameters_;
  Mat3 rotation_ = Mat3::Identity();
  Vec3 translation_ = Vec3::Zero();
  bool moves_ = false;
};

}  // namespace batten
