// Edits of a mesh: what to hold, keep and move, in one small TOML file (docs/deform.md has every
// key). The mesh stays in its own file; this reads the scene only.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/fair_curve.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/scene.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/features/proposals.h"
#include "batten/sculpting/curves/deformable_curve.h"

namespace batten {

/// [[select]]: vertices of the mesh as it was read that meet all the conditions given.
struct SelectRule {
  struct Geodesic {
    std::optional<long> node;   ///< the file's number
    std::optional<Vec3> point;  ///< its nearest vertex
    PlacedWord of;              ///< or a selection
    double distance = 0;
  };
  std::string name;
  FilePlace place;
  std::optional<std::pair<Vec3, Vec3>> box;
  std::optional<std::pair<Vec3, double>> sphere;
  struct Plane {
    Vec3 through, normal;
    double within;
  };
  std::optional<Plane> plane;
  std::optional<int> loop;  ///< boundary loop, from 1
  std::optional<Geodesic> geodesic;
  std::vector<long> nodes;         ///< the file's numbers
  std::filesystem::path file;      ///< of such numbers
  PlacedWord set, property;        ///< of a deck
  std::vector<PlacedWord> any;     ///< in one of these
  std::vector<PlacedWord> except;  ///< and in none of these
  int grow = 0;                    ///< in the end, with so many rings around
};

/// [[cut]]: a feature found by a minimum cut; its vertices are a selection of this name.
struct CutRule {
  std::string name;
  FilePlace place;
  std::vector<PlacedWord> band;
  std::optional<Vec3> inside;  ///< its nearest vertex is in the feature; none: the smaller side
  CutOptions options;
};

/// [[feature]] (one) or [[features]] (each of its names one).
struct FeatureRule {
  std::string name;  ///< "" for [[features]]
  FilePlace place;
  std::vector<PlacedWord> vertices;  ///< selections and proposals; '*' stands for any letters
  FormFeature::Kind kind = FormFeature::Kind::Free;
};

/// [[guide]]: a point that stays on a plane or on a line.
struct GuideRule {
  std::string name;
  FilePlace place;
  PlacedWord of;  ///< feature, selection or proposal: the mean of the vertices (of its loop)
  GuidedPoint::Kind kind = GuidedPoint::Kind::OnPlane;
  Vec3 direction = Vec3::UnitZ();
  std::optional<Vec3> through;  ///< none: where the point is
};

/// [[line]]: a character line that keeps its shape, rigidly or in the soft sense.
struct LineRule {
  std::string name;
  FilePlace place;
  std::vector<Vec3> through;  ///< the vertices nearest to these, and along creases between
  std::vector<long> nodes;    ///< or these, in their order
  bool closed = false;
  bool rigid = false;
  double width = 0;  ///< soft; 0: a tenth of the line's length
};

/// [[curve]]: a line of vertices that becomes a deformable curve: faired, shaped by its own loads,
/// and then imposed on its vertices exactly.
struct CurveRule {
  enum class Ends { Clamped, Held, Free };
  LineRule line;  ///< its way; keep and width are not used
  bool faired = true;
  FairOptions fair;  ///< of the fairing
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;  ///< relative, of the change of shape under loads
  std::vector<CurveLoad> loads;
};

/// [[pull]]: a vertex that is drawn to a place, softly or exactly.
struct PullRule {
  std::string name;
  FilePlace place;
  std::optional<long> node;
  std::optional<Vec3> at;
  Vec3 to = Vec3::Zero();
  std::optional<double> weight;  ///< none: exactly
};

/// [[edit]], on the mesh as the edit before left it.
struct EditRule {
  struct MovedHandle {
    std::string name;
    FilePlace place;
    std::vector<PlacedWord> vertices;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0, scale = 1;
    std::optional<Vec3> about;  ///< none: the mean of its vertices
  };
  struct ScaledFeature {
    PlacedWord feature;
    double factor = 1;
  };
  struct MovedGuide {
    PlacedWord guide;
    Vec3 through;
  };
  std::string name;
  FilePlace place;
  std::vector<PlacedWord> fixed, region;
  std::vector<MovedHandle> handles;
  std::vector<ScaledFeature> scales;
  std::vector<MovedGuide> guides;
};

/// [modes]: shell and material of the decks for natural frequencies, before and after.
struct ModesRule {
  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;
  std::vector<PlacedWord> clamped;
  std::string before, after;  ///< file names
};

/// [[picture]]: before and after side by side, or the mesh after each edit.
struct MeshPictureRule {
  enum class Show { BeforeAfter, Steps, After, Displacement };
  std::string file, title;
  Show show = Show::BeforeAfter;
  bool mesh = false;
  double azimuth = -30, elevation = 30, zoom = 1;
  PictureSize size;
};

struct DeformScene {
  std::filesystem::path file;
  std::string name, unit = "mm";
  std::filesystem::path mesh;
  DeformProblem::Weighting weighting = DeformProblem::Weighting::Area;
  ProposalOptions proposals;
  std::vector<SelectRule> selections;
  std::vector<CutRule> cuts;
  std::vector<FeatureRule> features;
  std::vector<GuideRule> guides;
  std::vector<LineRule> lines;
  std::vector<CurveRule> curves;
  std::vector<PullRule> pulls;
  std::vector<EditRule> edits;
  std::string mesh_out, vtp;  ///< file names; "" for none
  bool wide_nodes = false;
  std::optional<ModesRule> modes;
  std::vector<MeshPictureRule> pictures;

  /// EDIT.HANDLE.x, .y, .z, .degrees, .scale, EDIT.FEATURE.scale and CURVE.LOAD.
  std::vector<Parameter> parameters() const;
  /// Throws InputError, beginning with `where`: an unknown name (the nearest is offered), a scale
  /// not above 0.
  void set(const std::string& parameter, double value, const std::string& where);
  /// "FILE:LINE:COLUMN: "
  std::string at(const FilePlace& place) const { return place_prefix(file.string(), place); }
};

/// Whether a scene edits a mesh: it names a mesh or has an edit. Throws InputError when the file
/// cannot be read or is not TOML.
bool edits_a_mesh(const std::filesystem::path& file);

/// Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
DeformScene read_deform_scene(const std::filesystem::path& file);
DeformScene parse_deform_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
