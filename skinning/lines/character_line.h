// Character lines: the user's curves that define a surface, and their smooth segments.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// A C1 cubic curve that represents a line without any further fitting, shared by the regions on
/// both sides. Their meshes have vertices at the same points of it.
struct PrescribedCurve {
  HermiteCurve curve;  ///< in the direction of the line, with an almost uniform parametrisation
  /// Parameters of the mesh vertices on it, for a region in which it is edge-aligned. Ascending,
  /// from start to end; they include the nodes of the curve.
  std::vector<double> vertices;
};

/// A character line: a curve that the surface must contain, as given by the user.
struct CharacterLine {
  enum class Role {
    Outline,  ///< part of the loop around the region, or of one of the two loops of an annulus
    Hole,     ///< part of a loop around a hole
    Inner     ///< inside the region, or from side to side
  };
  /// How the mesh represents the line (docs/theory/domains.md).
  enum class MeshAlignment {
    Auto,  ///< edge-aligned if the domain permits a straight chain of edges, otherwise embedded
    EdgeAligned,  ///< conforming: a straight chain of element edges, exactly on the line
    Embedded      ///< immersed: imposed at collocation points; the gap between them is measured
  };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
  MeshAlignment mesh_alignment = MeshAlignment::Auto;
  /// The prescribed curve of an outline or hole line, or null. In a loop either all lines have one
  /// or none. Two prescribed curves meet in a corner unless their slopes are the same vector.
  std::shared_ptr<const PrescribedCurve> prescribed = {};
  /// For a hole line: false if the line only trims the surface and does not constrain it. Then the
  /// trim follows the points of the surface closest to the given line.
  bool constrains_surface = true;
};

// Splits input lines into the smooth segments that become C1 cubic curves.

/// A part of an input curve without interior corners, in either direction.
struct SmoothSegment {
  /// The line's name, followed by ".1", ".2", … if the line was split at corners.
  std::string name;
  CharacterLine::Role role;
  /// The segment in its own direction; the prescribed curve, if the line has one.
  std::shared_ptr<const InputCurve> curve;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  std::shared_ptr<const PrescribedCurve> prescribed = {};  ///< in the direction of the line
  std::shared_ptr<const InputCurve> input = {};            ///< with `prescribed`: the user's curve
  bool constrains_surface = true;

  /// Converts the segment to a line in the user's direction. `flipped`: `curve` runs against it.
  CharacterLine line(bool flipped) const;
  /// The prescribed curve in the direction of `curve`. `flipped`: `curve` runs against the user's
  /// line.
  HermiteCurve prescribed_along(bool flipped) const;
};

/// Splits a line at its corners; a line with a prescribed curve stays whole. `corner_angle`:
/// degrees. Throws InputError for a curve of zero length or with non-finite points. Also for a
/// prescribed curve with interior corners, or whose vertices do not ascend from start to end or do
/// not include its nodes.
std::vector<SmoothSegment> split_at_corners(const CharacterLine& line, double corner_angle);

/// The part of a curve between two parameters, from < to.
std::shared_ptr<const InputCurve> subcurve(std::shared_ptr<const InputCurve> curve, double from,
                                           double to);
/// The curve in the opposite direction.
std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve);

/// Converts a curve whose end coincides with its start, in position and slope, to a closed one.
HermiteCurve as_closed_curve(const HermiteCurve& curve);

/// Uses piecewise cubic input unchanged if possible (exact_curve()). Conditions: it is open; its
/// speed is even (fastest/slowest ≤ 3); no segment is shorter than `shortest`, unless it is the
/// only one; and its ends are within 1e-8 of its length from `start` and `end`, to which they are
/// then moved. Returns nullopt otherwise.
std::optional<HermiteCurve> reuse_cubic_input(const SmoothSegment& segment, double shortest,
                                              const Vec3& start, const Vec3& end);

/// Distances of points from one curve, by sampling (once) and Newton's method. Keeps a reference to
/// the curve.
class CurveDistance {
 public:
  explicit CurveDistance(const InputCurve& curve);
  double operator()(const Vec3& p) const;

 private:
  const InputCurve& curve_;
  std::vector<double> t_;
  std::vector<Vec3> x_;
};

}  // namespace batten
