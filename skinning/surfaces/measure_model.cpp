#include "batten/skinning/surfaces/measure_model.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/curvature_continuity.h"
#include "batten/skinning/surfaces/region_maker.h"
#include "batten/skinning/surfaces/surface_defects.h"

namespace batten {
namespace {

double enclosed(const SkinnedRegion& region, const Vec3& origin) {
  const Surface& s = region.surface;
  VecX ones = VecX::Zero(s.dof_map().count());
  for (int v = 0; v < s.mesh().vertex_count(); ++v) ones[s.dof_map().vertex(v)] = 1;
  const Points about = s.dofs() - ones * origin.transpose();
  const SurfaceAssembler assembler(s.mesh(), s.kind(), s.trim());
  return about.cwiseProduct(assembler.pressure_load(about)).sum() / 3;
}

void take_quality(ModelJoin& join, const JoinQuality& quality) {
  join.max_deg = quality.max_deg;
  join.max_inside_deg = quality.max_inside_deg;
  join.max_gap = quality.max_gap;
  join.median_curvature_jump = quality.median_curvature_jump;
  join.max_curvature_jump = quality.max_curvature_jump;
}

void measure_joins(SurfaceModel& model, const std::vector<const SkinnedRegion*>& made) {
  std::map<std::string, const JoinPlan*> plans;  // by line; of two the one that is not given up
  for (const JoinPlan& plan : model.layout->join_plans()) {
    const JoinPlan*& of_line = plans[plan.join_line.name];
    if (!of_line || of_line->rejected()) of_line = &plan;
  }
  parallel_for(isize(model.joins), [&](int j) {
    ModelJoin& join = model.joins[j];
    if (join.kind == ModelJoin::Kind::Smooth) {
      const auto found = plans.find(join.line);
      const JoinPlan* plan = found == plans.end() ? nullptr : found->second;
      if (plan && !plan->rejected()) {
        take_quality(join,
                     measure_join(made, plan->join_line, {plan->ends[0].open, plan->ends[1].open}));
        join.open = {plan->ends[0].open, plan->ends[1].open};
        join.curvature = is_curvature_continuous(*model.layout, *plan);
        return;
      }
      join.kind = ModelJoin::Kind::Crease;
      if (plan) join.why = plan->rejection_reason;
    }
    if (join.kind != ModelJoin::Kind::Crease) return;
    std::array<std::optional<JoinSide>, 2> sides;
    for (size_t k = 0; k < 2; ++k) {
      const int r = model.regions[join.regions[k]].layout_index;
      if (r >= 0) sides[k] = side_of(*made[r], r, join.line);
    }
    take_quality(join, sides[0] && sides[1]
                           ? measure_join(made, {join.line, {*sides[0], *sides[1]}})
                           : JoinQuality{});
    join.max_inside_deg = 0;
  });
  model.max_join_deg = 0;
  for (const ModelJoin& join : model.joins)
    if (join.kind == ModelJoin::Kind::Smooth)
      model.max_join_deg = std::max(model.max_join_deg, join.max_inside_deg);
}

// Area and volume of a shell; the volume of one that is closed with all its regions.
void measure_shell(const SurfaceModel& model, ModelShell& shell) {
  shell.area = shell.volume = 0;
  for (const int r : shell.regions) {
    const ModelRegion& region = model.regions[r];
    shell.closed = shell.closed && region.skinned;
    if (region.skinned) shell.area += region.quality.area;
  }
  shell.normals = {};
  if (!shell.orientable) return;
  std::vector<const SkinnedRegion*> made;
  for (const int r : shell.regions)
    if (model.regions[r].skinned) made.push_back(&*model.regions[r].skinned);
  shell.normals = normal_side(side_integrals(made), shell.closed);
  if (!shell.closed) return;
  std::vector<double> under(shell.regions.size());
  parallel_for(isize(under), [&](int k) {
    under[k] = enclosed(*model.regions[shell.regions[k]].skinned, model.layout->origin());
  });
  for (const double volume : under) shell.volume += volume;
}

// Whether two regions meet at a line that the user asked to be a crease: a knife's edge may be.
bool has_requested_crease(const SurfaceModel& model, const std::vector<int>& regions) {
  return std::any_of(model.joins.begin(), model.joins.end(), [&](const ModelJoin& join) {
    return join.requested && join.kind == ModelJoin::Kind::Crease &&
           std::is_permutation(join.regions.begin(), join.regions.end(), regions.begin(),
                               regions.end());
  });
}

}  // namespace

void measure(SurfaceModel& model, const Progress& progress) {
  progress.update("measuring", 0);
  const int n = isize(model.regions);
  parallel_for(n, [&](int r) {
    ModelRegion& region = model.regions[r];
    if (!region.skinned) return;
    region.quality = measure(*region.skinned);
    region.shape =
        fit_primitive(*region.skinned, primitive_tolerance(*region.skinned, model.layout->size()));
  });
  std::vector<SkinQuality> qualities;
  std::vector<double> filling_areas;
  std::vector<int> index;
  model.area = 0;
  for (int r = 0; r < n; ++r) {
    const ModelRegion& region = model.regions[r];
    if (!region.skinned) continue;
    qualities.push_back(region.quality);
    filling_areas.push_back(region.filling_area);
    index.push_back(r);
    model.area += region.quality.area;
  }
  const std::vector<const SkinnedRegion*> made = model.skinned();
  measure_joins(model, made);
  for (ModelShell& shell : model.shells) measure_shell(model, shell);
  progress.update("measuring", 0.5);
  model.defects = find_defects(made, qualities, filling_areas);
  for (SurfaceDefect& defect : model.defects)
    for (int& r : defect.regions) r = index[r];
  std::erase_if(model.defects, [&](const SurfaceDefect& defect) {
    return defect.kind == SurfaceDefect::Kind::Fold && defect.regions.size() == 2 &&
           has_requested_crease(model, defect.regions);
  });
  progress.update("measuring", 1);
}

}  // namespace batten
