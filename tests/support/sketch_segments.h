// SPDX-License-Identifier: MPL-2.0
// Maps the edges of a network to the segments of a sketch file.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/search/region_graph.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten_test {

using namespace batten;

// The segments of a sketch file along a loop: the midpoint of one is on the other.
struct SketchSegments {
  std::map<int, std::vector<Vec3>> points;

  explicit SketchSegments(const std::filesystem::path& file) {
    const auto json = nlohmann::json::parse(std::ifstream(file));
    for (const auto& segment : json.at("segments"))
      for (const auto& piece : segment.at("ctrl_pts")) {
        std::vector<Vec3> p;
        for (const auto& x : piece) p.push_back(Vec3(x[0], x[1], x[2]));
        for (int i = 0; i <= 40; ++i) {
          const double t = i / 40.0, s = 1 - t;
          points[segment.at("id")].push_back(p.size() == 4
                                                 ? Vec3(s * s * s * p[0] + 3 * s * s * t * p[1] +
                                                        3 * s * t * t * p[2] + t * t * t * p[3])
                                                 : Vec3(s * p.front() + t * p.back()));
        }
      }
  }

  static Vec3 middle(const std::vector<Vec3>& line) {
    double half = 0;
    for (size_t i = 1; i < line.size(); ++i) half += (line[i] - line[i - 1]).norm() / 2;
    for (size_t i = 1; i < line.size(); ++i) {
      const double d = (line[i] - line[i - 1]).norm();
      if (d >= half && d > 0) return line[i - 1] + half / d * (line[i] - line[i - 1]);
      half -= d;
    }
    return line.back();
  }
  static bool on(const Vec3& p, const std::vector<Vec3>& line, double tolerance) {
    for (size_t i = 1; i < line.size(); ++i) {
      const Vec3 d = line[i] - line[i - 1];
      const double t =
          d.norm() > 0 ? std::clamp((p - line[i - 1]).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
      if ((line[i - 1] + t * d - p).norm() < tolerance) return true;
    }
    return false;
  }
  std::vector<std::set<int>> of_edges(const RegionGraph& graph) const {
    std::vector<std::set<int>> all;
    for (const GraphEdge& edge : graph.edges) {
      const std::vector<Vec3> line(edge.points.begin(), edge.points.end());
      std::set<int> ids;
      for (const auto& [id, segment] : points)
        if (on(middle(line), segment, 2e-3 * graph.size) ||
            on(middle(segment), line, 2e-3 * graph.size))
          ids.insert(id);
      all.push_back(ids);
    }
    return all;
  }
};

// The segments of each edge of a loop.
inline std::vector<std::set<int>> segments_along(const EdgeLoop& loop,
                                                 const std::vector<std::set<int>>& of_edge) {
  std::vector<std::set<int>> all;
  for (const OrientedEdge& use : loop) all.push_back(of_edge[static_cast<size_t>(use.edge)]);
  return all;
}

// The expected surfaces of a sketch, by the segments around each (tests/reference/networks).
class ExpectedSurfaces {
 public:
  struct Score {
    std::set<int> correct;        // expected ones that were found
    int wrong = 0, expected = 0;  // wrong: found but not expected, or duplicate; expected: total
    double precision() const {
      return static_cast<double>(correct.size()) / (static_cast<double>(correct.size()) + wrong);
    }
    double recall() const { return static_cast<double>(correct.size()) / expected; }
  };

  explicit ExpectedSurfaces(const nlohmann::json& file) {
    for (const auto& region : file.at("regions")) {
      alternatives_.push_back({region.at("segments").get<std::set<int>>()});
      if (region.contains("also"))
        for (const auto& other : region.at("also"))
          alternatives_.back().push_back(other.get<std::set<int>>());
    }
    for (const auto& region : file.at("doubtful"))
      doubtful_.push_back(region.at("segments").get<std::set<int>>());
    if (!file.contains("creases")) return;
    creases_ = file.at("creases").get<std::set<int>>();
    doubtful_lines_ = file.at("doubtful_creases").get<std::set<int>>();
  }
  bool knows_creases() const { return !creases_.empty(); }
  int count() const { return static_cast<int>(alternatives_.size()); }
  // The surface of a loop, by the segments of each of its edges; -1: none.
  int of(const std::vector<std::set<int>>& loop) const {
    for (size_t r = 0; r < alternatives_.size(); ++r)
      for (const std::set<int>& segments : alternatives_[r])
        if (runs_along(loop, segments)) return static_cast<int>(r);
    return -1;
  }
  Score score(const std::vector<NetworkRegion>& regions,
              const std::vector<std::set<int>>& of_edge) const {
    Score s;
    s.expected = count();
    for (const NetworkRegion& region : regions) {
      const auto loop = segments_along(region.loops[0], of_edge);
      const int which = of(loop);
      if (which < 0 || !s.correct.insert(which).second) s.wrong += !doubtful(loop);
    }
    return s;
  }

  // The curves between two faces that are creases, by the names of their edges.
  struct Creases {
    std::vector<std::string> correct, wrong, missed;
    double precision() const { return fraction(correct.size(), wrong.size()); }
    double recall() const { return fraction(correct.size(), missed.size()); }

   private:
    static double fraction(size_t of, size_t and_others) {
      return static_cast<double>(of) / static_cast<double>(of + and_others);
    }
  };
  Creases creases(const std::vector<ModelJoin>& joins,
                  const std::vector<std::set<int>>& of_edge) const {
    Creases c;
    for (const ModelJoin& join : joins) {
      const bool crease = join.kind == ModelJoin::Kind::Crease;
      const std::set<int>& on = of_edge[static_cast<size_t>(join.edge)];
      if ((!crease && join.kind != ModelJoin::Kind::Smooth) || on.empty() ||
          any_in(on, doubtful_lines_))
        continue;
      const bool meant = any_in(on, creases_);
      if (meant && crease) c.correct.push_back(join.line);
      if (!meant && crease) c.wrong.push_back(join.line);
      if (meant && !crease) c.missed.push_back(join.line);
    }
    return c;
  }

 private:
  static bool any_in(const std::set<int>& on, const std::set<int>& lines) {
    return std::any_of(on.begin(), on.end(), [&](int id) { return lines.count(id) > 0; });
  }
  bool doubtful(const std::vector<std::set<int>>& loop) const {
    return std::any_of(doubtful_.begin(), doubtful_.end(),
                       [&](const auto& segments) { return runs_along(loop, segments); });
  }
  // Strokes may be doubled: each edge is on one of the segments, and each of these has an edge.
  static bool runs_along(const std::vector<std::set<int>>& loop, const std::set<int>& segments) {
    std::set<int> left = segments;
    for (const std::set<int>& edge : loop) {
      bool on = edge.empty();
      for (const int id : edge) {
        on = on || segments.count(id);
        left.erase(id);
      }
      if (!on) return false;
    }
    return left.empty();
  }

  std::vector<std::vector<std::set<int>>> alternatives_;
  std::vector<std::set<int>> doubtful_;
  std::set<int> creases_, doubtful_lines_;
};

}  // namespace batten_test
