// Lines that carry the design of a surface.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/input_curve.h"
#include "batten/fairing/curves/curve_fit.h"

namespace batten {

/// A C1 cubic curve that is used for a line as it is, so that the regions on both sides carry the
/// same one: it is not fitted again, and their meshes have vertices on it at the same places.
struct PrescribedCurve {
  HermiteCurve curve;  ///< over the direction of the line; its parameter runs evenly
  /// Parameters of the mesh's vertices on it, for a region that has it fitted: ascending, from
  /// start to end, with the nodes of the curve among them.
  std::vector<double> vertices;
};

/// A line, as the user gives it.
struct CharacterLine {
  enum class Role {
    Outline,  ///< part of the loop around the region, or of one of the two loops of a ring
    Hole,     ///< part of a loop around a hole
    Inner     ///< runs across the region, or inside of it
  };
  /// How the surface carries the line (docs/theory/domains.md).
  enum class MeshAlignment {
    Auto,         ///< fitted where the domain can have it as a straight run, otherwise embedded
    EdgeAligned,  ///< on a straight run of element edges: the surface is exactly on the line
    Embedded      ///< across the elements: held at points, the gap between them is measured
  };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
  MeshAlignment mesh_alignment = MeshAlignment::Auto;
  /// The given curve of an outline or hole line, or null. Either all lines of a loop have one or
  /// none has. Two of them that meet make a corner unless their slopes are the same vector.
  std::shared_ptr<const PrescribedCurve> prescribed = {};
  /// False, of a hole line: it trims the surface and does not hold it. Its place on the surface is
  /// nearest to where it was drawn; where that is in space, the surface says.
  bool constrains_surface = true;
};


// Cuts input lines into the stretches that become C1 cubic curves.

/// A stretch is a part of an input curve that has no corners inside, in one direction or the other.
struct SmoothSegment {
  std::string name;  ///< the line's, with ".1", ".2", … when the line was cut at corners
  CharacterLine::Role role;
  /// The stretch, in its own direction; the given curve, of a line that has one.
  std::shared_ptr<const InputCurve> curve;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  std::shared_ptr<const PrescribedCurve> prescribed = {};  ///< in the direction of the line
  std::shared_ptr<const InputCurve> input = {};  ///< with `prescribed`: the line's own curve
  bool constrains_surface = true;

  /// Returns the stretch as a line in the user's direction. `flipped`: `curve` runs against it.
  CharacterLine line(bool flipped) const;
  /// Returns the given curve in the direction of `curve`.
  HermiteCurve prescribed_along(bool flipped) const;
};

/// Cuts lines at their corners; those with a given curve stay whole. Throws InputError: a curve of
/// zero length, or not finite; a given curve with corners, or whose vertices do not ascend from its
/// start to its end with its nodes among them.
std::vector<SmoothSegment> split_at_corners(const CharacterLine& line, double corner_angle);

/// Returns a curve from one parameter to a later one.
std::shared_ptr<const InputCurve> subcurve(std::shared_ptr<const InputCurve> curve, double from,
                                           double to);
/// Returns the curve run backwards.
std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve);

/// Returns a curve that ends where and as it starts as a closed one, without an end.
HermiteCurve as_closed_curve(const HermiteCurve& curve);

/// Returns the input itself when it is piecewise cubic (exact_curve) and open, of even enough speed
/// (fastest/slowest ≤ 3), with no segment shorter than `shortest` unless it is the only one, and
/// ends within 1e-8 of its length from `start` and `end`, to which they are moved. Nothing
/// otherwise.
std::optional<HermiteCurve> reuse_cubic_input(const SmoothSegment& segment, double shortest,
                                              const Vec3& start, const Vec3& end);

/// The smallest distances of points from one curve, by samples, which are taken once, and Newton's
/// method. It keeps a reference to the curve.
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
