#include "batten/fairing/knot_placement.h"

#include <algorithm>

#include "batten/core/isize.h"

namespace batten {
namespace {

// Mean gap of the places around place i.
double gap_around(const std::vector<double>& places, size_t i) {
  constexpr size_t reach = 4;
  const size_t from = i < reach ? 0 : i - reach, to = std::min(i + reach, places.size() - 1);
  return (places[to] - places[from]) / static_cast<double>(std::max<size_t>(to - from, 1));
}

// The forced nodes, and those of the wanted ones that are not nearer to others than a share of the
// gaps around them; both ascending. Where noise throws feet together nodes would be so near that
// curvature changes between them lose their digits.
std::vector<double> merged_nodes(const std::vector<double>& nodes,
                                 const std::vector<double>& wanted, double fraction, double least) {
  std::vector<double> merged;
  size_t next = 0;
  for (size_t k = 0; k + 1 < nodes.size(); ++k) {
    merged.push_back(nodes[k]);
    for (; next < wanted.size(); ++next) {
      const double gap = std::max(least, fraction * gap_around(wanted, next));
      if (wanted[next] >= nodes[k + 1] - gap) break;
      if (wanted[next] >= merged.back() + gap) merged.push_back(wanted[next]);
    }
  }
  merged.push_back(nodes.back());
  return merged;
}

std::vector<double> with_middles(const std::vector<double>& nodes) {
  std::vector<double> all;
  for (size_t k = 0; k + 1 < nodes.size(); ++k) {
    all.push_back(nodes[k]);
    all.push_back(0.5 * (nodes[k] + nodes[k + 1]));
  }
  all.push_back(nodes.back());
  return all;
}

// All nodes; the second half of a mirrored curve has those of the first.
std::vector<double> all_nodes(const PointSequence& sequence, const std::vector<double>& u,
                              double length, std::vector<double> forced, bool mirrored,
                              int max_knots) {
  std::vector<double> places = u, wanted;
  std::sort(places.begin(), places.end());
  const size_t stride =
      (places.size() + static_cast<size_t>(max_knots) - 1) / static_cast<size_t>(max_knots);
  for (size_t i = 0; i < places.size(); i += stride) wanted.push_back(places[i]);
  const double end = mirrored ? 0.5 * length : length;
  if (mirrored)
    for (auto* all : {&forced, &wanted})
      for (double& at : *all) at = std::min(at, length - at);
  forced.push_back(end);
  constexpr int few = 11;  // points that are all passed through, or nearly
  // The forced ones first; of the others those that are not too near.
  // (What acts between nodes acts there too; a corner and the mirror image of its partner are one.)
  const double spacing = length / std::min(sequence.count(), max_knots);
  // Corners and their mirror images need room.
  const double same = (mirrored ? 1 : 2e-4) * spacing;
  std::sort(forced.begin(), forced.end());
  std::vector<double> nodes;
  for (const double at : forced)
    if (nodes.empty() || at - nodes.back() > same) nodes.push_back(at);
  nodes.back() = end;
  std::sort(wanted.begin(), wanted.end());
  std::vector<double> merged =
      merged_nodes(nodes, wanted, sequence.count() < few && !mirrored ? 0.02 : 0.3, 2e-4 * spacing);
  if (max_knots > sequence.count()) merged = with_middles(merged);
  // A closed curve has three segments at least: the longest ones are halved.
  while (sequence.closed && merged.size() < 4) {
    size_t longest = 0;
    for (size_t k = 0; k + 1 < merged.size(); ++k)
      if (merged[k + 1] - merged[k] > merged[longest + 1] - merged[longest]) longest = k;
    merged.insert(merged.begin() + static_cast<long>(longest) + 1,
                  0.5 * (merged[longest] + merged[longest + 1]));
  }
  std::vector<double> parameters = merged;
  if (mirrored)
    for (size_t k = merged.size() - 1; k-- > 0;) parameters.push_back(length - merged[k]);
  return parameters;
}

}  // namespace

KnotPlacement place_knots(const PointSequence& sequence, const std::vector<double>& u,
                          double length, std::vector<double> forced, bool mirrored, int max_knots) {
  std::vector<double> parameters =
      all_nodes(sequence, u, length, std::move(forced), mirrored, max_knots);
  const auto nearest = [&](double at) {
    const auto above = std::lower_bound(parameters.begin(), parameters.end(), at);
    if (above == parameters.end()) return isize(parameters) - 1;
    const auto i = above - parameters.begin();
    return static_cast<int>(i > 0 && at - parameters[i - 1] < *above - at ? i - 1 : i);
  };
  const int last = isize(parameters) - 1;
  std::vector<int> corners;
  for (const int c : sequence.corners) {
    const int node = nearest(u[c]);
    if (!sequence.closed && (node == 0 || node == last)) continue;
    corners.push_back(node % (sequence.closed ? last : last + 1));
    if (mirrored) corners.push_back((last - node) % (sequence.closed ? last : last + 1));
  }
  std::vector<int> corner_node;
  for (const int c : sequence.corners)
    corner_node.push_back(nearest(u[c]) % (sequence.closed ? last : last + 1));
  return {CurveMesh(std::move(parameters), sequence.closed, std::move(corners)),
          std::move(corner_node)};
}

}  // namespace batten
