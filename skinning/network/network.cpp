#include "batten/skinning/network/network.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "batten/core/errors.h"
#include "batten/core/groups.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/core/words.h"
#include "batten/skinning/network/network_arcs.h"
#include "batten/skinning/network/network_nodes.h"

namespace batten {
namespace {

using namespace netting;

// Node numbers in canonical order; nodes without an arc get none.
std::vector<int> canonical_nodes(const Strands& strands, NodesAndCuts& net) {
  std::vector<char> used(net.nodes.size(), 0);
  for (const Cut& c : net.cuts)
    for (const int n : c.nodes) used[n] = 1;
  std::vector<std::pair<std::array<long long, 3>, int>> order;
  for (int n = 0; n < count_of(net.nodes); ++n)
    if (used[n]) order.emplace_back(sort_key(net.nodes[n], strands.origin, strands.size), n);
  std::sort(order.begin(), order.end());
  std::vector<int> number(net.nodes.size(), -1);
  for (size_t i = 0; i < order.size(); ++i) number[order[i].second] = static_cast<int>(i);
  for (Cut& c : net.cuts)
    for (int& n : c.nodes) n = number[n];
  std::vector<Vec3> nodes;
  for (const auto& [key, n] : order) nodes.push_back(net.nodes[n]);
  net.nodes = std::move(nodes);
  return number;
}

struct Draft {
  const Cut* cut;
  std::shared_ptr<const Piece> input;
  double length;
  bool flipped;  // runs against its strand
  std::array<int, 2> nodes;
  std::array<long long, 3> middle;
};

Draft make_draft(const Strands& strands, const Cut& cut, double size) {
  const Strand& strand = strands.strands[cut.strand];
  const double period = strand.curve->end() - strand.curve->start();
  const auto parameter = [&](double s) {
    return s <= strand.length ? strand.arc->parameter(s)
                              : strand.arc->parameter(s - strand.length) + period;
  };
  const auto point = [&](double f) {
    double s = cut.s0 + f * (cut.s1 - cut.s0);
    if (s > strand.length) s -= strand.length;
    return strand.point(strand.arc->parameter(s));
  };
  // From the node that comes first; a closed one by places as far from either end.
  bool flipped = cut.nodes[0] > cut.nodes[1];
  if (cut.nodes[0] == cut.nodes[1])
    for (const double f : {0.25, 0.125, 0.375, 1.0 / 3, 0.05, 0.2, 0.45})
      if (const int c = compare(point(f), point(1 - f), 1e-9 * size); c != 0) {
        flipped = c > 0;
        break;
      }
  Draft draft{&cut,
              strand.curve->part(parameter(cut.s0), parameter(cut.s1), flipped),
              cut.s1 - cut.s0,
              flipped,
              cut.nodes,
              sort_key(point(0.5), strands.origin, size)};
  if (flipped) std::swap(draft.nodes[0], draft.nodes[1]);
  return draft;
}

// Away from the node.
Vec3 away(const Draft& draft, bool end) {
  const Piece& c = *draft.input;
  return end ? Vec3(-tangent(c, c.end(), -1)) : tangent(c, c.start(), 1);
}

// Which ends go on in which: pieces of one strand first, then the straightest.
void find_partners(const std::vector<Draft>& drafts, const std::vector<NetworkNode>& nodes,
                   const Strands& strands, double straight_angle, std::vector<NetworkArc>& arcs) {
  struct Pair {
    int strange;  // 0: of one strand, where that was cut
    long long turn;
    ArcEnd p, q;
  };
  const auto place = [&](const ArcEnd& e) {  // along its strand
    const Cut& c = *drafts[e.arc].cut;
    const bool last = e.end != drafts[e.arc].flipped;
    const double length = strands.strands[c.strand].length;
    const double s = last ? c.s1 : c.s0;
    return std::pair(last, s > length ? s - length : s);
  };
  for (const NetworkNode& node : nodes) {
    std::vector<Vec3> direction;
    for (const ArcEnd& e : node.ends) direction.push_back(away(drafts[e.arc], e.end));
    std::vector<Pair> pairs;
    for (size_t i = 0; i < node.ends.size(); ++i)
      for (size_t j = i + 1; j < node.ends.size(); ++j) {
        const ArcEnd &p = node.ends[i], &q = node.ends[j];
        const double turn = degrees_between(direction[i], -direction[j]);
        const auto [last_p, s_p] = place(p);
        const auto [last_q, s_q] = place(q);
        const int k = drafts[p.arc].cut->strand;
        const Strand& strand = strands.strands[k];
        const bool one = k == drafts[q.arc].cut->strand && last_p != last_q &&
                         strand.between(s_p, s_q) <= 1e-9 * strand.length &&
                         (strand.closed || (s_p > 0 && s_p < strand.length));
        if (one || turn <= straight_angle)
          pairs.push_back({one ? 0 : 1, std::llround(turn * (1 << 20)), p, q});
      }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return std::tie(a.strange, a.turn) < std::tie(b.strange, b.turn);
    });
    for (const Pair& pair : pairs) {
      auto &p = arcs[pair.p.arc].on[pair.p.end], &q = arcs[pair.q.arc].on[pair.q.end];
      if (p.arc >= 0 || q.arc >= 0) continue;
      p = pair.q;
      q = pair.p;
    }
  }
}

// Unit tangents along the arcs at both ends; partners have one.
std::vector<std::array<Vec3, 2>> end_tangents(const std::vector<Draft>& drafts,
                                              const std::vector<NetworkArc>& arcs) {
  std::vector<std::array<Vec3, 2>> along(arcs.size());
  for (size_t i = 0; i < arcs.size(); ++i)
    for (const bool end : {false, true}) along[i][end] = (end ? -1 : 1) * away(drafts[i], end);
  for (int i = 0; i < count_of(arcs); ++i)
    for (const bool end : {false, true}) {
      const ArcEnd q = arcs[i].on[end];
      if (q.arc < 0 || std::tuple(q.arc, q.end) < std::tuple(i, end)) continue;
      const Vec3 p_away = away(drafts[i], end), q_away = away(drafts[q.arc], q.end);
      const Vec3 common = (p_away - q_away).normalized();  // away from the node, of p
      along[i][end] = (end ? -1 : 1) * common;
      along[q.arc][q.end] = (q.end ? 1 : -1) * common;
    }
  return along;
}

void tell_of_parts(const std::vector<NetworkArc>& arcs, const std::vector<NetworkNode>& nodes,
                   const std::vector<CharacterLine>& lines, std::vector<NetworkFinding>& findings) {
  Groups groups(nodes.size());
  for (const auto& arc : arcs) groups.join(arc.nodes[0], arc.nodes[1]);
  std::map<int, std::vector<int>> parts;
  for (size_t i = 0; i < arcs.size(); ++i)
    parts[groups.of(arcs[i].nodes[0])].push_back(static_cast<int>(i));
  int largest = -1;
  for (const auto& [part, members] : parts)
    if (largest < 0 || members.size() > parts[largest].size()) largest = part;
  for (const auto& [part, members] : parts) {
    if (part == largest) continue;
    std::vector<std::string> names;
    for (const int i : members)
      if (const auto& name = lines[arcs[i].line].name;
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
    const Vec3& p = nodes[part].position;
    std::string text = names.size() == 1 ? "line '" : "lines '";
    constexpr size_t most = 4;
    for (size_t i = 0; i < std::min(most, names.size()); ++i)
      text += (i > 0 ? "', '" : "") + names[i];
    text += names.size() > most ? "', … (" + std::to_string(names.size()) + " lines)" : "'";
    findings.push_back({NetworkFinding::Kind::Apart, names, p, 0, false,
                        text + " near " + at(p) + (names.size() == 1 ? " has" : " have") +
                            " no connection to the rest of the network"});
  }
}

void require_options(const NetworkOptions& options) {
  const auto check = [](const char* name, double value, bool fits, const char* expected) {
    if (!fits)
      throw InputError(std::string("network: found ") + name + " = " + number(value) +
                       ", expected " + expected);
  };
  for (const auto& [name, value] : {std::pair("tolerance", options.tolerance),
                                    std::pair("fit_tolerance", options.fit_tolerance)})
    check(name, value, std::isfinite(value) && value >= 0, "0 (a default) or more");
  for (const auto& [name, value] : {std::pair("corner_angle", options.corner_angle),
                                    std::pair("straight_angle", options.straight_angle)})
    check(name, value, value >= 0 && value <= 180, "degrees from 0 to 180");
}

// The share of gaps that are within a tolerance; 1 where there is no end.
double share_within(const std::vector<double>& gaps, double tolerance) {
  const auto within =
      std::count_if(gaps.begin(), gaps.end(), [&](double gap) { return gap <= tolerance; });
  return gaps.empty() ? 1 : static_cast<double>(within) / static_cast<double>(gaps.size());
}

// The tolerance that the hand behind these gaps needs; `usual` where they tell none.
double found_tolerance(std::vector<double> gaps, double usual, double largest) {
  if (share_within(gaps, largest) < 0.5) return usual;
  std::sort(gaps.begin(), gaps.end());
  const size_t meeting =
      static_cast<size_t>(std::upper_bound(gaps.begin(), gaps.end(), largest) - gaps.begin());
  const double most = gaps[(4 * meeting + 4) / 5 - 1], all = gaps[meeting - 1];
  constexpr double alike = 2, margin = 1.4;  // a node takes the ends of a circle, not of a pair
  return std::clamp(margin * (all <= alike * most ? all : most), usual, largest);
}

struct Meeting {
  double tolerance, usual_share = 1;
};

// The tolerance that was asked for or, without one, the usual one; where that joins less than half
// of the places at which lines end or cross, the one that the gaps of their ends ask for.
Meeting meeting_of(const std::vector<Strand>& strands, const NetworkOptions& options, double size) {
  if (options.tolerance > 0.1 * size)
    throw InputError("network: found tolerance = " + number(options.tolerance) +
                     ", expected at most a tenth of the network's size, " + number(size));
  if (options.tolerance > 0) return {options.tolerance};
  const double usual = 1e-3 * size, largest = 2e-2 * size;
  std::vector<double> gaps = end_gaps(strands, largest);
  double share = share_within(gaps, usual);
  if (share >= 0.5) return {usual, share};
  // Lines that cross and run out a little have met: no hand's gap is what follows. Lines that cross
  // far more often than they end were laid to cross, and their gaps there tell of no hand either.
  const std::vector<Contact> met = find_contacts(strands, usual, size).joined;
  gaps = end_gaps(strands, largest, met);
  const auto crossing =
      std::count_if(met.begin(), met.end(), [](const Contact& c) { return c.ea < 0 && c.eb < 0; });
  std::vector<double> places = gaps;
  places.resize(gaps.size() + static_cast<size_t>(crossing), 0.0);
  share = share_within(places, usual);
  return {share < 0.5 ? found_tolerance(gaps, usual, largest) : usual, share};
}

double fit_of(const NetworkOptions& options, double size) {
  constexpr double default_fit = 1e-4;  // of the size
  return options.fit_tolerance > 0 ? options.fit_tolerance : default_fit * size;
}

// Drafts of all arcs in canonical order.
std::vector<Draft> draft_arcs(const Strands& strands, const std::vector<Cut>& cuts,
                              const std::vector<CharacterLine>& lines) {
  std::vector<Draft> drafts;
  for (const Cut& cut : cuts) drafts.push_back(make_draft(strands, cut, strands.size));
  const auto name_of = [&](const Draft& d) -> const std::string& {
    return lines[strands.strands[d.cut->strand].line].name;
  };
  std::stable_sort(drafts.begin(), drafts.end(), [&](const Draft& a, const Draft& b) {
    return std::tie(a.nodes, a.middle, name_of(a), a.cut->s0) <
           std::tie(b.nodes, b.middle, name_of(b), b.cut->s0);
  });
  return drafts;
}

// Arcs without their curves, names and partners; their ends are added to the nodes.
std::vector<NetworkArc> make_arcs(const std::vector<Draft>& drafts, const Strands& strands,
                                  std::vector<NetworkNode>& nodes) {
  std::vector<NetworkArc> arcs(drafts.size());
  for (int i = 0; i < count_of(drafts); ++i) {
    NetworkArc& arc = arcs[i];
    arc.line = strands.strands[drafts[i].cut->strand].line;
    arc.reversed = drafts[i].input->backwards();
    arc.input = drafts[i].input;
    arc.nodes = drafts[i].nodes;
    nodes[arc.nodes[0]].ends.push_back({i, false});
    nodes[arc.nodes[1]].ends.push_back({i, true});
  }
  return arcs;
}

// Names arcs along their lines; returns the arcs of each line, at the end those of other lines that
// it shares.
std::vector<std::vector<int>> name_arcs(const std::vector<Draft>& drafts,
                                        const std::vector<CharacterLine>& lines,
                                        std::vector<NetworkArc>& arcs) {
  std::vector<std::vector<int>> arcs_of_line(lines.size());
  for (int i = 0; i < count_of(arcs); ++i) arcs_of_line[arcs[i].line].push_back(i);
  for (size_t k = 0; k < lines.size(); ++k) {
    auto& of = arcs_of_line[k];
    std::sort(of.begin(), of.end(),
              [&](int i, int j) { return drafts[i].input->first() < drafts[j].input->first(); });
    for (size_t i = 0; i < of.size(); ++i)
      arcs[of[i]].name = lines[k].name + (of.size() > 1 ? "." + std::to_string(i + 1) : "");
  }
  for (int i = 0; i < count_of(drafts); ++i)
    for (const int line : drafts[i].cut->shared)
      if (auto& of = arcs_of_line[line]; std::find(of.begin(), of.end(), i) == of.end())
        of.push_back(i);
  return arcs_of_line;
}

// Makes the curves of arcs, in parallel.
void shape_arcs(const std::vector<Draft>& drafts, const std::vector<NetworkNode>& nodes,
                double size, double tolerance, double fit, std::vector<NetworkArc>& arcs) {
  const auto along = end_tangents(drafts, arcs);
  parallel_parts(count_of(arcs), [&](int i) {
    NetworkArc& arc = arcs[i];
    ArcShape shape = make_arc_curve({drafts[i].input, nodes[arc.nodes[0]].position,
                                     nodes[arc.nodes[1]].position, along[i][0], along[i][1]},
                                    size, tolerance, fit);
    arc.curve = std::move(shape.curve);
    arc.length = shape.length;
    arc.deviation = shape.deviation;
  });
}

}  // namespace

CharacterLineNetwork::CharacterLineNetwork(const std::vector<CharacterLine>& lines,
                                           const NetworkOptions& options, const Progress& progress)
    : lines_(lines) {
  require_options(options);
  progress.at("network", 0);
  const Strands strands = make_strands(lines, options.corner_angle);
  size_ = strands.size;
  progress.at("network", 0.1);
  const Meeting meeting = meeting_of(strands.strands, options, size_);
  tolerance_ = meeting.tolerance;
  usual_share_ = meeting.usual_share;
  const Contacts contacts = find_contacts(strands.strands, tolerance_, size_);
  progress.at("network", 0.5);
  NodesAndCuts net = make_nodes(strands, contacts, tolerance_, lines_, findings_);
  if (net.cuts.empty())
    throw InputError("the network has no line longer than its tolerance, " + number(tolerance_));
  canonical_nodes(strands, net);
  for (const Vec3& p : net.nodes) nodes_.push_back({p, {}});

  const std::vector<Draft> drafts = draft_arcs(strands, net.cuts, lines_);
  arcs_ = make_arcs(drafts, strands, nodes_);
  arcs_of_line_ = name_arcs(drafts, lines_, arcs_);
  find_partners(drafts, nodes_, strands, options.straight_angle, arcs_);
  progress.at("network", 0.6);
  shape_arcs(drafts, nodes_, size_, tolerance_, fit_of(options, size_), arcs_);
  tell_of_parts(arcs_, nodes_, lines_, findings_);
  std::stable_sort(
      findings_.begin(), findings_.end(),
      [](const NetworkFinding& a, const NetworkFinding& b) { return a.kind < b.kind; });
  progress.at("network", 1);
}

std::vector<int> CharacterLineNetwork::arcs_of(const std::string& name) const {
  for (size_t k = 0; k < lines_.size(); ++k)
    if (lines_[k].name == name) return arcs_of_line_[k];
  std::vector<std::string> names;
  for (size_t i = 0; i < arcs_.size(); ++i) {
    if (arcs_[i].name == name) return {static_cast<int>(i)};
    names.push_back(arcs_[i].name);
  }
  for (const auto& line : lines_) names.push_back(line.name);
  const std::string meant = nearest_word(name, names);
  throw InputError("the network has no line '" + name + "'" +
                   (meant.empty() ? "" : ": is '" + meant + "' meant?"));
}

Vec3 CharacterLineNetwork::direction(const ArcEnd& end) const {
  const HermiteCurve& curve = arcs_.at(end.arc).curve;
  return end.end ? Vec3(-curve.slope_in(curve.node_count() - 1).normalized())
                 : Vec3(curve.slope_out(0).normalized());
}

}  // namespace batten
