// Reads a STEP, IGES or BREP file into OpenCASCADE shapes with their attributes.
#pragma once

#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_format.h"

// The header data of CAD files: schema and length unit.

class IGESData_IGESModel;
class StepData_StepModel;

namespace batten {

/// Schema and length unit declared by a file.
struct CadHeader {
  CadFormat format = CadFormat::Step;
  std::string schema;            ///< STEP: the schema name in the file; IGES: the version; else ""
  double unit_in_metres = 1e-3;  ///< length unit
  /// False if the file declares none and `unit_in_metres` is the usual default.
  bool unit_stated = false;
  std::string note;  ///< remark on an unusual or missing unit; "" if there is none
};

/// Reads schema and unit of a STEP file. If its parts have different units, the header has the unit
/// of the first, and `note` reports it.
CadHeader step_header(const StepData_StepModel& model);

/// Reads version and unit of an IGES file. Without a declared unit it is in inches, as the standard
/// prescribes.
CadHeader iges_header(const IGESData_IGESModel& model);

/// The header of a BREP file. The format has no unit; mm is assumed.
CadHeader brep_header();
/// The header of a file of spline patches. The format has no unit; mm is assumed.
CadHeader patches_header();

/// The shapes of a file, in millimetres, with the labels of its edges.
struct CadFile {
  TopoDS_Compound shape;
  TopTools_IndexedMapOfShape edges, faces;
  std::vector<std::string> labels;  // label of each edge in `edges`; "" if it has none
  std::string found;                // number or kinds of entities in the file, for messages
  /// The product structure with placements, names, colours and layers. `document` and `header` are
  /// set by read_cad_here() only.
  Handle(TDocStd_Document) document;
  CadHeader header;
};

/// Reads a file, in a child process if is_sandboxed_read_enabled(). Throws InputError as
/// read_cad_lines() does for files and entities.
CadFile read_cad(const std::filesystem::path& file);

/// Reads a file in this process, with its attributes. Use it in functions that run in a child
/// process as a whole. Throws as read_cad().
CadFile read_cad_here(const std::filesystem::path& file);

/// Creates an empty document for products and attributes, with the given length unit.
Handle(TDocStd_Document) new_document(double unit_in_metres = 1e-3);

}  // namespace batten
