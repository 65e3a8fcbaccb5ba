// SPDX-License-Identifier: MPL-2.0
// Stiffeners of a shell: Kirchhoff rods along curves of the surface, in the shape functions of the shell.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_ties.h"
#include "batten/analysis/shell_section.h"
#include "batten/core/geometry.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Cross-section and material of a stiffener. The axes of the section are the normal n of the surface
/// and b = n × τ, with the tangent τ of the curve.
struct StiffenerSection {
  double young = 0, shear_modulus = 0;
  double density = 0, expansion = 0;
  double area = 0;
  double inertia = 0;          ///< second moment of area about b: for bending along the normal
  double lateral_inertia = 0;  ///< second moment of area about n: for bending in the tangent plane
  double torsion = 0;          ///< torsion constant J
  /// Height of the centroid above the reference surface of the shell, along n.
  double eccentricity = 0;
  /// Fibres of the section at which stresses are evaluated: positions (along n, along b) relative to
  /// the centroid; empty: no stresses.
  std::vector<Vec2> fibres = {};

  /// A rectangle of width b and height h. Throws InputError unless both are above 0, as the following
  /// functions do for their dimensions.
  static StiffenerSection rectangle(double width, double height);
  static StiffenerSection circle(double radius);
  /// A tube with the outer radius.
  static StiffenerSection tube(double radius, double wall);
  /// A T: its web stands on the shell and has the height up to the flange.
  static StiffenerSection tee(double web_height, double web_thickness, double flange_width,
                              double flange_thickness);

  /// The same section on one side of a shell: the foot of the section, at `foot` below its centroid,
  /// touches the shell's surface at the height `surface` above the reference surface. `side`: 1 along
  /// the normal, -1 against it.
  StiffenerSection on_side(double side, double surface) const;
  double foot = 0;  ///< distance of the centroid from the foot of the section
};

/// A stiffener along a curve of the model.
struct Stiffener {
  std::string name;  ///< names the stiffener in results
  std::string line;  ///< name of the curve
  StiffenerSection section;
};

/// Stress resultants of a stiffener at a point: the axial force, the bending moments about b and n, and
/// the torque. Positive `bending` stretches fibres along n, positive `lateral_bending` those against b.
struct StiffenerForces {
  double axial = 0, bending = 0, lateral_bending = 0, torque = 0;
};

/// Largest values of one stiffener.
struct StiffenerResult {
  std::string name;
  double largest_stress = 0;  ///< largest axial stress of a fibre, with its sign
  Vec3 stress_at = Vec3::Zero();
  StiffenerForces least, largest;  ///< of all points, component by component
};

/// The stiffeners of a shell of one shape. With the displacement U of the surface, the rotation φ of
/// the shell (of its normal, and of the tangent of the curve about the normal) and the centroid line
/// x + e n, whose displacement is U + e φ × n:
///
///     E = ½ ∫ (EA ε² + EI_b κ_b² + EI_n κ_n² + GJ κ_τ²) ds,   ε = τ · (U + e φ × n),s,   κ = φ,s
///
/// with s along the centroid line. Rigid motions cost nothing. Warping of the section is neglected.
/// The energies are ShellSprings at quadrature points, four per point. If the curve is common to several
/// faces, the stiffener belongs to the first one, to which the others are tied.
class Stiffeners {
 public:
  Stiffeners() = default;
  /// Throws InputError if a curve does not exist, the surface is singular along it, or a section has a
  /// modulus or an area that is not above 0, or another property that is below 0 or not finite.
  Stiffeners(const ModelLayout& model, const Points& shape, std::vector<Stiffener> stiffeners);

  bool empty() const { return points_.empty(); }
  /// Adds the stiffness to the springs of a shell.
  void add_to(ShellSprings& springs) const;
  /// Adds the mass ∫ ρ A N Nᵀ ds of one coordinate to that of the shell (lower triangle, n×n).
  void add_mass(SparseMatrix& M) const;
  /// Total mass.
  double mass() const;
  /// Load vector (n×3) of an acceleration.
  Points body_load(const std::function<Vec3(const Vec3& x)>& acceleration) const;
  /// Load vector (n×3) of a change of temperature, that of the middle of the shell.
  Points thermal_load(const ShellTemperature& temperature) const;
  /// Adds the geometric stiffness ∫ N N,s N,sᵀ ds of the axial forces under a displacement q, of one
  /// coordinate (lower triangle, n×n).
  void add_geometric_stiffness(const Points& q, const ShellTemperature& temperature,
                               SparseMatrix& G) const;
  /// Strain energy under a displacement q.
  double energy(const Points& q, const ShellTemperature& temperature) const;
  /// Largest stresses and forces of each stiffener under a displacement q.
  std::vector<StiffenerResult> results(const Points& q, const ShellTemperature& temperature) const;

 private:
  enum Strain { Axial, Bending, LateralBending, Twist, kStrains };
  struct Point {
    int stiffener;
    double length;
    Vec3 at;  // on the centroid line
    std::array<int, 3> vertices;
    Vec3 L;
    std::array<int, 12> dofs;
    std::array<Eigen::Matrix<double, 12, 3>, kStrains> strains;  // coefficients of the dofs
    Eigen::Matrix<double, 12, 1> position, slope;                // N and N,s
  };
  double stiffness(const Point& point, int strain) const;
  std::array<double, kStrains> strains_at(const Point& point, const Points& q,
                                          const ShellTemperature& temperature) const;
  double temperature_at(const Point& point, const ShellTemperature& temperature) const;
  template <class Block>
  void add_blocks(const Block& block, SparseMatrix& matrix) const;

  long dof_count_ = 0;
  std::vector<Stiffener> stiffeners_;
  std::vector<Point> points_;
};

}  // namespace batten
