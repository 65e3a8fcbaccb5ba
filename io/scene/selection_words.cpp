#include "batten/io/scene/selection_words.h"

#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

SelectRule read_select(const TomlTable& t, const std::filesystem::path& folder) {
  SelectRule rule;
  rule.name = t.text("name");
  rule.place = t.place();
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
    rule.plane = {p.vector("through"), p.direction("normal"), p.positive("within", infinity)};
  if (t.has("loop")) rule.loop = t.whole_number("loop", 1, 1);
  if (t.has("part")) rule.part = t.whole_number("part", 1, 1);
  for (const TomlTable& g : t.table("salient", {"node", "point", "threshold"})) {
    SelectRule::Salient salient;
    if (g.has("node") == g.has("point"))
      g.fail("", "a start that is not one", "one of node, point");
    if (g.has("node")) salient.node = label_of(g, "node", g.number("node"));
    if (g.has("point")) salient.point = g.vector("point");
    salient.threshold = g.positive("threshold");
    rule.salient = salient;
  }
  for (const TomlTable& g : t.table("geodesic", {"node", "point", "of", "distance"})) {
    SelectRule::Geodesic geodesic;
    if (g.has("node")) geodesic.node = label_of(g, "node", g.number("node"));
    if (g.has("point")) geodesic.point = g.vector("point");
    if (g.has("of")) geodesic.of = word_of(g, "of");
    if (g.has("node") + g.has("point") + g.has("of") != 1)
      g.fail("", "no single start of the distance", "one of node, point, of");
    geodesic.distance = g.positive("distance");
    rule.geodesic = geodesic;
  }
  rule.nodes = labels_of(t, "nodes");
  if (t.has("file")) rule.file = folder / t.text("file");
  if (t.has("set")) rule.set = word_of(t, "set");
  if (t.has("property")) rule.property = word_of(t, "property");
  rule.any = t.names("any");
  rule.except = t.names("except");
  rule.grow = t.whole_number("grow", 0, 0);
  return rule;
}

CutRule read_cut(const TomlTable& t) {
  CutRule rule;
  rule.name = t.text("name");
  rule.place = t.place();
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
      {{"shape", FormFeature::Kind::Free}, {"direction", FormFeature::Kind::KeepsDirection}});
}

}  // namespace

PlacedWord word_of(const TomlTable& table, const std::string& key) {
  return {table.text(key), table.place(key)};
}

long label_of(const TomlTable& table, const std::string& key, double value) {
  if (value != std::floor(value) || std::abs(value) > 1e15)
    table.fail(key, number(value), "whole numbers of nodes");
  return static_cast<long>(value);
}

std::vector<long> labels_of(const TomlTable& table, const std::string& key) {
  std::vector<long> labels;
  if (table.has(key))
    for (const double value : table.list(key)) labels.push_back(label_of(table, key, value));
  return labels;
}

/// Reads what features are proposed.
void read_proposals(const TomlTable& root, ProposalOptions& o) {
  for (const TomlTable& t : root.table(
           "proposals", {"crease_degrees", "rim_rings", "rim_width", "outer_loops", "nested"})) {
    o.crease_degrees = t.positive("crease_degrees", o.crease_degrees);
    if (o.crease_degrees >= 180)
      t.fail("crease_degrees", number(o.crease_degrees), "less than 180 degrees");
    o.rim_rings = t.whole_number("rim_rings", 1, o.rim_rings);
    o.rim_width = t.positive("rim_width", o.rim_width);
    o.outer_loops = t.boolean("outer_loops", o.outer_loops);
    o.nested = t.boolean("nested", o.nested);
  }
}

/// Reads selections and cuts, which share their names.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene) {
  Names selections("selection");
  selections.read(root, "select",
                  {"name", "box", "sphere", "plane", "loop", "part", "salient", "geodesic", "nodes",
                   "file", "set", "property", "any", "except", "grow"},
                  scene.selections, [&](const TomlTable& t) { return read_select(t, folder); });
  selections.read(root, "cut", {"name", "band", "on", "beside", "inside", "concave", "convex"},
                  scene.cuts, read_cut);
}

/// Reads form features: one by one, and many of a kind.
std::vector<FeatureRule> read_features(const TomlTable& root, Names& kept) {
  std::vector<FeatureRule> features;
  for (const TomlTable& t : root.tables("feature", {"name", "vertices", "keep"})) {
    FeatureRule rule{t.text("name"), t.place(), t.names("vertices"), read_kind(t)};
    if (rule.vertices.empty()) rule.vertices = {{rule.name, t.place("name")}};
    kept.add(t, "name", rule.name);
    features.push_back(std::move(rule));
  }
  for (const TomlTable& t : root.tables("features", {"of", "keep"})) {
    FeatureRule rule{"", t.place(), t.names("of"), read_kind(t)};
    if (rule.vertices.empty()) t.fail("of", "no names", "a list of selections or proposals");
    features.push_back(std::move(rule));
  }
  return features;
}

}  // namespace batten
