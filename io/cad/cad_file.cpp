#include "batten/io/cad/cad_file.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_Line.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepData_StepModel.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/patch_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/sandboxed_read.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

std::string trimmed(const Handle(TCollection_HAsciiString) & text) {
  if (text.IsNull()) return "";
  std::string s = text->ToCString();
  const auto is_blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  s.erase(s.begin(), std::find_if_not(s.begin(), s.end(), is_blank));
  s.erase(std::find_if_not(s.rbegin(), s.rend(), is_blank).base(), s.end());
  return s;
}

std::string label_of(const Handle(Standard_Transient) & entity) {
  if (const auto iges = Handle(IGESData_IGESEntity)::DownCast(entity); !iges.IsNull())
    return iges->HasName() ? trimmed(iges->NameValue()) : "";
  if (const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity); !item.IsNull())
    return trimmed(item->Name());
  return "";
}

/// The labels of entities, by the shapes that were made of them. A shape may lie in several places.
using Labels = std::unordered_map<const Standard_Transient*, std::string>;

// In one pass: TransferReader looks through all entities for each shape.
Labels labels_of(const Handle(Transfer_TransientProcess) & made) {
  Labels labels;
  for (int i = 1; i <= made->NbMapped(); ++i) {
    const TopoDS_Shape shape = TransferBRep::ShapeResult(made, made->Mapped(i));
    if (shape.IsNull()) continue;
    const std::string label = label_of(made->Mapped(i));
    if (!label.empty() && label != "NONE") labels.try_emplace(shape.TShape().get(), label);
  }
  return labels;
}

/// Gives the faces, edges, shells and solids of all products the names of the entities that they
/// were made of. (OpenCASCADE's own way, read.stepcaf.subshapes.name, breaks down over sound
/// files.)
void name_parts(const Handle(TDocStd_Document) & document, const Labels& labels) {
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence products;
  shapes->GetShapes(products);
  for (const TDF_Label& product : products) {
    if (!XCAFDoc_ShapeTool::IsSimpleShape(product)) continue;
    const TopoDS_Shape whole = XCAFDoc_ShapeTool::GetShape(product);
    TopTools_IndexedMapOfShape parts;
    for (const auto type : {TopAbs_SOLID, TopAbs_SHELL, TopAbs_FACE, TopAbs_EDGE})
      TopExp::MapShapes(whole, type, parts);
    for (int p = 1; p <= parts.Extent(); ++p) {
      const auto label = labels.find(parts(p).TShape().get());
      if (label == labels.end() || parts(p).IsSame(whole)) continue;
      const TDF_Label part = shapes->AddSubShape(product, parts(p));
      if (!part.IsNull())
        TDataStd_Name::Set(part, TCollection_ExtendedString(label->second.c_str(), true));
    }
  }
}

bool is_geometry(const IGESData_IGESEntity& entity) {
  const int type = entity.TypeNumber();
  const bool curve_or_surface = (type >= 100 && type < 200) || (type >= 500 && type < 600);
  return curve_or_surface && type != 116 && type != 123 && type != 124 && type != 132;
}

bool without_length(const Handle(IGESData_IGESEntity) & entity) {
  const auto line = Handle(IGESGeom_Line)::DownCast(entity);
  return !line.IsNull() && line->StartPoint().IsEqual(line->EndPoint(), 1e-12);
}

void map_shapes(CadFile& cad) {
  TopExp::MapShapes(cad.shape, TopAbs_EDGE, cad.edges);
  TopExp::MapShapes(cad.shape, TopAbs_FACE, cad.faces);
}

/// Flag 5: a curve in some parameter plane.
bool in_a_parameter_plane(const Handle(Standard_Transient) & root) {
  const auto iges = Handle(IGESData_IGESEntity)::DownCast(root);
  return !iges.IsNull() && iges->UseFlag() == 5;
}

void refuse_without_roots(XSControl_Reader& reader, const std::filesystem::path& file,
                          CadFile& cad) {
  cad.found = std::to_string(reader.Model()->NbEntities()) + " entities";
  if (reader.NbRootsForTransfer() == 0)
    throw InputError(file.string() + ": found " + cad.found +
                     " and no shape among them; expected curves or surfaces");
}

/// IGES, root by root, so that what cannot be converted is named.
void transfer_iges(IGESCAFControl_Reader& reader, const std::filesystem::path& file, CadFile& cad) {
  BRep_Builder builder;
  TopTools_IndexedMapOfShape left_out;
  for (int r = 1; r <= reader.NbRootsForTransfer(); ++r) {
    const Handle(Standard_Transient) root = reader.RootForTransfer(r);
    const auto iges = Handle(IGESData_IGESEntity)::DownCast(root);
    const int shapes = reader.NbShapes();
    reader.TransferOneRoot(r);
    const bool made = reader.NbShapes() > shapes;
    if (in_a_parameter_plane(root)) {
      if (made) left_out.Add(reader.Shape(reader.NbShapes()));
    } else if (made) {
      builder.Add(cad.shape, reader.Shape(reader.NbShapes()));
    } else if (!iges.IsNull() && is_geometry(*iges) && !without_length(iges)) {
      throw InputError(file.string() + ": entity " +
                       reader.Model()->StringLabel(root)->ToCString() + " of type " +
                       std::to_string(iges->TypeNumber()) +
                       " cannot be converted; expected a curve or surface that OpenCASCADE knows");
    }
  }
  refuse_without_roots(reader, file, cad);
  // What is converted already is only given its attributes.
  if (!reader.Transfer(cad.document)) return;
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(cad.document->Main());
  TDF_LabelSequence labels;
  shapes->GetFreeShapes(labels);
  for (const TDF_Label& label : labels)
    if (left_out.Contains(shapes->GetShape(label))) shapes->RemoveShape(label);
}

void transfer_step(STEPCAFControl_Reader& reader, const std::filesystem::path& file, CadFile& cad) {
  refuse_without_roots(reader.ChangeReader(), file, cad);
  reader.Transfer(cad.document);
  BRep_Builder builder;
  for (int s = 1; s <= reader.ChangeReader().NbShapes(); ++s)
    builder.Add(cad.shape, reader.ChangeReader().Shape(s));
}

void finish(XSControl_Reader& reader, CadFile& cad) {
  map_shapes(cad);
  const Labels labels = labels_of(reader.WS()->TransferReader()->TransientProcess());
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    const auto label = labels.find(cad.edges(e).TShape().get());
    cad.labels.push_back(label == labels.end() ? "" : label->second);
  }
  name_parts(cad.document, labels);
}

void read_step(const std::filesystem::path& file, CadFile& cad) {
  STEPCAFControl_Reader reader;
  if (reader.ReadFile(file.string().c_str()) != IFSelect_RetDone)
    throw InputError(file.string() + ": OpenCASCADE cannot read it; expected STEP");
  cad.header = step_header(*reader.ChangeReader().StepModel());
  transfer_step(reader, file, cad);
  finish(reader.ChangeReader(), cad);
}

void read_iges(const std::filesystem::path& file, CadFile& cad) {
  IGESCAFControl_Reader reader;
  if (reader.ReadFile(file.string().c_str()) != IFSelect_RetDone)
    throw InputError(file.string() + ": OpenCASCADE cannot read it; expected IGES");
  cad.header = iges_header(*reader.IGESModel());
  transfer_iges(reader, file, cad);
  finish(reader, cad);
}

bool is_finite(const gp_Pnt& p) {
  return std::isfinite(p.X()) && std::isfinite(p.Y()) && std::isfinite(p.Z());
}

/// Whether vertices, and curves and surfaces at a few places, are at finite points: bytes may be
/// any numbers.
bool is_finite(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape parts;
  for (const auto type : {TopAbs_VERTEX, TopAbs_EDGE, TopAbs_FACE})
    TopExp::MapShapes(shape, type, parts);
  for (int p = 1; p <= parts.Extent(); ++p) {
    const TopoDS_Shape& part = parts(p);
    if (part.ShapeType() == TopAbs_VERTEX) {
      const TopoDS_Vertex& vertex = TopoDS::Vertex(part);
      if (!is_finite(BRep_Tool::Pnt(vertex)) || !std::isfinite(BRep_Tool::Tolerance(vertex)))
        return false;
    } else if (part.ShapeType() == TopAbs_EDGE) {
      double a = 0, b = 0;
      const Handle(Geom_Curve) curve = BRep_Tool::Curve(TopoDS::Edge(part), a, b);
      for (const double t : {a, (a + b) / 2, b})
        if (!curve.IsNull() && !is_finite(curve->Value(t))) return false;
    } else {
      const Handle(Geom_Surface) surface = BRep_Tool::Surface(TopoDS::Face(part));
      double u0, u1, v0, v1;
      BRepTools::UVBounds(TopoDS::Face(part), u0, u1, v0, v1);
      for (const double s : {0.0, 0.5, 1.0})
        if (surface.IsNull() || !is_finite(surface->Value(u0 + s * (u1 - u0), v0 + s * (v1 - v0))))
          return false;
    }
  }
  return true;
}

void read_brep(const std::filesystem::path& file, CadFile& cad) {
  const std::string bytes = read_input_file(file, "a BREP file");
  std::istringstream in(bytes);
  in.imbue(std::locale::classic());
  TopoDS_Shape shape;
  if (is_binary_brep(bytes))
    BinTools::Read(shape, in);
  else
    BRepTools::Read(shape, in, BRep_Builder());
  if (!in || shape.IsNull() || !is_finite(shape))
    throw InputError(file.string() + ": OpenCASCADE cannot read it; expected a sound BREP file");
  cad.found = "a BREP shape";
  BRep_Builder().Add(cad.shape, shape);
  XCAFDoc_DocumentTool::ShapeTool(cad.document->Main())->AddShape(shape, false);
  cad.header = brep_header();
  map_shapes(cad);
  cad.labels.resize(static_cast<size_t>(cad.edges.Extent()));
}

void read_patch_set(const std::filesystem::path& file, CadFile& cad) {
  const TopoDS_Shape shape = read_patches(file, read_input_file(file, "a set of patches"));
  cad.found = "patches";
  BRep_Builder().Add(cad.shape, shape);
  XCAFDoc_DocumentTool::ShapeTool(cad.document->Main())->AddShape(shape, false);
  cad.header = patches_header();
  map_shapes(cad);
  cad.labels.resize(static_cast<size_t>(cad.edges.Extent()));
}

// The shapes and labels of a file whose text was looked at.
CadFile read_with_occ(const std::filesystem::path& file, CadFormat format) {
  OccSettings occ;
  occ.set_unit("MM");
  // One line an entity, corners in it or not; the default cuts splines at their corners.
  occ.set("read.iges.bspline.continuity", 0);
  CadFile cad;
  BRep_Builder().MakeCompound(cad.shape);
  cad.document = new_document();
  try {
    format == CadFormat::Step   ? read_step(file, cad)
    : format == CadFormat::Iges ? read_iges(file, cad)
    : format == CadFormat::Brep ? read_brep(file, cad)
                                : read_patch_set(file, cad);
  } catch (const Standard_Failure& failure) {
    throw InputError(file.string() +
                     ": OpenCASCADE failed to read it: " + failure.GetMessageString());
  }
  return cad;
}

// The order of edges in the map is that of the shape, and survives.
std::string to_bytes(const CadFile& cad) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << cad.found << '\n' << cad.labels.size() << '\n';
  for (const std::string& label : cad.labels) out << label.size() << ' ' << label;
  BinTools::Write(cad.shape, out);
  return out.str();
}

CadFile from_bytes(const std::string& bytes) {
  std::istringstream in(bytes);
  in.imbue(std::locale::classic());
  CadFile cad;
  size_t count = 0;
  std::getline(in, cad.found);
  in >> count;
  in.get();
  for (size_t i = 0; i < count; ++i) {
    size_t length = 0;
    in >> length;
    in.get();
    in.read(cad.labels.emplace_back(length, ' ').data(), static_cast<std::streamsize>(length));
  }
  TopoDS_Shape shape;
  BinTools::Read(shape, in);
  if (!in || shape.IsNull() || shape.ShapeType() != TopAbs_COMPOUND)
    throw Error("what a child process read is not whole");
  cad.shape = TopoDS::Compound(shape);
  map_shapes(cad);
  return cad;
}

}  // namespace

Handle(TDocStd_Document) new_document(double unit_in_metres) {
  const Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main());
  XCAFDoc_ShapeTool::SetAutoNaming(false);  // no names that nobody gave
  XCAFDoc_DocumentTool::SetLengthUnit(document, unit_in_metres);
  return document;
}

CadFile read_cad_here(const std::filesystem::path& file) {
  const CadFormat format = cad_format(file);
  check_cad_text(file, format);
  return read_with_occ(file, format);
}

CadFile read_cad(const std::filesystem::path& file) {
  if (!is_sandboxed_read_enabled()) return read_cad_here(file);
  const CadFormat format = cad_format(file);
  check_cad_text(file, format);
  return from_bytes(
      sandboxed_read(file, "OpenCASCADE", [&] { return to_bytes(read_with_occ(file, format)); }));
}

}  // namespace batten
