// SPDX-License-Identifier: MPL-2.0
// FreeCAD's "BOP check" of a STEP file.
#pragma once

#include <BOPAlgo_ArgumentAnalyzer.hxx>

#include <filesystem>

#include "batten/io/step/step_check.h"

namespace batten_test {

/// The number of faults that it finds.
inline int faults(const std::filesystem::path& path) {
  BOPAlgo_ArgumentAnalyzer check;
  check.SetShape1(batten::read_step(path));
  check.ArgumentTypeMode() = true;
  check.SelfInterMode() = true;
  check.SmallEdgeMode() = true;
  check.ContinuityMode() = true;
  check.CurveOnSurfaceMode() = true;
  check.Perform();
  return check.GetCheckResult().Extent();
}

}  // namespace batten_test
