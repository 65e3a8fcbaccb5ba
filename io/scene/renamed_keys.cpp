// SPDX-License-Identifier: MPL-2.0
// Keys of older versions of Batten, and names that other programs use for the same things.
#include <toml++/toml.h>
#include <optional>
#include <string>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

struct RenamedKey {
  SceneKind kind;
  const char* table;  // by its present name, dotted if it is nested; "": the top of the scene
  const char* old_name;
  const char* now;  // the present name, or what to write
};

constexpr SceneKind S = SceneKind::Surface, D = SceneKind::Deform, Q = SceneKind::Sequence;

constexpr RenamedKey kRenamedKeys[] = {
    {S, "", "network",
     "its keys in [skin]: gap_tolerance (was tolerance), tangent_angle, crease_angle (was "
     "smooth_below), angle_tolerance, symmetry, noisy_curves, max_faces_per_edge"},
    {S, "", "line", "curve"},
    {S, "", "lines", "curves"},
    {S, "", "region", "face"},
    {S, "", "weight", "stiffness"},
    {S, "", "move", "offset"},
    {S, "", "tolerance", "fit_tolerance"},
    {S, "curve", "turn", "rotate"},
    {S, "curve", "move", "translate"},
    {S, "curve", "treatment", "alignment"},
    {S, "curve", "hold", "trim_only = true instead of hold = false"},
    {S, "curve.scale", "point", "about"},
    {S, "curve.rotate", "point", "about"},
    {S, "curve.mirror", "point", "origin"},
    {S, "curves", "treatment", "alignment"},
    {S, "curves", "hold", "trim_only = true instead of hold = false"},
    {S, "face", "ring", "annulus"},
    {S, "join", "lines", "curves"},
    {S, "join", "kind", "continuity"},
    {S, "skin", "units", "load_units"},
    {S, "skin", "hold", "boundary"},
    {S, "skin", "strength", "fair_strength"},
    {S, "skin", "largest_move", "max_displacement"},
    {S, "skin", "straight_angle", "tangent_angle"},
    {S, "skin", "join_tolerance", "angle_tolerance"},
    {S, "skin", "most_at_line", "max_faces_per_edge"},
    {S, "skin", "trembling", "noisy_curves"},
    {S, "fair", "lines", "curves"},
    {S, "fair", "minimum", "minimize"},
    {S, "fair", "hold_ends", "fix_ends"},
    {S, "fair", "stretch", "segment"},
    {S, "target", "tolerance", "fit_tolerance"},
    {S, "constraint", "line", "curve"},
    {S, "constraint", "along", "parametric_direction"},
    {S, "load", "line", "curve"},
    {S, "load", "regions", "faces"},
    {S, "load.plane", "through", "origin"},
    {S, "stiffness", "kind", "type"},
    {S, "stiffness", "regions", "faces"},
    {S, "offset", "line", "curve"},
    {S, "stress", "along", "material_direction"},
    {S, "stress", "shear", "shear_modulus"},
    {S, "stress.supports", "line", "curve"},
    {S, "stress.supports", "kind", "type"},
    {S, "stress.supports", "region", "face"},
    {S, "stress.loads", "line", "curve"},
    {S, "stress.loads", "region", "face"},
    {S, "stress.loads", "area_force", "traction"},
    {S, "stress.thicknesses", "region", "face"},
    {S, "stress.thicknesses", "regions", "faces"},
    {S, "stress.pressures", "region", "face"},
    {S, "output", "step_lines", "step_curves"},
    {S, "picture", "lines", "curves"},
    {S, "picture", "parameter_lines", "isocurves"},
    {S, "sweep", "lines", "curves"},
    {S, "sweep", "parameter_lines", "isocurves"},
    {S, "skin", "element", "element in [mesh]"},
    {S, "skin", "domain", "domain in [mesh]"},
    {S, "skin", "mesher", "mesher in [mesh]"},
    {S, "skin", "edge_length", "edge_length in [mesh]"},
    {S, "skin", "refine", "refine in [mesh]"},
    {S, "skin", "settle", "minimize_distortion in [mesh]"},
    {D, "", "guide", "constraint"},
    {D, "", "line", "chain"},
    {D, "", "pull", "position_constraint"},
    {D, "constraint", "line", "axis"},
    {D, "constraint.plane", "through", "origin"},
    {D, "constraint.axis", "through", "origin"},
    {D, "relation", "kind", "type"},
    {D, "relation.plane", "through", "origin"},
    {D, "edit", "region", "region_of_interest"},
    {D, "edit", "turn", "rotation_mode"},
    {D, "edit", "turn_feature", "rotate_feature"},
    {D, "edit", "guide", "constraint"},
    {D, "edit.handle.rotate", "degrees", "angle"},
    {D, "edit.rotate_feature", "degrees", "angle"},
    {D, "edit.constraint", "through", "origin"},
    {D, "proposals", "crease_degrees", "crease_angle"},
    {D, "proposals", "rim_rings", "flange_rings"},
    {D, "proposals", "rim_width", "flange_width"},
    {D, "attached", "means", "distributing"},
    {D, "output", "wide_nodes", "large_field"},
    {D, "select.plane", "through", "origin"},
    {Q, "", "step", "operation"},
    {Q, "operation.source.select.plane", "through", "origin"},
    {Q, "proposals", "crease_degrees", "crease_angle"},
    {Q, "proposals", "rim_rings", "flange_rings"},
    {Q, "proposals", "rim_width", "flange_width"},
    {Q, "select.plane", "through", "origin"},
    {Q, "operation", "kind", "type"},
    {Q, "operation", "along", "direction"},
    {Q, "operation", "found", "contact_detection"},
    {Q, "operation", "upright", "unrotated"},
    {Q, "operation", "shift", "translate"},
    {Q, "operation", "spans", "segments"},
    {Q, "operation", "turns", "rotations"},
    {Q, "operation", "rounds", "iterations"},
    {Q, "operation", "rounds_between", "iterations_between"},
    {Q, "operation", "softness", "penalty"},
    {Q, "operation", "volume", "preserve_volume"},
    {Q, "operation", "every", "keyframe_interval"},
    {Q, "operation", "ends", "extrapolation"},
    {Q, "operation.keyframe.handle", "turn", "rotation"},
    {Q, "operation.keyframe.handle.rotate", "degrees", "angle"},
    {Q, "operation.contact_detection", "within", "distance"},
    {Q, "operation.contact_detection", "frames", "min_frames"},
    {Q, "operation.terrain", "turns", "rotate"},
    {Q, "operation.align.rotate", "degrees", "angle"},
};

// Names of other programs.
constexpr RenamedKey kForeignKeys[] = {
    {S, "stress", "E", "young"},
    {S, "stress", "nu", "poisson"},
    {S, "stress", "rho", "density"},
    {S, "stress", "bc", "supports"},
    {S, "mesh", "mesh_size", "edge_length"},
    {S, "mesh", "size", "edge_length"},
    {S, "skin", "tolerance", "gap_tolerance"},
    {S, "", "gap_tolerance", "gap_tolerance in [skin]"},
    {S, "", "edge_length", "edge_length in [mesh]"},
    {S, "", "mesh_size", "edge_length in [mesh]"},
    {S, "curve.arc", "center", "centre"},
    {S, "curve.circle", "center", "centre"},
    {S, "curve.ellipse", "center", "centre"},
    {S, "curve.helix", "center", "centre"},
    {S, "curve.rectangle", "center", "centre"},
};

struct RenamedValue {
  SceneKind kind;
  const char *table, *key, *old_value, *now;
};

constexpr RenamedValue kRenamedValues[] = {
    {S, "mesh", "domain", "plane", "projected"},
    {S, "mesh", "domain", "sheet", "developable"},
    {S, "mesh", "domain", "ring", "annulus"},
    {S, "face", "domain", "plane", "projected"},
    {S, "face", "domain", "sheet", "developable"},
    {S, "face", "domain", "ring", "annulus"},
    {S, "curve", "alignment", "fitted", "aligned"},
    {S, "curves", "alignment", "fitted", "aligned"},
    {S, "join", "continuity", "crease", "G0"},
    {S, "join", "continuity", "tangent", "G1"},
    {S, "join", "continuity", "curvature", "G2"},
    {S, "skin", "boundary", "lines", "curves"},
    {S, "fair", "minimize", "energy", "bending"},
    {S, "constraint", "type", "line_normal", "curve_normal"},
    {S, "load", "type", "scan", "point_cloud"},
    {S, "load", "type", "pulls", "attractors"},
    {S, "stress.supports", "type", "held", "prescribed"},
    {S, "picture", "show", "regions", "faces"},
    {S, "sweep", "show", "regions", "faces"},
    {D, "feature", "keep", "direction", "orientation"},
    {D, "features", "keep", "direction", "orientation"},
    {D, "curve", "ends", "held", "pinned"},
    {D, "edit", "rotation_mode", "found", "estimated"},
    {Q, "feature", "keep", "direction", "orientation"},
    {Q, "features", "keep", "direction", "orientation"},
    {Q, "operation", "type", "travel", "root_motion"},
    {Q, "operation", "type", "footprints", "foot_plants"},
    {Q, "operation", "trajectories", "paper", "piecewise_linear"},
    {Q, "operation", "align", "shift", "translate"},
    {Q, "operation.keyframe.handle", "rotation", "told", "prescribed"},
};

/// Searches the tables in the order of the file and stores the first renamed key or value.
class RenamedKeySearch {
 public:
  RenamedKeySearch(SceneKind kind, std::string file) : kind_(kind), file_(std::move(file)) {}

  void visit(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      visit_key(name, key.source().begin, path);
      const std::string inner =
          (path.empty() ? "" : path + ".") + present_name(path, name).value_or(name);
      if (const auto* text = node.as_string())
        visit_value(path, present_name(path, name).value_or(name), text->get(),
                    node.source().begin);
      if (const toml::table* sub = node.as_table()) visit(*sub, inner);
      if (const toml::array* list = node.as_array())
        for (const toml::node& item : *list)
          if (const toml::table* sub = item.as_table()) visit(*sub, inner);
    }
  }

  void throw_if_found() const {
    if (!message_.empty()) throw InputError(message_);
  }

 private:
  template <class Keys>
  const RenamedKey* find(const Keys& keys, const std::string& path, const std::string& name) const {
    for (const RenamedKey& key : keys)
      if (key.kind == kind_ && key.table == path && key.old_name == name) return &key;
    return nullptr;
  }
  std::optional<std::string> present_name(const std::string& path, const std::string& name) const {
    const RenamedKey* key = find(kRenamedKeys, path, name);
    return key ? std::optional<std::string>(key->now) : std::nullopt;
  }
  void visit_key(const std::string& name, const toml::source_position& at,
                 const std::string& path) {
    const RenamedKey* renamed = find(kRenamedKeys, path, name);
    const RenamedKey* key = renamed ? renamed : find(kForeignKeys, path, name);
    if (!key) return;
    const std::string where = path.empty() ? "" : " in '" + path + "'";
    store(at, "found the key '" + name + "'" + where + ", expected " + quoted(key->now) +
                  (renamed ? " (renamed)" : ""));
  }
  void visit_value(const std::string& path, const std::string& key, const std::string& value,
                   const toml::source_position& at) {
    for (const RenamedValue& v : kRenamedValues)
      if (v.kind == kind_ && v.table == path && v.key == key && v.old_value == value)
        store(at, "found " + key + " = \"" + value + "\", expected \"" + v.now + "\" (renamed)");
  }
  static std::string quoted(const std::string& now) {
    return now.find(' ') == std::string::npos ? "'" + now + "'" : now;
  }
  void store(const toml::source_position& at, const std::string& text) {
    if (!message_.empty() && std::pair(at.line, at.column) >= std::pair(first_.line, first_.column))
      return;
    first_ = at;
    message_ =
        format_location(file_, {static_cast<int>(at.line), static_cast<int>(at.column)}) + text;
  }

  SceneKind kind_;
  std::string file_, message_;
  toml::source_position first_{};
};

}  // namespace

void refuse_renamed_keys(const toml::table& root, SceneKind kind, const std::string& file) {
  RenamedKeySearch search(kind, file);
  search.visit(root, "");
  search.throw_if_found();
}

}  // namespace batten
