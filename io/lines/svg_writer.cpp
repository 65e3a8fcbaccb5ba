// SPDX-License-Identifier: MPL-2.0
// Writes SVG files.
#include <cmath>
#include <map>
#include <ostream>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/named_lines.h"

namespace batten {
namespace {

// The plane of a drawing: coordinate `normal` is `level`. `right`, `up`: the coordinates that are
// drawn to the right and upwards.
struct DrawingPlane {
  int normal, right, up;
  double level = 0;
};

constexpr const char* kAxes = "xyz";

DrawingPlane plane_of(const std::filesystem::path& path, const Box3& box) {
  const double flat = 1e-9 * box.diagonal().norm();
  for (const DrawingPlane& plane :
       {DrawingPlane{2, 0, 1}, DrawingPlane{1, 0, 2}, DrawingPlane{0, 1, 2}})
    if (box.sizes()[plane.normal] <= flat)
      return {plane.normal, plane.right, plane.up, box.center()[plane.normal]};
  throw InputError(path.string() + ": found curves with z from " + format_number(box.min().z()) +
                   " to " + format_number(box.max().z()) +
                   ", expected curves in a plane z = const (or x = const, or y = const), because "
                   "SVG files contain plane drawings; write a .dxf file to keep curves in space");
}

// What the file does not contain about the plane of the curves; empty for z = 0.
std::vector<std::string> plane_notes(const std::filesystem::path& path, const DrawingPlane& plane,
                                     double size) {
  if (plane.normal == 2 && std::abs(plane.level) <= 1e-9 * size) return {};
  const auto axis = [](int i) { return std::string(1, kAxes[i]); };
  return {path.filename().string() + ": the curves lie in the plane " + axis(plane.normal) + " = " +
          format_number(plane.level) + ", which SVG files do not contain: in the file, " +
          axis(plane.right) + " points to the right and " + axis(plane.up) +
          " upwards, and the curves are read back in the plane z = 0"};
}

std::string xml_escaped(const std::string& text) {
  static const std::map<char, std::string> escapes = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}};
  std::string escaped;
  for (const char c : text) {
    const auto at = escapes.find(c);
    escaped += at == escapes.end() ? std::string(1, c) : at->second;
  }
  return escaped;
}

// An XML name similar to the name of a curve, different from all in `taken`.
std::string xml_id(const std::string& name, std::set<std::string>& taken) {
  std::string id;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool valid = letter || (c >= '0' && c <= '9') || c == '-' || c == '.';
    if (id.empty() && !letter) id = "_";
    if (valid || !id.ends_with('_')) id += valid ? c : '_';
  }
  std::string unique = id;
  for (int k = 2; !taken.insert(unique).second; ++k) unique = id + "_" + std::to_string(k);
  return unique;
}

class SvgWriter {
 public:
  SvgWriter(std::ostream& out, const DrawingPlane& plane) : out_(out), plane_(plane) {}

  void write(const std::vector<NamedCurve>& curves, const Box3& box, double unit_in_metres) {
    head(box, unit_in_metres);
    for (const NamedCurve& curve : curves) {
      out_ << "    <path";
      if (!curve.name.empty())
        out_ << " id=\"" << xml_id(curve.name, ids_) << "\" inkscape:label=\""
             << xml_escaped(curve.name) << "\"";
      out_ << " d=\"" << path_of(curve) << "\"/>\n";
    }
    out_ << "  </g>\n</svg>\n";
  }

 private:
  // The page is the bounding box with a margin, rounded to a decimal number.
  void head(const Box3& box, double unit_in_metres) {
    const double size = box.diagonal().norm();
    const double steps = std::pow(10, 2 - std::floor(std::log10(size)));  // per length unit
    const auto low = [&](int axis) { return std::floor((box.min()[axis] - 0.05 * size) * steps); };
    const auto high = [&](int axis) { return std::ceil((box.max()[axis] + 0.05 * size) * steps); };
    const double width = (high(plane_.right) - low(plane_.right)) / steps;
    const double height = (high(plane_.up) - low(plane_.up)) / steps;
    static constexpr std::pair<const char*, double> units[] = {
        {"cm", 0.01}, {"in", 0.0254}, {"mm", 0.001}};
    const auto* unit = units;
    while (unit->second != unit_in_metres && unit->second != 0.001) ++unit;
    const double scale = unit_in_metres == unit->second ? 1 : unit_in_metres / unit->second;
    out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         << "<svg xmlns=\"http://www.w3.org/2000/svg\" "
         << "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" width=\""
         << exact_number(width * scale) << unit->first << "\" height=\""
         << exact_number(height * scale) << unit->first << "\" viewBox=\""
         << exact_number(low(plane_.right) / steps) << " "
         << exact_number(0 - high(plane_.up) / steps) << " " << exact_number(width) << " "
         << exact_number(height) << "\" " << kSvgOrigin << "=\"0 0\">\n"
         << "  <g fill=\"none\" stroke=\"black\" stroke-width=\"" << format_number(0.002 * size)
         << "\">\n";
  }

  std::string at(const Vec3& p) const {
    return exact_number(p[plane_.right]) + "," + exact_number(0 - p[plane_.up]);
  }

  std::string path_of(const NamedCurve& curve) const {
    std::vector<Vec3> vertices = polyline_vertices(curve);
    std::string path;
    if (!vertices.empty()) {
      const bool closed = vertices.size() > 2 && vertices.front() == vertices.back();
      if (closed) vertices.pop_back();
      for (const Vec3& p : vertices) path += (path.empty() ? "M " : " L ") + at(p);
      return path + (closed ? " Z" : "");
    }
    path = "M " + at(curve.curve.bezier(0).b[0]);
    for (int s = 0; s < curve.curve.segment_count(); ++s) {
      const BezierCubic<Vec3> cubic = curve.curve.bezier(s);
      if (is_straight(cubic))
        path += " L " + at(cubic.b[3]);
      else
        path += " C " + at(cubic.b[1]) + " " + at(cubic.b[2]) + " " + at(cubic.b[3]);
    }
    return path + (curve.curve.closed() ? " Z" : "");
  }

  std::ostream& out_;
  DrawingPlane plane_;
  std::set<std::string> ids_;
};

}  // namespace

std::vector<std::string> write_svg(const std::filesystem::path& path,
                                   const std::vector<NamedCurve>& curves, double unit_in_metres) {
  const Box3 box = drawing_box(curves);
  const DrawingPlane plane = plane_of(path, box);
  write_file_atomically(
      path, [&](std::ostream& out) { SvgWriter(out, plane).write(curves, box, unit_in_metres); });
  return plane_notes(path, plane, box.diagonal().norm());
}

}  // namespace batten
