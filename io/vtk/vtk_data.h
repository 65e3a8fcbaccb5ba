// SPDX-License-Identifier: MPL-2.0
// Reads the data sets of VTK files.
#pragma once

#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <string>

class vtkDataObject;

namespace batten {

/// Reads a .vtp, .vtu or legacy .vtk file: polygons, or an unstructured grid. In a child process, if
/// enable_sandboxed_read() has enabled that. Throws InputError for other files and damaged ones.
vtkSmartPointer<vtkPointSet> read_vtk_data(const std::filesystem::path& path);

/// The text of a legacy file. `version`: one of vtkDataWriter; `title`: empty for that of VTK.
std::string legacy_vtk_text(vtkDataObject* data, bool binary, int version,
                            const std::string& title);

}  // namespace batten
