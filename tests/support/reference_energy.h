// SPDX-License-Identifier: MPL-2.0
// Energies from whole matrices: reference implementation for the energies that a session tracks.
#pragma once

#include "batten/elements/reference_triangle.h"
#include "batten/fem/surface_assembler.h"

namespace batten {

/// Energies of dofs q (n×3) for a material on the domain of the assembler's mesh.
inline SurfaceEnergy energy(const SurfaceAssembler& assembler, const SurfaceStiffness& material,
                            const Points& q) {
  const auto cost = [&](const SurfaceStiffness& part) {
    const SparseMatrix K = assembler.stiffness(part);
    return 0.5 * q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
  };
  return {cost({material.alpha, Vec3::Zero()}),
          cost({Mat2::Zero(), material.beta, material.beta_mixed})};
}

}  // namespace batten
