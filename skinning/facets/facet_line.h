// Inside of facets: the lines of a region in (u, v), and where edges end on a line that nothing
// else divides.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/fem/planar_cubic.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// A line of the region in (u, v): a chain of mesh edges, or a curve. It keeps a reference to the
/// embedded line.
class FacetLine {
 public:
  FacetLine(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);
  /// Makes a straight line with its length as parameter.
  FacetLine(std::string name, const Vec2& from, const Vec2& to);
  explicit FacetLine(const EmbeddedLine& line);

  const std::string& name() const { return name_; }
  const EmbeddedLine* embedded() const { return embedded_; }
  const std::vector<double>& parameters() const { return parameters_; }
  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }

  Vec2 at(double t) const;     ///< the place at a parameter
  Vec2 slope(double t) const;  ///< dc/dt there
  /// Returns the cubic arc of segment k between two shares s of it in [0, 1].
  PlanarCubic arc(size_t k, double s0, double s1) const { return arcs_[k].part(s0, s1); }
  size_t arc_count() const { return arcs_.size(); }
  /// Returns a range of u that the line does not leave.
  std::pair<double, double> u_range() const;
  double parameter(size_t k, double s) const {
    return parameters_[k] + s * (parameters_[k + 1] - parameters_[k]);
  }
  /// Returns parameter and distance of the line's point that is nearest to p.
  CurvePoint closest(const Vec2& p) const;

 private:
  void make_segments();
  size_t segment(double t) const;

  std::string name_;
  const EmbeddedLine* embedded_ = nullptr;
  std::vector<double> parameters_;
  std::vector<Vec2> points_;  // of a run's vertices
  std::vector<PlanarCubic> arcs_;
};

/// Returns the parameters of a line's ends and corners, ascending.
std::vector<double> breaks(const EmbeddedLine& line);

/// Returns parameters that cut a line into even pieces of about `edge_length`, `min_edges` so many,
/// each of which turns by at most 36 degrees. They follow from the line's curve in space alone.
std::vector<double> subdivide_line(const EmbeddedLine& line, double edge_length, int min_edges);

}  // namespace batten
