#include "batten/io/cad/cad_unit.h"

#include <HeaderSection_FileSchema.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_HArray1OfHAsciiString.hxx>
#include <STEPConstruct_UnitContext.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx.hxx>
#include <StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext.hxx>
#include <StepRepr_GlobalUnitAssignedContext.hxx>
#include <TColStd_HSequenceOfHAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

std::string schema_of(const StepData_StepModel& model) {
  const auto schema = Handle(HeaderSection_FileSchema)::DownCast(
      model.HeaderEntity(STANDARD_TYPE(HeaderSection_FileSchema)));
  if (schema.IsNull() || schema->NbSchemaIdentifiers() < 1) return "";
  return schema->SchemaIdentifiersValue(1)->ToCString();
}

/// The units that an entity of the file assigns; null for other entities.
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
    context.ComputeFactors(units);
    if (!context.LengthDone()) continue;
    const double metres = 1e-3 * context.LengthFactor();
    if (!header.unit_stated)
      header.unit_in_metres = metres;
    else if (std::abs(metres - header.unit_in_metres) > 1e-9 * metres)
      header.note = "its parts have several units of length: all are converted";
    header.unit_stated = true;
  }
  if (!header.unit_stated) header.note = "it states no unit of length: taken as mm";
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
  if (!header.unit_stated) header.note = "it states no unit of length: taken as inches";
  return header;
}

CadHeader brep_header() {
  CadHeader header;
  header.format = CadFormat::Brep;
  header.note = "BREP has no unit of length: taken as mm";
  return header;
}

CadHeader patches_header() {
  CadHeader header;
  header.format = CadFormat::Patches;
  header.note = "sets of patches have no unit of length: taken as mm";
  return header;
}

}  // namespace batten
