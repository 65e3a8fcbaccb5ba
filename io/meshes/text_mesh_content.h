// A mesh file whose coordinates are replaced in its text. Internal.
#pragma once

#include <array>
#include <vector>
#include <functional>
#include <optional>
#include <string>

#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_source_text.h"
#include "batten/core/eigen.h"

namespace batten {

// Coordinate systems in which decks give the places of nodes. Internal.

/// One system: what three numbers of a node mean. Angles are in degrees.
struct CoordinateFrame {
  enum class Kind {
    Rectangular,  ///< x, y, z
    Cylindrical,  ///< radius, angle from x, z
    Spherical,    ///< radius, angle from z, angle from x about z
    Latitude      ///< radius, angle from x about z, angle from the plane xy
  };
  Kind kind = Kind::Rectangular;
  Vec3 origin = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns: x, y, z

  Vec3 position(const Vec3& local_coordinates) const;
  /// The numbers of a place; of all that mean it, those nearest to `near`.
  Vec3 local_coordinates(const Vec3& position, const Vec3& near) const;
  /// By how much each of the numbers of a place can change by rounding in position() and local_coordinates(),
  /// where the place itself is only known to `length`.
  Vec3 rounding(const Vec3& position, double length) const;
};

/// How a system is defined: by three points (its origin, one on its z axis, one in its plane xz), or
/// as it is.
struct CoordinateSystemDefinition {
  CoordinateFrame::Kind kind = CoordinateFrame::Kind::Rectangular;
  long label = 0;
  size_t where = 0;                      ///< offset of its definition, for messages
  std::string unsupported_name;          ///< the name of one that cannot be followed
  int in = -1;                           ///< the system in which the points are given; -1: global
  std::array<Vec3, 3> points{};          ///< their numbers in that system, or
  std::array<int, 3> nodes{-1, -1, -1};  ///< the nodes that they are
  std::optional<CoordinateFrame> given;  ///< instead of points
};

/// The systems of a deck and the nodes in them.
struct NodeCoordinateSystems {
  std::vector<CoordinateSystemDefinition> plans;
  std::vector<int> of_node;  ///< index of each node's system, -1: global; empty: all are
  Points local_coordinates;  ///< as read, of all nodes

  bool any() const { return !of_node.empty(); }
  int of(int node) const { return of_node.empty() ? -1 : of_node[node]; }
};

/// Frames of systems, each made once, from places of nodes.
class CoordinateFrameResolver {
 public:
  /// `position`: the place of a node that defines a system; it may ask for other systems.
  CoordinateFrameResolver(const NodeCoordinateSystems& systems, const MeshSourceText& file,
                          std::function<Vec3(int)> position)
      : systems_(systems),
        file_(file),
        position_(std::move(position)),
        frames_(systems.plans.size()),
        state_(systems.plans.size()) {}
  /// Throws InputError, with the place of its definition: a system that is defined by itself, three
  /// points on a line, a kind that is not followed.
  const CoordinateFrame& of(int system);

 private:
  CoordinateFrame make(const CoordinateSystemDefinition& plan);

  const NodeCoordinateSystems& systems_;
  const MeshSourceText& file_;
  std::function<Vec3(int)> position_;
  std::vector<CoordinateFrame> frames_;
  std::vector<char> state_;  // 1: on the way, 2: made
  int depth_ = 0;
};


/// The content of a mesh file in which coordinates are replaced field by field.
struct TextMeshContent : MeshContent {
  explicit TextMeshContent(MeshSourceText file) : file(std::move(file)) {}
  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions& options) const override;
  std::vector<std::filesystem::path> included_files() const override;

  /// Adds a warning for each included file that is not written with the deck.
  void warn_about_unwritten_includes();

  MeshSourceText file;
  std::vector<std::array<Field, 3>> fields;  ///< the fields of each node's three numbers
  NodeCoordinateSystems systems;             ///< what these numbers mean
  /// Why a node must stay where it is, as "a coordinate that is the parameter <x>"; few have it.
  std::vector<std::pair<int, std::string>> fixed_nodes;
};

/// Makes the places of a mesh's nodes of the numbers that are in shells.points, and keeps these.
/// Throws as CoordinateFrameResolver does.
void nodes_to_global(TextMeshContent& mesh, NodeCoordinateSystems systems);

}  // namespace batten
