// SPDX-License-Identifier: MPL-2.0
// The boundary of a model face, split into the segments that become edges of a CAD face.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "batten/core/bilinear_map.h"
#include "batten/core/geometry.h"
#include "batten/io/step/step_plan.h"

namespace batten {

/// A smooth segment of the boundary, oriented along its loop.
struct FaceBoundarySegment {
  /// In space and in the (u, v) of FaceBoundary, over the same parameter range.
  HermiteCurve curve, pcurve;
  std::string line;       ///< name of its curve
  bool reversed = false;  ///< true if the loop traverses the curve backwards
  /// Parameter on the curve = shift + scale · parameter on the segment.
  double shift = 0, scale = 1;
  bool shared = false;  ///< true if the curve has more than one adjacent side
  /// Corrections to add to the surface's unit normal to get the common target normal of both
  /// adjacent faces, at evenly spaced parameters. nullopt where the surfaces meet at an angle.
  /// Empty until find_tangent_joins() sets them.
  std::vector<std::optional<Vec3>> normal_corrections = {};

  Vec2 uv(double t) const { return drop_z(pcurve.evaluate(t)); }
  Vec2 first() const { return drop_z(pcurve.position(0)); }
  Vec2 last() const { return drop_z(pcurve.evaluate({pcurve.segment_count() - 1, 1.0})); }
  double line_parameter(double t) const { return shift + scale * t; }
  /// Linear interpolation of `normal_corrections`; nullopt if one of the two neighbours is.
  std::optional<Vec3> normal_correction(double t) const;
};
/// The segments of one closed boundary loop, in order.
using FaceLoop = std::vector<FaceBoundarySegment>;

/// All boundary loops of a model face.
///
/// The parameters (u, v) are those of the model face, except if its domain is a convex quadrilateral
/// without holes. Then they are coordinates on a rectangle that is mapped bilinearly onto it, so that
/// the sides are isoparametric curves: the knots of a tensor-product spline can become dense along
/// them, for example along the leading edge of a swept wing.
struct FaceBoundary {
  std::vector<FaceLoop> loops;  ///< for an annulus, the first two form one wire with the seam
  std::optional<BilinearMap> to_domain;  ///< from the rectangle to the domain of the model face
  double period = 0;  ///< of the mesh in u; 0 if the model face is not an annulus
  double seam = 0;    ///< u of the annulus's seam
  DomainLoops domain;

  /// How the two boundary circles of an annulus are handled. AtSeam: they start at the seam of (u,
  /// v) and are cut there. Whole: they are not cut.
  enum class AnnulusBoundary { AtSeam, Whole };

  /// Splits the model face's curves at corners and at the cuts of `common`. The boundary circles of
  /// an annulus are also split at the seam (AnnulusBoundary::AtSeam). Throws InputError as
  /// write_step_faces() does for invalid boundaries, and for a curve without a name if `common` is
  /// given.
  explicit FaceBoundary(const SkinnedRegion& region, const StepPlan* common = nullptr,
                        AnnulusBoundary boundary_cut = AnnulusBoundary::AtSeam);

  /// True if (u, v) lies inside the boundary.
  bool contains(Vec2 uv) const;
  /// The parameters of the model face at (u, v), and the reverse.
  Vec2 domain_point(const Vec2& uv) const { return to_domain ? to_domain->at(uv) : uv; }
  Vec2 parameters(const Vec2& at) const { return to_domain ? to_domain->inverse(at) : at; }
  /// Adds to the plan the interior parameters at which this boundary cuts its curves.
  void add_cuts(StepPlan& plan) const;

 private:
  void unroll(const std::string& name);
  void map_quadrilateral();
};

/// Adds to the plan the cuts that the boundaries of these model faces make, so that all model faces
/// cut their curves at the same points. Boundary circles of the model faces in `whole` are not cut.
/// Throws InputError as FaceBoundary does.
void cut_lines(StepPlan& plan, const std::vector<const SkinnedRegion*>& regions,
               const std::set<const SkinnedRegion*>& whole = {});

}  // namespace batten
