#include "batten/skinning/surfaces/embedded_joins.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/fem/surface_transfer.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/model/region_group.h"
#include "batten/skinning/model/rest_shape.h"

namespace batten {

void mark_along(const ModelLayout& layout, const JoinSide& side, std::vector<char>& marks) {
  const RegionLayout& region = layout.region(side.region);
  char* own = marks.data() + layout.first_triangle(side.region);
  const ParametricMesh& mesh = *region.mesh();
  if (!side.embedded) {
    for (const int e : region.edge_aligned()[side.line].edges) own[mesh.edges()[e].triangle[0]] = 1;
    return;
  }
  const TriangleLocator locator(mesh);
  const EmbeddedLine& line = region.embedded()[side.line];
  const double start = line.pcurve.start(), span = line.pcurve.end() - start;
  const int samples = 20 * std::max(1, isize(line.points));
  for (int i = 0; i <= samples; ++i) {
    const Vec3 c = line.pcurve.evaluate(start + span * i / samples);
    own[locator.locate({c.x(), c.y()}).triangle] = 1;
  }
}

Points interpolate_onto(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer) {
  std::vector<Points> each;
  for (int r = 0; r < layout.region_count(); ++r)
    each.push_back(
        finer.region(r).mesh() == layout.region(r).mesh()
            ? layout.region_dofs(r, dofs)
            : interpolate_onto(layout.skinned(r, dofs).surface, *finer.region(r).mesh()).dofs);
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
  parallel_for(isize(plans), [&](int j) {
    if (!plans[j].rejected() && !plans[j].at.empty())
      all[j] = measure_join(regions.pointers, plans[j].join_line).max_inside_deg;
  });
  return all;
}

class Refiner {
 public:
  Refiner(JoinedModel model, const SurfaceStiffness& material, double max_deg_allowed)
      : model_(std::move(model)),
        material_(material),
        max_deg_allowed_(max_deg_allowed),
        now_(angles(model_)),
        before_(now_.size(), std::numeric_limits<double>::infinity()) {}

  JoinedModel refined(const Progress& progress) {
    constexpr int kMaxRounds = 3;
    for (int round = 0; round < kMaxRounds && halve(); ++round) progress.throw_if_cancelled();
    while (make_creases()) {
    }
    open_ends();
    return std::move(model_);
  }

 private:
  bool falls(size_t j) const {
    constexpr double kImprovementRatio = 0.9;
    return now_[j] > max_deg_allowed_ && now_[j] < kImprovementRatio * before_[j];
  }

  // Halves along the joins whose angles fall, and makes creases of bad ones that fall no more.
  // Whether there was anything to halve, and the finer mesh has a shape.
  bool halve() {
    constexpr int kMaxRefinedTriangles = 20'000;  // a round of more takes seconds
    if (model_.layout->mesh()->triangle_count() > kMaxRefinedTriangles) return false;
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
    const Points shape = interpolate_onto(*model_.layout, model_.dofs, finer);
    if (!has_facets(finer, shape)) return false;
    reject(finer, [this](size_t j) { return !falls(j); });
    std::vector<double> now = now_;
    if (!solve(finer, shape)) return false;
    before_ = std::move(now);
    return true;
  }

  // Makes creases of joins that stay bad. Whether there is any.
  bool make_creases() {
    ModelLayout fewer = *model_.layout;
    return reject(fewer, [](size_t) { return true; }) && solve(fewer, model_.dofs);
  }

  // Where only the edge beside an end of a line keeps an angle, that end is a crease.
  void open_ends() {
    if (std::none_of(now_.begin(), now_.end(), [&](double deg) { return deg > max_deg_allowed_; }))
      return;
    std::vector<JoinPlan> plans = model_.layout->join_plans();
    bool any = false;
    const ModelRegions regions(model_);
    for (size_t j = 0; j < plans.size(); ++j)
      if (now_[j] > max_deg_allowed_) any = open_end(plans[j], now_[j], regions) || any;
    if (any)
      model_.layout = std::make_shared<const ModelLayout>(model_.layout->metadata(),
                                                          model_.layout->regions(), plans);
  }

  // Opens as few ends as leave less than the limit between them. Whether there are any.
  bool open_end(JoinPlan& plan, double degrees, const ModelRegions& regions) const {
    if (plan.closed) return false;
    constexpr double kMaxOpen = 1.0 / 3;  // of the line
    const auto& at = plan.at;
    const std::array<double, 2> edge{at[1] - at[0], at.back() - at[at.size() - 2]};
    for (const auto& more :
         {std::array{false, false}, {true, false}, {false, true}, {true, true}}) {
      std::array<bool, 2> open{};
      double open_fraction = 0;
      for (size_t e = 0; e < 2; ++e) {
        open[e] = plan.ends[e].open || more[e];
        if (open[e]) open_fraction += edge[e];
      }
      if (open_fraction > kMaxOpen ||
          !(measure_join(regions.pointers, plan.join_line, open).max_inside_deg <=
            max_deg_allowed_))
        continue;
      for (size_t e = 0; e < 2; ++e)
        if (open[e] && !plan.ends[e].open) {
          plan.ends[e].open = plan.ends[e].creased = true;
          plan.ends[e].plane_angle_deg = degrees;
        }
      return more[0] || more[1];
    }
    return false;
  }

  template <class IsHopeless>
  bool reject(ModelLayout& layout, const IsHopeless& is_hopeless) const {
    constexpr double kBetterACrease = 0.5;  // degrees
    bool any = false;
    for (size_t j = 0; j < now_.size(); ++j) {
      if (now_[j] <= kBetterACrease || !is_hopeless(j)) continue;
      layout.reject_join(model_.layout->join_plans()[j].join_line.name,
                         "a region carries it embedded, and would leave an angle of " +
                             format_number(now_[j]) + " degrees");
      any = true;
    }
    return any;
  }

  // Whether facets can be made of the regions whose meshes are new.
  bool has_facets(const ModelLayout& finer, const Points& shape) const {
    std::vector<char> none(static_cast<size_t>(finer.region_count()), 0);
    parallel_for(finer.region_count(), [&](int r) {
      none[r] = finer.region(r).mesh() != model_.layout->region(r).mesh() &&
                !facet_error(finer.skinned(r, shape)).empty();
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
      for (const RegionGroup& group : join_groups(layout.regions(), plans))
        if (std::any_of(group.regions.begin(), group.regions.end(),
                        [&](int r) { return is_new[r]; }))
          solve(layout.metadata(), group, shapes, plans);
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {
      return false;
    }
    model_.layout =
        std::make_shared<const ModelLayout>(layout.metadata(), layout.regions(), std::move(plans));
    model_.dofs = model_.layout->all_dofs(shapes);
    now_ = angles(model_);
    return true;
  }

  void solve(const ModelMetadata& metadata, const RegionGroup& group, std::vector<Points>& shapes,
             std::vector<JoinPlan>& plans) const {
    ModelLayout own(metadata, group.layouts, group.plans);
    std::vector<Points> before;
    std::map<int, int> to_model_location;
    for (const int r : group.regions) {
      to_model_location[isize(before)] = r;
      before.push_back(shapes[r]);
    }
    own.plan_joins(own.all_dofs(before));
    // A shape in which the regions beside a join do not go on into each other any more was no success.
    for (size_t j = 0; j < group.joins.size(); ++j)
      if (own.join_plans()[j].rejected() && !group.plans[j].rejected())
        throw NoSolutionError(own.join_plans()[j].rejection_reason);
    const Points solved = own.minimize_energy(material_, rest_dofs(own));
    for (const auto& [mine, r] : to_model_location) shapes[r] = own.region_dofs(mine, solved);
    for (size_t j = 0; j < group.joins.size(); ++j)
      plans[group.joins[j]] = renumbered(own.join_plans()[j], to_model_location);
  }

  // Regions that have another mesh than in the present model, or whose group has a join less.
  std::vector<char> new_regions(const ModelLayout& layout) const {
    std::vector<char> is_new;
    for (int r = 0; r < layout.region_count(); ++r)
      is_new.push_back(layout.regions()[r] != model_.layout->regions()[r]);
    for (const RegionGroup& was :
         join_groups(model_.layout->regions(), model_.layout->join_plans()))
      if (std::any_of(was.joins.begin(), was.joins.end(),
                      [&](size_t j) { return layout.join_plans()[j].rejected(); }))
        for (const int r : was.regions) is_new[r] = 1;
    return is_new;
  }

  JoinedModel model_;
  const SurfaceStiffness& material_;
  const double max_deg_allowed_;
  std::vector<double> now_, before_;  // degrees at each join plan; on the mesh before
};

}  // namespace

JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double max_deg_allowed, const Progress& progress) {
  return Refiner(std::move(model), material, max_deg_allowed).refined(progress);
}

}  // namespace batten
