// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/occ_settings.h"

#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <UnitsMethods.hxx>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "batten/core/containers.h"
#include "batten/fem/curves/bspline.h"

namespace batten {
namespace {

constexpr std::pair<std::string_view, double> kUnits[] = {
    {"MM", 1e-3},     {"CM", 1e-2},   {"M", 1},         {"KM", 1e3},      {"UM", 1e-6},
    {"INCH", 0.0254}, {"FT", 0.3048}, {"MI", 1609.344}, {"MIL", 2.54e-5}, {"UIN", 2.54e-8}};

std::recursive_mutex& process_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

void demand(bool done, const char* name) {
  if (!done) throw std::logic_error("OpenCASCADE refused its setting '" + std::string(name) + "'");
}

}  // namespace

OccSettings::OccSettings() : lock_(process_mutex()) {
  // This creates the settings.
  STEPCAFControl_Controller::Init();
  IGESControl_Controller::Init();
  cascade_unit_ = UnitsMethods::GetCasCadeLengthUnit();
  auto& printers = Message::DefaultMessenger()->ChangePrinters();
  printers_ = printers;
  printers.Clear();
}

OccSettings::~OccSettings() {
  // In reverse order: if a setting was changed twice, the first saved value is the original one.
  for (auto it = strings_.rbegin(); it != strings_.rend(); ++it)
    Interface_Static::SetCVal(it->first.c_str(), it->second.c_str());
  for (auto it = integers_.rbegin(); it != integers_.rend(); ++it)
    Interface_Static::SetIVal(it->first.c_str(), it->second);
  for (auto it = reals_.rbegin(); it != reals_.rend(); ++it)
    Interface_Static::SetRVal(it->first.c_str(), it->second);
  UnitsMethods::SetCasCadeLengthUnit(cascade_unit_);
  Message::DefaultMessenger()->ChangePrinters() = printers_;
}

void OccSettings::keep(const char* name) {
  const Handle(Interface_Static) setting = Interface_Static::Static(name);
  demand(!setting.IsNull(), name);
  switch (setting->Type()) {
    case Interface_ParamInteger:
      integers_.emplace_back(name, Interface_Static::IVal(name));
      break;
    case Interface_ParamReal:
      reals_.emplace_back(name, Interface_Static::RVal(name));
      break;
    default:
      strings_.emplace_back(name, Interface_Static::CVal(name));
  }
}

void OccSettings::set(const char* name, const char* value) {
  keep(name);
  demand(Interface_Static::SetCVal(name, value), name);
}

void OccSettings::set(const char* name, int value) {
  keep(name);
  demand(Interface_Static::SetIVal(name, value), name);
}

void OccSettings::set(const char* name, double value) {
  keep(name);
  demand(Interface_Static::SetRVal(name, value), name);
}

void OccSettings::set_unit(const std::string& name) {
  set("xstep.cascade.unit", name.c_str());
  set("write.step.unit", name.c_str());
  for (const auto& [known, metres] : kUnits)
    if (known == name) unit_in_metres_ = metres;
}

std::string OccSettings::unit_name(double unit_in_metres) {
  for (const auto& [name, metres] : kUnits)
    if (std::abs(unit_in_metres - metres) <= 1e-9 * metres) return std::string(name);
  return "";
}

namespace {

std::pair<TColStd_Array1OfReal, TColStd_Array1OfInteger> knots_of(const CubicSpline& spline) {
  const int n = isize(spline.knots);
  TColStd_Array1OfReal values(1, n);
  TColStd_Array1OfInteger times(1, n);
  for (int i = 1; i <= n; ++i) {
    values(i) = spline.knots[i - 1];
    times(i) = spline.multiplicities[i - 1];
  }
  return {values, times};
}

}  // namespace

Handle(Geom_BSplineCurve) to_occ(const CubicSpline& spline) {
  TColgp_Array1OfPnt poles(1, isize(spline.poles));
  for (int i = 1; i <= poles.Length(); ++i) poles(i) = to_occ(spline.poles[i - 1]);
  const auto [knots, times] = knots_of(spline);
  return new Geom_BSplineCurve(poles, knots, times, 3);
}

Handle(Geom2d_BSplineCurve) to_flat_occ(const CubicSpline& spline) {
  TColgp_Array1OfPnt2d poles(1, isize(spline.poles));
  for (int i = 1; i <= poles.Length(); ++i)
    poles(i) = {spline.poles[i - 1].x(), spline.poles[i - 1].y()};
  const auto [knots, times] = knots_of(spline);
  return new Geom2d_BSplineCurve(poles, knots, times, 3);
}

}  // namespace batten
