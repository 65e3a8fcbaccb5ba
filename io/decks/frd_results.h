// Reads CalculiX results (.frd): displacements, stresses, mesh and outer faces.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Displacements and stresses at the nodes of a .frd file, for its last step. CalculiX expands
/// shells to solids: the nodes are the corners of these solids, on both sides of the shell.
struct FrdResults {
  struct Node {
    Vec3 x = Vec3::Zero(), displacement = Vec3::Zero();
    Mat3 stress = Mat3::Zero();
  };
  std::vector<Node> nodes;
};

/// Reads a .frd file in text form (ccx writes it for *NODE FILE, U and *EL FILE, S). Throws
/// InputError: a missing file, a file without results, an invalid line.
FrdResults read_frd(const std::filesystem::path& path);

/// Nodes and elements of a .frd file.
struct FrdMesh {
  struct Element {
    int label = 0, type = 0;  ///< type codes of .frd: 1 is C3D8, 7 is S3
    std::vector<int> nodes;   ///< 0-based node indices, in the order of .frd
  };
  std::vector<int> labels;  ///< node labels, ascending
  Points points;
  std::vector<Element> elements;
};

/// Reads the mesh, then calls `step` for each step as it is read, with its value (a time, frequency
/// or buckling factor) and its displacements (n×3; zero at nodes without a value). Only the mesh
/// and one step are held in memory. Throws as read_frd(), and for an element with unknown nodes.
FrdMesh read_frd_steps(
    const std::filesystem::path& path,
    const std::function<void(const FrdMesh&, double value, const Points& displacements)>& step);

/// A face: corner nodes, followed by mid-side nodes if it is of second order.
struct FrdFace {
  int element = 0;
  std::vector<int> nodes;
  bool second_order = false;
};

/// The skin of a mesh: faces that belong to one solid only, oriented outwards, and all shells
/// (types 1 to 10; beams have no faces). O(faces).
std::vector<FrdFace> outer_faces(const FrdMesh& mesh);

}  // namespace batten
