// SPDX-License-Identifier: MPL-2.0
// Reads [[curve]] and [[curves]] of all kinds of scenes.
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {

const std::vector<std::string>& shape_keys() {
  static const std::vector<std::string> keys = {"file",   "points",  "bezier", "arc",
                                                "circle", "ellipse", "helix",  "rectangle",
                                                "spline", "copy"};
  return keys;
}

namespace {

// Shape keys of curves: arc, circle, ellipse, helix, rectangle, spline; and copies.

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

Vec3 vector_or(const TomlTable& table, const std::string& key, const Vec3& fallback) {
  return table.has(key) ? table.vector(key) : fallback;
}

// Reads the plane of a curve: centre, normal, x. The default of x is the global x axis, or y if the
// normal is parallel to x.
CurvePlane read_plane(const TomlTable& table) {
  const Vec3 normal = vector_or(table, "normal", Vec3::UnitZ());
  const bool along_x = normal.cross(Vec3::UnitX()).norm() < 1e-6 * normal.norm();
  const Vec3 x = vector_or(table, "x", along_x ? Vec3::UnitY() : Vec3::UnitX());
  return curve_plane(table.vector("centre"), normal, x);
}

std::vector<std::string> in_plane(std::vector<std::string> keys) {
  keys.insert(keys.end(), {"centre", "normal", "x"});
  return keys;
}

std::shared_ptr<const InputCurve> round(const TomlTable& table, double a, double b,
                                        bool closed_by_default) {
  VecX angles(2);
  angles << 0, 360;
  if (!closed_by_default || table.has("angles")) angles = table.numbers("angles", "from, to");
  return ellipse_arc(read_plane(table), a, b, radians(angles[0]), radians(angles[1]));
}

std::shared_ptr<const InputCurve> bezier(const TomlTable& table) {
  const std::vector<Vec3> p = table.points("bezier");
  if (p.size() != 4) table.fail("bezier", std::to_string(p.size()) + " points", "4 control points");
  return bezier_curve(p[0], p[1], p[2], p[3]);
}

std::shared_ptr<const InputCurve> arc(const TomlTable& table) {
  if (table.is_array("arc")) {
    const std::vector<Vec3> p = table.points("arc");
    if (p.size() != 3)
      table.fail("arc", std::to_string(p.size()) + " points",
                 "3, its start, one between, its end, or {centre, radius, angles}");
    return arc_through(p[0], p[1], p[2]);
  }
  const TomlTable t = table.table("arc", in_plane({"radius", "angles"})).front();
  return round(t, t.number("radius"), t.number("radius"), false);
}

std::shared_ptr<const InputCurve> circle(const TomlTable& table) {
  const TomlTable t = table.table("circle", in_plane({"radius"})).front();
  return round(t, t.number("radius"), t.number("radius"), true);
}

std::shared_ptr<const InputCurve> ellipse(const TomlTable& table) {
  const TomlTable t = table.table("ellipse", in_plane({"radii", "angles"})).front();
  const VecX radii = t.numbers("radii", "along x, along y");
  return round(t, radii[0], radii[1], true);
}

std::shared_ptr<const InputCurve> helix_of(const TomlTable& table) {
  const TomlTable t = table.table("helix", in_plane({"radius", "pitch", "turns"})).front();
  return helix(read_plane(t), t.number("radius"), t.number("pitch"), t.number("turns"));
}

std::shared_ptr<const InputCurve> rectangle_of(const TomlTable& table) {
  const TomlTable t = table.table("rectangle", in_plane({"size", "radius"})).front();
  const VecX size = t.numbers("size", "width, height");
  return rectangle(read_plane(t), size[0], size[1], t.number("radius", 0));
}

std::shared_ptr<const InputCurve> spline(const TomlTable& table) {
  const TomlTable t = table.table("spline", {"poles", "degree", "weights", "knots"}).front();
  const auto list = [&](const char* key) {
    return t.has(key) ? t.list(key) : std::vector<double>{};
  };
  return nurbs_curve(t.integer("degree", 1, 3), t.points("poles"), list("weights"), list("knots"));
}

// Adds the location of the key to exceptions of the kernel.
template <class Make>
auto placed_at(const TomlTable& table, const std::string& key, const Make& make) {
  try {
    return make();
  } catch (const InputError& e) {
    const std::string what = e.what();
    if (what.starts_with("found ")) throw InputError(table.at(key) + what);
    throw;
  }
}

/// Reads the curve of a shape key of this table: arc, circle, ellipse, helix, rectangle, spline or
/// bezier. Throws InputError with its location.
std::shared_ptr<const InputCurve> read_shape_curve(const TomlTable& table, const std::string& key) {
  return placed_at(table, key, [&] {
    return key == "arc"         ? arc(table)
           : key == "circle"    ? circle(table)
           : key == "ellipse"   ? ellipse(table)
           : key == "helix"     ? helix_of(table)
           : key == "rectangle" ? rectangle_of(table)
           : key == "spline"    ? spline(table)
                                : bezier(table);
  });
}

/// The keys that transform a copy.
const std::vector<std::string>& placement_keys() {
  static const std::vector<std::string> keys = {"scale", "rotate", "mirror", "translate"};
  return keys;
}

/// Reads the transform of a copy: scaling first, then rotation, mirroring and translation. Throws
/// InputError, with the location, also if none of them is given.
AffineTransform read_placement(const TomlTable& table) {
  AffineTransform transform;
  bool any = false;
  const auto then = [&](const std::string& key, const auto& next) {
    if (!table.has(key)) return;
    any = true;
    transform = transform.then(placed_at(table, key, next));
  };
  const auto about = [](const TomlTable& t) { return vector_or(t, "about", Vec3::Zero()); };
  then("scale", [&] {
    const TomlTable t = table.table("scale", {"factor", "about"}).front();
    return scaling_about(about(t), t.number("factor"));
  });
  then("rotate", [&] {
    const TomlTable t = table.table("rotate", {"axis", "angle", "about"}).front();
    return rotation_about(about(t), t.vector("axis"), radians(t.number("angle")));
  });
  then("mirror", [&] {
    const TomlTable t = table.table("mirror", {"normal", "origin"}).front();
    return reflection_in(vector_or(t, "origin", Vec3::Zero()), t.vector("normal"));
  });
  then("translate", [&] { return AffineTransform{Mat3::Identity(), table.vector("translate")}; });
  if (!any)
    table.fail("copy", "a copy in the same place",
               "one or more of: " + comma_separated(placement_keys()));
  return transform;
}

CharacterLine::Role read_role(const TomlTable& table) {
  using Role = CharacterLine::Role;
  return table.choice("role", Role::Outline,
                      {{"outline", Role::Outline}, {"hole", Role::Hole}, {"inner", Role::Inner}});
}

CharacterLine::MeshAlignment read_mesh_alignment(const TomlTable& table) {
  using MeshAlignment = CharacterLine::MeshAlignment;
  return table.choice("alignment", MeshAlignment::Auto,
                      {{"auto", MeshAlignment::Auto},
                       {"aligned", MeshAlignment::EdgeAligned},
                       {"embedded", MeshAlignment::Embedded}});
}

// Reads corners = [3, 7], "none" or "all".
void read_corners(const TomlTable& table, SceneLine& line) {
  if (!table.has("corners")) return;
  line.corners.emplace();
  if (!table.is_array("corners")) {
    line.all_corners = table.choice("corners", true, {{"all", true}, {"none", false}});
    return;
  }
  const bool has_points = !line.points.empty();
  for (const double number : table.list("corners")) {
    const bool whole = number == std::floor(number) && number >= 1 && number < 1e9;
    if (!whole || (has_points && number > isize(line.points)))
      table.fail("corners", batten::format_number(number),
                 has_points ? "numbers of points, 1 to " + std::to_string(line.points.size())
                            : "numbers of points, from 1 on");
    line.corners->push_back(static_cast<int>(number) - 1);
  }
}

// Reads points = "measured", which stands beside 'file'.
void read_measured(const TomlTable& table, SceneLine& line) {
  if (table.has("points") && !table.is_array("points"))
    line.measured = table.choice("points", true, {{"measured", true}});
}

// Reads the shape of a line; the result is the key that defines it.
std::string read_shape(const TomlTable& table, const std::filesystem::path& folder,
                       SceneLine& line) {
  std::vector<std::string> found;
  for (const std::string& key : shape_keys()) {
    const bool beside_file = key == "points" && table.has("file") && !table.is_array(key);
    if (table.has(key) && !beside_file) found.push_back(key);
  }
  if (found.size() != 1)
    table.fail("name",
               found.empty() ? "no shape for the curve '" + line.name + "'"
                             : "more than one shape for the curve '" + line.name + "'",
               "one of: " + comma_separated(shape_keys()));
  const std::string key = found.front();
  if (table.has("unit") && key != "file")
    table.fail("unit", "a unit beside '" + key + "'",
               "'unit' only with 'file': all other lengths are in the unit of the scene");
  if (key == "file") {
    line.file = folder / table.text("file");
    if (table.has("unit")) line.unit = read_unit(table, "unit");
    read_measured(table, line);
  } else if (key == "points") {
    line.points = table.points(key);
    if (line.points.size() < 2)
      table.fail(key, std::to_string(line.points.size()) + " points", "2 points or more");
  } else if (key == "copy") {
    line.copy = table.text("copy");
    line.transform = read_placement(table);
  } else {
    line.curve = read_shape_curve(table, key);
  }
  return key;
}

SceneLine read_line(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.location = table.location();
  line.name = table.text("name");
  if (roles) {
    line.role = read_role(table);
    line.mesh_alignment = read_mesh_alignment(table);
    line.constrains_surface = !table.boolean("trim_only", false);
    if (!line.constrains_surface && line.role != CharacterLine::Role::Hole)
      table.fail("trim_only", "trim_only = true for a curve that is not a hole",
                 "role = \"hole\" with it");
  }
  line.location = table.location(read_shape(table, folder, line));
  for (const std::string& key : placement_keys())
    if (table.has(key) && line.copy.empty())
      table.fail(key, "'" + key + "' without 'copy'", "both: copy = \"name of a curve\"");
  read_corners(table, line);
  return line;
}

SceneLine read_lines(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.file = folder / table.text("file");
  line.location = table.location("file");
  if (table.has("unit")) line.unit = read_unit(table, "unit");
  if (roles) {
    line.role = read_role(table);
    line.mesh_alignment = read_mesh_alignment(table);
  }
  line.creases = table.boolean("creases", false);
  read_measured(table, line);
  read_corners(table, line);
  line.only = table.strings("only");
  line.skip = table.strings("skip");
  if (roles) {
    line.inner = table.strings("inner");
    line.holes = table.strings("holes");
    line.constrains_surface = !table.boolean("trim_only", false);
    if (!line.constrains_surface && line.holes.empty() && line.role != CharacterLine::Role::Hole)
      table.fail("trim_only", "trim_only = true without holes",
                 "'holes', or role = \"hole\", with it");
  }
  if (!line.only.empty() && !line.skip.empty())
    table.fail("skip", "both 'only' and 'skip'", "one of them");
  return line;
}

}  // namespace

std::vector<std::string> line_keys(bool roles) {
  std::vector<std::string> keys = {"name", "unit", "corners"};
  keys.insert(keys.end(), shape_keys().begin(), shape_keys().end());
  keys.insert(keys.end(), placement_keys().begin(), placement_keys().end());
  if (roles) keys.insert(keys.end(), {"role", "alignment", "trim_only"});
  return keys;
}

std::vector<std::string> lines_keys(bool roles) {
  std::vector<std::string> keys = {"file", "unit", "only", "skip", "creases", "corners", "points"};
  if (roles) keys.insert(keys.end(), {"role", "alignment", "inner", "holes", "trim_only"});
  return keys;
}

std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required) {
  std::vector<SceneLine> lines;
  UniqueNames names("curve name");
  names.read(root, "curve", line_keys(roles), lines,
             [&](const TomlTable& t) { return read_line(t, folder, roles); });
  for (const TomlTable& t : root.tables("curves", lines_keys(roles)))
    lines.push_back(read_lines(t, folder, roles));
  if (required && lines.empty()) root.fail("", "no curves", "[[curve]] or [[curves]]");
  return lines;
}

}  // namespace batten
