// SPDX-License-Identifier: MPL-2.0
// Sequence scenes: TOML files that edit a deforming mesh (all keys: docs/sequence.md). These
// functions read the scene file only, not the frames.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
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

/// A file of frames: the main sequence ([sequence]), or another sequence that an operation uses.
struct SequenceSource {
  std::filesystem::path path;
  SourceLocation location;
  SequenceOptions options;
  /// Frames in memory, which take the place of the file; nullptr: none.
  std::shared_ptr<const MeshSequence> in_memory = nullptr;
};

/// [[handle]]: a named part of the mesh that operations move.
struct SequenceHandle {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> vertices;
  /// Handle relative to which the motion is filtered; empty: relative to the whole mesh.
  LocatedString parent;
};

/// A keyframe of an operation: the handles that are moved in one frame.
struct KeyframeSpec {
  int frame = 1;  ///< frame number, 1-based as in the scene file
  SourceLocation location;
  /// Motion of a handle in a keyframe: rotation by `degrees` about `axis`, then translation.
  struct Move {
    LocatedString handle;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0;
    /// Centre of rotation; empty: centroid of the handle in the keyframe.
    std::optional<Vec3> about;
    bool free_rotation = false;
  };
  std::vector<Move> moves;
};

/// Options for detecting foot contacts in a sequence.
struct FootContactSearch {
  /// Largest distance between positions of the foot during a contact, model units; 0: 1 % of the
  /// size of the mesh.
  double max_spread = 0;
  int frames = 3;
};

/// One [[operation]], applied to the result of the previous operation.
struct SequenceOperation {
  std::string name;
  SourceLocation location;
  /// Selections of nodes that keep their input position in each frame.
  std::vector<LocatedString> fixed;
  SequenceEditOptions options;
  std::optional<double> penalty_weight;
  bool preserve_volume = false;
  /// Interval n between keyframes, for operations that prescribe all frames: every n-th frame is a
  /// keyframe, and the frames between keyframes are interpolated.
  int keyframe_interval = 1;

  /// Operation that moves handles in the keyframes given in the scene.
  struct Keyframes {
    std::vector<KeyframeSpec> keys;
  };
  /// Root motion: repeats a cycle animated in place, and moves the mesh along a direction.
  struct RootMotion {
    int cycles = 1;
    Vec3 along = Vec3::UnitX();
    /// Speed, model units per frame; empty: the speed at which the lowest foot moves backwards.
    std::optional<double> speed;
    std::vector<LocatedString> feet;  ///< handles of the feet, from which the speed is determined
  };
  /// Foot contacts: planted feet are fixed, translated, or projected onto a terrain.
  struct FootContacts {
    std::vector<LocatedString> feet;
    FootContactSearch search;
    Vec3 translation = Vec3::Zero();
    std::filesystem::path terrain;  ///< mesh file of the terrain; empty: no terrain
    SourceLocation terrain_location;
    /// A mesh in memory, which takes the place of the terrain's file; nullptr: none.
    std::shared_ptr<const ShellMesh> terrain_in_memory = nullptr;
    /// Handles that follow the mean translation of the feet without rotating.
    std::vector<LocatedString> unrotated;
    /// Height of the centroid of a foot above the terrain, model units. Empty: the height of the
    /// foot above `ground` in the input.
    std::optional<double> clearance;
    double ground = 0;  ///< height of the ground in the input, along the upward axis
    bool rotations = false;
  };
  /// Moves the sequence to another path on the ground.
  struct Path {
    std::vector<Vec3> through;
    int spans = 0;
    PathLengths lengths = PathLengths::Absolute;
    std::vector<LocatedString> feet;
    /// Handles that stay on the path without rotating, independently of the feet.
    std::vector<LocatedString> unrotated;
    FootContactSearch search;
  };
  /// Low-pass, high-pass or cartoon filter of the trajectories of handles.
  struct Filter {
    enum class Kind { Low, High, Cartoon } kind = Kind::Cartoon;
    std::vector<LocatedString> handles;
    double sigma = 2;  ///< standard deviation of the Gaussian, in frames
    double amount = 1;
    std::vector<LocatedString> feet;  ///< handles of feet whose ground contacts stay fixed
    FootContactSearch search;
  };
  /// Transfers the motion of handles from another sequence.
  struct Mix {
    SequenceSource source;
    std::vector<SelectionSpec> selections;  ///< selections on the mesh of `source`
    struct Pair {
      LocatedString handle;  ///< name of a handle of the edited sequence
      /// Selection on the mesh of `source`; empty: the node numbers of `handle`.
      LocatedString from;
    };
    std::vector<Pair> pairs;
    bool rotations = true;  ///< true: transfer positions and rotations; false: positions only
    using Align = MotionTransferOptions::Align;
    Align align = Align::All;
  };
  /// Morphs the sequence into another one.
  struct Morph {
    SequenceSource target;
    MorphOptions options;  ///< intervals of 0-based frames; last = -1: the last frame
    /// Corresponding points in the first frames of the blended intervals of the two sequences.
    /// Empty: both meshes must have the same faces.
    std::vector<MorphLandmark> landmarks;
    TargetFitOptions fit;
  };
  std::variant<Keyframes, RootMotion, FootContacts, Path, Filter, Mix, Morph> what;
};

/// [[picture]]: a sheet of several frames, or an animation.
struct SequencePicture {
  std::string file, title;
  enum class Show { Before, After, Both } show = Show::Both;
  int frames = 6;         ///< number of frames on a sheet; 0: animation of all frames
  bool together = false;  ///< true: draw all frames in one picture, at their positions
  bool mesh = false;
  double azimuth = -30, elevation = 20, zoom = 1;
  double seconds = 0.05;  ///< time per frame of an animation, seconds
  PictureSize size;
};

/// Contents of a sequence scene.
struct SequenceScene : SceneSelections {
  SequenceSource source;
  int up = 2;  ///< upward axis of the sequence: 0, 1, 2 for x, y, z
  std::vector<SequenceHandle> handles;
  std::vector<FeatureSpec> features;
  std::vector<SequenceOperation> steps;
  std::string frames_out;  ///< file name or pattern of the output, relative to the output folder
  /// Frame rate of .glb output, 1/s; used if the frames have numbers instead of times.
  double frames_per_second = 24;
  std::vector<SequencePicture> pictures;

  /// The unit vector along the upward axis.
  Vec3 upwards() const { return Vec3::Unit(up); }
};

/// True if a scene file edits a sequence, that is, contains [sequence]. Throws InputError if the
/// file cannot be read or is not TOML.
bool is_sequence_scene(const std::filesystem::path& file);

/// Reads a sequence scene. Throws InputError ("FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?") if the file is invalid.
SequenceScene read_sequence_scene(const std::filesystem::path& file);
/// Parses a sequence scene from text. `file` appears in messages, and relative paths are resolved
/// against its folder.
SequenceScene parse_sequence_scene(const std::string& text, const std::filesystem::path& file);
/// Parses the edits of a sequence in memory: a sequence scene without [sequence], [output] and
/// [[picture]], whose lengths have the unit of the sequence. `unit`, if given, appears in messages.
SequenceScene parse_sequence_edits(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
