#include "batten/skinning/surfaces/embedded_joins.h"

#include <algorithm>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fem/surface_transfer.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/model/natural_shape.h"

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

class Refiner {
 public:
  Refiner(JoinedModel model, const SurfaceStiffness& material, double most_deg)
      : model_(std::move(model)),
        material_(material),
        most_deg_(most_deg),
        now_(angles(model_)),
        before_(now_.size(), std::numeric_limits<double>::infinity()) {}

  JoinedModel refined(const Progress& progress) {
    constexpr int most_rounds = 3;
    for (int round = 0; round < most_rounds && halve(); ++round) {
      give_up_hopeless(false);
      if (progress.cancelled && progress.cancelled()) throw CancelledError();
    }
    while (give_up_hopeless(true)) {
    }
    return std::move(model_);
  }

 private:
  bool falls(size_t j) const {
    constexpr double better = 0.9;
    return now_[j] > most_deg_ && now_[j] < better * before_[j];
  }

  // Whether there was anything to halve, and the finer mesh has a shape.
  bool halve() {
    constexpr int most_triangles = 20'000;  // a round of more takes seconds
    if (model_.layout->mesh()->triangle_count() > most_triangles) return false;
    std::vector<char> marks(model_.layout->mesh()->triangle_count(), 0);
    bool any = false;
    const auto& plans = model_.layout->join_plans();
    for (size_t j = 0; j < now_.size(); ++j) {
      if (!falls(j)) continue;
      any = true;
      for (const JoinSide& side : plans[j].join_line.sides) mark_along(*model_.layout, side, marks);
    }
    if (!any) return false;
    auto finer = std::make_shared<ModelLayout>(*model_.layout);
    const std::vector<double> now = now_;
    if (!finer->refine(marks)) return false;
    const Points shape = carried_over(*model_.layout, model_.dofs, *finer);
    for (int r = 0; r < finer->region_count(); ++r)
      if (finer->region(r).mesh() != model_.layout->region(r).mesh() &&
          !why_no_facets(finer->skinned(r, shape)).empty())
        return false;
    if (!solve(finer, shape)) return false;
    before_ = now;
    return true;
  }

  // Makes creases of joins that stay bad. Whether there is any.
  bool give_up_hopeless(bool last) {
    constexpr double better_a_crease = 0.5;  // degrees
    auto fewer = std::make_shared<ModelLayout>(*model_.layout);
    bool any = false;
    for (size_t j = 0; j < now_.size(); ++j) {
      if (now_[j] <= better_a_crease || (!last && falls(j))) continue;
      fewer->give_up_join(model_.layout->join_plans()[j].join_line.name,
                          "a region carries it embedded, and would leave an angle of " +
                              number(now_[j]) + " degrees");
      any = true;
    }
    return any && solve(fewer, model_.dofs);
  }

  // Plans all joins of another layout from a shape on it and takes both, unless that is too much
  // for its mesh.
  bool solve(const std::shared_ptr<ModelLayout>& layout, const Points& shape) {
    layout->plan_joins(shape);
    JoinedModel next{layout, {}};
    try {
      next.dofs = layout->least_energy(material_, natural_dofs(*layout));
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {
      return false;
    }
    now_ = angles(next);
    model_ = std::move(next);
    return true;
  }

  JoinedModel model_;
  const SurfaceStiffness& material_;
  const double most_deg_;
  std::vector<double> now_, before_;  // degrees at each join plan; on the mesh before
};

}  // namespace

JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double most_deg, const Progress& progress) {
  return Refiner(std::move(model), material, most_deg).refined(progress);
}

}  // namespace batten
