// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_parts.h"

#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineCurve.hxx>
#include <NCollection_DataMap.hxx>
#include <Quantity_Color.hxx>
#include <TColStd_HSequenceOfExtendedString.hxx>
#include <TCollection_AsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Vertex.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "batten/core/containers.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

std::string utf8(const TCollection_ExtendedString& text) {
  std::vector<char> bytes(static_cast<size_t>(text.LengthOfCString()) + 1, '\0');
  Standard_PCharacter data = bytes.data();
  text.ToUTF8CString(data);
  return bytes.data();
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  return utf8(name->Get());
}

/// The colours that a shape gives to its faces and to its curves; "" for none.
struct Colours {
  std::string surface, curve;
  Colours over(const Colours& inherited) const {
    return {surface.empty() ? inherited.surface : surface, curve.empty() ? inherited.curve : curve};
  }
};

std::string hex(const Quantity_Color& colour) {
  std::string text = Quantity_Color::ColorToHex(colour).ToCString();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Attributes of a subshape of a part in the document.
struct Attributes {
  std::string name;
  Colours colours;
};

class Walker {
 public:
  explicit Walker(const Handle(TDocStd_Document) & document)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
        colours_(XCAFDoc_DocumentTool::ColorTool(document->Main())),
        layers_(XCAFDoc_DocumentTool::LayerTool(document->Main())) {}

  CadTree walk() {
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    for (const TDF_Label& root : roots) visit(root, TopLoc_Location(), {}, 0);
    return std::move(tree_);
  }

 private:
  Colours colours_of(const TDF_Label& label) const {
    Quantity_Color colour;
    Colours result;
    if (colours_->GetColor(label, XCAFDoc_ColorGen, colour))
      result.surface = result.curve = hex(colour);
    if (colours_->GetColor(label, XCAFDoc_ColorSurf, colour)) result.surface = hex(colour);
    if (colours_->GetColor(label, XCAFDoc_ColorCurv, colour)) result.curve = hex(colour);
    return result;
  }

  void count_layers(const TDF_Label& label, int CadAttribute::*what) {
    Handle(TColStd_HSequenceOfExtendedString) names;
    if (!layers_->GetLayers(label, names) || names.IsNull()) return;
    for (const TCollection_ExtendedString& text : names->Sequence()) {
      const std::string name = utf8(text);
      auto at = std::find_if(tree_.layers.begin(), tree_.layers.end(),
                             [&](const CadAttribute& use) { return use.name == name; });
      if (at == tree_.layers.end()) at = tree_.layers.insert(at, CadAttribute{name});
      ++((*at).*what);
    }
  }

  /// Visits a label that is an instance, an assembly or a shape. `place`: the placement of its
  /// parent.
  void visit(TDF_Label label, TopLoc_Location place, Colours inherited, int level) {
    CadProduct product;
    product.level = level;
    Colours own = colours_of(label);
    if (XCAFDoc_ShapeTool::IsReference(label)) {
      product.instance_name = name_of(label);
      place = place * XCAFDoc_ShapeTool::GetLocation(label);
      TDF_Label referred;
      XCAFDoc_ShapeTool::GetReferredShape(label, referred);
      label = referred;
      own = own.over(colours_of(label));
    }
    product.name = name_of(label);
    if (product.instance_name == product.name) product.instance_name.clear();
    product.colour = own.surface.empty() ? own.curve : own.surface;
    product.assembly = XCAFDoc_ShapeTool::IsAssembly(label);
    const gp_Trsf move = place.Transformation();
    product.translation = {move.TranslationPart().X(), move.TranslationPart().Y(),
                           move.TranslationPart().Z()};
    gp_XYZ axis;
    double angle = 0;
    if (move.GetRotation(axis, angle))
      product.rotation_deg = std::abs(angle) * 180 / std::numbers::pi;
    count_layers(label, &CadAttribute::products);
    const size_t at = tree_.products.size();
    tree_.products.push_back(product);
    const Colours colours = own.over(inherited);
    if (product.assembly) {
      TDF_LabelSequence components;
      XCAFDoc_ShapeTool::GetComponents(label, components);
      for (const TDF_Label& component : components) visit(component, place, colours, level + 1);
    } else {
      add_part(label, place, colours, at);
    }
  }

  void add_part(const TDF_Label& label, const TopLoc_Location& place, const Colours& colours,
                size_t product) {
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    CadProduct& of = tree_.products[product];
    if (shape.IsNull()) return;
    TDF_LabelSequence parts;
    XCAFDoc_ShapeTool::GetSubShapes(label, parts);
    Within within;
    for (const TDF_Label& part : parts) {
      const TopoDS_Shape inner = XCAFDoc_ShapeTool::GetShape(part);
      if (inner.IsNull()) continue;
      within.Bind(inner, {name_of(part), colours_of(part)});
      count_layers(part,
                   inner.ShapeType() == TopAbs_EDGE ? &CadAttribute::curves : &CadAttribute::faces);
    }
    CadPart result;
    result.name = of.name.empty() ? of.instance_name : of.name;
    result.shape = shape.Moved(place);
    // A product that is a single face or edge gives its name to it.
    const bool single = shape.ShapeType() == TopAbs_FACE || shape.ShapeType() == TopAbs_EDGE;
    if (single && !within.IsBound(shape)) within.Bind(shape, {result.name, {}});
    collect(shape, place, within, colours, "", result);
    add_named_edges(shape, place, within, result);
    for (TopExp_Explorer s(shape, TopAbs_SOLID); s.More(); s.Next()) ++of.solids;
    of.faces = isize(result.faces);
    of.curves = isize(result.curves);
    tree_.parts.push_back(std::move(result));
  }

  using Within = NCollection_DataMap<TopoDS_Shape, Attributes, TopTools_ShapeMapHasher>;

  /// Adds the faces and free curves of a shape; edges of faces are not visited. `solid`: the name
  /// of the innermost named shape that contains it.
  void collect(const TopoDS_Shape& shape, const TopLoc_Location& place, const Within& within,
               const Colours& inherited, const std::string& solid, CadPart& part) const {
    const Attributes* own = within.Seek(shape);
    const Colours colours = own ? own->colours.over(inherited) : inherited;
    const std::string name = own ? own->name : "";
    if (shape.ShapeType() == TopAbs_FACE) {
      part.faces.push_back({TopoDS::Face(shape.Moved(place)), name, colours.surface, solid});
    } else if (shape.ShapeType() == TopAbs_EDGE) {
      part.curves.push_back({TopoDS::Edge(shape.Moved(place)), name, colours.curve});
    } else {
      if (!name.empty()) part.bodies.push_back({shape.Moved(place), name});
      for (TopoDS_Iterator it(shape); it.More(); it.Next())
        collect(it.Value(), place, within, colours, name.empty() ? solid : name, part);
    }
  }

  static void add_named_edges(const TopoDS_Shape& shape, const TopLoc_Location& place,
                              const Within& within, CadPart& part) {
    TopTools_IndexedMapOfShape edges;
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
      TopExp::MapShapes(face.Current(), TopAbs_EDGE, edges);
    for (int e = 1; e <= edges.Extent(); ++e)
      if (const Attributes* own = within.Seek(edges(e)); own && !own->name.empty())
        part.edges.push_back({TopoDS::Edge(edges(e).Moved(place)), own->name, own->colours.curve});
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colours_;
  Handle(XCAFDoc_LayerTool) layers_;
  CadTree tree_;
};

}  // namespace

CadTree tree_of(const Handle(TDocStd_Document) & document) { return Walker(document).walk(); }

Handle(TDocStd_Document) document_of(const std::vector<CadPart>& parts, double unit_in_metres) {
  const Handle(TDocStd_Document) document = new_document(unit_in_metres);
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const auto colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const auto text = [](const std::string& s) {
    return TCollection_ExtendedString(s.c_str(), true);
  };
  const auto describe = [&](const TDF_Label& label, const std::string& name,
                            const std::string& hex_colour, XCAFDoc_ColorType type) {
    if (label.IsNull()) return;
    if (!name.empty()) TDataStd_Name::Set(label, text(name));
    Quantity_Color colour;
    if (!hex_colour.empty() && Quantity_Color::ColorFromHex(hex_colour.c_str(), colour))
      colours->SetColor(label, colour, type);
  };
  for (const CadPart& part : parts) {
    const TDF_Label product = shapes->AddShape(part.shape, false);
    describe(product, part.name, "", XCAFDoc_ColorSurf);
    for (const CadBody& body : part.bodies)
      describe(shapes->AddSubShape(product, body.shape), body.name, "", XCAFDoc_ColorSurf);
    for (const CadFace& face : part.faces)
      describe(shapes->AddSubShape(product, face.face), face.name, face.colour, XCAFDoc_ColorSurf);
    for (const CadCurveItem& curve : part.curves)
      describe(shapes->AddSubShape(product, curve.edge), curve.name, curve.colour,
               XCAFDoc_ColorCurv);
    for (const CadCurveItem& edge : part.edges)
      describe(shapes->AddSubShape(product, edge.edge), edge.name, edge.colour, XCAFDoc_ColorCurv);
  }
  return document;
}

namespace {

TopoDS_Edge edge_of(const CubicSpline& spline, double tolerance) {
  BRep_Builder builder;
  TopoDS_Vertex first, last;
  builder.MakeVertex(first, to_occ(spline.poles.front()), tolerance);
  if (spline.closed)
    last = first;
  else
    builder.MakeVertex(last, to_occ(spline.poles.back()), tolerance);
  TopoDS_Edge edge;
  builder.MakeEdge(edge, to_occ(spline), tolerance);
  builder.Add(edge, first.Oriented(TopAbs_FORWARD));
  builder.Add(edge, last.Oriented(TopAbs_REVERSED));
  builder.Range(edge, spline.knots.front(), spline.knots.back());
  return edge;
}

}  // namespace

CadPart part_of_curves(const std::string& name, const std::vector<CubicSpline>& splines) {
  double size = 0;
  for (const CubicSpline& spline : splines) size = std::max(size, spline.size);
  CadPart part;
  part.name = name;
  TopoDS_Compound compound;
  BRep_Builder builder;
  builder.MakeCompound(compound);
  for (const CubicSpline& spline : splines) {
    part.curves.push_back({edge_of(spline, 1e-9 * size), spline.name, ""});
    builder.Add(compound, part.curves.back().edge);
  }
  part.shape = compound;
  return part;
}

TopTools_IndexedMapOfShape free_edges_of(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges, free_edges;
  std::vector<int> uses;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
    for (TopExp_Explorer edge(face.Current(), TopAbs_EDGE); edge.More(); edge.Next()) {
      const auto number = static_cast<size_t>(edges.Add(edge.Current()));
      uses.resize(std::max(uses.size(), number), 0);
      ++uses[number - 1];  // a seam occurs twice
    }
  for (int e = 1; e <= edges.Extent(); ++e)
    if (uses[static_cast<size_t>(e) - 1] == 1 && !BRep_Tool::Degenerated(TopoDS::Edge(edges(e))))
      free_edges.Add(edges(e));
  return free_edges;
}

namespace {

/// Orients closed shells outwards.
TopoDS_Shape outwards(const TopoDS_Shape& shape) {
  const bool single = shape.ShapeType() != TopAbs_COMPOUND;
  TopoDS_Compound result;
  BRep_Builder builder;
  builder.MakeCompound(result);
  const auto turned = [](const TopoDS_Shape& part) {
    if (part.ShapeType() != TopAbs_SHELL || !free_edges_of(part).IsEmpty()) return part;
    GProp_GProps volume;
    BRepGProp::VolumeProperties(part, volume);
    return volume.Mass() < 0 ? part.Reversed() : part;
  };
  if (single) return turned(shape);
  for (TopoDS_Iterator it(shape); it.More(); it.Next()) builder.Add(result, turned(it.Value()));
  return result;
}

}  // namespace

TopoDS_Shape sewn(const TopoDS_Shape& shape, double tolerance, std::vector<CadFace>* faces) {
  BRepBuilderAPI_Sewing sewing(tolerance);
  sewing.Add(shape);
  sewing.Perform();
  if (sewing.SewedShape().IsNull()) return shape;
  const TopoDS_Shape result = outwards(sewing.SewedShape());
  if (!faces) return result;
  TopTools_IndexedMapOfShape found;  // keeps the orientation of each face
  TopExp::MapShapes(result, TopAbs_FACE, found);
  std::vector<CadFace> kept;
  for (const CadFace& face : *faces) {
    const int at =
        found.FindIndex(sewing.IsModifiedSubShape(face.face) ? sewing.ModifiedSubShape(face.face)
                                                             : TopoDS_Shape(face.face));
    if (at > 0) kept.push_back({TopoDS::Face(found(at)), face.name, face.colour, face.solid});
  }
  *faces = std::move(kept);
  return result;
}

}  // namespace batten
