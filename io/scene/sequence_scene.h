// Sequence scenes: TOML files that edit a deforming mesh (all keys: docs/sequence.md). These
// functions read the scene file only, not the frames.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/scene/scene_selections.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/mesh/sequence/morph.h"
#include "batten/mesh/sequence/sequence_editor.h"
#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/ground_path.h"

namespace batten {

/// Frames from a file: [sequence], and further sequences used by steps.
struct SequenceSource {
  std::filesystem::path path;
  SourceLocation location;
  SequenceOptions options;
};

/// [[handle]]: a named part of the mesh that steps move.
struct SequenceHandle {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> vertices;
  LocatedString parent;  ///< parent handle, for filters; empty: the whole mesh
};

/// A keyframe of a step: handles moved in one frame.
struct KeyframeSpec {
  int frame = 1;  ///< 1-based, like all frame numbers in scenes
  SourceLocation location;
  /// Motion of a handle: rotation by `degrees` about `axis`, then translation.
  struct Move {
    LocatedString handle;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0;
    std::optional<Vec3> about;  ///< centre of rotation; empty: the handle's centroid in the frame
    bool free_rotation = false;
  };
  std::vector<Move> moves;
};

/// Options of foot contact detection.
struct FootContactSearch {
  double max_spread = 0;  ///< model units; 0: a hundredth of the size
  int frames = 3;
};

/// One [[operation]]; it operates on the result of the previous step.
struct SequenceOperation {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> fixed;  ///< nodes that keep their position in each frame
  SequenceEditOptions options;
  std::optional<double> penalty_weight;
  bool preserve_volume = false;
  /// Prescribed frames: every n-th frame is a keyframe, the others follow.
  int keyframe_interval = 1;

  /// User-defined keyframes.
  struct Keyframes {
    std::vector<KeyframeSpec> keys;
  };
  /// Root motion: the sequence is repeated as a cycle and moves along a direction.
  struct RootMotion {
    int cycles = 1;
    Vec3 along = Vec3::UnitX();
    /// Model units per frame; empty: the speed of the standing foot.
    std::optional<double> speed;
    std::vector<LocatedString> feet;  ///< feet that determine the speed
  };
  /// Foot contacts: planted feet are kept in place, shifted, or put on a terrain.
  struct FootContacts {
    std::vector<LocatedString> feet;
    FootContactSearch search;
    Vec3 translation = Vec3::Zero();
    std::filesystem::path terrain;  ///< a mesh; empty: none
    SourceLocation terrain_location;
    /// Handles that follow the mean of the feet without rotating.
    std::vector<LocatedString> unrotated;
    std::optional<double> clearance;  ///< empty: the clearance above the ground is kept
    double ground = 0;                ///< height of the original ground, along `up`
    bool rotations = false;
  };
  /// Motion along a path on the ground.
  struct Path {
    std::vector<Vec3> through;
    int spans = 0;
    PathLengths lengths = PathLengths::Absolute;
    std::vector<LocatedString> feet;
    /// Handles that stay on the path, independently of the feet.
    std::vector<LocatedString> unrotated;
    FootContactSearch search;
  };
  /// Low-pass, high-pass or cartoon filter of handle trajectories.
  struct Filter {
    enum class Kind { Low, High, Cartoon } kind = Kind::Cartoon;
    std::vector<LocatedString> handles;
    double sigma = 2;  ///< standard deviation of the Gaussian, in frames
    double amount = 1;
    std::vector<LocatedString> feet;  ///< feet whose contacts are preserved
    FootContactSearch search;
  };
  /// Transfers motion from another sequence.
  struct Mix {
    SequenceSource source;
    std::vector<SelectionSpec> selections;  ///< selections on the mesh of the source
    struct Pair {
      LocatedString handle;  ///< handle of this sequence
      LocatedString from;    ///< a selection of the source; empty: nodes with the same numbers
    };
    std::vector<Pair> pairs;
    bool rotations = true;  ///< true: transfer rotations; false: positions only
    using Align = MotionTransferOptions::Align;
    Align align = Align::All;
  };
  /// Morphs into another sequence.
  struct Morph {
    SequenceSource target;
    MorphOptions options;  ///< 0-based intervals; last = -1: the last frame
    /// Positions in the first frame of each interval; empty: both meshes have the same faces.
    std::vector<MorphLandmark> landmarks;
    TargetFitOptions fit;
  };
  std::variant<Keyframes, RootMotion, FootContacts, Path, Filter, Mix, Morph> what;
};

/// [[picture]]: some frames side by side, or all frames as an animation.
struct SequencePicture {
  std::string file, title;
  enum class Show { Before, After, Both } show = Show::Both;
  int frames = 6;         ///< frames of a sheet; 0: all, as an animation
  bool together = false;  ///< true: all frames in one picture, at their positions
  bool mesh = false;
  double azimuth = -30, elevation = 20, zoom = 1;
  double seconds = 0.05;  ///< duration of a frame in an animation
  PictureSize size;
};

/// Contents of a sequence scene.
struct SequenceScene : SceneSelections {
  SequenceSource source;
  int up = 2;  ///< axis that points upwards, 0 (x) to 2 (z)
  std::vector<SequenceHandle> handles;
  std::vector<FeatureSpec> features;
  std::vector<SequenceOperation> steps;
  std::string frames_out;         ///< path in the output folder, as for SequenceWriter
  double frames_per_second = 24;  ///< of .glb output, if frames have numbers instead of times
  std::vector<SequencePicture> pictures;

  /// Unit vector of the axis `up`.
  Vec3 upwards() const { return Vec3::Unit(up); }
};

/// True if a scene edits a sequence: it has [sequence]. Throws InputError if the file cannot be
/// read or is not TOML.
bool is_sequence_scene(const std::filesystem::path& file);

/// Reads a sequence scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
SequenceScene read_sequence_scene(const std::filesystem::path& file);
/// Parses a sequence scene from text. `file` appears in messages, and paths are relative to its
/// folder.
SequenceScene parse_sequence_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
