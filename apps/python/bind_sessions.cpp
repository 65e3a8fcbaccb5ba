// SPDX-License-Identifier: MPL-2.0
// Binds sculpting sessions: parameters in, points out.
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/stress_settings.h"
#include "batten/core/errors.h"
#include "batten/scenes/session_data.h"

namespace batten::python {
namespace {

using namespace py::literals;

/// The Python class Session: a session, and its triangles as an array, made once.
struct SessionObject {
  Session session;
  py::object triangles = py::none();
  std::shared_ptr<const DisplayTopology> pattern = nullptr;  // from which `triangles` was made
};

std::unique_ptr<SessionObject> new_session(const py::object& source, const py::object& values,
                                           const py::object& progress) {
  KernelCall call(progress);
  const auto numbers = values_from(values);
  const std::map<std::string, double> by_name(numbers.begin(), numbers.end());
  const bool given = py::isinstance<Model>(source);
  std::optional<Model> model;
  if (given) model = source.cast<Model>();
  const std::string file = given ? "" : path_from(source);
  return call([&](const Progress& hook) {
    if (!given)
      model = load(file, by_name, hook);
    else if (!by_name.empty())
      model = model->with_values(by_name, hook);
    return std::make_unique<SessionObject>(SessionObject{Session(*model, hook)});
  });
}

/// Calls function(session) without the GIL; Ctrl-C cancels it, and `progress` is called if given.
template <class Function>
auto call_session(SessionObject& of, const Function& function,
                  const py::object& progress = py::none()) {
  return KernelCall(progress)([&](const Progress& hook) {
    const ProgressScope scope(hook);
    return function(of.session);
  });
}

py::array frame_view(SessionObject& of, std::vector<float> Frame::*numbers) {
  const auto frame = call_session(of, [](Session& session) { return session.frame(); });
  const std::vector<float>& data = (*frame).*numbers;
  return rows_view(frame, data.data(), static_cast<py::ssize_t>(data.size() / 3), 3);
}

py::object session_triangles(SessionObject& of) {
  const auto frame = call_session(of, [](Session& session) { return session.frame(); });
  if (of.pattern != frame->pattern) {
    of.pattern = frame->pattern;
    of.triangles = rows_view(of.pattern, of.pattern->facets.front().data(),
                             static_cast<py::ssize_t>(of.pattern->facets.size()), 3);
  }
  return of.triangles;
}

void add_point_constraint(SessionObject& of, const std::string& name, const py::object& at,
                          const py::object& target) {
  const Vec3 point = vector_from(at, "at");
  const Vec3 goal = target.is_none() ? point : vector_from(target, "target");
  call_session(of, [&](Session& session) { session.add_point_constraint(name, point, goal); });
}

void add_offset(SessionObject& of, const std::string& name, const std::string& curve,
                const py::object& direction, double fade, double value, double low, double high) {
  Vec3 along = Vec3::Zero();
  if (!direction.is_none()) {
    along = vector_from(direction, "direction");
    if (along == Vec3::Zero())
      throw InputError("direction: found a vector of length 0, expected a direction or None");
  }
  call_session(of, [&](Session& session) {
    session.add_offset(name, curve, along, fade, {value, low, high});
  });
}

void drive(SessionObject& of, const std::string& parameter, const py::dict& follows,
           double offset) {
  const auto terms = values_from(follows, "follows");
  call_session(of, [&](Session& session) {
    session.drive(parameter, {terms.begin(), terms.end()}, offset);
  });
}

py::dict session_reactions(SessionObject& of) {
  py::dict forces;
  for (const Reaction& one : call_session(of, [](Session& session) { return session.reactions(); }))
    forces[py::str(one.name)] = py::make_tuple(one.force.x(), one.force.y(), one.force.z());
  return forces;
}

std::shared_ptr<SessionStress> session_stress(SessionObject& of, const py::object& material,
                                              const py::object& thickness,
                                              const py::object& supports, const py::object& loads,
                                              const std::string& settings,
                                              const py::object& progress) {
  const detail::StressTable table =
      stress_table_from(material, thickness, supports, loads, py::none(), 0, 0, settings);
  return call_session(
      of,
      [&](Session& session) {
        detail::SessionContents& contents = session.contents();
        return std::make_shared<SessionStress>(contents.with_session(
            false, [&](SculptingSession&) { return contents.current_stress(table); }));
      },
      progress);
}

void bind_session_stress(py::module_& m) {
  using Pointer = std::shared_ptr<SessionStress>;
  py::class_<SessionStress, Pointer>(m, "SessionStress", R"(Result of Session.stress().

    >>> live = session.stress(material="steel", thickness=1, supports=["left", "right"],
    ...                       loads={"pressure": -0.01})
    >>> live.displacement.shape == session.points.shape
    True)")
      .def_readonly("load_case", &SessionStress::load_case,
                    "Name of the load case with the largest von Mises stress.")
      .def_readonly("max_von_mises", &SessionStress::max_von_mises,
                    "Largest von Mises stress over all load cases.")
      .def_readonly("max_displacement", &SessionStress::max_displacement,
                    "Largest displacement over all load cases, model units.")
      .def_property_readonly(
          "von_mises",
          [](const Pointer& of) {
            return array_view(of, of->von_mises.data(),
                              {static_cast<py::ssize_t>(of->von_mises.size())}, {sizeof(float)});
          },
          "Larger von Mises stress of top and bottom at each of session.points, n float32. A view.")
      .def_property_readonly(
          "displacement",
          [](const Pointer& of) {
            return rows_view(of, of->displacement.data(),
                             static_cast<py::ssize_t>(of->displacement.size() / 3), 3);
          },
          "Displacement at each of session.points, n×3 float32, model units. A view.")
      .def("__repr__", [](const SessionStress& of) {
        return "<batten.SessionStress: von Mises " + format_number(of.max_von_mises) + " in '" +
               of.load_case + "', displacement " + format_number(of.max_displacement) + ">";
      });
}

std::map<std::string, double> parameters_of(SessionObject& of) {
  return call_session(of, [](Session& session) { return session.parameters(); });
}

/// Names of the parameters, in the order of `parameters`.
py::list keys_of(SessionObject& of) {
  py::list keys;
  for (const auto& [name, value] : parameters_of(of)) keys.append(name);
  return keys;
}

std::string session_repr(SessionObject& of) {
  std::string values;
  for (const auto& [name, value] : parameters_of(of))
    values += (values.empty() ? ": " : ", ") + name + " = " + format_number(value);
  return "<batten.Session of '" + of.session.contents().base->scene.name + "'" + values + ">";
}

std::string report_repr(const SolveReport& report) {
  return std::string("<batten.SolveReport: ") + (report.converged ? "" : "not ") +
         "converged, iterations " + std::to_string(report.iterations) + ", change " +
         format_number(report.change) + ">";
}

using SessionClass = py::class_<SessionObject>;

/// What a dict has: `in`, iteration, len() and the keys that IPython completes.
void bind_session_mapping(SessionClass& c) {
  c.def(
       "__setitem__",
       [](SessionObject& of, const std::string& name, double value) {
         call_session(of, [&](Session& session) { session.set(name, value); });
       },
       "name"_a, "value"_a)
      .def(
          "__getitem__",
          [](SessionObject& of, const std::string& name) {
            return call_session(of, [&](Session& session) { return session.value(name); });
          },
          "name"_a)
      .def(
          "__contains__",
          [](SessionObject& of, const py::object& name) { return keys_of(of).contains(name); },
          "name"_a)
      .def("__iter__", [](SessionObject& of) { return py::iter(keys_of(of)); })
      .def("__len__", [](SessionObject& of) { return parameters_of(of).size(); })
      .def("keys", &keys_of, "Names of the parameters, a list: dict(session) has their values.")
      .def(
          "values",
          [](SessionObject& of) {
            py::list values;
            for (const auto& [name, value] : parameters_of(of)) values.append(value);
            return values;
          },
          "Values of the parameters, a list.")
      .def(
          "items",
          [](SessionObject& of) {
            py::list items;
            for (const auto& item : parameters_of(of))
              items.append(py::make_tuple(item.first, item.second));
            return items;
          },
          "Names and values of the parameters, a list of pairs.")
      .def("_ipython_key_completions_", &keys_of)
      .def("__repr__", &session_repr);
}

void bind_session_solves(SessionClass& c) {
  c.def(
       "set",
       [](SessionObject& of, const std::string& name, double value) {
         call_session(of, [&](Session& session) { session.set(name, value); });
       },
       "name"_a, "value"_a,
       "Sets a parameter; it takes effect in the next update() or solve(). Raises InputError if "
       "it is unknown, out of range, not finite, or driven by others.")
      .def(
          "update",
          [](SessionObject& of, int max_iterations, double tolerance) {
            return call_session(
                of, [&](Session& session) { return session.update(max_iterations, tolerance); });
          },
          "max_iterations"_a = 4, "tolerance"_a = 1e-5,
          R"(Updates the shape quickly, as during a drag: up to `max_iterations` iterations, or until the
change is below `tolerance` (of the size).

Costs one or a few pairs of triangular solves; the next call continues if it has not converged.
Raises NoSolutionError for a load beyond its limit; parameters and shape are then the last valid ones.)")
      .def(
          "solve",
          [](SessionObject& of, const py::object& progress) {
            return call_session(
                of, [](Session& session) { return session.solve(); }, progress);
          },
          py::kw_only(), "progress"_a = py::none(),
          "Solves to equilibrium, to rounding; `progress` is called if the shape is faired. Raises "
          "NoSolutionError, ConflictError.")
      .def(
          "undo",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.undo(); });
          },
          R"(Undoes an edit, or a drag since the last solve(). False: nothing to undo.

The history begins with the model of the session and keeps the last 1,000 steps within 512 MiB; a step
takes 24 bytes per degree of freedom. Restores the same bits. The next solve factors again if the
factorization of the restored state is no longer stored.

    >>> before = session.points
    >>> session["swell"] = 20
    >>> report = session.solve()
    >>> session.undo(), (session.points == before).all()
    (True, True))")
      .def(
          "redo",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.redo(); });
          },
          "Redoes what undo() has undone. False: nothing to redo.");
}

void start_motion(SessionObject& of, double dt, const py::object& density,
                  const py::object& damping, const py::object& theta) {
  const SceneMotion& scene = of.session.contents().base->scene.motion;
  const auto number = [](const py::object& given, const std::string& what, double usual) {
    return given.is_none() ? usual : numbers_from(py::make_tuple(given), what).front();
  };
  const Motion motion{dt, number(density, "density", scene.density),
                      number(damping, "damping", scene.damping),
                      number(theta, "theta", scene.theta)};
  call_session(of, [&](Session& session) { session.start_motion(motion); });
}

void bind_session_motion(SessionClass& c) {
  c.def(
       "start_motion", &start_motion, "dt"_a, py::kw_only(), "density"_a = py::none(),
       "damping"_a = py::none(), "theta"_a = py::none(),
       R"(Starts a motion M (ρ ẍ + μ ẋ) + K x = F at rest from the current shape, with the time step `dt`.

`density` ρ, `damping` μ, `theta` (of the theta method, 0.5 to 1): None: those of [motion] in the
scene, or 1. Same motion as `batten sculpt --time`. Raises InputError.

    >>> session.add_force("push", at=[50, 50, 0], direction=[0, 0, 1], value=2)
    >>> session.start_motion(0.01, damping=0, theta=0.5)
    >>> report = session.step()                  # the load sets in
    >>> energy = session.total_energy            # constant from now on
    >>> report = session.step(9)
    >>> round(session.time, 9), abs(session.total_energy / energy - 1) < 1e-6
    (0.1, True))")
      .def(
          "step",
          [](SessionObject& of, int count, const py::object& progress) {
            return KernelCall(progress)([&](const Progress& hook) {
              const ProgressScope scope(hook);
              return of.session.step(count, hook);
            });
          },
          "count"_a = 1, py::kw_only(), "progress"_a = py::none(),
          R"(Advances the motion, and parameters that depend on time, by `count` time steps.

Costs one pair of triangular solves per step. Raises InputError without a motion, NoSolutionError.)")
      .def(
          "stop_motion",
          [](SessionObject& of) {
            call_session(of, [](Session& session) { session.stop_motion(); });
          },
          "Ends the motion in the current shape; solve() then solves to equilibrium.")
      .def_property_readonly(
          "in_motion",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.in_motion(); });
          },
          "Whether a motion was started and not stopped.")
      .def_property_readonly(
          "time",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.time(); });
          },
          "Time of the motion, and of parameters that depend on time.")
      .def_property_readonly(
          "total_energy",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.total_energy(); });
          },
          "Elastic energy - work of the loads + springs + kinetic energy of a motion, in the units "
          "of `energy`.");
}

void bind_session_edits(SessionClass& c) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  c.def(
       "add_pressure",
       [](SessionObject& of, const std::string& name, double value, double low, double high,
          const py::iterable& faces) {
         const std::vector<std::string> on = names_from(faces, "faces");
         call_session(of, [&](Session& session) {
           session.add_pressure(name, {value, low, high}, on);
         });
       },
       "name"_a, py::kw_only(), "value"_a = 0.0, "min"_a = -inf, "max"_a = inf,
       "faces"_a = py::tuple(),
       R"(Adds a pressure along the normal, F = p ∬ N (x_u × x_v) du dv, on the named faces (empty: all).

Its value is the parameter of this name, from `min` to `max`. Raises InputError.

    >>> session.add_pressure("bulge", max=50, faces=["panel"])
    >>> session["bulge"] = 10)")
      .def(
          "add_force",
          [](SessionObject& of, const std::string& name, const py::object& at,
             const py::object& direction, double value, double low, double high) {
            const Vec3 point = vector_from(at, "at"), along = vector_from(direction, "direction");
            call_session(of, [&](Session& session) {
              session.add_force(name, point, along, {value, low, high});
            });
          },
          "name"_a, py::kw_only(), "at"_a, "direction"_a, "value"_a = 0.0, "min"_a = -inf,
          "max"_a = inf,
          R"(Adds the force `value` along `direction` at the surface point nearest to `at`.

`at`, `direction`: arrays of 3. Its value is the parameter of this name. Raises InputError.

    >>> session.add_force("push", at=[50, 50, 0], direction=[0, 0, 1], value=2))")
      .def("add_point_constraint", &add_point_constraint, "name"_a, py::kw_only(), "at"_a,
           "target"_a = py::none(),
           R"(Constrains the surface point nearest to `at` to the position `target` (None: `at`).

`at`, `target`: arrays of 3, model units. Its parameters are name.x, name.y and name.z. On a curve, a
target within 1e-6 of the model's size holds the point where the curve has it, so that float32
coordinates can be used; others raise ConflictError. Within 1e-3, a point is on the curve if the target
would move it by more than a tenth of its distance. Raises InputError, and ConflictError if other
constraints contradict.

    >>> session.add_point_constraint("peak", at=[50, 50, 20])
    >>> session["peak.z"] = 25)")
      .def(
          "add_normal_constraint",
          [](SessionObject& of, const std::string& name, const py::object& at,
             const py::object& normal) {
            const Vec3 point = vector_from(at, "at"), along = vector_from(normal, "normal");
            call_session(
                of, [&](Session& session) { session.add_normal_constraint(name, point, along); });
          },
          "name"_a, py::kw_only(), "at"_a, "normal"_a,
          R"(Constrains the surface normal at the point nearest to `at` to the direction `normal`.

`at`, `normal`: arrays of 3. Raises InputError, ConflictError.

    >>> session.add_normal_constraint("level", at=[50, 50, 20], normal=[0, 0, 1]))")
      .def(
          "add_offset", &add_offset, "name"_a, "curve"_a, py::kw_only(), "direction"_a = py::none(),
          "fade"_a = 0.0, "value"_a = 0.0, "min"_a = -inf, "max"_a = inf,
          R"(Adds a parameter that offsets a curve by value · direction (None: along the normal), model units.

`fade`: fraction of its length at either end over which the offset grows from zero. Raises InputError.

    >>> session.add_offset("lift", "front", direction=[0, 0, 1], fade=0.3, value=5))")
      .def(
          "add_parameter",
          [](SessionObject& of, const std::string& name, double value, double low, double high) {
            call_session(of, [&](Session& session) {
              session.add_parameter(name, {value, low, high});
            });
          },
          "name"_a, py::kw_only(), "value"_a = 0.0, "min"_a = -inf, "max"_a = inf,
          "Adds a parameter that can drive others: drive(). Raises InputError.")
      .def("drive", &drive, "parameter"_a, "follows"_a, py::kw_only(), "offset"_a = 0.0,
           R"(Drives a parameter by others: offset + Σ factor · value, with {name: factor}.

Raises InputError for unknown names and circular rules.

    >>> session.add_parameter("style", min=0, max=1)
    >>> session.drive("swell", {"style": 40})
    >>> session["style"] = 0.5
    >>> session["swell"]
    20.0)")
      .def(
          "remove",
          [](SessionObject& of, const std::string& name) {
            call_session(of, [&](Session& session) { session.remove(name); });
          },
          "name"_a, "Removes a load, constraint or offset. Raises InputError for an unknown name.")
      .def_property_readonly(
          "names",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.names(); });
          },
          "Names of the loads, constraints and offsets, for remove().");
}

void bind_session_results(SessionClass& c) {
  c.def_property_readonly("parameters", &parameters_of, "Current values, {name: value}.")
      .def_property_readonly(
          "points", [](SessionObject& of) { return frame_view(of, &Frame::points); },
          "Points of the current shape, n×3 float32, model units. A view of a snapshot.")
      .def_property_readonly(
          "normals", [](SessionObject& of) { return frame_view(of, &Frame::normals); },
          "Exact unit normals at the points, n×3 float32. A view of a snapshot.")
      .def_property_readonly(
          "triangles", &session_triangles,
          "Point indices of the triangles, m×3 int32: the same array until the mesh changes.")
      .def_property_readonly(
          "dofs",
          [](SessionObject& of) {
            return array_of(call_session(of, [](Session& session) { return session.dofs(); }));
          },
          "The degrees of freedom of the current shape, n×3 float64 (docs/theory/elements.md).")
      .def_property_readonly(
          "residual",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.residual(); });
          },
          "Largest residual of all constraints, relative to the size.")
      .def_property_readonly(
          "energy",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.energy(); });
          },
          "Elastic energy ½ qᵀK q, on the domain scaled to size 1.")
      .def_property_readonly(
          "volume",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.volume(); });
          },
          "⅓ ∬ x·(x_u × x_v), model units³.")
      .def("reactions", &session_reactions,
           "Reaction forces of curves and constraints, {name: (x, y, z)}.")
      .def("stress", &session_stress, py::kw_only(), "material"_a = py::none(),
           "thickness"_a = py::none(), "supports"_a = py::none(), "loads"_a = py::none(),
           "settings"_a = "", "progress"_a = py::none(),
           R"(Stresses of the current shape as a thin shell, for use during a drag: SessionStress.

The arguments are those of stress(); without any, the [stress] of the model is used. A shape close to
that of an earlier call is solved with its factorization, to a relative error of about 1e-7;
stress(session.model(), …) gives the exact values, with reactions, error estimates and checks. Raises
InputError, ConflictError, NoSolutionError.
Source: Kirchhoff-Love shells on the same elements (docs/stress.md).

    >>> live = session.stress(material="steel", thickness=1, supports=["left", "right"],
    ...                       loads={"pressure": -0.01})
    >>> live.von_mises.shape == (len(session.points),)
    True)")
      .def(
          "model",
          [](SessionObject& of) {
            return call_session(of, [](Session& session) { return session.model(); });
          },
          "The Model in its current shape, with everything that was added. A session of it has the "
          "same shape, to the last bit.")
      .def("__reduce__", [](const py::object& self) {
        return py::make_tuple(self.attr("__class__"), py::make_tuple(self.attr("model")()));
      });
}

}  // namespace

void bind_sessions(py::module_& m) {
  bind_session_stress(m);
  py::class_<SolveReport>(m, "SolveReport", R"(Convergence of Session.update() or Session.solve().

    >>> session.solve().converged
    True)")
      .def_readonly("converged", &SolveReport::converged,
                    "Whether the change is below the tolerance.")
      .def_readonly("iterations", &SolveReport::iterations, "Pairs of triangular solves.")
      .def_readonly("change", &SolveReport::change,
                    "Change in the last iteration, relative to the size.")
      .def_readonly("factored", &SolveReport::factored, "Whether a new factorization was needed.")
      .def("__repr__", &report_repr);
  SessionClass c(m, "Session",
                 R"(Interactive sculpting: a model with its loads and constraints. Thread-safe.

A session has the parameters of a model as a dict has keys: `name in session`, dict(session). It can be
pickled: as model().

    >>> session["swell"] = 20
    >>> report = session.update()             # quick: a few triangular solves
    >>> points, triangles = session.points, session.triangles
    >>> report = session.solve()              # to convergence
    >>> session.model().parameters["swell"]
    20.0)");
  c.def(py::init(&new_session), "source"_a, py::kw_only(), "values"_a = py::none(),
        "progress"_a = py::none(),
        "A session of a Model, or of a scene file. `values`: parameters {name: value}. Raises the "
        "exceptions of load().");
  bind_session_mapping(c);
  bind_session_solves(c);
  bind_session_motion(c);
  bind_session_edits(c);
  bind_session_results(c);
}

}  // namespace batten::python
