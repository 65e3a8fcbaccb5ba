// Lines that carry the design of a surface.
#pragma once

#include <memory>
#include <string>

#include "batten/fairing/input_curve.h"

namespace batten {

struct CharacterLine {
  enum class Role { Outline, Inner };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
};

}  // namespace batten
