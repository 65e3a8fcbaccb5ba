#include "batten/io/lines/curve_cad.h"

#include <IGESBasic_Name.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_BSplineCurve.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_HArray1OfXYZ.hxx>
#include <TCollection_HAsciiString.hxx>
#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/fem/cubic_splines.h"
#include "batten/io/cad/curve_part.h"
#include "batten/io/cad/iges_text.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/occ_values.h"
#include "batten/io/cad/step_text.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

Handle(IGESGeom_BSplineCurve) iges_curve(const CubicSpline& spline) {
  std::vector<double> all;
  for (size_t k = 0; k < spline.knots.size(); ++k)
    all.insert(all.end(), static_cast<size_t>(spline.multiplicities[k]), spline.knots[k]);
  const int count = isize(spline.poles);
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
    curve->SetLabel(occ_text(spline.name.substr(0, 8)));
    const Handle(IGESBasic_Name) name = new IGESBasic_Name;
    name->Init(1, occ_text(spline.name));
    curve->AddProperty(name);
    if (!writer.AddEntity(name) || !writer.AddEntity(curve))
      throw Error(path.string() + ": OpenCASCADE cannot turn the curves into IGES");
  }
  IGESData_GlobalSection header = writer.Model()->GlobalSection();
  header.SetMaxCoord(largest);
  header.SetResolution(1e-9 * largest);
  header.SetAuthorName(occ_text(""));
  header.SetSendName(occ_text(path.stem().string()));
  header.SetFileName(occ_text(path.filename().string()));
  writer.Model()->SetGlobalSection(header);
  write_file_atomically(path, [&](std::ostream& out) {
    if (!print_iges(writer, out)) throw Error(path.string() + ": OpenCASCADE cannot write it");
  });
}

}  // namespace

void write_cad_curves(const fs::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options) {
  const std::string unit = cad_unit(options.unit_in_metres);
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
  try {
    if (lower_extension(path).starts_with(".ig")) return write_iges_curves(path, splines, unit);
    const std::string name = path.stem().string();
    write_parts(path, {part_of_curves(name, splines)},
                {{name, "", "curves"}, options.ap242, 1e-9 * size}, occ);
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() + ": OpenCASCADE failed to write it: " + failure.GetMessageString());
  }
}

}  // namespace batten
