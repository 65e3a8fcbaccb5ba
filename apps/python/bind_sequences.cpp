// SPDX-License-Identifier: MPL-2.0
// Binds sequences of deforming meshes, with their frames as arrays, and their edits.
#include <optional>
#include <utility>

#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/toml_values.h"
#include "batten/core/errors.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/sequence_data.h"

namespace batten::python {
namespace {

using namespace py::literals;

// Frames.

std::vector<Points> frames_from(const py::object& given) {
  if (!py::isinstance<py::iterable>(given))
    refuse_setting(given, "frames", "an array k×n×3, or a list of arrays n×3");
  std::vector<Points> frames;
  for (const py::handle frame : given)
    frames.push_back(points_from(frame, "frames[" + std::to_string(frames.size()) + "]"));
  return frames;
}

Sequence new_sequence(const py::object& given, const py::object& faces, const py::object& times) {
  std::vector<Points> frames = frames_from(given);
  std::vector<double> at;
  if (!times.is_none()) {
    at = numbers_from(times, "times");
    if (at.size() != frames.size())
      throw InputError("times: found " + std::to_string(at.size()) + ", expected " +
                       std::to_string(frames.size()) + ", one for each frame");
  }
  std::optional<Mesh> mesh;
  std::vector<std::vector<int>> lists;
  if (py::isinstance<Mesh>(faces))
    mesh = faces.cast<Mesh>();
  else
    lists = faces_from(faces, "faces");
  return KernelCall()([&](const Progress&) {
    return mesh ? Sequence(std::move(frames), *mesh, std::move(at))
                : Sequence(std::move(frames), lists, std::move(at));
  });
}

Sequence sequence_of_file(const py::object& path, int first, int last, const py::object& mesh,
                          bool gaps, const std::string& animation, double frames_per_second,
                          bool weld, const py::object& progress) {
  const std::string file = path_from(path);
  SequenceOptions options;
  options.first = first;
  options.last = last;
  if (!mesh.is_none()) options.mesh = path_from(mesh);
  options.allow_gaps = gaps;
  options.animation = animation;
  options.frames_per_second = frames_per_second;
  options.weld_seams = weld;
  return KernelCall(progress)(
      [&](const Progress& hook) { return read_sequence(file, options, hook); });
}

py::array frame_points(const Sequence& sequence, int index) {
  const int count = sequence.frame_count();
  if (index < -count || index >= count)
    throw py::index_error("found frame " + std::to_string(index) + ", expected " +
                          std::to_string(-count) + " to " + std::to_string(count - 1));
  const Points& points = sequence.frame(index < 0 ? index + count : index);
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(sequence.shared_data(), points.data(), {points.rows(), 3},
                    {size, points.rows() * size});
}

py::list frame_list(const Sequence& sequence) {
  py::list frames;
  for (int k = 0; k < sequence.frame_count(); ++k) frames.append(frame_points(sequence, k));
  return frames;
}

py::list sequence_faces(const Sequence& sequence) {
  py::list faces;
  for (const std::vector<int>& face : sequence.faces()) faces.append(py::tuple(py::cast(face)));
  return faces;
}

py::list save_frames(const Sequence& sequence, const py::object& path, double frames_per_second,
                     const py::object& progress) {
  const std::string file = path_from(path);
  const auto files = KernelCall(progress)(
      [&](const Progress& hook) { return sequence.save(file, frames_per_second, hook); });
  py::list names;
  for (const std::filesystem::path& one : files) names.append(one.string());
  return names;
}

py::tuple sequence_state(const Sequence& sequence) {
  return py::make_tuple(frame_list(sequence), py::cast(sequence.mesh()), sequence.times(),
                        sequence.report(), sequence.warnings(), sequence.failed_checks());
}

Sequence sequence_of_state(const py::tuple& state) {
  using Texts = std::vector<std::string>;
  const Sequence frames(frames_from(state[0]), state[1].cast<Mesh>(),
                        state[2].cast<std::vector<double>>());
  return Sequence(std::make_shared<const detail::SequenceData>(
      detail::SequenceData{frames.data().frames, state[3].cast<std::string>(),
                           state[4].cast<Texts>(), state[5].cast<Texts>()}));
}

std::string sequence_repr(const Sequence& sequence) {
  const MeshSequence& frames = sequence.data().frames;
  return "<batten.Sequence: " + std::to_string(frames.frame_count()) + " frames, " +
         std::to_string(frames.node_count()) + " vertices, " +
         std::to_string(frames.shells.face_count()) + " faces>";
}

// Edits.

std::vector<VertexGroup> vertex_groups(const py::dict& given, const std::string& what, int count) {
  std::vector<VertexGroup> groups;
  for (const auto& [key, vertices] : given) {
    const std::string name = py::str(key);
    groups.push_back({name, indices_from(vertices, what + "['" + name + "']", count)});
  }
  return groups;
}

/// The arguments that all edits have.
struct GroupArguments {
  py::dict handles, features, keep_orientation;
  py::object fixed;
  std::string up;
};

SequenceSettings settings_from(const Sequence& sequence, const GroupArguments& given) {
  const int count = sequence.data().frames.node_count();
  SequenceSettings settings;
  settings.handles = vertex_groups(given.handles, "handles", count);
  settings.features = vertex_groups(given.features, "features", count);
  settings.keep_orientation = vertex_groups(given.keep_orientation, "keep_orientation", count);
  settings.fixed = indices_from(given.fixed, "fixed", count);
  settings.up = given.up;
  return settings;
}

std::map<std::string, std::string> parents_from(const py::dict& given) {
  std::map<std::string, std::string> parents;
  for (const auto& [child, parent] : given) {
    if (!py::isinstance<py::str>(parent))
      refuse_setting(parent, "parents['" + std::string(py::str(child)) + "']",
                     "the name of a handle");
    parents[py::str(child)] = py::str(parent);
  }
  return parents;
}

/// Objects of a class by name.
template <class Object>
std::map<std::string, Object> objects_from(const py::dict& given, const std::string& what,
                                           const std::string& expected) {
  std::map<std::string, Object> objects;
  for (const auto& [key, object] : given) {
    const std::string name = py::str(key);
    if (!py::isinstance<Object>(object))
      refuse_setting(object, what + "['" + name + "']", expected);
    objects.emplace(name, object.template cast<Object>());
  }
  return objects;
}

std::vector<std::string> operations_from(const py::object& given) {
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given))
    refuse_setting(given, "operations", "a list of dicts such as {'type': 'filter', …}");
  std::vector<std::string> operations;
  for (const py::handle one : given) {
    const std::string label = "operations[" + std::to_string(operations.size()) + "]";
    if (!py::isinstance<py::dict>(one))
      refuse_setting(one, label, "a dict such as {'type': 'filter', …}");
    operations.push_back(toml_from(one, label));
  }
  return operations;
}

/// Further keys of an operation, as in an inline table. `caller`: the function, for messages.
std::string keys_from(const py::kwargs& given, const std::string& caller) {
  std::string keys;
  for (const auto& [name, value] : given) {
    const std::string key = toml_key(name, caller);
    keys += (keys.empty() ? "" : ", ") + key + " = " + toml_from(value, caller + ": " + key);
  }
  return keys;
}

/// First and last frame of a range, or none.
std::optional<std::pair<int, int>> range_from(const py::object& given, const std::string& what) {
  if (given.is_none()) return {};
  constexpr int most = 1 << 30;
  const std::vector<int> range = indices_from(given, what, most);
  constexpr size_t both = 2;
  if (range.size() != both || range[1] < range[0])
    refuse_setting(given, what, "two frames, the first one not after the last one");
  return std::pair(range[0], range[1]);
}

Sequence edited_frames(const Sequence& sequence, const std::string& scene,
                       const py::object& operations, const py::dict& handles,
                       const py::dict& features, const py::dict& keep_orientation,
                       const py::dict& parents, const py::dict& selections, const py::object& fixed,
                       const py::dict& sequences, const py::dict& meshes, const std::string& up,
                       const py::object& folder, const py::object& progress) {
  SequenceSettings settings =
      settings_from(sequence, {handles, features, keep_orientation, fixed, up});
  settings.parents = parents_from(parents);
  settings.selections =
      vertex_groups(selections, "selections", sequence.data().frames.node_count());
  settings.sequences = objects_from<Sequence>(sequences, "sequences", "a Sequence");
  settings.meshes = objects_from<Mesh>(meshes, "meshes", "a Mesh");
  detail::SequenceEditText text;
  text.operations = operations_from(operations);
  text.scene = scene;
  text.folder = path_from(folder);
  return KernelCall(progress)(
      [&](const Progress& hook) { return detail::edited(sequence, text, settings, hook); });
}

/// Moves of handles in keyframes, {frame: {handle: Move}}.
std::map<int, std::map<std::string, Move>> keyframes_from(const Sequence& sequence,
                                                          const py::dict& given) {
  std::map<int, std::map<std::string, Move>> keyframes;
  for (const auto& [key, moves] : given) {
    const std::string label = "moves[" + std::string(py::repr(key)) + "]";
    if (!py::isinstance<py::int_>(key) || !py::isinstance<py::dict>(moves))
      refuse_setting(moves, label, "a dict {handle: Move} for the number of a frame");
    int frame = key.cast<int>();
    if (frame < 0) frame += sequence.frame_count();
    keyframes[frame] = objects_from<Move>(py::reinterpret_borrow<py::dict>(moves), label, "a Move");
  }
  return keyframes;
}

Sequence keyframe_edit(const Sequence& sequence, const py::dict& moves, const py::dict& handles,
                       const py::dict& features, const py::dict& keep_orientation,
                       const py::object& fixed, const py::object& influence,
                       const py::object& progress, const py::kwargs& keys) {
  const SequenceSettings settings =
      settings_from(sequence, {handles, features, keep_orientation, fixed, ""});
  const auto keyframes = keyframes_from(sequence, moves);
  const auto range = range_from(influence, "influence");
  const std::string more = keys_from(keys, "keyframes()");
  return KernelCall(progress)([&](const Progress& hook) {
    return sequence.keyframes(keyframes, settings, range, more, hook);
  });
}

Sequence filtered_frames(const Sequence& sequence, const std::string& kind, const py::dict& handles,
                         const py::dict& parents, const py::dict& features,
                         const py::dict& keep_orientation, const py::object& fixed, double sigma,
                         const py::object& progress, const py::kwargs& keys) {
  SequenceSettings settings =
      settings_from(sequence, {handles, features, keep_orientation, fixed, ""});
  settings.parents = parents_from(parents);
  const std::string more = keys_from(keys, "filter()");
  return KernelCall(progress)(
      [&](const Progress& hook) { return sequence.filter(kind, settings, sigma, more, hook); });
}

Sequence mixed_frames(const Sequence& sequence, const Sequence& source,
                      const py::object& source_vertices, const py::dict& handles,
                      const py::dict& features, const py::dict& keep_orientation,
                      const py::object& fixed, const std::string& up, const py::object& progress,
                      const py::kwargs& keys) {
  const SequenceSettings settings =
      settings_from(sequence, {handles, features, keep_orientation, fixed, up});
  std::map<std::string, std::vector<int>> from;
  if (source_vertices.is_none())
    for (const VertexGroup& handle : settings.handles) from[handle.name] = {};
  else if (!py::isinstance<py::dict>(source_vertices))
    refuse_setting(source_vertices, "source_vertices", "a dict {handle: vertices of the source}");
  else
    for (VertexGroup& group : vertex_groups(source_vertices.cast<py::dict>(), "source_vertices",
                                            source.data().frames.node_count()))
      from[group.name] = std::move(group.vertices);
  const std::string more = keys_from(keys, "mix()");
  return KernelCall(progress)(
      [&](const Progress& hook) { return sequence.mix(source, from, settings, more, hook); });
}

Sequence morphed_frames(const Sequence& sequence, const Sequence& target,
                        const py::object& interval, const py::object& target_interval, int frames,
                        const py::object& landmarks, const std::string& up,
                        const py::object& progress, const py::kwargs& keys) {
  MorphSettings settings;
  settings.interval = range_from(interval, "interval");
  settings.target_interval = range_from(target_interval, "target_interval");
  settings.frames = frames;
  settings.up = up;
  settings.keys = keys_from(keys, "morph()");
  constexpr size_t both = 2;
  for (const py::handle pair : landmarks) {
    const std::string label = "landmarks[" + std::to_string(settings.landmarks.size()) + "]";
    if (!py::isinstance<py::sequence>(pair) || py::len(pair) != both)
      refuse_setting(pair, label, "two points: of the sequence, and on the target");
    const auto points = py::reinterpret_borrow<py::sequence>(pair);
    settings.landmarks.emplace_back(vector_from(points[0], label), vector_from(points[1], label));
  }
  return KernelCall(progress)(
      [&](const Progress& hook) { return sequence.morph(target, settings, hook); });
}

using SequenceClass = py::class_<Sequence>;

void bind_frames(SequenceClass& c) {
  c.def(
       py::init(&new_sequence), "frames"_a, "faces"_a, "times"_a = py::none(),
       R"(A sequence of frames k×n×3 and faces (as in Mesh: m×3, m×4, or lists of vertices; or a Mesh).

`times`: one ascending time per frame (default: 1, 2, …). Raises InputError.)")
      .def("__len__", &Sequence::frame_count)
      .def("__getitem__", &frame_points, "index"_a,
           "Vertex positions of a frame (from 0), n×3 float64. A view.")
      .def("__iter__", [](const Sequence& sequence) { return py::iter(frame_list(sequence)); })
      .def_property_readonly(
          "times",
          [](const Sequence& sequence) { return array_of(std::vector<double>(sequence.times())); },
          "Times of the frames: seconds, or frame numbers.")
      .def_property_readonly("faces", &sequence_faces,
                             "Vertices of the corners of each face, as tuples.")
      .def(
          "mesh",
          [](const Sequence& sequence, int frame) {
            return KernelCall()([&](const Progress&) { return sequence.mesh(frame); });
          },
          "frame"_a = 0, "The Mesh in a frame (from 0), as for selections by vertices_in().")
      .def("save", &save_frames, "path"_a, py::kw_only(), "frames_per_second"_a = 24.0,
           "progress"_a = py::none(),
           R"(Writes the sequence; returns the names of the files.

"out/walk_*.obj" (.obj .off .ply .stl .vtp .vtu) for numbered files, .pvd, .pc2, .mdd, .glb. Replaces
files of the same names. `frames_per_second`: for a .glb, if the times are frame numbers. Raises
InputError, FileError.)")
      .def_property_readonly(
          "report",
          [](const Sequence& sequence) -> py::object {
            if (sequence.report().empty()) return py::dict();
            return json_object(sequence.report());
          },
          "What the edit measured, as in report.json (docs/sequence.md); {} without an edit.")
      .def_property_readonly("warnings", &Sequence::warnings, "Warnings of the edit, as sentences.")
      .def_property_readonly("failed_checks", &Sequence::failed_checks,
                             "The failed checks of the edit, as sentences with the amount.")
      .def("__repr__", &sequence_repr)
      .def("__copy__", [](const py::object& self) { return self; })
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, "memo"_a)
      .def(py::pickle(&sequence_state, &sequence_of_state));
}

void bind_sequence_edits(SequenceClass& c) {
  c.def("edited", &edited_frames, "scene"_a = "", py::kw_only(), "operations"_a = py::tuple(),
        "handles"_a = py::dict(), "features"_a = py::dict(), "keep_orientation"_a = py::dict(),
        "parents"_a = py::dict(), "selections"_a = py::dict(), "fixed"_a = py::tuple(),
        "sequences"_a = py::dict(), "meshes"_a = py::dict(), "up"_a = "", "folder"_a = "",
        "progress"_a = py::none(),
        R"(Applies operations of `batten sequence` in order; same result, to the last bit.

`scene`: text of a sequence scene without [sequence], [output], [[picture]]. `operations`: dicts with
the keys of [[operation]] instead, such as {"type": "path", "through": …} (docs/sequence.md; they
number frames from 1). `handles`, `features`, `keep_orientation` (features that do not rotate),
`selections`: {name: vertices}. `parents`: {handle: parent}. `fixed`: vertices that stay in place.
`sequences`, `meshes`: objects that "file" refers to by name, for sources, targets and terrains.
`up`: "x", "y", "z" (default "z"). Raises InputError, ConflictError, NoSolutionError.
Reference: Xu et al. 2007, Gradient domain editing of deforming mesh sequences.)")
      .def("keyframes", &keyframe_edit, "moves"_a, py::kw_only(), "handles"_a,
           "features"_a = py::dict(), "keep_orientation"_a = py::dict(), "fixed"_a = py::tuple(),
           "influence"_a = py::none(), "progress"_a = py::none(),
           R"(Moves handles in keyframes {frame: {handle: Move}}, and all other frames accordingly.

Frames from 0; a Move is relative to the position in that frame. `influence`: first and last frame
that change the rest (default: all). Further keywords: keys of the operation "keyframes"
(docs/sequence.md), such as iterations=200. Otherwise as edited().)")
      .def("filter", &filtered_frames, "filter"_a, py::kw_only(), "handles"_a,
           "parents"_a = py::dict(), "features"_a = py::dict(), "keep_orientation"_a = py::dict(),
           "fixed"_a = py::tuple(), "sigma"_a = 2.0, "progress"_a = py::none(),
           R"(Filters the trajectories of all handles: "cartoon", "low" or "high".

`sigma`: width, frames. Further keywords: keys of the operation "filter", such as amount=1 and
feet=["left"]. Otherwise as edited(). Reference: Wang et al. 2006, The cartoon animation filter.)")
      .def("mix", &mixed_frames, "source"_a, "source_vertices"_a = py::none(), py::kw_only(),
           "handles"_a, "features"_a = py::dict(), "keep_orientation"_a = py::dict(),
           "fixed"_a = py::tuple(), "up"_a = "", "progress"_a = py::none(),
           R"(Transfers the motion of vertices of another sequence to handles.

`source_vertices`: {handle: vertices of `source`}; None: those with the same numbers. Further
keywords: keys of the operation "mix", such as align="each". Otherwise as edited().)")
      .def("morph", &morphed_frames, "target"_a, py::kw_only(), "interval"_a = py::none(),
           "target_interval"_a = py::none(), "frames"_a = 0, "landmarks"_a = py::tuple(),
           "up"_a = "z", "progress"_a = py::none(),
           R"(Blends the sequence into another one.

`interval`, `target_interval`: first and last frame (from 0) that are blended (default: all).
`frames`: length of the morph (0: mean of the intervals). `landmarks`: pairs of corresponding points
(of the sequence, on the target), if the faces differ. Further keywords: keys of the operation
"morph", such as align={"translate": [1, 0, 0]}. Otherwise as edited().)");
}

}  // namespace

void bind_sequences(py::module_& m) {
  SequenceClass c(m, "Sequence",
                  R"(A sequence of a deforming mesh: frames with the same faces. Immutable.

Sequences can be copied and pickled. Edits return new sequences:

    >>> walk = batten.read_sequence("examples/24-stairs/walker.pc2")
    >>> hand = walk.mesh().vertices_in([-1, 0.2, 0.5], [1, 1, 0.85])
    >>> foot = walk.mesh().vertices_in([-1, -1, -0.1], [1, 1, 0.08])
    >>> wave = walk.keyframes({8: {"hand": batten.Move(translate=[0, 0, 0.2])}},
    ...                       handles={"hand": hand}, fixed=foot)
    >>> print(round(float((wave[8] - walk[8])[hand, 2].mean()), 6))
    0.2)");
  bind_frames(c);
  bind_sequence_edits(c);
  m.def("read_sequence", &sequence_of_file, "path"_a, py::kw_only(), "first"_a = 1, "last"_a = 0,
        "mesh"_a = py::none(), "gaps"_a = false, "animation"_a = "", "frames_per_second"_a = 24.0,
        "weld"_a = true, "progress"_a = py::none(),
        R"(Reads a sequence: numbered files, .pvd, .pc2, .mdd, .gltf, .glb, .frd.

`first`, `last`: frames to read, counted from 1; `last` = 0: to the end. `mesh`: file with the faces
of a point cache (default: beside it). `gaps`: numbers of files may be missing. `animation` (name or
number), `frames_per_second`, `weld` (coinciding vertices): for glTF. Raises InputError.

    >>> len(batten.read_sequence("examples/24-stairs/walker.pc2", last=5))
    5)");
}

}  // namespace batten::python
