// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_file.h"

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <Bnd_Box.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <HeaderSection_FileSchema.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_Line.hxx>
#include <Interface_HArray1OfHAsciiString.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPConstruct_UnitContext.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <Standard_Version.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx.hxx>
#include <StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext.hxx>
#include <StepRepr_GlobalUnitAssignedContext.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColStd_HSequenceOfHAsciiString.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/vtk/vtk_message_capture.h"

namespace batten {

// Reads tensor-product B-spline patches in the XML format of G+Smo.

/// Reads every TensorBSpline2 and TensorNurbs2 with three coordinates as an untrimmed face. The
/// first direction of the poles runs fastest. Patch edges within 1e-5 of the model size of each
/// other are sewn. Throws InputError with the number of the patch: no patch, decreasing knots, a
/// wrong number of poles, invalid or non-finite numbers, weights that are not positive.
TopoDS_Shape read_patches(const std::filesystem::path& file, const std::string& text);

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

/// The labels of entities, keyed by the shape made from each. One shape may occur at several
/// locations.
using Labels = std::unordered_map<const Standard_Transient*, std::string>;

// One pass over all entities; TransferReader would search all of them for each shape.
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

/// Names the faces, edges, shells and solids of all products after the entities that they were made
/// from. (OpenCASCADE's own option, read.stepcaf.subshapes.name, crashes on valid files.)
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

/// True for IGES use flag 5: a curve in the parameter plane of a surface.
bool in_a_parameter_plane(const Handle(Standard_Transient) & root) {
  const auto iges = Handle(IGESData_IGESEntity)::DownCast(root);
  return !iges.IsNull() && iges->UseFlag() == 5;
}

void refuse_without_roots(XSControl_Reader& reader, const std::filesystem::path& file,
                          CadFile& cad) {
  cad.found = std::to_string(reader.Model()->NbEntities()) + " entities";
  if (reader.NbRootsForTransfer() == 0)
    throw InputError(file.string() + ": found " + cad.found +
                     " and no shape; expected curves or surfaces");
}

/// Converts an IGES file root by root, so that an error message can name the entity that failed.
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
  // Already converted entities are not converted again; they only get their attributes.
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

void read_step_file(const std::filesystem::path& file, CadFile& cad) {
  STEPCAFControl_Reader reader;
  if (reader.ReadFile(file.string().c_str()) != IFSelect_RetDone)
    throw InputError(file.string() + ": OpenCASCADE cannot read it; expected STEP");
  cad.header = step_header(*reader.ChangeReader().StepModel());
  transfer_step(reader, file, cad);
  finish(reader.ChangeReader(), cad);
}

void read_iges_file(const std::filesystem::path& file, CadFile& cad) {
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

/// True if vertices, and sample points of curves and surfaces, are finite. Coordinates in binary
/// files may be arbitrary bit patterns.
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

void read_brep_file(const std::filesystem::path& file, CadFile& cad) {
  const std::string bytes = read_input_file(file, "a BREP file");
  std::istringstream in(bytes);
  in.imbue(std::locale::classic());
  TopoDS_Shape shape;
  if (is_binary_brep(bytes))
    BinTools::Read(shape, in);
  else
    BRepTools::Read(shape, in, BRep_Builder());
  if (!in || shape.IsNull() || !is_finite(shape))
    throw InputError(file.string() + ": OpenCASCADE cannot read it; expected a valid BREP file");
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

// Reads shapes and labels of a file that passed check_cad_text().
CadFile read_with_occ(const std::filesystem::path& file, CadFormat format) {
  OccSettings occ;
  occ.set_unit("MM");
  // One edge per entity, even with corners in it; by default OpenCASCADE splits splines at corners.
  occ.set("read.iges.bspline.continuity", 0);
  CadFile cad;
  BRep_Builder().MakeCompound(cad.shape);
  cad.document = new_document();
  try {
    format == CadFormat::Step   ? read_step_file(file, cad)
    : format == CadFormat::Iges ? read_iges_file(file, cad)
    : format == CadFormat::Brep ? read_brep_file(file, cad)
                                : read_patch_set(file, cad);
  } catch (const Standard_Failure& failure) {
    throw InputError(file.string() +
                     ": OpenCASCADE failed to read it: " + failure.GetMessageString());
  }
  return cad;
}

// Serialising the shape preserves the order of its edges, and with it the order of the labels.
std::string to_bytes(const CadFile& cad) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << cad.found << '\n' << cad.labels.size() << '\n';
  for (const std::string& label : cad.labels) out << label.size() << ' ' << label;
  BinTools::Write(cad.shape, out);
  return out.str();
}

CadFile cad_file_from_bytes(const std::string& bytes) {
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
    throw Error("the data of a child process are incomplete");
  cad.shape = TopoDS::Compound(shape);
  map_shapes(cad);
  return cad;
}

}  // namespace

Handle(TDocStd_Document) new_document(double unit_in_metres) {
  const Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main());
  XCAFDoc_ShapeTool::SetAutoNaming(false);  // no automatic names
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
  return cad_file_from_bytes(
      sandboxed_read(file, "OpenCASCADE", [&] { return to_bytes(read_with_occ(file, format)); }));
}

namespace {

std::string schema_of(const StepData_StepModel& model) {
  const auto schema = Handle(HeaderSection_FileSchema)::DownCast(
      model.HeaderEntity(STANDARD_TYPE(HeaderSection_FileSchema)));
  if (schema.IsNull() || schema->NbSchemaIdentifiers() < 1) return "";
  return schema->SchemaIdentifiersValue(1)->ToCString();
}

/// The unit context of an entity; null if the entity is none.
Handle(StepRepr_GlobalUnitAssignedContext) units_of(const Handle(Standard_Transient) & entity) {
  using Plain = StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext;
  using Uncertain = StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx;
  if (const auto plain = Handle(Plain)::DownCast(entity); !plain.IsNull())
    return plain->GlobalUnitAssignedContext();
  if (const auto uncertain = Handle(Uncertain)::DownCast(entity); !uncertain.IsNull())
    return uncertain->GlobalUnitAssignedContext();
  return Handle(StepRepr_GlobalUnitAssignedContext)::DownCast(entity);
}

}  // namespace

CadHeader step_header(const StepData_StepModel& model) {
  CadHeader header;
  header.format = CadFormat::Step;
  header.schema = schema_of(model);
  for (int e = 1; e <= model.NbEntities(); ++e) {
    const auto units = units_of(model.Value(e));
    if (units.IsNull()) continue;
    STEPConstruct_UnitContext context;
#if OCC_VERSION_HEX >= 0x070800
    context.ComputeFactors(units, {});
#else
    context.ComputeFactors(units);
#endif
    if (!context.LengthDone()) continue;
    const double metres = 1e-3 * context.LengthFactor();
    if (!header.unit_stated)
      header.unit_in_metres = metres;
    else if (std::abs(metres - header.unit_in_metres) > 1e-9 * metres)
      header.note = "the file has parts in different length units, which are converted";
    header.unit_stated = true;
  }
  if (!header.unit_stated) header.note = "the file states no length unit: assumed mm";
  return header;
}

CadHeader iges_header(const IGESData_IGESModel& model) {
  CadHeader header;
  header.format = CadFormat::Iges;
  const IGESData_GlobalSection& global = model.GlobalSection();
  header.schema = std::to_string(global.IGESVersion());
  const double millimetres = global.UnitValue();
  header.unit_stated = millimetres > 0 && std::isfinite(millimetres);
  header.unit_in_metres = header.unit_stated ? 1e-3 * millimetres : 0.0254;
  if (!header.unit_stated) header.note = "the file states no length unit: assumed inches";
  return header;
}

CadHeader brep_header() {
  CadHeader header;
  header.format = CadFormat::Brep;
  header.note = "BREP files have no length unit: assumed mm";
  return header;
}

CadHeader patches_header() {
  CadHeader header;
  header.format = CadFormat::Patches;
  header.note = "patch files have no length unit: assumed mm";
  return header;
}

namespace {

/// A knot vector: distinct knots and their multiplicities.
struct Knots {
  int degree = 0;
  std::vector<double> at;
  std::vector<int> times;
  int poles() const {
    int sum = -degree - 1;
    for (const int t : times) sum += t;
    return sum;
  }
};

class PatchReader {
 public:
  explicit PatchReader(std::string where) : where_(std::move(where)) {}

  TopoDS_Face face(vtkXMLDataElement& geometry) const {
    vtkXMLDataElement* basis = geometry.FindNestedElementWithName("Basis");
    if (!basis) fail("no Basis", "one with two B-spline bases");
    std::vector<double> weights;
    if (vtkXMLDataElement* inner = basis->FindNestedElementWithName("Basis");
        // Of a rational patch: nested, with the weights beside it.
        inner && !inner->GetAttribute("index")) {
      if (vtkXMLDataElement* w = basis->FindNestedElementWithName("weights")) weights = numbers(*w);
      basis = inner;
    }
    const Knots u = knots(*basis, "0"), v = knots(*basis, "1");
    vtkXMLDataElement* coefs = geometry.FindNestedElementWithName("coefs");
    if (!coefs || !coefs->GetAttribute("geoDim") || std::strcmp(coefs->GetAttribute("geoDim"), "3"))
      fail("no coefs of three coordinates", "coefs geoDim=\"3\"");
    const std::vector<double> x = numbers(*coefs);
    const long count = static_cast<long>(u.poles()) * v.poles();
    if (isize(x) != 3 * count)
      fail(std::to_string(x.size()) + " coordinates", "3 for each of " + std::to_string(u.poles()) +
                                                          " × " + std::to_string(v.poles()) +
                                                          " poles");
    if (!weights.empty() && isize(weights) != count)
      fail(std::to_string(weights.size()) + " weights", "one for each pole");
    return made(u, v, x, weights);
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(where_ + "found " + found + ", expected " + expected);
  }

  std::vector<double> numbers(vtkXMLDataElement& element) const {
    const char* text = element.GetCharacterData();
    std::string_view rest = text ? text : "";
    constexpr std::string_view blanks = " \t\r\n\f\v";
    std::vector<double> values;
    for (;;) {
      rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
      if (rest.empty()) break;
      const std::string_view token = rest.substr(0, rest.find_first_of(blanks));
      double value = 0;
      const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
      if (error != std::errc() || end != token.data() + token.size() || !std::isfinite(value))
        fail("'" + std::string(token.substr(0, 40)) + "'", "a finite number");
      values.push_back(value);
      rest.remove_prefix(token.size());
    }
    return values;
  }

  Knots knots(vtkXMLDataElement& bases, const char* index) const {
    for (int k = 0; k < bases.GetNumberOfNestedElements(); ++k) {
      vtkXMLDataElement* basis = bases.GetNestedElement(k);
      const char* own = basis->GetAttribute("index");
      if (!own || std::strcmp(own, index) != 0) continue;
      vtkXMLDataElement* vector = basis->FindNestedElementWithName("KnotVector");
      Knots knots;
      if (!vector || !vector->GetScalarAttribute("degree", knots.degree) || knots.degree < 1 ||
          knots.degree > Geom_BSplineSurface::MaxDegree())
        fail("no KnotVector of a degree from 1 to 25 in basis " + std::string(index), "one");
      for (const double value : numbers(*vector)) {
        if (!knots.at.empty() && value < knots.at.back()) fail("knots that fall", "rising ones");
        if (knots.at.empty() || value > knots.at.back()) {
          knots.at.push_back(value);
          knots.times.push_back(0);
        }
        ++knots.times.back();
      }
      check(knots);
      return knots;
    }
    fail("no basis " + std::string(index), "two B-spline bases");
  }

  void check(const Knots& knots) const {
    const int ends = knots.degree + 1;
    bool sound = knots.at.size() >= 2 && knots.times.front() == ends && knots.times.back() == ends;
    for (size_t k = 1; k + 1 < knots.times.size(); ++k)
      sound = sound && knots.times[k] <= knots.degree;
    if (!sound)
      fail("knots that do not clamp their ends",
           std::to_string(ends) + " equal ones at either end, fewer between");
  }

  TopoDS_Face made(const Knots& u, const Knots& v, const std::vector<double>& x,
                   const std::vector<double>& weights) const {
    TColgp_Array2OfPnt poles(1, u.poles(), 1, v.poles());
    TColStd_Array2OfReal w(1, u.poles(), 1, v.poles());
    for (int j = 0; j < v.poles(); ++j)
      for (int i = 0; i < u.poles(); ++i) {
        const size_t k = static_cast<size_t>(j) * u.poles() + i;
        poles(i + 1, j + 1) = gp_Pnt(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
        w(i + 1, j + 1) = weights.empty() ? 1 : weights[k];
        if (!(w(i + 1, j + 1) > 0)) fail("weight " + format_number(weights[k]), "one above 0");
      }
    const Handle(Geom_BSplineSurface) surface = new Geom_BSplineSurface(
        poles, w, array<TColStd_Array1OfReal>(u.at), array<TColStd_Array1OfReal>(v.at),
        array<TColStd_Array1OfInteger>(u.times), array<TColStd_Array1OfInteger>(v.times), u.degree,
        v.degree);
    constexpr double point = 1e-7;  // below this length, mm, a side counts as degenerate
    BRepBuilderAPI_MakeFace maker(surface, point);
    if (!maker.IsDone()) fail("a surface that has no face", "a sound patch");
    return maker.Face();
  }

  template <class Array, class Values>
  static Array array(const Values& values) {
    Array result(1, isize(values));
    for (int i = 0; i < isize(values); ++i) result(i + 1) = values[i];
    return result;
  }

  std::string where_;
};

}  // namespace

TopoDS_Shape read_patches(const std::filesystem::path& file, const std::string& text) {
  check_xml_nesting_depth(text, file.string());
  const auto root = [&] {
    const VtkMessageCapture messages;
    return vtkSmartPointer<vtkXMLDataElement>::Take(
        vtkXMLUtilities::ReadElementFromString(text.c_str()));
  }();
  if (!root)
    throw InputError(file.string() + ": found no well-formed XML, expected patches of G+Smo");
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  int count = 0;
  for (int k = 0; k < root->GetNumberOfNestedElements(); ++k) {
    vtkXMLDataElement* geometry = root->GetNestedElement(k);
    const char* type = geometry->GetAttribute("type");
    if (std::strcmp(geometry->GetName(), "Geometry") != 0 || !type ||
        (std::strcmp(type, "TensorBSpline2") != 0 && std::strcmp(type, "TensorNurbs2") != 0))
      continue;
    ++count;
    const PatchReader reader(file.string() + ": patch " + std::to_string(count) + ": ");
    builder.Add(all, reader.face(*geometry));
  }
  if (count == 0)
    throw InputError(file.string() +
                     ": found no Geometry of type TensorBSpline2 or TensorNurbs2, "
                     "expected patches of G+Smo");
  Bnd_Box box;
  BRepBndLib::AddOptimal(all, box, false, false);
  BRepBuilderAPI_Sewing sewing(ContinuityOptions{}.sewing * std::sqrt(box.SquareExtent()));
  sewing.Add(all);
  sewing.Perform();
  return sewing.SewedShape();
}

}  // namespace batten
