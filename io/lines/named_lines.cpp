// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/named_lines.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"

namespace batten {

std::vector<Vec3> NamedCurve::written_points() const {
  if (!has_curve()) return points;
  std::vector<Vec3> on_curve;
  // Relative to the range of u, which is approximately the length.
  constexpr double one_place = 1e-12;
  for (const double u : parameters) {
    const Vec3 p = curve.evaluate(u);
    if (on_curve.empty() ||
        (p - on_curve.back()).norm() > one_place * (curve.end() - curve.start()))
      on_curve.push_back(p);
  }
  return on_curve;
}

void make_names_unique(const std::vector<std::string*>& names, const std::string& other) {
  std::map<std::string, int> count, used;
  std::set<std::string> taken;
  for (std::string* name : names) {
    if (name->empty()) *name = other;
    ++count[*name];
  }
  for (const auto& [name, n] : count)
    if (n == 1) taken.insert(name);
  for (std::string* name : names) {
    const std::string shared = *name;
    if (count[shared] == 1) continue;
    do *name = shared + "_" + std::to_string(++used[shared]);
    while (!taken.insert(*name).second);
  }
}

namespace {

/// One end of a segment; `line` is -1 if there is none.
struct End {
  int line = -1;
  bool last = false;
};

class SegmentChainer {
 public:
  explicit SegmentChainer(std::vector<NamedPoints> lines) : lines_(std::move(lines)) {
    next_.resize(lines_.size());
    taken_.assign(lines_.size(), 0);
    for (auto& [endpoint, at] : endpoints())
      if (at.uses == 2 && at.ends.size() == 2 && goes_on(at.ends[0], at.ends[1])) {
        next_[at.ends[0].line][at.ends[0].last] = at.ends[1];
        next_[at.ends[1].line][at.ends[1].last] = at.ends[0];
      }
  }

  std::vector<NamedPoints> run() {
    std::vector<NamedPoints> chained;
    for (int k = 0; k < isize(lines_); ++k)
      if (!taken_[k]) chained.push_back(chain_of(k));
    return chained;
  }

 private:
  struct Endpoint {
    int uses = 0;           // by any curve
    std::vector<End> ends;  // of segments only
  };

  bool is_segment(int k) const { return lines_[k].points.size() == 2; }
  const Vec3& point(const End& e) const { return lines_[e.line].points[e.last]; }
  static End other(const End& e) { return {e.line, !e.last}; }

  std::map<std::pair<std::string, std::array<double, 3>>, Endpoint> endpoints() const {
    std::map<std::pair<std::string, std::array<double, 3>>, Endpoint> endpoints;
    for (int k = 0; k < isize(lines_); ++k)
      for (size_t i = 0; i < lines_[k].points.size(); ++i) {
        const Vec3& p = lines_[k].points[i];
        Endpoint& endpoint = endpoints[{lines_[k].name, {p.x(), p.y(), p.z()}}];
        ++endpoint.uses;
        if (is_segment(k)) endpoint.ends.push_back({k, i == 1});
      }
    return endpoints;
  }

  bool goes_on(const End& a, const End& b) const {
    constexpr double corner = 60 - 1e-6;  // degrees
    if (a.line == b.line) return false;
    return degrees_between(point(a) - point(other(a)), point(other(b)) - point(b)) < corner;
  }

  NamedPoints chain_of(int k) {
    if (!is_segment(k)) {
      taken_[k] = 1;
      return std::move(lines_[k]);
    }
    End start{k, false};
    for (End e = next_[k][0]; e.line >= 0; e = next_[start.line][start.last]) {
      start = other(e);
      if (e.line != k) continue;
      start = {k, false};  // closed
      break;
    }
    NamedPoints chain{lines_[k].name, {point(start)}, lines_[k].first_line};
    for (End e = start; e.line >= 0 && !taken_[e.line]; e = next_[e.line][!e.last]) {
      taken_[e.line] = 1;
      chain.points.push_back(point(other(e)));
    }
    return chain;
  }

  std::vector<NamedPoints> lines_;
  std::vector<std::array<End, 2>> next_;  // the segment end that continues each segment end
  std::vector<char> taken_;
};

}  // namespace

std::vector<NamedPoints> chain_segments(std::vector<NamedPoints> lines) {
  const size_t before = lines.size();
  std::vector<NamedPoints> chained = SegmentChainer(std::move(lines)).run();
  if (chained.size() < before)
    chained.front().format_note = std::to_string(before) + " records of the file joined to " +
                                  std::to_string(chained.size()) +
                                  (chained.size() == 1 ? " curve" : " curves");
  return chained;
}

}  // namespace batten
