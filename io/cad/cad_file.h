// SPDX-License-Identifier: MPL-2.0
// Reads a STEP, IGES or BREP file into OpenCASCADE shapes with their attributes; curves and names of
// its edges, and shape healing.
#pragma once

#include <Geom_Curve.hxx>
#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
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
  /// Names of `faces` after heal_shape(): "face 1" … in file order, "face 1.1" … for the parts of a
  /// divided face. Empty before.
  std::vector<std::string> face_names;
  std::string found;  // number or kinds of entities in the file, for messages
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

// Curves and names of edges.

/// The edge's 3D curve with its parameter range, in the global frame; null for an edge of length
/// zero.
Handle(Geom_Curve) curve_of(const TopoDS_Edge& edge, double& start, double& end);

/// The names of the edges of a file, in file order, as documented at read_cad_lines(); "" for edges
/// of length zero.
std::vector<std::string> edge_names(const CadFile& cad);

// Prepares CAD files for fitting a model to them.

/// True if the face is on both sides of the edge. (BRep_Tool::IsClosed() alone is also true for
/// former seams along which a face was divided.)
bool is_seam(const TopoDS_Edge& edge, const TopoDS_Face& face);

/// True if a face is a tube: it has a seam and two boundary loops without corners, and no pole. From
/// one loop to the other, it bends by less than their radius.
bool is_tube(const TopoDS_Face& face);

/// Merges coincident edges of faces that have edges of their own, as in IGES files: edges within 1e-5
/// of the model size of each other. Does nothing if no free edges coincide.
void merge_coincident_edges(CadFile& cad);

/// Merges coincident edges (merge_coincident_edges()), splits faces at creases and divides closed faces.
///
/// Faces are split along the curves where their surface is only C0
/// (knots as multiple as the degree). There the surface may have an angle like at an edge, so a
/// curve is needed. Faces with a seam other than tubes (spheres, tori, cones with an apex, cylinders
/// with holes) are divided along isoparametric curves, so that no part has the same curve on both
/// sides: in halves, and in quarters around a pole. These curves have the label "division". Parts of
/// a split edge keep its label. Other faces and edges do not change. A face that OpenCASCADE cannot
/// divide into valid parts stays whole.
void heal_shape(CadFile& cad);

}  // namespace batten
