// Plans what the regions of a STEP file share: lines, the points where lines end, and shells.
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

/// A line of one or more regions.
struct StepLine {
  const HermiteCurve* curve = nullptr;  ///< the curve in the first region that has it
  /// Point indices of its start and end; coincident ends have the same index.
  std::array<int, 2> places{};
  int sides = 0;  ///< number of adjacent region sides; a line inside a region has two
  std::vector<double> cuts = {};  ///< parameters where all edges along it end, ascending
};

/// Regions that form one shell.
struct StepShell {
  std::vector<int> regions;  ///< indices into StepPlan::regions
  bool solid = false;
};

/// The regions of a STEP file, and what they share.
struct StepPlan {
  std::vector<const SkinnedRegion*> regions;  ///< ordered shell by shell, solids first
  std::vector<StepShell> shells;
  std::map<std::string, StepLine> lines;  ///< all named lines, of boundaries and inside regions
  bool joined = false;                    ///< true if any line occurs twice
  /// Largest distance at which points or lines count as coincident, model units.
  double distance = 0;
  std::vector<std::string> warnings;
};

/// Plans a file. Regions with a line of the same name form one shell. It is a solid if every line
/// has two sides with opposite directions and the normals point outwards. Regions that meet at a
/// non-manifold line, or cannot be oriented consistently, become a shell each, with a warning.
/// Throws InputError: no region, non-finite dofs, a size above 20 km, different curves under one
/// name.
StepPlan step_plan(const std::vector<const SkinnedRegion*>& regions, double unit_in_metres);

/// +1 if `curve` equals `line`, -1 if it equals the reversed line, 0 otherwise. Points at equal
/// fractions of the parameter ranges are compared, within `distance`.
int direction_along(const HermiteCurve& curve, const HermiteCurve& line, double distance);

/// Builds the shells and solids of a plan. `add` puts the faces of a region into its shell.
TopoDS_Shape assembled(const StepPlan& plan,
                       const std::function<void(int region, TopoDS_Shell& shell)>& add);

}  // namespace batten
