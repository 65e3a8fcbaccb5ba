#include "batten/io/cad/measure_contents.h"

#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <algorithm>
#include <cmath>

#include "batten/io/cad/cad_free_edges.h"
#include "batten/io/cad/cad_parts.h"

namespace batten {
namespace {

std::string format_words(const CadHeader& header) {
  if (header.format == CadFormat::Iges) return "IGES";
  if (header.format == CadFormat::Brep) return "BREP";
  if (header.format == CadFormat::Patches) return "patches";
  const auto has = [&](const char* word) { return header.schema.find(word) != std::string::npos; };
  return has("AP242") || has("MANAGED_MODEL_BASED_3D") ? "STEP AP242"
         : has("AUTOMOTIVE_DESIGN")                    ? "STEP AP214"
         : has("CONFIG_CONTROL_DESIGN")                ? "STEP AP203"
                                                       : "STEP " + header.schema;
}

void count(std::vector<CadAttribute>& uses, const std::string& name, int CadAttribute::*what) {
  if (name.empty()) return;
  auto at = std::find_if(uses.begin(), uses.end(),
                         [&](const CadAttribute& use) { return use.name == name; });
  if (at == uses.end()) at = uses.insert(at, CadAttribute{name});
  ++((*at).*what);
}

void measure(const CadPart& part, CadContents& c) {
  GProp_GProps area, volume;
  BRepGProp::SurfaceProperties(part.shape, area, 1e-6);
  c.area += area.Mass();
  TopTools_IndexedMapOfShape solids, shells, edges;
  TopExp::MapShapes(part.shape, TopAbs_SOLID, solids);
  TopExp::MapShapes(part.shape, TopAbs_SHELL, shells);
  TopExp::MapShapes(part.shape, TopAbs_EDGE, edges);
  for (int s = 1; s <= solids.Extent(); ++s) {
    BRepGProp::VolumeProperties(solids(s), volume);
    c.volume += std::abs(volume.Mass());
  }
  for (int e = 1; e <= edges.Extent(); ++e) {
    GProp_GProps length;
    BRepGProp::LinearProperties(edges(e), length);
    c.trim_uncertainty_area += length.Mass() * BRep_Tool::Tolerance(TopoDS::Edge(edges(e)));
  }
  c.solids += solids.Extent();
  c.shells += shells.Extent();
  c.edges += edges.Extent();
  for (int s = 1; s <= shells.Extent(); ++s) c.closed_shells += free_edges_of(shells(s)).IsEmpty();
}

}  // namespace

CadContents contents_of(const CadFile& cad) {
  CadContents c;
  c.format = format_words(cad.header);
  c.unit_in_metres = cad.header.unit_in_metres;
  c.unit_stated = cad.header.unit_stated;
  if (!cad.header.note.empty()) c.notes.push_back(cad.header.note);
  CadTree tree = tree_of(cad.document);
  for (const CadPart& part : tree.parts) {
    measure(part, c);
    c.faces += static_cast<int>(part.faces.size());
    c.curves += static_cast<int>(part.curves.size());
    for (const CadBody& body : part.bodies) count(c.names, body.name, &CadAttribute::solids);
    for (const CadFace& face : part.faces) {
      count(c.names, face.name, &CadAttribute::faces);
      count(c.colours, face.colour, &CadAttribute::faces);
    }
    for (const CadCurveItem& curve : part.curves) {
      count(c.names, curve.name, &CadAttribute::curves);
      count(c.colours, curve.colour, &CadAttribute::curves);
    }
    for (const CadCurveItem& edge : part.edges) {
      count(c.names, edge.name, &CadAttribute::edges);
      count(c.colours, edge.colour, &CadAttribute::edges);
    }
  }
  Bnd_Box box;
  BRepBndLib::AddOptimal(cad.shape, box, false, false);
  const double unit = 1e-3 / c.unit_in_metres;  // a millimetre in the file's unit
  c.size = box.IsVoid() ? 0 : std::sqrt(box.SquareExtent()) * unit;
  for (double* area : {&c.area, &c.trim_uncertainty_area}) *area *= unit * unit;
  c.volume *= unit * unit * unit;
  c.products = std::move(tree.products);
  for (CadProduct& product : c.products) product.translation *= unit;
  c.layers = std::move(tree.layers);
  return c;
}

}  // namespace batten
