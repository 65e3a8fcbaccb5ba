// Reads results of CalculiX.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Displacements and stresses at the nodes of a .frd file, of its last step. CalculiX makes solids of
/// shells: the nodes are those of their corners, on both sides.
struct FrdResults {
  struct Node {
    Vec3 x = Vec3::Zero(), displacement = Vec3::Zero();
    Mat3 stress = Mat3::Zero();
  };
  std::vector<Node> nodes;
};

/// Reads a .frd file in text form (ccx writes it for *NODE FILE, U and *EL FILE, S). Throws
/// InputError: no such file, no results in it, a line that cannot be read.
FrdResults read_frd(const std::filesystem::path& path);

/// Nodes and elements of a .frd file.
struct FrdMesh {
  struct Element {
    int label = 0, type = 0;  ///< types as .frd has them: 1 is C3D8, 7 is S3
    std::vector<int> nodes;   ///< indices, in the order of .frd
  };
  std::vector<int> labels;  ///< of nodes, ascending
  Points points;
  std::vector<Element> elements;
};

/// Reads the mesh, then each step's displacements (n×3; zero at nodes that have none) as it comes:
/// `step` is called with the value of the step (a time, a frequency, a factor of buckling). Memory:
/// the mesh and one step. Throws as read_frd(), and for an element whose nodes are not there.
FrdMesh read_frd_steps(
    const std::filesystem::path& path,
    const std::function<void(const FrdMesh&, double value, const Points& displacements)>& step);

/// A face: corners, then middle nodes if it has any.
struct FrdFace {
  int element = 0;
  std::vector<int> nodes;
  bool second_order = false;
};

/// The skin: faces of solids that no other solid has, pointing outwards, and the shells themselves
/// (types 1 to 10; beams have no faces). O(faces).
std::vector<FrdFace> outer_faces(const FrdMesh& mesh);

}  // namespace batten
