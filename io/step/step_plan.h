// SPDX-License-Identifier: MPL-2.0
// Plans what the model faces of a STEP file share: curves, the points where curves end, and shells.
#pragma once

#include <TopoDS_Shape.hxx>
#include <TopoDS_Shell.hxx>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// A curve of one or more model faces.
struct StepLine {
  const HermiteCurve* curve = nullptr;  ///< the curve in the first model face that has it
  /// Point indices of its start and end; coincident ends have the same index.
  std::array<int, 2> places{};
  int sides = 0;  ///< number of adjacent model face sides; a curve inside a model face has two
  std::vector<double> cuts = {};  ///< parameters where all edges along it end, ascending
};

/// Model faces that form one shell.
struct StepShell {
  std::vector<int> regions;  ///< indices into StepPlan::regions
  bool solid = false;
};

/// The model faces of a STEP file, and what they share.
struct StepPlan {
  std::vector<const SkinnedRegion*> regions;  ///< ordered shell by shell, solids first
  std::vector<StepShell> shells;
  /// All named curves, of boundaries and inside model faces.
  std::map<std::string, StepLine> lines;
  bool joined = false;  ///< true if any curve occurs twice
  /// Largest distance at which points or curves count as coincident, model units.
  double distance = 0;
  std::vector<std::string> warnings;
};

/// Plans a file. Model faces with a curve of the same name form one shell. It is a solid if every
/// curve has two sides with opposite directions and the normals point outwards. Model faces that
/// meet at a non-manifold curve, or cannot be oriented consistently, become a shell each, with a
/// warning. Throws InputError: no model face, non-finite dofs, a size above 20 km, different curves
/// under one name.
StepPlan step_plan(const std::vector<const SkinnedRegion*>& regions, double unit_in_metres);

/// +1 if `curve` equals `line`, -1 if it equals the reversed curve, 0 otherwise. Points at equal
/// fractions of the parameter ranges are compared, within `distance`.
int direction_along(const HermiteCurve& curve, const HermiteCurve& line, double distance);

/// Builds the shells and solids of a plan. `add` puts the CAD faces of a model face into its shell.
TopoDS_Shape assembled(const StepPlan& plan,
                       const std::function<void(int region, TopoDS_Shell& shell)>& add);

}  // namespace batten
