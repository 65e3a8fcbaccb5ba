// SPDX-License-Identifier: MPL-2.0
// Reads CalculiX result files (.frd): displacements, stresses, the mesh and its outer faces.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Displacements and stresses at the nodes of a .frd file, in the last step of the file. CalculiX
/// expands shell elements to solid elements, so the nodes of a shell are the corners of these
/// solids, on both sides of the mid-surface.
struct FrdResults {
  struct Node {
    Vec3 x = Vec3::Zero(), displacement = Vec3::Zero();
    Mat3 stress = Mat3::Zero();
  };
  std::vector<Node> nodes;
};

/// Reads the displacements and stresses from a .frd file in text form (long or short), as ccx writes
/// it for *NODE FILE, U and *EL FILE, S. Throws InputError if the file is missing, without results,
/// or invalid.
FrdResults read_frd(const std::filesystem::path& path);

/// The nodes and elements of a .frd file.
struct FrdMesh {
  struct Element {
    int label = 0, type = 0;  ///< element number, and type code of .frd (1: C3D8, 7: S3)
    std::vector<int> nodes;   ///< indices into FrdMesh::points, in the node order of .frd files
  };
  std::vector<int> labels;  ///< node numbers in the file, ascending
  Points points;
  std::vector<Element> elements;
};

/// Reads the mesh of a CalculiX result file (.frd), then calls `step` for each step of the results.
/// The arguments of `step` are the mesh, the value of the step (time, frequency or buckling factor)
/// and the displacements of the nodes (n×3; zero at nodes without a value). Only the mesh and one
/// step are held in memory. Throws InputError as read_frd(), and for an element with unknown nodes.
FrdMesh read_frd_steps(
    const std::filesystem::path& path,
    const std::function<void(const FrdMesh&, double value, const Points& displacements)>& step);

/// A face of an element: corner nodes, followed by mid-side nodes if the element is of second
/// order.
struct FrdFace {
  int element = 0;
  std::vector<int> nodes;
  bool second_order = false;
};

/// The outer faces of a mesh: the faces that belong to exactly one solid element, oriented
/// outwards, and all shell elements. Supports the element types 1 to 10; beams have no faces.
/// O(faces).
std::vector<FrdFace> outer_faces(const FrdMesh& mesh);

/// Numbers of the table of a .dat file of ccx: natural frequencies (cycles per time) and buckling
/// factors; empty if it has none. Throws InputError if the file cannot be read.
std::vector<double> read_ccx_frequencies(const std::filesystem::path& path);
std::vector<double> read_ccx_buckling_factors(const std::filesystem::path& path);

}  // namespace batten
