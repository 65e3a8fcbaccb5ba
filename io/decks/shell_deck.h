// A shell problem as decks of FE programs state it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/box.h"
#include "batten/core/eigen.h"

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

}  // namespace batten
