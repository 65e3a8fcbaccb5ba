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
#include "batten/mesh/sequence/fit_to_target.h"
#include "batten/mesh/sequence/footprints.h"
#include "batten/mesh/sequence/morph.h"
#include "batten/mesh/sequence/path.h"
#include "batten/mesh/sequence/sequence_editor.h"

namespace batten {

/// Frames of a file: [sequence], and further sequences in steps.
struct SequenceSource {
  std::filesystem::path path;
  FilePlace place;
  SequenceOptions options;
};

/// [[handle]]: a part of the mesh that steps move; its name stands for its vertices.
struct SequenceHandle {
  std::string name;
  FilePlace place;
  std::vector<PlacedWord> vertices;
  PlacedWord parent;  ///< another handle that it hangs on, for filters; "": the whole mesh
};

/// A keyframe of a step: handles moved in one frame.
struct KeyframeRule {
  int frame = 1;  ///< counted from 1, as all frames in scenes are
  FilePlace place;
  struct Move {
    PlacedWord handle;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0;
    std::optional<Vec3> about;  ///< centre of the turn; none: the handle's centroid in the frame
    bool turns_freely = false;
  };
  std::vector<Move> moves;
};

/// How feet that stay put are found.
struct FootprintSearch {
  double within = 0;  ///< model units; 0: a hundredth of the size
  int frames = 3;
};

/// One [[step]], which works on the result of the step before.
struct SequenceStep {
  std::string name;
  FilePlace place;
  std::vector<PlacedWord> fixed;  ///< nodes that stay where each frame has them
  SequenceEditOptions options;
  std::optional<double> softness;
  bool keeps_volume = false;
  int every = 1;  ///< told frames: every so many one is a keyframe, the others follow

  struct Keyframes {
    std::vector<KeyframeRule> keys;
  };
  struct Travel {
    int cycles = 1;
    Vec3 along = Vec3::UnitX();
    std::optional<double> speed;   ///< model units a frame; none: that of the foot that stands
    std::vector<PlacedWord> feet;  ///< for that
  };
  struct Footprints {
    std::vector<PlacedWord> feet;
    FootprintSearch search;
    Vec3 shift = Vec3::Zero();
    std::filesystem::path terrain;  ///< a mesh; "": none
    FilePlace terrain_place;
    std::vector<PlacedWord> upright;  ///< handles that go with the mean of the feet and do not turn
    std::optional<double> clearance;  ///< none: as high above the ground as before
    double ground = 0;                ///< height of the ground before, along up
    bool turns = false;
  };
  struct Path {
    std::vector<Vec3> through;
    int spans = 0;
    PathLengths lengths = PathLengths::Absolute;
    std::vector<PlacedWord> feet;
    std::vector<PlacedWord> upright;  ///< handles that stay on their way, whatever the feet do
    FootprintSearch search;
  };
  struct Filter {
    enum class Kind { Low, High, Cartoon } kind = Kind::Cartoon;
    std::vector<PlacedWord> handles;
    double sigma = 2;  ///< frames
    double amount = 1;
    std::vector<PlacedWord> feet;  ///< whose footprints stay as they are
    FootprintSearch search;
  };
  struct Mix {
    SequenceSource source;
    std::vector<SelectRule> selections;  ///< on the mesh of the source
    struct Pair {
      PlacedWord handle;  ///< of this sequence
      PlacedWord from;    ///< a selection of the source; "": nodes of the same numbers
    };
    std::vector<Pair> pairs;
    bool turns = true;  ///< rotations carried along; false: places only
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
  std::variant<Keyframes, Travel, Footprints, Path, Filter, Mix, Morph> what;
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
  std::vector<FeatureRule> features;
  std::vector<SequenceStep> steps;
  std::string frames_out;         ///< path in the output folder, SequenceWriter's
  double frames_per_second = 24;  ///< of a .glb whose frames have numbers instead of times
  std::vector<SequencePicture> pictures;

  Vec3 upwards() const { return Vec3::Unit(up); }
};

/// Whether a scene edits a sequence: it has [sequence]. Throws InputError when the file cannot be
/// read or is not TOML.
bool edits_a_sequence(const std::filesystem::path& file);

/// Reads a sequence scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
SequenceScene read_sequence_scene(const std::filesystem::path& file);
SequenceScene parse_sequence_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
