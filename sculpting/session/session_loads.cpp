#include <algorithm>

#include "batten/constraints/shape/embedded_line_constraints.h"
#include "batten/constraints/shape/surface_constraints.h"
#include "batten/core/errors.h"
#include "batten/fem/line_load.h"
#include "batten/sculpting/loads/area_weights.h"
#include "batten/sculpting/session/session_system.h"

namespace batten::detail {

namespace {

int position_of(const std::vector<std::string>& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

}  // namespace

// Right-hand sides of all rows when one line has another curve and all others are zero.
MatX line_curve_rhs(const SessionSystem& system, const std::string& name,
                    const HermiteCurve& curve) {
  const ModelLayout& layout = system.layout();
  const ModelLine& line = layout.model_line(name);
  // In the order of the rows: region by region.
  std::vector<LineSide> sides = line.sides;
  std::sort(sides.begin(), sides.end(),
            [](const LineSide& a, const LineSide& b) { return a.region < b.region; });
  std::vector<Vec3> own;
  for (const LineSide& side : sides) {
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
    throw InputError("the rows of line '" + name + "' do not fit the layout's");
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
    parts.pressure();  // now, and not in the first answer
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

}  // namespace batten::detail
