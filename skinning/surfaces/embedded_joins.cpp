#include "batten/skinning/surfaces/embedded_joins.h"

#include <algorithm>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fem/surface_transfer.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

void mark_along(const ModelLayout& layout, const JoinSide& side, std::vector<char>& marks) {
  const RegionLayout& region = layout.region(side.region);
  char* own = marks.data() + layout.first_triangle(side.region);
  const ParametricMesh& mesh = *region.mesh();
  if (!side.embedded) {
    for (const int e : region.runs()[side.line].edges) own[mesh.edges()[e].triangle[0]] = 1;
    return;
  }
  const TriangleLocator locator(mesh);
  const EmbeddedLine& line = region.embedded()[side.line];
  const double start = line.image.start(), span = line.image.end() - start;
  const int samples = 20 * std::max(1, count_of(line.points));
  for (int i = 0; i <= samples; ++i) {
    const Vec3 c = line.image.evaluate(start + span * i / samples);
    own[locator.locate({c.x(), c.y()}).triangle] = 1;
  }
}

Points carried_over(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer) {
  std::vector<Points> each;
  for (int r = 0; r < layout.region_count(); ++r)
    each.push_back(carried_over(layout.skinned(r, dofs).surface, *finer.region(r).mesh()).dofs);
  return finer.all_dofs(each);
}

namespace {

// The angle at each join that a region carries embedded; 0 at all others.
std::vector<double> angles(const JoinedModel& model) {
  std::vector<SkinnedRegion> regions;
  for (int r = 0; r < model.layout->region_count(); ++r)
    regions.push_back(model.layout->skinned(r, model.dofs));
  std::vector<const SkinnedRegion*> pointers;
  for (const SkinnedRegion& region : regions) pointers.push_back(&region);
  std::vector<double> all;
  for (const JoinPlan& plan : model.layout->join_plans())
    all.push_back(plan.given_up() || plan.at.empty()
                      ? 0
                      : measure_join(pointers, plan.join_line).max_inside_deg);
  return all;
}

}  // namespace

JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double most_deg, const Progress& progress) {
  constexpr int most_rounds = 3, most_triangles = 20'000;  // a round of more takes seconds
  constexpr double better = 0.9;
  std::vector<double> now = angles(model),
                      before(now.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < most_rounds; ++round) {
    if (model.layout->mesh()->triangle_count() > most_triangles) break;
    if (progress.cancelled && progress.cancelled()) throw CancelledError();
    std::vector<char> marks(model.layout->mesh()->triangle_count(), 0);
    bool any = false;
    const auto& plans = model.layout->join_plans();
    for (size_t j = 0; j < now.size(); ++j) {
      if (!(now[j] > most_deg) || !(now[j] < better * before[j])) continue;
      any = true;
      for (const JoinSide& side : plans[j].join_line.sides) mark_along(*model.layout, side, marks);
    }
    if (!any) break;
    auto finer = std::make_shared<ModelLayout>(*model.layout);
    if (!finer->refine(marks)) break;
    finer->plan_joins(carried_over(*model.layout, model.dofs, *finer));
    JoinedModel next{finer, {}};
    try {
      next.dofs = finer->least_energy(material);
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {  // too much for this mesh: the last shape stands
      break;
    }
    before = now;
    now = angles(next);
    model = std::move(next);
  }
  model.angles = std::move(now);
  return model;
}

}  // namespace batten
