// Files and pictures of stresses, vibrations and buckling.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/apps/commands/shapes/shape_files.h"

namespace batten {

/// The name of a case's files without their ending: NAME_CASE after the scene, of letters, digits,
/// '-' and '_'.
std::string stress_stem(const Scene& scene, const std::string& name);

/// How much a displacement is drawn larger in a model of this size: by 1, 2, 5, 10, …, a twentieth of
/// the model at most.
double deformation_scale(double largest, double size);

/// Writes what a shell does into the folder of a run, NAME_… after the scene, and lists the files in
/// its report. Pictures are seen as the scene's first picture.
class StressFiles {
 public:
  StressFiles(RunContext& run, const Scene& scene, const ShellModel& shell)
      : run_(run), scene_(scene), shell_(shell) {}

  /// NAME_CASE.vtu on the undeformed shape, with Displacement, Von_mises_top, _middle and _bottom,
  /// Stress_top, _middle and _bottom, Forces, Moments, Thickness (tensors as xx, yy, zz, xy, yz, xz), and
  /// NAME_CASE.png, the equivalent stress on the deformed shape. `largest`: displacement.
  void write_case(const std::string& name, const Points& displacement, double largest,
                  const ShellStresses& stresses);

  /// NAME_KIND.pvd, a series of NAME_KIND_1.vtu, … with the Displacement of each shape, the largest 1;
  /// NAME_KIND.png, a sheet of all of them with their captions, and NAME_KIND_1.gif, …, on which they
  /// swing.
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
