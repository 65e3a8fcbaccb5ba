// Lines that carry the design of a surface.
#pragma once

#include <memory>
#include <string>

#include "batten/fairing/input_curve.h"

namespace batten {

struct CharacterLine {
  enum class Role {
    Outline,  ///< part of the loop around the region, or of one of the two loops of a ring
    Hole,     ///< part of a loop around a hole
    Inner     ///< runs across the region, or inside of it
  };
  /// How the surface carries the line (docs/theory/domains.md).
  enum class Treatment {
    Auto,     ///< fitted where the domain can have it as a straight run, otherwise embedded
    Fitted,   ///< on a straight run of element edges: the surface is exactly on the line
    Embedded  ///< across the elements: held at points, the gap between them is measured
  };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
  Treatment treatment = Treatment::Auto;
};

}  // namespace batten
