// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_writer.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepTools.hxx>
#include <Bnd_Box.hxx>
#include <IGESBasic_Name.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESSelect_WorkLibrary.hxx>
#include <Interface_FloatWriter.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepGeom_TrimmedCurve.hxx>
#include <StepShape_GeometricCurveSet.hxx>
#include <StepShape_GeometricSetSelect.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TopoDS_Iterator.hxx>
#include <TransferBRep.hxx>
#include <TransferBRep_ShapeMapper.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <locale>
#include <optional>
#include <sstream>
#include <string_view>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

/// Gives products without a name that of the file; OpenCASCADE would generate names.
void name_products(const Handle(TDocStd_Document) & document, const std::string& name) {
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence products;
  shapes->GetShapes(products);
  for (const TDF_Label& product : products) {
    Handle(TDataStd_Name) given;
    if (!product.FindAttribute(TDataStd_Name::GetID(), given) || given->Get().IsEmpty())
      TDataStd_Name::Set(product, TCollection_ExtendedString(name.c_str(), true));
  }
}

std::string step_of(const Handle(TDocStd_Document) & document, const CadWriteOptions& options,
                    OccSettings& occ) {
  occ.set("write.step.unit", cad_unit(options.unit_in_metres).c_str());
  occ.set("write.step.schema", options.ap242 ? "AP242DIS" : "AP214IS");
  occ.set("write.stepcaf.subshapes.name", 1);
  occ.set("write.surfacecurve.mode", 1);
  name_products(document, options.name);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document, STEPControl_AsIs))
    throw Error("OpenCASCADE cannot convert the shapes to STEP");
  std::ostringstream out;
  write_step_text(writer.ChangeWriter(), {options.name, "", "shapes"}, out);
  return out.str();
}

/// Sets the name of an IGES entity. The label in its directory entry holds eight characters, so a
/// name property holds the full name.
void name_iges(IGESCAFControl_Writer& writer, const TopoDS_Shape& shape, const std::string& name) {
  if (name.empty()) return;
  const auto finder = TransferBRep::ShapeMapper(writer.TransferProcess(), shape);
  Handle(IGESData_IGESEntity) entity;
  if (!writer.TransferProcess()->FindTypedTransient(finder, STANDARD_TYPE(IGESData_IGESEntity),
                                                    entity))
    return;
  entity->SetLabel(occ_string(name.substr(0, 8)));
  const Handle(IGESBasic_Name) property = new IGESBasic_Name;
  property->Init(1, occ_string(name));
  entity->AddProperty(property);
  writer.AddEntity(property);
}

std::string iges_of(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                    const CadWriteOptions& options, OccSettings& occ) {
  occ.set("write.iges.unit", cad_unit(options.unit_in_metres).c_str());
  occ.set("write.iges.brep.mode", 1);
  IGESCAFControl_Writer writer;
  writer.SetNameMode(false);  // it would write the names of products only
  if (!writer.Transfer(document)) throw Error("OpenCASCADE cannot convert the shapes to IGES");
  for (const CadPart& part : tree_of(document).parts) {
    name_iges(writer, part.shape, part.name);
    for (const CadBody& body : part.bodies) name_iges(writer, body.shape, body.name);
    for (const CadFace& face : part.faces) name_iges(writer, face.face, face.name);
    for (const CadCurveItem& curve : part.curves) name_iges(writer, curve.edge, curve.name);
  }
  Bnd_Box box;
  BRepBndLib::Add(shape, box, false);
  double largest = 1;
  if (!box.IsVoid())
    for (const gp_Pnt& p : {box.CornerMin(), box.CornerMax()})
      largest = std::max({largest, std::abs(p.X()), std::abs(p.Y()), std::abs(p.Z())});
  IGESData_GlobalSection header = writer.Model()->GlobalSection();
  header.SetMaxCoord(largest * 1e-3 / options.unit_in_metres);
  header.SetAuthorName(occ_string(""));
  header.SetSendName(occ_string(options.name));
  header.SetFileName(occ_string(options.name));
  writer.Model()->SetGlobalSection(header);
  std::ostringstream out;
  out.imbue(std::locale::classic());
  if (!print_iges(writer, out)) throw Error("OpenCASCADE cannot write IGES");
  return out.str();
}

std::string brep_of(const TopoDS_Shape& shape, const CadWriteOptions& options) {
  TopoDS_Shape written = shape;
  if (TopoDS_Iterator it(shape); it.More()) {
    const TopoDS_Shape only = it.Value();
    it.Next();
    if (!it.More()) written = only;
  }
  const double factor = 1e-3 / options.unit_in_metres;
  if (std::abs(factor - 1) > 1e-12) {
    gp_Trsf scaling;
    scaling.SetScaleFactor(factor);
    written = BRepBuilderAPI_Transform(written, scaling, true).Shape();
  }
  std::ostringstream out;
  out.imbue(std::locale::classic());
  BRepTools::Write(written, out, false, false, TopTools_FormatVersion_VERSION_1);
  return out.str();
}

}  // namespace

std::string cad_text(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                     const CadWriteOptions& options) {
  OccSettings occ;
  occ.set_unit("MM");
  return options.format == CadFormat::Step   ? step_of(document, options, occ)
         : options.format == CadFormat::Iges ? iges_of(document, shape, options, occ)
                                             : brep_of(shape, options);
}

namespace {

/// Copies the names of free curves from the curve sets in which OpenCASCADE wraps them to the
/// curves themselves. Readers use the name of the curve.
void name_curves(const StepData_StepModel& model) {
  for (int e = 1; e <= model.NbEntities(); ++e) {
    const auto set = Handle(StepShape_GeometricCurveSet)::DownCast(model.Value(e));
    if (set.IsNull() || set->NbElements() != 1) continue;
    const auto curve = set->ElementsValue(1).Curve();
    if (curve.IsNull()) continue;
    curve->SetName(set->Name());
    if (const auto cut = Handle(StepGeom_TrimmedCurve)::DownCast(curve); !cut.IsNull())
      cut->BasisCurve()->SetName(set->Name());
  }
}

}  // namespace

std::string cad_unit(double model_unit_in_metres) {
  const std::string name = OccSettings::unit_name(model_unit_in_metres);
  if (name.empty())
    throw InputError("a CAD file in a model unit of " + format_number(model_unit_in_metres) +
                     " m; expected one of um, mm, cm, m, km, inch, ft, mi, mil, uin");
  return name;
}

namespace {

/// The date of SOURCE_DATE_EPOCH, which makes files reproducible (reproducible-builds.org); empty if
/// the variable is not set. Throws InputError if its value is not a date.
std::optional<std::tm> source_date() {
  const char* const value = std::getenv("SOURCE_DATE_EPOCH");
  if (!value) return {};
  constexpr long end_of_9999 = 253402300799;  // the last second with a year of four digits
  const std::string_view text = value;
  long seconds = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error != std::errc() || end != text.data() + text.size() || seconds < 0 ||
      seconds > end_of_9999)
    throw InputError("found SOURCE_DATE_EPOCH = " + quoted_excerpt(text) +
                     " in the environment, expected the seconds since 1970 that 'date +%s' prints");
  const std::time_t time = seconds;
  std::tm date{};
  gmtime_r(&time, &date);
  return date;
}

std::string formatted(const std::tm& date, const char* format) {
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), format, &date)};
}

}  // namespace

void write_step_text(STEPControl_Writer& writer, const StepHeader& header, std::ostream& out) {
  name_curves(*writer.Model());
  APIHeaderSection_MakeHeader made(writer.Model());
  made.SetName(occ_string(header.name));
  made.SetAuthorValue(1, occ_string(header.author));
  made.SetOrganizationValue(1, occ_string(""));
  made.SetDescriptionValue(1, occ_string(header.description));
  made.SetOriginatingSystem(occ_string("Batten"));
  if (const auto date = source_date())
    made.SetTimeStamp(occ_string(formatted(*date, "%Y-%m-%dT%H:%M:%S")));
  StepData_StepWriter text(writer.Model());
  // Enough digits to read the same number back. (OpenCASCADE's zero suppression, which would make
  // the file smaller, truncates the exponents of numbers as long as these.)
  text.FloatWriter().SetFormat("%#.17G");
  text.SendModel(Handle(StepData_Protocol)::DownCast(writer.WS()->Protocol()));
  text.Print(out);
}

void write_parts(const std::filesystem::path& path, const std::vector<CadPart>& parts,
                 const StepFileProperties& properties, OccSettings& occ) {
  occ.set("write.step.schema", properties.ap242 ? "AP242DIS" : "AP214IS");
  occ.set("write.step.assembly", 0);  // one product per part, instead of one per shell or curve
  occ.set("write.stepcaf.subshapes.name", 1);
  occ.set("write.surfacecurve.mode", 1);
  occ.set("write.precision.mode", 2);  // use the value set in the next line
  occ.set("write.precision.val", properties.tolerance);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document_of(parts, occ.unit_in_metres()), STEPControl_AsIs))
    throw Error(path.string() + ": OpenCASCADE cannot convert the shapes to STEP");
  // OpenCASCADE appends a process-wide product counter to the names; restore them.
  const auto& model = *writer.ChangeWriter().Model();
  size_t next = 0;
  for (int e = 1; e <= model.NbEntities(); ++e)
    if (const auto found = Handle(StepBasic_Product)::DownCast(model.Value(e)); !found.IsNull()) {
      if (next == parts.size()) throw Error(path.string() + ": more products than parts");
      const auto name = occ_string(parts[next++].name);
      found->SetId(name);
      found->SetName(name);
    }
  write_file_atomically(path, [&](std::ostream& out) {
    write_step_text(writer.ChangeWriter(), properties.header, out);
  });
}

void write_surfaces(const std::filesystem::path& path, const CadPart& part,
                    const StepFileOptions& options, double tolerance, OccSettings& occ) {
  std::vector<CadPart> parts = {part};
  if (!options.lines.empty()) parts.push_back(part_of_curves("curves", options.lines));
  write_parts(path, parts, {{options.name, options.author, "surfaces"}, options.ap242, tolerance},
              occ);
}

CadFace face_of_region(const TopoDS_Face& face, const std::string& region, size_t number,
                       size_t regions) {
  static constexpr std::array colours = {"#8cb4d9", "#e6b46e", "#96c896", "#d98c8c", "#b4a0d2",
                                         "#d2cd82", "#82c8c8", "#dca0c8", "#a0a0a0", "#b4825a"};
  return {face, region, regions > 1 ? colours[number % colours.size()] : ""};
}

bool print_iges(IGESControl_Writer& writer, std::ostream& out) {
  writer.ComputeModel();
  if (const auto date = source_date()) {
    IGESData_GlobalSection header = writer.Model()->GlobalSection();
    header.SetDate(occ_string(formatted(*date, "%Y%m%d.%H%M%S")));
    header.SetLastChangeDate(header.Date());
    writer.Model()->SetGlobalSection(header);
  }
  IGESData_IGESWriter text(writer.Model());
  text.FloatWriter().SetFormat("%#.17G");
  text.FloatWriter().SetZeroSuppress(false);
  text.SendModel(IGESSelect_WorkLibrary::DefineProtocol());
  return text.Print(out);
}

}  // namespace batten
