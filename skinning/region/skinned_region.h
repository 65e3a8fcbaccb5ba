// A skinned region: one C1 surface and its lines.
#pragma once

#include <string>
#include <vector>
#include <memory>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/elements/c1_triangle.h"

namespace batten {

/// A fitted line: a chain of element edges along a straight run of the domain, on which the surface
/// is exactly the fitted curve.
struct EdgeAlignedLine {
  CharacterLine line;              ///< as the user gave it
  HermiteCurve fitted;             ///< the C1 cubic curve that the surface interpolates
  std::vector<int> vertices;       ///< mesh vertices from the line's start to its end
  std::vector<double> parameters;  ///< of `fitted`, at each of these vertices
  std::vector<int> edges;          ///< mesh edges between them
};

/// An embedded line: the mesh ignores it, the surface is on it at its points and nearly so between
/// them.
struct EmbeddedLine {
  CharacterLine line;          ///< as the user gave it
  HermiteCurve fitted;         ///< X(t), model units
  HermiteCurve pcurve;         ///< c(t) in (u, v), z = 0, over the same parameters
  std::vector<double> points;  ///< parameters at which x(c(t)) = X(t) is held, ascending
  /// `fitted` runs against line.given: outlines run along their loop.
  bool opposite_to_prescribed = false;
};

/// One line, or run, of the region's boundary.
struct BoundarySegment {
  enum class Kind { EdgeAligned, Embedded } kind = Kind::EdgeAligned;
  int index = 0;          ///< in SkinnedRegion::edge_aligned or ::embedded
  bool reversed = false;  ///< the loop goes against the line's direction
};

/// A surface and how its lines lie on it.
struct SkinnedRegion {
  std::string name;
  Surface surface;
  std::vector<EdgeAlignedLine> edge_aligned;
  double size = 1;  ///< length scale of the region in model units: diagonal of its lines' box
  std::vector<EmbeddedLine> embedded = {};
  /// Closed loops with the region to their left in (u, v), the outline first, then holes. A ring (a
  /// mesh that is periodic in u) begins with two, its rims, which run once around the period.
  std::vector<std::vector<BoundarySegment>> boundary = {};
};

/// Returns the straight image of a run in (u, v) (z = 0), over the parameters of its fitted curve.
HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);

/// Returns a piece of the boundary, in the direction of its loop, in (u, v) (z = 0), over the
/// parameters of boundary_curve().
HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece);
/// Returns the same piece in space.
HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece);
/// Returns the boundary as a region of the (u, v) plane. It is not for rings.
DomainLoops boundary_loops(const SkinnedRegion& region);


// Options for making a region of its lines.

class SizeField;  // skinning/domains/size_field.h

/// How a region is made of its lines.
struct SkinOptions {
  /// Largest distance between a line and its C1 cubic curve, model units. 0: 1e-4 of the region's
  /// size.
  double tolerance = 0;
  /// A line turns a corner where its direction turns by more, degrees.
  double corner_angle = 20;
  TriangleElement element = TriangleElement::HCT;
  enum class Mesher {
    Delaunay,  ///< CGAL's Mesh_2; falls back to Fan, with a warning, in a build without CGAL
    Fan        ///< triangles from the domain's centre to its sides, each cut in four again and
               ///< again; sides of one line each, no inner lines
  };
  Mesher mesher = Mesher::Delaunay;
  enum class Domain {
    Auto,
    Polygon,      ///< for three corners or more; lines are fitted
    Projected,    ///< for a loop that projects simply; lines are embedded
    Developable,  ///< for any other loop, unfolded like a strip of paper; lines are embedded
    Annulus       ///< for two smooth loops; they are fitted
  };
  Domain domain = Domain::Auto;
  /// Every corner turns to the left of the loop, wherever the lines alone seem to turn: so do those of a
  /// face that the region will be drawn to. Such a face may be far from any surface that the lines make.
  bool convex = false;
  /// The region rests in the shape that its boundary means (rest_shape.h), if there is one; else it bends
  /// from nothing.
  bool rest = true;
  /// Inner lines of a ring are sections of it, in their order from the first rim to the last.
  bool sections = false;
  /// The outline runs against its first line: the normal points to the other side.
  bool reverse_orientation = false;
  /// Whether a polygon's corners move, and the mesh is made anew, until the surface that the lines
  /// make is as little stretched and sheared as straight sides allow (at most three rounds, each
  /// one solve).
  bool minimize_distortion = false;
  /// How often the triangles of the fan are cut in four; -1: until edges are short enough. Lines
  /// that need more nodes than the fan then has on a side to reach the tolerance are refused.
  int fan_refinements = -1;
  /// Target length of element edges, model units. 0: 1/20 of the region's size.
  double edge_length = 0;
  /// Shorter edges than that, on a polygon of given curves; null: none.
  std::shared_ptr<const SizeField> size_field{};
};


// What a region is made of, except its shape.

/// A corner of the domain's outline. It has a place, and an interior angle (degrees) in the domain
/// and another one between the lines in space.
struct DomainCorner {
  Vec2 uv;
  double domain_angle_deg, line_angle_deg;
};

/// All that a region has except its shape.
struct RegionGeometry {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;  ///< null when no embedded line bounds the region
  std::vector<EdgeAlignedLine> edge_aligned;
  std::vector<EmbeddedLine> embedded;
  std::vector<std::vector<BoundarySegment>> boundary;
  std::vector<DomainCorner> corners;  ///< counter-clockwise
  std::vector<std::string> warnings;
};


// Measures how good a finished surface is.

/// Returns the largest distance |x(c(t)) - X(t)| of a shape from its embedded line, of 20 samples
/// between any two points.
double line_gap(const Surface& surface, const EmbeddedLine& line);

/// Marks the triangles, one mark for each of the region, under the stretches of embedded lines that
/// the surface leaves by more than `target` between two points.
void mark_gaps(const SkinnedRegion& region, double target, char* marks);

/// How far the finished surface is from what it promises, measured by sampling.
struct SkinQuality {
  double max_line_residual = 0;    ///< surface from its fitted lines, over the region's size
  double max_line_gap = 0;         ///< surface from the curves of embedded lines, model units
  double max_line_deviation = 0;   ///< surface from the input lines, both ways, model units
  double max_normal_jump_deg = 0;  ///< between normals across inner element edges
  double min_jacobian_ratio = 0;   ///< smallest |x_u × x_v| (oriented) over the median
  double max_shear = 1;            ///< largest σ1/σ2 of (x_u, x_v)
  double rms_strain = 0;           ///< Distortion::rms of the domain against the surface
  int singular_nodes = 0;          ///< vertices where x_u × x_v is below 1e-6 of the median
  double area = 0;                 ///< model units²
};
SkinQuality measure(const SkinnedRegion& region);
/// The part of it that needs no line: normals, Jacobians, singular nodes, area. A tenth of the time.
SkinQuality measure(const Surface& surface);

}  // namespace batten
