#include "batten/sculpting/session/session_system.h"

#include <algorithm>

#include "batten/fem/nested_dissection.h"

namespace batten::detail {

MeshData::MeshData(const ModelLayout& layout)
    : mesh(layout.mesh()),
      trim(layout.trim()),
      kind(layout.element()),
      assembler(*mesh, kind, trim),
      domain_scale(layout.domain_scale()),
      vertices(dof_vertices(*mesh)),
      ones(layout.position_dofs()) {
  for (int r = 0; r < layout.region_count(); ++r) {
    region_meshes.push_back(layout.region(r).mesh());
    locators.push_back(std::make_unique<TriangleLocator>(*region_meshes.back()));
    first_triangle.push_back(layout.first_triangle(r));
  }
}

const SparseMatrix& MeshData::mass() const {
  if (mass_.rows() == 0) mass_ = assembler.mass(domain_scale);
  return mass_;
}

const PressureOperator& MeshData::pressure() const {
  if (!pressure_) pressure_ = std::make_unique<PressureOperator>(*mesh, kind, trim);
  return *pressure_;
}

Location MeshData::at(const ModelPoint& point) const {
  Location where = locator(point.region).locate(point.uv);
  where.triangle += first_triangle[point.region];
  return where;
}

size_t MeshData::bytes() const { return static_cast<size_t>(mesh->triangle_count()) * 1400; }

namespace {

bool nonlinear(const Load::AttractorSprings& springs) {
  return std::holds_alternative<Load::AttractorSprings::Curve>(springs.target) ||
         springs.rest_length != 0 || springs.falloff != 0;
}

unsigned role_of(const Load& load) {
  if (std::holds_alternative<Load::Pressure>(load.kind)) return kPressure;
  if (const auto* springs = std::get_if<Load::AttractorSprings>(&load.kind))
    return nonlinear(*springs) ? kSpring | kPressure : kSpring;
  return std::holds_alternative<Load::PointCloudSprings>(load.kind) ? kMatrix : kLinear;
}

MatX constraint_rhs(const ConstraintSet& set) {
  MatX rhs(static_cast<long>(set.constraints().size()), 3);
  for (long r = 0; r < rhs.rows(); ++r) rhs.row(r) = set.constraints()[r].value;
  return rhs;
}

bool same_coefficients(const ConstraintSet& a, const ConstraintSet& b) {
  return a.names() == b.names() &&
         std::equal(a.constraints().begin(), a.constraints().end(), b.constraints().begin(),
                    b.constraints().end(), [](const auto& x, const auto& y) {
                      return x.name == y.name &&
                             std::equal(x.entries.begin(), x.entries.end(), y.entries.begin(),
                                        y.entries.end(), [](const auto& p, const auto& q) {
                                          return p.dof == q.dof && p.coefficient == q.coefficient;
                                        });
                    });
}

// Rows of lines: the same coefficients when only curves changed.
void build_line_constraints(SessionSystem& system, const SessionSystem* older, bool same_mesh,
                            bool same_lines) {
  const ModelLayout& layout = system.layout();
  if (same_lines) {
    system.line_rows = older->line_rows;
    system.reduction = older->reduction;
    system.base_rhs = older->base_rhs;
  } else {
    const ConstraintSet set =
        system.def.fix_corners_only ? layout.corner_constraints() : layout.line_constraints();
    system.line_rows =
        std::make_shared<const ConstraintSet>(set.translated(system.parts->ones, system.origin()));
    system.base_rhs = constraint_rhs(*system.line_rows);
    if (same_mesh && same_coefficients(*older->line_rows, *system.line_rows))
      system.reduction = older->reduction;
    else
      system.reduction = std::make_shared<const AffineReduction>(
          *system.line_rows, AffineReduction::RhsMode::Deferred);
  }
}

// Which parameter moves what, by name.
void find_parameters(SessionSystem& system, const Parameters& parameters) {
  const SessionDefinition& d = system.def;
  for (const auto& load : d.loads)
    system.load_parameter.push_back(parameters.index(load->load.name));
  for (const auto& w : d.weights)
    system.weight_parameter.push_back(parameters.index(w->weight.name));
  for (const auto& m : d.moves) system.move_parameter.push_back(parameters.index(m->move.name));
  const auto three = [&](const std::string& name, const std::array<const char*, 3>& ends) {
    if (parameters.has(name)) {
      const int i = parameters.index(name);
      return std::array<int, 3>{i, i, i};
    }
    std::array<int, 3> all{};
    for (size_t k = 0; k < 3; ++k) all[k] = parameters.index(name + ends[k]);
    return all;
  };
  system.alpha = three("alpha", {"_uu", "_uv", "_vv"});
  system.beta = three("beta", {"_uu", "_uv", "_vv"});
}

// Notes what each parameter acts on. The loose rows are made before, because goals act on them.
void assign_roles(SessionSystem& system, const Parameters& parameters) {
  const SessionDefinition& d = system.def;
  system.roles.assign(static_cast<size_t>(parameters.count()), kNothing);
  const auto give = [&](int parameter, unsigned role) { system.roles[parameter] |= role; };
  for (const int p : system.alpha) give(p, kMatrix);
  for (const int p : system.beta) give(p, kMatrix);
  for (size_t i = 0; i < d.loads.size(); ++i)
    give(system.load_parameter[i], role_of(d.loads[i]->load));
  for (const int p : system.weight_parameter) give(p, kMatrix);
  for (const int p : system.move_parameter) give(p, kRhs);
  for (const auto& source : system.auxiliary->sources)
    if (source.kind == AuxiliaryConstraints::Source::Goal) give(source.parameter, kGoal);
}

// What acts, as far as it is not there already.
void build_loads(SessionSystem& system, const SessionSystem* older, bool same_mesh,
                 bool same_lines) {
  const SessionDefinition& d = system.def;
  const bool same_reduction = older && system.reduction == older->reduction;
  const auto reused = [&](const auto& mine, const auto& theirs, const auto& made, size_t i,
                          bool fits) -> std::decay_t<decltype(made[0])> {
    if (fits)
      for (size_t j = 0; j < theirs.size(); ++j)
        if (theirs[j] == mine[i]) return made[j];
    return nullptr;
  };
  // A line load follows its line's curve.
  const auto keeps = [&](const AttachedLoad& load) {
    return same_reduction && (same_lines || !std::holds_alternative<Load::Line>(load.load.kind));
  };
  for (size_t i = 0; i < d.loads.size(); ++i) {
    auto known =
        older ? reused(d.loads, older->def.loads, older->loads, i, keeps(*d.loads[i])) : nullptr;
    system.loads.push_back(
        known ? known : std::make_shared<const AssembledLoad>(assembled(*d.loads[i], system)));
  }
  for (size_t i = 0; i < d.weights.size(); ++i) {
    auto known =
        older ? reused(d.weights, older->def.weights, older->weights, i, same_mesh) : nullptr;
    system.weights.push_back(
        known ? known
              : std::make_shared<const AssembledStiffnessField>(assembled(*d.weights[i], system)));
  }
  for (size_t i = 0; i < d.moves.size(); ++i) {
    auto known =
        older ? reused(d.moves, older->def.moves, older->offset_rhs, i, same_lines) : nullptr;
    system.offset_rhs.push_back(
        known ? known
              : std::make_shared<const MatX>(
                    line_curve_rhs(system, d.moves[i]->move.line, d.moves[i]->displacement)));
  }
}

// Keeps the numbers of the matrix when all that it is made of is the same.
void keep_matrix_values(SessionSystem& system, const SessionSystem& older,
                        const Parameters& parameters) {
  const SessionDefinition& d = system.def;
  const bool same_matrix = older.def.weights == d.weights && older.scan_load.rows() == 0 &&
                           std::none_of(d.loads.begin(), d.loads.end(), [](const auto& l) {
                             return std::holds_alternative<Load::PointCloudSprings>(l->load.kind);
                           });
  if (!same_matrix || older.matrix_values.empty()) return;
  // Values by name: numbers of parameters may have changed.
  system.matrix_values.assign(static_cast<size_t>(parameters.count()), 0);
  const auto take = [&](int mine, int theirs) {
    system.matrix_values[mine] = older.matrix_values[theirs];
  };
  for (size_t k = 0; k < 3; ++k) {
    take(system.alpha[k], older.alpha[k]);
    take(system.beta[k], older.beta[k]);
  }
  for (size_t i = 0; i < d.weights.size(); ++i)
    take(system.weight_parameter[i], older.weight_parameter[i]);
}

// Takes over what was factored on the same reduction.
void keep_systems(SessionSystem& system, const SessionSystem& older, const Parameters& parameters) {
  const SessionDefinition& d = system.def;
  system.statics = older.statics;
  system.dynamics = older.dynamics;
  system.motion = older.motion;
  for (size_t i = 0; i < d.loads.size(); ++i)
    for (size_t j = 0; j < older.def.loads.size(); ++j)
      if (older.def.loads[j] == d.loads[i]) {
        system.scan_foot_points[i] = older.scan_foot_points[j];
        system.scan_used[i] = older.scan_used[j];
      }
  keep_matrix_values(system, older, parameters);
  system.rest_load = older.rest_load;
  system.rest_reduced = older.rest_reduced;
  system.coupling = older.coupling;  // for its solves; the session makes it anew
  system.dynamics_coupling = older.dynamics_coupling;
  system.coupled_rows = older.coupled_rows;
  system.dynamics_constraints = older.dynamics_constraints;
}

}  // namespace

std::shared_ptr<SessionSystem> build(SessionDefinition def, const Parameters& parameters,
                                     const SessionSystem* older) {
  auto system = std::make_shared<SessionSystem>();
  system->def = std::move(def);
  const ModelLayout& layout = *system->def.layout;
  const bool same_mesh = older && older->layout().mesh() == layout.mesh();
  const bool same_lines = same_mesh && older->def.layout == system->def.layout;
  system->parts = same_mesh ? older->parts : std::make_shared<const MeshData>(layout);
  build_line_constraints(*system, older, same_mesh, same_lines);
  find_parameters(*system, parameters);
  build_loads(*system, older, same_mesh, same_lines);
  system->auxiliary = std::make_shared<const AuxiliaryConstraints>(
      build_auxiliary_constraints(*system, parameters));
  assign_roles(*system, parameters);
  system->scan_foot_points.resize(system->def.loads.size());
  system->scan_used.resize(system->def.loads.size());
  if (same_mesh) system->rest = older->rest;
  if (older && system->reduction == older->reduction) keep_systems(*system, *older, parameters);
  return system;
}

size_t bytes_of(const SessionSystem& system, std::set<const void*>& seen) {
  size_t sum = 0;
  const auto once = [&](const void* what, size_t bytes) {
    if (what && seen.insert(what).second) sum += bytes;
  };
  const auto n = static_cast<size_t>(system.dofs());
  once(system.parts.get(), system.parts->bytes());
  once(system.reduction.get(),
       12 * static_cast<size_t>(system.reduction->D().nonZeros() +
                                system.reduction->rhs_to_particular().nonZeros()));
  for (const auto& load : system.loads)
    once(load.get(), 8 * static_cast<size_t>(load->F.size() + load->reduced.size()) +
                         8 * static_cast<size_t>(load->weights.size()));
  for (const auto& w : system.weights)
    once(w.get(), 8 * static_cast<size_t>(w->weights.size()) + 16 * w->directions.size());
  for (const auto& m : system.offset_rhs) once(m.get(), 8 * static_cast<size_t>(m->size()));
  once(system.auxiliary.get(), 16 * static_cast<size_t>(system.auxiliary->A.nonZeros()));
  for (const auto& placed : system.def.loads) once(placed->on.get(), 24 * n);
  for (const auto& placed : system.def.weights) once(placed->on.get(), 24 * n);
  for (const auto& placed : system.def.constraints) once(placed->on.get(), 24 * n);
  for (const auto* made : {system.statics.get(), system.dynamics.get()})
    if (made) once(made, made->bytes());
  for (const auto* coupling : {system.coupling.get(), system.dynamics_coupling.get()})
    if (coupling) once(coupling, coupling->bytes());
  if (system.rest)
    once(system.rest.get(),
         8 * static_cast<size_t>(system.rest->dofs.size() + system.rest->first.size()));
  return sum + 8 * static_cast<size_t>(system.base_rhs.size() + system.scan_load.size() +
                                       system.rest_load.size());
}

}  // namespace batten::detail
