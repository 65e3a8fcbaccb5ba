// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/session/session_system.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/sculpting/loads/loads.h"

namespace batten::detail {

MeshData::MeshData(const ModelLayout& layout)
    : mesh(layout.mesh()),
      trim(layout.trim()),
      kind(layout.element()),
      assembler(*mesh, kind, trim),
      domain_scale(layout.domain_scale()),
      vertices(dof_vertices(*mesh)),
      ones(layout.position_dofs()),
      displacement_weights(batten::displacement_weights(*mesh, trim.get())) {
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

size_t MeshData::bytes() const {
  constexpr size_t of_triangle = 1000, of_pressure = 1500;  // measured
  return static_cast<size_t>(mesh->triangle_count()) *
             (of_triangle + (pressure_ ? of_pressure : 0)) +
         12 * static_cast<size_t>(mass_.nonZeros());
}

namespace {

// Point clouds are part of the matrix.
bool has_point_clouds(const SessionDefinition& def) {
  return std::any_of(def.loads.begin(), def.loads.end(), [](const auto& l) {
    return std::holds_alternative<Load::PointCloudSprings>(l->load.kind);
  });
}

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

// Assembles the constraints of lines; reuses the coefficients if only curves changed.
void build_line_constraints(SessionSystem& system, const SessionSystem* older, bool same_mesh,
                            bool same_lines) {
  const ModelLayout& layout = system.layout();
  if (same_lines) {
    system.line_rows = older->line_rows;
    system.reduction = older->reduction;
    system.base_rhs = older->base_rhs;
  } else {
    throw_if_cancelled();
    const ConstraintSet set =
        system.def.fix_corners_only ? layout.corner_constraints() : layout.line_constraints();
    throw_if_cancelled();
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

// Looks up the parameter indices of loads, fields and offsets by name.
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

// Records what each parameter acts on. Must follow the auxiliary constraints, whose goals are
// parameters.
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

// What was made of the same item in another system, or null.
template <class Items, class Made>
typename Made::value_type reused(const Items& mine, const Items& theirs, const Made& made, size_t i,
                                 bool fits) {
  if (fits)
    for (size_t j = 0; j < theirs.size(); ++j)
      if (theirs[j] == mine[i]) return made[j];
  return nullptr;
}

// Computes the right-hand sides of offsets, or reuses those of the older system.
void build_offsets(SessionSystem& system, const SessionSystem* older, bool same_lines) {
  const auto& moves = system.def.moves;
  for (size_t i = 0; i < moves.size(); ++i) {
    auto known =
        older ? reused(moves, older->def.moves, older->offset_rhs, i, same_lines) : nullptr;
    system.offset_rhs.push_back(known ? known
                                      : std::make_shared<const MatX>(line_curve_rhs(
                                            system, moves[i]->move.line, moves[i]->displacement)));
  }
}

// Assembles loads and stiffness fields, or reuses those of the older system.
void build_loads(SessionSystem& system, const SessionSystem* older, bool same_mesh,
                 bool same_lines) {
  const SessionDefinition& d = system.def;
  const bool same_reduction = older && system.reduction == older->reduction;
  // A line load depends on its line's curve.
  const auto keeps = [&](const AttachedLoad& load) {
    return same_reduction && (same_lines || !std::holds_alternative<Load::Line>(load.load.kind));
  };
  for (size_t i = 0; i < d.loads.size(); ++i) {
    throw_if_cancelled();
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
}

// Keeps the values of the matrix if everything that it is made from is unchanged.
void keep_matrix_values(SessionSystem& system, const SessionSystem& older,
                        const Parameters& parameters) {
  const SessionDefinition& d = system.def;
  if (older.matrix_values.empty() || older.def.weights != d.weights ||
      has_point_clouds(older.def) || has_point_clouds(d))
    return;
  // Values are matched by name, because parameter indices may have changed.
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

// Reuses what was factored for the same reduction.
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
  system.matrix_load = older.matrix_load;
  system.matrix_load_reduced = older.matrix_load_reduced;
  system.rest_load = older.rest_load;
  system.rest_reduced = older.rest_reduced;
  system.coupling = older.coupling;  // reused only for its solves; the session recomputes the
                                     // couplings
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
  update_progress("constraints", 0);
  const bool same_mesh = older && older->layout().mesh() == layout.mesh();
  const bool same_lines = same_mesh && older->def.layout == system->def.layout;
  system->parts = same_mesh ? older->parts : std::make_shared<const MeshData>(layout);
  build_line_constraints(*system, older, same_mesh, same_lines);
  find_parameters(*system, parameters);
  build_loads(*system, older, same_mesh, same_lines);
  build_offsets(*system, older, same_lines);
  system->auxiliary = std::make_shared<const AuxiliaryConstraints>(
      build_auxiliary_constraints(*system, parameters));
  assign_roles(*system, parameters);
  system->scan_foot_points.resize(system->def.loads.size());
  system->scan_used.resize(system->def.loads.size());
  if (same_mesh) system->rest = older->rest;
  if (older && system->reduction == older->reduction) keep_systems(*system, *older, parameters);
  return system;
}

std::shared_ptr<SessionSystem> without_factors(const SessionSystem& system) {
  auto copy = std::make_shared<SessionSystem>(system);
  copy->statics.reset();
  copy->dynamics.reset();
  copy->coupling.reset();
  copy->dynamics_coupling.reset();
  copy->coupled_rows.reset();
  copy->dynamics_constraints.reset();
  return copy;
}

std::shared_ptr<SessionSystem> without_recomputable(const SessionSystem& system) {
  auto copy = without_factors(system);
  copy->parts.reset();
  copy->line_rows.reset();
  copy->reduction.reset();
  copy->base_rhs.resize(0, 3);
  copy->offset_rhs.clear();
  copy->auxiliary.reset();
  copy->matrix_load.resize(0, 3);
  copy->matrix_load_reduced.resize(0, 3);
  copy->rest_load.resize(0, 3);
  copy->rest_reduced.resize(0, 3);
  return copy;
}

namespace {

// Whether the matrices and the loads that belong to them are equal, on the same reduction.
bool same_matrix(const SessionSystem& a, const SessionSystem& b) {
  if (a.matrix_values.empty() || b.matrix_values.empty() || a.def.weights != b.def.weights ||
      a.rest != b.rest || has_point_clouds(a.def) || has_point_clouds(b.def))
    return false;
  const auto same = [&](int p, int q) { return a.matrix_values[p] == b.matrix_values[q]; };
  bool all = true;
  for (size_t k = 0; k < 3; ++k)
    all = all && same(a.alpha[k], b.alpha[k]) && same(a.beta[k], b.beta[k]);
  for (size_t w = 0; w < a.weight_parameter.size(); ++w)
    all = all && same(a.weight_parameter[w], b.weight_parameter[w]);
  return all;
}

}  // namespace

std::shared_ptr<SessionSystem> completed(const SessionSystem& incomplete,
                                         const Parameters& parameters, const SessionSystem& other) {
  auto system = std::make_shared<SessionSystem>(incomplete);
  const ModelLayout& layout = system->layout();
  const bool same_mesh = other.layout().mesh() == layout.mesh();
  const bool same_lines = same_mesh && other.def.layout == system->def.layout;
  system->parts = same_mesh ? other.parts : std::make_shared<const MeshData>(layout);
  build_line_constraints(*system, &other, same_mesh, same_lines);
  build_offsets(*system, &other, same_lines);
  system->auxiliary = std::make_shared<const AuxiliaryConstraints>(
      build_auxiliary_constraints(*system, parameters));
  if (system->reduction == other.reduction && other.statics && same_matrix(*system, other)) {
    system->statics = other.statics;
    system->coupling = other.coupling;
    system->coupled_rows = other.coupled_rows;
    system->matrix_load = other.matrix_load;
    system->matrix_load_reduced = other.matrix_load_reduced;
    system->rest_load = other.rest_load;
    system->rest_reduced = other.rest_reduced;
  }
  return system;
}

namespace {

size_t bytes_of(const SparseMatrix& matrix) {
  return 12 * static_cast<size_t>(matrix.nonZeros()) + 4 * static_cast<size_t>(matrix.cols());
}

size_t bytes_of(const ConstraintSet& set) {
  size_t sum = 0;
  for (const auto& row : set.constraints())
    sum += sizeof(row) + sizeof(row.entries[0]) * row.entries.capacity();
  for (const auto& row : set.coupled_constraints())
    sum += sizeof(row) + sizeof(row.entries[0]) * row.entries.capacity();
  return sum;
}

template <class Matrix>
size_t bytes_of(const Eigen::DenseBase<Matrix>& matrix) {
  return sizeof(double) * static_cast<size_t>(matrix.size());
}

size_t bytes_of_mesh(const ParametricMesh& mesh) {
  constexpr size_t of_triangle = 100;  // measured
  return of_triangle * static_cast<size_t>(mesh.triangle_count());
}

size_t bytes_of(const RegionLayout& region) {
  size_t sum = sizeof(region);
  if (region.trim()) sum += 60 * static_cast<size_t>(region.mesh()->triangle_count());
  for (const EdgeAlignedLine& line : region.edge_aligned())
    sum += sizeof(line) + 16 * line.vertices.size() + 2 * bytes_of(line.fitted.dofs());
  for (const EmbeddedLine& line : region.embedded())
    sum += sizeof(line) + 8 * line.points.size() + 2 * bytes_of(line.fitted.dofs()) +
           2 * bytes_of(line.pcurve.dofs());
  return sum;
}

}  // namespace

void visit_shared_parts(const SessionSystem& system,
                        const std::function<void(const void*, size_t)>& visit) {
  const auto part = [&](const auto& pointer, const auto& bytes) {
    if (pointer) visit(pointer.get(), bytes(*pointer));
  };
  const auto points = [](const Points& p) { return bytes_of(p); };
  const auto items = [&](const auto& list) {
    for (const auto& item : list) {
      part(item, [](const auto& i) { return sizeof(i) + 200; });
      part(item->on, points);
    }
  };
  items(system.def.loads);
  items(system.def.weights);
  items(system.def.constraints);
  for (const auto& move : system.def.moves)
    part(move,
         [](const AttachedOffset& m) { return sizeof(m) + 2 * bytes_of(m.displacement.dofs()); });
  part(system.def.layout, [](const ModelLayout& layout) {
    return sizeof(layout) + 500 * layout.lines().size() + bytes_of(layout.domain_scale());
  });
  part(system.layout().mesh(), bytes_of_mesh);
  for (int r = 0; r < system.layout().region_count(); ++r) {
    part(system.layout().region(r).mesh(), bytes_of_mesh);
    visit(&system.layout().region(r), bytes_of(system.layout().region(r)));
  }
  part(system.parts, [](const MeshData& mesh) { return mesh.bytes(); });
  part(system.line_rows, [](const ConstraintSet& set) { return bytes_of(set); });
  part(system.reduction, [](const AffineReduction& reduction) {
    return 2 * (bytes_of(reduction.D()) + bytes_of(reduction.rhs_to_particular()));
  });
  for (const auto& load : system.loads)
    part(load, [](const AssembledLoad& l) {
      return bytes_of(l.F) + bytes_of(l.reduced) + bytes_of(l.weights);
    });
  for (const auto& field : system.weights)
    part(field, [](const AssembledStiffnessField& w) {
      return bytes_of(w.weights) + sizeof(Vec2) * w.directions.size();
    });
  for (const auto& rhs : system.offset_rhs) part(rhs, [](const MatX& m) { return bytes_of(m); });
  part(system.auxiliary,
       [](const AuxiliaryConstraints& a) { return bytes_of(a.A) + 100 * a.rows.size(); });
  for (const auto* factor : {&system.statics, &system.dynamics})
    part(*factor, [](const ReusableFactorization& f) { return f.bytes(); });
  for (const auto* coupling : {&system.coupling, &system.dynamics_coupling})
    part(*coupling, [](const SchurComplementConstraints& c) { return c.bytes(); });
  part(system.rest, [](const RestConfiguration& rest) {
    return bytes_of(rest.dofs) + bytes_of(rest.first) + bytes_of(rest.rows);
  });
}

size_t own_bytes(const SessionSystem& system) {
  const SessionDefinition& def = system.def;
  size_t sum = sizeof(SessionSystem) + bytes_of(system.base_rhs) + bytes_of(system.rest_load) +
               bytes_of(system.rest_reduced) + bytes_of(system.matrix_load) +
               bytes_of(system.matrix_load_reduced);
  const size_t items =
      def.loads.size() + def.weights.size() + def.constraints.size() + def.moves.size();
  sum += 100 * items + sizeof(double) * (system.matrix_values.size() + system.roles.size());
  for (const auto& cloud : system.scan_foot_points) sum += (sizeof(ModelPoint) + 1) * cloud.size();
  return sum;
}

namespace {

int position_of(const std::vector<std::string>& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

}  // namespace

// Right-hand sides of all constraints if one line has another curve and all others are zero.
MatX line_curve_rhs(const SessionSystem& system, const std::string& name,
                    const HermiteCurve& curve) {
  const ModelLayout& layout = system.layout();
  const ModelLine& line = layout.model_line(name);
  // In the order of the constraints: region by region.
  std::vector<LineSide> sides = line.sides;
  std::sort(sides.begin(), sides.end(),
            [](const LineSide& a, const LineSide& b) { return a.region < b.region; });
  std::vector<Vec3> own;
  for (const LineSide& side : sides) {
    throw_if_cancelled();
    const RegionLayout& region = layout.region(side.region);
    const ParametricMesh& mesh = *region.mesh();
    const HermiteCurve along = layout.against(line, side) ? curve.backwards() : curve;
    ConstraintSet set(DofMap(mesh).count());
    const auto i = static_cast<size_t>(side.index);
    if (side.embedded) {
      const EmbeddedLine& embedded = region.embedded()[i];
      EmbeddedLineConstraints(mesh, system.parts->kind, system.parts->locator(side.region), set)
          .points(name, embedded.pcurve, along, embedded.points);
    } else {
      const EdgeAlignedLine& aligned_line = region.edge_aligned()[i];
      SurfaceConstraints(mesh, system.parts->kind, set)
          .curve(name, aligned_line.vertices, aligned_line.parameters, along,
                 mesh.chain_vector(aligned_line.vertices));
    }
    for (const auto& row : set.constraints()) own.push_back(row.value);
  }
  MatX rhs = MatX::Zero(system.base_rhs.rows(), 3);
  const auto& rows = system.line_rows->constraints();
  const int index = position_of(system.line_rows->names(), name);
  size_t next = 0;
  for (size_t r = 0; r < rows.size(); ++r)
    if (rows[r].name == index) {
      if (next == own.size()) break;
      rhs.row(static_cast<long>(r)) = own[next++];
    }
  if (next != own.size())
    throw InputError("the constraint equations of curve '" + name +
                     "' do not match those of the layout");
  return rhs;
}

AssembledLoad assembled(const AttachedLoad& placed, const SessionSystem& system) {
  AssembledLoad b;
  const MeshData& parts = *system.parts;
  const ModelScale scale = system.def.scale();
  const auto weights = [&](const Area& area) {
    return everywhere(area)
               ? VecX()
               : triangle_weights(area, system.layout(), surface_on(system.def, *placed.on));
  };
  if (const auto* p = std::get_if<Load::Pressure>(&placed.load.kind)) {
    b.weights = weights(p->area);
    parts.pressure();  // computed now rather than during the first solve
    b.scale = scale.per_area();
  } else if (const auto* u = std::get_if<Load::Uniform>(&placed.load.kind)) {
    const Vec3 f = scale.per_domain_area() * u->direction;
    VecX w = weights(u->area);
    if (parts.domain_scale.size() > 0)
      w = w.size() > 0 ? VecX(w.cwiseProduct(parts.domain_scale)) : parts.domain_scale;
    if (w.size() == 0)
      b.F = parts.assembler.load(f);
    else
      b.F = parts.assembler.load(w) * f.transpose();
  } else if (const auto* g = std::get_if<Load::Gravity>(&placed.load.kind)) {
    const Vec3 f = scale.per_area() * g->direction;
    b.F = parts.assembler.area_load(surface_on(system.def, *placed.on)) * f.transpose();
  } else if (const auto* f = std::get_if<Load::Point>(&placed.load.kind)) {
    b.F = parts.assembler.point_load(parts.at(placed.foot_points[0]), scale.force() * f->direction);
  } else if (const auto* l = std::get_if<Load::Line>(&placed.load.kind)) {
    const LineSide& side = system.layout().model_line(l->line).sides.front();
    b.F = system.layout().spread(side.region,
                                 line_load(*system.layout().region(side.region).mesh(), parts.kind,
                                           parts.locator(side.region), system.layout().pcurve(side),
                                           system.layout().curve(side))) *
          l->direction.transpose();
  }
  if (b.F.rows() > 0) b.reduced = system.reduction->D().transpose() * b.F;
  return b;
}

AssembledStiffnessField assembled(const AttachedStiffnessField& placed,
                                  const SessionSystem& system) {
  AssembledStiffnessField b;
  const StiffnessField& w = placed.weight;
  const int triangles = system.parts->mesh->triangle_count();
  b.weights = everywhere(w.area)
                  ? VecX(VecX::Ones(triangles))
                  : triangle_weights(w.area, system.layout(), surface_on(system.def, *placed.on));
  if (!w.along) return b;
  if (const auto* uv = std::get_if<Vec2>(&*w.along))
    b.directions.assign(static_cast<size_t>(triangles), uv->normalized());
  else
    b.directions = triangle_directions(std::get<std::string>(*w.along), system.layout());
  return b;
}

const std::string& AuxiliaryConstraints::name_of(int row) const {
  for (const Block& block : blocks)
    if (row < block.end_row) return block.name;
  return blocks.back().name;
}

namespace {

class AuxiliaryConstraintsBuilder {
 public:
  explicit AuxiliaryConstraintsBuilder(int dofs) : dofs_(dofs) {}
  void begin(const void* owner, const std::string& name) {
    points_here_.clear();
    rows.blocks.push_back({owner, name, count_, count_, here(), here()});
  }
  void end() {
    rows.blocks.back().end_point = count_;
    rows.blocks.back().end_row = here();
  }
  using Terms = std::vector<std::pair<int, double>>;
  // The constraints of one item share its points.
  int point(const Terms& terms) {
    const auto [it, fresh] = points_here_.emplace(terms, count_);
    if (fresh) {
      for (const auto& [dof, value] : terms) entries_.emplace_back(dof, count_, value);
      ++count_;
    }
    return it->second;
  }
  void add(int point, const Vec3& direction, double size, bool soft,
           AuxiliaryConstraints::Source source) {
    rows.rows.push_back({point, direction, size, soft});
    rows.sources.push_back(source);
  }
  // Adds a coupled constraint: with one point if all its coefficients are parallel, otherwise with
  // one point per coordinate.
  void add(const ConstraintSet::CoupledConstraint& row) {
    double largest = 0, size = 0;
    Vec3 direction = Vec3::UnitX();
    std::map<int, Vec3> sums;
    for (const auto& e : row.entries)
      sums.try_emplace(e.dof, Vec3::Zero()).first->second += e.coefficient;
    for (const auto& [dof, n] : sums) {
      size += n.squaredNorm();
      if (n.norm() <= largest) continue;
      largest = n.norm();
      direction = n.normalized();
    }
    if (!(size > 0)) return;
    const auto along = [&](const Vec3& d) {
      Terms terms;
      for (const auto& [dof, n] : sums)
        if (const double part = n.dot(d); part != 0) terms.emplace_back(dof, part);
      return terms;
    };
    const bool one = std::all_of(sums.begin(), sums.end(), [&](const auto& s) {
      return (s.second - s.second.dot(direction) * direction).norm() <= 1e-13 * largest;
    });
    SchurComplementConstraints::Constraint made{-1, direction, std::sqrt(size)};
    if (one) {
      made.point = point(along(direction));
    } else {
      for (int c = 0; c < 3; ++c) {
        const Terms terms = along(Vec3::Unit(c));
        if (terms.empty()) continue;
        if (made.point < 0) {
          made.point = point(terms);
          made.direction = Vec3::Unit(c);
        } else {
          made.further_terms.push_back({point(terms), Vec3::Unit(c)});
        }
      }
    }
    // Skips duplicates (edges of a line share their ends).
    for (int r = rows.blocks.back().first_row; r < here(); ++r) {
      const SchurComplementConstraints::Constraint& other = rows.rows[r];
      if (one && other.further_terms.empty() && other.point == made.point &&
          (other.direction - made.direction).norm() < 1e-12)
        return;
    }
    rows.rows.push_back(std::move(made));
    rows.sources.push_back({});
  }
  AuxiliaryConstraints take() {
    rows.A.resize(dofs_, count_);
    rows.A.setFromTriplets(entries_.begin(), entries_.end());
    return std::move(rows);
  }
  AuxiliaryConstraints rows;

 private:
  int here() const { return isize(rows.rows); }
  int dofs_, count_ = 0;
  std::vector<Triplet> entries_;
  std::map<Terms, int> points_here_;
};

std::vector<std::pair<int, double>> functional(const MeshData& parts, const ModelPoint& at) {
  const Location where = parts.at(at);
  const Vec12 N =
      C1Triangle(parts.kind, parts.mesh->shape(where.triangle)).evaluate(where.L).col(kW);
  const auto dof = parts.assembler.dofs().triangle(*parts.mesh, where.triangle);
  std::vector<std::pair<int, double>> terms;
  for (int a = 0; a < 12; ++a)
    if (N[a] != 0) terms.emplace_back(dof[a], N[a]);
  std::sort(terms.begin(), terms.end());
  return terms;
}

double length_of(const std::vector<std::pair<int, double>>& terms) {
  double sum = 0;
  for (const auto& t : terms) sum += t.second * t.second;
  return std::sqrt(sum);
}

void add_line_normal(const AttachedConstraint& placed, const SessionSystem& system,
                     ConstraintSet& set) {
  const MeshData& parts = *system.parts;
  const ModelLayout& layout = system.layout();
  const auto& along = std::get<Constraint::LineNormal>(placed.constraint.kind);
  const std::string& name = placed.constraint.name;
  std::optional<Surface> on;
  if (placed.on) on.emplace(surface_on(system.def, *placed.on));
  std::vector<LineSide> sides = layout.model_line(along.line).sides;
  if (layout.join_plan(along.line)) sides.resize(1);
  for (const LineSide& side : sides) {
    const RegionLayout& region = layout.region(side.region);
    const ParametricMesh& mesh = *region.mesh();
    const auto normal_at = [&](const Vec2& uv) -> Vec3 {
      return along.normal ? along.normal->normalized()
                          : on->jet(parts.at({side.region, uv})).normal();
    };
    ConstraintSet own(DofMap(mesh).count());
    const auto i = static_cast<size_t>(side.index);
    if (side.embedded) {
      const EmbeddedLine& line = region.embedded()[i];
      EmbeddedLineConstraints(mesh, parts.kind, parts.locator(side.region), own)
          .normal(name, line.pcurve, line.points,
                  [&](double t) { return normal_at(drop_z(line.pcurve.evaluate(t))); });
    } else {
      const auto n = [&](int edge, double s) {
        const auto& e = mesh.edges()[edge];
        const Vec2 low = mesh.vertices()[e.low];
        const Vec2 high = mesh.image_near(mesh.vertices()[e.high], low);
        return normal_at(mesh.wrapped(low + s * (high - low)));
      };
      SurfaceConstraints(mesh, parts.kind, own)
          .varying_normal(name, region.edge_aligned()[i].edges, n, true);
    }
    for (const auto& row : own.coupled_constraints()) {
      auto entries = row.entries;
      for (auto& e : entries) e.dof = layout.dof_offsets(side.region)(e.dof);
      set.add_coupled(name, std::move(entries), row.value);
    }
  }
}

}  // namespace

AuxiliaryConstraints build_auxiliary_constraints(const SessionSystem& system,
                                                 const Parameters& parameters) {
  AuxiliaryConstraintsBuilder all(system.dofs());
  const MeshData& parts = *system.parts;
  for (const auto& placed : system.def.constraints) {
    throw_if_cancelled();
    const Constraint& c = placed->constraint;
    all.begin(placed.get(), c.name);
    if (std::holds_alternative<Constraint::Point>(c.kind)) {
      const auto terms = functional(parts, placed->foot_point);
      const int point = all.point(terms);
      const char* axis[] = {".x", ".y", ".z"};
      for (int k = 0; k < 3; ++k)
        all.add(point, Vec3::Unit(k), length_of(terms), false,
                {AuxiliaryConstraints::Source::Goal, parameters.index(c.name + axis[k]), k});
    } else {
      ConstraintSet set(system.dofs());
      SurfaceConstraints shape(*parts.mesh, parts.kind, set);
      if (const auto* normal = std::get_if<Constraint::Normal>(&c.kind))
        shape.normal(c.name, parts.at(placed->foot_point), normal->normal);
      else if (const auto* tangent = std::get_if<Constraint::Tangent>(&c.kind))
        shape.tangent(c.name, parts.at(placed->foot_point), tangent->along, tangent->tau);
      else
        add_line_normal(*placed, system, set);
      for (const auto& row : set.coupled_constraints()) all.add(row);
    }
    all.end();
  }
  for (size_t l = 0; l < system.def.loads.size(); ++l) {
    const AttachedLoad& placed = *system.def.loads[l];
    const auto* springs = std::get_if<Load::AttractorSprings>(&placed.load.kind);
    if (!springs) continue;
    all.begin(&placed, placed.load.name);
    const auto* plane = std::get_if<Load::AttractorSprings::Plane>(&springs->target);
    for (size_t i = 0; i < placed.foot_points.size(); ++i) {
      poll_every<256>(static_cast<long>(i));
      const auto terms = functional(parts, placed.foot_points[i]);
      const int point = all.point(terms);
      AuxiliaryConstraints::Source source{AuxiliaryConstraints::Source::Spring,
                                          system.load_parameter[l], -1, static_cast<int>(l),
                                          static_cast<int>(i)};
      if (plane) {
        all.add(point, plane->normal.normalized(), length_of(terms), true, source);
        continue;
      }
      for (source.coordinate = 0; source.coordinate < 3; ++source.coordinate)
        all.add(point, Vec3::Unit(source.coordinate), length_of(terms), true, source);
    }
    all.end();
  }
  return all.take();
}

}  // namespace batten::detail

namespace batten {

VecX displacement_weights(const ParametricMesh& mesh, const Trim* trim) {
  const DofMap dofs(mesh);
  VecX weights = VecX::Zero(dofs.count());
  constexpr double seen = 0.05;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<16384>(t);
    if (trim && trim->area_fraction(t) < seen) continue;
    const double h = std::sqrt(2 * mesh.shape(t).area);
    for (const int v : mesh.triangles()[t]) {
      weights[dofs.vertex(v)] = 1;
      for (const int derivative : {1, 2}) {
        double& w = weights[dofs.vertex(v, derivative)];
        w = std::max(w, h);
      }
    }
    for (const int e : mesh.edges_of(t)) weights[dofs.edge(e)] = std::max(weights[dofs.edge(e)], h);
  }
  return weights;
}

}  // namespace batten
