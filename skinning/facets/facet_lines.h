// Inside of facets: the lines of a region in (u, v), and where edges end on them by themselves.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/fem/planar_cubic.h"
#include "batten/skinning/region/region.h"

namespace batten {

/// A line of the region in (u, v): a chain of mesh edges, or a curve. Refers to the embedded line.
class FacetLine {
 public:
  FacetLine(const ParametricMesh& mesh, const LineRun& run);
  /// A straight line over its own length.
  FacetLine(std::string name, const Vec2& from, const Vec2& to);
  explicit FacetLine(const EmbeddedLine& line);

  const std::string& name() const { return name_; }
  const EmbeddedLine* embedded() const { return embedded_; }
  const std::vector<double>& parameters() const { return parameters_; }
  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }

  Vec2 at(double t) const;
  Vec2 slope(double t) const;
  /// The cubic arc between two parameters of one segment.
  PlanarCubic arc(size_t k, double s0, double s1) const { return arcs_[k].part(s0, s1); }
  size_t arc_count() const { return arcs_.size(); }
  /// The range of u that it stays in.
  std::pair<double, double> reach() const;
  double parameter(size_t k, double s) const {
    return parameters_[k] + s * (parameters_[k + 1] - parameters_[k]);
  }
  /// Parameter and distance of the nearest point.
  CurvePoint closest(const Vec2& p) const;

 private:
  void join_places();
  size_t segment(double t) const;

  std::string name_;
  const EmbeddedLine* embedded_ = nullptr;
  std::vector<double> parameters_;
  std::vector<Vec2> places_;  // of a run's vertices
  std::vector<PlanarCubic> arcs_;
};

/// Where the curve of a line breaks: its ends and corners.
std::vector<double> breaks(const EmbeddedLine& line);

/// Parameters that cut a line evenly in pieces of about `edge_length`, `at_least` so many, and turn
/// by 36 degrees each at most. They follow from the line's curve in space alone.
std::vector<double> divisions(const EmbeddedLine& line, double edge_length, int at_least);

}  // namespace batten
