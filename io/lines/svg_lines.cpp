// SPDX-License-Identifier: MPL-2.0
// Reads SVG files.
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/named_lines.h"
#include "batten/io/lines/svg_path.h"
#include "batten/io/lines/svg_style.h"
#include "batten/io/lines/text_rows.h"

namespace batten {
namespace {

constexpr double kPixel = 0.0254 / 96;  // CSS pixel in metres
constexpr double kTwoPi = 2 * std::numbers::pi;

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

// The region to which percentages refer, in user units.
struct Viewport {
  double width = 0, height = 0;

  // The reference length for an attribute such as "x", "height" or "r".
  double reference(std::string_view key) const {
    if (key == "r") return std::hypot(width, height) / std::numbers::sqrt2;
    return key.find('y') != key.npos || key == "height" ? height : width;
  }
};

// A length in user units: "12", "3mm", or "50%" of the viewport.
double coordinate(const Element& element, const char* key, const Viewport& viewport,
                  double fallback = 0) {
  const std::string text = attribute(element, key);
  if (text.empty() || text == "auto") return fallback;
  if (text.back() == '%')
    if (const std::vector<double> percent = numbers_of(text); percent.size() == 1)
      return percent[0] / 100 * viewport.reference(key);
  const std::optional<double> metres = length_of(text);
  if (!metres) fail(element, key, "a length");
  return *metres / kPixel;
}

// The scale factors and the shift by which a viewBox is fitted into a region (preserveAspectRatio).
struct Fitting {
  double sx = 1, sy = 1, dx = 0, dy = 0;

  Fitting(const Element& element, const std::array<double, 4>& box, double width, double height)
      : sx(width / box[2]), sy(height / box[3]) {
    const std::string rule = attribute(element, "preserveAspectRatio");
    const auto has = [&](const char* word) { return rule.find(word) != std::string::npos; };
    if (std::abs(sx - sy) <= 1e-12 * sx)
      sy = sx;
    else if (!has("none"))
      sx = sy = has("slice") ? std::max(sx, sy) : std::min(sx, sy);
    const double x = has("xMin")   ? 0
                     : has("xMax") ? 1
                                   : 0.5,
                 y = has("YMin")   ? 0
                     : has("YMax") ? 1
                                   : 0.5;
    if (std::abs(width - sx * box[2]) > 1e-12 * width) dx = x * (width - sx * box[2]);
    if (std::abs(height - sy * box[3]) > 1e-12 * height) dy = y * (height - sy * box[3]);
    dx -= sx * box[0];
    dy -= sy * box[1];
  }
};

// The viewBox of an element; empty if it has none.
std::optional<std::array<double, 4>> view_box(const Element& element) {
  const std::vector<double> n = numbers_of(attribute(element, "viewBox"));
  if (n.size() != 4) return {};
  return std::array{n[0], n[1], n[2], n[3]};
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

SvgElementKey key_of(const Element& element) {
  SvgElementKey key{kind_of(element), attribute(element, "id"), {}};
  const std::string classes = attribute(element, "class");
  for (size_t at = 0; (at = classes.find_first_not_of(" \t\r\n", at)) != classes.npos;) {
    const size_t end = std::min(classes.find_first_of(" \t\r\n", at), classes.size());
    key.classes.push_back(classes.substr(at, end - at));
    at = end;
  }
  return key;
}

bool is_container(const std::string& kind) {
  return kind == "g" || kind == "a" || kind == "svg" || kind == "symbol" || kind == "switch";
}

// Walks through the elements as they are drawn: `use` elements are replaced by their targets, and
// elements that are not displayed or not visible are left out.
class SvgReader {
 public:
  Drawing read(const Element& root) {
    if (kind_of(root) != "svg") throw InputError("found no <svg>, expected an SVG drawing");
    collect(root);
    const State page = page_of(root);
    path_.push_back(key_of(root));
    if (property(root, "display") != "none") children(root, page);
    drawing_.unit_in_metres = unit_;
    passed_over_.report_to(drawing_);
    return std::move(drawing_);
  }

 private:
  // What elements inherit.
  struct State {
    AffineTransform transform;  // from user coordinates to those of the drawing
    Viewport viewport;
    std::string layer;
    std::string clone;  // name of the `use` element whose target this is
    bool visible = true;
  };

  // Collects style sheets and the targets of `use` elements.
  void collect(const Element& element) {
    if (kind_of(element) == "style") styles_.add(attribute(element, "#text"));
    if (const std::string id = attribute(element, "id"); !id.empty())
      targets_.emplace(id, &element);
    for (const Element& inner : element[2]) collect(inner);
  }

  // The value of a property of the last element of `path_`: its style attribute, the style sheets,
  // and the attribute of this name, in this order.
  std::string property(const Element& element, const std::string& name) const {
    std::string value = css_declaration(attribute(element, "style"), name);
    if (value.empty() && !styles_.empty()) value = styles_.value(path_, name);
    return value.empty() ? attribute(element, name.c_str()) : value;
  }

  // Sets the unit, and maps the page to coordinates with y upwards from its lower edge, or from the
  // origin that the writer states.
  State page_of(const Element& root) {
    auto width = length_of(attribute(root, "width")), height = length_of(attribute(root, "height"));
    const auto box = view_box(root);
    State page;
    AffineTransform& to_page = page.transform;
    to_page.A(1, 1) = -1;
    unit_ = kPixel;
    if (box && (*box)[2] > 0 && (*box)[3] > 0) {
      // A missing length follows from the other one.
      if (!(width && *width > 0) && height) width = *height * (*box)[2] / (*box)[3];
      if (!(width && *width > 0)) width = (*box)[2] * kPixel;
      if (!(height && *height > 0)) height = *width * (*box)[3] / (*box)[2];
      const Fitting fit(root, *box, *width, *height);
      unit_ = rounded_unit(fit.sx);
      to_page.A(1, 1) = -fit.sy / fit.sx;
      to_page.b = Vec3(fit.dx / fit.sx, (*height - fit.dy) / fit.sx, 0);
      page.viewport = {(*box)[2], (*box)[3]};
    } else {
      page.viewport = {width.value_or(0) / kPixel, height.value_or(0) / kPixel};
      to_page.b = Vec3(0, page.viewport.height, 0);
    }
    const std::vector<double> origin = numbers_of(attribute(root, kSvgOrigin));
    if (origin.size() == 2) to_page.b = Vec3(-origin[0], origin[1], 0);
    return page;
  }

  void children(const Element& parent, const State& state) {
    for (const Element& element : parent[2]) visit(element, state);
  }

  // A few elements that use each other several times can expand to any number of curves.
  void count_clone(const Element& element) {
    constexpr size_t most_elements = 250000, most_data = 1 << 22, deepest = 16;
    clone_data_ += attribute(element, "d").size() + attribute(element, "points").size();
    if (++clones_ > most_elements || clone_data_ > most_data)
      throw InputError("found more than " + std::to_string(most_elements) +
                       " elements in clones (use), or " + std::to_string(most_data >> 20) +
                       " MB of their path data, expected fewer");
    if (expanding_.size() > deepest)
      throw InputError("found clones (use) that are nested more than " + std::to_string(deepest) +
                       " levels deep, expected fewer levels");
  }

  void visit(const Element& element, const State& outer) {
    if (!expanding_.empty()) count_clone(element);
    path_.push_back(key_of(element));
    if (property(element, "display") != "none") displayed(element, outer);
    path_.pop_back();
  }

  void displayed(const Element& element, const State& outer) {
    const std::string kind = kind_of(element), label = attribute(element, "inkscape:label");
    State here = outer;
    here.transform = transform_of(element).then(outer.transform);
    here.clone.clear();
    if (const std::string visibility = property(element, "visibility"); !visibility.empty())
      here.visible = visibility == "visible";
    std::string name = !outer.clone.empty() ? outer.clone
                       : label.empty()      ? attribute(element, "id")
                                            : label;
    if (is_container(kind)) {
      if (!label.empty() || !outer.clone.empty()) here.layer = outer.clone.empty() ? label : name;
      if (kind == "svg")
        region(element, here, coordinate(element, "width", outer.viewport, outer.viewport.width),
               coordinate(element, "height", outer.viewport, outer.viewport.height));
      else if (kind == "switch")
        alternative(element, here);
      else if (kind != "symbol")  // drawn only by `use` elements
        children(element, here);
    } else if (kind == "use") {
      here.clone = name;
      use(element, here);
    } else if (here.visible) {
      shape(element, kind, here, name.empty() ? outer.layer : name);
    }
  }

  // The contents of a nested `svg` or of a `symbol`, with its own coordinates.
  void region(const Element& element, State here, double width, double height) {
    AffineTransform inner;
    inner.b =
        Vec3(coordinate(element, "x", here.viewport), coordinate(element, "y", here.viewport), 0);
    if (const auto box = view_box(element)) {
      if (!((*box)[2] > 0 && (*box)[3] > 0 && width > 0 && height > 0)) return;
      const Fitting fit(element, *box, width, height);
      inner.A(0, 0) = fit.sx;
      inner.A(1, 1) = fit.sy;
      inner.b += Vec3(fit.dx, fit.dy, 0);
      here.viewport = {(*box)[2], (*box)[3]};
    } else {
      here.viewport = {width, height};
    }
    here.transform = inner.then(here.transform);
    children(element, here);
  }

  // Of a `switch`, the first element without conditions is drawn.
  void alternative(const Element& element, const State& here) {
    for (const Element& inner : element[2]) {
      const std::string language = attribute(inner, "systemLanguage");
      if (!attribute(inner, "requiredExtensions").empty() ||
          (!language.empty() && language.find("en") == std::string::npos))
        continue;
      return visit(inner, here);
    }
  }

  void use(const Element& element, State here) {
    std::string href = attribute(element, "href");
    if (href.empty()) href = attribute(element, "xlink:href");
    if (href.empty()) return;
    const auto target = href[0] == '#' ? targets_.find(href.substr(1)) : targets_.end();
    if (target == targets_.end())
      return passed_over_.add(href[0] == '#' ? "use without its element" : "use of another file");
    const Element& drawn = *target->second;
    if (std::find(expanding_.begin(), expanding_.end(), &drawn) != expanding_.end())
      return passed_over_.add("use that contains itself");
    AffineTransform shift;
    shift.b =
        Vec3(coordinate(element, "x", here.viewport), coordinate(element, "y", here.viewport), 0);
    here.transform = shift.then(here.transform);
    expanding_.push_back(&drawn);
    const std::string kind = kind_of(drawn);
    if (kind == "symbol" || kind == "svg")
      instance(element, drawn, here);
    else
      visit(drawn, here);
    expanding_.pop_back();
  }

  // A `symbol` or `svg` drawn by a `use` element, whose width and height replace its own.
  void instance(const Element& use, const Element& drawn, State here) {
    path_.push_back(key_of(drawn));
    const auto extent = [&](const char* key, double whole) {
      return coordinate(use, key, here.viewport, coordinate(drawn, key, here.viewport, whole));
    };
    if (property(drawn, "display") != "none") {
      here.transform = transform_of(drawn).then(here.transform);
      here.layer = here.clone;
      here.clone.clear();
      region(drawn, here, extent("width", here.viewport.width),
             extent("height", here.viewport.height));
    }
    path_.pop_back();
  }

  void shape(const Element& e, const std::string& kind, const State& state,
             const std::string& name) {
    const AffineTransform& here = state.transform;
    const Viewport& view = state.viewport;
    if (kind == "path") return path(e, here, name);
    if (kind == "text" || kind == "image" || kind == "foreignObject") return passed_over_.add(kind);
    const auto at = [&](const char* x, const char* y) {
      return Vec3(coordinate(e, x, view), coordinate(e, y, view), 0);
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
      const double a = coordinate(e, circle ? "r" : "rx", view),
                   b = coordinate(e, circle ? "r" : "ry", view);
      if (!(a > 0 && b > 0)) return passed_over_.add(kind + " of zero size");
      const CurvePlane plane{at("cx", "cy"), Vec3::UnitX(), Vec3::UnitY()};
      add({name, {}, ellipse_arc(plane, a, b, 0, kTwoPi)}, here);
    } else if (kind == "rect") {
      rect(e, state, name);
    }
  }

  void rect(const Element& e, const State& state, const std::string& name) {
    const AffineTransform& here = state.transform;
    const Viewport& view = state.viewport;
    const double w = coordinate(e, "width", view), h = coordinate(e, "height", view);
    if (!(w > 0 && h > 0)) return passed_over_.add("rect without size");
    const double rx = coordinate(e, "rx", view, coordinate(e, "ry", view));
    const double ry = coordinate(e, "ry", view, rx);
    const Vec3 centre(coordinate(e, "x", view) + w / 2, coordinate(e, "y", view) + h / 2, 0);
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
  SvgStyleSheet styles_;
  std::map<std::string, const Element*> targets_;  // by id
  std::vector<SvgElementKey> path_;                // from the root to the current element
  std::vector<const Element*> expanding_;          // targets of `use` elements, outermost first
  size_t clones_ = 0, clone_data_ = 0;             // elements, and bytes of their path data
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
  if (element->GetName() && kind_of({element->GetName()}) == "style" && element->GetCharacterData())
    attributes["#text"] = element->GetCharacterData();
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

}  // namespace batten
