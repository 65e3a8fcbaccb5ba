// SPDX-License-Identifier: MPL-2.0
// The placed parts of a CAD document, with names and colours of their faces, and sewing.
#pragma once

#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <string>
#include <vector>

#include "batten/fem/curves/bspline.h"
#include "batten/io/cad/cad_contents.h"

namespace batten {

/// A placed face. Name and colour are "" if there is none; the colour may be inherited.
struct CadFace {
  TopoDS_Face face;
  std::string name, colour;
  std::string solid = {};  ///< name of the solid or shell that contains it; "" if it has none
};

/// A curve: a placed edge.
struct CadCurveItem {
  TopoDS_Edge edge;
  std::string name, colour;
};

/// A placed solid or shell within a part.
struct CadBody {
  TopoDS_Shape shape;
  std::string name;
};

/// One instance of a shape that is not an assembly.
struct CadPart {
  std::string name;    ///< of the product, else of the instance; "" if neither has one
  TopoDS_Shape shape;  ///< placed in the global frame
  std::vector<CadFace> faces;
  std::vector<CadBody> bodies;       ///< the named solids and shells within the part
  std::vector<CadCurveItem> curves;  ///< edges that belong to no face
  std::vector<CadCurveItem> edges;   ///< named edges of faces, each listed once
};

/// All instances of a document.
struct CadTree {
  std::vector<CadProduct> products;  ///< parts and assemblies, depth first; translations in mm
  std::vector<CadPart> parts;
  std::vector<CadAttribute> layers;
};

/// Collects all instances of a document. O(number of shapes).
CadTree tree_of(const Handle(TDocStd_Document) & document);

/// Creates a document with one product per part, in the given length unit. Names and colours of
/// faces and curves are those in `parts`.
Handle(TDocStd_Document)
    document_of(const std::vector<CadPart>& parts, double unit_in_metres = 1e-3);

// Curves as a part of a CAD document.

/// Creates a part of free edges: one for each spline, in the same order and with the same names. A
/// closed spline gets one vertex. In STEP this becomes a product with a geometric curve set, which
/// CAD programs show as wires.
CadPart part_of_curves(const std::string& name, const std::vector<CubicSpline>& splines);

// Free edges of CAD shapes, and sewing.

/// The free edges of a shape: those with exactly one adjacent face, each listed once. Seams and
/// degenerate edges are not included. A closed shape has none. O(edges).
TopTools_IndexedMapOfShape free_edges_of(const TopoDS_Shape& shape);

/// Sews edges that lie within `tolerance` of each other. `faces` is updated to the resulting faces,
/// which keep their names; faces that sewing drops are removed from it. Solids become shells.
/// Closed shells are oriented outwards.
TopoDS_Shape sewn(const TopoDS_Shape& shape, double tolerance,
                  std::vector<CadFace>* faces = nullptr);

}  // namespace batten
