// From character lines to a C1 surface: one region.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/elements/c1_triangle.h"
#include "batten/skinning/region.h"

namespace batten {

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
  /// How often the fan is cut in four; -1: until edges are short enough. Lines that need more nodes
  /// than that to reach the tolerance are refused.
  int fan_refinements = -1;
  /// Target length of element edges, model units. 0: 1/20 of the region's size.
  double edge_length = 0;
};

/// Everything of a region except its shape: domain, mesh, lines on element edges.
///
/// 1. outline lines are joined at their ends into one loop, corners found;
/// 2. lines become C1 cubic Hermite curves (exact where the input is piecewise cubic);
/// 3. the domain is a polygon that bends at the line's corners only, sides as long and corners as
///    wide as the lines make them; it is scaled so that the region's size is 1: (u, v) has no unit;
/// 4. the polygon is meshed, nodes of lines included;
/// 5. each line becomes a straight run of element edges.
/// Lines with corners inside are cut there into "name.1", "name.2", …
/// The domain runs counter-clockwise along the outline in the direction of its first line, so that
/// line's direction decides to which side the surface's normal points; u runs along its side of the
/// polygon (directional alpha and beta refer to it).
/// Source: straight-run rule, docs/theory/domains.md.
class RegionLayout {
 public:
  /// Throws InputError, in words for the user, for what it refuses: an open loop, lines that cross
  /// or touch, a loop that crosses itself, fewer than three corners (smooth closed outlines), all
  /// lines on one line, a closed inner line, inner lines with corners, that cross, or whose ends
  /// are not on the outline.
  RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
               const SkinOptions& options, const Progress& progress = {});

  const std::string& name() const { return name_; }
  const std::shared_ptr<const ParametricMesh>& mesh() const { return mesh_; }
  TriangleElement element() const { return element_; }
  const std::vector<LineRun>& runs() const { return runs_; }
  double size() const { return size_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Corners of the polygon, counter-clockwise, and the angle (degrees) of each in the domain and
  /// between the lines in space.
  struct Corner {
    Vec2 uv;
    double domain_degrees, line_degrees;
  };
  const std::vector<Corner>& corners() const { return corners_; }

  /// The rows that hold every line exactly: uncoupled, named after the lines.
  ConstraintSet line_constraints() const;
  /// The rows that hold only the positions of the corners: uncoupled, "corner 1", "corner 2", …
  ConstraintSet corner_constraints() const;
  /// The region with the given dofs.
  SkinnedRegion region(Points dofs) const;

 private:
  std::string name_;
  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleElement element_;
  std::vector<LineRun> runs_;
  std::vector<Corner> corners_;
  std::vector<std::string> warnings_;
  double size_ = 1;
};

/// How far the finished surface is from what it promises, measured by sampling.
struct SkinQuality {
  double max_line_residual = 0;    ///< surface edge to fitted line, over the region's size
  double max_line_deviation = 0;   ///< surface edge to input curve, both ways, model units
  double max_normal_jump_deg = 0;  ///< across inner element edges
  double min_jacobian_ratio = 0;   ///< smallest |x_u × x_v| (oriented) over the median
  int singular_nodes = 0;          ///< vertices where x_u × x_v is below 1e-6 of the median
  double area = 0;                 ///< model units²
};
SkinQuality measure(const SkinnedRegion& region);

}  // namespace batten
