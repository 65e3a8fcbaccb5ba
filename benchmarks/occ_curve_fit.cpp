// SPDX-License-Identifier: MPL-2.0
#include "occ_curve_fit.h"

#if BATTEN_BENCH_OCC

#include <GeomAPI_PointsToBSpline.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Standard_Failure.hxx>
#include <Standard_Version.hxx>
#include <TColgp_Array1OfPnt.hxx>

namespace batten::bench {

std::string occ_curves_version() { return OCC_VERSION_COMPLETE; }

struct OccCurveFit::Data {
  Handle(Geom_BSplineCurve) curve;
};

OccCurveFit::OccCurveFit(const std::vector<Vec3>& points, const OccCurveFitSettings& s)
    : data_(std::make_unique<Data>()) {
  TColgp_Array1OfPnt array(1, static_cast<int>(points.size()));
  for (size_t i = 0; i < points.size(); ++i)
    array.SetValue(static_cast<int>(i) + 1, {points[i].x(), points[i].y(), points[i].z()});
  const GeomAbs_Shape continuity = s.continuity == 1 ? GeomAbs_C1 : GeomAbs_C2;
  try {
    GeomAPI_PointsToBSpline fit;
    if (s.variational)
      fit.Init(array, s.weights[0], s.weights[1], s.weights[2], s.degree, continuity, s.tolerance);
    else
      fit.Init(array, s.degree, s.degree, continuity, s.tolerance);
    if (fit.IsDone()) data_->curve = fit.Curve();
  } catch (const Standard_Failure&) {
  }
}
OccCurveFit::~OccCurveFit() = default;
OccCurveFit::OccCurveFit(OccCurveFit&&) noexcept = default;

bool OccCurveFit::done() const { return !data_->curve.IsNull(); }

std::vector<double> OccCurveFit::knots() const {
  std::vector<double> knots;
  for (int i = 1; i <= data_->curve->NbKnots(); ++i) knots.push_back(data_->curve->Knot(i));
  return knots;
}

Vec3 OccCurveFit::evaluate(double u, int order) const {
  if (order == 0) {
    const gp_Pnt p = data_->curve->Value(u);
    return {p.X(), p.Y(), p.Z()};
  }
  const gp_Vec d = data_->curve->DN(u, order);
  return {d.X(), d.Y(), d.Z()};
}

}  // namespace batten::bench

#else

#include <stdexcept>

namespace batten::bench {

std::string occ_curves_version() { return ""; }

struct OccCurveFit::Data {};
OccCurveFit::OccCurveFit(const std::vector<Vec3>&, const OccCurveFitSettings&) {
  throw std::logic_error("built without OpenCASCADE");
}
OccCurveFit::~OccCurveFit() = default;
OccCurveFit::OccCurveFit(OccCurveFit&&) noexcept = default;
bool OccCurveFit::done() const { return false; }
std::vector<double> OccCurveFit::knots() const { return {}; }
Vec3 OccCurveFit::evaluate(double, int) const { return Vec3::Zero(); }

}  // namespace batten::bench

#endif
