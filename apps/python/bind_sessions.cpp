// Binds sculpting sessions: parameters in, points out.

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_evaluator.h"
#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/apps/commands/shapes/stress_setup.h"
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/model.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene.h"

namespace batten::python {

// Thread-safe sessions.

/// A sculpting session with its scene and the frames that Python views. Calls from several threads
/// are serialised. All functions except the constructor must be called without the GIL.
class SharedSession {
 public:
  /// Creates the session of a model's scene and solves it to equilibrium. Throws as sculpt_model()
  /// and make_session().
  SharedSession(std::shared_ptr<const Model> model, const Progress& progress);

  SharedSession(const SharedSession&) = delete;  // the session refers to members by address

  /// Calls function(session) exclusively. `changes`: the call may move the surface. `progress`:
  /// polled by the session during the call.
  template <class Function>
  auto with_session(bool changes, const Progress& progress, const Function& function) {
    return serialize_([&] {
      const ProgressScope scope(active_progress_, progress);
      if (changes) stale_ = true;
      return function(*session_);
    });
  }

  SolveReport solve_to_equilibrium(const Progress& progress);
  SolveReport solve_preview(int max_iterations, double tolerance, const Progress& progress);
  /// Points and normals of the current shape. The frame does not change while it is referenced;
  /// unreferenced frames are reused.
  std::shared_ptr<const Frame> frame(const Progress& progress);
  /// The current shape as a Model, with the parameter values of the session.
  std::shared_ptr<const Model> model(const Progress& progress);

  struct Stress {
    ShellEvaluator::MaxValues largest;
    std::shared_ptr<const ShellEvaluator::Field> field;
  };
  /// Stresses of the shell defined by [stress] in the scene, at the points of frame(). Throws
  /// InputError if there is no [stress].
  Stress stress(const Progress& progress);

  const Scene& scene() const { return scene_; }

 private:
  /// Sets the progress callbacks for the duration of a call.
  struct ProgressScope {
    ProgressScope(const Progress*& of, const Progress& progress) : scope(of) { scope = &progress; }
    ~ProgressScope() { scope = nullptr; }
    ProgressScope(const ProgressScope&) = delete;
    const Progress*& scope;
  };
  /// Callbacks that the session keeps; they forward to those of the current call.
  Progress forwarding_progress();
  std::shared_ptr<const Frame> current_frame();

  Scene scene_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const SculptModel> model_;
  const Progress* active_progress_ = nullptr;
  SessionReference start_;
  std::unique_ptr<SculptingSession> session_;
  SolveReport solve_report_;
  CallSerializer serialize_;
  std::vector<std::shared_ptr<Frame>> frames_;
  std::shared_ptr<const Frame> shown_;
  bool stale_ = true;  // shown_ does not show the current shape
  std::optional<ShellEvaluator> stress_;
};

namespace {

using namespace py::literals;

/// The Python class Session: the shared session, and its triangles as an array, made once.
struct SessionObject {
  std::unique_ptr<SharedSession> shared;
  py::object triangles;
  std::shared_ptr<const DisplayTopology> pattern;  // topology from which `triangles` was made
};

std::unique_ptr<SessionObject> new_session(const py::object& source, const py::object& values,
                                           const py::object& progress) {
  std::shared_ptr<const Model> model;
  KernelCall call(progress);
  if (py::isinstance<Model>(source)) {
    model = source.cast<std::shared_ptr<Model>>();
    const auto numbers = values_from(values);
    if (!numbers.empty())
      model = call([&](const Progress& hook) { return model->with_values(numbers, hook); });
  } else {
    Scene scene = scene_of_file(path_from(source));
    set_values(scene, values);
    model = call([&](const Progress& hook) { return Model::of_scene(scene, hook); });
  }
  auto session = std::make_unique<SessionObject>();
  session->shared =
      call([&](const Progress& hook) { return std::make_unique<SharedSession>(model, hook); });
  return session;
}

/// Calls function(session) exclusively and without the GIL.
template <class Function>
auto call_without_gil(const SessionObject& of, bool changes, const Function& function) {
  return KernelCall()(
      [&](const Progress& hook) { return of.shared->with_session(changes, hook, function); });
}

std::shared_ptr<const Frame> frame_of(const SessionObject& of) {
  return KernelCall()([&](const Progress& hook) { return of.shared->frame(hook); });
}

py::array frame_view(const SessionObject& of, std::vector<float> Frame::*numbers) {
  const auto frame = frame_of(of);
  const std::vector<float>& data = (*frame).*numbers;
  return rows_view(frame, data.data(), static_cast<py::ssize_t>(data.size() / 3), 3);
}

py::object session_triangles(SessionObject& of) {
  const auto frame = frame_of(of);
  if (of.pattern != frame->pattern) {
    of.pattern = frame->pattern;
    of.triangles = rows_view(of.pattern, of.pattern->facets.front().data(),
                             static_cast<py::ssize_t>(of.pattern->facets.size()), 3);
  }
  return of.triangles;
}

py::dict session_parameters(const SessionObject& of) {
  const Parameters now =
      call_without_gil(of, false, [](SculptingSession& session) { return session.parameters(); });
  py::dict values;
  for (const ScalarParameter& p : now.all()) values[py::str(p.name)] = now.value(p.name);
  return values;
}

std::vector<ScalarParameter> range_of(const std::string& name, double value, double low,
                                      double high) {
  ScalarParameter parameter;
  parameter.name = name;
  parameter.value = value;
  parameter.min = low;
  parameter.max = high;
  return {parameter};
}

void add_pressure(const SessionObject& of, const std::string& name, double value, double low,
                  double high, const std::vector<std::string>& faces) {
  Load::Pressure pressure;
  pressure.area.regions = faces;
  call_without_gil(of, true, [&](SculptingSession& session) {
    session.add(Load{name, pressure}, range_of(name, value, low, high));
  });
}

void add_force(const SessionObject& of, const std::string& name, const py::object& at,
               const py::object& direction, double value, double low, double high) {
  const Load load{name, Load::Point{vector_from(at, "at"), vector_from(direction, "direction")}};
  call_without_gil(of, true, [&](SculptingSession& session) {
    session.add(load, range_of(name, value, low, high));
  });
}

void add_point_constraint(const SessionObject& of, const std::string& name, const py::object& at,
                          const py::object& target) {
  const Vec3 point = vector_from(at, "at");
  const Constraint constraint{
      name, Constraint::Point{point, target.is_none() ? point : vector_from(target, "target")}};
  call_without_gil(of, true, [&](SculptingSession& session) { session.add(constraint); });
}

void add_normal_constraint(const SessionObject& of, const std::string& name, const py::object& at,
                           const py::object& normal) {
  const Constraint constraint{
      name, Constraint::Normal{vector_from(at, "at"), vector_from(normal, "normal")}};
  call_without_gil(of, true, [&](SculptingSession& session) { session.add(constraint); });
}

void add_offset(const SessionObject& of, const std::string& name, const std::string& curve,
                const py::object& direction, double fade, double value, double low, double high) {
  LineOffset offset{name, curve};
  if (!direction.is_none()) offset.direction = vector_from(direction, "direction");
  offset.fade = fade;
  call_without_gil(of, true, [&](SculptingSession& session) {
    session.add(offset, range_of(name, value, low, high));
  });
}

void set_rule(const SessionObject& of, const std::string& parameter, const py::dict& rule_terms,
              double offset) {
  std::vector<ScalarParameter::Term> terms;
  for (const auto& [name, factor] : values_from(rule_terms)) terms.push_back({name, factor});
  call_without_gil(of, true,
                   [&](SculptingSession& session) { session.set_rule(parameter, terms, offset); });
}

py::dict session_reactions(const SessionObject& of) {
  const auto reactions =
      call_without_gil(of, false, [](SculptingSession& session) { return session.reactions(); });
  py::dict forces;
  for (const Reaction& one : reactions)
    forces[py::str(one.name)] = py::make_tuple(one.force.x(), one.force.y(), one.force.z());
  return forces;
}

py::dict session_stress(const SessionObject& of) {
  const SharedSession::Stress stress =
      KernelCall()([&](const Progress& hook) { return of.shared->stress(hook); });
  const ShellEvaluator::Field& field = *stress.field;
  const auto rows = static_cast<py::ssize_t>(field.displacement.size() / 3);
  return py::dict("case"_a = field.load_case, "largest_von_mises"_a = stress.largest.von_mises,
                  "largest_displacement"_a = stress.largest.displacement,
                  "von_mises"_a = array_view(stress.field, field.von_mises.data(),
                                             {static_cast<py::ssize_t>(field.von_mises.size())},
                                             {sizeof(float)}),
                  "displacement"_a = rows_view(stress.field, field.displacement.data(), rows, 3));
}

void require_solver_options(int max_iterations, double tolerance) {
  if (max_iterations < 1)
    throw InputError("max_iterations: found " + std::to_string(max_iterations) +
                     ", expected 1 or more");
  if (!(tolerance > 0 && std::isfinite(tolerance)))
    throw InputError("tolerance: found " + format_number(tolerance) +
                     ", expected a number above 0");
}

using SessionClass = py::class_<SessionObject>;

void bind_session_solves(SessionClass& c) {
  c.def(
       "set",
       [](const SessionObject& of, const std::string& name, double value) {
         call_without_gil(of, true, [&](SculptingSession& session) { session.set(name, value); });
       },
       "name"_a, "value"_a,
       "Sets a parameter; it takes effect in the next update() or solve(). Raises InputError if "
       "it is unknown, out of range, not finite, or driven by others.")
      .def(
          "__setitem__",
          [](const SessionObject& of, const std::string& name, double value) {
            call_without_gil(of, true,
                             [&](SculptingSession& session) { session.set(name, value); });
          },
          "name"_a, "value"_a)
      .def(
          "__getitem__",
          [](const SessionObject& of, const std::string& name) {
            return call_without_gil(of, false, [&](SculptingSession& session) {
              return session.parameters().value(name);
            });
          },
          "name"_a)
      .def(
          "update",
          [](const SessionObject& of, int max_iterations, double tolerance) {
            require_solver_options(max_iterations, tolerance);
            return KernelCall()([&](const Progress& hook) {
              return of.shared->solve_preview(max_iterations, tolerance, hook);
            });
          },
          "max_iterations"_a = 4, "tolerance"_a = 1e-5,
          R"(Updates the shape quickly, as during a drag: up to `max_iterations` iterations, or until the
change is below `tolerance` (of the size).

Costs one or a few pairs of triangular solves; the next call continues if it has not converged.
Raises NoSolutionError for a load beyond its limit; parameters and shape are then the last valid ones.)")
      .def(
          "solve",
          [](const SessionObject& of, const py::object& progress) {
            return KernelCall(progress)(
                [&](const Progress& hook) { return of.shared->solve_to_equilibrium(hook); });
          },
          py::kw_only(), "progress"_a = py::none(),
          "Solves to equilibrium, to rounding; `progress` is called if the shape is faired. Raises "
          "NoSolutionError, ConflictError.")
      .def(
          "undo",
          [](const SessionObject& of) {
            return call_without_gil(of, true,
                                    [](SculptingSession& session) { return session.undo(); });
          },
          "Undoes an edit, or a drag since the last solve(). False: nothing to undo.")
      .def(
          "redo",
          [](const SessionObject& of) {
            return call_without_gil(of, true,
                                    [](SculptingSession& session) { return session.redo(); });
          },
          "Redoes what undo() has undone. False: nothing to redo.");
}

void bind_session_edits(SessionClass& c) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  c.def("add_pressure", &add_pressure, "name"_a, py::kw_only(), "value"_a = 0.0, "min"_a = -inf,
        "max"_a = inf, "faces"_a = std::vector<std::string>(),
        "Adds a pressure along the normal, F = p ∬ N (x_u × x_v) du dv, on the named faces (empty: "
        "all); its value is the parameter of this name.")
      .def("add_force", &add_force, "name"_a, py::kw_only(), "at"_a, "direction"_a, "value"_a = 0.0,
           "min"_a = -inf, "max"_a = inf,
           "Adds the force value · direction at the surface point nearest to `at`.")
      .def("add_point_constraint", &add_point_constraint, "name"_a, py::kw_only(), "at"_a,
           "target"_a = py::none(),
           "Constrains the surface point nearest to `at` to the position `target` (None: `at`), "
           "with the parameters name.x, name.y and name.z. Raises ConflictError if other "
           "constraints contradict.")
      .def("add_normal_constraint", &add_normal_constraint, "name"_a, py::kw_only(), "at"_a,
           "normal"_a,
           "Constrains the surface normal at the point nearest to `at` to the direction `normal`. "
           "Raises ConflictError.")
      .def("add_offset", &add_offset, "name"_a, "curve"_a, py::kw_only(),
           "direction"_a = py::none(), "fade"_a = 0.0, "value"_a = 0.0, "min"_a = -inf,
           "max"_a = inf,
           "Adds a parameter that offsets a curve by value · direction (None: along the normal), "
           "model units. `fade`: fraction of its length at either end over which the offset grows "
           "from zero.")
      .def(
          "add_parameter",
          [](const SessionObject& of, const std::string& name, double value, double low,
             double high) {
            call_without_gil(of, true, [&](SculptingSession& session) {
              session.add_parameter(range_of(name, value, low, high).front());
            });
          },
          "name"_a, py::kw_only(), "value"_a = 0.0, "min"_a = -inf, "max"_a = inf,
          "Adds a parameter that can drive others: drive().")
      .def("drive", &set_rule, "parameter"_a, "follows"_a, py::kw_only(), "offset"_a = 0.0,
           "Drives a parameter by others: offset + Σ factor · value, with {name: factor}.")
      .def(
          "remove",
          [](const SessionObject& of, const std::string& name) {
            call_without_gil(of, true, [&](SculptingSession& session) { session.remove(name); });
          },
          "name"_a, "Removes a load, constraint or offset.")
      .def_property_readonly(
          "names",
          [](const SessionObject& of) {
            return py::cast(call_without_gil(
                of, false, [](SculptingSession& session) { return session.names(); }));
          },
          "Names of the loads, constraints and offsets, for remove().");
}

void bind_session_results(SessionClass& c) {
  c.def_property_readonly("parameters", &session_parameters, "Current values, {name: value}.")
      .def_property_readonly(
          "points", [](const SessionObject& of) { return frame_view(of, &Frame::points); },
          "Points of the current shape, n×3 float32, model units. A view of a snapshot.")
      .def_property_readonly(
          "normals", [](const SessionObject& of) { return frame_view(of, &Frame::normals); },
          "Exact unit normals at the points, n×3 float32. A view of a snapshot.")
      .def_property_readonly(
          "triangles", &session_triangles,
          "Point indices of the triangles, m×3 int32: the same array until the mesh changes.")
      .def_property_readonly(
          "dofs",
          [](const SessionObject& of) {
            return array_of(call_without_gil(
                of, false, [](SculptingSession& session) { return session.dofs(); }));
          },
          "The degrees of freedom of the current shape, n×3 float64 (docs/theory/elements.md).")
      .def_property_readonly(
          "residual",
          [](const SessionObject& of) {
            return call_without_gil(of, false,
                                    [](SculptingSession& session) { return session.residual(); });
          },
          "Largest residual of all constraints, relative to the size.")
      .def_property_readonly(
          "energy",
          [](const SessionObject& of) {
            const SurfaceEnergy energy = call_without_gil(
                of, false, [](SculptingSession& session) { return session.energy(); });
            return energy.stretching + energy.bending;
          },
          "Elastic energy ½ qᵀK q, on the domain scaled to size 1.")
      .def_property_readonly(
          "volume",
          [](const SessionObject& of) {
            return call_without_gil(
                of, false, [](SculptingSession& session) { return session.enclosed_volume(); });
          },
          "⅓ ∬ x·(x_u × x_v), model units³.")
      .def("reactions", &session_reactions,
           "Reaction forces of curves and constraints, {name: (x, y, z)}.")
      .def("stress", &session_stress,
           R"(Stresses of the current shape as the shell of [stress] in the scene.

A dict: case (the governing one), largest_von_mises, largest_displacement, and at the points von_mises
(n float32) and displacement (n×3 float32). Raises InputError without [stress].
Source: Kirchhoff-Love shells on the same elements (docs/stress.md).)")
      .def(
          "model",
          [](const SessionObject& of) {
            return KernelCall()([&](const Progress& hook) {
              return std::const_pointer_cast<Model>(of.shared->model(hook));
            });
          },
          "The current shape as an immutable Model.");
}

}  // namespace

void bind_sessions(py::module_& m) {
  py::class_<SolveReport>(m, "SolveReport", "Convergence of update() or solve().")
      .def_readonly("converged", &SolveReport::converged)
      .def_readonly("iterations", &SolveReport::iterations, "Pairs of triangular solves.")
      .def_readonly("change", &SolveReport::change,
                    "Change in the last iteration, relative to the size.")
      .def_readonly("factored", &SolveReport::factored, "Whether a new factorization was needed.");
  SessionClass c(m, "Session",
                 R"(Interactive sculpting: a model with its loads and constraints. Thread-safe.

    session = batten.Session(model)
    session["swell"] = 120
    session.update()
    show(session.points, session.triangles))");
  c.def(py::init(&new_session), "source"_a, py::kw_only(), "values"_a = py::none(),
        "progress"_a = py::none(),
        "A session of a Model, or of a scene file. `values`: parameters {name: value}. Raises the "
        "exceptions of load().");
  bind_session_solves(c);
  bind_session_edits(c);
  bind_session_results(c);
}

SharedSession::SharedSession(std::shared_ptr<const Model> of, const Progress& progress)
    : scene_(of->scene()), lines_(of->lines()) {
  require_surface(*of);
  const ProgressScope scope(active_progress_, progress);
  model_ =
      std::make_shared<const SculptModel>(sculpt_model(*of->made(), scene_, forwarding_progress()));
  progress.update("session", 0);
  session_ = std::make_unique<SculptingSession>(
      make_session(*model_->layout, scene_, model_->made, FactorReuse::many, forwarding_progress(),
                   &start_, model_->fair.rest));
  solve_report_ = session_->solve_to_equilibrium();
}

Progress SharedSession::forwarding_progress() {
  Progress progress;
  progress.report = [this](std::string_view stage, double fraction) {
    if (active_progress_ && active_progress_->report) active_progress_->report(stage, fraction);
  };
  progress.cancelled = [this] {
    return active_progress_ && active_progress_->cancelled && active_progress_->cancelled();
  };
  return progress;
}

SolveReport SharedSession::solve_to_equilibrium(const Progress& progress) {
  return with_session(true, progress, [&](SculptingSession& session) {
    return solve_report_ = session.solve_to_equilibrium();
  });
}

SolveReport SharedSession::solve_preview(int max_iterations, double tolerance,
                                         const Progress& progress) {
  return with_session(true, progress, [&](SculptingSession& session) {
    return solve_report_ = session.solve_preview(max_iterations, tolerance);
  });
}

std::shared_ptr<const Frame> SharedSession::current_frame() {
  if (!stale_ && shown_) return shown_;
  shown_.reset();
  std::shared_ptr<Frame> free;
  for (const auto& frame : frames_)
    if (frame.use_count() == 1) free = frame;
  std::atomic_thread_fence(std::memory_order_acquire);  // pairs with the release of its last reader
  if (!free) {
    free = std::make_shared<Frame>();
    constexpr size_t most_kept = 4;
    if (frames_.size() < most_kept) frames_.push_back(free);
  }
  session_->draw(*free);
  shown_ = free;
  stale_ = false;
  return shown_;
}

std::shared_ptr<const Frame> SharedSession::frame(const Progress& progress) {
  return with_session(false, progress, [&](SculptingSession&) { return current_frame(); });
}

std::shared_ptr<const Model> SharedSession::model(const Progress& progress) {
  return with_session(false, progress, [&](SculptingSession& session) {
    SolvedShape shape = shape_of(session, scene_, start_.unloaded, solve_report_);
    Scene scene = scene_;
    for (const ScalarParameter& p : scene_.named_values())
      if (p.rule_terms.empty() && p.keyframes.empty() && session.parameters().has(p.name))
        scene.set(p.name, session.parameters().value(p.name), "");
    auto made = std::make_shared<const BuiltModel>(model_->made);
    return std::make_shared<const Model>(std::move(scene), lines_, std::move(made),
                                         std::move(shape));
  });
}

SharedSession::Stress SharedSession::stress(const Progress& progress) {
  if (!scene_.stress)
    throw InputError(scene_.name +
                     ": found no [stress], expected one with thickness, material and supports");
  return with_session(false, progress, [&](SculptingSession& session) {
    const auto shown = current_frame();
    if (!stress_) stress_.emplace(shell_problem(scene_));
    Stress result;
    result.largest = stress_->at(session.layout(), session.dofs());
    result.field =
        std::make_shared<ShellEvaluator::Field>(stress_->field(shown->pattern->locations));
    return result;
  });
}

}  // namespace batten::python
