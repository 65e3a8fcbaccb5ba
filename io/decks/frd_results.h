// Reads results of CalculiX.
#pragma once

#include <filesystem>
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

}  // namespace batten
