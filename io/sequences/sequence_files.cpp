// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sequences/sequence_files.h"

#include <map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/io/decks/frd_results.h"
#include "batten/io/files/text.h"

namespace batten {

FrameRange frame_range(const SequenceOptions& options, long all, const std::string& name) {
  const long last = options.last == 0 ? all : options.last;
  if (options.first < 1 || last < options.first || last > all)
    throw InputError(name + ": found " + format_count(all, "frame") + ", expected frames " +
                     std::to_string(options.first) + " to " +
                     (options.last == 0 ? "the end" : std::to_string(last)));
  return {options.first - 1, static_cast<int>(last - options.first + 1)};
}

void require_frame_memory(const std::filesystem::path& file, long frames, long points) {
  const double bytes = 3.0 * sizeof(double) * static_cast<double>(frames);
  require_memory(bytes * static_cast<double>(points), file.string() + ": reading " +
                                                          format_count(frames, "frame") + " of " +
                                                          format_count(points, "point"));
}

MeshSequence read_frames(const std::filesystem::path& path, const SequenceOptions& options,
                         const Progress& progress) {
  static const std::map<std::string, SequenceReader*> readers{
      {".pvd", read_pvd_sequence},   {".pc2", read_pc2_sequence},  {".mdd", read_mdd_sequence},
      {".gltf", read_gltf_sequence}, {".glb", read_gltf_sequence}, {".frd", read_frd_sequence}};
  std::error_code ignored;
  const auto found = std::filesystem::is_directory(path, ignored)
                         ? readers.end()
                         : readers.find(lower_extension(path));
  SequenceReader* const read = found == readers.end() ? read_numbered_sequence : found->second;
  MeshSequence sequence = read(path, options, progress);
  check(sequence, path.string());
  sequence.shells.points = sequence.frames.front();
  return sequence;
}

// CalculiX results as frames: the outer skin of the model in each step.

namespace {

/// Faces of the skin, and the model node of each of its nodes.
struct Skin {
  ShellMesh shells;
  std::vector<int> nodes;
};

Skin skin_of(const FrdMesh& mesh, const std::string& name) {
  std::vector<FrdFace> faces;
  try {
    faces = outer_faces(mesh);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
  if (faces.empty())
    throw InputError(name + ": found no solids or shells with faces, expected at least one");
  std::vector<int> number(mesh.labels.size(), -1);
  for (const FrdFace& face : faces)
    for (const int node : face.nodes) number[node] = 0;
  Skin skin;
  for (int i = 0; i < isize(number); ++i)
    if (number[i] == 0) {
      number[i] = isize(skin.nodes);
      skin.nodes.push_back(i);
    }
  for (FrdFace& face : faces) {
    for (int& node : face.nodes) node = number[node];
    skin.shells.add_face(face.nodes, face.second_order);
  }
  skin.shells.points = mesh.points(skin.nodes, Eigen::all);
  return skin;
}

}  // namespace

MeshSequence read_frd_sequence(const std::filesystem::path& path, const SequenceOptions& options,
                               const Progress& progress) {
  progress.update("reading results", 0);
  MeshSequence sequence;
  Skin skin;
  std::vector<double> values;
  read_frd_steps(path, [&](const FrdMesh& mesh, double value, const Points& displacements) {
    if (values.empty()) skin = skin_of(mesh, path.string());
    progress.update("reading results", 0);
    values.push_back(value);
    const int k = isize(values);
    if (k < options.first || (options.last > 0 && k > options.last)) return;
    sequence.frames.push_back(Points(mesh.points + displacements)(skin.nodes, Eigen::all));
  });
  sequence.shells = std::move(skin.shells);
  const FrameRange range = frame_range(options, isize(values), path.string());
  bool ascend = true;
  for (size_t k = 1; k < values.size(); ++k) ascend = ascend && values[k] > values[k - 1];
  for (int k = range.first; k < range.first + range.count; ++k)
    sequence.times.push_back(ascend ? values[static_cast<size_t>(k)] : k + 1);
  return sequence;
}

}  // namespace batten
