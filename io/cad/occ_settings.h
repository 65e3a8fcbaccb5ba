// OpenCASCADE's process-wide settings, changed for one task only.
#pragma once

#include <Message_SequenceOfPrinters.hxx>
#include <mutex>
#include <string>
#include <utility>
#include <vector>
#include <TCollection_HAsciiString.hxx>
#include <gp_Pnt.hxx>

#include "batten/core/eigen.h"

namespace batten {

/// While such an object exists, OpenCASCADE's translators have the settings given by set() and
/// print nothing. Its destructor restores settings, unit and printers. The settings belong to the
/// whole process, so only one thread at a time can have such an object (others wait).
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

  /// Changes a setting. Throws std::logic_error when OpenCASCADE does not know it or refuses the
  /// value.
  void set(const char* name, const char* value);
  void set(const char* name, int value);
  void set(const char* name, double value);

  /// Sets the unit ("MM", "M", "INCH" …) of the coordinates that OpenCASCADE reads into and writes
  /// from. Files that are written have the same unit, so that coordinates are not converted.
  void set_unit(const std::string& name);
  /// The unit that was set; a millimetre before.
  double unit_in_metres() const { return unit_in_metres_; }

  /// OpenCASCADE's name of a length unit, or "" for a unit that STEP files of OpenCASCADE cannot
  /// have. Known: UM, MM, CM, M, KM, INCH, FT, MI, MIL, UIN.
  static std::string unit_name(double unit_in_metres);

 private:
  void keep(const char* name);

  std::unique_lock<std::recursive_mutex> lock_;
  std::vector<std::pair<std::string, std::string>> strings_;
  std::vector<std::pair<std::string, int>> integers_;
  std::vector<std::pair<std::string, double>> reals_;
  double cascade_unit_;  // millimetres
  double unit_in_metres_ = 1e-3;
  Message_SequenceOfPrinters printers_;
};


// Points and texts as OpenCASCADE has them.

inline gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
inline Vec3 from_occ(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
inline Vec3 from_occ(const gp_Pnt& p) { return from_occ(p.XYZ()); }

inline Handle(TCollection_HAsciiString) occ_string(const std::string& text) {
  return new TCollection_HAsciiString(text.c_str());
}

}  // namespace batten
