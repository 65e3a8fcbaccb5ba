// SPDX-License-Identifier: MPL-2.0
// Stress recovery of a shell from its displacement, with error estimates.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/analysis/models/shell_model.h"
#include "batten/analysis/shell_stress.h"

namespace batten {

/// A ball around a point at which stresses are singular, such as a re-entrant corner or a point force.
struct SingularPlace {
  Vec3 at = Vec3::Zero();
  double radius = 0;  ///< model units
  bool contains(const Vec3& x) const { return (x - at).norm() <= radius; }
};

/// Recovered stresses of a shell: superconvergent patch recovery ([ZienkiewiczZhu1992]).
///
/// Raw stresses jump between elements. They are evaluated at the centroids of the three cubics of
/// each triangle (Z12: of the same sub-triangles), and a quadratic in (u, v) is fitted to those
/// around each vertex. Patches never extend across the curves between regions, so that stress jumps
/// at creases and thickness steps are preserved. Inside a triangle, the three quadratics of its
/// vertices are blended.
///
/// Cost: O(triangles), on all threads; energy_norm_error() and goal_error() cost as much again. The
/// constructor reports the stage "stresses" to the current ProgressScope.
/// Keeps references to the shell (its assembler), to q and to the temperature.
class ShellStresses {
 public:
  /// Recovers the stresses of the displacement q (n×3) at a temperature.
  ShellStresses(const ShellModel& shell, const Points& q, const ShellTemperature& temperature);
  /// The same without a change of temperature.
  ShellStresses(const ShellModel& shell, const Points& q);
  /// The same for a shell without supports and factorization.
  ShellStresses(const ShellAssembler& shell, const Points& q, const ShellTemperature& temperature);
  ShellStresses(const ShellAssembler& shell, const Points& q);

  /// Recovered stress at a location of the model's mesh.
  ShellStress at(const Location& where) const;
  /// Raw stress of the finite element solution at a location, without recovery.
  ShellStress raw(const Location& where) const;

  /// Estimated relative error in the energy norm ([ZienkiewiczZhu1987]): √(energy of the stress
  /// errors / energy). The stress error is the recovered stress minus the raw one. It is integrated
  /// by the quadrature of the stiffness, which also captures the spurious membrane forces of
  /// locking elements. The relative error of a displacement under its own load is about the square
  /// of this estimate.
  double energy_norm_error() const;
  /// Strain energy: the complementary energy of the raw stresses, without stress-free thermal strains.
  double energy() const;
  /// Estimated error of a goal functional Gᵀq ([OdenPrudhomme2001]): the work of the stress errors
  /// (recovered minus raw stress) on the strain errors of `adjoint`, integrated over the shell.
  /// `adjoint`: the stresses of the adjoint solution ShellModel::adjoint(G) on the same shell.
  double goal_error(const ShellStresses& adjoint) const;
  /// Contributions of the triangles to goal_error(), for adaptive refinement.
  VecX goal_error_per_triangle(const ShellStresses& adjoint) const;

  /// Largest von Mises stress at the top or bottom of the shell, in laminates of any ply: the largest
  /// at a vertex and, from there, a local maximum in the triangles around it; in triangles that the boundary loops cut, at
  /// sampling points and at Trim::boundary_points().
  struct Peak {
    double value = 0;
    /// Height at which the peak occurs, relative to half of the thickness; 1 is the top, -1 the bottom.
    double height = 1;
    int ply = 0;        ///< of a laminate, from 0, from the bottom
    double spread = 0;  ///< largest deviation of the surrounding raw stresses from `value`
    Location where;
    Vec3 at = Vec3::Zero();
  };
  Peak peak() const { return peak_; }
  /// The largest stress outside of `places`; peak() if they cover the whole shell.
  Peak largest_outside(const std::vector<SingularPlace>& places) const;
  /// The smallest reserve factor of the plies, sought at the vertices and, in cut triangles, at
  /// sampling points. nullopt: no material has strengths, or there is no stress.
  struct Reserve {
    double factor = 0, height = 0;
    int ply = 0;
    Location where;
    Vec3 at = Vec3::Zero();
  };
  std::optional<Reserve> smallest_reserve_factor(FailureCriterion criterion) const;

 private:
  static constexpr int kParts = 12;  // six of the membrane forces, six of the moments
  using Parts = Eigen::Matrix<double, kParts, 1>;
  struct Sample {
    Location where;
    double weight;  // area of the surface
    Parts parts;
  };
  // Quadratic in the (u, v) position relative to a vertex, fitted to the stresses around the
  // vertex.
  struct Polynomial {
    Eigen::Matrix<double, 6, kParts> coefficients;
    double size = 0;
  };
  using Monomials = Eigen::Matrix<double, 6, 1>;
  static Monomials monomials(const Vec2& d, double size);
  void take_samples();
  std::vector<std::vector<int>> patches() const;
  void fit();
  // Per triangle: work of the stress jumps with those of `adjoint`, of the stresses themselves, and of
  // stresses that would prevent all thermal expansion.
  struct Energies {
    VecX goal_error, all, thermal;
  };
  Energies energies(const ShellStresses& adjoint) const;
  ShellStress at(const Location& where, const ShellPoint& point) const;
  /// Visits the vertices and, in cut triangles, the sampling points and points of the boundary.
  template <class Visit>
  void for_each_sample_location(const Visit& visit) const;
  /// The largest stress outside of `places`; a value of 0 if they cover the shell.
  Peak find_peak(const std::vector<SingularPlace>& places) const;
  ShellStress stress_of(const Parts& parts, const Location& where, const ShellPoint& point) const;
  TemperatureAt temperature_at(const Location& where) const {
    return shell_.temperature_at(temperature_, where.triangle, where.L);
  }
  ShellAssembler::Resultants resultants(const ShellPoint& point, int triangle, const Vec3& L,
                                        const DisplacementJet& jet) const {
    return shell_.resultants(triangle, L, point.strain(jet), temperature_at({triangle, L}));
  }

  const ShellAssembler& shell_;
  const Points& q_;
  const ShellTemperature& temperature_;
  std::vector<std::vector<Sample>> samples_;  // of each triangle
  // Empty if nothing around the vertex is inside.
  std::vector<std::optional<Polynomial>> at_vertices_;
  Peak peak_;
};

}  // namespace batten
