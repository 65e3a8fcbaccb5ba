// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/model_joins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/model/model_shapes.h"

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

// Largest inner angle at each join on an embedded line, degrees; 0 for all other joins.
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

  // Halves triangles along the joins whose angles decrease; bad joins that no longer improve become
  // creases. Returns false if there is nothing to halve, or if the finer mesh has no shape.
  bool halve() {
    constexpr int kMaxRefinedTriangles = 20'000;  // a round with more takes seconds
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

  // Turns joins that stay bad into creases. Returns true if there are any.
  bool make_creases() {
    ModelLayout fewer = *model_.layout;
    return reject(fewer, [](size_t) { return true; }) && solve(fewer, model_.dofs);
  }

  // If only the mesh edge next to an end of a line exceeds the angle, that end becomes a crease.
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

  // Makes as few ends creases as are needed to keep the limit in between. Returns true if there are
  // any.
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
                         "it is embedded in one of its faces, which would leave an angle of " +
                             format_number(now_[j]) + " degrees");
      any = true;
    }
    return any;
  }

  // True if the regions with new meshes can be tessellated.
  bool has_facets(const ModelLayout& finer, const Points& shape) const {
    std::vector<char> none(static_cast<size_t>(finer.region_count()), 0);
    parallel_for(finer.region_count(), [&](int r) {
      none[r] = finer.region(r).mesh() != model_.layout->region(r).mesh() &&
                !facet_error(finer.skinned(r, shape)).empty();
    });
    return std::find(none.begin(), none.end(), 1) == none.end();
  }

  // Adopts a layout with an initial shape: plans joins from the shape and solves, in the groups
  // with changes. Returns false if a mesh cannot be solved.
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
    // It is a failure if regions next to a join no longer continue each other in the shape.
    for (size_t j = 0; j < group.joins.size(); ++j)
      if (own.join_plans()[j].rejected() && !group.plans[j].rejected())
        throw NoSolutionError(own.join_plans()[j].rejection_reason);
    const Points solved = own.minimize_energy(material_, rest_dofs(own));
    for (const auto& [mine, r] : to_model_location) shapes[r] = own.region_dofs(mine, solved);
    for (size_t j = 0; j < group.joins.size(); ++j)
      plans[group.joins[j]] = renumbered(own.join_plans()[j], to_model_location);
  }

  // Regions whose mesh differs from that of the current model, or whose group has lost a join.
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
  std::vector<double> now_, before_;  // degrees per join plan, on the present and the previous mesh
};

}  // namespace

JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double max_deg_allowed, const Progress& progress) {
  return Refiner(std::move(model), material, max_deg_allowed).refined(progress);
}

namespace {

// Calls `use` with the index of each region on which the constraints of a join act; it may change
// it.
template <class Plan, class Use>
void for_regions(Plan& plan, const Use& use) {
  for (auto& side : plan.join_line.sides) use(side.region);
  for (auto& end : plan.ends)
    for (auto& neighbours : end.set)
      for (auto& other : neighbours) use(other.side.region);
}

template <class Items, class Same>
bool all_same(const Items& a, const Items& b, const Same& same) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

auto numbers_of(const JoinSide& side) {
  return std::tie(side.region, side.embedded, side.line, side.left, side.neighbour);
}

bool same_end(const JoinEnd& a, const JoinEnd& b) {
  const auto numbers = [](const JoinEnd& e) {
    return std::tie(e.gamma, e.delta, e.plane_angle_deg, e.open, e.undetermined);
  };
  using Neighbour = JoinEnd::Neighbour;
  const auto same = [](const Neighbour& p, const Neighbour& q) {
    return numbers_of(p.side) == numbers_of(q.side) && p.end == q.end;
  };
  return numbers(a) == numbers(b) && all_same(a.set[0], b.set[0], same) &&
         all_same(a.set[1], b.set[1], same);
}

bool same_plan(const JoinPlan& a, const JoinPlan& b) {
  const auto numbers = [](const JoinPlan& p) {
    return std::tie(p.join_line.name, p.at, p.gamma, p.delta, p.closed, p.end_conditions,
                    p.rejection_reason);
  };
  const auto same_side = [](const JoinSide& p, const JoinSide& q) {
    return numbers_of(p) == numbers_of(q);
  };
  return numbers(a) == numbers(b) && all_same(a.join_line.sides, b.join_line.sides, same_side) &&
         all_same(a.ends, b.ends, same_end);
}

}  // namespace

bool is_same_problem(const RegionGroup& a, const RegionGroup& b) {
  return a.layouts == b.layouts && all_same(a.plans, b.plans, same_plan);
}

JoinPlan renumbered(JoinPlan plan, const std::map<int, int>& number) {
  for_regions(plan, [&](int& region) { region = number.at(region); });
  return plan;
}

std::vector<RegionGroup> join_groups(
    const std::vector<std::shared_ptr<const RegionLayout>>& layouts,
    const std::vector<JoinPlan>& plans) {
  DisjointSets groups(layouts.size());
  for (const JoinPlan& plan : plans)
    if (!plan.rejected())
      for_regions(plan, [&](int r) { groups.unite(plan.join_line.sides[0].region, r); });
  std::map<int, RegionGroup> by_lowest;
  std::map<int, int> number;  // index of each region within its group
  for (int r = 0; r < isize(layouts); ++r) {
    if (!layouts[r]) continue;
    RegionGroup& group = by_lowest[groups.find(r)];
    number[r] = isize(group.regions);
    group.regions.push_back(r);
    group.layouts.push_back(layouts[r]);
  }
  for (size_t s = 0; s < plans.size(); ++s) {
    if (plans[s].rejected()) continue;
    RegionGroup& group = by_lowest.at(groups.find(plans[s].join_line.sides[0].region));
    group.joins.push_back(s);
    group.plans.push_back(renumbered(plans[s], number));
  }
  std::vector<RegionGroup> all;
  for (auto& [lowest, group] : by_lowest) all.push_back(std::move(group));
  return all;
}

namespace {

// The direction, away from an end of a network edge, of the other edge that bounds a region there;
// nullopt if the region is not bounded by the edge or if the two edges form no corner.
std::optional<Vec3> direction_of_other_edge(const CurveNetwork& network, const NetworkRegion& plan,
                                            int edge, bool end) {
  constexpr double kCorner = 15;  // degrees
  for (const EdgeLoop& loop : plan.loops)
    for (size_t i = 0; i < loop.size(); ++i) {
      if (loop[i].edge != edge) continue;
      const bool behind = loop[i].reversed != end;
      const OrientedEdge& other = loop[(i + (behind ? 1 : loop.size() - 1)) % loop.size()];
      const Vec3 direction = network.direction({other.edge, other.reversed != !behind});
      const double angle_deg = degrees_between(network.direction({edge, end}), direction);
      if (angle_deg > kCorner && angle_deg < 180 - kCorner) return direction;
      return std::nullopt;
    }
  return std::nullopt;
}

// True if the lines of a region fix its tangent plane at an end of a network edge: the previous or
// next edge of the loop forms a corner there.
bool is_plane_fixed(const CurveNetwork& network, const NetworkRegion& plan, int edge, bool end) {
  return direction_of_other_edge(network, plan, edge, end).has_value();
}

// Estimates the angle at a join. Surfaces without rest shape are flatter than those that continue
// beyond their lines, so they meet at larger angles between nodes. At nodes, lines fix their planes
// and the angle is final. Rest shapes have the intended angle along the whole line, but may have no
// tangent plane at an end, as at the apex of a cone.
double estimate(const CurveNetwork& network, const RegionMaker& maker,
                const std::vector<ModelRegion>& regions, const ModelJoin& join,
                const JoinLine& join_line) {
  const JoinQuality angle = angle_of(regions, join_line);
  const auto rest_shapes = [&](int r) { return maker.rest_shapes()[r].rows() > 0; };
  if (join.neighbour || std::all_of(join.regions.begin(), join.regions.end(), rest_shapes))
    return angle.mean_deg;
  constexpr double kOfEnd = 0.4;  // weight of an end at which the angle is known
  double sum = 0, known_weight = 0;
  for (const bool end : {false, true}) {
    const bool known = std::all_of(join.regions.begin(), join.regions.end(), [&](int r) {
      return is_plane_fixed(network, regions[r].plan, join.edge, end);
    });
    if (!known || std::isnan(angle.end_deg[end])) continue;
    sum += kOfEnd * angle.end_deg[end];
    known_weight += kOfEnd;
  }
  return sum + (1 - known_weight) * angle.mean_deg;
}

// Averages the estimates over each chain of edges that continue each other along one region. Half
// of a straight side cannot be a crease if the other half is smooth.
std::vector<double> estimate_chains(const CurveNetwork& network, const RegionMaker& maker,
                                    const std::vector<ModelRegion>& regions,
                                    const JoinClassification& classification) {
  const std::vector<JoinLine>& join_lines = classification.join_lines;
  std::map<int, int> join_line_of;
  for (size_t s = 0; s < join_lines.size(); ++s)
    join_line_of[classification.joins[classification.join_of[s]].edge] = static_cast<int>(s);
  DisjointSets chains(join_lines.size());
  for (const auto& [edge, s] : join_line_of)
    for (const EdgeEnd& on : network.edges()[edge].continuation) {
      const auto other = join_line_of.find(on.edge);
      if (other == join_line_of.end()) continue;
      const auto &mine = maker.sides(edge), &theirs = maker.sides(on.edge);
      if (std::none_of(mine.begin(), mine.end(), [&](const EdgeUse& a) {
            return std::any_of(theirs.begin(), theirs.end(),
                               [&](const EdgeUse& b) { return a.region == b.region; });
          }))
        continue;
      chains.unite(s, other->second);
    }
  std::vector<double> estimates(join_lines.size());
  parallel_for(isize(estimates), [&](int s) {
    estimates[s] = estimate(network, maker, regions,
                            classification.joins[classification.join_of[s]], join_lines[s]);
  });
  std::vector<double> sum(join_lines.size(), 0), length(join_lines.size(), 0), result;
  for (const auto& [edge, s] : join_line_of) {
    const auto r = static_cast<size_t>(chains.find(s));
    const double l = network.edges()[edge].length;
    sum[r] += l * estimates[s];
    length[r] += l;
  }
  for (size_t s = 0; s < join_lines.size(); ++s) {
    const auto r = static_cast<size_t>(chains.find(static_cast<int>(s)));
    result.push_back(sum[r] / length[r]);
  }
  return result;
}

// Angles, degrees, between the tangent plane of a given surface and the plane of the curves that
// meet at the ends of an edge; those of ends at which the curves form a corner.
std::vector<double> corner_angles(const CurveNetwork& network, const NetworkRegion& plan,
                                  const ModelJoin& join) {
  std::vector<double> angles;
  for (const bool end : {false, true}) {
    const auto across = direction_of_other_edge(network, plan, join.edge, end);
    if (!across) continue;
    const Vec3 along = network.direction({join.edge, end});
    const double deg = degrees_between(join.neighbour->into(end ? 1 : 0, along).cross(along),
                                       along.cross(*across));
    angles.push_back(std::min(deg, 180 - deg));
  }
  return angles;
}

// Mean of points on the boundary of a face.
Vec3 boundary_centre(const CurveNetwork& network, const NetworkRegion& plan) {
  Vec3 sum = Vec3::Zero();
  double length = 0;
  constexpr int samples = 16;
  for (const EdgeLoop& loop : plan.loops)
    for (const OrientedEdge& use : loop) {
      const NetworkEdge& edge = network.edges()[use.edge];
      for (int i = 0; i < samples; ++i)
        sum += edge.length / samples * edge.curve.evaluate(edge.curve.end() * i / samples);
      length += edge.length;
    }
  return sum / length;
}

// True if the given surface beside an edge, continued with its curvature κ, would close the opening:
// a sphere that meets the plane of the opening at the angle θ, in a circle of radius ρ, has
// κ ρ = sin θ; a cylinder has κ = 0. θ must be below a right angle: bowls get a flat lid.
bool closes_opening(const CurveNetwork& network, const RegionMaker& maker,
                    const NetworkRegion& plan, const ModelJoin& join) {
  constexpr double most_deg = 85, of_sphere = 0.5;
  constexpr int samples = 16;
  if (!(join.initial_deg < most_deg)) return false;
  const Vec3 centre = boundary_centre(network, plan);
  const HermiteCurve& curve = maker.prescribed(join.edge)->curve;
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    const double f = (i + 0.5) / samples;
    const Vec3 x = curve.evaluate(curve.start() + f * (curve.end() - curve.start()));
    sum += join.neighbour->curvature(f).dot(centre - x) / samples;
  }
  return sum > of_sphere * std::pow(std::sin(join.initial_deg * std::numbers::pi / 180), 2);
}

// Whether an edge beside a given surface is a crease by default. At corners, the curves fix the
// tangent plane; without corners, the initial shape and the curvature of the given surface are the
// only indications.
bool is_crease_at_neighbour(const CurveNetwork& network, const RegionMaker& maker,
                            const ModelOptions& options, const std::vector<ModelRegion>& regions,
                            const ModelJoin& join) {
  const NetworkRegion& plan = regions[join.regions[0]].plan;
  const std::vector<double> angles = corner_angles(network, plan, join);
  if (angles.empty())
    return !(join.initial_deg < options.neighbour_crease_angle_deg) &&
           !closes_opening(network, maker, plan, join);
  return !(*std::max_element(angles.begin(), angles.end()) < options.crease_angle_deg);
}

using SpecKind = JoinSpec::Kind;

// User specifications by network edge.
std::map<int, SpecKind> specs_of(const CurveNetwork& network, const ModelOptions& options) {
  std::map<int, SpecKind> specs;
  for (const JoinSpec& spec : options.joins) {
    try {
      for (const int a : network.edges_of(spec.line)) specs[a] = spec.kind;
    } catch (const InputError& e) {
      throw InputError(spec.where + e.what());
    }
  }
  return specs;
}

SpecKind kind_of(NeighbourContinuity continuity) {
  return continuity == NeighbourContinuity::Position    ? SpecKind::Crease
         : continuity == NeighbourContinuity::Curvature ? SpecKind::Curvature
                                                        : SpecKind::Tangent;
}

// Adds the line of the join that comes next in the classification.
void add_join_line(const ModelJoin& join, const JoinSide& one, const JoinSide& two,
                   const SpecKind* spec, JoinClassification& classification) {
  JoinLine& line = classification.join_lines.emplace_back(JoinLine{join.line, {one, two}});
  if (spec && *spec != SpecKind::Crease && *spec != SpecKind::Smooth)
    line.curvature = *spec == SpecKind::Curvature;
  classification.join_of.push_back(isize(classification.joins));
}

// Adds the join of one network edge, and a join line if its two regions can be joined.
void add_join(int edge, const CurveNetwork& network, const RegionMaker& maker,
              const ModelOptions& options, const SpecKind* spec,
              JoinClassification& classification) {
  const std::string& name = network.edges()[edge].name;
  SpecKind stated{};
  const std::vector<EdgeUse>& uses = maker.sides(edge);
  if (uses.empty()) return;
  ModelJoin join;
  join.edge = edge;
  join.line = name;
  for (const EdgeUse& use : uses) join.regions.push_back(use.region);
  join.kind = uses.size() == 1   ? ModelJoin::Kind::FreeEdge
              : uses.size() == 2 ? ModelJoin::Kind::Crease
                                 : ModelJoin::Kind::NonManifold;
  if (uses.size() == 1 && !options.neighbours.empty() && maker.prescribed(edge))
    join.neighbour = NeighbourEdge::along(
        maker.prescribed(edge)->curve, options.neighbours,
        options.neighbour_tolerance > 0 ? options.neighbour_tolerance : network.tolerance());
  if (join.neighbour && !spec && join.neighbour->continuity() != NeighbourContinuity::Automatic) {
    stated = kind_of(join.neighbour->continuity());
    spec = &stated;
  }
  join.requested = spec != nullptr;
  const bool smooth = spec && *spec != SpecKind::Crease;
  if (join.neighbour) {
    if (const auto side = maker.side_of(uses[0], edge))
      add_join_line(join, *side, beside(*side, join.neighbour), spec, classification);
  } else if (smooth && uses.size() != 2)
    join.why = "it belongs to " + std::to_string(uses.size()) +
               (uses.size() == 1 ? " face" : " faces") + ", expected two";
  if (uses.size() == 2) {
    const auto one = maker.side_of(uses[0], edge), two = maker.side_of(uses[1], edge);
    if (one && two) {
      add_join_line(join, *one, *two, spec, classification);
    } else if (smooth) {
      join.why = !maker.layouts()[uses[0].region] || !maker.layouts()[uses[1].region]
                     ? "one of its faces could not be skinned"
                     : "it is not on the boundary of one of its faces";
    }
  }
  classification.joins.push_back(std::move(join));
}

}  // namespace

JoinSide beside(JoinSide side, std::shared_ptr<const NeighbourEdge> neighbour) {
  side.left = !side.left;
  side.neighbour = std::move(neighbour);
  return side;
}

JoinQuality angle_of(const std::vector<ModelRegion>& regions, JoinLine join_line,
                     const std::array<bool, 2>& open) {
  std::vector<const SkinnedRegion*> two;
  for (JoinSide& side : join_line.sides) {
    two.push_back(&*regions[side.region].skinned);
    side.region = isize(two) - 1;
  }
  return measure_join(two, join_line, open);
}

JoinClassification classify_joins(const CurveNetwork& network, const RegionMaker& maker,
                                  const ModelOptions& options,
                                  const std::vector<ModelRegion>& regions) {
  const std::map<int, SpecKind> specs = specs_of(network, options);
  JoinClassification classification;
  for (size_t a = 0; a < network.edges().size(); ++a) {
    const auto spec = specs.find(static_cast<int>(a));
    add_join(static_cast<int>(a), network, maker, options,
             spec == specs.end() ? nullptr : &spec->second, classification);
  }
  const std::vector<double> estimates = estimate_chains(network, maker, regions, classification);
  std::vector<JoinLine> smooth;
  std::vector<int> join_of;
  for (size_t s = 0; s < classification.join_lines.size(); ++s) {
    ModelJoin& join = classification.joins[classification.join_of[s]];
    join.initial_deg = estimates[s];
    const auto spec = specs.find(join.edge);
    const bool crease =
        spec != specs.end() ? spec->second == SpecKind::Crease
        : join.requested    ? join.neighbour->continuity() == NeighbourContinuity::Position
        : join.neighbour    ? is_crease_at_neighbour(network, maker, options, regions, join)
                            : !(join.initial_deg < options.crease_angle_deg);
    if (crease) continue;
    smooth.push_back(classification.join_lines[s]);
    join_of.push_back(classification.join_of[s]);
  }
  classification.join_lines = std::move(smooth);
  classification.join_of = std::move(join_of);
  return classification;
}

}  // namespace batten
