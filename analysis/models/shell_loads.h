// Loads on the shell of a model.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Each returns F, n×3 over the dofs of the model, whose work with a displacement q is Σ F_m · q_m.
// `shape`: absolute dofs of the middle surface. Sums of loads are loads.

/// Force per area of the surface at a place x with the unit normal n = x_u × x_v / |x_u × x_v|.
using SurfaceTraction = std::function<Vec3(const Vec3& x, const Vec3& n)>;

/// F = ∬ N f(x, n) dA over the inside of a part. A pressure p is f = p n (it pushes along the
/// normal). By quadrature, of degree 6 or better; f is called on one thread. Throws InputError for a
/// region out of range; EmptyPartError: a box that holds no place of the surface.
Points surface_traction(const ModelLayout& model, const Points& shape, const SurfaceTraction& force,
                        const ShellPart& part = {});

/// F = ∬ N ρ t a dA: the weight of the shell under an acceleration a. `sections`: one, or one for
/// each triangle of the model's mesh.
Points gravity_load(const ModelLayout& model, const Points& shape,
                    const std::vector<ShellSection>& sections, const Vec3& acceleration);

/// F of a force per length along a line, or along what of it lies in a box. Throws InputError: no
/// such line (with the nearest name); EmptyPartError: a box that holds nothing of it.
Points line_force(const ModelLayout& model, const Points& shape, const std::string& line,
                  const Vec3& per_length, const std::optional<Box3>& box = {});

/// F of a moment per length about the line's own direction, right-handed, on its first side. Throws
/// as line_force().
Points line_moment(const ModelLayout& model, const Points& shape, const std::string& line,
                   double per_length, const std::optional<Box3>& box = {});

/// A place of the surface, for forces and supports.
struct ShellLocation {
  ModelPoint at;
  Location where;       ///< in the mesh of the model
  double distance = 0;  ///< from the point that was asked for
};
/// The place inside of the model's trims that is nearest to p.
ShellLocation nearest_location(const ModelLayout& model, const Points& shape, const Vec3& p);

/// F of a force at one place.
Points point_force(const ModelLayout& model, const ShellLocation& position, const Vec3& force);

/// Resultant of a load: its force, and its moment about the origin.
struct Resultant {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
};
Resultant resultant(const ModelLayout& model, const Points& shape, const Points& F);

}  // namespace batten
