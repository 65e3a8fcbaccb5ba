#include "batten/io/cad/step_text.h"

#include <APIHeaderSection_MakeHeader.hxx>
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
#include <XSControl_WorkSession.hxx>
#include <array>

#include "batten/core/errors.h"
#include "batten/io/cad/curve_part.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/occ_values.h"
#include "batten/io/files/atomic_file.h"

namespace batten {
namespace {

/// OpenCASCADE makes a set of each curve that belongs to no face, and names that: readers take a
/// curve's name.
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

void write_step_text(STEPControl_Writer& writer, const StepHeader& header, std::ostream& out) {
  name_curves(*writer.Model());
  APIHeaderSection_MakeHeader made(writer.Model());
  made.SetName(occ_text(header.name));
  made.SetAuthorValue(1, occ_text(header.author));
  made.SetOrganizationValue(1, occ_text(""));
  made.SetDescriptionValue(1, occ_text(header.description));
  made.SetOriginatingSystem(occ_text("Batten"));
  StepData_StepWriter text(writer.Model());
  // Enough digits to read the same number back. (Its zero suppression, which would make the file
  // smaller, cuts exponents off numbers as long as these.)
  text.FloatWriter().SetFormat("%#.17G");
  text.SendModel(Handle(StepData_Protocol)::DownCast(writer.WS()->Protocol()));
  text.Print(out);
}

void write_parts(const std::filesystem::path& path, const std::vector<CadPart>& parts,
                 const StepFileProperties& properties, OccSettings& occ) {
  occ.set("write.step.schema", properties.ap242 ? "AP242DIS" : "AP214IS");
  occ.set("write.step.assembly", 0);  // one product a part, not one for each shell or curve
  occ.set("write.stepcaf.subshapes.name", 1);
  occ.set("write.surfacecurve.mode", 1);
  occ.set("write.precision.mode", 2);  // the value given next
  occ.set("write.precision.val", properties.tolerance);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document_of(parts, occ.unit_in_metres()), STEPControl_AsIs))
    throw Error(path.string() + ": OpenCASCADE cannot turn the shapes into STEP");
  // OpenCASCADE counts the products of a process in their names.
  const auto& model = *writer.ChangeWriter().Model();
  size_t next = 0;
  for (int e = 1; e <= model.NbEntities(); ++e)
    if (const auto found = Handle(StepBasic_Product)::DownCast(model.Value(e)); !found.IsNull()) {
      if (next == parts.size()) throw Error(path.string() + ": more products than parts");
      const auto name = occ_text(parts[next++].name);
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
  if (!options.lines.empty()) parts.push_back(part_of_curves("lines", options.lines));
  write_parts(path, parts, {{options.name, options.author, "surfaces"}, options.ap242, tolerance},
              occ);
}

CadFace face_of_region(const TopoDS_Face& face, const std::string& region, size_t number,
                       size_t regions) {
  static constexpr std::array colours = {"#8cb4d9", "#e6b46e", "#96c896", "#d98c8c", "#b4a0d2",
                                         "#d2cd82", "#82c8c8", "#dca0c8", "#a0a0a0", "#b4825a"};
  return {face, region, regions > 1 ? colours[number % colours.size()] : ""};
}

}  // namespace batten
