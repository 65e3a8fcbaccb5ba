// Reads an IGES or STEP file into OpenCASCADE's shapes. Internal.
#pragma once

#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// The shapes of a file, in millimetres, and the labels of its edges.
struct CadFile {
  TopoDS_Compound shape;
  TopTools_IndexedMapOfShape edges, faces;
  std::vector<std::string> labels;  // label of each edge; "" for none
  std::string found;                // kinds of entities in the file, for messages
};

/// Reads a file. Throws InputError as read_cad_lines() does of files and entities.
CadFile read_cad(const std::filesystem::path& file);

}  // namespace batten
