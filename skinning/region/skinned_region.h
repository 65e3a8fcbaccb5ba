// A skinned region (one C1 surface with its lines), its options, and quality measures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/elements/c1_triangle.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A mesh-aligned (conforming) curve: a chain of element edges, straight in the domain, on which
/// the surface equals the fitted curve exactly.
struct EdgeAlignedLine {
  CharacterLine line;   ///< the input curve
  HermiteCurve fitted;  ///< the C1 cubic curve that the surface interpolates
  /// Mesh vertices from the start of the curve to its end. A closed curve repeats the first one.
  std::vector<int> vertices;
  std::vector<double> parameters;  ///< for each entry of `vertices`, the parameter of `fitted`
  std::vector<int> edges;          ///< mesh edges between consecutive entries of `vertices`
};

/// An embedded (immersed) curve: the mesh does not follow it. The surface contains the curve at
/// collocation points; between them there is a gap, which is measured.
struct EmbeddedLine {
  CharacterLine line;          ///< the input curve
  HermiteCurve fitted;         ///< curve in space X(t), model units
  HermiteCurve pcurve;         ///< parameter curve c(t) in (u, v), z = 0, with the same t
  std::vector<double> points;  ///< collocation parameters t: x(c(t)) = X(t); ascending
  /// True if `fitted` runs against line.prescribed, because outlines are oriented along their loop.
  bool opposite_to_prescribed = false;
};

/// One line of the region's boundary, edge-aligned or embedded.
struct BoundarySegment {
  enum class Kind { EdgeAligned, Embedded } kind = Kind::EdgeAligned;
  int index = 0;          ///< index into SkinnedRegion::edge_aligned or ::embedded
  bool reversed = false;  ///< the loop runs against the line's direction
};

/// A surface with its lines and boundary.
struct SkinnedRegion {
  std::string name;
  Surface surface;
  std::vector<EdgeAlignedLine> edge_aligned;
  /// Length scale of the region, model units: diagonal of the bounding box of its lines.
  double size = 1;
  std::vector<EmbeddedLine> embedded = {};
  /// Closed loops with the region to their left in (u, v): the outline first, then holes. In an
  /// annular domain (mesh periodic in u) the first two loops are the boundary circles, which run
  /// once around the period.
  std::vector<std::vector<BoundarySegment>> boundary = {};
};

/// Straight pcurve of an edge-aligned line in (u, v) (z = 0), with the parameter of its fitted
/// curve.
HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);

/// Pcurve of a boundary segment, in the direction of its loop, in (u, v) (z = 0). It has the
/// parameter of boundary_curve().
HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece);
/// Curve of a boundary segment in space, in the direction of its loop.
HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece);
/// The boundary as loops in the (u, v) plane. Not for annular domains.
DomainLoops boundary_loops(const SkinnedRegion& region);

// Options for skinning a region.

class SizeField;  // skinning/domains/mesher.h

/// Options for building a region's surface from its lines.
struct SkinOptions {
  /// Largest distance between a line and its C1 cubic curve, model units. 0: 1e-4 of the region's
  /// size.
  double tolerance = 0;
  /// A line has a corner where its direction changes by more than this angle, degrees.
  double corner_angle = 20;
  TriangleElement element = TriangleElement::HCT;
  enum class Mesher {
    Delaunay,  ///< CGAL's Mesh_2; falls back to Fan, with a warning, in a build without CGAL
    /// Triangles from the domain's centroid to its sides, each split into four repeatedly; needs
    /// one line per side and no inner lines.
    Fan
  };
  Mesher mesher = Mesher::Delaunay;
  /// Type of the flat parameter domain.
  enum class Domain {
    Auto,  ///< chosen by the loops, as described for the other types
    /// Polygon with straight sides, for a loop with three or more corners; the outline curves are
    /// mesh-aligned.
    Polygon,
    /// Projection onto a plane, for a loop whose projection does not intersect itself; all curves
    /// are embedded.
    Projected,
    /// Unrolled developable surface that spans the loop, for a loop that overlaps itself in
    /// projection; all curves are embedded.
    Developable,
    Annulus  ///< periodic in u, for two smooth loops; boundary curves are mesh-aligned
  };
  Domain domain = Domain::Auto;
  /// Treats every corner as convex (a left turn of the loop), even if the lines alone suggest a
  /// right turn. Set it for a face to which the region will be fitted and whose corners are convex.
  /// Such a face may be far from any surface that the lines alone define.
  bool convex = false;
  /// The region has a rest shape, the surface that its boundary curves suggest (model_shapes.h), if
  /// there is one. If false, its bending energy is that of the shape itself (rest shape zero).
  bool rest = true;
  /// True: the region is an annulus, and each inner line is a closed cross-section of it. The lines
  /// are ordered from one boundary circle to the other.
  bool sections = false;
  /// The outline runs against its first line, so that the normal points to the other side.
  bool reverse_orientation = false;
  /// Moves the corners of a polygonal domain and remeshes, until the surface defined by the lines
  /// has as little stretch and shear as straight sides allow. At most three rounds, one solve each.
  bool minimize_distortion = false;
  /// Number of times that the triangles of the fan are split into four; -1: until edges are short
  /// enough. Throws if a line needs more nodes for the tolerance than the fan then has on a side.
  int fan_refinements = -1;
  /// Target length of element edges, model units. 0: 1/20 of the region's size.
  double edge_length = 0;
  /// Spatially varying lengths below `edge_length`, for polygonal domains of prescribed curves;
  /// null: none.
  std::shared_ptr<const SizeField> size_field{};
};

// Geometry of a region: everything except its shape.

/// A corner of the domain's outline: its position, its interior angle in the domain and the angle
/// between the lines in space, degrees.
struct DomainCorner {
  Vec2 uv;
  double domain_angle_deg, line_angle_deg;
};

/// Mesh, lines and boundary of a region: everything except its shape (dofs).
struct RegionGeometry {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;  ///< null if no embedded line bounds the region
  std::vector<EdgeAlignedLine> edge_aligned;
  std::vector<EmbeddedLine> embedded;
  std::vector<std::vector<BoundarySegment>> boundary;
  std::vector<DomainCorner> corners;  ///< counter-clockwise
  std::vector<std::string> warnings;
};

// Quality measures of a finished surface.

/// Largest distance |x(c(t)) - X(t)| between a surface and an embedded line, model units: sampled
/// 20 times between adjacent collocation points.
double line_gap(const Surface& surface, const EmbeddedLine& line);

/// Marks triangles under intervals between collocation points in which the surface is farther than
/// `target` (model units) from an embedded line. `marks`: one per triangle of the region; others
/// are left unchanged.
void mark_gaps(const SkinnedRegion& region, double target, char* marks);

/// Quality of a finished surface, measured by sampling.
struct SkinQuality {
  double max_line_residual = 0;    ///< surface to edge-aligned curves, over the region's size
  double max_line_gap = 0;         ///< surface to the curves of embedded lines, model units
  double max_line_deviation = 0;   ///< surface to input lines, symmetric, model units
  double max_normal_jump_deg = 0;  ///< between normals across interior element edges, degrees
  double min_jacobian_ratio = 0;   ///< smallest |x_u × x_v| (with sign) over the median
  double max_shear = 1;            ///< largest σ1/σ2 of (x_u, x_v)
  double rms_strain = 0;           ///< Distortion::rms of the surface relative to its domain
  int singular_nodes = 0;          ///< vertices where |x_u × x_v| is below 1e-6 of the median
  double area = 0;                 ///< model units²
};
/// Measures all quality figures of a region, by sampling.
SkinQuality measure(const SkinnedRegion& region);
/// Measures only what needs no lines: normals, Jacobians, singular nodes, area. Ten times faster.
SkinQuality measure(const Surface& surface);

}  // namespace batten
