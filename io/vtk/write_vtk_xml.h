// Writes VTK's XML files. Internal.
#pragma once

#include <filesystem>

class vtkDataObject;
class vtkXMLWriter;

namespace batten {

/// Writes `data` with the writer: binary appended, compressed. The file appears whole or not at
/// all. Throws InputError when it cannot be written.
void write_vtk_xml(vtkXMLWriter& writer, vtkDataObject* data, const std::filesystem::path& path);

}  // namespace batten
