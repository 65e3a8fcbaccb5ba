// Deformed shell meshes as VTK's files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// What was done to each node.
struct DeformedData {
  Points displacement;       ///< n×3
  std::vector<int> feature;  ///< index into feature_names, -1 for none; n
  std::vector<std::string> feature_names;
};

/// The faces as polygons; faces of second order through all their nodes in the order in which they
/// lie around them. Double precision.
vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points);

/// The mesh at its nodes' present places as a .vtp file, with point data Displacement and Feature
/// and field data Feature_names. Whole or not at all. Throws InputError.
void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data);

}  // namespace batten
