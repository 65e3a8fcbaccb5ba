#include "batten/sculpting/session_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/constraints/shape/embedded_rows.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/fem/dissection.h"
#include "batten/fem/line_load.h"
#include "batten/sculpting/area.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::live {
namespace {

void require_finite(const std::string& name, bool finite) {
  if (!finite) throw InputError("'" + name + "' has a number that is not finite");
}

void require_direction(const std::string& name, const Vec3& direction) {
  require_finite(name, direction.allFinite());
  if (!(direction.norm() > 0)) throw InputError("'" + name + "' has a direction of no length");
}

// Where the surface is nearest to a place in space.
ModelPoint foot(const std::string& name, const Vec3& at, const ModelProjector& projector,
                double size) {
  require_finite(name, at.allFinite());
  const auto closest = projector.nearest_inside(at);
  constexpr double far = 0.5;  // of the size: no rounding, a mistake
  if (!(closest.distance <= far * size))
    throw InputError("'" + name + "': the surface is " + number(closest.distance) +
                     " away from where it should act (the region's size is " + number(size) + ")");
  return closest.at;
}

Surface surface_on(const Definition& def, const Points& dofs) { return def.layout->surface(dofs); }

SharedPoints shared(const Surface& surface) { return std::make_shared<Points>(surface.dofs()); }

bool everywhere(const Area& area) {
  return std::holds_alternative<Area::Everywhere>(area.where) && area.regions.empty();
}

void check_area(const Area& area, const Definition& def, const Surface& surface) {
  if (!everywhere(area)) triangle_weights(area, *def.layout, surface);  // throws what is wrong
}

int position_of(const std::vector<std::string>& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

}  // namespace

MeshParts::MeshParts(const ModelLayout& layout)
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

const SparseMatrix& MeshParts::mass() const {
  if (mass_.rows() == 0) mass_ = assembler.mass(domain_scale);
  return mass_;
}

const PressureOperator& MeshParts::pressure() const {
  if (!pressure_) pressure_ = std::make_unique<PressureOperator>(*mesh, kind, trim);
  return *pressure_;
}

Location MeshParts::at(const ModelPoint& point) const {
  Location where = locator(point.region).locate(point.uv);
  where.triangle += first_triangle[static_cast<size_t>(point.region)];
  return where;
}

size_t MeshParts::bytes() const { return static_cast<size_t>(mesh->triangle_count()) * 1400; }

HermiteCurve sum(const HermiteCurve& a, const HermiteCurve& b, double factor) {
  const HermiteCurve whole = a.with_nodes(b.parameters()), other = b.with_nodes(a.parameters());
  const CurveMesh& mesh = whole.mesh();
  Points dofs = whole.dofs();
  for (int n = 0; n < mesh.node_count(); ++n) {
    dofs.row(mesh.position_dof(n)) += factor * other.position(n).transpose();
    if (mesh.slope_in(n) != mesh.slope_out(n))
      dofs.row(mesh.slope_in(n)) += factor * other.slope_in(n).transpose();
    dofs.row(mesh.slope_out(n)) += factor * other.slope_out(n).transpose();
  }
  return {mesh, dofs};
}

PlacedLoad place(const Load& load, const Definition& def, const Surface& surface) {
  PlacedLoad placed{load, {}, nullptr};
  const double size = def.layout->size();
  const std::string& name = load.name;
  std::optional<ModelProjector> projector;
  const auto put = [&](const Vec3& at) {
    if (!projector) projector.emplace(*def.layout, surface.dofs());
    placed.feet.push_back(foot(name, at, *projector, size));
  };
  if (const auto* p = std::get_if<Load::Pressure>(&load.kind)) {
    check_area(p->area, def, surface);
    if (!everywhere(p->area)) placed.on = shared(surface);
  } else if (const auto* u = std::get_if<Load::Uniform>(&load.kind)) {
    require_direction(name, u->direction);
    check_area(u->area, def, surface);
    if (!everywhere(u->area)) placed.on = shared(surface);
  } else if (const auto* g = std::get_if<Load::Gravity>(&load.kind)) {
    require_direction(name, g->direction);
    placed.on = shared(surface);
  } else if (const auto* f = std::get_if<Load::Point>(&load.kind)) {
    require_direction(name, f->direction);
    put(f->at);
  } else if (const auto* line = std::get_if<Load::Line>(&load.kind)) {
    require_direction(name, line->direction);
    def.layout->model_line(line->line);
  } else if (const auto* s = std::get_if<Load::Pulls>(&load.kind)) {
    if (s->at.empty()) throw InputError("'" + name + "' has no springs: 'at' is empty");
    if (!(s->rest_length >= 0) || !(s->falloff >= 0) || !std::isfinite(s->rest_length + s->falloff))
      throw InputError("'" + name + "' has a rest length of " + number(s->rest_length) +
                       " and a falloff of " + number(s->falloff) + ": expected 0 or more");
    for (const Vec3& at : s->at) put(at);
    if (const auto* places = std::get_if<Load::Pulls::Places>(&s->target)) {
      if (places->to.size() != s->at.size())
        throw InputError("'" + name + "' has " + std::to_string(s->at.size()) + " springs and " +
                         std::to_string(places->to.size()) + " places to pull them to");
      for (const Vec3& to : places->to) require_finite(name, to.allFinite());
    } else if (const auto* plane = std::get_if<Load::Pulls::Plane>(&s->target)) {
      require_finite(name, plane->through.allFinite());
      require_direction(name, plane->normal);
    } else if (std::get<Load::Pulls::Curve>(s->target).curve.segment_count() < 1) {
      throw InputError("'" + name + "' has springs to a curve without segments");
    }
  } else {
    const auto& points = std::get<Load::Springs>(load.kind).points;
    if (points.empty()) throw InputError("'" + name + "' has no points for its springs");
    for (const Vec3& at : points) require_finite(name, at.allFinite());
  }
  return placed;
}

PlacedWeight place(const WeightField& weight, const Definition& def, const Surface& surface) {
  check_area(weight.area, def, surface);
  if (weight.along) {
    if (const auto* uv = std::get_if<Vec2>(&*weight.along)) {
      if (!uv->allFinite() || !(uv->norm() > 0))
        throw InputError("'" + weight.name + "' acts along a direction of no length");
    } else {
      def.layout->model_line(std::get<std::string>(*weight.along));
    }
  }
  return {weight, everywhere(weight.area) ? nullptr : shared(surface)};
}

PlacedConstraint place(const Constraint& c, const Definition& def, const Surface& surface) {
  PlacedConstraint placed{c, {}, nullptr};
  const double size = def.layout->size();
  if (const auto* point = std::get_if<Constraint::Point>(&c.kind)) {
    require_finite(c.name, point->goal.allFinite());
    placed.foot = foot(c.name, point->at, ModelProjector(*def.layout, surface.dofs()), size);
  } else if (const auto* normal = std::get_if<Constraint::Normal>(&c.kind)) {
    require_direction(c.name, normal->normal);
    placed.foot = foot(c.name, normal->at, ModelProjector(*def.layout, surface.dofs()), size);
  } else if (const auto* tangent = std::get_if<Constraint::Tangent>(&c.kind)) {
    require_direction(c.name, tangent->tau);
    if (!tangent->along.allFinite() || !(tangent->along.norm() > 0))
      throw InputError("'" + c.name + "' has no direction in (u, v)");
    placed.foot = foot(c.name, tangent->at, ModelProjector(*def.layout, surface.dofs()), size);
  } else {
    const auto& along = std::get<Constraint::LineNormal>(c.kind);
    def.layout->model_line(along.line);
    if (along.normal)
      require_direction(c.name, *along.normal);
    else
      placed.on = shared(surface);
  }
  return placed;
}

namespace {

// The normals of a surface along a line: the mean of those on its sides.
class NormalsAlong {
 public:
  NormalsAlong(const ModelLayout& layout, const ModelLine& line, const Surface& surface)
      : surface_(surface) {
    for (const LineSide& side : line.sides)
      sides_.push_back({layout.image(side), layout.against(line, side),
                        layout.first_triangle(side.region),
                        std::make_unique<TriangleLocator>(*layout.region(side.region).mesh())});
  }
  Vec3 at(double t) const {
    Vec3 sum = Vec3::Zero();
    for (const auto& side : sides_) {
      const HermiteCurve& image = side.image;
      Location where = side.locator->locate(
          flat(image.evaluate(side.against ? image.start() + image.end() - t : t)));
      where.triangle += side.first_triangle;
      sum += surface_.jet(where).normal();
    }
    return sides_.size() == 1 ? sum : sum.normalized();
  }

 private:
  struct Side {
    HermiteCurve image;
    bool against;
    int first_triangle;
    std::unique_ptr<TriangleLocator> locator;
  };
  const Surface& surface_;
  std::vector<Side> sides_;
};

}  // namespace

PlacedMove place(const LineMove& move, const Definition& def, const Surface& surface) {
  if (def.hold_corners)
    throw InputError("'" + move.name + "': lines are not held here, only corners are");
  if (move.direction) require_direction(move.name, *move.direction);
  if (!(move.fade >= 0 && move.fade <= 0.5))
    throw InputError("'" + move.name + "' fades over " + number(move.fade) +
                     " of its line: expected 0 to 0.5 of its length at either end");
  const ModelLayout& layout = *def.layout;
  const ModelLine& line = layout.model_line(move.line);
  const HermiteCurve& fitted = layout.curve(line.sides.front());
  if (move.fade > 0 && fitted.closed())
    throw InputError("'" + move.name + "': line '" + move.line +
                     "' is closed and has no ends to fade to");
  const bool smooth = layout.seam(move.line) != nullptr;
  if (!move.direction && line.sides.size() > 1 && !smooth)
    throw InputError("'" + move.name + "': " + std::to_string(line.sides.size()) +
                     " regions meet at the crease '" + move.line +
                     "', which has no normal to move along: expected a direction");
  NormalsAlong normals(layout, line, surface);
  const double start = fitted.start(), span = fitted.end() - start;
  // The profile, and its derivative.
  const auto profile = [&](double t) -> Vec2 {
    const double s = (t - start) / span, edge = std::min(s, 1 - s);
    if (!(move.fade > 0) || edge >= move.fade) return {1, 0};
    const double r = std::clamp(edge / move.fade, 0.0, 1.0);
    return {r * r * r * (10 - 15 * r + 6 * r * r),
            (s < 0.5 ? 1 : -1) * 30 * r * r * (1 - r) * (1 - r) / (move.fade * span)};
  };
  const auto direction = [&](double t) -> Vec3 {
    if (move.direction) return *move.direction;
    return normals.at(t);
  };
  // Nodes of its own, where the line is long between its nodes.
  std::vector<double> more;
  constexpr int at_least = 32;
  // On element edges it is one cubic between vertices.
  const LineSide& first = line.sides.front();
  const bool on_edges = !first.embedded;
  if (on_edges)
    more = layout.region(first.region).runs()[static_cast<size_t>(first.index)].parameters;
  for (int k = 1; k < at_least && !on_edges; ++k) more.push_back(start + span * k / at_least);
  if (move.fade > 0 && !on_edges)
    for (const double f : {move.fade, 0.5 * move.fade, 1 - move.fade, 1 - 0.5 * move.fade})
      more.push_back(start + span * f);
  const HermiteCurve nodes = fitted.with_nodes(more);
  const CurveMesh& mesh = nodes.mesh();
  const double step = 1e-4 * span / nodes.segment_count();
  Points dofs = Points::Zero(mesh.dof_count(), 3);
  // Of the direction: differences stay on one side where the line ends or turns a corner.
  const auto turning = [&](double t, int side) -> Vec3 {
    if (move.direction) return Vec3::Zero();
    if (side == 0) {
      const double before = mesh.closed() && t == start ? mesh.end() : t;
      return (direction(t + step) - direction(before - step)) / (2 * step);
    }
    const double h = side * step;
    return (-3 * direction(t) + 4 * direction(t + h) - direction(t + 2 * h)) / (2 * h);
  };
  const auto slope = [&](double t, int side) -> Vec3 {
    const Vec2 p = profile(t);
    return p[1] * direction(t) + p[0] * turning(t, side);
  };
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double t = mesh.parameters()[static_cast<size_t>(n)];
    const bool begins = n == 0 && !mesh.closed(),
               ends = n + 1 == mesh.node_count() && !mesh.closed();
    dofs.row(mesh.position_dof(n)) = profile(t)[0] * direction(t);
    if (mesh.is_corner(n)) {
      dofs.row(mesh.slope_in(n)) = slope(n == 0 ? mesh.end() : t, -1);
      dofs.row(mesh.slope_out(n)) = slope(t, 1);
    } else {
      dofs.row(mesh.slope_out(n)) = slope(t, begins ? 1 : ends ? -1 : 0);
    }
  }
  return {move, HermiteCurve(mesh, dofs)};
}

const std::string& LooseRows::name_of(int row) const {
  for (const Block& block : blocks)
    if (row < block.end_row) return block.name;
  return blocks.back().name;
}

namespace {

// -- lines ----------------------------------------------------------------------------------------

MatX right_of(const ConstraintSet& set) {
  MatX right(static_cast<long>(set.rows().size()), 3);
  for (long r = 0; r < right.rows(); ++r) right.row(r) = set.rows()[static_cast<size_t>(r)].value;
  return right;
}

// Right-hand sides of all rows when one line has another curve and all others are zero.
MatX right_of_line(const Model& model, const std::string& name, const HermiteCurve& curve) {
  const ModelLayout& layout = model.layout();
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
      EmbeddedRows(mesh, model.parts->kind, model.parts->locator(side.region), set)
          .points(name, embedded.image, along, embedded.points);
    } else {
      const LineRun& run = region.runs()[i];
      ShapeConstraints(mesh, model.parts->kind, set)
          .curve(name, run.vertices, run.parameters, along, mesh.displacement(run.vertices));
    }
    for (const auto& row : set.rows()) own.push_back(row.value);
  }
  MatX right = MatX::Zero(model.base_right.rows(), 3);
  const auto& rows = model.line_rows->rows();
  const int index = position_of(model.line_rows->names(), name);
  size_t next = 0;
  for (size_t r = 0; r < rows.size(); ++r)
    if (rows[r].name == index) {
      if (next == own.size()) break;
      right.row(static_cast<long>(r)) = own[next++];
    }
  if (next != own.size())
    throw InputError("the rows of line '" + name + "' do not fit the layout's");
  return right;
}

// -- loads ----------------------------------------------------------------------------------------

BuiltLoad built(const PlacedLoad& placed, const Model& model) {
  BuiltLoad b;
  const MeshParts& parts = *model.parts;
  const ModelScale scale = model.def.scale();
  const auto weights = [&](const Area& area) {
    return everywhere(area)
               ? VecX()
               : triangle_weights(area, model.layout(), surface_on(model.def, *placed.on));
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
    b.F = parts.assembler.area_load(surface_on(model.def, *placed.on)) * f.transpose();
  } else if (const auto* f = std::get_if<Load::Point>(&placed.load.kind)) {
    b.F = parts.assembler.point_load(parts.at(placed.feet[0]), scale.force() * f->direction);
  } else if (const auto* l = std::get_if<Load::Line>(&placed.load.kind)) {
    const LineSide& side = model.layout().model_line(l->line).sides.front();
    b.F = model.layout().spread(side.region,
                                line_load(*model.layout().region(side.region).mesh(), parts.kind,
                                          parts.locator(side.region), model.layout().image(side),
                                          model.layout().curve(side))) *
          l->direction.transpose();
  }
  if (b.F.rows() > 0) b.reduced = model.reduction->D().transpose() * b.F;
  return b;
}

BuiltWeight built(const PlacedWeight& placed, const Model& model) {
  BuiltWeight b;
  const WeightField& w = placed.weight;
  const int triangles = model.parts->mesh->triangle_count();
  b.weights = everywhere(w.area)
                  ? VecX(VecX::Ones(triangles))
                  : triangle_weights(w.area, model.layout(), surface_on(model.def, *placed.on));
  if (!w.along) return b;
  if (const auto* uv = std::get_if<Vec2>(&*w.along))
    b.directions.assign(static_cast<size_t>(triangles), uv->normalized());
  else
    b.directions = triangle_directions(std::get<std::string>(*w.along), model.layout());
  return b;
}

// -- loose rows -----------------------------------------------------------------------------------

class RowCollector {
 public:
  explicit RowCollector(int dofs) : dofs_(dofs) {}
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
  void add(int point, const Vec3& direction, double size, bool soft, LooseRows::Source source) {
    rows.rows.push_back({point, direction, size, soft});
    rows.sources.push_back(source);
  }
  // A coupled row: of one direction, a number for each dof; else a point for each coordinate.
  void add(const ConstraintSet::CoupledRow& row) {
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
    Coupling::Row made{-1, direction, std::sqrt(size)};
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
          made.more.push_back({point(terms), Vec3::Unit(c)});
        }
      }
    }
    // The same row twice (edges of a line share their ends).
    for (int r = rows.blocks.back().first_row; r < here(); ++r) {
      const Coupling::Row& other = rows.rows[static_cast<size_t>(r)];
      if (one && other.more.empty() && other.point == made.point &&
          (other.direction - made.direction).norm() < 1e-12)
        return;
    }
    rows.rows.push_back(std::move(made));
    rows.sources.push_back({});
  }
  LooseRows take() {
    rows.A.resize(dofs_, count_);
    rows.A.setFromTriplets(entries_.begin(), entries_.end());
    return std::move(rows);
  }
  LooseRows rows;

 private:
  int here() const { return static_cast<int>(rows.rows.size()); }
  int dofs_, count_ = 0;
  std::vector<Triplet> entries_;
  std::map<Terms, int> points_here_;
};

std::vector<std::pair<int, double>> functional(const MeshParts& parts, const ModelPoint& at) {
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

void add_line_normal(const PlacedConstraint& placed, const Model& model, ConstraintSet& set) {
  const MeshParts& parts = *model.parts;
  const ModelLayout& layout = model.layout();
  const auto& along = std::get<Constraint::LineNormal>(placed.constraint.kind);
  const std::string& name = placed.constraint.name;
  std::optional<Surface> on;
  if (placed.on) on.emplace(surface_on(model.def, *placed.on));
  std::vector<LineSide> sides = layout.model_line(along.line).sides;
  if (layout.seam(along.line)) sides.resize(1);
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
      EmbeddedRows(mesh, parts.kind, parts.locator(side.region), own)
          .normal(name, line.image, line.points,
                  [&](double t) { return normal_at(flat(line.image.evaluate(t))); });
    } else {
      const auto n = [&](int edge, double s) {
        const auto& e = mesh.edges()[static_cast<size_t>(edge)];
        const Vec2 low = mesh.vertices()[static_cast<size_t>(e.low)];
        const Vec2 high = mesh.image_near(mesh.vertices()[static_cast<size_t>(e.high)], low);
        return normal_at(mesh.wrapped(low + s * (high - low)));
      };
      ShapeConstraints(mesh, parts.kind, own).varying_normal(name, region.runs()[i].edges, n, true);
    }
    for (const auto& row : own.coupled_rows()) {
      auto entries = row.entries;
      for (auto& e : entries) e.dof = layout.numbers(side.region)(e.dof);
      set.add_coupled(name, std::move(entries), row.value);
    }
  }
}

LooseRows loose_rows(const Model& model, const Parameters& parameters) {
  RowCollector all(model.dofs());
  const MeshParts& parts = *model.parts;
  for (const auto& placed : model.def.constraints) {
    const Constraint& c = placed->constraint;
    all.begin(placed.get(), c.name);
    if (std::holds_alternative<Constraint::Point>(c.kind)) {
      const auto terms = functional(parts, placed->foot);
      const int point = all.point(terms);
      const char* axis[] = {".x", ".y", ".z"};
      for (int k = 0; k < 3; ++k)
        all.add(point, Vec3::Unit(k), length_of(terms), false,
                {LooseRows::Source::Goal, parameters.index(c.name + axis[k]), k});
    } else {
      ConstraintSet set(model.dofs());
      ShapeConstraints shape(*parts.mesh, parts.kind, set);
      if (const auto* normal = std::get_if<Constraint::Normal>(&c.kind))
        shape.normal(c.name, parts.at(placed->foot), normal->normal);
      else if (const auto* tangent = std::get_if<Constraint::Tangent>(&c.kind))
        shape.tangent(c.name, parts.at(placed->foot), tangent->along, tangent->tau);
      else
        add_line_normal(*placed, model, set);
      for (const auto& row : set.coupled_rows()) all.add(row);
    }
    all.end();
  }
  for (size_t l = 0; l < model.def.loads.size(); ++l) {
    const PlacedLoad& placed = *model.def.loads[l];
    const auto* springs = std::get_if<Load::Pulls>(&placed.load.kind);
    if (!springs) continue;
    all.begin(&placed, placed.load.name);
    const auto* plane = std::get_if<Load::Pulls::Plane>(&springs->target);
    for (size_t i = 0; i < placed.feet.size(); ++i) {
      const auto terms = functional(parts, placed.feet[i]);
      const int point = all.point(terms);
      LooseRows::Source source{LooseRows::Source::Spring, model.load_parameter[l], -1,
                               static_cast<int>(l), static_cast<int>(i)};
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

bool nonlinear(const Load::Pulls& springs) {
  return std::holds_alternative<Load::Pulls::Curve>(springs.target) || springs.rest_length != 0 ||
         springs.falloff != 0;
}

unsigned role_of(const Load& load) {
  if (std::holds_alternative<Load::Pressure>(load.kind)) return kPressure;
  if (const auto* springs = std::get_if<Load::Pulls>(&load.kind))
    return nonlinear(*springs) ? kSpring | kPressure : kSpring;
  return std::holds_alternative<Load::Springs>(load.kind) ? kMatrix : kLinear;
}

}  // namespace

std::shared_ptr<Model> build(Definition def, const Parameters& parameters, const Model* older) {
  auto model = std::make_shared<Model>();
  model->def = std::move(def);
  const ModelLayout& layout = *model->def.layout;
  const bool same_mesh = older && older->layout().mesh() == layout.mesh();
  const bool same_lines = same_mesh && older->def.layout == model->def.layout;
  model->parts = same_mesh ? older->parts : std::make_shared<const MeshParts>(layout);

  // Rows of lines: the same coefficients when only curves changed.
  if (same_lines) {
    model->line_rows = older->line_rows;
    model->reduction = older->reduction;
    model->base_right = older->base_right;
  } else {
    const ConstraintSet set =
        model->def.hold_corners ? layout.corner_constraints() : layout.line_constraints();
    model->line_rows =
        std::make_shared<const ConstraintSet>(set.moved(model->parts->ones, model->origin()));
    model->base_right = right_of(*model->line_rows);
    const auto same_coefficients = [](const ConstraintSet& a, const ConstraintSet& b) {
      return a.names() == b.names() &&
             std::equal(a.rows().begin(), a.rows().end(), b.rows().begin(), b.rows().end(),
                        [](const auto& x, const auto& y) {
                          return x.name == y.name &&
                                 std::equal(x.entries.begin(), x.entries.end(), y.entries.begin(),
                                            y.entries.end(), [](const auto& p, const auto& q) {
                                              return p.dof == q.dof &&
                                                     p.coefficient == q.coefficient;
                                            });
                        });
    };
    if (same_mesh && same_coefficients(*older->line_rows, *model->line_rows))
      model->reduction = older->reduction;
    else
      model->reduction = std::make_shared<const AffineReduction>(*model->line_rows,
                                                                 AffineReduction::Values::Later);
  }
  const bool same_reduction = older && model->reduction == older->reduction;

  // Parameters.
  const auto& d = model->def;
  for (const auto& load : d.loads)
    model->load_parameter.push_back(parameters.index(load->load.name));
  for (const auto& w : d.weights)
    model->weight_parameter.push_back(parameters.index(w->weight.name));
  for (const auto& m : d.moves) model->move_parameter.push_back(parameters.index(m->move.name));
  const auto three = [&](const std::string& name, const std::array<const char*, 3>& ends) {
    if (parameters.has(name)) {
      const int i = parameters.index(name);
      return std::array<int, 3>{i, i, i};
    }
    std::array<int, 3> all{};
    for (size_t k = 0; k < 3; ++k) all[k] = parameters.index(name + ends[k]);
    return all;
  };
  model->alpha = three("alpha", {"_uu", "_uv", "_vv"});
  model->beta = three("beta", {"_uu", "_uv", "_vv"});
  model->roles.assign(static_cast<size_t>(parameters.count()), kNothing);
  const auto give = [&](int parameter, unsigned role) {
    model->roles[static_cast<size_t>(parameter)] |= role;
  };
  for (const int p : model->alpha) give(p, kMatrix);
  for (const int p : model->beta) give(p, kMatrix);
  for (size_t i = 0; i < d.loads.size(); ++i)
    give(model->load_parameter[i], role_of(d.loads[i]->load));
  for (const int p : model->weight_parameter) give(p, kMatrix);
  for (const int p : model->move_parameter) give(p, kRight);

  // What acts, as far as it is not there already.
  const auto reused = [&](const auto& mine, const auto& theirs, const auto& made, size_t i,
                          bool fits) -> std::decay_t<decltype(made[0])> {
    if (fits)
      for (size_t j = 0; j < theirs.size(); ++j)
        if (theirs[j] == mine[i]) return made[j];
    return nullptr;
  };
  // A line load follows its line's curve.
  const auto keeps = [&](const PlacedLoad& load) {
    return same_reduction && (same_lines || !std::holds_alternative<Load::Line>(load.load.kind));
  };
  for (size_t i = 0; i < d.loads.size(); ++i) {
    auto known =
        older ? reused(d.loads, older->def.loads, older->loads, i, keeps(*d.loads[i])) : nullptr;
    model->loads.push_back(known ? known
                                 : std::make_shared<const BuiltLoad>(built(*d.loads[i], *model)));
  }
  for (size_t i = 0; i < d.weights.size(); ++i) {
    auto known =
        older ? reused(d.weights, older->def.weights, older->weights, i, same_mesh) : nullptr;
    model->weights.push_back(
        known ? known : std::make_shared<const BuiltWeight>(built(*d.weights[i], *model)));
  }
  for (size_t i = 0; i < d.moves.size(); ++i) {
    auto known =
        older ? reused(d.moves, older->def.moves, older->move_right, i, same_lines) : nullptr;
    model->move_right.push_back(
        known ? known
              : std::make_shared<const MatX>(
                    right_of_line(*model, d.moves[i]->move.line, d.moves[i]->displacement)));
  }
  model->loose = std::make_shared<const LooseRows>(loose_rows(*model, parameters));
  for (const auto& source : model->loose->sources)
    if (source.kind == LooseRows::Source::Goal) give(source.parameter, kGoal);

  model->measured_feet.resize(d.loads.size());
  model->measured_used.resize(d.loads.size());
  if (same_reduction) {
    model->statics = older->statics;
    model->moving = older->moving;
    model->motion = older->motion;
    for (size_t i = 0; i < d.loads.size(); ++i)
      for (size_t j = 0; j < older->def.loads.size(); ++j)
        if (older->def.loads[j] == d.loads[i]) {
          model->measured_feet[i] = older->measured_feet[j];
          model->measured_used[i] = older->measured_used[j];
        }
    // The matrix stays when what it is made of does.
    const bool same_matrix = older->def.weights == d.weights && older->measured_load.rows() == 0 &&
                             std::none_of(d.loads.begin(), d.loads.end(), [](const auto& l) {
                               return std::holds_alternative<Load::Springs>(l->load.kind);
                             });
    if (same_matrix) {
      // Values by name: numbers of parameters may have changed.
      model->matrix_values.assign(static_cast<size_t>(parameters.count()), 0);
      const auto take = [&](int mine, int theirs) {
        model->matrix_values[static_cast<size_t>(mine)] =
            older->matrix_values[static_cast<size_t>(theirs)];
      };
      if (!older->matrix_values.empty()) {
        for (size_t k = 0; k < 3; ++k) {
          take(model->alpha[k], older->alpha[k]);
          take(model->beta[k], older->beta[k]);
        }
        for (size_t i = 0; i < d.weights.size(); ++i)
          take(model->weight_parameter[i], older->weight_parameter[i]);
      } else {
        model->matrix_values.clear();
      }
    }
    model->coupling = older->coupling;  // for its solves; the session makes it anew
    model->moving_coupling = older->moving_coupling;
    model->coupled_rows = older->coupled_rows;
    model->moving_rows = older->moving_rows;
  }
  return model;
}

size_t bytes_of(const Model& model, std::set<const void*>& seen) {
  size_t sum = 0;
  const auto once = [&](const void* what, size_t bytes) {
    if (what && seen.insert(what).second) sum += bytes;
  };
  const auto n = static_cast<size_t>(model.dofs());
  once(model.parts.get(), model.parts->bytes());
  once(model.reduction.get(), 12 * static_cast<size_t>(model.reduction->D().nonZeros() +
                                                       model.reduction->from_right().nonZeros()));
  for (const auto& load : model.loads)
    once(load.get(), 8 * static_cast<size_t>(load->F.size() + load->reduced.size()) +
                         8 * static_cast<size_t>(load->weights.size()));
  for (const auto& w : model.weights)
    once(w.get(), 8 * static_cast<size_t>(w->weights.size()) + 16 * w->directions.size());
  for (const auto& m : model.move_right) once(m.get(), 8 * static_cast<size_t>(m->size()));
  once(model.loose.get(), 16 * static_cast<size_t>(model.loose->A.nonZeros()));
  for (const auto& placed : model.def.loads) once(placed->on.get(), 24 * n);
  for (const auto& placed : model.def.weights) once(placed->on.get(), 24 * n);
  for (const auto& placed : model.def.constraints) once(placed->on.get(), 24 * n);
  for (const auto* system : {model.statics.get(), model.moving.get()})
    if (system) once(system, system->bytes());
  for (const auto* coupling : {model.coupling.get(), model.moving_coupling.get()})
    if (coupling) once(coupling, coupling->bytes());
  return sum + 8 * static_cast<size_t>(model.base_right.size() + model.measured_load.size());
}

}  // namespace batten::live
