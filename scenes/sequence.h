// SPDX-License-Identifier: MPL-2.0
// Sequences of deforming meshes, and their edits.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/progress.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/scenes/mesh.h"

namespace batten {

struct SequenceSettings;
struct MorphSettings;
namespace detail {
struct SequenceData;  // scenes/sequence_data.h
}

/// A sequence of a deforming mesh: frames with the same faces, from files or from arrays.
///
///     const Sequence walk = read_sequence("walker.pc2");
///     SequenceSettings settings;
///     settings.handles = {{"left", walk.mesh().vertices_in({-1, 0, 0}, {1, 1, 0.08})},
///                         {"right", walk.mesh().vertices_in({-1, -1, 0}, {1, 0, 0.08})}};
///     settings.meshes.emplace("stairs", read_mesh("stairs.obj"));
///     const Sequence climb = walk.edited(R"(
///       [[operation]]
///       type = "foot_plants"
///       feet = ["left", "right"]
///       terrain = { file = "stairs" })", settings);
///     climb.save("climb.pc2");
///
/// A sequence is an immutable value: copies share their data, and cost nothing. All functions may
/// be called by several threads at once. Frames and vertices are numbered from 0, except in the text
/// of scenes, where frames are numbered from 1. Lengths are in the unit of the vertex positions.
///
/// The functions that edit a sequence give the frames of `batten sequence` for the same operations,
/// to the last bit (docs/sequence.md). They throw InputError for invalid settings and unknown names,
/// with the nearest name; ConflictError, NoSolutionError, CancelledError.
/// Reference: [Xu2007].
class Sequence {
 public:
  /// A sequence of `frames`, n×3 each, and `faces` as those of a Mesh. `times`: one ascending time
  /// per frame; empty: 1, 2, … Throws InputError for invalid faces, as Mesh, or if check() of
  /// mesh/sequence/mesh_sequence.h rejects the frames.
  Sequence(std::vector<Points> frames, const std::vector<std::vector<int>>& faces,
           std::vector<double> times = {});
  /// A sequence with the faces of a mesh.
  Sequence(std::vector<Points> frames, const Mesh& mesh, std::vector<double> times = {});
  explicit Sequence(std::shared_ptr<const detail::SequenceData> data) : data_(std::move(data)) {}

  int frame_count() const;
  /// Vertex positions of a frame, n×3. Throws InputError if there is no such frame.
  const Points& frame(int index) const;
  const std::vector<double>& times() const;  ///< seconds, or frame numbers
  /// Vertices of the corners of each face, in order around it. O(faces).
  std::vector<std::vector<int>> faces() const;
  /// The mesh in a frame. Throws as frame(), and as read_mesh() for a mesh that prepare()
  /// (mesh/prepared_mesh.h) rejects. O(n log n).
  Mesh mesh(int frame = 0) const;

  /// Writes the sequence and returns the files. The path selects the format: "out/walk_*.obj" (.obj
  /// .off .ply .stl .vtp .vtu) for numbered files, .pvd, .pc2, .mdd or .glb (SequenceWriter in
  /// io/sequences/sequence_writer.h). Existing files of these names are replaced; numbered files
  /// with other numbers remain.
  ///
  /// `frames_per_second`: frame rate of a .glb file, if the times are frame numbers. Throws
  /// InputError, FileError, CancelledError.
  std::vector<std::filesystem::path> save(const std::filesystem::path& file,
                                          double frames_per_second = 24,
                                          const Progress& progress = {}) const;

  // Edits.

  /// Applies the operations of a scene in order. `scene`: the text of a sequence scene without
  /// [sequence], [output] and [[picture]] (docs/sequence.md). `unit` is optional in it.
  Sequence edited(const std::string& scene, const Progress& progress = {}) const;
  Sequence edited(const std::string& scene, const SequenceSettings& settings,
                  const Progress& progress = {}) const;

  // Single operations. `keys`: further keys of the operation, as in an inline table of a scene:
  // "iterations = 200, weights = 'cotangent'".

  /// Moves handles in keyframes: {frame: {handle: move from its position in this frame}}, and all
  /// other frames accordingly (operation "keyframes"). `influence`: first and last frame that may
  /// change, see docs/sequence.md; empty: all frames change. Moves must have the scale 1.
  Sequence keyframes(const std::map<int, std::map<std::string, Move>>& moves,
                     const SequenceSettings& settings,
                     const std::optional<std::pair<int, int>>& influence = {},
                     const std::string& keys = "", const Progress& progress = {}) const;
  /// Filters the trajectories of all handles: "cartoon" [Wang2006], "low" or "high" (operation
  /// "filter"). `sigma`: standard deviation of the Gaussian, frames, above 0.
  Sequence filter(const std::string& kind, const SequenceSettings& settings, double sigma = 2,
                  const std::string& keys = "", const Progress& progress = {}) const;
  /// Transfers the motion of vertices of another sequence to handles (operation "mix"). `from`:
  /// {handle: vertices of `source`}; without vertices, those with the numbers of the handle.
  Sequence mix(const Sequence& source, const std::map<std::string, std::vector<int>>& from,
               const SequenceSettings& settings, const std::string& keys = "",
               const Progress& progress = {}) const;
  /// Blends the sequence into another one (operation "morph").
  Sequence morph(const Sequence& target, const Progress& progress = {}) const;
  Sequence morph(const Sequence& target, const MorphSettings& settings,
                 const Progress& progress = {}) const;

  // Results of the edit that the sequence comes from; empty for other sequences.

  /// Everything that was measured, as the JSON text of report.json (docs/sequence.md).
  const std::string& report() const;
  const std::vector<std::string>& warnings() const;
  /// The failed checks as sentences with the measured value.
  const std::vector<std::string>& failed_checks() const;

  // For Batten's own front ends.
  const detail::SequenceData& data() const { return *data_; }
  const std::shared_ptr<const detail::SequenceData>& shared_data() const { return data_; }

 private:
  std::shared_ptr<const detail::SequenceData> data_;
};

/// What the operations on a sequence move and keep, and what their text refers to by name. Vertices
/// are numbered from 0; the names of all groups must differ.
struct SequenceSettings {
  std::vector<int> fixed = {};             ///< vertices that keep their position in each frame
  std::vector<VertexGroup> handles = {};   ///< groups that operations move
  std::vector<VertexGroup> features = {};  ///< groups that keep their shape and may rotate
  /// Features that keep their orientation, too.
  std::vector<VertexGroup> keep_orientation = {};
  std::string up = "";  ///< vertical axis: "x", "y", "z"; empty: that of the text, or "z"
  /// Parents of handles, {handle: parent}, relative to which the motion is filtered.
  std::map<std::string, std::string> parents = {};
  std::vector<VertexGroup> selections = {};  ///< further vertices, such as "fixed" of one operation
  /// Sequences for source = { file = NAME } and target = { file = NAME }, in place of files.
  std::map<std::string, Sequence> sequences = {};
  /// Meshes for terrain = { file = NAME }, in place of files.
  std::map<std::string, Mesh> meshes = {};
};

/// Options of Sequence::morph(). Frames are numbered from 0.
struct MorphSettings {
  /// First and last frame that are blended, of the sequence and of the target; empty: all frames.
  std::optional<std::pair<int, int>> interval = {}, target_interval = {};
  int frames = 0;  ///< number of frames of the morph, 2 or more; 0: the mean of the intervals
  /// Corresponding points (from the sequence, on the target) in the first frames of the intervals:
  /// at least four that are not coplanar. Empty: both sequences have the same faces.
  std::vector<std::pair<Vec3, Vec3>> landmarks = {};
  std::string up = "z";   ///< vertical axis: "x", "y", "z"
  std::string keys = "";  ///< further keys of the operation, as in an inline table of a scene
};

/// Reads a sequence: numbered mesh files, .pvd, .pc2, .mdd, .gltf, .glb, .frd. Frames of the options
/// are numbered from 1. Throws InputError, which begins with the file name; CancelledError.
Sequence read_sequence(const std::filesystem::path& file, const SequenceOptions& options = {},
                       const Progress& progress = {});

}  // namespace batten
