// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/deform_scene.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

GuideSpec read_guide(const TomlTable& t) {
  GuideSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  rule.of = read_string(t, "of");
  if (t.has("plane") + t.has("axis") != 1)
    t.fail("", "a constraint without a plane or an axis", "one of plane = {…}, axis = {…}");
  for (const TomlTable& p : t.table("plane", {"normal", "origin"})) {
    rule.direction = p.direction("normal");
    if (p.has("origin")) rule.through = p.vector("origin");
  }
  for (const TomlTable& l : t.table("axis", {"direction", "origin"})) {
    rule.kind = PointConstraint::Kind::OnLine;
    rule.direction = l.direction("direction");
    if (l.has("origin")) rule.through = l.vector("origin");
  }
  return rule;
}

LineSpec read_line(const TomlTable& t) {
  LineSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  if (t.has("through")) rule.through = t.points("through");
  rule.nodes = read_labels(t, "nodes");
  if (rule.through.empty() == rule.nodes.empty())
    t.fail("", "neither points nor nodes", "one of through = [[x, y, z], …], nodes = […]");
  rule.closed = t.boolean("closed", false);
  rule.rigid = t.choice("keep", false, {{"shape", false}, {"rigid", true}});
  rule.width = t.positive("width", 0);
  return rule;
}

std::vector<CurveLoad> read_curve_loads(const TomlTable& t) {
  std::vector<CurveLoad> loads;
  UniqueNames names("load");
  for (const TomlTable& s : t.tables("spring", {"name", "at", "to", "stiffness"})) {
    loads.push_back({s.text("name"), s.positive("stiffness"),
                     CurveLoad::Spring{s.vector("at"), s.vector("to")}});
    names.add(s, "name", loads.back().name);
  }
  for (const TomlTable& s : t.tables("force", {"name", "at", "direction", "value"})) {
    loads.push_back({s.text("name"), s.number("value"),
                     CurveLoad::Force{s.vector("at"), s.direction("direction")}});
    names.add(s, "name", loads.back().name);
  }
  for (const TomlTable& s : t.tables("uniform", {"name", "direction", "value"})) {
    loads.push_back(
        {s.text("name"), s.number("value"), CurveLoad::Uniform{s.direction("direction")}});
    names.add(s, "name", loads.back().name);
  }
  return loads;
}

CurveSpec read_curve(const TomlTable& t, const std::filesystem::path& folder) {
  CurveSpec rule;
  rule.line = read_line(t);
  for (const char* key : {"curve", "unit"})
    if (t.has(key) && !t.has("file"))
      t.fail(key, std::string("a ") + key + " without a file", "file = …, in which the curve is");
  if (t.has("file")) rule.file = folder / t.text("file");
  if (t.has("unit")) rule.unit = read_unit(t, "unit");
  if (t.has("curve")) rule.curve = read_string(t, "curve");
  rule.faired = t.boolean("faired", rule.file.empty());
  if (t.has("deviation") + t.has("wavelength") + !rule.faired > 1)
    t.fail("", "more than one fairing option", "one of deviation, wavelength, faired = false");
  using Smoothing = FairOptions::Smoothing;
  if (t.has("deviation")) {
    rule.fair.smoothing = Smoothing::Deviation;
    rule.fair.deviation = t.positive("deviation");
  } else if (t.has("wavelength")) {
    rule.fair.smoothing = Smoothing::Wavelength;
    rule.fair.wavelength = t.positive("wavelength");
  }
  rule.fair.corner_angle = t.positive("corner_angle", rule.fair.corner_angle);
  rule.ends = t.choice("ends", CurveSpec::Ends::Clamped,
                       {{"clamped", CurveSpec::Ends::Clamped},
                        {"pinned", CurveSpec::Ends::Pinned},
                        {"free", CurveSpec::Ends::Free}});
  rule.alpha = t.number("alpha", 0);
  if (!(rule.alpha >= 0)) t.fail("alpha", format_number(rule.alpha), "0 or more");
  rule.beta = t.positive("beta", 1);
  rule.loads = read_curve_loads(t);
  return rule;
}

PositionConstraintSpec read_position_constraint(const TomlTable& t) {
  PositionConstraintSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  if (t.has("node")) rule.node = read_label(t, "node", t.number("node"));
  if (t.has("at")) rule.at = t.vector("at");
  if (t.has("node") == t.has("at"))
    t.fail("", "a position constraint without one vertex", "one of node, at");
  rule.to = t.vector("to");
  if (t.has("weight")) rule.weight = t.positive("weight");
  return rule;
}

MorphTargetSpec read_morph_target(const TomlTable& t, const std::filesystem::path& folder) {
  MorphTargetSpec rule;
  rule.location = t.location("file");
  rule.file = folder / t.text("file");
  if (t.has("unit")) rule.unit = read_unit(t, "unit");
  rule.of = t.names("of");
  rule.smoothing = t.positive("smoothing", 0);
  rule.reach = t.positive("reach", 0);
  rule.offset = t.number("offset", 0);
  return rule;
}

EditSpec read_edit(const TomlTable& t, size_t index) {
  EditSpec rule;
  rule.name = t.text("name", "edit-" + std::to_string(index + 1));
  rule.location = t.location();
  rule.fixed = t.names("fixed");
  rule.region = t.names("region_of_interest");
  UniqueNames handles("handle");
  for (const TomlTable& h :
       t.tables("handle", {"name", "vertices", "translate", "rotate", "scale", "about"})) {
    EditSpec::MovedHandle handle;
    handle.name = h.text("name");
    handles.add(h, "name", handle.name);
    handle.location = h.location();
    handle.vertices = h.names("vertices");
    if (handle.vertices.empty()) handle.vertices = {{handle.name, h.location("name")}};
    if (h.has("translate")) handle.translate = h.vector("translate");
    for (const TomlTable& r : h.table("rotate", {"axis", "angle"})) {
      handle.axis = r.direction("axis");
      handle.degrees = r.number("angle");
    }
    handle.scale = h.positive("scale", 1);
    if (h.has("about")) handle.about = h.vector("about");
    rule.handles.push_back(handle);
  }
  for (const TomlTable& s : t.tables("scale", {"feature", "factor"}))
    rule.scales.push_back({read_string(s, "feature"), s.positive("factor")});
  for (const TomlTable& s : t.tables("rotate_feature", {"feature", "axis", "angle"}))
    rule.rotated_features.push_back(
        {read_string(s, "feature"), s.direction("axis"), s.number("angle")});
  rule.rotation_mode = t.choice("rotation_mode", EditSpec::RotationMode::Estimated,
                                {{"estimated", EditSpec::RotationMode::Estimated},
                                 {"dual", EditSpec::RotationMode::Dual},
                                 {"nonlinear", EditSpec::RotationMode::Nonlinear},
                                 {"harmonic", EditSpec::RotationMode::Harmonic}});
  for (const TomlTable& g : t.tables("constraint", {"name", "origin"}))
    rule.guides.push_back({read_string(g, "name"), g.vector("origin")});
  rule.keep_centres = t.choice("centres", true, {{"kept", true}, {"free", false}});
  return rule;
}

DimensionSpec read_dimension(const TomlTable& t) {
  using Kind = DimensionSpec::Kind;
  DimensionSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  rule.kind = t.choice<Kind>("type", {{"distance", Kind::Distance},
                                      {"radius", Kind::Radius},
                                      {"angle", Kind::Angle},
                                      {"area", Kind::Area},
                                      {"volume", Kind::Volume},
                                      {"mass", Kind::Mass}});
  rule.of = t.names("of");
  const bool two = rule.kind == Kind::Distance || rule.kind == Kind::Angle,
             whole = !two && rule.kind != Kind::Radius;
  if (rule.of.size() != (two ? 2 : 1) && !(whole && rule.of.empty()))
    t.fail("of", std::to_string(rule.of.size()) + " names",
           std::string(two ? "two names" : "one name") + " of features, selections or proposals");
  if (t.has("direction") && rule.kind != Kind::Distance)
    t.fail("direction", "a direction", "one only with type = \"distance\"");
  if (t.has("direction")) rule.direction = t.direction("direction");
  for (const char* key : {"thickness", "density"})
    if (t.has(key) && rule.kind != Kind::Mass)
      t.fail(key, std::string("a ") + key, "one only with type = \"mass\"");
  if (rule.kind == Kind::Mass) {
    rule.thickness = t.positive("thickness");
    rule.density = t.positive("density");
  }
  return rule;
}

RequirementSpec read_requirement(const TomlTable& t) {
  using Relation = RequirementSpec::Relation;
  RequirementSpec rule;
  rule.location = t.location();
  rule.dimension = read_string(t, "dimension");
  if (t.has("equal") + t.has("at_most") + t.has("at_least") != 1)
    t.fail("", "a requirement without one value", "one of equal, at_most, at_least");
  for (const auto& [key, relation] : {std::pair{"equal", Relation::Equal},
                                      {"at_most", Relation::AtMost},
                                      {"at_least", Relation::AtLeast}})
    if (t.has(key)) {
      rule.relation = relation;
      rule.value = t.number(key);
    }
  if (t.has("adjust")) rule.adjust = read_string(t, "adjust");
  return rule;
}

ModesSpec read_modes(const TomlTable& t, UniqueNames& files) {
  ModesSpec rule;
  rule.thickness = t.positive("thickness");
  rule.young = t.positive("young");
  rule.poisson = t.number("poisson");
  if (!(rule.poisson > -1 && rule.poisson < 0.5))
    t.fail("poisson", format_number(rule.poisson), "above -1 and below 0.5");
  rule.density = t.positive("density");
  rule.count = t.integer("count", 1, 10);
  rule.clamped = t.names("clamped");
  if (t.has("before")) rule.before = output_file(t, "before", files, {".inp"});
  if (t.has("after")) rule.after = output_file(t, "after", files, {".inp"});
  return rule;
}

MeshPictureSpec mesh_picture(const TomlTable& t, UniqueNames& files) {
  using Show = MeshPictureSpec::Show;
  MeshPictureSpec rule;
  rule.file = output_file(t, "file", files, {".png"});
  rule.title = t.text("title", "");
  rule.show = t.choice("show", Show::BeforeAfter,
                       {{"before_after", Show::BeforeAfter},
                        {"steps", Show::Steps},
                        {"after", Show::After},
                        {"displacement", Show::Displacement}});
  rule.mesh = t.boolean("mesh", false);
  read_view(t, rule.azimuth, rule.elevation, rule.size);
  rule.up = t.choice("up", 2, {{"x", 0}, {"y", 1}, {"z", 2}});
  rule.zoom = t.positive("zoom", 1);
  return rule;
}

/// Reads how non-shell elements follow the shells.
void read_attached(const TomlTable& root, AttachmentOptions& options) {
  const std::vector<std::string> kinds = {
      "solids",       "beams",  "bushes", "rigid",
      "distributing", "masses", "others"};  // in the order of NonShellElement::Kind
  for (const TomlTable& t : root.table("attached", kinds))
    for (size_t k = 0; k < kinds.size(); ++k) {
      const bool says_itself = kinds[k] == "rigid" || kinds[k] == "distributing";
      AttachmentRule& slot = options.rule_of_kind[k];
      if (!t.has(kinds[k])) continue;
      slot = says_itself ? t.choice<AttachmentRule>(kinds[k], {{"follow", AttachmentRule::Rigid},
                                                               {"stay", AttachmentRule::Stay}})
                         : t.choice<AttachmentRule>(kinds[k], {{"smooth", AttachmentRule::Smooth},
                                                               {"rigid", AttachmentRule::Rigid},
                                                               {"stay", AttachmentRule::Stay}});
    }
}

RelationSpec read_relation(const TomlTable& t) {
  using Kind = RelationSpec::Kind;
  RelationSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  rule.kind = t.choice<Kind>("type", {{"parallel", Kind::Parallel},
                                      {"coaxial", Kind::Coaxial},
                                      {"distance", Kind::Distance},
                                      {"spacing", Kind::Spacing},
                                      {"symmetric", Kind::Symmetric}});
  rule.of = t.names("of");
  if (rule.of.empty()) t.fail("of", "no names", "a list of features");
  if (t.has("plane") != (rule.kind == Kind::Symmetric))
    t.fail("plane", t.has("plane") ? "a plane" : "no plane",
           "plane = { normal, origin } with type = \"symmetric\", and only with it");
  for (const TomlTable& p : t.table("plane", {"normal", "origin"}))
    rule.plane = {p.direction("normal"), p.vector("origin")};
  return rule;
}

/// Reads guides, relations, lines, curves and position constraints.
void read_guides_and_lines(const TomlTable& root, UniqueNames& taken, DeformScene& scene) {
  taken.read(root, "constraint", {"name", "of", "plane", "axis"}, scene.guides, read_guide);
  taken.read(root, "relation", {"name", "type", "of", "plane"}, scene.relations, read_relation);
  taken.read(root, "chain", {"name", "through", "nodes", "closed", "keep", "width"}, scene.lines,
             read_line);
  for (const TomlTable& t :
       root.tables("curve", {"name", "through", "nodes", "closed", "file", "unit", "curve",
                             "faired", "deviation", "wavelength", "corner_angle", "ends", "alpha",
                             "beta", "spring", "force", "uniform"})) {
    scene.curves.push_back(read_curve(t, scene.file.parent_path()));
    taken.add(t, "name", scene.curves.back().line.name);
  }
  taken.read(root, "position_constraint", {"name", "node", "at", "to", "weight"},
             scene.position_constraints, read_position_constraint);
}

/// Reads the edits.
void read_edits(const TomlTable& root, bool required, DeformScene& scene) {
  UniqueNames edits("edit");
  edits.read(root, "edit",
             {"name", "fixed", "region_of_interest", "handle", "scale", "constraint", "centres",
              "rotation_mode", "rotate_feature"},
             scene.edits, [&](const TomlTable& t) { return read_edit(t, scene.edits.size()); });
  if (!scene.edits.empty()) return;
  if (scene.targets.empty() && scene.position_constraints.empty()) {
    if (required)
      root.fail("", "no edits", "at least one [[edit]], [[target]] or [[position_constraint]]");
    return;
  }
  scene.edits.emplace_back();  // the constraints alone
  scene.edits.back().name = "edit-1";
}

/// Reads dimensions, and the conditions on them.
void read_dimensions(const TomlTable& root, DeformScene& scene) {
  UniqueNames dimensions("dimension");
  dimensions.read(root, "dimension", {"name", "type", "of", "direction", "thickness", "density"},
                  scene.dimensions, read_dimension);
  std::vector<std::string> names, parameters, adjusted;
  for (const DimensionSpec& dimension : scene.dimensions) names.push_back(dimension.name);
  for (const Parameter& p : scene.parameters()) parameters.push_back(p.name);
  const auto known = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const TomlTable& t :
       root.tables("require", {"dimension", "equal", "at_most", "at_least", "adjust"})) {
    RequirementSpec rule = read_requirement(t);
    if (!known(names, rule.dimension.text))
      t.fail("dimension", "'" + rule.dimension.text + "'",
             names.empty() ? "a [[dimension]] of this name"
                           : expected_one_of(rule.dimension.text, names));
    if (const std::string& adjust = rule.adjust.text; !adjust.empty()) {
      if (!known(parameters, adjust))
        t.fail("adjust", "'" + adjust + "'", expected_one_of(adjust, parameters));
      if (known(adjusted, adjust))
        t.fail("adjust", "'" + adjust + "' again", "a parameter of its own for each requirement");
      adjusted.push_back(adjust);
    }
    scene.requirements.push_back(std::move(rule));
  }
}

/// Reads the output files: meshes, decks for natural frequencies, pictures.
void read_outputs(const TomlTable& root, DeformScene& scene) {
  UniqueNames files("file name");
  const std::string ending = scene.mesh.extension().string();
  scene.mesh_out = scene.mesh.stem().string() + "-deformed" + ending;
  for (const TomlTable& t : root.table("output", {"mesh", "vtp", "large_field"})) {
    if (t.has("mesh")) scene.mesh_out = output_file(t, "mesh", files, {ending});
    if (t.has("vtp")) scene.vtp = output_file(t, "vtp", files, {".vtp"});
    scene.large_field_nodes = t.boolean("large_field", false);
  }
  if (!files.has(scene.mesh_out)) files.add(root, "mesh", scene.mesh_out);
  for (const TomlTable& t : root.table("modes", {"thickness", "young", "poisson", "density",
                                                 "count", "clamped", "before", "after"}))
    scene.modes = read_modes(t, files);
  for (const TomlTable& t :
       root.tables("picture", {"file", "title", "show", "mesh", "view", "up", "zoom", "size"}))
    scene.pictures.push_back(mesh_picture(t, files));
}

/// Reads the whole scene from its root table.
DeformScene deform_scene(const toml::table& root_table, const std::filesystem::path& file,
                         bool edits_required) {
  refuse_renamed_keys(root_table, SceneKind::Deform, file.string());
  const TomlTable root(file.string(), root_table, "the scene",
                       {"name",       "unit",     "mesh",      "weighting", "proposals",
                        "attached",   "select",   "cut",       "feature",   "features",
                        "constraint", "relation", "chain",     "curve",     "position_constraint",
                        "target",     "edit",     "dimension", "require",   "output",
                        "modes",      "picture"});
  const std::filesystem::path folder = file.parent_path();
  DeformScene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = read_unit(root, "unit");
  scene.mesh = folder / root.text("mesh");
  scene.weighting = root.choice(
      "weighting", DeformProblem::Weighting::Area,
      {{"area", DeformProblem::Weighting::Area}, {"uniform", DeformProblem::Weighting::Uniform}});
  read_proposals(root, scene.proposals);
  read_attached(root, scene.following);
  read_selections(root, folder, scene);
  UniqueNames taken("name");
  scene.features = read_features(root, taken);
  read_guides_and_lines(root, taken, scene);
  for (const TomlTable& t :
       root.tables("target", {"file", "unit", "of", "smoothing", "reach", "offset"}))
    scene.targets.push_back(read_morph_target(t, folder));
  read_edits(root, edits_required, scene);
  read_dimensions(root, scene);
  read_outputs(root, scene);
  return scene;
}

/// Enumerates all parameters: calls f for each one.
template <class AnyScene, class Function>
void for_each_edit_parameter(AnyScene& scene, const Function& f) {
  for (auto& curve : scene.curves)
    for (auto& load : curve.loads)
      f(curve.line.name + "." + load.name, load.value,
        std::holds_alternative<CurveLoad::Spring>(load.kind));
  const auto point = [&](const std::string& name, auto& value) {
    for (int i = 0; i < 3; ++i) f(name + "." + "xyz"[i], value[i], false);
  };
  for (auto& guide : scene.guides)
    if (guide.through) point(guide.name, *guide.through);
  for (auto& constraint : scene.position_constraints) point(constraint.name, constraint.to);
  for (auto& edit : scene.edits) {
    for (auto& guide : edit.guides) point(edit.name + "." + guide.guide.text, guide.through);
    for (auto& handle : edit.handles) {
      const std::string name = edit.name + "." + handle.name + ".";
      for (int i = 0; i < 3; ++i) f(name + "xyz"[i], handle.translate[i], false);
      f(name + "angle", handle.degrees, false);
      f(name + "scale", handle.scale, true);
    }
    for (auto& scaled : edit.scales)
      f(edit.name + "." + scaled.feature.text + ".scale", scaled.factor, true);
  }
}

/// Sets EDIT.HANDLE.rotation.x, .y or .z; false for other names.
bool set_handle_rotation(DeformScene& scene, const std::string& parameter, double value,
                         const std::string& where) {
  for (auto& edit : scene.edits)
    for (auto& handle : edit.handles)
      for (int i = 0; i < 3; ++i) {
        if (parameter != edit.name + "." + handle.name + ".rotation." + "xyz"[i]) continue;
        if (!std::isfinite(value))
          throw InputError(where + "found " + format_number(value) + " for '" + parameter +
                           "', expected a finite number");
        set_rotation_component(i, value, handle.axis, handle.degrees);
        return true;
      }
  return false;
}

}  // namespace

void set_rotation_component(int coordinate, double value, Vec3& axis, double& degrees) {
  Vec3 turn = degrees * axis;
  turn[coordinate] = value;
  degrees = turn.norm();
  if (degrees > 0) axis = turn / degrees;
}

std::vector<Parameter> DeformScene::parameters() const {
  std::vector<Parameter> list;
  for_each_edit_parameter(*this, [&](const std::string& n, double value, bool positive) {
    list.push_back({n, value, positive ? 0 : -kInfinity, kInfinity});
  });
  return list;
}

void DeformScene::set(const std::string& parameter, double value, const std::string& where) {
  std::vector<std::string> names;
  bool known = set_handle_rotation(*this, parameter, value, where);
  for_each_edit_parameter(*this, [&](const std::string& n, double& slot, bool positive) {
    names.push_back(n);
    if (n != parameter) return;
    known = true;
    if (!std::isfinite(value) || (positive && !(value > 0)))
      throw InputError(where + "found " + format_number(value) + " for '" + n + "', expected a " +
                       (positive ? "number above 0" : "finite number"));
    slot = value;
  });
  if (!known)
    throw InputError(where + "found parameter '" + parameter + "', expected " +
                     expected_one_of(parameter, names));
}

bool is_deform_scene(const std::filesystem::path& file) {
  const toml::table root =
      parse_toml(read_input_file(file, "a scene (.toml)"), file, "a scene or edits of a mesh");
  return root["mesh"].is_string() || root.contains("edit");
}

DeformScene parse_deform_scene(const std::string& text, const std::filesystem::path& file,
                               bool edits_required) {
  return deform_scene(parse_toml(text, file, "edits of a mesh (unit, mesh, [[edit]] …)"), file,
                      edits_required);
}

DeformScene read_deform_scene(const std::filesystem::path& file) {
  return parse_deform_scene(read_input_file(file, "edits of a mesh (.toml)"), file);
}

}  // namespace batten
