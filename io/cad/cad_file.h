// Reads a STEP, IGES or BREP file into OpenCASCADE's shapes and their attributes. Internal.
#pragma once

#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_format.h"

// What CAD files say of themselves: schema and unit of length. Internal.

class IGESData_IGESModel;
class StepData_StepModel;

namespace batten {

/// What a file says of itself.
struct CadHeader {
  CadFormat format = CadFormat::Step;
  std::string schema;            ///< of STEP, as the file names it; of IGES the version; else ""
  double unit_in_metres = 1e-3;  ///< of its lengths
  bool unit_stated = false;      ///< false where the unit is only what such files mostly have
  std::string note;              ///< what is odd about its unit; "" for nothing
};

/// The schema and unit of a STEP file. Where its parts have several units, the header has that of
/// the first, and says so.
CadHeader step_header(const StepData_StepModel& model);

/// The version and unit of an IGES file; without a unit it is in inches, as the standard has it.
CadHeader iges_header(const IGESData_IGESModel& model);

/// BREP has no unit: programs take it for millimetres.
CadHeader brep_header();
/// Nor have sets of patches.
CadHeader patches_header();


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
