// SPDX-License-Identifier: MPL-2.0
// Content of a mesh file whose coordinates are replaced in its text, and the local coordinate
// systems of decks.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

/// A local coordinate system: converts the three numbers of a node to a global position and back.
/// Angles are in degrees.
struct CoordinateFrame {
  enum class Kind {
    Rectangular,  ///< x, y, z
    Cylindrical,  ///< radius, angle from x about z, z
    Spherical,    ///< radius, angle from z, angle from x about z
    Latitude      ///< radius, angle from x about z, angle from the xy plane
  };
  Kind kind = Kind::Rectangular;
  Vec3 origin = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns: unit vectors x, y, z

  /// The global position of local coordinates.
  Vec3 position(const Vec3& local_coordinates) const;
  /// The local coordinates of a global position. If several are equivalent (angles plus 360°,
  /// negative radius), those nearest to `near` are chosen.
  Vec3 local_coordinates(const Vec3& position, const Vec3& near) const;
  /// Bound on the change of each local coordinate through rounding in position() and
  /// local_coordinates(), if the position itself is only known to within `length`.
  Vec3 rounding(const Vec3& position, double length) const;
};

/// Definition of a coordinate system: by three points (origin, point on the z axis, point in the xz
/// plane), or directly by a frame.
struct CoordinateSystemDefinition {
  CoordinateFrame::Kind kind = CoordinateFrame::Kind::Rectangular;
  /// Number of the system in the deck.
  long label = 0;
  size_t where = 0;                      ///< offset of its definition, for messages
  std::string unsupported_name;          ///< name of an unsupported type; else empty
  int in = -1;                           ///< system in which the points are given; -1: global
  std::array<Vec3, 3> points{};          ///< coordinates of the points in that system, or
  std::array<int, 3> nodes{-1, -1, -1};  ///< the nodes at these points; -1: none
  std::optional<CoordinateFrame> given;  ///< frame, used instead of points
};

/// The coordinate systems of a deck, and the system of each node.
struct NodeCoordinateSystems {
  /// Definitions of the systems.
  std::vector<CoordinateSystemDefinition> plans;
  std::vector<int> of_node;  ///< index of each node's system, -1: global; empty: all global
  Points local_coordinates;  ///< coordinates of all nodes as read

  /// True if any node has a local system.
  bool any() const { return !of_node.empty(); }
  /// Index of the system of a node; -1: global.
  int of(int node) const { return of_node.empty() ? -1 : of_node[node]; }
};

/// Computes the frames of coordinate systems on demand, each one once.
class CoordinateFrameResolver {
 public:
  /// `position` gives the global position of a node that defines a system. It may recursively
  /// request other systems.
  CoordinateFrameResolver(const NodeCoordinateSystems& systems, const MeshSourceText& file,
                          std::function<Vec3(int)> position)
      : systems_(systems),
        file_(file),
        position_(std::move(position)),
        frames_(systems.plans.size()),
        state_(systems.plans.size()) {}
  /// The frame of a system. Throws InputError with the location of the definition for circular
  /// definitions, three collinear points or an unsupported type.
  const CoordinateFrame& of(int system);

 private:
  CoordinateFrame make(const CoordinateSystemDefinition& plan);

  const NodeCoordinateSystems& systems_;
  const MeshSourceText& file_;
  std::function<Vec3(int)> position_;
  std::vector<CoordinateFrame> frames_;
  std::vector<char> state_;  // 1: in progress, 2: done
  int depth_ = 0;
};

/// Numbers of a card that rotate with nodes of the mesh: directions, offsets, and points that define
/// axes.
struct RotatingCard {
  /// Three numbers with their locations in the file.
  struct Numbers {
    std::array<Field, 3> fields;
    Vec3 value = Vec3::Zero();
    enum class Kind {
      Vector,  ///< rotates
      Point,   ///< moves with the nodes
      Arm      ///< a point that rotates about `origin`
    } kind = Kind::Vector;
    Vec3 origin = Vec3::Zero();
  };
  std::string name;        ///< for messages: "CBAR 12", "*ORIENTATION FIBRE"
  std::vector<int> nodes;  ///< nodes with which the numbers rotate
  std::vector<Numbers> numbers;
  /// Coordinate system of the vectors, at the first node; -1: global.
  int system = -1;
  enum class Use {
    Own,      ///< of one element or node
    Shared,   ///< of several elements: only their mean rotation is possible
    Unknown,  ///< not known: the card rotates only if the whole mesh rotates as a rigid body
  } use = Use::Own;
};

/// The angle between the first edge of a shell and a material direction that the deck fixes in the
/// global system. It is written as an angle if the element rotates.
struct MaterialDirection {
  std::string name;
  Field field;
  int face = -1;
  Vec3 direction = Vec3::UnitX();
};

/// Cards with directions in the global system that Batten cannot rewrite. They are named if the
/// nodes rotate.
struct GlobalDirections {
  std::string name;
  std::vector<int> nodes;
};

/// Content of a mesh file in which coordinates are replaced field by field.
struct TextMeshContent : MeshContent {
  explicit TextMeshContent(MeshSourceText file) : file(std::move(file)) {}
  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions& options) const override;
  std::vector<std::filesystem::path> included_files() const override;
  std::filesystem::path folder_in_tree() const override;

  /// Adds a warning for each included file that is not written together with the deck.
  void warn_about_unwritten_includes();

  MeshSourceText file;
  std::vector<std::array<Field, 3>> fields;  ///< fields of the three coordinates of each node
  NodeCoordinateSystems systems;             ///< coordinate systems of these coordinates
  /// Nodes that must not move, each with the reason, such as "a coordinate that is the parameter
  /// <x>". Usually few.
  std::vector<std::pair<int, std::string>> fixed_nodes;
  std::vector<RotatingCard> rotating_cards;
  std::vector<MaterialDirection> material_directions;
  std::vector<GlobalDirections> global_directions;
  /// Cards with positions in the global system, such as rigid walls, which stay; number by name.
  std::map<std::string, int> global_positions;
};

/// Converts shells.points of a mesh from local to global coordinates, and stores `systems` and the
/// local coordinates in it. Throws the exceptions of CoordinateFrameResolver.
void nodes_to_global(TextMeshContent& mesh, NodeCoordinateSystems systems);

}  // namespace batten
