#include <algorithm>
#include <cmath>
#include <map>

#include "batten/constraints/shape/embedded_line_constraints.h"
#include "batten/constraints/shape/surface_constraints.h"
#include "batten/core/isize.h"
#include "batten/core/planar_geometry.h"
#include "batten/sculpting/session/session_system.h"

namespace batten::detail {

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
  // Points of one thing are shared by its rows.
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
  // Adds a coupled row: with one point when all its coefficients are parallel, otherwise with one
  // for each coordinate.
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
    // The same row twice (edges of a line share their ends).
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
