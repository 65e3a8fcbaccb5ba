// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/facets/model_elements.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

/// One region's copy of a line.
struct Side {
  size_t region, line;  ///< index in the region, edge-aligned lines first
  bool aligned_line;
  const HermiteCurve* curve;
  double start, end;     ///< parameter range
  bool against = false;  ///< runs against the line's first side

  double fraction(double t) const {
    const double f = (t - start) / (end - start);
    return against ? 1 - f : f;
  }
  double parameter(double f) const {
    if (against) f = 1 - f;
    return f <= 0 ? start : f >= 1 ? end : start + f * (end - start);
  }
  Vec3 at(double f) const { return curve->evaluate(parameter(f)); }
};

struct SharedLine {
  std::string name;
  std::vector<Side> sides;
  std::vector<double> fractions = {};  ///< where edges end; only for lines with several sides

  bool shared() const { return sides.size() > 1; }
  size_t nearest(double f) const {
    const auto above = std::lower_bound(fractions.begin(), fractions.end(), f);
    if (above == fractions.end()) return fractions.size() - 1;
    const auto k = static_cast<size_t>(above - fractions.begin());
    return k > 0 && f - fractions[k - 1] < fractions[k] - f ? k - 1 : k;
  }
  void add(double f) {
    if (!fractions.empty() && std::abs(fractions[nearest(f)] - f) <= kParameterTolerance) return;
    fractions.insert(std::upper_bound(fractions.begin(), fractions.end(), f), f);
  }
  /// True if an edge of a side spans exactly two adjacent fractions.
  bool has_edge(const Side& side, const std::array<double, 2>& t) const {
    const size_t a = nearest(side.fraction(t[0])), b = nearest(side.fraction(t[1]));
    return a + 1 == b || b + 1 == a;
  }
};

class ModelMesher {
 public:
  ModelMesher(const std::vector<const SkinnedRegion*>& regions, double edge_length)
      : regions_(regions), edge_length_(edge_length) {
    if (regions.empty())
      throw InputError("tessellation of a model: found no face, expected one or more");
    list_lines();
    for (SharedLine& line : lines_)
      if (line.shared()) compare_sides(line);
  }

  ModelElements make() {
    result_.regions.resize(regions_.size());
    result_.requests.resize(regions_.size());
    conform_regions();
    for (size_t r = 0; r < regions_.size(); ++r) place_nodes(r);
    join_nodes();
    number_nodes();
    list_edges();
    return std::move(result_);
  }

 private:
  void list_lines() {
    std::map<std::string, size_t> index;
    line_of_.resize(regions_.size());
    const auto add = [&](const std::string& name, const Side& side) {
      const auto [found, added] = index.try_emplace(name, lines_.size());
      if (added) lines_.push_back({name, {}});
      lines_[found->second].sides.push_back(side);
      line_of_[side.region].push_back(found->second);
    };
    for (size_t r = 0; r < regions_.size(); ++r) {
      size_t l = 0;
      for (const EdgeAlignedLine& aligned_line : regions_[r]->edge_aligned)
        add(aligned_line.line.name,
            {r, l++, true, &aligned_line.fitted, aligned_line.parameters.front(),
             aligned_line.parameters.back()});
      for (const EmbeddedLine& line : regions_[r]->embedded)
        add(line.line.name, {r, l++, false, &line.fitted, line.pcurve.start(), line.pcurve.end()});
    }
  }

  // Finds the sides that run against the first one. Throws if they are not the same curve.
  void compare_sides(SharedLine& line) const {
    constexpr double most = 1e-2;  // of the smaller region's size
    const Side& first = line.sides[0];
    for (Side& side : line.sides) {
      double apart[2] = {0, 0};
      for (const bool against : {false, true}) {
        side.against = against;
        for (const double f : {0.0, 0.25, 0.5, 0.75, 1.0})
          apart[against] = std::max(
              apart[against], (side.at(f) - first.curve->evaluate(first.parameter(f))).norm());
        if (&side == &first) break;
      }
      side.against = &side != &first && apart[1] < apart[0];
      const double gap = apart[side.against];
      const SkinnedRegion &a = *regions_[first.region], &b = *regions_[side.region];
      if (!(gap <= most * std::min(a.size, b.size)))
        throw InputError("tessellation of a model: curves '" + line.name + "' of faces '" + a.name +
                         "' and '" + b.name + "' are " + format_number(gap) +
                         " apart, expected one curve: names of curves are unique within a model");
    }
  }

  // Meshes regions repeatedly until edges on shared lines agree on all sides.
  void conform_regions() {
    for (SharedLine& line : lines_)
      if (line.shared())
        for (const Side& side : line.sides)
          if (side.aligned_line)
            for (const double t : regions_[side.region]->edge_aligned[side.line].parameters)
              line.add(side.fraction(t));
    constexpr int halving_rounds = 3, rounds = 10;
    std::vector<char> made(regions_.size(), 0);
    for (int round = 0;; ++round) {
      bool changed = false;
      for (size_t r = 0; r < regions_.size(); ++r) {
        if (made[r] && conforms(r)) continue;
        if (round >= rounds)
          throw InputError("tessellation of a model: face '" + regions_[r]->name +
                           "' and its neighbours have no matching element edges on their curves");
        result_.requests[r] = request_for(r, round < halving_rounds);
        result_.regions[r] = quadratic_elements(*regions_[r], edge_length_, result_.requests[r]);
        made[r] = 1;
        changed = true;
        add_fractions_of(r);
      }
      if (!changed) return;
    }
  }

  template <class Action>
  void for_each_shared_side(size_t r, const Action& action) {
    for (const size_t l : std::set<size_t>(line_of_[r].begin(), line_of_[r].end()))
      if (lines_[l].shared())
        for (const Side& side : lines_[l].sides)
          if (side.region == r) action(lines_[l], side);
  }

  SubdivisionRequest request_for(size_t r, bool may_split) {
    SubdivisionRequest subdivision;
    subdivision.may_split = may_split;
    for_each_shared_side(r, [&](const SharedLine& line, const Side& side) {
      subdivision.at.resize(line_of_[r].size());
      std::vector<double>& at = subdivision.at[side.line];
      for (const double f : line.fractions) at.push_back(side.parameter(f));
      if (side.against) std::reverse(at.begin(), at.end());
    });
    return subdivision;
  }

  void add_fractions_of(size_t r) {
    for_each_shared_side(r, [&](SharedLine& line, const Side& side) {
      for (const auto& t : result_.regions[r].parameters[side.line])
        for (const double end : t) line.add(side.fraction(end));
    });
  }

  bool conforms(size_t r) {
    bool all = true;
    for_each_shared_side(r, [&](const SharedLine& line, const Side& side) {
      for (const auto& t : result_.regions[r].parameters[side.line])
        all = all && line.has_edge(side, t);
    });
    return all;
  }

  // Computes the positions of a region's nodes on its surface.
  void place_nodes(size_t r) {
    QuadraticElements& facets = result_.regions[r];
    if (facets.is_element_mesh)  // each node gets its location in the last element around it
      for (size_t t = 0; t < facets.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i) {
          const auto& n = facets.triangles[t];
          // Opposite to corner i.
          const int here = static_cast<int>(t), middle = n[3 + (i + 1) % 3];
          facets.nodes[n[i]] = {here, Vec3::Unit(i)};
          facets.nodes[middle] = {here, (Vec3::Ones() - Vec3::Unit(i)) / 2};
        }
    first_.push_back(on_surface_.size());
    for (const Location& where : facets.nodes)
      on_surface_.push_back(regions_[r]->surface.position(where));
  }

  size_t id(size_t r, int node) const { return first_[r] + static_cast<size_t>(node); }

  void unite(size_t a, size_t b) { merged_->unite(static_cast<int>(a), static_cast<int>(b)); }
  void join_nodes() {
    merged_.emplace(on_surface_.size());
    on_aligned_line_.assign(on_surface_.size(), 0);
    on_curve_.resize(on_surface_.size());
    struct End {
      Vec3 position;
      size_t id;
    };
    std::vector<End> ends;
    for (const SharedLine& line : lines_) {
      std::map<std::pair<size_t, bool>, size_t>
          known;  // keyed by the index of a fraction; true: the midpoint after it
      const auto join = [&](size_t k, bool middle, size_t id) {
        if (!line.shared()) return;
        unite(known.try_emplace({k, middle}, id).first->second, id);
        const auto& f = line.fractions;
        if (!on_curve_[id]) on_curve_[id] = line.sides[0].at(middle ? (f[k] + f[k + 1]) / 2 : f[k]);
      };
      for (const Side& side : line.sides) {
        const auto& edges = result_.regions[side.region].lines[side.line];
        const auto& parameters = result_.regions[side.region].parameters[side.line];
        for (size_t e = 0; e < edges.size(); ++e) {
          size_t k[2] = {0, 0};
          for (const size_t i : {0, 1}) {
            const size_t node = id(side.region, edges[e][i]);
            const double t = parameters[e][i];
            k[i] = line.shared() ? line.nearest(side.fraction(t)) : 0;
            on_aligned_line_[node] = on_aligned_line_[node] || side.aligned_line;
            join(k[i], false, node);
            if (t != side.start && t != side.end) continue;
            if (!side.aligned_line && !on_curve_[node]) on_curve_[node] = side.curve->evaluate(t);
            ends.push_back({side.aligned_line ? on_surface_[node] : *on_curve_[node], node});
          }
          const size_t middle = id(side.region, edges[e][2]);
          on_aligned_line_[middle] = side.aligned_line;
          join(std::min(k[0], k[1]), true, middle);
        }
      }
    }
    const double same = 1e-6 * bounding_box(on_surface_).diagonal().norm();
    std::stable_sort(ends.begin(), ends.end(),
                     [](const End& a, const End& b) { return a.position.x() < b.position.x(); });
    for (size_t i = 0; i < ends.size(); ++i)
      for (size_t j = i + 1; j < ends.size() && ends[j].position.x() - ends[i].position.x() <= same;
           ++j)
        if ((ends[i].position - ends[j].position).norm() <= same) unite(ends[i].id, ends[j].id);
  }

  void number_nodes() {
    std::vector<int> number(on_surface_.size(), -1);
    std::vector<std::vector<size_t>> members;
    for (size_t r = 0; r < regions_.size(); ++r) {
      result_.node.emplace_back();
      for (size_t i = 0; i < result_.regions[r].nodes.size(); ++i) {
        const size_t node = first_[r] + i;
        int& n = number[merged_->find(static_cast<int>(node))];
        if (n < 0) {
          n = isize(members);
          members.emplace_back();
        }
        members[n].push_back(node);
        result_.node[r].push_back(n);
      }
    }
    for (const auto& all : members) {
      const auto aligned_line =
          std::find_if(all.begin(), all.end(), [&](size_t i) { return on_aligned_line_[i]; });
      const auto curve =
          std::find_if(all.begin(), all.end(), [&](size_t i) { return on_curve_[i].has_value(); });
      result_.positions.push_back(aligned_line != all.end() ? on_surface_[*aligned_line]
                                  : all.size() > 1 && curve != all.end() ? *on_curve_[*curve]
                                                                         : on_surface_[all[0]]);
    }
    for (size_t r = 0; r < regions_.size(); ++r)
      for (const auto& triangle : result_.regions[r].triangles) {
        std::set<int> nodes;
        for (const int n : triangle) nodes.insert(result_.node[r][n]);
        if (nodes.size() < triangle.size())
          throw InputError("tessellation of face '" + regions_[r]->name +
                           "': found curve ends closer than 1e-6 of the model's size, expected "
                           "space for an element between them");
      }
  }

  void list_edges() {
    for (const SharedLine& line : lines_) {
      ModelElements::Line& list = result_.lines.emplace_back();
      list.name = line.name;
      std::set<int> middles;
      for (const Side& side : line.sides) {
        const std::vector<int>& node = result_.node[side.region];
        for (const auto& [a, b, middle] : result_.regions[side.region].lines[side.line])
          if (middles.insert(node[middle]).second)
            list.edges.push_back({node[a], node[b], node[middle]});
      }
    }
  }

  const std::vector<const SkinnedRegion*>& regions_;
  double edge_length_;
  std::vector<SharedLine> lines_;
  // For each region and each of its lines, the index in lines_.
  std::vector<std::vector<size_t>> line_of_;
  ModelElements result_;
  // Node data of all regions, region after region.
  std::vector<size_t> first_;  // first node of each region
  std::vector<Vec3> on_surface_;
  std::vector<std::optional<Vec3>> on_curve_;
  std::vector<char> on_aligned_line_;
  std::optional<DisjointSets> merged_;  // nodes that are merged
};

}  // namespace

ModelElements model_elements(const std::vector<const SkinnedRegion*>& regions, double edge_length) {
  return ModelMesher(regions, edge_length).make();
}

}  // namespace batten
