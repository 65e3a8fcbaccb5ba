// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/step_plan.h"

#include <BRep_Builder.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Solid.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/surface_assembler.h"

namespace batten {
namespace {

/// One side of a curve: the adjacent model face, and +1 if its loop runs along the curve, -1 if
/// against it.
struct LineSide {
  int region, orientation;
};

Vec3 end_of(const HermiteCurve& curve, bool end) {
  return end ? curve.evaluate({curve.segment_count() - 1, 1.0}) : curve.position(0);
}

class Planner {
 public:
  Planner(const std::vector<const SkinnedRegion*>& regions, double unit_in_metres)
      : regions_(regions) {
    if (regions.empty()) throw InputError("STEP: found no face to write, expected at least one");
    for (const SkinnedRegion* region : regions) {
      if (!region->surface.dofs().allFinite())
        throw InputError("STEP: face '" + region->name + "' has coordinates that are not finite");
      for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
        extend_box(aligned_line.fitted);
      for (const EmbeddedLine& line : region->embedded) extend_box(line.fitted);
    }
    require_size(unit_in_metres);
    if (!box_.isEmpty()) plan_.distance = 1e-6 * box_.diagonal().norm();
    open_.resize(regions.size());
    for (int r = 0; r < isize(regions); ++r) add_lines(r);
    find_end_points();
    for (const auto& [name, sides] : sides_) plan_.lines.at(name).sides = isize(sides);
  }

  StepPlan plan() {
    std::vector<char> done(regions_.size());
    for (int r = 0; r < isize(regions_); ++r)
      if (!done[r]) {
        const std::vector<int> group = connected_regions(r);
        for (const int k : group) done[k] = 1;
        add_shells(group);
      }
    put_solids_first();
    return std::move(plan_);
  }

 private:
  // OpenCASCADE resolves 1e-7 mm. In larger files, edges deviate from their faces by 1e-4 of the
  // size, reading takes minutes, or it fails.
  void require_size(double unit_in_metres) const {
    constexpr double most_metres = 2e4;
    const double size = box_.isEmpty() ? 0 : box_.diagonal().norm();
    if (size * unit_in_metres > most_metres)
      throw InputError("STEP: found a surface of size " + format_number(size) +
                       ", expected at most " + format_number(most_metres / unit_in_metres) +
                       " (20 km; check the length unit)");
  }

  void extend_box(const HermiteCurve& curve) {
    for (int i = 0; i < curve.node_count(); ++i) box_.extend(curve.position(i));
  }

  void add_lines(int r) {
    const SkinnedRegion& region = *regions_[r];
    std::set<const HermiteCurve*> on_boundary;
    open_[r] = region.boundary.empty();
    for (const auto& loop : region.boundary)
      for (const BoundarySegment& piece : loop) {
        const bool aligned_line = piece.kind == BoundarySegment::Kind::EdgeAligned;
        const auto i = static_cast<size_t>(piece.index);
        const std::string& name =
            aligned_line ? region.edge_aligned.at(i).line.name : region.embedded.at(i).line.name;
        const HermiteCurve& curve =
            aligned_line ? region.edge_aligned[i].fitted : region.embedded[i].fitted;
        on_boundary.insert(&curve);
        if (name.empty())
          open_[r] = 1;
        else
          sides_[name].push_back({r, (piece.reversed ? -1 : 1) * direction(name, curve, r)});
      }
    const auto add_inner = [&](const std::string& name, const HermiteCurve& curve) {
      if (name.empty() || on_boundary.count(&curve)) return;
      direction(name, curve, r);
      sides_[name].insert(sides_[name].end(), {{r, 1}, {r, -1}});
    };
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
      add_inner(aligned_line.line.name, aligned_line.fitted);
    for (const EmbeddedLine& line : region.embedded) add_inner(line.line.name, line.fitted);
  }

  int direction(const std::string& name, const HermiteCurve& curve, int r) {
    const auto [it, added] = plan_.lines.emplace(name, StepLine{&curve});
    if (added) return 1;
    plan_.joined = true;
    if (const int orientation = direction_along(curve, *it->second.curve, plan_.distance))
      return orientation;
    throw InputError("STEP: faces '" + regions_[sides_[name].front().region]->name + "' and '" +
                     regions_[r]->name + "' have different curves named '" + name +
                     "'; expected one curve, or two names");
  }

  void find_end_points() {
    std::vector<Vec3> places;
    for (auto& [name, line] : plan_.lines)
      for (const bool end : {false, true}) {
        const Vec3 p = end_of(*line.curve, end);
        const auto found = std::find_if(places.begin(), places.end(), [&](const Vec3& q) {
          return (p - q).norm() <= plan_.distance;
        });
        line.places[end] = static_cast<int>(found - places.begin());
        if (found == places.end()) places.push_back(p);
      }
  }

  std::vector<int> connected_regions(int first) const {
    std::set<int> group{first};
    for (size_t before = 0; before != group.size();) {
      before = group.size();
      for (const auto& [name, sides] : sides_)
        if (std::any_of(sides.begin(), sides.end(),
                        [&](const LineSide& s) { return group.count(s.region) > 0; }))
          for (const LineSide& s : sides) group.insert(s.region);
    }
    return {group.begin(), group.end()};
  }

  void add_shells(const std::vector<int>& group) {
    bool closed = true, branching = false, one_sided = false;
    for (const int r : group) closed = closed && !open_[r];
    for (const auto& [name, sides] : sides_) {
      if (std::find(group.begin(), group.end(), sides.front().region) == group.end()) continue;
      closed = closed && sides.size() == 2;
      branching = branching || sides.size() > 2;
      one_sided = one_sided || (sides.size() == 2 && sides[0].orientation == sides[1].orientation);
    }
    const int start = isize(plan_.regions);
    for (const int r : group) plan_.regions.push_back(regions_[r]);
    if (branching || one_sided) {
      if (group.size() > 1)
        plan_.warnings.push_back(
            std::string("connected faces ") +
            (branching ? "with more than two faces at an edge" : "without a common orientation") +
            " are written as separate shells without shared edges");
      for (size_t k = 0; k < group.size(); ++k)
        plan_.shells.push_back({{start + static_cast<int>(k)}});
      return;
    }
    StepShell shell{std::vector<int>(group.size()), closed && volume(group) > 0};
    std::iota(shell.regions.begin(), shell.regions.end(), start);
    plan_.shells.push_back(std::move(shell));
  }

  // STEP files list solids before other shells. With the same order in the plan, faces are read
  // back in the order of the plan.
  void put_solids_first() {
    std::stable_partition(plan_.shells.begin(), plan_.shells.end(),
                          [](const StepShell& shell) { return shell.solid; });
    const std::vector<const SkinnedRegion*> before = std::move(plan_.regions);
    plan_.regions.clear();
    for (StepShell& shell : plan_.shells)
      for (int& r : shell.regions) {
        plan_.regions.push_back(before[r]);
        r = isize(plan_.regions) - 1;
      }
  }

  /// The enclosed volume: ⅓ ∬ x · (x_u × x_v).
  double volume(const std::vector<int>& group) const {
    double sum = 0;
    for (const int r : group) {
      const Surface& surface = regions_[r]->surface;
      Points about = surface.dofs();
      for (int v = 0; v < surface.mesh().vertex_count(); ++v)
        about.row(surface.dof_map().vertex(v)) -= box_.center().transpose();
      const SurfaceAssembler assembler(surface.mesh(), surface.kind(), surface.trim());
      sum += about.cwiseProduct(assembler.pressure_load(about)).sum() / 3;
    }
    return sum;
  }

  const std::vector<const SkinnedRegion*>& regions_;
  Box3 box_;
  StepPlan plan_;
  std::map<std::string, std::vector<LineSide>> sides_;
  // True for a model face with a boundary curve that has no name, or without boundary.
  std::vector<char> open_;
};

}  // namespace

StepPlan step_plan(const std::vector<const SkinnedRegion*>& regions, double unit_in_metres) {
  return Planner(regions, unit_in_metres).plan();
}

int direction_along(const HermiteCurve& curve, const HermiteCurve& line, double distance) {
  double apart[2] = {0, 0};
  for (const double fraction : {0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 0.999}) {
    const auto at = [&](const HermiteCurve& c, double s) {
      return c.evaluate(c.start() + s * (c.end() - c.start()));
    };
    const Vec3 x = at(curve, fraction);
    apart[0] = std::max(apart[0], (x - at(line, fraction)).norm());
    // The end of a closed curve coincides with its start.
    apart[1] = std::max(apart[1], (x - at(line, 1 - fraction)).norm());
  }
  if (!(std::min(apart[0], apart[1]) <= distance)) return 0;
  return apart[1] < apart[0] ? -1 : 1;
}

TopoDS_Shape assembled(const StepPlan& plan,
                       const std::function<void(int region, TopoDS_Shell& shell)>& add) {
  const BRep_Builder builder;
  TopoDS_Compound compound;
  builder.MakeCompound(compound);
  TopoDS_Shape last;
  for (const StepShell& planned : plan.shells) {
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    for (const int region : planned.regions) add(region, shell);
    shell.Closed(planned.solid);
    last = shell;
    if (planned.solid) {
      TopoDS_Solid solid;
      builder.MakeSolid(solid);
      builder.Add(solid, shell);
      last = solid;
    }
    builder.Add(compound, last);
  }
  return plan.shells.size() > 1 ? TopoDS_Shape(compound) : last;
}

}  // namespace batten
