#include "batten/apps/commands/documents/document_view.h"

#include <algorithm>
#include <cmath>

#include "batten/core/box.h"

namespace batten {
namespace {

std::vector<Vec3> points_of(const InputCurve& curve) {
  constexpr int pieces = 96;
  std::vector<Vec3> points;
  for (int i = 0; i <= pieces; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / pieces));
  return points;
}

std::vector<DocumentView::Table> tables_of(const SceneText& text) {
  std::vector<SceneTable> names = {{}};
  names.insert(names.end(), text.tables().begin(), text.tables().end());
  std::vector<DocumentView::Table> tables;
  for (const SceneTable& name : names) {
    tables.push_back({name, {}});
    for (const std::string& key : text.keys(name))
      tables.back().values.emplace_back(key, text.value(name, key));
  }
  return tables;
}

std::vector<DocumentView::Slider> sliders_of(const Document& document) {
  std::vector<DocumentView::Slider> sliders;
  const SculptingSession* session = document.session();
  for (const NamedValue& p : document.scene().named_values()) {
    DocumentView::Slider slider{p.name, p.value, p.min, p.max, !p.follows.empty()};
    if (session && session->parameters().has(p.name))
      slider.value = session->parameters().value(p.name);
    sliders.push_back(slider);
  }
  return sliders;
}

void look_at_surface(DocumentView& view, const Document& document) {
  const SculptingSession& session = *document.session();
  const ModelLayout& layout = session.layout();
  view.surface = true;
  view.triangles = layout.mesh()->triangle_count();
  view.size = layout.size();
  for (const SkinnedRegion& region : session.regions()) {
    view.regions.push_back(region.name);
    for (const LineRun& run : region.runs) view.shown_lines.push_back(run.line.name);
    for (const EmbeddedLine& line : region.embedded) view.shown_lines.push_back(line.line.name);
  }
  const SculptModel& model = document.model()->model;
  const MadeModel& made = model.made;
  if (made.network)
    view.network = network_report(*made.network, *made.found, made.model, made.fit_tolerance,
                                  document.scene().network->join_tolerance);
  view.flaws = flaw_reports(made.model);
}

}  // namespace

std::array<Vec3, 2> DocumentView::box() const {
  std::optional<Box3> box;
  for (const Polyline& line : lines)
    for (const Vec3& p : line.points) {
      if (!box) box.emplace(p);
      box->extend(p);
    }
  if (!box) return {Vec3::Zero(), Vec3::Zero()};
  return {box->min(), box->max()};
}

const DocumentView::Table* DocumentView::table(const SceneTable& name) const {
  for (const Table& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

std::string DocumentView::free_name(const std::string& beginning) const {
  for (int number = 1;; ++number) {
    const std::string name = beginning + " " + std::to_string(number);
    if (std::none_of(tables.begin(), tables.end(),
                     [&](const Table& table) { return table.name.name == name; }))
      return name;
  }
}

DocumentView view_of(const Document& document) {
  DocumentView view;
  view.title = document.file().empty() ? "untitled" : document.file().filename().string();
  view.unit = document.scene().unit;
  view.text = document.text().text();
  view.changed = document.changed();
  view.can_undo = document.can_undo();
  view.can_redo = document.can_redo();
  view.problem = document.problem();
  view.tables = tables_of(document.text());
  view.sliders = sliders_of(document);
  for (const CharacterLine& line : document.lines())
    view.lines.push_back({line.name, points_of(*line.curve)});
  if (document.session()) look_at_surface(view, document);
  return view;
}

}  // namespace batten
