// SPDX-License-Identifier: MPL-2.0
// A skinned face (one C1 surface with its curves), its options, and quality measures.
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
  /// Mesh vertices on the curve, from start to end. For a closed curve, the last vertex equals the
  /// first one.
  std::vector<int> vertices;
  std::vector<double> parameters;  ///< parameters of `fitted` at the entries of `vertices`
  std::vector<int> edges;          ///< mesh edges between consecutive entries of `vertices`
};

/// An embedded (immersed) curve, which the mesh does not follow. The surface contains the curve at
/// collocation points. Between these points, line_gap() measures the distance of the surface from
/// the curve.
struct EmbeddedLine {
  CharacterLine line;          ///< the input curve
  HermiteCurve fitted;         ///< C1 cubic approximation of the curve in space, model units
  HermiteCurve pcurve;         ///< curve in (u, v), z = 0; same parameter as `fitted`
  std::vector<double> points;  ///< curve parameters of the collocation points, ascending
  /// True if `fitted` runs against `line.prescribed`. `fitted` has the direction of the loop of the
  /// outline; `line.prescribed` has that of the input curve.
  bool opposite_to_prescribed = false;
};

/// One curve of the boundary of a face, mesh-aligned or embedded.
struct BoundarySegment {
  enum class Kind { EdgeAligned, Embedded } kind = Kind::EdgeAligned;
  int index = 0;          ///< into SkinnedRegion::edge_aligned or SkinnedRegion::embedded
  bool reversed = false;  ///< true: the loop runs against the curve
};

/// The surface of a face, with its curves and its boundary.
struct SkinnedRegion {
  std::string name;
  Surface surface;
  std::vector<EdgeAlignedLine> edge_aligned;
  /// Length scale of the face, model units: diagonal of the bounding box of its curves.
  double size = 1;
  std::vector<EmbeddedLine> embedded = {};
  /// Closed boundary loops, with the face on the left in (u, v): first the outline, then the holes.
  /// In an annular domain (mesh periodic in u) the first two loops are the boundary circles, which
  /// run once around the period.
  std::vector<std::vector<BoundarySegment>> boundary = {};
};

/// The pcurve of a mesh-aligned curve: a straight line in (u, v), with z = 0 and the
/// parametrisation of EdgeAlignedLine::fitted.
HermiteCurve edge_aligned_pcurve(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line);

/// The pcurve of a boundary segment in (u, v), with z = 0, in the direction of the boundary loop,
/// with the parametrisation of boundary_curve().
HermiteCurve boundary_pcurve(const SkinnedRegion& region, const BoundarySegment& piece);
/// The curve of a boundary segment in space, in the direction of the boundary loop.
HermiteCurve boundary_curve(const SkinnedRegion& region, const BoundarySegment& piece);
/// The boundary of a face as closed loops in the (u, v) plane. The domain must not be annular.
DomainLoops boundary_loops(const SkinnedRegion& region);

// Options for skinning a face.

class SizeField;  // skinning/domains/mesher.h

/// Options for building the surface of a face from its curves.
struct SkinOptions {
  /// Largest allowed distance between an input curve and the C1 cubic curve fitted to it, model
  /// units. 0: 1e-4 of the size of the face.
  double tolerance = 0;
  /// Corner angle, degrees: a curve has a corner where its tangent turns by more than this angle.
  double corner_angle = 20;
  TriangleElement element = TriangleElement::HCT;
  enum class Mesher {
    Delaunay,  ///< CGAL's Mesh_2; falls back to Fan, with a warning, in a build without CGAL
    /// A fan of triangles from the centroid of the domain to its sides, each repeatedly split into
    /// four. The domain must have one curve per side and no inner curves.
    Fan
  };
  Mesher mesher = Mesher::Delaunay;
  /// Type of the flat parameter domain.
  enum class Domain {
    Auto,  ///< selected by the number, corners and projection of the loops
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
  /// True: every corner of the face is convex (a left turn of the loop), even if the curves alone
  /// suggest a right turn. Set this option if the face will be fitted to a target whose corners are
  /// convex. Such a target may be far from any surface that the curves alone define.
  bool convex = false;
  /// True: the bending energy is measured from a rest shape made of the boundary curves (rest_dofs()
  /// in model_shapes.h), or from the flat state if they define none. False: it is always measured
  /// from the flat state.
  bool rest = true;
  /// True: the face is an annulus, and each inner curve is a closed cross-section of it. The curves
  /// are ordered from one boundary circle to the other.
  bool sections = false;
  /// True: the outline runs against its first curve, which reverses the normal of the surface.
  bool reverse_orientation = false;
  /// True: the corners of a polygonal domain are moved, and the domain is remeshed, to minimise the
  /// stretch and shear of the surface relative to the domain. At most three rounds, one solve each.
  bool minimize_distortion = false;
  /// Number of times that the triangles of Mesher::Fan are split into four. -1: until the edges are
  /// at most `edge_length` long. InputError is thrown if a side of the fan has too few nodes to fit
  /// a curve within `tolerance`.
  int fan_refinements = -1;
  /// Target length of element edges, model units. 0: 1/20 of the size of the face.
  double edge_length = 0;
  /// Target edge lengths that vary over the domain, below `edge_length`. Used only for polygonal
  /// domains with prescribed curves; null: `edge_length` everywhere.
  std::shared_ptr<const SizeField> size_field{};
};

// Geometry of a face: everything except its shape.

/// A corner of the outline of a face: its position (u, v) and its interior angle in the domain, and
/// the angle between its two curves in space. Angles are in degrees.
struct DomainCorner {
  Vec2 uv;
  double domain_angle_deg, line_angle_deg;
};

/// Mesh, curves and boundary of a face: everything except its shape (dofs).
struct RegionGeometry {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;  ///< trimmed domain; null if no embedded curve bounds the face
  std::vector<EdgeAlignedLine> edge_aligned;
  std::vector<EmbeddedLine> embedded;
  std::vector<std::vector<BoundarySegment>> boundary;
  std::vector<DomainCorner> corners;  ///< corners of the outline, counter-clockwise
  std::vector<std::string> warnings;
};

// Quality measures of a finished surface.

/// Largest distance between a surface and an embedded curve at equal curve parameters, model units.
/// It is sampled at 20 points between adjacent collocation points.
double line_gap(const Surface& surface, const EmbeddedLine& line);

/// Largest gap between one or several faces and their embedded curves, model units. 0 if there are
/// no embedded curves.
double line_gap(const SkinnedRegion& region);
double max_line_gap(const std::vector<SkinnedRegion>& regions);

/// Marks the triangles through which an embedded curve passes between two adjacent collocation
/// points, if the surface is farther than `target` (model units) from the curve there. `marks`: one
/// entry per triangle of the face; 1 for marked triangles, unchanged for the others.
void mark_gaps(const SkinnedRegion& region, double target, char* marks);

/// Quality of a finished surface, measured by sampling.
struct SkinQuality {
  /// Largest distance from the surface to its mesh-aligned curves, divided by the size of the face.
  double max_line_residual = 0;
  double max_line_gap = 0;  ///< largest gap at embedded curves (line_gap()), model units
  /// Largest distance of the surface's curves from the input curves, or vice versa, model units.
  double max_line_deviation = 0;
  /// Largest angle between the normals on both sides of an interior element edge, degrees.
  double max_normal_jump_deg = 0;
  /// Smallest Jacobian |x_u × x_v|, divided by the median; negative if the surface is inverted
  /// relative to the mean normal of the triangle.
  double min_jacobian_ratio = 0;
  double max_shear = 1;    ///< largest ratio of the singular values of (x_u, x_v)
  double rms_strain = 0;   ///< distortion relative to the domain (Distortion::rms)
  int singular_nodes = 0;  ///< vertices with |x_u × x_v| below 1e-6 of the median
  double area = 0;         ///< area of the surface, model units²
};
/// Measures all quality figures of a face, by sampling.
SkinQuality measure(const SkinnedRegion& region);
/// Measures only the quantities that do not depend on curves: normals, Jacobians, singular nodes,
/// area. This is ten times faster than measure(const SkinnedRegion&).
SkinQuality measure(const Surface& surface);

}  // namespace batten
