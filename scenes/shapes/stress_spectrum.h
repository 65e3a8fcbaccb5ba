// SPDX-License-Identifier: MPL-2.0
// Response spectrum analysis of a scene's shell.
#pragma once

#include <memory>
#include <vector>

#include "batten/analysis/models/response_spectrum.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// The combined response of a shell at its points.
class SpectrumField {
 public:
  /// Keeps references to the shell and to the response.
  SpectrumField(const ShellModel& shell, const SpectrumResponse& response);
  /// Largest displacements along x, y and z at a location in the mesh of the model.
  Vec3 displacement(const Location& where) const;
  /// Largest von Mises stress at a height above the middle, relative to half of the thickness.
  double von_mises(const Location& where, double height) const;

 private:
  const SpectrumResponse& response_;
  std::vector<Surface> moved_;
  std::vector<std::unique_ptr<const ShellStresses>> stresses_;
};

/// Results of [stress] `spectrum`. `field`: that of `response`. Cost: O(vertices · responses²).
StressReport::Spectrum spectrum_report(const Scene& scene, const ShellModel& shell,
                                       const SpectrumResponse& response,
                                       const SpectrumField& field);

}  // namespace batten
