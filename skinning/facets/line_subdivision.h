// Inside of facets: where edges end on the lines of a region, before it is meshed.
//
// There has to be a stop at every mesh vertex of a run, at every end and corner of an embedded
// line, and wherever lines meet or cross. Between these come the stops that subdivide_line() or the
// neighbours (SubdivisionRequest) want.
#pragma once

#include <string>
#include <vector>
#include <utility>

#include "batten/core/containers.h"
#include "batten/skinning/facets/facets.h"
#include "batten/fem/curves/domain_loops.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

// Inside of facets: the lines of a region in (u, v), and where edges end on a line that nothing
// else divides.

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


/// A place on a line where an edge ends.
struct SubdivisionPoint {
  double t;
  int node;
  bool fixed;  ///< a break, a mesh vertex, or shared with another line
};

/// The mean length of element edges that are not outside: as the distance of their ends in space,
/// and in (u, v).
struct MeanEdge {
  double space = 0, uv = 0;
};
MeanEdge mean_edge(const Surface& surface);

/// Finds the stops on all lines of a region.
class LineSubdivision {
 public:
  /// Throws InputError: no boundary; a ring without room for a seam.
  LineSubdivision(const SkinnedRegion& region, double edge_length,
                  const SubdivisionRequest& requested);

  /// Returns "facets of region 'NAME': ", for messages.
  std::string message_prefix() const { return "facets of region '" + region_.name + "': "; }
  /// Returns the lines of the region: runs, then embedded lines, then the seam of a ring.
  const std::vector<FacetLine>& lines() const { return lines_; }
  /// Returns the stops of a line, ascending.
  const std::vector<SubdivisionPoint>& on(size_t line) const { return subdivisions_[line]; }
  const std::vector<Vec2>& nodes() const { return nodes_; }
  bool on_boundary(size_t line) const { return on_boundary_[line] != 0; }
  size_t line_of(const BoundarySegment& piece) const {
    return static_cast<size_t>(piece.index) +
           (piece.kind == BoundarySegment::Kind::EdgeAligned ? 0 : region_.edge_aligned.size());
  }
  /// Returns the target length of edges in (u, v).
  double size() const { return size_; }

  /// Adds a stop between two others.
  void add(size_t line, double t);

  /// Returns p, or on a ring its image that is nearest to another point.
  Vec2 near(const Vec2& p, const Vec2& anchor) const {
    return region_.surface.mesh().image_near(p, anchor);
  }
  double period() const { return region_.surface.mesh().period(); }
  bool has_seam() const { return period() > 0; }
  size_t seam() const { return lines_.size() - 1; }
  bool on_seam(int node) const;
  /// Returns by how much the u of p is greater than that of the seam at the same v.
  double beyond_seam(const Vec2& p) const;

 private:
  int new_node(const Vec2& p) {
    nodes_.push_back(p);
    return isize(nodes_) - 1;
  }
  // The fixed stop of a line near a point of it, or null. Closed lines have two at their seam.
  const SubdivisionPoint* fixed_near(size_t line, const Vec2& p) const;
  void fix(size_t line, double t, int node) { subdivisions_[line].push_back({t, node, true}); }
  // The nearest point of a line to p or one of its images.
  CurvePoint closest(const FacetLine& line, const Vec2& p) const;

  // Cuts a ring along a straight seam from rim to rim. It is meshed between two images of the seam,
  // which are one again afterwards. The seam begins at the vertex of the first rim for which it
  // runs least along other lines, and crosses no hole.
  void cut_open();
  void add_fixed_points();
  void find_crossings();
  // Finds crossings of two arcs by halving them; the second line is moved by du.
  void intersect_segments(size_t l, size_t i, double s0, double s1, size_t m, size_t j, double t0,
                          double t1, double du, int depth);
  // Makes the stops between the fixed ones.
  void subdivide();
  void subdivide_embedded(size_t line);
  void subdivide_as_requested(size_t line);
  void subdivide_seam();

  const SkinnedRegion& region_;
  const SubdivisionRequest& requested_;
  std::vector<FacetLine> lines_;
  std::vector<char> on_boundary_;
  std::vector<int> min_edges_;
  double merge_tolerance_ = 0, size_ = 0, edge_length_ = 0;
  std::vector<Vec2> nodes_;
  std::vector<std::vector<SubdivisionPoint>> subdivisions_;
};

}  // namespace batten
