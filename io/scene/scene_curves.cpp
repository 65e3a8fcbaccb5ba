#include "batten/io/scene/scene_curves.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/format.h"

namespace batten {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

Vec3 vector_or(const TomlTable& table, const std::string& key, const Vec3& fallback) {
  return table.has(key) ? table.vector(key) : fallback;
}

// centre, normal, x: the plane of a curve; without x the x of space, or its y seen along that.
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

// What the kernel refuses gets the place of the word.
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

}  // namespace

const std::vector<std::string>& shape_keys() {
  static const std::vector<std::string> words = {"file",   "points",  "bezier", "arc",
                                                 "circle", "ellipse", "helix",  "rectangle",
                                                 "spline", "copy"};
  return words;
}

std::shared_ptr<const InputCurve> read_curve(const TomlTable& table, const std::string& word) {
  return placed_at(table, word, [&] {
    return word == "arc"         ? arc(table)
           : word == "circle"    ? circle(table)
           : word == "ellipse"   ? ellipse(table)
           : word == "helix"     ? helix_of(table)
           : word == "rectangle" ? rectangle_of(table)
           : word == "spline"    ? spline(table)
                                 : bezier(table);
  });
}

const std::vector<std::string>& placement_keys() {
  static const std::vector<std::string> words = {"scale", "turn", "mirror", "move"};
  return words;
}

AffineTransform read_placement(const TomlTable& table) {
  AffineTransform transform;
  bool any = false;
  const auto then = [&](const std::string& key, const auto& next) {
    if (!table.has(key)) return;
    any = true;
    transform = transform.then(placed_at(table, key, next));
  };
  const auto point = [](const TomlTable& t) { return vector_or(t, "point", Vec3::Zero()); };
  then("scale", [&] {
    const TomlTable t = table.table("scale", {"factor", "point"}).front();
    return scaling_about(point(t), t.number("factor"));
  });
  then("turn", [&] {
    const TomlTable t = table.table("turn", {"axis", "angle", "point"}).front();
    return rotation_about(point(t), t.vector("axis"), radians(t.number("angle")));
  });
  then("mirror", [&] {
    const TomlTable t = table.table("mirror", {"normal", "point"}).front();
    return reflection_in(point(t), t.vector("normal"));
  });
  then("move", [&] { return AffineTransform{Mat3::Identity(), table.vector("move")}; });
  if (!any)
    table.fail("copy", "a copy in the same place",
               "one or more of: " + comma_separated(placement_keys()));
  return transform;
}

}  // namespace batten
