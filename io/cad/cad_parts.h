// The parts of a CAD document at their places, with names and colours of their faces. Internal.
#pragma once

#include <TDocStd_Document.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <string>
#include <vector>
#include <TopTools_IndexedMapOfShape.hxx>

#include "batten/io/cad/cad_contents.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A face at its place. Names and colour are "" for none; a colour may be inherited.
struct CadFace {
  TopoDS_Face face;
  std::string name, colour;
  std::string solid = {};  ///< the name of the solid or shell that it is in
};

/// A curve: an edge at its place.
struct CadCurveItem {
  TopoDS_Edge edge;
  std::string name, colour;
};

/// A solid or shell within a part, at its place.
struct CadBody {
  TopoDS_Shape shape;
  std::string name;
};

/// One instance of a shape that is no assembly.
struct CadPart {
  std::string name;    ///< of its product, or of its instance where that says more; "" for none
  TopoDS_Shape shape;  ///< at its place
  std::vector<CadFace> faces;
  std::vector<CadBody> bodies;       ///< those within it that have a name
  std::vector<CadCurveItem> curves;  ///< those that belong to no face
  std::vector<CadCurveItem> edges;   ///< those of faces that have a name, each once
};

struct CadTree {
  std::vector<CadProduct> products;  ///< all, assemblies too, from the top down; shifts in mm
  std::vector<CadPart> parts;
  std::vector<CadAttribute> layers;
};

/// All instances of a document. O(shapes).
CadTree tree_of(const Handle(TDocStd_Document) & document);

/// A document with a product for each part: faces have the names and colours that are given,
/// coordinates are in this unit.
Handle(TDocStd_Document)
    document_of(const std::vector<CadPart>& parts, double unit_in_metres = 1e-3);


// Curves as a part of a CAD document. Internal.

/// A part of edges without faces: one for each spline, in their order and by their names, closed
/// ones with one vertex. STEP has it as a product with a set of curves, which programs show as
/// wires.
CadPart part_of_curves(const std::string& name, const std::vector<CubicSpline>& splines);


// Edges of CAD shapes that have one face only. Internal.

/// The edges of a shape beside which one face lies, once; no seams, none without length. A closed
/// shape has none. O(edges).
TopTools_IndexedMapOfShape free_edges_of(const TopoDS_Shape& shape);

/// The shape with edges within `tolerance` of each other made one; faces in `faces` become those of
/// the result and keep their names; those that sewing drops are left out. Solids become shells, and
/// closed shells look outwards.
TopoDS_Shape sewn(const TopoDS_Shape& shape, double tolerance,
                  std::vector<CadFace>* faces = nullptr);

}  // namespace batten
