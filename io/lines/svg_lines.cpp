// SPDX-License-Identifier: MPL-2.0
// Reads and writes SVG files.
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <ostream>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/named_lines.h"
#include "batten/io/lines/svg_path.h"
#include "batten/io/lines/text_rows.h"

namespace batten {
namespace {

constexpr double kPixel = 0.0254 / 96;  // CSS pixel in metres
constexpr double kTwoPi = 2 * std::numbers::pi;
// Attribute of the root element with the origin of the curves, in user coordinates.
constexpr const char* kOrigin = "data-batten-origin";

Vec3 in_plane(const Vec2& p) { return {p.x(), p.y(), 0}; }

// An element of the file: [name, {attribute: value}, [elements inside of it]].
using Element = nlohmann::json;

// Element name without namespace: "svg:path" is a path.
std::string kind_of(const Element& element) {
  const std::string name = element[0];
  return name.substr(name.find(':') + 1);
}

std::string attribute(const Element& element, const char* key) { return element[1].value(key, ""); }

[[noreturn]] void fail(const Element& element, const std::string& key,
                       const std::string& expected) {
  const std::string id = attribute(element, "id");
  throw InputError("found " + key + " = " + quoted_excerpt(attribute(element, key.c_str())) +
                   " of a " + kind_of(element) + (id.empty() ? "" : " with id '" + id + "'") +
                   ", expected " + expected);
}

// Extracts numbers separated by commas, blanks or words.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  for (size_t i = 0; i < text.size();) {
    double value = 0;
    const char* first = text.data() + i + (text[i] == '+');
    const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
    // "inf" and "nan" count as words
    const bool good = error == std::errc() && std::isfinite(value);
    if (good) numbers.push_back(value);
    i = good ? static_cast<size_t>(end - text.data()) : i + 1;
  }
  return numbers;
}

// Parses a length, in metres. A bare number is in pixels. nullopt if it is missing or a percentage.
std::optional<double> length_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return {};
  const std::string unit(
      trimmed(std::string_view(text).substr(static_cast<size_t>(end - text.data()))));
  static const std::map<std::string, double> units = {
      {"", kPixel},        {"px", kPixel},     {"mm", 0.001},  {"cm", 0.01},  {"in", 0.0254},
      {"pt", 0.0254 / 72}, {"pc", 0.0254 / 6}, {"q", 0.00025}, {"Q", 0.00025}};
  const auto found = units.find(unit);
  if (found == units.end()) return {};
  return value * found->second;
}

// Removes the rounding errors of the division that gives a unit.
double rounded_unit(double metres) {
  for (const std::string& name : length_units())
    if (const double unit = unit_in_metres(name); std::abs(metres - unit) <= 1e-12 * unit)
      return unit;
  return metres;
}

double coordinate(const Element& element, const char* key, double fallback = 0) {
  const std::string text = attribute(element, key);
  if (text.empty()) return fallback;
  const std::optional<double> metres = length_of(text);
  if (!metres) fail(element, key, "a length");
  return *metres / kPixel;
}

// One transform function with its arguments.
AffineTransform transform_name(const Element& element, const std::string& name,
                               const std::vector<double>& n) {
  const size_t count = n.size();
  AffineTransform p;
  const auto put = [&](double a, double b, double c, double d, double e, double f) {
    p.A.topLeftCorner<2, 2>() << a, c, b, d;
    p.b = Vec3(e, f, 0);
  };
  const auto angle = [&] { return n[0] * std::numbers::pi / 180; };
  if (name == "matrix" && count == 6) {
    put(n[0], n[1], n[2], n[3], n[4], n[5]);
  } else if (name == "translate" && (count == 1 || count == 2)) {
    put(1, 0, 0, 1, n[0], count > 1 ? n[1] : 0);
  } else if (name == "scale" && (count == 1 || count == 2)) {
    put(n[0], 0, 0, n.back(), 0, 0);
  } else if (name == "rotate" && (count == 1 || count == 3)) {
    const double c = std::cos(angle()), s = std::sin(angle());
    put(c, s, -s, c, 0, 0);
    if (count == 3) {
      const Vec3 about(n[1], n[2], 0);
      p.b = about - p.A * about;
    }
  } else if (name == "skewX" && count == 1) {
    put(1, 0, std::tan(angle()), 1, 0, 0);
  } else if (name == "skewY" && count == 1) {
    put(1, std::tan(angle()), 0, 1, 0, 0);
  } else {
    fail(element, "transform",
         "transforms such as matrix(a b c d e f), translate(x y), rotate(angle)");
  }
  return p;
}

AffineTransform transform_of(const Element& element) {
  const std::string text = attribute(element, "transform");
  AffineTransform all;
  for (size_t i = 0;;) {
    i = text.find_first_not_of(" \t\r\n,", i);
    if (i == text.npos) return all;
    const size_t open = text.find('(', i), close = text.find(')', i);
    if (open == text.npos || close == text.npos || close < open)
      fail(element, "transform", "transforms with numbers in parentheses");
    const std::string name(trimmed(std::string_view(text).substr(i, open - i)));
    // The last transform in the list is applied first.
    all =
        transform_name(element, name, numbers_of(std::string_view(text).substr(open, close - open)))
            .then(all);
    i = close + 1;
  }
}

std::shared_ptr<const InputCurve> piece_of(const SvgSegment& segment) {
  if (segment.type == SvgSegment::Type::arc) {
    const SvgArc& arc = segment.arc;
    const double c = std::cos(arc.rotation), s = std::sin(arc.rotation);
    const CurvePlane plane{in_plane(arc.centre), Vec3(c, s, 0), Vec3(-s, c, 0)};
    return ellipse_arc(plane, arc.radii.x(), arc.radii.y(), arc.from, arc.to);
  }
  const auto p = [&](int i) { return in_plane(segment.points[i]); };
  if (segment.type == SvgSegment::Type::line) return straight_segment(p(0), p(3));
  return bezier_curve(p(0), p(1), p(2), p(3));
}

class SvgReader {
 public:
  Drawing read(const Element& root) {
    if (kind_of(root) != "svg") throw InputError("found no <svg>, expected an SVG drawing");
    go_into(root, page_of(root), "");
    drawing_.unit_in_metres = unit_;
    passed_over_.report_to(drawing_);
    return std::move(drawing_);
  }

 private:
  // Sets the unit, and maps the page to coordinates with y upwards from its lower edge, or from the
  // origin that the writer states.
  AffineTransform page_of(const Element& root) {
    std::vector<double> box = numbers_of(attribute(root, "viewBox"));
    const auto width = length_of(attribute(root, "width"));
    const auto height = length_of(attribute(root, "height"));
    unit_ = kPixel;
    if (box.size() == 4 && box[2] > 0 && width && *width > 0) unit_ = rounded_unit(*width / box[2]);
    if (box.size() != 4) box = {0, 0, 0, height ? *height / kPixel : 0};
    AffineTransform page;
    page.A(1, 1) = -1;
    page.b = Vec3(-box[0], box[1] + box[3], 0);
    const std::vector<double> origin = numbers_of(attribute(root, kOrigin));
    if (origin.size() == 2) page.b = Vec3(-origin[0], origin[1], 0);
    return page;
  }

  void go_into(const Element& parent, const AffineTransform& outer, const std::string& layer) {
    for (const Element& element : parent[2]) {
      const std::string kind = kind_of(element);
      if (attribute(element, "display") == "none" ||
          attribute(element, "style").find("display:none") != std::string::npos)
        continue;
      const AffineTransform here = transform_of(element).then(outer);
      const std::string label = attribute(element, "inkscape:label");
      const std::string name = label.empty() ? attribute(element, "id") : label;
      if (kind == "g" || kind == "a" || kind == "svg")
        go_into(element, here, label.empty() ? layer : label);
      else
        shape(element, kind, here, name.empty() ? layer : name);
    }
  }

  void shape(const Element& e, const std::string& kind, const AffineTransform& here,
             const std::string& name) {
    if (kind == "path") return path(e, here, name);
    if (kind == "text" || kind == "image" || kind == "use" || kind == "foreignObject")
      return passed_over_.add(kind);
    const auto at = [&](const char* x, const char* y) {
      return Vec3(coordinate(e, x), coordinate(e, y), 0);
    };
    if (kind == "line") {
      add({name, {at("x1", "y1"), at("x2", "y2")}}, here);
    } else if (kind == "polyline" || kind == "polygon") {
      const std::vector<double> n = numbers_of(attribute(e, "points"));
      if (n.size() % 2 != 0 || n.size() < 4) fail(e, "points", "pairs of numbers, two or more");
      DrawnLine line{name, {}};
      for (size_t i = 0; i < n.size(); i += 2) line.points.push_back({n[i], n[i + 1], 0});
      if (kind == "polygon" && line.points.front() != line.points.back())
        line.points.push_back(line.points.front());
      add(line, here);
    } else if (kind == "circle" || kind == "ellipse") {
      const bool circle = kind == "circle";
      const double a = coordinate(e, circle ? "r" : "rx"), b = coordinate(e, circle ? "r" : "ry");
      if (!(a > 0 && b > 0)) return passed_over_.add(kind + " of zero size");
      const CurvePlane plane{at("cx", "cy"), Vec3::UnitX(), Vec3::UnitY()};
      add({name, {}, ellipse_arc(plane, a, b, 0, kTwoPi)}, here);
    } else if (kind == "rect") {
      rect(e, here, name);
    }
  }

  void rect(const Element& e, const AffineTransform& here, const std::string& name) {
    const double w = coordinate(e, "width"), h = coordinate(e, "height");
    if (!(w > 0 && h > 0)) return passed_over_.add("rect without size");
    const double rx = coordinate(e, "rx", coordinate(e, "ry"));
    const double ry = coordinate(e, "ry", rx);
    const Vec3 centre(coordinate(e, "x") + w / 2, coordinate(e, "y") + h / 2, 0);
    if (!(rx > 0 && ry > 0)) {
      const CurvePlane plane{centre, Vec3::UnitX(), Vec3::UnitY()};
      return add({name, {}, rectangle(plane, w, h, 0)}, here);
    }
    // Elliptical corners are circular ones, scaled in y.
    const double a = std::min(rx, w / 2), stretch = std::min(ry, h / 2) / a;
    AffineTransform own;
    own.A(1, 1) = stretch;
    own.b = centre;
    add({name, {}, rectangle({}, w, h / stretch, a)}, own.then(here));
  }

  // Adds each subpath as a line: as points if all its segments are straight, else as a curve.
  void path(const Element& e, const AffineTransform& here, const std::string& name) {
    std::vector<SvgSubpath> parts;
    try {
      parts = parse_svg_path(attribute(e, "d"));
    } catch (const SvgPathError& error) {
      fail(e, "d",
           "path data (M, L, C, A, z …); at character " + std::to_string(error.index + 1) + ": " +
               error.what());
    }
    for (const SvgSubpath& part : parts) {
      std::vector<std::shared_ptr<const InputCurve>> pieces;
      DrawnLine line{name, {in_plane(part.start)}};
      bool straight_only = true;
      for (const SvgSegment& segment : part.segments) {
        pieces.push_back(piece_of(segment));
        straight_only = straight_only && segment.type == SvgSegment::Type::line;
        line.points.push_back(in_plane(segment.end()));
      }
      if (pieces.empty()) {
        passed_over_.add("path of zero length");
        continue;
      }
      if (!straight_only) {
        line.points.clear();
        line.curve = pieces.size() == 1 ? pieces[0] : concatenated(std::move(pieces));
      }
      add(line, here);
    }
  }

  void add(const DrawnLine& line, const AffineTransform& here) {
    drawing_.lines.push_back(transformed(line, here));
  }

  Drawing drawing_;
  SkippedEntities passed_over_;
  double unit_ = kPixel;
};

}  // namespace

namespace {

// Entities are replaced by their text wherever they are used, so those that contain others, or long
// texts, can expand to any size. Drawings use them for short addresses of namespaces.
void check_entities(const std::string& text, const std::filesystem::path& path) {
  constexpr size_t longest = 200;
  for (size_t at = text.find("<!ENTITY"); at != text.npos; at = text.find("<!ENTITY", at + 1)) {
    const size_t begin = std::min(text.find_first_of("\"'", at), text.size() - 1),
                 end = std::min(text.find(text[begin], begin + 1), text.size());
    const std::string_view value = std::string_view(text).substr(begin + 1, end - begin - 1);
    if (value.size() > longest || value.find_first_of("&%<") != value.npos)
      throw InputError(path.string() + ":" +
                       std::to_string(1 + std::count(text.begin(), text.begin() + at, '\n')) +
                       ": found an entity with the text " + quoted_excerpt(value) +
                       ", expected a plain text of at most " + std::to_string(longest) +
                       " characters");
  }
}

Element element_of(vtkXMLDataElement* element) {
  Element attributes = Element::object(), nested = Element::array();
  for (int i = 0; i < element->GetNumberOfAttributes(); ++i)
    attributes[element->GetAttributeName(i)] = element->GetAttributeValue(i);
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i)
    nested.push_back(element_of(element->GetNestedElement(i)));
  return Element::array(
      {element->GetName() ? element->GetName() : "", std::move(attributes), std::move(nested)});
}

Element read_elements(const std::filesystem::path& path) {
  const std::string bytes = sandboxed_read(path, "VTK", [&] {
    vtkNew<vtkXMLDataParser> parser;
    parser->SetFileName(path.string().c_str());
    // Suppress VTK's error output.
    parser->AddObserver(vtkCommand::ErrorEvent, vtkNew<vtkCallbackCommand>());
    if (!parser->Parse() || !parser->GetRootElement())
      throw InputError(path.string() + ": found no well-formed XML, expected an SVG drawing");
    std::string result;
    Element::to_cbor(element_of(parser->GetRootElement()), result);
    return result;
  });
  return Element::from_cbor(bytes);
}

}  // namespace

Drawing read_svg(const std::filesystem::path& path) {
  const std::string text = read_input_file(path, "a drawing");
  check_xml_nesting_depth(text, path.string());
  check_entities(text, path);
  const Element root = read_elements(path);
  try {
    return SvgReader().read(root);
  } catch (const std::exception& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

// Writes SVG files.

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
         << exact_number(height) << "\" " << kOrigin << "=\"0 0\">\n"
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
