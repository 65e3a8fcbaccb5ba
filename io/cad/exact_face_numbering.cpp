#include "batten/io/cad/exact_face_numbering.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/isize.h"

namespace batten {
namespace {

std::vector<int> add(int count, std::vector<int>& all) {
  std::vector<int> numbers(static_cast<size_t>(count));
  std::iota(numbers.begin(), numbers.end(), isize(all));
  all.insert(all.end(), numbers.begin(), numbers.end());
  return numbers;
}
/// The line's parameters at the vertices of a run.
std::vector<double> on_line(const StepLine& line, const EdgeAlignedLine& aligned_line,
                            double distance) {
  const HermiteCurve &curve = *line.curve, &fitted = aligned_line.fitted;
  const bool along = direction_along(fitted, curve, distance) > 0;
  std::vector<double> at;
  for (const double t : aligned_line.parameters) {
    const double fraction = (t - fitted.start()) / (fitted.end() - fitted.start());
    at.push_back(curve.start() + (along ? fraction : 1 - fraction) * (curve.end() - curve.start()));
  }
  return at;
}

}  // namespace

ExactFaceNumbering::ExactFaceNumbering(const StepPlan& plan) : plan_(plan) {
  for (const SkinnedRegion* region : plan.regions) {
    SharedEntityIds own;
    own.vertices = add(region->surface.mesh().vertex_count(), vertices_);
    own.edges = add(region->surface.mesh().edge_count(), edges_);
    if (!region->surface.trim())
      for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
        if (!aligned_line.line.name.empty()) join(aligned_line, own);
    numbers_.push_back(std::move(own));
  }
  const auto to_roots = [&](std::vector<int>& numbers) {
    for (int& v : numbers) v = root(v);
  };
  for (SharedEntityIds& of : numbers_) {
    to_roots(of.vertices);
    for (auto& [edge, pieces] : of.on_lines) to_roots(pieces.vertices);
  }
  for (auto& [name, line] : lines_) to_roots(line.vertices);
}

int ExactFaceNumbering::root(int vertex) const {
  while (vertices_[vertex] != vertex) vertex = vertices_[vertex];
  return vertex;
}

// Makes two vertices one; the lower number stays.
void ExactFaceNumbering::unite(int a, int b) {
  a = root(a);
  b = root(b);
  vertices_[std::max(a, b)] = std::min(a, b);
}

const LineEntityIds& ExactFaceNumbering::numbers_of(const std::string& name) {
  const auto [it, added] = lines_.try_emplace(name);
  LineEntityIds& numbers = it->second;
  if (!added) return numbers;
  const StepLine& line = plan_.lines.at(name);
  const int cuts = isize(line.cuts);
  numbers.vertices = add(cuts + 2, vertices_);
  numbers.edges = add(cuts + 1, edges_);
  for (const bool end : {false, true}) {
    const int v = end ? numbers.vertices.back() : numbers.vertices.front();
    unite(end_points_.emplace(line.places[end], v).first->second, v);
  }
  return numbers;
}

void ExactFaceNumbering::join(const EdgeAlignedLine& aligned_line, SharedEntityIds& own) {
  const StepLine& line = plan_.lines.at(aligned_line.line.name);
  const LineEntityIds& numbers = numbers_of(aligned_line.line.name);
  std::vector<double> places{line.curve->start()};
  places.insert(places.end(), line.cuts.begin(), line.cuts.end());
  places.push_back(line.curve->end());
  std::vector<int> at;  // places of the run's vertices
  for (const double t : on_line(line, aligned_line, plan_.distance)) {
    const auto next = std::lower_bound(places.begin() + 1, places.end() - 1, t);
    at.push_back(static_cast<int>(next - places.begin()) - (*next - t > t - *(next - 1)));
    unite(own.vertices[aligned_line.vertices[at.size() - 1]], numbers.vertices[at.back()]);
  }
  for (size_t k = 0; k < aligned_line.edges.size(); ++k) {
    const bool up = aligned_line.vertices[k] < aligned_line.vertices[k + 1];
    const int from = at[up ? k : k + 1], to = at[up ? k + 1 : k], step = from < to ? 1 : -1;
    SideSubdivision& pieces = own.on_lines[aligned_line.edges[k]];
    for (int c = from; c != to + step; c += step) {
      pieces.vertices.push_back(numbers.vertices[c]);
      pieces.fractions.push_back(
          std::abs((places[c] - places[from]) / (places[to] - places[from])));
      if (c != to) pieces.edges.push_back(numbers.edges[std::min(c, c + step)]);
    }
  }
}

void cut_at_vertices(StepPlan& plan) {
  for (const SkinnedRegion* region : plan.regions)
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned) {
      if (region->surface.trim() || aligned_line.line.name.empty()) continue;
      StepLine& line = plan.lines.at(aligned_line.line.name);
      const double span = line.curve->end() - line.curve->start();
      // Vertices of two regions in one place are one, whatever rounding did to their parameters.
      const double hair = plan.distance / line.curve->length() * span;
      const auto at = on_line(line, aligned_line, plan.distance);
      std::vector<double> added;
      for (size_t k = 1; k + 1 < at.size(); ++k)
        if (std::none_of(line.cuts.begin(), line.cuts.end(),
                         [&](double cut) { return std::abs(cut - at[k]) <= hair; }))
          added.push_back(at[k]);
      line.cuts.insert(line.cuts.end(), added.begin(), added.end());
      std::sort(line.cuts.begin(), line.cuts.end());
    }
}

}  // namespace batten
