// Inside of facets: where edges end on the lines of a region, before it is meshed.
//
// There has to be a stop at every mesh vertex of a run, at every end and corner of an embedded
// line, and wherever lines meet or cross. Between these come the stops that subdivide_line() or the
// neighbours (SubdivisionRequest) want.
#pragma once

#include <string>
#include <vector>

#include "batten/core/isize.h"
#include "batten/skinning/facets/facet_line.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

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
  void place_fixed_stops();
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
  double same_ = 0, size_ = 0, space_ = 0;
  std::vector<Vec2> nodes_;
  std::vector<std::vector<SubdivisionPoint>> subdivisions_;
};

}  // namespace batten
