// Which vertices and edges exact faces have in common. Internal.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/io/cad/step_plan.h"

namespace batten {

/// A side of a triangle from its lower vertex to the higher one: one edge, or several where
/// vertices of others lie on it.
struct Pieces {
  std::vector<int> vertices, edges;
  std::vector<double> shares;  // of the side, at the vertices
};

/// Numbers of a region's vertices and edges among those of all regions, of which each is one.
struct CommonNumbers {
  std::vector<int> vertices, edges;
  std::map<int, Pieces> on_lines;  // of edges along named lines, instead of the above
};

/// Numbers along a line, from its start.
struct LineNumbers {
  std::vector<int> vertices, edges;
};

/// Numbers vertices and edges of all regions but the cut ones. What lies in the same place of lines
/// with the same name, or at ends of lines that lie in the same place, gets one number. Edges along
/// lines end at the plan's cuts (cut_at_vertices).
class ExactNumbers {
 public:
  /// Keeps a reference.
  explicit ExactNumbers(const StepPlan& plan);

  /// Of StepPlan::regions.
  const std::vector<CommonNumbers>& regions() const { return numbers_; }
  const std::map<std::string, LineNumbers>& lines() const { return lines_; }
  size_t vertex_count() const { return vertices_.size(); }
  size_t edge_count() const { return edges_.size(); }

 private:
  int root(int vertex) const;
  void unite(int a, int b);
  const LineNumbers& numbers_of(const std::string& name);
  void join(const LineRun& run, CommonNumbers& own);

  const StepPlan& plan_;
  std::vector<int> vertices_;  // each the number that it is one with, or its own
  std::vector<int> edges_;
  std::map<std::string, LineNumbers> lines_;
  std::map<int, int> places_;
  std::vector<CommonNumbers> numbers_;
};

/// Cuts lines where triangles of exact faces have vertices on them.
void cut_at_vertices(StepPlan& plan);

}  // namespace batten
