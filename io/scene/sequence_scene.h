// A sequence scene is one small TOML file that says how to edit a deforming mesh (docs/sequence.md
// has every key). These functions read the scene only; the frames have files of their own.
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
#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/ground_path.h"
#include "batten/mesh/sequence/sequence_editor.h"

namespace batten {

/// Frames of a file: [sequence], and further sequences in steps.
struct SequenceSource {
  std::filesystem::path path;
  SourceLocation location;
  SequenceOptions options;
};

/// [[handle]]: a part of the mesh that steps move; its name stands for its vertices.
struct SequenceHandle {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> vertices;
  LocatedString parent;  ///< another handle that it hangs on, for filters; "": the whole mesh
};

/// A keyframe of a step: handles moved in one frame.
struct KeyframeSpec {
  int frame = 1;  ///< counted from 1, as all frames in scenes are
  SourceLocation location;
  struct Move {
    LocatedString handle;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0;
    std::optional<Vec3> about;  ///< centre of the turn; none: the handle's centroid in the frame
    bool free_rotation = false;
  };
  std::vector<Move> moves;
};

/// How feet that stay put are found.
struct FootContactSearch {
  double max_spread = 0;  ///< model units; 0: a hundredth of the size
  int frames = 3;
};

/// One [[step]], which works on the result of the step before.
struct SequenceOperation {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> fixed;  ///< nodes that stay where each frame has them
  SequenceEditOptions options;
  std::optional<double> penalty_weight;
  bool preserve_volume = false;
  int keyframe_interval = 1;  ///< told frames: every so many one is a keyframe, the others follow

  struct Keyframes {
    std::vector<KeyframeSpec> keys;
  };
  struct RootMotion {
    int cycles = 1;
    Vec3 along = Vec3::UnitX();
    std::optional<double> speed;      ///< model units a frame; none: that of the foot that stands
    std::vector<LocatedString> feet;  ///< for that
  };
  struct FootContacts {
    std::vector<LocatedString> feet;
    FootContactSearch search;
    Vec3 translation = Vec3::Zero();
    std::filesystem::path terrain;  ///< a mesh; "": none
    SourceLocation terrain_location;
    std::vector<LocatedString>
        unrotated;                    ///< handles that go with the mean of the feet and do not turn
    std::optional<double> clearance;  ///< none: as high above the ground as before
    double ground = 0;                ///< height of the ground before, along up
    bool rotations = false;
  };
  struct Path {
    std::vector<Vec3> through;
    int spans = 0;
    PathLengths lengths = PathLengths::Absolute;
    std::vector<LocatedString> feet;
    std::vector<LocatedString> unrotated;  ///< handles that stay on their way, whatever the feet do
    FootContactSearch search;
  };
  struct Filter {
    enum class Kind { Low, High, Cartoon } kind = Kind::Cartoon;
    std::vector<LocatedString> handles;
    double sigma = 2;  ///< frames
    double amount = 1;
    std::vector<LocatedString> feet;  ///< whose footprints stay as they are
    FootContactSearch search;
  };
  struct Mix {
    SequenceSource source;
    std::vector<SelectionSpec> selections;  ///< on the mesh of the source
    struct Pair {
      LocatedString handle;  ///< of this sequence
      LocatedString from;    ///< a selection of the source; "": nodes of the same numbers
    };
    std::vector<Pair> pairs;
    bool rotations = true;  ///< rotations carried along; false: places only
    /// How the source's trajectories are laid over those of the handles.
    enum class Align {
      All,   ///< by one similarity for all pairs, about up
      Each,  ///< each pair by one of its own
      Shift  ///< each pair by a shift alone: for handles that hardly move by themselves
    } align = Align::All;
  };
  struct Morph {
    SequenceSource target;
    MorphOptions options;  ///< intervals counted from 0; last -1: the last frame
    struct Landmark {
      Vec3 from, to;  ///< places of the first frames of both intervals
    };
    std::vector<Landmark> landmarks;  ///< none: the meshes have the same faces
    TargetFitOptions fit;
  };
  std::variant<Keyframes, RootMotion, FootContacts, Path, Filter, Mix, Morph> what;
};

/// [[picture]]: some frames side by side, or all of them as an animation.
struct SequencePicture {
  std::string file, title;
  enum class Show { Before, After, Both } show = Show::Both;
  int frames = 6;         ///< of a sheet; 0: all, of an animation
  bool together = false;  ///< all of them in one picture, where they are
  bool mesh = false;
  double azimuth = -30, elevation = 20, zoom = 1;
  double seconds = 0.05;  ///< a frame of an animation
  PictureSize size;
};

struct SequenceScene : SceneSelections {
  SequenceSource source;
  int up = 2;  ///< axis that points upwards, 0 (x) to 2 (z)
  std::vector<SequenceHandle> handles;
  std::vector<FeatureSpec> features;
  std::vector<SequenceOperation> steps;
  std::string frames_out;         ///< path in the output folder, SequenceWriter's
  double frames_per_second = 24;  ///< of a .glb whose frames have numbers instead of times
  std::vector<SequencePicture> pictures;

  Vec3 upwards() const { return Vec3::Unit(up); }
};

/// Whether a scene edits a sequence: it has [sequence]. Throws InputError when the file cannot be
/// read or is not TOML.
bool is_sequence_scene(const std::filesystem::path& file);

/// Reads a sequence scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
SequenceScene read_sequence_scene(const std::filesystem::path& file);
SequenceScene parse_sequence_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
