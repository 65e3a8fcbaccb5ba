// What regions have in common in a STEP file: lines, the places where these end, shells. Internal.
#pragma once

#include <TopoDS_Shape.hxx>
#include <TopoDS_Shell.hxx>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "batten/skinning/region/region.h"

namespace batten {

struct StepLine {
  const HermiteCurve* curve = nullptr;  ///< as the first region has it
  std::array<int, 2> places{};          ///< of its start, end; ends that coincide have the same
  std::vector<double> cuts = {};        ///< parameters where all edges along it end, ascending
};

struct StepShell {
  std::vector<int> regions;  ///< indices into StepPlan::regions
  bool solid = false;
};

struct StepPlan {
  std::vector<const SkinnedRegion*> regions;  ///< shell by shell
  std::vector<StepShell> shells;
  std::map<std::string, StepLine> lines;  ///< all that have a name, of boundaries and inside
  bool joined = false;                    ///< some line is there twice
  double distance = 0;                    ///< at most, of what is to be one; model units
  std::vector<std::string> warnings;
};

/// Regions with a line of the same name are one shell. It is a solid when every line of it has two
/// sides, which run against each other, and its normals point outwards. Regions with three sides at
/// a line, or without a common outside, are a shell each, and a warning says so. Throws InputError:
/// no region, dofs that are not finite, different curves of one name.
StepPlan step_plan(const std::vector<const SkinnedRegion*>& regions);

/// +1 where `curve` is `line`, -1 where it is that line run backwards, 0 where it is neither within
/// `distance`. Taken at equal shares of the parameter.
int direction_along(const HermiteCurve& curve, const HermiteCurve& line, double distance);

/// The shells of a plan as shells and solids; `add` puts a region's faces into one.
TopoDS_Shape assembled(const StepPlan& plan,
                       const std::function<void(int region, TopoDS_Shell& shell)>& add);

}  // namespace batten
