// How Batten writes VTK's XML files. Internal.
#pragma once

#include <filesystem>

class vtkDataObject;
class vtkXMLWriter;

namespace batten {

/// Binary appended, compressed; whole or not at all. Throws InputError.
void write_xml(vtkXMLWriter& writer, vtkDataObject* data, const std::filesystem::path& path);

}  // namespace batten
