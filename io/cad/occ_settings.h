// SPDX-License-Identifier: MPL-2.0
// Scoped access to OpenCASCADE's process-wide settings, and conversions to its types.
#pragma once

#include <Message_SequenceOfPrinters.hxx>
#include <TCollection_HAsciiString.hxx>
#include <gp_Pnt.hxx>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"

class Geom2d_BSplineCurve;
class Geom_BSplineCurve;

namespace batten {

struct CubicSpline;

/// RAII guard for OpenCASCADE's process-wide translator settings. While it exists, the settings
/// given to set() apply and OpenCASCADE prints nothing. The destructor restores settings, unit and
/// message printers. Only one thread at a time can have such an object; other threads wait.
///
///     OccSettings occ;
///     occ.set("xstep.cascade.unit", "MM");
///     STEPControl_Reader reader;
class OccSettings {
 public:
  OccSettings();
  ~OccSettings();
  OccSettings(const OccSettings&) = delete;
  OccSettings& operator=(const OccSettings&) = delete;

  /// Changes a setting. Throws std::logic_error if OpenCASCADE has no such setting or rejects the
  /// value.
  void set(const char* name, const char* value);
  void set(const char* name, int value);
  void set(const char* name, double value);

  /// Sets the unit ("MM", "M", "INCH" …) of coordinates in memory, for reading and writing. Written
  /// files declare the same unit, so that coordinates are not converted.
  void set_unit(const std::string& name);
  /// The unit that was set; by default a millimetre.
  double unit_in_metres() const { return unit_in_metres_; }

  /// OpenCASCADE's name of a length unit: UM, MM, CM, M, KM, INCH, FT, MI, MIL or UIN. "" for any
  /// other unit, which STEP files of OpenCASCADE cannot declare.
  static std::string unit_name(double unit_in_metres);

 private:
  void keep(const char* name);

  std::unique_lock<std::recursive_mutex> lock_;
  std::vector<std::pair<std::string, std::string>> strings_;
  std::vector<std::pair<std::string, int>> integers_;
  std::vector<std::pair<std::string, double>> reals_;
  double cascade_unit_;  // the previous unit of OpenCASCADE, in millimetres
  double unit_in_metres_ = 1e-3;
  Message_SequenceOfPrinters printers_;
};

// Converts points, splines and strings to and from OpenCASCADE's types.

inline gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
inline Vec3 from_occ(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
inline Vec3 from_occ(const gp_Pnt& p) { return from_occ(p.XYZ()); }

/// The same spline as a curve in space, and in the plane z = 0.
Handle(Geom_BSplineCurve) to_occ(const CubicSpline& spline);
Handle(Geom2d_BSplineCurve) to_flat_occ(const CubicSpline& spline);

inline Handle(TCollection_HAsciiString) occ_string(const std::string& text) {
  return new TCollection_HAsciiString(text.c_str());
}

}  // namespace batten
