// SPDX-License-Identifier: MPL-2.0
// Tables of a scene that select vertices of a mesh: [[select]], [[cut]], [[feature]].
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// [[select]]: the vertices of the undeformed mesh that satisfy all given conditions.
struct SelectionSpec {
  /// Selects the vertices within a geodesic distance of a vertex or of another selection.
  struct Geodesic {
    std::optional<long> node;   ///< node number in the mesh file from which distances are measured
    std::optional<Vec3> point;  ///< alternative to `node`: the vertex nearest to this point
    LocatedString of;     ///< alternative: name of the selection from which distances are measured
    double distance = 0;  ///< maximum geodesic distance, model units
  };
  std::string name;
  SourceLocation location;
  std::optional<std::pair<Vec3, Vec3>> box;
  std::optional<std::pair<Vec3, double>> sphere;
  /// Selects the vertices whose distance from a plane is at most `within`.
  struct Plane {
    Vec3 through, normal;
    double within;
  };
  std::optional<Plane> plane;
  std::optional<int> loop;  ///< number of a boundary loop of the mesh, 1-based
  std::optional<int> part;  ///< number of a connected component of the mesh, 1-based
  std::optional<Geodesic> geodesic;
  /// Selects a connected region of salient vertices, grown from a start vertex.
  struct Salient {
    std::optional<long> node;   ///< start vertex: its node number in the mesh file
    std::optional<Vec3> point;  ///< alternative to `node`: the vertex nearest to this point
    double threshold = 0;       ///< minimum mesh saliency of the selected vertices, 0 to 1
  };
  std::optional<Salient> salient;
  std::vector<long> nodes;      ///< node numbers in the mesh file
  std::filesystem::path file;   ///< file that lists node numbers of the mesh file; empty: none
  LocatedString set, property;  ///< names of a set and of a property of an FE deck; empty: not used
  std::vector<LocatedString> any;     ///< selections, at least one of which must contain the vertex
  std::vector<LocatedString> except;  ///< selections that must not contain the vertex
  int grow = 0;  ///< number of rings of neighbours by which the selection is extended
};

/// [[cut]]: a feature that is separated from the rest of the mesh by a minimum cut (graph cut). The
/// vertices of the feature form a selection with the name of the cut.
struct CutSpec {
  std::string name;
  SourceLocation location;
  /// Selections of a band in which the border of the feature lies.
  std::vector<LocatedString> band;
  /// Alternative to `band`: selections on the feature, and selections outside the feature.
  std::vector<LocatedString> on, beside;
  /// A point near the feature, which tells on which side of the cut the feature is. Empty: the
  /// smaller side of the cut is the feature.
  std::optional<Vec3> inside;
  CutOptions options;
};

/// [[feature]]: one form feature. [[features]]: one form feature for each name in `vertices`.
struct FeatureSpec {
  std::string name;  ///< name of the feature; empty for [[features]]
  SourceLocation location;
  std::vector<LocatedString> vertices;  ///< names of selections and proposals; '*' is a wildcard
  FormFeature::Kind kind = FormFeature::Kind::Free;
};

/// Members shared by all scenes that select vertices of a mesh. VertexSelector evaluates the
/// selections.
struct SceneSelections {
  std::filesystem::path file;
  std::string name, unit = "mm";
  FeatureDetectionOptions proposals;
  std::vector<SelectionSpec> selections;
  std::vector<CutSpec> cuts;

  /// The prefix of messages about a location in the scene file: "FILE:LINE:COLUMN: ".
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

}  // namespace batten
