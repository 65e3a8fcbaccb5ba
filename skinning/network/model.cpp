#include "batten/skinning/network/model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/words.h"
#include "batten/skinning/network/orientation.h"

namespace batten {
namespace {

// Numbers that belong together; each group is known by its lowest.
class Groups {
 public:
  explicit Groups(size_t count) : lower_(count) { std::iota(lower_.begin(), lower_.end(), 0); }
  int first(int i) const {
    while (lower_[static_cast<size_t>(i)] != i) i = lower_[static_cast<size_t>(i)];
    return i;
  }
  void join(int i, int j) {
    const auto [low, high] = std::minmax({first(i), first(j)});
    lower_[static_cast<size_t>(high)] = low;
  }

 private:
  std::vector<int> lower_;
};

// How a region that is made has a line on its boundary; `region`: its number in what is returned.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name) {
  for (const auto& loop : made.boundary)
    for (const BoundaryPiece& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const bool embedded = piece.kind == BoundaryPiece::Kind::Embedded;
      if ((embedded ? made.embedded[i].line : made.runs[i].line).name != name) continue;
      const bool against = embedded && made.embedded[i].against_given;
      return JoinSide{region, embedded, piece.index, piece.reversed == against};
    }
  return std::nullopt;
}

// The plan with other numbers for its regions.
SeamPlan renumbered(SeamPlan plan, const std::map<int, int>& number) {
  for (JoinSide& side : plan.seam.sides) side.region = number.at(side.region);
  for (SeamEnd& end : plan.ends)
    for (auto& neighbours : end.set)
      for (auto& other : neighbours) other.side.region = number.at(other.side.region);
  return plan;
}

// Angles, areas, volumes and flaws of a model's shape.
void measure(SurfaceModel& model, const Progress& progress);

class ModelMaker {
 public:
  ModelMaker(const CharacterLineNetwork& network, const FoundRegions& found,
             const ModelOptions& options, const Progress& progress)
      : network_(network), options_(options), progress_(progress) {
    std::vector<NetworkRegion> plans = found.regions;
    for (NetworkRegion& plan : plans) open_slits(plan);
    orientation_ = orient(network, plans);
    model_.shells = orientation_.shells;
    model_.regions.resize(plans.size());
    for (size_t r = 0; r < plans.size(); ++r) {
      model_.regions[r].plan = std::move(plans[r]);
      model_.regions[r].plain_area = orientation_.plain_areas[r];
    }
    edge_ = options.skin.edge_length > 0 ? options.skin.edge_length : network.size() / 40;
    tolerance_ = options.skin.tolerance > 0 ? options.skin.tolerance : 1e-4 * network.size();
    for (const NetworkNode& node : network.nodes())
      origin_ += node.position / static_cast<double>(network.nodes().size());
  }

  SurfaceModel make() {
    place_vertices();
    layouts_.resize(model_.regions.size());
    first_.resize(model_.regions.size());
    std::vector<int> all(model_.regions.size());
    std::iota(all.begin(), all.end(), 0);
    lay_out(all, 0, 0.4);
    decide_joins();
    join();
    return std::move(model_);
  }

 private:
  // Where meshes have their vertices on each arc.
  void place_vertices() {
    given_.resize(network_.arcs().size());
    for (size_t a = 0; a < network_.arcs().size(); ++a) {
      const NetworkArc& arc = network_.arcs()[a];
      double spacing = std::min(edge_, 0.5 * arc.length);
      for (const ArcSide& side : orientation_.sides[a]) {
        constexpr double least_across = 8;  // edges across a region
        spacing =
            std::min(spacing, orientation_.sizes[static_cast<size_t>(side.region)] / least_across);
      }
      auto given = std::make_shared<GivenCurve>();
      given->curve = arc.curve;
      const auto& nodes = arc.curve.parameters();
      const double per_length = arc.curve.end() / arc.length;
      given->vertices.push_back(nodes.front());
      for (size_t i = 0; i + 1 < nodes.size(); ++i) {
        const double span = nodes[i + 1] - nodes[i];
        const int cuts =
            std::max(1, static_cast<int>(std::ceil(span / (spacing * per_length) - 0.2)));
        for (int c = 1; c <= cuts; ++c)
          given->vertices.push_back(c == cuts ? nodes[i + 1] : nodes[i] + span * c / cuts);
      }
      given_[a] = std::move(given);
    }
  }

  // A loop that goes along an arc and comes back on it: the arc lies inside then, and what is left
  // are two loops, the longer of which is the outline.
  void open_slits(NetworkRegion& plan) const {
    if (plan.ring) return;
    for (size_t l = 0; l < plan.loops.size(); ++l)
      while (open_slit(plan, l)) {
      }
    // A tube that was cut open along a line: two smooth loops and the cut between them.
    plan.ring = plan.loops.size() == 2 && !plan.inner.empty() && is_smooth(plan.loops[0]) &&
                is_smooth(plan.loops[1]);
  }
  bool is_smooth(const ArcLoop& loop) const {
    for (size_t i = 0; i < loop.size(); ++i) {
      const ArcUse &use = loop[i], &next = loop[(i + 1) % loop.size()];
      const NetworkArc& arc = network_.arcs()[static_cast<size_t>(use.arc)];
      if (arc.on[use.reversed ? 0 : 1] != ArcEnd{next.arc, next.reversed}) return false;
    }
    return true;
  }
  bool open_slit(NetworkRegion& plan, size_t l) const {
    const ArcLoop loop = plan.loops[l];
    for (size_t i = 0; i < loop.size(); ++i)
      for (size_t j = i + 1; j < loop.size(); ++j) {
        if (loop[i].arc != loop[j].arc || loop[i].reversed == loop[j].reversed) continue;
        const auto at = [&](size_t k) { return loop.begin() + static_cast<std::ptrdiff_t>(k); };
        ArcLoop between(at(i + 1), at(j)), around(at(j + 1), loop.end());
        around.insert(around.end(), loop.begin(), at(i));
        if (length_of(around) < length_of(between)) std::swap(around, between);
        if (around.empty()) return false;
        plan.inner.push_back(loop[i].arc);
        plan.loops[l] = std::move(around);
        if (!between.empty()) plan.loops.push_back(std::move(between));
        return true;
      }
    return false;
  }
  double length_of(const ArcLoop& loop) const {
    double sum = 0;
    for (const ArcUse& use : loop) sum += network_.arcs()[static_cast<size_t>(use.arc)].length;
    return sum;
  }

  std::vector<CharacterLine> lines_of(const NetworkRegion& plan) const {
    std::vector<CharacterLine> lines;
    const auto add = [&](int a, CharacterLine::Role role) {
      const NetworkArc& arc = network_.arcs()[static_cast<size_t>(a)];
      CharacterLine line{arc.name, arc.input, role};
      if (role == CharacterLine::Role::Inner)
        line.curve = curve_from_hermite(arc.curve);
      else
        line.given = given_[static_cast<size_t>(a)];
      lines.push_back(std::move(line));
    };
    for (size_t l = 0; l < plan.loops.size(); ++l)
      for (const ArcUse& use : plan.loops[l])
        add(use.arc,
            l == 0 || plan.ring ? CharacterLine::Role::Outline : CharacterLine::Role::Hole);
    for (const int a : plan.inner) add(a, CharacterLine::Role::Inner);
    return lines;
  }

  // Layout and first shape of some regions, side by side.
  void lay_out(const std::vector<int>& which, double from, double to) {
    progress_.at("skinning regions", from);
    parallel_parts(static_cast<int>(which.size()), [&](int i) {
      const auto r = static_cast<size_t>(which[static_cast<size_t>(i)]);
      ModelRegion& region = model_.regions[r];
      region.why_not.clear();
      try {
        lay_out_one(r);
      } catch (const CancelledError&) {
        throw;
      } catch (const std::runtime_error& e) {
        // Made once more for its joins only: then it stays as it was.
        if (layouts_[r]) return;
        region.why_not = e.what();
        if (dynamic_cast<const NoSolutionError*>(&e) ||
            region.why_not.find("parametric") != std::string::npos)
          region.why_not = "its lines leave too little room for elements (" + region.why_not + ")";
      }
    });
    progress_.at("skinning regions", to);
  }

  void lay_out_one(size_t r) {
    const NetworkRegion& plan = model_.regions[r].plan;
    SkinOptions skin = options_.skin;
    constexpr double least_across = 12;  // elements across a small region
    skin.edge_length = std::min(edge_, orientation_.sizes[r] / least_across);
    skin.tolerance = tolerance_;
    skin.domain = plan.ring ? SkinOptions::Domain::Ring : SkinOptions::Domain::Auto;
    skin.against_first = plan.loops[0][0].reversed;
    std::vector<CharacterLine> lines = lines_of(plan);
    std::shared_ptr<const RegionLayout> layout;
    std::vector<std::string> warnings;
    try {
      layout = std::make_shared<const RegionLayout>(plan.name, lines, skin);
    } catch (const InputError& e) {
      if (plan.inner.empty()) throw;
      lines.resize(lines.size() - plan.inner.size());
      layout = std::make_shared<const RegionLayout>(plan.name, lines, skin);
      warnings = {"its inner lines are left out: " + std::string(e.what())};
    }
    Points shape = ModelLayout(frame(), {layout}, {}).least_energy(options_.material);
    model_.regions[r].skinned = layout->region(shape);
    model_.regions[r].warnings = std::move(warnings);
    layouts_[r] = std::move(layout);
    first_[r] = std::move(shape);
  }

  ModelFrame frame() const {
    return {options_.name, network_.size(), tolerance_, origin_, options_.join_tolerance_deg};
  }

  std::optional<JoinSide> side_of(const ArcSide& use, const std::string& arc) const {
    const auto& made = model_.regions[static_cast<size_t>(use.region)].skinned;
    return made ? batten::side_of(*made, use.region, arc) : std::nullopt;
  }

  void decide_joins() {
    progress_.at("joining", 0);
    std::map<int, bool> words;  // smooth or not
    for (const JoinWord& word : options_.joins) {
      try {
        for (const int a : network_.arcs_of(word.line)) words[a] = word.smooth;
      } catch (const InputError& e) {
        throw InputError(word.where + e.what());
      }
    }
    for (size_t a = 0; a < network_.arcs().size(); ++a) {
      const auto& uses = orientation_.sides[a];
      if (uses.empty()) continue;
      ModelJoin join;
      join.arc = static_cast<int>(a);
      join.line = network_.arcs()[a].name;
      for (const ArcSide& use : uses) join.regions.push_back(use.region);
      join.kind = uses.size() == 1   ? ModelJoin::Kind::Rim
                  : uses.size() == 2 ? ModelJoin::Kind::Crease
                                     : ModelJoin::Kind::Branching;
      if (const auto word = words.find(join.arc); word != words.end()) {
        join.asked = true;
        if (uses.size() != 2 && word->second)
          join.why = std::to_string(uses.size()) + " region(s) meet there";
      }
      if (uses.size() == 2) {
        const std::string& name = network_.arcs()[a].name;
        const auto one = side_of(uses[0], name), two = side_of(uses[1], name);
        if (one && two) {
          seams_.push_back({name, {*one, *two}});
          seam_join_.push_back(static_cast<int>(model_.joins.size()));
        } else if (join.asked && words[join.arc]) {
          join.why = !layouts_[static_cast<size_t>(uses[0].region)] ||
                             !layouts_[static_cast<size_t>(uses[1].region)]
                         ? "one of its regions could not be skinned"
                         : "one of its regions does not have it on its boundary";
        }
      }
      model_.joins.push_back(std::move(join));
    }

    const std::vector<double> estimates = estimate_chains();
    std::vector<Seam> smooth;
    std::vector<int> smooth_join;
    for (size_t s = 0; s < seams_.size(); ++s) {
      ModelJoin& join = model_.joins[static_cast<size_t>(seam_join_[s])];
      join.first_deg = estimates[s];
      const auto word = words.find(join.arc);
      if (word != words.end() ? !word->second : !(join.first_deg < options_.smooth_below_deg))
        continue;
      smooth.push_back(seams_[s]);
      smooth_join.push_back(seam_join_[s]);
    }
    seams_ = std::move(smooth);
    seam_join_ = std::move(smooth_join);
  }

  // One angle for each chain of arcs that go on into each other along one region: half of a
  // straight side cannot be a crease when the other half is smooth.
  std::vector<double> estimate_chains() const {
    std::map<int, int> seam_of;
    for (size_t s = 0; s < seams_.size(); ++s)
      seam_of[model_.joins[static_cast<size_t>(seam_join_[s])].arc] = static_cast<int>(s);
    Groups chains(seams_.size());
    for (const auto& [arc, s] : seam_of)
      for (const ArcEnd& on : network_.arcs()[static_cast<size_t>(arc)].on) {
        const auto other = seam_of.find(on.arc);
        if (other == seam_of.end()) continue;
        const auto &mine = orientation_.sides[static_cast<size_t>(arc)],
                   &theirs = orientation_.sides[static_cast<size_t>(on.arc)];
        if (std::none_of(mine.begin(), mine.end(), [&](const ArcSide& a) {
              return std::any_of(theirs.begin(), theirs.end(),
                                 [&](const ArcSide& b) { return a.region == b.region; });
            }))
          continue;
        chains.join(s, other->second);
      }
    std::vector<double> sum(seams_.size(), 0), length(seams_.size(), 0), result;
    for (const auto& [arc, s] : seam_of) {
      const auto r = static_cast<size_t>(chains.first(s));
      const double l = network_.arcs()[static_cast<size_t>(arc)].length;
      sum[r] += l * estimate(seams_[static_cast<size_t>(s)]);
      length[r] += l;
    }
    for (size_t s = 0; s < seams_.size(); ++s) {
      const auto r = static_cast<size_t>(chains.first(static_cast<int>(s)));
      result.push_back(sum[r] / length[r]);
    }
    return result;
  }

  // Surfaces that lines alone make are flatter than those that go on beyond them, and meet at more
  // between nodes; at nodes, where lines fix their planes, they meet as they will in the end.
  double estimate(const Seam& seam) const {
    const SeamAngle angle = angle_of(seam);
    return 0.5 * angle.mean_deg + 0.25 * (angle.end_deg[0] + angle.end_deg[1]);
  }

  // Of the two regions as they are.
  SeamAngle angle_of(Seam seam, const std::array<bool, 2>& open = {}) const {
    std::vector<const SkinnedRegion*> two;
    for (JoinSide& side : seam.sides) {
      two.push_back(&*model_.regions[static_cast<size_t>(side.region)].skinned);
      side.region = static_cast<int>(two.size()) - 1;
    }
    return seam_angle(two, seam, open);
  }

  // Solves the groups of regions that smooth joins connect, and halves along joins that are still
  // above the tolerance.
  void join() {
    std::vector<Points> dofs(model_.regions.size());
    std::vector<SeamPlan> plans;
    for (int round = 0;; ++round) {
      progress_.at("joining", std::min(0.9, (round + 0.2) / (options_.most_join_rounds + 1)));
      plans = solve_groups(dofs);
      give_shapes(dofs);
      std::set<int> halved, again;
      bool fewer = false;
      for (size_t s = 0; s < seams_.size(); ++s) {
        if (!plans[s].why_not.empty()) continue;
        ModelJoin& join = model_.joins[static_cast<size_t>(seam_join_[s])];
        const SeamAngle angle = angle_of(seams_[s], {plans[s].ends[0].open, plans[s].ends[1].open});
        join.max_deg = angle.max_deg;
        join.max_inside_deg = angle.max_inside_deg;
        if (angle.max_inside_deg <= options_.join_tolerance_deg) continue;
        if (!plans[s].at.empty()) {
          // Vertices on an embedded line are not those of its region's mesh: halving would not
          // help.
          constexpr double better_a_crease = 2;
          if (angle.max_inside_deg <= better_a_crease) continue;
          given_up_[join.arc] = "a region carries it embedded, and would leave an angle of " +
                                number(angle.max_inside_deg) + " degrees";
          fewer = true;
        } else if (round < options_.most_join_rounds) {
          halved.insert(join.arc);
          for (const int r : join.regions) again.insert(r);
        }
      }
      if (halved.empty() && !fewer) break;
      for (const int a : halved) halve(a);
      lay_out({again.begin(), again.end()}, 0.5, 0.9);
      find_sides_again();
    }
    // Smooth lines that end where there is no tangent plane, by node.
    std::map<int, std::pair<std::vector<std::string>, double>> without_plane;
    for (size_t s = 0; s < plans.size(); ++s) {
      ModelJoin& join = model_.joins[static_cast<size_t>(seam_join_[s])];
      join.why = plans[s].why_not;
      if (!plans[s].why_not.empty()) continue;
      join.kind = ModelJoin::Kind::Smooth;
      join.one_domain = plans[s].constant();
      for (int e = 0; e < 2; ++e) {
        const SeamEnd& end = plans[s].ends[static_cast<size_t>(e)];
        join.open[static_cast<size_t>(e)] = end.open;
        if (!end.open) continue;
        const NetworkArc& arc = network_.arcs()[static_cast<size_t>(join.arc)];
        auto& at_node = without_plane[arc.nodes[static_cast<size_t>(e)]];
        at_node.first.push_back("'" + arc.name + "'");
        at_node.second = std::max(at_node.second, end.apart_deg);
      }
    }
    for (const auto& [node, lines] : without_plane) {
      std::string names;
      for (const std::string& name : lines.first) names += (names.empty() ? "" : ", ") + name;
      model_.warnings.push_back(
          "no tangent plane at " + at(network_.nodes()[static_cast<size_t>(node)].position) +
          ": the lines that meet there leave one by up to " + number(lines.second) +
          " degrees, so that these end as creases: " + names);
    }
    finish(plans, dofs);
  }

  // Another layout of a region may carry a line in another way.
  void find_sides_again() {
    for (size_t s = 0; s < seams_.size(); ++s) {
      const ModelJoin& join = model_.joins[static_cast<size_t>(seam_join_[s])];
      const auto arc = static_cast<size_t>(join.arc);
      for (size_t k = 0; k < 2; ++k)
        if (const auto side = side_of(orientation_.sides[arc][k], network_.arcs()[arc].name))
          seams_[s].sides[k] = *side;
    }
  }

  std::vector<SeamPlan> solve_groups(std::vector<Points>& dofs) {
    dofs = first_;
    std::vector<SeamPlan> plans(seams_.size());
    std::vector<Seam> possible;
    std::vector<size_t> index;
    for (size_t s = 0; s < seams_.size(); ++s) {
      plans[s].seam = seams_[s];
      const int arc = model_.joins[static_cast<size_t>(seam_join_[s])].arc;
      if (const auto it = given_up_.find(arc); it != given_up_.end()) {
        plans[s].why_not = it->second;
        continue;
      }
      possible.push_back(seams_[s]);
      index.push_back(s);
    }
    std::vector<const RegionLayout*> layouts;
    for (const auto& layout : layouts_) layouts.push_back(layout.get());
    std::vector<SeamPlan> planned =
        plan_seams(layouts, first_, possible, options_.join_tolerance_deg);
    for (size_t i = 0; i < planned.size(); ++i) plans[index[i]] = std::move(planned[i]);
    Groups groups(layouts_.size());
    for (const SeamPlan& plan : plans)
      if (plan.why_not.empty()) groups.join(plan.seam.sides[0].region, plan.seam.sides[1].region);
    std::map<int, std::vector<int>> members;
    for (int r = 0; r < static_cast<int>(layouts_.size()); ++r)
      if (layouts_[static_cast<size_t>(r)]) members[groups.first(r)].push_back(r);
    for (const auto& [first, regions] : members) {
      if (regions.size() < 2 && std::none_of(plans.begin(), plans.end(), [&](const SeamPlan& p) {
            return p.why_not.empty() && p.seam.sides[0].region == first;
          }))
        continue;
      std::map<int, int> local;
      std::vector<std::shared_ptr<const RegionLayout>> some;
      for (const int r : regions) {
        local[r] = static_cast<int>(some.size());
        some.push_back(layouts_[static_cast<size_t>(r)]);
      }
      std::vector<SeamPlan> of_group;
      for (const SeamPlan& plan : plans)
        if (plan.why_not.empty() && local.count(plan.seam.sides[0].region))
          of_group.push_back(renumbered(plan, local));
      const ModelLayout group(frame(), std::move(some), std::move(of_group));
      Points solved;
      try {
        solved = group.least_energy(options_.material);
      } catch (const CancelledError&) {
        throw;
      } catch (const std::runtime_error& e) {
        // The seams of this group do not go together: without those on embedded lines, or none.
        give_up(plans, local, e.what());
        return solve_groups(dofs);
      }
      for (const int r : regions)
        dofs[static_cast<size_t>(r)] = group.region_dofs(local[r], solved);
    }
    return plans;
  }

  void give_up(const std::vector<SeamPlan>& plans, const std::map<int, int>& group,
               const std::string& why) {
    for (const bool embedded : {true, false}) {
      bool any = false;
      for (size_t s = 0; s < plans.size(); ++s) {
        if (!plans[s].why_not.empty() || !group.count(plans[s].seam.sides[0].region) ||
            plans[s].at.empty() == embedded)
          continue;
        given_up_[model_.joins[static_cast<size_t>(seam_join_[s])].arc] = why;
        any = true;
      }
      if (any) return;
    }
  }

  void give_shapes(const std::vector<Points>& dofs) {
    for (size_t r = 0; r < dofs.size(); ++r)
      if (layouts_[r]) model_.regions[r].skinned = layouts_[r]->region(dofs[r]);
  }

  void halve(int a) {
    const GivenCurve& given = *given_[static_cast<size_t>(a)];
    auto finer = std::make_shared<GivenCurve>(GivenCurve{given.curve, {}});
    for (size_t i = 0; i + 1 < given.vertices.size(); ++i) {
      finer->vertices.push_back(given.vertices[i]);
      finer->vertices.push_back(0.5 * (given.vertices[i] + given.vertices[i + 1]));
    }
    finer->vertices.push_back(given.vertices.back());
    given_[static_cast<size_t>(a)] = std::move(finer);
  }

  void finish(const std::vector<SeamPlan>& plans, const std::vector<Points>& dofs) {
    std::map<int, int> number;
    std::vector<std::shared_ptr<const RegionLayout>> regions;
    std::vector<Points> shapes;
    for (size_t r = 0; r < layouts_.size(); ++r) {
      if (!layouts_[r]) continue;
      ModelRegion& region = model_.regions[r];
      region.in_layout = number[static_cast<int>(r)] = static_cast<int>(regions.size());
      const auto& more = layouts_[r]->warnings();
      region.warnings.insert(region.warnings.end(), more.begin(), more.end());
      regions.push_back(layouts_[r]);
      shapes.push_back(dofs[r]);
    }
    if (regions.empty()) return;
    std::vector<SeamPlan> joined;
    for (const SeamPlan& plan : plans)
      if (plan.why_not.empty()) joined.push_back(renumbered(plan, number));
    model_.layout =
        std::make_shared<const ModelLayout>(frame(), std::move(regions), std::move(joined));
    model_.dofs = model_.layout->all_dofs(shapes);
    measure(model_, progress_);
  }

  const CharacterLineNetwork& network_;
  const ModelOptions& options_;
  const Progress& progress_;
  double edge_ = 0, tolerance_ = 0;
  Vec3 origin_ = Vec3::Zero();
  SurfaceModel model_;
  Orientation orientation_;
  std::vector<std::shared_ptr<const GivenCurve>> given_;      // by arc
  std::vector<std::shared_ptr<const RegionLayout>> layouts_;  // by region; none: not skinned
  std::vector<Points> first_;                                 // shapes that their own lines make
  std::vector<Seam> seams_;
  std::map<int, std::string> given_up_;  // arcs whose seam proved worse than a crease, and why
  std::vector<int> seam_join_;           // index into model_.joins
};

}  // namespace

namespace {

double enclosed(const SkinnedRegion& region, const Vec3& origin) {
  const Surface& s = region.surface;
  VecX ones = VecX::Zero(s.dof_map().count());
  for (int v = 0; v < s.mesh().vertex_count(); ++v) ones[s.dof_map().vertex(v)] = 1;
  const Points about = s.dofs() - ones * origin.transpose();
  const SurfaceAssembler assembler(s.mesh(), s.kind(), s.trim());
  return about.cwiseProduct(assembler.pressure_load(about)).sum() / 3;
}

void measure_joins(SurfaceModel& model, const std::vector<const SkinnedRegion*>& made) {
  model.max_join_deg = 0;
  for (ModelJoin& join : model.joins) {
    if (join.kind == ModelJoin::Kind::Smooth) {
      const SeamPlan* plan = model.layout->seam(join.line);
      if (plan) {
        const SeamAngle angle =
            seam_angle(made, plan->seam, {plan->ends[0].open, plan->ends[1].open});
        join.max_deg = angle.max_deg;
        join.max_inside_deg = angle.max_inside_deg;
        join.open = {plan->ends[0].open, plan->ends[1].open};
        model.max_join_deg = std::max(model.max_join_deg, join.max_inside_deg);
        continue;
      }
      join.kind = ModelJoin::Kind::Crease;
      for (const SeamPlan& given_up : model.layout->seams())
        if (given_up.seam.name == join.line) join.why = given_up.why_not;
    }
    if (join.kind != ModelJoin::Kind::Crease) continue;
    std::array<std::optional<JoinSide>, 2> sides;
    for (size_t k = 0; k < 2; ++k) {
      const int r = model.regions[static_cast<size_t>(join.regions[k])].in_layout;
      if (r >= 0) sides[k] = side_of(*made[static_cast<size_t>(r)], r, join.line);
    }
    join.max_deg =
        sides[0] && sides[1] ? seam_angle(made, {join.line, {*sides[0], *sides[1]}}).max_deg : 0;
  }
}

void measure(SurfaceModel& model, const Progress& progress) {
  progress.at("measuring", 0);
  const int n = static_cast<int>(model.regions.size());
  parallel_parts(n, [&](int r) {
    ModelRegion& region = model.regions[static_cast<size_t>(r)];
    if (region.skinned) region.quality = measure(*region.skinned);
  });
  std::vector<SkinQuality> qualities;
  std::vector<double> plain;
  std::vector<int> index;
  model.area = 0;
  for (int r = 0; r < n; ++r) {
    const ModelRegion& region = model.regions[static_cast<size_t>(r)];
    if (!region.skinned) continue;
    qualities.push_back(region.quality);
    plain.push_back(region.plain_area);
    index.push_back(r);
    model.area += region.quality.area;
  }
  const std::vector<const SkinnedRegion*> made = model.skinned();
  measure_joins(model, made);
  for (ModelShell& shell : model.shells) {
    bool whole = true;
    shell.area = shell.volume = 0;
    for (const int r : shell.regions) {
      const ModelRegion& region = model.regions[static_cast<size_t>(r)];
      if (!region.skinned) {
        whole = false;
        continue;
      }
      shell.area += region.quality.area;
      shell.volume += enclosed(*region.skinned, model.layout->origin());
    }
    shell.closed = shell.closed && whole;
    if (!shell.closed || !shell.orientable) shell.volume = 0;
  }
  progress.at("measuring", 0.5);
  model.flaws = find_flaws(made, qualities, plain);
  for (SurfaceFlaw& flaw : model.flaws)
    for (int& r : flaw.regions) r = index[static_cast<size_t>(r)];
  progress.at("measuring", 1);
}

}  // namespace

void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress) {
  for (ModelRegion& region : model.regions)
    if (region.in_layout >= 0)
      region.skinned = std::move(made[static_cast<size_t>(region.in_layout)]);
  model.layout = std::move(layout);
  model.dofs = std::move(dofs);
  measure(model, progress);
}

std::vector<const SkinnedRegion*> SurfaceModel::skinned() const {
  std::vector<const SkinnedRegion*> all;
  for (const ModelRegion& region : regions)
    if (region.skinned) all.push_back(&*region.skinned);
  return all;
}

SurfaceModel skin_network(const CharacterLineNetwork& network, const FoundRegions& found,
                          const ModelOptions& options, const Progress& progress) {
  return ModelMaker(network, found, options, progress).make();
}

}  // namespace batten
