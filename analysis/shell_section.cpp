// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/shell_section.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/errors.h"

namespace batten {

ShellSection ShellSection::of_plies(std::vector<Ply> plies, const Vec3& along) {
  ShellSection section;
  section.laminate = std::make_shared<const Laminate>(std::move(plies));
  section.thickness = section.laminate->thickness();
  section.along = along;
  return section;
}

ShellSection::PlyView ShellSection::ply(int k) const {
  if (!laminate) return {material, -0.5, 0.5, 0};
  const auto i = static_cast<size_t>(k);
  const Ply& of = laminate->plies()[i];
  return {of.material, laminate->heights()[i], laminate->heights()[i + 1], of.angle};
}

bool ShellSection::has_strength() const {
  for (int k = 0; k < ply_count(); ++k)
    if (ply(k).material.strength) return true;
  return false;
}

void require_section(const ShellSection& section) {
  const double least = section.thickness + std::min(0.0, section.thickness_offset.minCoeff());
  if (!(section.thickness > 0 && least > 0) || !std::isfinite(section.thickness) ||
      !section.thickness_offset.allFinite())
    throw InputError("shell section: found thickness = " +
                     format_number(section.thickness > 0 ? least : section.thickness) +
                     ", expected a length above 0");
  if (!section.along.allFinite()) throw InputError("the material direction is not finite");
  if (!std::isfinite(section.offset))
    throw InputError("shell section: found an offset that is not finite");
  if (!section.laminate) require_material(section.material);
}

}  // namespace batten
