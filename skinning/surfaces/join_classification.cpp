#include "batten/skinning/surfaces/join_classification.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "batten/core/disjoint_sets.h"
#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

// Whether the lines of a region fix its tangent plane at an end of one of its arcs: the line before
// or behind it turns a corner there.
bool is_plane_fixed(const CurveNetwork& network, const NetworkRegion& plan, int edge, bool end) {
  constexpr double kCorner = 15;  // degrees
  for (const EdgeLoop& loop : plan.loops)
    for (size_t i = 0; i < loop.size(); ++i) {
      if (loop[i].edge != edge) continue;
      const bool behind = loop[i].reversed != end;
      const OrientedEdge& other = loop[(i + (behind ? 1 : loop.size() - 1)) % loop.size()];
      const double angle_deg =
          degrees_between(network.direction({edge, end}),
                          network.direction({other.edge, other.reversed != !behind}));
      return angle_deg > kCorner && angle_deg < 180 - kCorner;
    }
  return false;
}

// Surfaces that bend from nothing are flatter than those that go on beyond their lines, and meet at more
// between nodes; at nodes, where lines fix their planes, they meet as they will in the end. Rest shapes
// meet as they are meant to along all of the line, and may have no tangent plane at an end, as cones
// at their apex.
double estimate(const CurveNetwork& network, const RegionMaker& maker,
                const std::vector<ModelRegion>& regions, const ModelJoin& join,
                const JoinLine& join_line) {
  const JoinQuality angle = angle_of(regions, join_line);
  const auto rest_shapes = [&](int r) { return maker.rest_shapes()[r].rows() > 0; };
  if (std::all_of(join.regions.begin(), join.regions.end(), rest_shapes)) return angle.mean_deg;
  constexpr double kOfEnd = 0.4;  // where it is known
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

// One angle for each chain of arcs that go on into each other along one region: half of a
// straight side cannot be a crease when the other half is smooth.
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

using Kind = JoinSpec::Kind;

// By arc.
std::map<int, Kind> specs_of(const CurveNetwork& network, const ModelOptions& options) {
  std::map<int, Kind> specs;
  for (const JoinSpec& spec : options.joins) {
    try {
      for (const int a : network.edges_of(spec.line)) specs[a] = spec.kind;
    } catch (const InputError& e) {
      throw InputError(spec.where + e.what());
    }
  }
  return specs;
}

// The join of one arc, and a join line where its two regions can have one.
void add_join(int edge, const std::string& name, const RegionMaker& maker, const Kind* spec,
              JoinClassification& classification) {
  const std::vector<EdgeUse>& uses = maker.sides(edge);
  if (uses.empty()) return;
  ModelJoin join;
  join.edge = edge;
  join.line = name;
  for (const EdgeUse& use : uses) join.regions.push_back(use.region);
  join.kind = uses.size() == 1   ? ModelJoin::Kind::FreeEdge
              : uses.size() == 2 ? ModelJoin::Kind::Crease
                                 : ModelJoin::Kind::NonManifold;
  join.requested = spec != nullptr;
  const bool smooth = spec && *spec != Kind::Crease;
  if (smooth && uses.size() != 2) join.why = std::to_string(uses.size()) + " region(s) meet there";
  if (uses.size() == 2) {
    const auto one = maker.side_of(uses[0], edge), two = maker.side_of(uses[1], edge);
    if (one && two) {
      JoinLine& line = classification.join_lines.emplace_back(JoinLine{name, {*one, *two}});
      if (smooth && *spec != Kind::Smooth) line.curvature = *spec == Kind::Curvature;
      classification.join_of.push_back(isize(classification.joins));
    } else if (smooth) {
      join.why = !maker.layouts()[uses[0].region] || !maker.layouts()[uses[1].region]
                     ? "one of its regions could not be skinned"
                     : "one of its regions does not have it on its boundary";
    }
  }
  classification.joins.push_back(std::move(join));
}

}  // namespace

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
  const std::map<int, Kind> specs = specs_of(network, options);
  JoinClassification classification;
  for (size_t a = 0; a < network.edges().size(); ++a) {
    const auto spec = specs.find(static_cast<int>(a));
    add_join(static_cast<int>(a), network.edges()[a].name, maker,
             spec == specs.end() ? nullptr : &spec->second, classification);
  }
  const std::vector<double> estimates = estimate_chains(network, maker, regions, classification);
  std::vector<JoinLine> smooth;
  std::vector<int> join_of;
  for (size_t s = 0; s < classification.join_lines.size(); ++s) {
    ModelJoin& join = classification.joins[classification.join_of[s]];
    join.initial_deg = estimates[s];
    const auto spec = specs.find(join.edge);
    if (spec != specs.end() ? spec->second == Kind::Crease
                            : !(join.initial_deg < options.crease_angle_deg))
      continue;
    smooth.push_back(classification.join_lines[s]);
    join_of.push_back(classification.join_of[s]);
  }
  classification.join_lines = std::move(smooth);
  classification.join_of = std::move(join_of);
  return classification;
}

}  // namespace batten
