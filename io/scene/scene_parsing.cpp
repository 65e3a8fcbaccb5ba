// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene_parsing.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <locale>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {

const std::vector<std::string>& skin_keys() {
  static const std::vector<std::string> keys = {
      "alpha",         "beta",          "load_units",        "boundary",
      "fair",          "sections",      "fair_strength",     "max_displacement",
      "gap_tolerance", "tangent_angle", "crease_angle",      "angle_tolerance",
      "symmetry",      "noisy_curves",  "max_faces_per_edge"};
  return keys;
}
const std::vector<std::string>& mesh_keys() {
  static const std::vector<std::string> keys = {
      "element", "domain", "mesher", "minimize_distortion", "edge_length", "refine"};
  return keys;
}
const std::vector<std::string>& output_keys() {
  static const std::vector<std::string> keys = {
      "step", "step_form", "step_tolerance", "step_curves", "step_schema", "step_neighbours",
      "vtu",  "vtp",       "mesh",           "calculix"};
  return keys;
}

std::string read_unit(const TomlTable& table, const std::string& key) {
  const std::string unit = table.text(key);
  if (std::find(length_units().begin(), length_units().end(), unit) == length_units().end())
    table.fail(key, "the unit '" + unit + "'", expected_one_of(unit, length_units()));
  return unit;
}

std::string output_file(const TomlTable& table, const std::string& key, UniqueNames& files,
                        const std::vector<std::string>& endings) {
  const std::filesystem::path name = table.text(key);
  if (name.is_absolute() || name.has_parent_path())
    table.fail(key, "'" + name.string() + "'", "a file name without folders (files go to --out)");
  if (std::find(endings.begin(), endings.end(), name.extension()) == endings.end())
    table.fail(key, "'" + name.string() + "'",
               "a file name that ends in " + comma_separated(endings));
  files.add(table, key, name.string());
  return name.string();
}

void read_view(const TomlTable& table, double& azimuth, double& elevation, PictureSize& size) {
  if (table.has("view")) {
    const VecX view = table.numbers("view", "azimuth, elevation");
    if (std::abs(view[1]) > 90)
      table.fail("view", "elevation " + format_number(view[1]), "-90 to 90 degrees");
    azimuth = view[0];
    elevation = view[1];
  }
  if (table.has("size")) {
    const VecX pixels = table.numbers("size", "width, height");
    if (pixels.minCoeff() < 64 || pixels.maxCoeff() > 4096)
      table.fail("size", format_number(pixels[0]) + " by " + format_number(pixels[1]),
                 "64 to 4096 pixels each");
    size = {static_cast<int>(pixels[0]), static_cast<int>(pixels[1])};
  }
}

std::string format_range(double min, double max) {
  if (min > -kInfinity && max < kInfinity)
    return "from " + format_number(min) + " to " + format_number(max);
  if (min > -kInfinity) return "from " + format_number(min) + " up";
  return "up to " + format_number(max);
}

toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       const std::string& expected) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(format_location(file.string(), {1, 1}) + "found an empty file, expected " +
                     expected);
  check_nesting_depth(text, file.string());
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& e) {
    const auto begin = e.source().begin;
    throw InputError(format_location(file.string(), {static_cast<int>(begin.line),
                                                     static_cast<int>(begin.column)}) +
                     "not TOML: " + std::string(e.description()));
  }
}

namespace {

/// A number with the fewest digits that read back exactly; other values as toml++ writes them.
template <class Value>
std::string value_to_toml(const Value& value) {
  if constexpr (std::is_same_v<Value, toml::value<double>>)
    if (std::isfinite(value.get())) {
      char digits[32];
      return {digits, std::to_chars(digits, digits + sizeof digits, value.get()).ptr};
    }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

std::string key_to_toml(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-';
  });
  return bare ? std::string(key) : value_to_toml(toml::value<std::string>(key));
}

}  // namespace

std::string to_toml(const toml::node& part) {
  std::string text;
  const auto add = [&](const std::string& one) { text += (text.empty() ? "" : ", ") + one; };
  if (const toml::table* table = part.as_table()) {
    for (const auto& [key, value] : *table) add(key_to_toml(key.str()) + " = " + to_toml(value));
    return text.empty() ? "{}" : "{ " + text + " }";
  }
  if (const toml::array* list = part.as_array()) {
    for (const toml::node& one : *list) add(to_toml(one));
    return "[" + text + "]";
  }
  part.visit([&](const auto& value) { text = value_to_toml(value); });
  return text;
}

namespace {

SelectionSpec read_select(const TomlTable& t, const std::filesystem::path& folder) {
  SelectionSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  if (t.has("box")) {
    const auto corners = t.points("box");
    if (corners.size() != 2)
      t.fail("box", std::to_string(corners.size()) + " points",
             "two corners [[x, y, z], [x, y, z]]");
    rule.box = {corners[0].cwiseMin(corners[1]), corners[0].cwiseMax(corners[1])};
  }
  for (const TomlTable& s : t.table("sphere", {"centre", "radius"}))
    rule.sphere = {s.vector("centre"), s.positive("radius")};
  for (const TomlTable& p : t.table("plane", {"origin", "normal", "within"}))
    rule.plane = {p.vector("origin"), p.direction("normal"), p.positive("within", kInfinity)};
  if (t.has("loop")) rule.loop = t.integer("loop", 1, 1);
  if (t.has("part")) rule.part = t.integer("part", 1, 1);
  for (const TomlTable& g : t.table("salient", {"node", "point", "threshold"})) {
    SelectionSpec::Salient salient;
    if (g.has("node") == g.has("point"))
      g.fail("", "a start that is not one", "one of node, point");
    if (g.has("node")) salient.node = read_label(g, "node", g.number("node"));
    if (g.has("point")) salient.point = g.vector("point");
    salient.threshold = g.positive("threshold");
    rule.salient = salient;
  }
  for (const TomlTable& g : t.table("geodesic", {"node", "point", "of", "distance"})) {
    SelectionSpec::Geodesic geodesic;
    if (g.has("node")) geodesic.node = read_label(g, "node", g.number("node"));
    if (g.has("point")) geodesic.point = g.vector("point");
    if (g.has("of")) geodesic.of = read_string(g, "of");
    if (g.has("node") + g.has("point") + g.has("of") != 1)
      g.fail("", "no single start of the distance", "one of node, point, of");
    geodesic.distance = g.positive("distance");
    rule.geodesic = geodesic;
  }
  rule.nodes = read_labels(t, "nodes");
  if (t.has("file")) rule.file = folder / t.text("file");
  if (t.has("set")) rule.set = read_string(t, "set");
  if (t.has("property")) rule.property = read_string(t, "property");
  rule.any = t.names("any");
  rule.except = t.names("except");
  rule.grow = t.integer("grow", 0, 0);
  return rule;
}

CutSpec read_cut(const TomlTable& t) {
  CutSpec rule;
  rule.name = t.text("name");
  rule.location = t.location();
  rule.band = t.names("band");
  rule.on = t.names("on");
  rule.beside = t.names("beside");
  if (rule.on.empty() != rule.beside.empty() || rule.band.empty() == rule.on.empty())
    t.fail("", "a cut without band or strokes",
           "band, which holds the feature's border, or on and beside, strokes that tell the two "
           "sides");
  if (t.has("inside")) rule.inside = t.vector("inside");
  rule.options.concave = t.positive("concave", rule.options.concave);
  rule.options.convex = t.positive("convex", rule.options.convex);
  return rule;
}

FormFeature::Kind read_kind(const TomlTable& t) {
  return t.choice(
      "keep", FormFeature::Kind::Free,
      {{"shape", FormFeature::Kind::Free}, {"orientation", FormFeature::Kind::TranslationOnly}});
}

}  // namespace

LocatedString read_string(const TomlTable& table, const std::string& key) {
  return {table.text(key), table.location(key)};
}

long read_label(const TomlTable& table, const std::string& key, double value) {
  if (value != std::floor(value) || std::abs(value) > 1e15)
    table.fail(key, format_number(value), "whole numbers of nodes");
  return static_cast<long>(value);
}

std::vector<long> read_labels(const TomlTable& table, const std::string& key) {
  std::vector<long> labels;
  if (table.has(key))
    for (const double value : table.list(key)) labels.push_back(read_label(table, key, value));
  return labels;
}

/// Reads the options of feature detection.
void read_proposals(const TomlTable& root, FeatureDetectionOptions& o) {
  for (const TomlTable& t : root.table("proposals", {"crease_angle", "flange_rings", "flange_width",
                                                     "outer_loops", "nested"})) {
    o.crease_degrees = t.positive("crease_angle", o.crease_degrees);
    if (o.crease_degrees >= 180)
      t.fail("crease_angle", format_number(o.crease_degrees), "less than 180 degrees");
    o.flange_rings = t.integer("flange_rings", 1, o.flange_rings);
    o.flange_width = t.positive("flange_width", o.flange_width);
    o.outer_loops = t.boolean("outer_loops", o.outer_loops);
    o.nested = t.boolean("nested", o.nested);
  }
}

/// Reads selections and cuts, which share one namespace.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene) {
  UniqueNames selections("selection");
  selections.read(root, "select",
                  {"name", "box", "sphere", "plane", "loop", "part", "salient", "geodesic", "nodes",
                   "file", "set", "property", "any", "except", "grow"},
                  scene.selections, [&](const TomlTable& t) { return read_select(t, folder); });
  selections.read(root, "cut", {"name", "band", "on", "beside", "inside", "concave", "convex"},
                  scene.cuts, read_cut);
}

/// Reads form features, single ones and several of one kind.
std::vector<FeatureSpec> read_features(const TomlTable& root, UniqueNames& taken) {
  std::vector<FeatureSpec> features;
  for (const TomlTable& t : root.tables("feature", {"name", "vertices", "keep"})) {
    FeatureSpec rule{t.text("name"), t.location(), t.names("vertices"), read_kind(t)};
    if (rule.vertices.empty()) rule.vertices = {{rule.name, t.location("name")}};
    taken.add(t, "name", rule.name);
    features.push_back(std::move(rule));
  }
  for (const TomlTable& t : root.tables("features", {"of", "keep"})) {
    FeatureSpec rule{"", t.location(), t.names("of"), read_kind(t)};
    if (rule.vertices.empty()) t.fail("of", "no names", "a list of selections or proposals");
    features.push_back(std::move(rule));
  }
  return features;
}

}  // namespace batten
