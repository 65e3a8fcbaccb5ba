// Writes deformed shell meshes as VTK's files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// What a deformation did to each of the n nodes.
struct DeformedData {
  Points displacement;       ///< displacement of each node, n×3
  std::vector<int> feature;  ///< index of each node's feature in feature_names, -1 for none
  std::vector<std::string> feature_names;
};

/// The faces as polygons in VTK's data, in double precision. A face of second order is a polygon
/// through all its nodes, in the order in which they lie around it.
vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points);

/// Writes the mesh, its nodes at `shells.points`, as a .vtp file with point data Displacement and
/// Feature and field data Feature_names. It appears whole or not at all. Throws InputError when it
/// cannot be written.
void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data);

}  // namespace batten
