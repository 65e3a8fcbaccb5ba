// The factors of loads and materials on a model scaled to size 1.
#pragma once

#include "batten/fairing/surface_energy.h"

namespace batten {

/// A model of size S is solved on its domain divided by S. In relative units alpha, beta and loads
/// are pure numbers there while dofs keep their length, so that forces get a factor S. In absolute
/// units forces stay as they are and areas of the domain get a factor S². (Between the regions of a
/// model: ModelLayout::domain_scale().)
class ModelScale {
 public:
  ModelScale(LoadUnits units, double size)
      : relative_(units == LoadUnits::Relative), units_(units), size_(size) {}

  SurfaceStiffness material(const SurfaceStiffness& m) const {
    return scaled_to_unit_domain(m, units_, size_);
  }
  /// Returns the factor of a force.
  double force() const { return relative_ ? size_ : 1; }
  /// Return the factors of a force per area of the domain, and per area of the surface itself.
  double per_domain_area() const { return relative_ ? size_ : size_ * size_; }
  double per_area() const { return relative_ ? 1 / size_ : 1; }
  /// Returns the factor of mass and damping per area of the domain.
  double inertia() const { return relative_ ? 1 : size_ * size_; }
  /// Return the factors from forces and energies of the solved problem to those that are reported.
  double reaction_factor() const { return relative_ ? 1 / size_ : 1; }
  double energy_factor() const { return relative_ ? 1 / (size_ * size_) : 1; }

 private:
  bool relative_;
  LoadUnits units_;
  double size_;
};

}  // namespace batten
