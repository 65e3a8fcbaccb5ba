// What bending and stretching cost, and in which units.
#pragma once

#include "batten/elements/surface_stiffness.h"

namespace batten {

/// Relative (default): alpha, beta and loads are pure numbers on the region scaled to size 1, so
/// that the same region in mm and in m is the same shape under the same numbers. Absolute: alpha is
/// force/length, beta force·length, uniform loads and pressure force/length², point loads force,
/// all in the model's length unit.
enum class LoadUnits { Relative, Absolute };

/// The material on a domain that is the region over its size (u = length / size). Stretching is
/// free of scale in two dimensions; bending carries 1/size² in absolute units.
inline SurfaceStiffness scaled_to_unit_domain(const SurfaceStiffness& material, LoadUnits units,
                                              double size) {
  SurfaceStiffness scaled = material;
  if (units == LoadUnits::Absolute) {
    scaled.beta /= size * size;
    scaled.beta_mixed /= size * size;
  }
  return scaled;
}

struct SurfaceEnergy {
  double stretching = 0;  ///< ∬ alpha part of the energy, sum over x, y, z
  double bending = 0;     ///< ∬ beta part
};

}  // namespace batten
