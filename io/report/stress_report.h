// What a stress analysis found, for report.json and for a mail.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Of `batten stress`. Units are the scene's: lengths in model units, forces and stresses follow
/// from Young's modulus.
struct StressReport {
  std::string material;  ///< its name, or ""
  int unknowns = 0;      ///< of the system that was factored
  double yield = 0;      ///< 0: not stated
  double thickness_over_radius =
      0;  ///< the largest thickness over the smallest radius of curvature
  double edge_over_boundary_layer =
      0;  ///< largest of edge length / √(radius · thickness): above 1.5 coarse

  std::vector<std::string> weakly_constrained_motions;  ///< which the supports hardly resist
  double smallest_lever = 0;                            ///< by what lever, over the size

  struct Reaction {
    std::string support;
    Vec3 force, moment;  ///< on the shell; moment about the origin
  };
  /// The largest values of another program on the same shell, and those where ours are largest.
  struct CalculixResult {
    std::string elements;
    double displacement = 0, stress = 0, displacement_there = 0, stress_there = 0;
  };
  struct Case {
    std::string name;
    bool combination = false;
    Vec3 force = Vec3::Zero();      ///< sum of all loads
    double displacement = 0;        ///< the largest
    double displacement_error = 0;  ///< estimate of what is missing of it
    Vec3 displacement_vector = Vec3::Zero(), max_displacement_at = Vec3::Zero();
    std::string max_displacement_region;
    double stress = 0;                          ///< the largest equivalent stress (von Mises)
    std::string side;                           ///< "top" or "bottom"
    Vec3 max_stress_at = Vec3::Zero();          ///< on the middle surface
    Vec3 max_stress_face_point = Vec3::Zero();  ///< the same place, top or bottom
    std::string max_stress_region;
    double spread = 0;  ///< of the elements' own stresses there
    bool near_singularity =
        false;          ///< beside a point load or support, where stresses have no limit
    double safety = 0;  ///< yield / stress; 0 where no yield is stated
    double energy = 0;
    double error = 0;                 ///< estimate, relative, in energy norm
    double equilibrium_residual = 0;  ///< |loads + reactions| / |loads|
    bool buckling_requested = false;
    std::vector<double> buckling;  ///< factors of the load, smallest first
    std::vector<Reaction> reactions;
    std::optional<CalculixResult> calculix;
  };
  std::vector<Case> cases;
  /// A mesh on the way to an accuracy that was asked for: the largest values of all cases.
  struct Mesh {
    double edge_length = 0;
    int unknowns = 0;
    double displacement = 0, stress = 0;
    double error = 0;  ///< estimate: relative, of displacements
  };
  std::vector<Mesh> meshes;
  /// Derivatives of a case by a parameter of the scene.
  struct Sensitivity {
    std::string parameter, load_case;
    double displacement = 0;  ///< of the largest displacement, along itself
    double compliance = 0;    ///< of the work of the loads
  };
  std::vector<Sensitivity> sensitivities;
  std::vector<double> frequencies;  ///< 1/time, rigid motions as 0 first
};

}  // namespace batten
