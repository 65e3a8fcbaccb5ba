// SPDX-License-Identifier: MPL-2.0
// Binds the constraints of deformers.
#include <limits>
#include <optional>
#include <utility>

#include "batten/apps/python/bindings.h"
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/deformer_constraints.h"
#include "batten/core/errors.h"

namespace batten::python {
namespace {

using namespace py::literals;

constexpr int kAnyCount = std::numeric_limits<int>::max();  // the mesh is not known yet

Vec3 direction_from(const py::object& given, const std::string& what) {
  const Vec3 direction = vector_from(given, what);
  if (direction.norm() == 0) throw InputError(what + ": found length 0, expected a direction");
  return direction;
}

py::object array_or_none(const std::optional<Vec3>& point) {
  return point ? py::object(array_of(*point)) : py::object(py::none());
}

/// An OnPlane or OnLine of Python. Its vertices stay as given, because they may be a mask, whose
/// size must be that of the mesh.
template <class Constraint>
struct SlidingObject {
  py::array vertices;
  Vec3 direction;
  std::optional<Vec3> origin;
};

constexpr const char* direction_name(const SlidingObject<OnPlane>&) { return "normal"; }
constexpr const char* direction_name(const SlidingObject<OnLine>&) { return "direction"; }

template <class Constraint>
SlidingObject<Constraint> new_sliding(const py::object& vertices, const py::object& direction,
                                      const py::object& origin) {
  SlidingObject<Constraint> made;
  const py::array any = py::array::ensure(vertices);
  const bool mask = any && any.dtype().kind() == 'b' && any.ndim() == 1;
  const int count = mask ? static_cast<int>(any.shape(0)) : kAnyCount;
  std::vector<int> indices = indices_from(vertices, "vertices", count);
  if (indices.empty()) throw InputError("vertices: found no vertices, expected one or more");
  made.vertices = mask ? py::array(any.attr("copy")()) : array_of(std::move(indices));
  made.direction = direction_from(direction, direction_name(made));
  if (!origin.is_none()) made.origin = vector_from(origin, "origin");
  return made;
}

/// A class whose constructor is new_sliding(); it takes `direction` under another name.
template <class Constraint>
void bind_sliding(py::module_& m, const char* name, const char* what, const char* words) {
  using Object = SlidingObject<Constraint>;
  const char* direction = direction_name(Object{});
  py::class_<Object>(m, name, words)
      .def(py::init(&new_sliding<Constraint>), "vertices"_a, py::arg(direction), py::kw_only(),
           "origin"_a = py::none(), what)
      .def_property_readonly(
          "vertices", [](const Object& one) { return one.vertices; }, "Indices, or a mask.")
      .def_property_readonly(
          direction, [](const Object& one) { return array_of(one.direction); }, "Array of 3.")
      .def_property_readonly(
          "origin", [](const Object& one) { return array_or_none(one.origin); },
          "Array of 3, model units, or None.")
      .def("__repr__",
           [name = std::string(name), direction](const Object& one) {
             return "<batten." + name + ": " + direction + " " + format_point(one.direction) +
                    (one.origin ? ", origin " + format_point(*one.origin) : "") + ">";
           })
      .def(py::pickle(
          [](const Object& one) {
            return py::make_tuple(one.vertices, array_of(one.direction), array_or_none(one.origin));
          },
          [](const py::tuple& state) {
            return new_sliding<Constraint>(state[0], state[1], state[2]);
          }));
}

CharacterChain new_chain(const py::object& vertices, bool closed, const py::object& width) {
  const py::array any = py::array::ensure(vertices);
  if (any && any.dtype().kind() == 'b')
    throw InputError("vertices: found a mask, expected whole numbers in the order along the chain");
  CharacterChain chain{"", indices_from(vertices, "vertices", kAnyCount), closed, 0};
  if (width.is_none()) return chain;
  chain.width = numbers_from(py::make_tuple(width), "width").front();
  if (!(chain.width > 0))
    throw InputError("width: found " + format_number(chain.width) +
                     ", expected a number above 0, or None");
  return chain;
}

py::object width_of(const CharacterChain& chain) {
  return chain.width > 0 ? py::object(py::float_(chain.width)) : py::object(py::none());
}

int vertex_from(py::handle given, const std::string& what) {
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(given.ptr()));
  if (!number) {
    PyErr_Clear();
    throw InputError(what + ": found " + std::string(py::repr(given)) +
                     ", expected a whole number from 0");
  }
  return indices_from(py::make_tuple(number), what, kAnyCount).front();
}

LinearConstraint new_linear(const py::dict& coefficients, const py::object& target,
                            const py::object& weight, const py::object& rotates_with) {
  LinearConstraint made;
  for (const auto& [vertex, coefficient] : coefficients) {
    const int index = vertex_from(vertex, "coefficients, vertex");
    const std::string what = "coefficients[" + std::to_string(index) + "]";
    made.combination.entries.push_back(
        {index, numbers_from(py::make_tuple(coefficient), what).front()});
  }
  if (made.combination.entries.empty())
    throw InputError("coefficients: found no vertices, expected {vertex: coefficient}");
  made.target = vector_from(target, "target");
  if (!weight.is_none()) made.weight = numbers_from(py::make_tuple(weight), "weight").front();
  if (made.weight && !(*made.weight > 0))
    throw InputError("weight: found " + format_number(*made.weight) +
                     ", expected a number above 0, or None for an exact constraint");
  if (!rotates_with.is_none()) made.rotates_with = vertex_from(rotates_with, "rotates_with");
  return made;
}

py::dict coefficients_of(const LinearConstraint& row) {
  py::dict coefficients;
  for (const auto& entry : row.combination.entries)
    coefficients[py::int_(entry.vertex)] = entry.coefficient;
  return coefficients;
}

py::object weight_of(const LinearConstraint& row) {
  return row.weight ? py::object(py::float_(*row.weight)) : py::object(py::none());
}

py::object rotates_with_of(const LinearConstraint& row) {
  return row.rotates_with >= 0 ? py::object(py::int_(row.rotates_with)) : py::object(py::none());
}

void bind_chain(py::module_& m) {
  py::class_<CharacterChain>(
      m, "Chain",
      R"(A chain of mesh edges that keeps its shape approximately and rotates with the mesh.

For `chains` of a Deformer.

    >>> edge = mesh.crease_path([[0, 0, 0], [100, 0, 0]])
    >>> batten.Chain(edge[:5])
    <batten.Chain of 5 vertices>
)")
      .def(
          py::init(&new_chain), "vertices"_a, py::kw_only(), "closed"_a = false,
          "width"_a = py::none(),
          R"(`vertices`: three or more indices in order along the chain, for example of Mesh.crease_path().

The chain resists bending like a strip of the mesh with this `width`, model units, above 0; None: a tenth
of its length. `closed`: the last vertex is connected to the first. Raises InputError.)")
      .def_property_readonly(
          "vertices",
          [](const CharacterChain& chain) { return array_of(std::vector<int>(chain.vertices)); },
          "Indices in order.")
      .def_readonly("closed", &CharacterChain::closed,
                    "Whether the last vertex is connected to the first.")
      .def_property_readonly("width", &width_of, "Model units, or None.")
      .def("__repr__",
           [](const CharacterChain& chain) {
             return "<batten.Chain of " + std::to_string(chain.vertices.size()) + " vertices" +
                    (chain.closed ? ", closed>" : ">");
           })
      .def(py::pickle(
          [](const CharacterChain& chain) {
            return py::make_tuple(array_of(std::vector<int>(chain.vertices)), chain.closed,
                                  width_of(chain));
          },
          [](const py::tuple& state) {
            return new_chain(state[0], state[1].cast<bool>(), state[2]);
          }));
}

void bind_linear(py::module_& m) {
  py::class_<LinearConstraint>(
      m, "LinearConstraint",
      R"(A linear combination of vertex positions with a prescribed value: Σ c_i p_i = target.

For `linear_constraints` of a Deformer.

    >>> peak = batten.LinearConstraint({7: 1}, target=[50, 50, 80])
    >>> deformer = batten.Deformer(mesh, fixed=[0], linear_constraints={"peak": peak})
    >>> np.round(deformer.deform({}, targets={"peak": [50, 50, 90]})[7], 9)
    array([50., 50., 90.])
)")
      .def(
          py::init(&new_linear), "coefficients"_a, "target"_a, py::kw_only(),
          "weight"_a = py::none(), "rotates_with"_a = py::none(),
          R"(`coefficients`: {vertex: c}; {vertex: 1} prescribes the position of a vertex. `target`: array of 3, model units.

`weight`: None: the constraint is exact; above 0: it is soft and adds ½ weight |Σ c_i p_i - target|² to the
energy. `rotates_with`: a vertex; `target` rotates like the mesh there. Raises InputError.)")
      .def_property_readonly("coefficients", &coefficients_of, "{vertex: coefficient}.")
      .def_property_readonly(
          "target", [](const LinearConstraint& row) { return array_of(row.target); },
          "Array of 3, model units.")
      .def_property_readonly("weight", &weight_of, "Weight of a soft constraint, or None.")
      .def_property_readonly("rotates_with", &rotates_with_of, "Index of a vertex, or None.")
      .def("__repr__",
           [](const LinearConstraint& row) {
             return "<batten.LinearConstraint of " +
                    std::to_string(row.combination.entries.size()) + " vertices: target " +
                    format_point(row.target) + ">";
           })
      .def(py::pickle(
          [](const LinearConstraint& row) {
            return py::make_tuple(coefficients_of(row), array_of(row.target), weight_of(row),
                                  rotates_with_of(row));
          },
          [](const py::tuple& state) {
            return new_linear(state[0], state[1], state[2], state[3]);
          }));
}

/// The object with a name, if it has the type.
template <class Object>
const Object& object_of(py::handle given, const std::string& what, const std::string& expected) {
  if (!py::isinstance<Object>(given))
    throw InputError(what + ": found " + std::string(py::repr(given)) + ", expected " + expected);
  return given.cast<const Object&>();
}

template <class Constraint>
Constraint constraint_of(const SlidingObject<Constraint>& given, const std::string& name,
                         int count) {
  return {name, indices_from(given.vertices, "constraint '" + name + "'", count), given.direction,
          given.origin};
}

void check_index(int vertex, const std::string& what, int count) {
  if (vertex >= count)
    throw InputError(what + ": found " + std::to_string(vertex) + ", expected 0 to " +
                     std::to_string(count - 1));
}

}  // namespace

std::vector<std::variant<OnPlane, OnLine>> constraints_from(const py::dict& given, int count) {
  std::vector<std::variant<OnPlane, OnLine>> constraints;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    if (py::isinstance<SlidingObject<OnPlane>>(value))
      constraints.push_back(
          constraint_of(value.template cast<const SlidingObject<OnPlane>&>(), name, count));
    else
      constraints.push_back(
          constraint_of(object_of<SlidingObject<OnLine>>(value, "constraint '" + name + "'",
                                                         "a batten.OnPlane or batten.OnLine"),
                        name, count));
  }
  return constraints;
}

std::vector<CharacterChain> chains_from(const py::dict& given, int count) {
  std::vector<CharacterChain> chains;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key), what = "chain '" + name + "'";
    chains.push_back(object_of<CharacterChain>(value, what, "a batten.Chain"));
    chains.back().name = name;
    for (const int v : chains.back().vertices) check_index(v, what, count);
  }
  return chains;
}

std::vector<LinearConstraint> linear_constraints_from(const py::dict& given, int count) {
  std::vector<LinearConstraint> rows;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key), what = "linear constraint '" + name + "'";
    rows.push_back(object_of<LinearConstraint>(value, what, "a batten.LinearConstraint"));
    rows.back().name = name;
    for (const auto& entry : rows.back().combination.entries)
      check_index(entry.vertex, what, count);
    check_index(rows.back().rotates_with, what + ", rotates_with", count);
  }
  return rows;
}

py::dict dict_of(const std::vector<std::variant<OnPlane, OnLine>>& constraints) {
  py::dict result;
  for (const auto& any : constraints) {
    if (const auto* plane = std::get_if<OnPlane>(&any))
      result[py::str(plane->name)] = py::cast(SlidingObject<OnPlane>{
          array_of(std::vector<int>(plane->vertices)), plane->normal, plane->origin});
    if (const auto* line = std::get_if<OnLine>(&any))
      result[py::str(line->name)] = py::cast(SlidingObject<OnLine>{
          array_of(std::vector<int>(line->vertices)), line->direction, line->origin});
  }
  return result;
}

py::dict dict_of(const std::vector<CharacterChain>& chains) {
  py::dict result;
  for (const CharacterChain& chain : chains) result[py::str(chain.name)] = py::cast(chain);
  return result;
}

py::dict dict_of(const std::vector<LinearConstraint>& constraints) {
  py::dict result;
  for (const LinearConstraint& row : constraints) result[py::str(row.name)] = py::cast(row);
  return result;
}

void bind_constraints(py::module_& m) {
  bind_sliding<OnPlane>(
      m, "OnPlane",
      R"(`vertices`: indices from 0 or a mask; `normal`: array of 3, of any length above 0.

`origin`: a point of the plane, model units; None: the mean of the vertices in the mesh. Raises InputError.)",
      "Keeps the mean of vertices on a plane, exactly: the centre of a hole, a feature or a "
      "vertex.");
  bind_sliding<OnLine>(
      m, "OnLine",
      R"(`vertices`: indices from 0 or a mask; `direction`: array of 3, of any length above 0.

`origin`: a point of the line, model units; None: the mean of the vertices in the mesh. Raises InputError.)",
      R"(Keeps the mean of vertices on a straight line, exactly.

For `constraints` of a Deformer.

    >>> rail = batten.OnLine([7], direction=[1, 0, 1], origin=[0, 5, 0])
    >>> deformer = batten.Deformer(mesh, fixed=[0], constraints={"rail": rail})
    >>> np.round(deformer.deform({})[7, 1], 9)
    5.0
)");
  bind_chain(m);
  bind_linear(m);
}

}  // namespace batten::python
