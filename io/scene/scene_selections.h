// Scene elements that select vertices of a mesh: [[select]], [[cut]], [[feature]].
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/features/minimum_cut.h"

namespace batten {

/// [[select]]: the vertices of the undeformed mesh that satisfy all given conditions.
struct SelectionSpec {
  /// Vertices within a geodesic distance of a start.
  struct Geodesic {
    std::optional<long> node;   ///< start: node number in the mesh file
    std::optional<Vec3> point;  ///< alternatively: the vertex nearest to this point
    LocatedString of;           ///< alternatively: this selection
    double distance = 0;        ///< maximum geodesic distance, model units
  };
  std::string name;
  SourceLocation location;
  std::optional<std::pair<Vec3, Vec3>> box;
  std::optional<std::pair<Vec3, double>> sphere;
  /// Vertices within a distance of a plane.
  struct Plane {
    Vec3 through, normal;
    double within;
  };
  std::optional<Plane> plane;
  std::optional<int> loop;  ///< number of a boundary loop, from 1
  std::optional<int> part;  ///< number of a connected component of the mesh, from 1
  std::optional<Geodesic> geodesic;
  /// A region grown from a start over salient vertices.
  struct Salient {
    std::optional<long> node;   ///< start: node number in the mesh file
    std::optional<Vec3> point;  ///< alternatively: the vertex nearest to this point
    double threshold = 0;       ///< the region contains vertices of at least this saliency
  };
  std::optional<Salient> salient;
  std::vector<long> nodes;            ///< node numbers in the mesh file
  std::filesystem::path file;         ///< a file with node numbers
  LocatedString set, property;        ///< name of a set, or of a property, of a deck
  std::vector<LocatedString> any;     ///< selections of which at least one contains the vertex
  std::vector<LocatedString> except;  ///< selections of which none contains the vertex
  int grow = 0;                       ///< number of rings of neighbours added at the end
};

/// [[cut]]: a feature found by a minimum cut (graph cut); its vertices form a selection of this
/// name.
struct CutSpec {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> band;        ///< selections that contain the border of the feature
  std::vector<LocatedString> on, beside;  ///< alternatively: strokes on the feature and outside it
  /// The vertex nearest to this point is in the feature; empty: the feature is the smaller side.
  std::optional<Vec3> inside;
  CutOptions options;
};

/// [[feature]]: one form feature; or [[features]]: one for each name in `vertices`.
struct FeatureSpec {
  std::string name;  ///< empty for [[features]]
  SourceLocation location;
  std::vector<LocatedString> vertices;  ///< selections and proposals; '*' is a wildcard
  FormFeature::Kind kind = FormFeature::Kind::Free;
};

/// Common part of scenes that select vertices of a mesh. VertexSelector evaluates the selections.
struct SceneSelections {
  std::filesystem::path file;
  std::string name, unit = "mm";
  FeatureDetectionOptions proposals;
  std::vector<SelectionSpec> selections;
  std::vector<CutSpec> cuts;

  /// The location as "FILE:LINE:COLUMN: ", the prefix of messages.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

}  // namespace batten
