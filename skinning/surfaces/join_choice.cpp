#include "batten/skinning/surfaces/join_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/groups.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/core/words.h"

namespace batten {
namespace {

// Whether the lines of a region fix its tangent plane at an end of one of its arcs: the line before
// or behind it turns a corner there.
bool is_plane_fixed(const CharacterLineNetwork& network, const NetworkRegion& plan, int arc,
                    bool end) {
  constexpr double corner = 15;  // degrees
  for (const ArcLoop& loop : plan.loops)
    for (size_t i = 0; i < loop.size(); ++i) {
      if (loop[i].arc != arc) continue;
      const bool behind = loop[i].reversed != end;
      const ArcUse& other = loop[(i + (behind ? 1 : loop.size() - 1)) % loop.size()];
      const double turn = degrees_between(
          network.direction({arc, end}), network.direction({other.arc, other.reversed != !behind}));
      return turn > corner && turn < 180 - corner;
    }
  return false;
}

// Surfaces that bend from nothing are flatter than those that go on beyond their lines, and meet at more
// between nodes; at nodes, where lines fix their planes, they meet as they will in the end. Rest shapes
// meet as they are meant to along all of the line, and may have no tangent plane at an end, as cones
// at their apex.
double estimate(const CharacterLineNetwork& network, const RegionMaker& maker,
                const std::vector<ModelRegion>& regions, const ModelJoin& join,
                const JoinLine& join_line) {
  const JoinQuality angle = angle_of(regions, join_line);
  const auto rests = [&](int r) { return maker.rests()[r].rows() > 0; };
  if (std::all_of(join.regions.begin(), join.regions.end(), rests)) return angle.mean_deg;
  constexpr double of_end = 0.4;  // where it is known
  double sum = 0, share = 0;
  for (const bool end : {false, true}) {
    const bool known = std::all_of(join.regions.begin(), join.regions.end(), [&](int r) {
      return is_plane_fixed(network, regions[r].plan, join.arc, end);
    });
    if (!known || std::isnan(angle.end_deg[end])) continue;
    sum += of_end * angle.end_deg[end];
    share += of_end;
  }
  return sum + (1 - share) * angle.mean_deg;
}

// One angle for each chain of arcs that go on into each other along one region: half of a
// straight side cannot be a crease when the other half is smooth.
std::vector<double> estimate_chains(const CharacterLineNetwork& network, const RegionMaker& maker,
                                    const std::vector<ModelRegion>& regions,
                                    const JoinChoice& choice) {
  const std::vector<JoinLine>& join_lines = choice.join_lines;
  std::map<int, int> join_line_of;
  for (size_t s = 0; s < join_lines.size(); ++s)
    join_line_of[choice.joins[choice.join_of[s]].arc] = static_cast<int>(s);
  Groups chains(join_lines.size());
  for (const auto& [arc, s] : join_line_of)
    for (const ArcEnd& on : network.arcs()[arc].on) {
      const auto other = join_line_of.find(on.arc);
      if (other == join_line_of.end()) continue;
      const auto &mine = maker.sides(arc), &theirs = maker.sides(on.arc);
      if (std::none_of(mine.begin(), mine.end(), [&](const ArcSide& a) {
            return std::any_of(theirs.begin(), theirs.end(),
                               [&](const ArcSide& b) { return a.region == b.region; });
          }))
        continue;
      chains.join(s, other->second);
    }
  std::vector<double> estimates(join_lines.size());
  parallel_parts(count_of(estimates), [&](int s) {
    estimates[s] =
        estimate(network, maker, regions, choice.joins[choice.join_of[s]], join_lines[s]);
  });
  std::vector<double> sum(join_lines.size(), 0), length(join_lines.size(), 0), result;
  for (const auto& [arc, s] : join_line_of) {
    const auto r = static_cast<size_t>(chains.of(s));
    const double l = network.arcs()[arc].length;
    sum[r] += l * estimates[s];
    length[r] += l;
  }
  for (size_t s = 0; s < join_lines.size(); ++s) {
    const auto r = static_cast<size_t>(chains.of(static_cast<int>(s)));
    result.push_back(sum[r] / length[r]);
  }
  return result;
}

using Kind = JoinWord::Kind;

// By arc.
std::map<int, Kind> words_of(const CharacterLineNetwork& network, const ModelOptions& options) {
  std::map<int, Kind> words;
  for (const JoinWord& word : options.joins) {
    try {
      for (const int a : network.arcs_of(word.line)) words[a] = word.kind;
    } catch (const InputError& e) {
      throw InputError(word.where + e.what());
    }
  }
  return words;
}

// The join of one arc, and a join line where its two regions can have one.
void add_join(int arc, const std::string& name, const RegionMaker& maker, const Kind* word,
              JoinChoice& choice) {
  const std::vector<ArcSide>& uses = maker.sides(arc);
  if (uses.empty()) return;
  ModelJoin join;
  join.arc = arc;
  join.line = name;
  for (const ArcSide& use : uses) join.regions.push_back(use.region);
  join.kind = uses.size() == 1   ? ModelJoin::Kind::Rim
              : uses.size() == 2 ? ModelJoin::Kind::Crease
                                 : ModelJoin::Kind::Branching;
  join.asked = word != nullptr;
  const bool smooth = word && *word != Kind::Crease;
  if (smooth && uses.size() != 2) join.why = std::to_string(uses.size()) + " region(s) meet there";
  if (uses.size() == 2) {
    const auto one = maker.side_of(uses[0], arc), two = maker.side_of(uses[1], arc);
    if (one && two) {
      JoinLine& line = choice.join_lines.emplace_back(JoinLine{name, {*one, *two}});
      if (smooth && *word != Kind::Smooth) line.curvature = *word == Kind::Curvature;
      choice.join_of.push_back(count_of(choice.joins));
    } else if (smooth) {
      join.why = !maker.layouts()[uses[0].region] || !maker.layouts()[uses[1].region]
                     ? "one of its regions could not be skinned"
                     : "one of its regions does not have it on its boundary";
    }
  }
  choice.joins.push_back(std::move(join));
}

}  // namespace

JoinQuality angle_of(const std::vector<ModelRegion>& regions, JoinLine join_line,
                     const std::array<bool, 2>& open) {
  std::vector<const SkinnedRegion*> two;
  for (JoinSide& side : join_line.sides) {
    two.push_back(&*regions[side.region].skinned);
    side.region = count_of(two) - 1;
  }
  return measure_join(two, join_line, open);
}

JoinChoice choose_joins(const CharacterLineNetwork& network, const RegionMaker& maker,
                        const ModelOptions& options, const std::vector<ModelRegion>& regions) {
  const std::map<int, Kind> words = words_of(network, options);
  JoinChoice choice;
  for (size_t a = 0; a < network.arcs().size(); ++a) {
    const auto word = words.find(static_cast<int>(a));
    add_join(static_cast<int>(a), network.arcs()[a].name, maker,
             word == words.end() ? nullptr : &word->second, choice);
  }
  const std::vector<double> estimates = estimate_chains(network, maker, regions, choice);
  std::vector<JoinLine> smooth;
  std::vector<int> join_of;
  for (size_t s = 0; s < choice.join_lines.size(); ++s) {
    ModelJoin& join = choice.joins[choice.join_of[s]];
    join.first_deg = estimates[s];
    const auto word = words.find(join.arc);
    if (word != words.end() ? word->second == Kind::Crease
                            : !(join.first_deg < options.smooth_below_deg))
      continue;
    smooth.push_back(choice.join_lines[s]);
    join_of.push_back(choice.join_of[s]);
  }
  choice.join_lines = std::move(smooth);
  choice.join_of = std::move(join_of);
  return choice;
}

}  // namespace batten
