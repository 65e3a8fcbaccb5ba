#include "batten/io/lines/curve_cad.h"

#include <BRep_Builder.hxx>
#include <Geom_BSplineCurve.hxx>
#include <IGESBasic_Name.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_BSplineCurve.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_BSplineCurve.hxx>
#include <StepGeom_TrimmedCurve.hxx>
#include <StepShape_GeometricCurveSet.hxx>
#include <StepShape_GeometricSetSelect.hxx>
#include <StepShape_HArray1OfGeometricSetSelect.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_HArray1OfXYZ.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/fem/cubic_splines.h"
#include "batten/io/cad/iges_text.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/step_text.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Handle(TCollection_HAsciiString) text_of(const std::string& text) {
  return new TCollection_HAsciiString(text.c_str());
}

TopoDS_Edge edge_of(const CubicSpline& spline, double tolerance) {
  const int knots = count_of(spline.knots);
  TColgp_Array1OfPnt poles(1, count_of(spline.poles));
  TColStd_Array1OfReal values(1, knots);
  TColStd_Array1OfInteger times(1, knots);
  for (int i = 1; i <= poles.Length(); ++i) poles(i) = to_occ(spline.poles[i - 1]);
  for (int i = 1; i <= knots; ++i) {
    values(i) = spline.knots[i - 1];
    times(i) = spline.multiplicities[i - 1];
  }
  BRep_Builder builder;
  TopoDS_Vertex first, last;
  builder.MakeVertex(first, to_occ(spline.poles.front()), tolerance);
  if (spline.closed)
    last = first;
  else
    builder.MakeVertex(last, to_occ(spline.poles.back()), tolerance);
  TopoDS_Edge edge;
  builder.MakeEdge(edge, new Geom_BSplineCurve(poles, values, times, 3), tolerance);
  builder.Add(edge, first.Oriented(TopAbs_FORWARD));
  builder.Add(edge, last.Oriented(TopAbs_REVERSED));
  builder.Range(edge, spline.knots.front(), spline.knots.back());
  return edge;
}

/// The curves of the file are the edges in their order: each gets its name, and so does its spline.
void name_step_curves(const StepData_StepModel& model, const std::vector<CubicSpline>& splines) {
  size_t next = 0;
  for (int e = 1; e <= model.NbEntities(); ++e) {
    const auto set = Handle(StepShape_GeometricCurveSet)::DownCast(model.Value(e));
    if (set.IsNull()) continue;
    for (int k = 1; k <= set->NbElements(); ++k) {
      const auto curve = set->ElementsValue(k).Curve();
      if (curve.IsNull() || next == splines.size()) continue;
      const auto name = text_of(splines[next++].name);
      curve->SetName(name);
      if (const auto cut = Handle(StepGeom_TrimmedCurve)::DownCast(curve); !cut.IsNull())
        cut->BasisCurve()->SetName(name);
    }
  }
  if (next != splines.size())
    throw Error("OpenCASCADE made " + std::to_string(next) + " STEP curves of " +
                std::to_string(splines.size()));
}

void write_step_curves(const fs::path& path, const std::vector<CubicSpline>& splines, double size) {
  OccSettings occ;
  occ.set("write.step.product.name", path.stem().c_str());
  TopoDS_Compound compound;
  BRep_Builder builder;
  builder.MakeCompound(compound);
  for (const CubicSpline& spline : splines) builder.Add(compound, edge_of(spline, 1e-9 * size));
  STEPControl_Writer writer;
  if (writer.Transfer(compound, STEPControl_GeometricCurveSet) != IFSelect_RetDone)
    throw Error(path.string() + ": OpenCASCADE cannot turn the curves into STEP");
  name_step_curves(*writer.Model(), splines);
  save_step(writer, path, {path.stem().string(), "", "curves"});
}

Handle(IGESGeom_BSplineCurve) iges_curve(const CubicSpline& spline) {
  std::vector<double> all;
  for (size_t k = 0; k < spline.knots.size(); ++k)
    all.insert(all.end(), static_cast<size_t>(spline.multiplicities[k]), spline.knots[k]);
  const int count = count_of(spline.poles);
  // IGES counts knots from -degree and poles from 0.
  const Handle(TColStd_HArray1OfReal) knots = new TColStd_HArray1OfReal(-3, count);
  const Handle(TColStd_HArray1OfReal) weights = new TColStd_HArray1OfReal(0, count - 1, 1.0);
  const Handle(TColgp_HArray1OfXYZ) poles = new TColgp_HArray1OfXYZ(0, count - 1);
  for (int i = -3; i <= count; ++i) knots->SetValue(i, all[i + 3]);
  for (int i = 0; i < count; ++i) poles->SetValue(i, to_occ(spline.poles[i]).XYZ());
  const Handle(IGESGeom_BSplineCurve) curve = new IGESGeom_BSplineCurve;
  curve->Init(count - 1, 3, false, spline.closed, true, false, knots, weights, poles,
              spline.knots.front(), spline.knots.back(), gp_XYZ(0, 0, 0));
  return curve;
}

void write_iges_curves(const fs::path& path, const std::vector<CubicSpline>& splines,
                       const std::string& unit) {
  IGESControl_Writer writer(unit.c_str(), 0);
  double largest = 0;
  for (const CubicSpline& spline : splines) {
    for (const Vec3& p : spline.poles) largest = std::max(largest, p.cwiseAbs().maxCoeff());
    const auto curve = iges_curve(spline);
    // The directory has room for eight letters; the property for all of them.
    curve->SetLabel(text_of(spline.name.substr(0, 8)));
    const Handle(IGESBasic_Name) name = new IGESBasic_Name;
    name->Init(1, text_of(spline.name));
    curve->AddProperty(name);
    if (!writer.AddEntity(name) || !writer.AddEntity(curve))
      throw Error(path.string() + ": OpenCASCADE cannot turn the curves into IGES");
  }
  IGESData_GlobalSection header = writer.Model()->GlobalSection();
  header.SetMaxCoord(largest);
  header.SetResolution(1e-9 * largest);
  header.SetAuthorName(text_of(""));
  header.SetSendName(text_of(path.stem().string()));
  header.SetFileName(text_of(path.filename().string()));
  writer.Model()->SetGlobalSection(header);
  write_whole_file(path, [&](std::ostream& out) {
    if (!print_iges(writer, out)) throw Error(path.string() + ": OpenCASCADE cannot write it");
  });
}

}  // namespace

void write_cad_curves(const fs::path& path, const std::vector<NamedCurve>& curves,
                      double model_unit_in_metres, bool iges) {
  const std::string unit = cad_unit(model_unit_in_metres);
  std::vector<CubicSpline> splines;
  double size = 0;
  for (const NamedCurve& curve : curves)
    for (CubicSpline& spline : cubic_splines(curve.name, curve.curve)) {
      size = std::max(size, spline.size);
      splines.push_back(std::move(spline));
    }
  OccSettings occ;
  occ.set_unit(unit);
  occ.set("write.iges.unit", unit.c_str());
  occ.set("write.step.assembly", 0);  // one product, not one for each curve
  occ.set("write.step.schema", "AP214IS");
  occ.set("write.precision.mode", 2);  // the value given next
  occ.set("write.precision.val", 1e-9 * size);
  try {
    iges ? write_iges_curves(path, splines, unit) : write_step_curves(path, splines, size);
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() + ": OpenCASCADE failed to write it: " + failure.GetMessageString());
  }
}

}  // namespace batten
