#include <algorithm>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_data.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

using detail::SessionDefinition;
using detail::ShapeState;

void SessionData::require_lines(const char* what) {
  if (system().def.fix_corners_only)
    throw InputError(std::string("lines cannot be ") + what + " here: only the corners are held");
}

// Carries dofs on the present layout over to the meshes of another one.
SurfaceTransfer SessionData::transferred(const ModelLayout& layout, const Points& dofs) {
  SurfaceTransfer all;
  std::vector<Points> each;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& from = this->layout().region(r);
    SurfaceTransfer own = interpolate_onto(
        Surface(from.mesh(), from.element(), this->layout().region_dofs(r, dofs), from.trim()),
        *layout.region(r).mesh());
    all.max_displacement = std::max(all.max_displacement, own.max_displacement);
    each.push_back(std::move(own.dofs));
  }
  all.dofs = layout.all_dofs(each);
  return all;
}

// Carries over the shapes that loads, weight fields and constraints refer to.
void SessionData::transfer_reference_shapes(const ModelLayout& layout,
                                                       SessionDefinition& def) {
  std::vector<std::pair<detail::SharedPoints, detail::SharedPoints>> moved;
  const auto along = [&](detail::SharedPoints& on) {
    if (!on) return;
    for (const auto& [old, made] : moved)
      if (old == on) {
        on = made;
        return;
      }
    auto made = std::make_shared<const Points>(transferred(layout, *on).dofs);
    moved.emplace_back(on, made);
    on = made;
  };
  const auto follow = [&](auto& things) {
    for (auto& thing : things) {
      auto copy = *thing;
      along(copy.on);
      thing = std::make_shared<const std::decay_t<decltype(copy)>>(std::move(copy));
    }
  };
  follow(def.loads);
  follow(def.weights);
  follow(def.constraints);
}

// Goes over to a layout with other meshes or other lines, and carries the shape over.
SurfaceTransfer SessionData::change_layout(ModelLayout layout) {
  bool other_mesh = false;
  for (int r = 0; r < layout.region_count(); ++r)
    other_mesh = other_mesh || layout.region(r).mesh() != this->layout().region(r).mesh();
  SessionDefinition def = system().def;
  SurfaceTransfer made;
  ShapeState shape = now.shape;
  if (other_mesh) {
    made = transferred(layout, absolute(now.shape.x));
    if (now.in_motion) shape.v = transferred(layout, now.shape.v).dofs;
    transfer_reference_shapes(layout, def);
  }
  if (other_mesh && !layout.join_plans().empty()) layout.plan_joins(made.dofs);
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  rebuild(std::move(def));
  if (other_mesh) {
    VecX ones = system().parts->ones;
    shape.x = made.dofs - ones * system().origin().transpose();
    if (!now.in_motion) shape.v = Points::Zero(shape.x.rows(), 3);
    now.shape = std::move(shape);
    now.converged_x = now.shape.x;
  }
  solve_constrained();
  return made;
}

void SessionData::require_unused(const std::string& line) {
  const auto refuse = [&](const std::string& user) {
    throw InputError("line '" + line + "' cannot be removed: '" + user + "' refers to it");
  };
  const auto near = [&](const Area& area) {
    const auto* at = std::get_if<Area::NearLine>(&area.where);
    return at && at->line == line;
  };
  for (const auto& p : system().def.loads) {
    if (const auto* l = std::get_if<Load::Line>(&p->load.kind); l && l->line == line)
      refuse(p->load.name);
    if (const auto* l = std::get_if<Load::Pressure>(&p->load.kind); l && near(l->area))
      refuse(p->load.name);
    if (const auto* l = std::get_if<Load::Uniform>(&p->load.kind); l && near(l->area))
      refuse(p->load.name);
  }
  for (const auto& p : system().def.weights) {
    const auto* along = p->weight.along ? std::get_if<std::string>(&*p->weight.along) : nullptr;
    if (near(p->weight.area) || (along && *along == line)) refuse(p->weight.name);
  }
  for (const auto& p : system().def.constraints)
    if (const auto* c = std::get_if<Constraint::LineNormal>(&p->constraint.kind);
        c && c->line == line)
      refuse(p->constraint.name);
  for (const auto& p : system().def.moves)
    if (p->move.line == line) refuse(p->move.name);
}

void SessionData::set_line(const std::string& name, const HermiteCurve& curve) {
  require_lines("edited");
  ModelLayout layout = this->layout();
  layout.set_line(name, curve);
  SessionDefinition def = system().def;
  def.layout = std::make_shared<const ModelLayout>(std::move(layout));
  rebuild(std::move(def));
  solve_constrained();
}

HermiteCurve SessionData::line(const std::string& name) {
  HermiteCurve curve = layout().line(name);
  const SessionDefinition& def = system().def;
  for (size_t i = 0; i < def.moves.size(); ++i)
    if (def.moves[i]->move.line == name)
      curve = detail::sum(curve, def.moves[i]->displacement,
                          now.parameters.value(system().move_parameter[i]));
  return curve;
}

}  // namespace batten
