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

/// Gravity load F = ∬ N ρ t a dA for an acceleration a, with the shape functions N, density ρ and
/// thickness t. `sections`: one for all triangles, or one per triangle of the model's mesh.
Points gravity_load(const ModelLayout& model, const Points& shape,
                    const std::vector<ShellSection>& sections, const Vec3& acceleration);

/// Load vector of a force per length along a curve, or along the part of the curve in a box. Throws
/// InputError if the curve does not exist (the message suggests the closest name), EmptyPartError
/// if the box contains no part of the curve.
Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const Vec3& per_length, const std::optional<Box3>& box = {});

/// Load vector of a moment per length about the tangent of a curve, right-handed. On a curve shared
/// by several regions, it is applied to the first one. Throws the same exceptions as line_force().
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

}  // namespace batten
