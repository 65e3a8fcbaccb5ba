// Plans what regions have in common in a STEP file: lines, the places where they end, and shells.
// Internal.
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

/// A line of one region or of several.
struct StepLine {
  const HermiteCurve* curve = nullptr;  ///< its curve in the first region that has it
  std::array<int, 2> places{};    ///< numbers of its start and end; ends in one place have the same
  int sides = 0;                  ///< how many regions lie beside it; a line inside one has two
  std::vector<double> cuts = {};  ///< parameters where all edges along it end, ascending
};

/// Regions that make one shell.
struct StepShell {
  std::vector<int> regions;  ///< indices into StepPlan::regions
  bool solid = false;
};

/// The regions of a STEP file, and what they have in common.
struct StepPlan {
  std::vector<const SkinnedRegion*> regions;  ///< all regions, shell by shell, solids first
  std::vector<StepShell> shells;
  std::map<std::string, StepLine> lines;  ///< all lines with a name, of boundaries and inside
  bool joined = false;                    ///< whether any line is there twice
  double distance = 0;  ///< largest distance of points, or of lines, that are one; model units
  std::vector<std::string> warnings;
};

/// Plans a file. Regions with a line of the same name are one shell. It is a solid when every line
/// of it has two sides, which run against each other, and its normals point outwards. Regions with
/// three sides at a line, or without a common outside, are a shell each, and a warning says so.
/// Throws InputError: no region, dofs that are not finite, a size above 20 km, different curves
/// of one name.
StepPlan step_plan(const std::vector<const SkinnedRegion*>& regions, double unit_in_metres);

/// Returns +1 when `curve` is `line`, -1 when it is the line run backwards, 0 when it is neither.
/// Points at equal shares of the parameters are compared, within `distance`.
int direction_along(const HermiteCurve& curve, const HermiteCurve& line, double distance);

/// Makes the shells and solids of a plan. `add` puts a region's faces into its shell.
TopoDS_Shape assembled(const StepPlan& plan,
                       const std::function<void(int region, TopoDS_Shell& shell)>& add);

}  // namespace batten
