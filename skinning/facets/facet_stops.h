// Inside of facets: where edges end on the lines of a region, before it is meshed.
//
// There has to be a stop at every mesh vertex of a run, at every end and corner of an embedded
// line, and wherever lines meet or cross. Between these come the stops that divisions() or the
// neighbours (LineStops) want.
#pragma once

#include <string>
#include <vector>

#include "batten/core/index.h"
#include "batten/skinning/facets/facet_lines.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

/// A place on a line where an edge ends.
struct FacetStop {
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
class FacetStops {
 public:
  /// Throws InputError: no boundary; a ring without room for a seam.
  FacetStops(const SkinnedRegion& region, double edge_length, const LineStops& asked);

  /// Returns "facets of region 'NAME': ", for messages.
  std::string who() const { return "facets of region '" + region_.name + "': "; }
  /// Returns the lines of the region: runs, then embedded lines, then the seam of a ring.
  const std::vector<FacetLine>& lines() const { return lines_; }
  /// Returns the stops of a line, ascending.
  const std::vector<FacetStop>& on(size_t line) const { return stops_[line]; }
  const std::vector<Vec2>& nodes() const { return nodes_; }
  bool on_boundary(size_t line) const { return on_boundary_[line] != 0; }
  size_t line_of(const BoundaryPiece& piece) const {
    return static_cast<size_t>(piece.index) +
           (piece.kind == BoundaryPiece::Kind::Run ? 0 : region_.runs.size());
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
    return count_of(nodes_) - 1;
  }
  // The fixed stop of a line near a point of it, or null. Closed lines have two at their seam.
  const FacetStop* fixed_near(size_t line, const Vec2& p) const;
  void fix(size_t line, double t, int node) { stops_[line].push_back({t, node, true}); }
  // The nearest point of a line to p or one of its images.
  CurvePoint closest(const FacetLine& line, const Vec2& p) const;

  // Cuts a ring along a straight seam from rim to rim. It is meshed between two images of the seam,
  // which are one again afterwards. The seam begins at the vertex of the first rim for which it
  // runs least along other lines, and crosses no hole.
  void cut_open();
  void place_fixed_stops();
  void find_crossings();
  // Finds crossings of two arcs by halving them; the second line is moved by du.
  void cross_arcs(size_t l, size_t i, double s0, double s1, size_t m, size_t j, double t0,
                  double t1, double du, int depth);
  // Makes the stops between the fixed ones.
  void divide();
  void divide_embedded(size_t line);
  void divide_as_asked(size_t line);
  void divide_seam();

  const SkinnedRegion& region_;
  const LineStops& asked_;
  std::vector<FacetLine> lines_;
  std::vector<char> on_boundary_;
  std::vector<int> at_least_;
  double same_ = 0, size_ = 0, space_ = 0;
  std::vector<Vec2> nodes_;
  std::vector<std::vector<FacetStop>> stops_;
};

}  // namespace batten
