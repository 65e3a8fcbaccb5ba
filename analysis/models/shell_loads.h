// SPDX-License-Identifier: MPL-2.0
// Loads on the shell of a model, and their resultants.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Each of the following functions returns a load vector F, n×3 over the dofs of the model; its work
// with a displacement q is Σ F_m · q_m. `shape`: absolute dofs of the middle surface. Load vectors
// can be added.

/// Force per area at a point x of the surface with unit normal n = x_u × x_v / |x_u × x_v|.
using SurfaceTraction = std::function<Vec3(const Vec3& x, const Vec3& n)>;

/// Load vector F = ∬ N f(x, n) dA of a surface traction f over a part of the surface, with the
/// shape functions N. A pressure p along the normal is f = p n. Quadrature has degree 6 or higher;
/// f is called on one thread. Throws InputError if a region is out of range, EmptyPartError if the
/// box contains no point of the surface.
Points surface_traction(const ModelLayout& model, const Points& shape, const SurfaceTraction& force,
                        const ShellPart& part = {});

/// A pressure along the normal at a point, and its gradient in space.
struct PressureAt {
  double value = 0;
  Vec3 gradient = Vec3::Zero();
};

/// Stiffness of a pressure p that follows the surface (follower load): change of its load vector F
/// with the displacement U, made symmetric,
///
///     S = (A + Aᵀ)/2,   A u = dF = ∬ N (p (U_u × x_v + x_u × U_v) + (∇p · U) x_u × x_v) du dv
///
/// as a 3n×3n matrix over [x; y; z], lower triangle. In a linear buckling analysis, it is
/// subtracted from the geometric stiffness. The part that is not symmetric is an integral along the
/// boundary of the loaded part; it vanishes where p = 0 or the boundary is fixed [Hibbitt1979].
/// Same quadrature and exceptions as surface_traction().
SparseMatrix follower_stiffness(const ModelLayout& model, const Points& shape,
                                const std::function<PressureAt(const Vec3& x)>& pressure,
                                const ShellPart& part = {});

/// Acceleration at a point of space.
using AccelerationField = std::function<Vec3(const Vec3& x)>;

/// Load F = ∬ N ρ t a dA of an acceleration a(x), with the shape functions N, density ρ and thickness
/// t. `sections`: one for all triangles, or one per triangle of the model's mesh.
Points body_load(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const AccelerationField& acceleration);
/// body_load() of a constant acceleration.
Points gravity_load(const ModelLayout& model, const Points& shape,
                    const std::vector<ShellSection>& sections, const Vec3& acceleration);

/// Force per length at a point x of a curve.
using LineTraction = std::function<Vec3(const Vec3& x)>;

/// Load vector of a force per length along a curve, or along the part of the curve in a box. Throws
/// InputError if the curve does not exist (the message suggests the closest name), EmptyPartError
/// if the box contains no part of the curve.
Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const LineTraction& per_length, const std::optional<Box3>& box = {});
/// line_force() of a constant force per length.
Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const Vec3& per_length, const std::optional<Box3>& box = {});

/// Intensity per length at a point x of a curve.
using LineIntensity = std::function<double(const Vec3& x)>;

/// Load vector of a force per length on an edge of the shell, in the tangent plane and perpendicular
/// to the edge; positive values pull, away from the face. Throws the same exceptions as
/// line_force(), and InputError for a curve that is not the edge of exactly one face.
Points edge_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const LineIntensity& per_length, const std::optional<Box3>& box = {});
/// edge_force() of a constant force per length.
Points edge_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  double per_length, const std::optional<Box3>& box = {});

/// A load of given resultant, spread evenly over a curve or a part of the surface.
///
/// The force per length or area is f(x) = F / A + ω × (x - c), with the size A (length or area) and
/// the centroid c of the part. ω follows from ∬ (x - c) × (ω × (x - c)) dA = M, so that the resultant
/// is the force F at the centroid and the moment M: the load of a rigid part with weights (RBE3) in
/// a finite-element deck. `load`: makes the load vector of a force per length or area. Throws
/// InputError for a moment about the direction of a straight curve.
Points spread_load(const ModelLayout& model, const Points& shape,
                   const std::function<Points(const LineTraction& f)>& load, const Vec3& force,
                   const Vec3& moment);

/// Load vector of a moment per length about the tangent of a curve, right-handed. On a curve shared
/// by several regions, it is applied to the first one. Throws the same exceptions as line_force().
Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   const LineIntensity& per_length, const std::optional<Box3>& box = {});
/// line_moment() of a constant moment per length.
Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   double per_length, const std::optional<Box3>& box = {});

/// Point of the shell surface at which a force or a support acts.
struct ShellLocation {
  ModelPoint at;
  Location where;       ///< location in the mesh of the model
  double distance = 0;  ///< distance from the point passed to nearest_location()
};
/// Point of the surface nearest to p, inside of the trims of the model.
ShellLocation nearest_location(const ModelLayout& model, const Points& shape, const Vec3& p);

/// Load vector of a point force at a location of the shell.
Points point_force(const ModelLayout& model, const ShellLocation& position, const Vec3& force);

/// Resultant of a load: total force, and moment about the origin.
struct Resultant {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
};
/// Computes the resultant of a load vector F (n×3) on the middle surface with dofs `shape`.
Resultant resultant(const ModelLayout& model, const Points& shape, const Points& F);

/// Magnitudes of a load: sums that do not cancel, Σ |F_m| over the position dofs m, and
/// Σ |(x_m - c) × F_m| over all dofs, with c = centre() for position dofs and 0 for derivatives.
struct ForceMagnitudes {
  double force = 0, moment = 0;
};
/// The magnitudes of a load vector F (n×3) on the middle surface with dofs `shape`.
ForceMagnitudes magnitudes(const ModelLayout& model, const Points& shape, const Points& F);

/// Mean of the vertex positions of a middle surface with dofs `shape`.
Vec3 centre(const ModelLayout& model, const Points& shape);

}  // namespace batten
