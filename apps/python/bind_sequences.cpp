// Binds sequences of deforming meshes, with their frames as arrays.
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/io/sequences/sequence_files.h"

namespace batten::python {
namespace {

using namespace py::literals;
using SequencePtr = std::shared_ptr<MeshSequence>;

SequencePtr frames_of_file(const py::object& path, int first, int last,
                           const py::object& progress) {
  const std::string file = path_from(path);
  SequenceOptions options;
  options.first = first;
  options.last = last;
  return KernelCall(progress)([&](const Progress& hook) {
    return std::make_shared<MeshSequence>(read_sequence(file, options, hook));
  });
}

py::array frame_points(const SequencePtr& sequence, int index) {
  const int count = sequence->frame_count();
  if (index < -count || index >= count)
    throw py::index_error("found frame " + std::to_string(index));
  const Points& points = sequence->frames[static_cast<size_t>(index < 0 ? index + count : index)];
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(sequence, points.data(), {points.rows(), 3}, {size, points.rows() * size});
}

py::list sequence_faces(const MeshSequence& sequence) {
  py::list faces;
  for (int f = 0; f < sequence.shells.face_count(); ++f) {
    const auto corners = sequence.shells.corners(f);
    py::tuple face(corners.size());
    for (size_t i = 0; i < corners.size(); ++i) face[i] = corners[i];
    faces.append(face);
  }
  return faces;
}

}  // namespace

void bind_sequences(py::module_& m) {
  py::class_<MeshSequence, SequencePtr>(
      m, "Sequence", "A mesh sequence: frames with the same connectivity. Immutable.")
      .def("__len__", &MeshSequence::frame_count)
      .def("__getitem__", &frame_points, "index"_a,
           "Node positions of a frame (from 0), n×3 float64. A view.")
      .def_property_readonly(
          "times",
          [](const MeshSequence& sequence) {
            return array_of(std::vector<double>(sequence.times));
          },
          "Times of the frames: seconds, or frame numbers.")
      .def_property_readonly("faces", &sequence_faces, "Node indices of each face, as tuples.");
  m.def("read_sequence", &frames_of_file, "path"_a, py::kw_only(), "first"_a = 1, "last"_a = 0,
        "progress"_a = py::none(),
        R"(Reads a mesh sequence: numbered files, .pvd, .pc2, .mdd, .gltf, .glb, .frd.

`first`, `last`: frames to read, counted from 1; `last` = 0: to the end. Raises InputError.)");
}

}  // namespace batten::python
