// Stresses of a shell, recovered from its displacement, and how sure they are.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/analysis/models/shell_model.h"

namespace batten {

/// Symmetric tensors in the tangent plane at one place, in space.
struct ShellStress {
  Mat3 forces = Mat3::Zero();   ///< N, force per length
  Mat3 moments = Mat3::Zero();  ///< M, moment per length; stretches the top where positive
  double thickness = 0;

  /// Stress at a height above the middle surface, as a share of half the thickness: 1 is the top,
  /// where the normal points, -1 the bottom. σ = N/t + height · 6 M/t²
  Mat3 at(double height) const {
    return forces / thickness + height * 6 / (thickness * thickness) * moments;
  }
};

/// The equivalent stress √(σ1² - σ1 σ2 + σ2²) of a plane stress.
double von_mises(const Mat3& stress);
/// The principal stresses σ1 ≥ σ2 of a plane stress.
std::array<double, 2> principal(const Mat3& stress);

/// Stresses jump a little from element to element. Here they are taken at the centroids of the
/// three cubics of each triangle (Z12: of the same sub-triangles), and a quadratic over (u, v) is
/// fitted to those around each vertex (Zienkiewicz and Zhu 1992): never across lines of regions, so
/// that jumps at creases and steps of thickness stay. Inside of a triangle its three quadratics are
/// blended. O(triangles), on all threads; error() and missing() as much again. Keeps references to the
/// shell and to q.
class ShellStresses {
 public:
  ShellStresses(const ShellModel& shell, const Points& q);

  /// At a place of the model's mesh.
  ShellStress at(const Location& where) const;
  /// What the elements themselves have there, without recovery.
  ShellStress raw(const Location& where) const;

  /// √(energy of the stresses' jumps / energy): the relative error in energy norm by Zienkiewicz and
  /// Zhu (1987), by the rule of the stiffness, which also sees the false membrane forces of elements
  /// that lock. The error of a displacement under its own load is about its square.
  double energy_norm_error() const;
  /// What is missing of a goal Gᵀq, about: the work of these jumps with those of `adjoint`, the
  /// stresses of ShellModel::adjoint(G) on the same shell (Oden and Prudhomme 2001).
  double goal_error(const ShellStresses& adjoint) const;
  /// The same of each triangle: where smaller elements pay.
  VecX goal_error_per_triangle(const ShellStresses& adjoint) const;

  /// The largest equivalent stress at a vertex inside, top or bottom.
  struct Peak {
    double value = 0;
    double height = 1;  ///< 1: top, -1: bottom
    double spread = 0;  ///< largest difference of the raw stresses around from it
    Location where;
    Vec3 at = Vec3::Zero();
  };
  Peak peak() const { return peak_; }

 private:
  static constexpr int kParts = 12;  // six of N, six of M
  using Parts = Eigen::Matrix<double, kParts, 1>;
  struct Sample {
    Location where;
    double weight;  // area of the surface
    Parts parts;
  };
  // Of one vertex: a quadratic of the place relative to it.
  struct Polynomial {
    Eigen::Matrix<double, 6, kParts> coefficients;
    double size = 0;
  };
  using Monomials = Eigen::Matrix<double, 6, 1>;
  static Monomials monomials(const Vec2& d, double size);
  void take_samples();
  std::vector<std::vector<int>> patches() const;
  void fit();
  // Of each triangle: the work of these jumps with those of `adjoint`, and of the own stresses.
  struct Energies {
    VecX goal_error, all;
  };
  Energies energies(const ShellStresses& adjoint) const;
  ShellStress at(const Location& where, const Vec3& normal) const;
  void find_peak();
  ShellStress stress_of(const Parts& parts, const Vec3& normal, double thickness) const;

  const ShellModel& shell_;
  const Points& q_;
  std::vector<std::vector<Sample>> samples_;            // of each triangle
  std::vector<std::optional<Polynomial>> at_vertices_;  // none where nothing is inside
  Peak peak_;
};

}  // namespace batten
