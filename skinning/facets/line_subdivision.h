// SPDX-License-Identifier: MPL-2.0
// Subdivision of the lines of a region into edges, before the region is meshed for facets.
//
// Subdivision points are required at every mesh vertex of an edge-aligned line, at every end and
// corner of an embedded line, and wherever lines meet or cross. Between these there are the points
// of subdivide_line() or those that the neighbours request (SubdivisionRequest).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/fem/curves/domain_loops.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

// The lines of a region in (u, v), and the subdivision of a line without required points.

/// A line of the region in (u, v): a chain of mesh edges, or an embedded line's pcurve. Keeps a
/// reference to the embedded line.
class FacetLine {
 public:
  FacetLine(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);
  /// Constructs a straight line with its length as parameter.
  FacetLine(std::string name, const Vec2& from, const Vec2& to);
  explicit FacetLine(const EmbeddedLine& line);

  const std::string& name() const { return name_; }
  const EmbeddedLine* embedded() const { return embedded_; }
  const std::vector<double>& parameters() const { return parameters_; }
  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }

  Vec2 at(double t) const;     ///< point at a parameter
  Vec2 slope(double t) const;  ///< dc/dt at a parameter
  /// The cubic arc of segment k between two fractions of it in [0, 1].
  PlanarCubic arc(size_t k, double s0, double s1) const { return arcs_[k].part(s0, s1); }
  size_t arc_count() const { return arcs_.size(); }
  /// A range of u that contains the line.
  std::pair<double, double> u_range() const;
  double parameter(size_t k, double s) const {
    return parameters_[k] + s * (parameters_[k + 1] - parameters_[k]);
  }
  /// Parameter and distance of the line's point that is closest to p.
  CurvePoint closest(const Vec2& p) const;

 private:
  void make_segments();
  size_t segment(double t) const;

  std::string name_;
  const EmbeddedLine* embedded_ = nullptr;
  std::vector<double> parameters_;
  std::vector<Vec2> points_;  // mesh vertices of an edge-aligned line
  std::vector<PlanarCubic> arcs_;
};

/// The parameters of a line's ends and corners, ascending.
std::vector<double> breaks(const EmbeddedLine& line);

/// Divides a line into even intervals of about `edge_length` (model units), at least `min_edges`.
/// In each interval its direction changes by at most 36 degrees. Parameters depend on the line's
/// curve in space only.
std::vector<double> subdivide_line(const EmbeddedLine& line, double edge_length, int min_edges);

/// A point on a line where edges end.
struct SubdivisionPoint {
  double t;
  int node;
  bool fixed;  ///< a break, a mesh vertex, or shared with another line
};

/// Mean length of element edges that are not outside of the trim: the distance of their ends in
/// space (model units), and the length in (u, v).
struct MeanEdge {
  double space = 0, uv = 0;
};
MeanEdge mean_edge(const Surface& surface);

/// Computes the subdivision of all lines of a region.
class LineSubdivision {
 public:
  /// Throws InputError for a region without boundary, or an annulus without a straight seam that
  /// avoids its holes.
  LineSubdivision(const SkinnedRegion& region, double edge_length,
                  const SubdivisionRequest& requested);

  /// The prefix "tessellation of face 'NAME': " of messages.
  std::string message_prefix() const { return "tessellation of face '" + region_.name + "': "; }
  /// The lines of the region: edge-aligned, then embedded, then the seam of an annulus.
  const std::vector<FacetLine>& lines() const { return lines_; }
  /// Subdivision points of a line, ascending.
  const std::vector<SubdivisionPoint>& on(size_t line) const { return subdivisions_[line]; }
  const std::vector<Vec2>& nodes() const { return nodes_; }
  bool on_boundary(size_t line) const { return on_boundary_[line] != 0; }
  size_t line_of(const BoundarySegment& piece) const {
    return static_cast<size_t>(piece.index) +
           (piece.kind == BoundarySegment::Kind::EdgeAligned ? 0 : region_.edge_aligned.size());
  }
  /// Target length of edges in (u, v).
  double size() const { return size_; }

  /// Inserts a subdivision point between two others.
  void add(size_t line, double t);

  /// p or, in an annular domain, its periodic copy nearest to `anchor`.
  Vec2 near(const Vec2& p, const Vec2& anchor) const {
    return region_.surface.mesh().image_near(p, anchor);
  }
  double period() const { return region_.surface.mesh().period(); }
  bool has_seam() const { return period() > 0; }
  size_t seam() const { return lines_.size() - 1; }
  bool on_seam(int node) const;
  /// Difference between the u of p and the u of the seam at the same v.
  double beyond_seam(const Vec2& p) const;

 private:
  int new_node(const Vec2& p) {
    nodes_.push_back(p);
    return isize(nodes_) - 1;
  }
  // The fixed subdivision point of a line near p, or null. Closed lines have two at their start.
  const SubdivisionPoint* fixed_near(size_t line, const Vec2& p) const;
  void fix(size_t line, double t, int node) { subdivisions_[line].push_back({t, node, true}); }
  // The point of a line closest to p or to one of its periodic copies.
  CurvePoint closest(const FacetLine& line, const Vec2& p) const;

  // Cuts an annulus along a straight seam from circle to circle. It is meshed between two copies of
  // the seam, which are merged afterwards. The seam begins at the vertex of the first circle for
  // which it is least aligned with other lines, and it crosses no hole.
  void cut_open();
  void add_fixed_points();
  void find_crossings();
  // Finds crossings of two arcs by recursive bisection; the second line is shifted by du.
  void intersect_segments(size_t l, size_t i, double s0, double s1, size_t m, size_t j, double t0,
                          double t1, double du, int depth);
  // Adds the subdivision points between the fixed ones.
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
