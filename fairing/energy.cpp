#include "batten/fairing/energy.h"

namespace batten {

SurfaceStiffness on_unit_domain(const SurfaceStiffness& material, LoadUnits units, double size) {
  SurfaceStiffness scaled = material;
  if (units == LoadUnits::Absolute) {
    scaled.beta /= size * size;
    scaled.beta_mixed /= size * size;
  }
  return scaled;
}

SurfaceEnergy energy(const SurfaceAssembler& assembler, const SurfaceStiffness& material,
                     const Points& q) {
  const auto cost = [&](const SurfaceStiffness& part) {
    const SparseMatrix K = assembler.stiffness(part);
    return q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
  };
  return {cost({material.alpha, Vec3::Zero()}),
          cost({Mat2::Zero(), material.beta, material.beta_mixed})};
}

}  // namespace batten
