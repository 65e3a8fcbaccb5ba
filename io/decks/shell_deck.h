// A shell problem as decks of FE programs state it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>
#include <filesystem>

#include "batten/core/geometry.h"
#include "batten/core/eigen.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// A linear static shell problem on a model of one or more regions. The user chooses the units,
/// which must fit together (mm, N and MPa need density in t/mm³ and gravity in mm/s²).
struct ShellDeck {
  enum class Element {
    S6,  ///< six-node triangles
    S3,  ///< four three-node triangles in place of each
    S8R  ///< three eight-node quads in place of each
  };
  struct Support {
    enum class Kind {
      Pinned,  ///< no displacement
      Clamped  ///< no displacement, no rotation
    };
    std::string line;  ///< name of a character line of the model; "": an area
    Kind kind = Kind::Pinned;
    std::string region = {};                               ///< of an area; "": of all
    std::optional<Box3> box = {};                          ///< the nodes in it only
    std::array<bool, 3> constrained = {true, true, true};  ///< x, y, z of the displacement
    Vec3 displacement = Vec3::Zero();
  };
  struct PointForce {
    Vec3 at;  ///< the nearest node takes the force
    Vec3 force;
  };

  struct Pressure {
    std::string region;   ///< name of a region of the model
    double pressure = 0;  ///< force per area; positive pushes along its x_u × x_v
  };
  struct Thickness {
    std::string region;
    double thickness = 0;
  };
  struct LineForce {
    std::string line;
    Vec3 per_length;
    std::optional<Box3> box;
  };

  Element element = Element::S6;
  double thickness = 0, young = 0, poisson = 0;
  std::vector<Thickness> thicknesses;  ///< of single regions
  double density = 0;                  ///< needed by gravity only
  std::string units;                   ///< units as a comment in the deck: "mm, N, MPa"
  std::vector<Support> supports;       ///< one or more
  double pressure = 0;  ///< force per area on all regions; positive pushes along x_u × x_v
  std::vector<Pressure> pressures;  ///< further pressures on single regions
  /// Force per area at a place x with the normal n of the region of a name; none: no such force.
  std::function<Vec3(const std::string& region, const Vec3& x, const Vec3& n)> area_force;
  std::vector<LineForce> line_forces;
  std::vector<PointForce> point_forces;
  Vec3 gravity = Vec3::Zero();  ///< acceleration
};


// Writes skinned regions as an input deck of CalculiX (ccx) with shell elements.

/// Writes `path` (.inp) for `ccx -i <path without .inp>`. The file appears whole or not at all.
///
/// Each element becomes one S6 triangle (or its parts, of other types) of its vertices and the
/// surface's points at the parametric midpoints of its edges. The surface is the middle surface;
/// normals are x_u × x_v of each region.
/// In a deck of one region, node numbers are mesh vertex + 1, then vertex_count + edge + 1; element
/// numbers are triangle + 1. The elements of a region with embedded lines are its quadratic_elements:
/// the deck is the region inside of its boundary, with nodes on its lines.
///
/// Several regions are one shell (model_elements()). They share the nodes on a line that they share,
/// which lie where a region that has the line as a run has them; where lines meet there is one
/// node. Nodes and elements are numbered region after region, a shared node where it first comes.
/// Where regions meet at a crease, ccx joins the thick elements of both sides rigidly. Loads act on
/// all regions.
///
/// The deck has the node set NALL, the element set ALL, one node set for each line of the model
/// (also for rims of holes and ribs) and, with several regions, one element set for each. Their
/// names are in capitals, with '_' for all but letters and digits, and a number behind where two
/// would be the same. Area and line forces become nodal loads, by the quadratic shape functions on
/// the true surface. Supports in boxes have node sets SUPPORT_1, …. Numbers have the 20 characters that ccx reads: their relative error is 1e-13 at most.
///
/// Throws InputError: no region, thickness, Young's modulus not above 0, Poisson's ratio not in
/// (-1, 0.5), a density below 0 or gravity without density, numbers that are not finite, no
/// support, one that holds no node, a line or region that the model does not have (with the nearest name), what
/// model_elements() throws, a file that cannot be written.
void write_calculix(const std::filesystem::path& path,
                    const std::vector<const SkinnedRegion*>& regions, const ShellDeck& deck);

}  // namespace batten
