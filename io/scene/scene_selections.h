// Scenes that name vertices of a mesh: [[select]], [[cut]], [[feature]].
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/features/minimum_cut.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// [[select]]: vertices of the mesh as it was read that meet all the conditions given.
struct SelectionSpec {
  struct Geodesic {
    std::optional<long> node;   ///< start: the node with this number in the mesh file
    std::optional<Vec3> point;  ///< or the vertex nearest to this point
    LocatedString of;           ///< or this selection
    double distance = 0;        ///< largest distance from the start over the mesh, model units
  };
  std::string name;
  SourceLocation location;
  std::optional<std::pair<Vec3, Vec3>> box;
  std::optional<std::pair<Vec3, double>> sphere;
  struct Plane {
    Vec3 through, normal;
    double within;
  };
  std::optional<Plane> plane;
  std::optional<int> loop;  ///< number of a boundary loop, from 1
  std::optional<int> part;  ///< number of a part of the mesh, from 1
  std::optional<Geodesic> geodesic;
  struct Salient {
    std::optional<long> node;   ///< start: the node with this number in the mesh file
    std::optional<Vec3> point;  ///< or the vertex nearest to this point
    double threshold = 0;       ///< grown while the saliency of vertices is not below this
  };
  std::optional<Salient> salient;
  std::vector<long> nodes;            ///< numbers of nodes in the mesh file
  std::filesystem::path file;         ///< a file with such numbers
  LocatedString set, property;        ///< names of a set and a property of a deck
  std::vector<LocatedString> any;     ///< selections: the vertex is in one of them
  std::vector<LocatedString> except;  ///< selections: the vertex is in none of them
  int grow = 0;                       ///< rings of neighbours that are added in the end
};

/// [[cut]]: a feature that is found by a minimum cut; its vertices are a selection of this name.
struct CutSpec {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> band;        ///< selections that hold the feature's border
  std::vector<LocatedString> on, beside;  ///< or strokes on the feature and beside it
  std::optional<Vec3> inside;  ///< point whose nearest vertex is in the feature; none: the
                               ///< feature is the smaller side
  CutOptions options;
};

/// [[feature]]: one form feature; or [[features]]: one for each of its names.
struct FeatureSpec {
  std::string name;  ///< "" for [[features]]
  SourceLocation location;
  std::vector<LocatedString> vertices;  ///< selections and proposals; '*' stands for any letters
  FormFeature::Kind kind = FormFeature::Kind::Free;
};

/// A scene that names vertices of a mesh; what it means is found later (VertexSelector).
struct SceneSelections {
  std::filesystem::path file;
  std::string name, unit = "mm";
  FeatureDetectionOptions proposals;
  std::vector<SelectionSpec> selections;
  std::vector<CutSpec> cuts;

  /// The place as "FILE:LINE:COLUMN: ", with which messages begin.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

}  // namespace batten
