// SPDX-License-Identifier: MPL-2.0
// The input curves that define a surface (character lines), their smooth segments, and their
// samples for fairing.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

struct CurveSamples;  // fairing/curves/staged_fairing.h

/// A C1 cubic curve that replaces an input curve, which is then not fitted. The faces on both sides
/// share the curve, and their meshes have vertices at the same points of the curve.
struct PrescribedCurve {
  /// The C1 cubic curve, in the direction of the input curve, with an almost uniform
  /// parametrisation.
  HermiteCurve curve;
  /// Parameters of `curve` at the mesh vertices of faces in which the curve is mesh-aligned:
  /// ascending, from start to end, including the ends of all its cubic pieces.
  std::vector<double> vertices;
};

/// An input curve that the surface must contain, with its role and its options.
struct CharacterLine {
  enum class Role {
    Outline,  ///< part of the loop around the face, or of one of the two loops of an annulus
    Hole,     ///< part of a loop around a hole
    Inner     ///< curve inside the face, or across it from side to side
  };
  /// How the mesh represents the curve (docs/theory/domains.md).
  enum class MeshAlignment {
    Auto,  ///< mesh-aligned if the domain permits a straight chain of edges, otherwise embedded
    EdgeAligned,  ///< conforming: a straight chain of element edges, exactly on the curve
    Embedded      ///< immersed: the surface contains the curve at collocation points only
  };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
  MeshAlignment mesh_alignment = MeshAlignment::Auto;
  /// C1 cubic curve that replaces `curve` exactly, or null; only for outlines and holes. Within a
  /// loop, either all curves have a prescribed curve, or none of them. Two prescribed curves meet
  /// at a corner unless their derivative vectors are equal there.
  std::shared_ptr<const PrescribedCurve> prescribed = {};
  /// True: the surface must contain the curve. False: the curve bounds a hole, but only trims the
  /// surface and does not constrain it. The trim then follows the points of the surface closest to
  /// the curve.
  bool constrains_surface = true;
};

// Smooth segments of input curves, each of which becomes a C1 cubic curve.

/// A part of an input curve without interior corners, in the direction of the input curve or
/// against it.
struct SmoothSegment {
  /// Name of the input curve, followed by ".1", ".2", … if the curve was split at corners.
  std::string name;
  CharacterLine::Role role;
  /// Geometry in the direction of the segment: the part of the input curve or, if the input curve
  /// has a prescribed curve, that curve.
  std::shared_ptr<const InputCurve> curve;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  /// Prescribed curve (CharacterLine::prescribed), in the direction of the input curve, or null.
  std::shared_ptr<const PrescribedCurve> prescribed = {};
  /// The input curve if `prescribed` is set, otherwise null.
  std::shared_ptr<const InputCurve> input = {};
  bool constrains_surface = true;  ///< value of CharacterLine::constrains_surface
  /// True if the input curve has a corner at the start (end) of the segment.
  std::array<bool, 2> at_corner = {false, false};

  /// Converts the segment to a CharacterLine in the direction of the input curve. `flipped`: true
  /// if the segment runs against the input curve.
  CharacterLine line(bool flipped) const;
  /// The curve `prescribed` in the direction of the segment. `flipped`: true if the segment runs
  /// against the input curve.
  HermiteCurve prescribed_along(bool flipped) const;
};

/// Splits an input curve at its corners, unless it has a prescribed curve. `corner_angle`: smallest
/// change of direction that counts as a corner, degrees. Throws InputError if the curve has zero
/// length or points that are not finite, or if a prescribed curve has interior corners. Also throws
/// InputError if the vertices of a prescribed curve do not ascend from start to end, or do not
/// include the ends of all its cubic pieces.
std::vector<SmoothSegment> split_at_corners(const CharacterLine& line, double corner_angle);

/// The part of a curve between the parameters `from` < `to`.
std::shared_ptr<const InputCurve> subcurve(std::shared_ptr<const InputCurve> curve, double from,
                                           double to);
/// The curve in the opposite direction.
std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve);

/// Converts an open curve into a closed one. The end of the curve must coincide with the start, in
/// position and slope.
HermiteCurve as_closed_curve(const HermiteCurve& curve);

/// Converts a piecewise cubic segment to a HermiteCurve without approximation (exact_curve()), if
/// the following conditions hold: the segment is open; the ratio of the largest to the smallest
/// parametric speed is at most 3; no cubic piece is shorter than `shortest` (model units), unless
/// it is the only one; and the ends are within 1e-8 of the arc length from `start` and `end`, to
/// which they are then moved. Returns nullopt otherwise.
std::optional<HermiteCurve> reuse_cubic_input(const SmoothSegment& segment, double shortest,
                                              const Vec3& start, const Vec3& end);

/// Computes distances of points from a curve in model units, by Newton's method from samples that
/// the constructor computes. The curve must outlive this object.
class CurveDistance {
 public:
  explicit CurveDistance(const InputCurve& curve);
  double operator()(const Vec3& p) const;

 private:
  const InputCurve& curve_;
  std::vector<double> t_;
  std::vector<Vec3> x_;
};

// Samples of curves for fairing.

/// Samples a curve for fair_in_stages(), at equal steps of arc length between its corners.
///
/// The curve gets about 200 points, divided among its segments in proportion to their arc lengths,
/// but each segment gets at least eight points per span between its breaks (InputCurve::breaks()).
/// CurveSamples::extra_points contains three additional points between any two adjacent points. The
/// last point of a closed curve equals the first one.
///
/// `corner_angle`: smallest change of direction that counts as a corner, degrees; see
/// corner_angle_of(). CharacterLine::prescribed is ignored. Throws InputError if the curve has zero
/// length or points that are not finite.
CurveSamples sample_line(const CharacterLine& line, double corner_angle);

}  // namespace batten
