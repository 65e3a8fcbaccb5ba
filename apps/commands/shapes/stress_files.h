// Files and pictures of stresses, natural modes and buckling modes.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/apps/commands/shapes/shape_files.h"

namespace batten {

/// File name of a load case without extension: NAME_CASE, with NAME of the scene. It consists of
/// letters, digits, '-' and '_'.
std::string stress_stem(const Scene& scene, const std::string& name);

/// Magnification of drawn displacements for a model of this size: a factor 1, 2 or 5 times a power
/// of ten, so that the largest displacement is at most a twentieth of the size.
double deformation_scale(double largest, double size);

/// Writes shell results into the folder of a run, with the prefix NAME_ of the scene, and lists the
/// files in its report. Pictures use the view of the scene's first picture.
class StressFiles {
 public:
  StressFiles(RunContext& run, const Scene& scene, const ShellModel& shell)
      : run_(run), scene_(scene), shell_(shell) {}

  /// Writes a load case: NAME_CASE.vtu on the undeformed shape and NAME_CASE.png, the equivalent
  /// stress on the deformed shape. The .vtu has Displacement, Von_mises_top, _middle and _bottom,
  /// Stress_top, _middle and _bottom, Forces, Moments and Thickness (tensors as xx, yy, zz, xy, yz,
  /// xz). `largest`: largest displacement.
  void write_case(const std::string& name, const Points& displacement, double largest,
                  const ShellStresses& stresses);

  /// Writes mode shapes: NAME_KIND.pvd, a series NAME_KIND_1.vtu, … with the Displacement of each
  /// mode, normalised to a maximum of 1. NAME_KIND.png is a contact sheet with captions;
  /// NAME_KIND_1.gif, … are animations.
  void write_mode_shapes(const std::string& kind, const std::vector<Points>& shapes,
                         const std::vector<std::string>& captions);

 private:
  std::vector<SkinnedRegion> regions_of(const Points& dofs) const;
  PictureScene view() const;
  double largest(const Points& displacement) const;

  RunContext& run_;
  const Scene& scene_;
  const ShellModel& shell_;
};

}  // namespace batten
