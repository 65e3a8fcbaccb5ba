// Reads a STEP, IGES or BREP file into OpenCASCADE's shapes and their attributes. Internal.
#pragma once

#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_unit.h"

namespace batten {

/// The shapes of a file, in millimetres, and the labels of its edges.
struct CadFile {
  TopoDS_Compound shape;
  TopTools_IndexedMapOfShape edges, faces;
  std::vector<std::string> labels;  // label of each edge; "" for none
  std::string found;                // kinds of entities in the file, for messages
  /// Products with their places, names, colours and layers; and the header. Of read_cad_here()
  /// only.
  Handle(TDocStd_Document) document;
  CadHeader header;
};

/// Reads a file, in a child process if is_sandboxed_read_enabled(). Throws InputError as read_cad_lines() does
/// of files and entities.
CadFile read_cad(const std::filesystem::path& file);

/// Reads a file in this process, with its attributes: for functions that run in a child as a whole.
/// Throws as read_cad().
CadFile read_cad_here(const std::filesystem::path& file);

/// An empty document for products and their attributes, with lengths in this unit.
Handle(TDocStd_Document) new_document(double unit_in_metres = 1e-3);

}  // namespace batten
