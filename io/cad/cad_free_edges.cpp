#include "batten/io/cad/cad_free_edges.h"

#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Iterator.hxx>
#include <algorithm>
#include <vector>

namespace batten {

TopTools_IndexedMapOfShape free_edges_of(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges, free_edges;
  std::vector<int> uses;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
    for (TopExp_Explorer edge(face.Current(), TopAbs_EDGE); edge.More(); edge.Next()) {
      const auto number = static_cast<size_t>(edges.Add(edge.Current()));
      uses.resize(std::max(uses.size(), number), 0);
      ++uses[number - 1];  // a seam is there twice
    }
  for (int e = 1; e <= edges.Extent(); ++e)
    if (uses[static_cast<size_t>(e) - 1] == 1 && !BRep_Tool::Degenerated(TopoDS::Edge(edges(e))))
      free_edges.Add(edges(e));
  return free_edges;
}

namespace {

/// Closed shells look outwards.
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
  TopTools_IndexedMapOfShape found;  // with their orientations
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
