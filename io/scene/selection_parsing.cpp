#include "batten/io/scene/selection_parsing.h"

#include <cmath>

#include "batten/core/errors.h"

namespace batten {
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
  for (const TomlTable& p : t.table("plane", {"through", "normal", "within"}))
    rule.plane = {p.vector("through"), p.direction("normal"), p.positive("within", kInfinity)};
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
      {{"shape", FormFeature::Kind::Free}, {"direction", FormFeature::Kind::TranslationOnly}});
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

/// Reads what features are proposed.
void read_proposals(const TomlTable& root, FeatureDetectionOptions& o) {
  for (const TomlTable& t : root.table(
           "proposals", {"crease_degrees", "rim_rings", "rim_width", "outer_loops", "nested"})) {
    o.crease_degrees = t.positive("crease_degrees", o.crease_degrees);
    if (o.crease_degrees >= 180)
      t.fail("crease_degrees", format_number(o.crease_degrees), "less than 180 degrees");
    o.flange_rings = t.integer("rim_rings", 1, o.flange_rings);
    o.flange_width = t.positive("rim_width", o.flange_width);
    o.outer_loops = t.boolean("outer_loops", o.outer_loops);
    o.nested = t.boolean("nested", o.nested);
  }
}

/// Reads selections and cuts, which share their names.
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

/// Reads form features: one by one, and many of a kind.
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
