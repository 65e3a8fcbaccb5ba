// Points and texts as OpenCASCADE has them.
#pragma once

#include <TCollection_HAsciiString.hxx>
#include <gp_Pnt.hxx>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

inline gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
inline Vec3 from_occ(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
inline Vec3 from_occ(const gp_Pnt& p) { return from_occ(p.XYZ()); }

inline Handle(TCollection_HAsciiString) occ_text(const std::string& text) {
  return new TCollection_HAsciiString(text.c_str());
}

}  // namespace batten
