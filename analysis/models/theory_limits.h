// SPDX-License-Identifier: MPL-2.0
// Estimates of what the linear theory of thin shells neglects.
#pragma once

#include "batten/analysis/models/shell_model.h"
#include "batten/analysis/models/shell_stresses.h"

namespace batten {

/// Estimated relative change of the displacements q, if they are not assumed to be small: the first
/// correction of the load-displacement curve in the direction of q.
///
/// With the quadratic part e = ½ U,α · U,β of the Green-Lagrange membrane strains, the strain energy of
/// s q is s² E₂ + s³ E₃ + s⁴ E₄, so that the linear displacement changes by (3 E₃ + 4 E₄)/(2 E₂):
///
///     E₃ = ½ qᵀ G q,     E₄ = min_v ½ ∬ (e + ε(v)) · t A (e + ε(v)) dA + bending energy of v
///
/// G: geometric stiffness of q. E₄ is the membrane energy that remains if displacements v follow: it
/// vanishes for strips that bend freely, but not for plates whose edges cannot move. Example: a clamped
/// disc of thickness t, whose middle moves by w, has 0.47 (w/t)² [Timoshenko1959]. Above about 0.1, the
/// linear solution is inaccurate.
///
/// `energy`: strain energy of q. Cost: an assembly of G, and one pair of triangular solves. Returns 0
/// without energy.
double nonlinearity(const ShellModel& shell, const Points& q, double energy,
                    const ShellTemperature& temperature = {});

/// Energy of the transverse shear that the theory of thin shells neglects, ½ ∬ V²/(5/6 G t) dA, with
/// the shear forces V_α = M_αβ,β of the recovered moments and the shear modulus G (of laminates, the
/// harmonic mean of the in-plane moduli of the plies). Divided by the strain energy, it estimates by how
/// much the displacements are too small. The energy of a triangle is limited to its bending energy: within a
/// thickness of a singular point, the shear forces of the theory have no meaning. Triangles that the
/// trim cuts are left out. O(triangles).
double transverse_shear_energy(const ShellAssembler& shell, const ShellStresses& stresses);

}  // namespace batten
