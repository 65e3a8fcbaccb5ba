#include "batten/skinning/surfaces/embedded_joins.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/fem/surface_transfer.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/model/model_groups.h"
#include "batten/skinning/model/rest_shape.h"

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
    each.push_back(
        finer.region(r).mesh() == layout.region(r).mesh()
            ? layout.region_dofs(r, dofs)
            : carried_over(layout.skinned(r, dofs).surface, *finer.region(r).mesh()).dofs);
  return finer.all_dofs(each);
}

namespace {

struct ModelRegions {
  std::vector<SkinnedRegion> regions;
  std::vector<const SkinnedRegion*> pointers;

  explicit ModelRegions(const JoinedModel& model) {
    for (int r = 0; r < model.layout->region_count(); ++r)
      regions.push_back(model.layout->skinned(r, model.dofs));
    for (const SkinnedRegion& region : regions) pointers.push_back(&region);
  }
};

// The angle at each join that a region carries embedded; 0 at all others.
std::vector<double> angles(const JoinedModel& model) {
  const ModelRegions regions(model);
  const auto& plans = model.layout->join_plans();
  std::vector<double> all(plans.size(), 0.0);
  parallel_parts(count_of(plans), [&](int j) {
    if (!plans[j].given_up() && !plans[j].at.empty())
      all[j] = measure_join(regions.pointers, plans[j].join_line).max_inside_deg;
  });
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
    for (int round = 0; round < most_rounds && halve(); ++round) progress.go_on();
    while (make_creases()) {
    }
    open_ends();
    return std::move(model_);
  }

 private:
  bool falls(size_t j) const {
    constexpr double better = 0.9;
    return now_[j] > most_deg_ && now_[j] < better * before_[j];
  }

  // Halves along the joins whose angles fall, and makes creases of bad ones that fall no more.
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
    ModelLayout finer = *model_.layout;
    if (!finer.refine(marks)) return false;
    const Points shape = carried_over(*model_.layout, model_.dofs, finer);
    if (!has_facets(finer, shape)) return false;
    give_up(finer, [this](size_t j) { return !falls(j); });
    std::vector<double> now = now_;
    if (!solve(finer, shape)) return false;
    before_ = std::move(now);
    return true;
  }

  // Makes creases of joins that stay bad. Whether there is any.
  bool make_creases() {
    ModelLayout fewer = *model_.layout;
    return give_up(fewer, [](size_t) { return true; }) && solve(fewer, model_.dofs);
  }

  // Where only the edge beside an end of a line keeps an angle, that end is a crease.
  void open_ends() {
    if (std::none_of(now_.begin(), now_.end(), [&](double deg) { return deg > most_deg_; })) return;
    std::vector<JoinPlan> plans = model_.layout->join_plans();
    bool any = false;
    const ModelRegions regions(model_);
    for (size_t j = 0; j < plans.size(); ++j)
      if (now_[j] > most_deg_) any = open_end(plans[j], now_[j], regions) || any;
    if (any)
      model_.layout = std::make_shared<const ModelLayout>(model_.layout->frame(),
                                                          model_.layout->regions(), plans);
  }

  // Opens as few ends as leave less than the limit between them. Whether there are any.
  bool open_end(JoinPlan& plan, double degrees, const ModelRegions& regions) const {
    if (plan.closed) return false;
    constexpr double most_open = 1.0 / 3;  // of the line
    const auto& at = plan.at;
    const std::array<double, 2> edge{at[1] - at[0], at.back() - at[at.size() - 2]};
    for (const auto& more :
         {std::array{false, false}, {true, false}, {false, true}, {true, true}}) {
      std::array<bool, 2> open{};
      double share = 0;
      for (size_t e = 0; e < 2; ++e) {
        open[e] = plan.ends[e].open || more[e];
        if (open[e]) share += edge[e];
      }
      if (share > most_open ||
          !(measure_join(regions.pointers, plan.join_line, open).max_inside_deg <= most_deg_))
        continue;
      for (size_t e = 0; e < 2; ++e)
        if (open[e] && !plan.ends[e].open) {
          plan.ends[e].open = plan.ends[e].creased = true;
          plan.ends[e].apart_deg = degrees;
        }
      return more[0] || more[1];
    }
    return false;
  }

  template <class Hopeless>
  bool give_up(ModelLayout& layout, const Hopeless& hopeless) const {
    constexpr double better_a_crease = 0.5;  // degrees
    bool any = false;
    for (size_t j = 0; j < now_.size(); ++j) {
      if (now_[j] <= better_a_crease || !hopeless(j)) continue;
      layout.give_up_join(model_.layout->join_plans()[j].join_line.name,
                          "a region carries it embedded, and would leave an angle of " +
                              number(now_[j]) + " degrees");
      any = true;
    }
    return any;
  }

  // Whether facets can be made of the regions whose meshes are new.
  bool has_facets(const ModelLayout& finer, const Points& shape) const {
    std::vector<char> none(static_cast<size_t>(finer.region_count()), 0);
    parallel_parts(finer.region_count(), [&](int r) {
      none[r] = finer.region(r).mesh() != model_.layout->region(r).mesh() &&
                !why_no_facets(finer.skinned(r, shape)).empty();
    });
    return std::find(none.begin(), none.end(), 1) == none.end();
  }

  // Takes another layout and a shape on it. Joins are planned from the shape, and regions solved,
  // in the groups in which anything is new. Not where that is too much for a mesh.
  bool solve(const ModelLayout& layout, const Points& shape) {
    std::vector<JoinPlan> plans = layout.join_plans();
    std::vector<Points> shapes;
    for (int r = 0; r < layout.region_count(); ++r) shapes.push_back(layout.region_dofs(r, shape));
    const std::vector<char> is_new = new_regions(layout);
    try {
      for (const RegionGroup& group : groups_of(layout.regions(), plans))
        if (std::any_of(group.regions.begin(), group.regions.end(),
                        [&](int r) { return is_new[r]; }))
          solve(layout.frame(), group, shapes, plans);
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {
      return false;
    }
    model_.layout =
        std::make_shared<const ModelLayout>(layout.frame(), layout.regions(), std::move(plans));
    model_.dofs = model_.layout->all_dofs(shapes);
    now_ = angles(model_);
    return true;
  }

  void solve(const ModelFrame& frame, const RegionGroup& group, std::vector<Points>& shapes,
             std::vector<JoinPlan>& plans) const {
    ModelLayout own(frame, group.layouts, group.plans);
    std::vector<Points> before;
    std::map<int, int> in_model;
    for (const int r : group.regions) {
      in_model[count_of(before)] = r;
      before.push_back(shapes[r]);
    }
    own.plan_joins(own.all_dofs(before));
    // A shape in which the regions beside a join do not go on into each other any more was no success.
    for (size_t j = 0; j < group.joins.size(); ++j)
      if (own.join_plans()[j].given_up() && !group.plans[j].given_up())
        throw NoSolutionError(own.join_plans()[j].why_not);
    const Points solved = own.least_energy(material_, rest_dofs(own));
    for (const auto& [mine, r] : in_model) shapes[r] = own.region_dofs(mine, solved);
    for (size_t j = 0; j < group.joins.size(); ++j)
      plans[group.joins[j]] = renumbered(own.join_plans()[j], in_model);
  }

  // Regions that have another mesh than in the present model, or whose group has a join less.
  std::vector<char> new_regions(const ModelLayout& layout) const {
    std::vector<char> is_new;
    for (int r = 0; r < layout.region_count(); ++r)
      is_new.push_back(layout.regions()[r] != model_.layout->regions()[r]);
    for (const RegionGroup& was : groups_of(model_.layout->regions(), model_.layout->join_plans()))
      if (std::any_of(was.joins.begin(), was.joins.end(),
                      [&](size_t j) { return layout.join_plans()[j].given_up(); }))
        for (const int r : was.regions) is_new[r] = 1;
    return is_new;
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
