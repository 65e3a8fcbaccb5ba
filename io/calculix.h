// A skinned region as an input deck of CalculiX (ccx): quadratic shell elements.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/skinning/region.h"

namespace batten {

/// A linear static shell problem on one region. Units are the user's and must fit together (mm, N
/// and MPa need density in t/mm³ and gravity in mm/s²).
struct ShellDeck {
  struct Support {
    enum class Kind {
      Pinned,  ///< no displacement
      Clamped  ///< no displacement, no rotation
    };
    std::string line;  ///< name of a character line of the region
    Kind kind = Kind::Pinned;
  };
  struct PointForce {
    Vec3 at;  ///< the nearest node takes the force
    Vec3 force;
  };

  double thickness = 0, young = 0, poisson = 0;
  double density = 0;              ///< needed by gravity only
  std::string units;               ///< a comment for the reader of the deck: "mm, N, MPa"
  std::vector<Support> supports;   ///< one or more
  double pressure = 0;             ///< force per area; positive pushes along x_u × x_v
  Vec3 area_force = Vec3::Zero();  ///< force per area in a fixed direction
  std::vector<PointForce> point_forces;
  Vec3 gravity = Vec3::Zero();  ///< acceleration
};

/// Writes `path` (.inp), ready for `ccx -i <path without .inp>`. Whole or not at all.
///
/// Each element becomes one S6 triangle: its vertices and the surface's points at the parametric
/// midpoints of its edges; the middle surface is the surface, normals are x_u × x_v. Node numbers:
/// mesh vertex + 1, then vertex_count + edge + 1; element numbers: triangle + 1. A region with
/// embedded lines has its quadratic_facets for elements: the deck is the region inside of its
/// boundary, with nodes on its lines. Node set NALL,
/// element set ALL, one node set for each line, rims of holes and ribs as well: its name in
/// capitals, other signs than letters and digits replaced by '_', with a number behind it where two
/// lines would get the same. Area forces are exact nodal loads (quadratic shape functions on the
/// true surface). Numbers have as many digits as ccx reads, 20 characters: relative error 1e-13 at
/// most.
///
/// Throws InputError: thickness, Young's modulus not above 0, Poisson's ratio not in (-1, 0.5), a
/// density below 0 or gravity without density, numbers that are not finite, no support, a line that
/// the region does not have (with the nearest name), a file that cannot be written.
void write_calculix(const std::filesystem::path& path, const SkinnedRegion& region,
                    const ShellDeck& deck);

}  // namespace batten
