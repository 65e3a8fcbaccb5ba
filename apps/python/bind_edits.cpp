// Edits of a mesh that a scene says, with numbers that go on changing.
#include <fstream>
#include <sstream>

#include "batten/apps/commands/documents/edited_mesh.h"
#include "batten/apps/python/arrays.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/mesh_object.h"
#include "batten/apps/python/scenes.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/deform_scene.h"

namespace batten::python {
namespace {

using namespace py::literals;

/// A deform scene that is worked on. Functions take turns.
struct MeshEditObject {
  EditedMesh edited;
  std::vector<std::string> names;  // of all parameters
  std::shared_ptr<MeshObject> mesh;
  CallSerializer serialize;

  Points nodes() const { return node_positions(edited.shape(), mesh->source.file); }
};

std::string full_text(const std::string& file) {
  require_input_file(file, "an edit of a mesh", "");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::unique_ptr<MeshEditObject> new_mesh_edit(const py::object& path, const py::object& progress) {
  const std::string file = path_from(path);
  return KernelCall(progress)([&](const Progress& hook) {
    auto made = std::make_unique<MeshEditObject>();
    const std::string text = full_text(file);
    for (const Parameter& p : parse_deform_scene(text, file).parameters())
      made->names.push_back(p.name);
    made->edited.rebuild(SceneText(text, file), file, hook);
    if (!made->edited.problem().empty()) throw InputError(made->edited.problem());
    made->mesh = std::make_shared<MeshObject>(MeshObject{made->edited.source(), true});
    return made;
  });
}

void set_number(MeshEditObject& of, const std::string& name, double value) {
  KernelCall()([&](const Progress&) {
    of.serialize([&] {
      of.edited.check(name, value);
      if (!of.edited.moves(name))
        throw InputError("found '" + name + "', expected a number of the last edit's handles");
      of.edited.set(name, value);
    });
  });
}

double number_of(MeshEditObject& of, const std::string& name) {
  return KernelCall()(
      [&](const Progress&) { return of.serialize([&] { return of.edited.value(name); }); });
}

py::dict numbers_of(MeshEditObject& of) {
  py::dict values;
  for (const std::string& name : of.names) values[py::str(name)] = number_of(of, name);
  return values;
}

}  // namespace

void bind_edits(py::module_& m) {
  py::class_<MeshEditObject>(
      m, "MeshEdit",
      R"(The edits of a deform scene, live: numbers of the last edit's handles go on changing.

Features, guides and rows are those of the scene; factors are made once. What settle() gives is what
`batten deform` writes (docs/deform.md).)")
      .def(py::init(&new_mesh_edit), "path"_a, py::kw_only(), "progress"_a = py::none(),
           "Reads a deform scene and does its edits. Raises InputError, ConflictError, "
           "NoSolutionError.")
      .def_property_readonly("parameters", &numbers_of,
                             "Numbers of all edits, {\"EDIT.HANDLE.x\": value, …}.")
      .def("__setitem__", &set_number, "name"_a, "value"_a)
      .def("__getitem__", &number_of, "name"_a)
      .def(
          "answer",
          [](MeshEditObject& of) {
            return KernelCall()([&](const Progress&) {
              return of.serialize([&] { return of.edited.solve_preview(); });
            });
          },
          "The shape for a drag, a pair of triangular solves; True when features rest. Raises as "
          "settle().")
      .def(
          "settle",
          [](MeshEditObject& of) {
            KernelCall()(
                [&](const Progress&) { of.serialize([&] { of.edited.solve_to_equilibrium(); }); });
          },
          "The shape at rest. Raises ConflictError, NoSolutionError; shape and numbers then go "
          "back.")
      .def_property_readonly(
          "points",
          [](MeshEditObject& of) {
            return array_of(KernelCall()(
                [&](const Progress&) { return of.serialize([&] { return of.nodes(); }); }));
          },
          "Places of the nodes, n×3 float64, an array of its own.")
      .def_readonly("mesh", &MeshEditObject::mesh, "The Mesh as it was read.");
}

}  // namespace batten::python
