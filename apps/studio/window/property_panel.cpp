// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/window/property_panel.h"

#include <QComboBox>
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QStringList>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <string>

#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/mesh_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/io/scene/scene_text.h"

namespace batten::studio {

// Values of enumerated keys in a scene, for combo boxes.

/// Possible values of a key in TOML notation. Booleans: "true" and "false"; enumerated keys: the
/// values in docs/scenes.md; empty for all other keys, or if the list does not contain `value`.
/// `faired`: [skin] of the scene has fair = "variation", which supports G2.
QStringList enum_values(const SceneTable& table, const std::string& key, const std::string& value,
                        bool faired);

namespace {

using CommandKind = DocumentCommand::CommandKind;
using Kind = ModelTree::Item::Kind;

/// The input as a TOML value; input that is not valid TOML is quoted as a string.
std::string as_value(const std::string& typed) {
  try {
    SceneText("key = " + typed);
    return typed;
  } catch (const Error&) {
    return SceneText::toml_value(typed);
  }
}

}  // namespace

PropertyPanel::PropertyPanel(QWidget* parent, std::function<void(DocumentCommand)> post,
                             ViewSelection selection)
    : QWidget(parent),
      post_(std::move(post)),
      selection_(std::move(selection)),
      title_(new QLabel),
      description_(new QLabel),
      buttons_(new QWidget),
      keys_(new QTableWidget(0, 2)) {
  auto* column = new QVBoxLayout(this);
  QFont bold = title_->font();
  bold.setBold(true);
  title_->setFont(bold);
  description_->setWordWrap(true);
  description_->setSizePolicy(QSizePolicy::Ignored,
                              QSizePolicy::Preferred);  // long words must not widen the panel
  title_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  new QGridLayout(buttons_);
  buttons_->layout()->setContentsMargins(0, 0, 0, 0);
  keys_->setHorizontalHeaderLabels({text(kKey), text(kValue)});
  keys_->verticalHeader()->hide();
  keys_->horizontalHeader()->setStretchLastSection(true);
  column->addWidget(title_);
  column->addWidget(description_);
  column->addWidget(buttons_);
  column->addWidget(keys_, 8);
  column->addStretch(1);
  QObject::connect(keys_, &QTableWidget::cellChanged, this, [this](int row, int) {
    if (!filling_) post_value(row);
  });
}

// Posts the value of a row to the scene; for a new row, once both cells are filled.
void PropertyPanel::post_value(int row) {
  const std::string key = keys_->item(row, 0)->text().trimmed().toStdString();
  const std::string typed = keys_->item(row, 1)->text().trimmed().toStdString();
  if (key.empty() || key == text(kAddProperty).toStdString()) return;
  if (typed.empty()) {  // let the user enter the value next
    keys_->setCurrentCell(row, 1);
    return keys_->editItem(keys_->item(row, 1));
  }
  const std::string value = as_value(typed);
  if (const auto part = selected_stress_part()) {
    for (DocumentCommand& edit : stress_part_edits(SceneText(view_->text), *part, key, value))
      post_(std::move(edit));
    return;
  }
  post_({.kind = CommandKind::Set, .table = item_.table, .key = key, .text = value});
}

std::optional<StressPart> PropertyPanel::selected_stress_part() const {
  if (item_.kind != Kind::StressPart) return std::nullopt;
  const std::vector<StressPart> parts = stress_parts(SceneText(view_->text));
  const auto number = static_cast<size_t>(item_.number);
  return number < parts.size() ? std::optional(parts[number]) : std::nullopt;
}

void PropertyPanel::refresh(std::shared_ptr<const DocumentView> view, const ModelTree::Item& item) {
  view_ = std::move(view);
  item_ = item;
  for (QPushButton* old : buttons_->findChildren<QPushButton*>()) delete old;
  title_->setText(shown(item.name.empty() ? item.table.kind : item.name));
  description_->clear();
  fill_table();
  fill_description();
  fill_mesh();
  fill_line();
  fill_stress();
  description_->setVisible(!description_->text().isEmpty());
}

void PropertyPanel::fill_table() {
  filling_ = true;
  keys_->setRowCount(0);
  const bool stated = item_.kind == Kind::Table || item_.table.kind != "";
  const DocumentView::Table* table = stated ? view_->table(item_.table) : nullptr;
  const std::optional<StressPart> part = selected_stress_part();
  const std::vector<SceneText::Value> none;
  for (const auto& [key, value] : part ? part->values : table ? table->values : none)
    add_key(key, value);
  if (part || stated) add_key(text(kAddProperty).toStdString(), "");
  keys_->setVisible(keys_->rowCount() > 0);
  filling_ = false;
}

// Adds a row. Enumerated keys get a combo box, whose last entry allows free input.
void PropertyPanel::add_key(const std::string& key, const std::string& value) {
  const int row = keys_->rowCount();
  keys_->insertRow(row);
  auto* name = new QTableWidgetItem(shown(key));
  if (key == text(kAddProperty).toStdString())
    name->setForeground(palette().brush(QPalette::Disabled, QPalette::Text));
  else
    name->setFlags(name->flags() & ~Qt::ItemIsEditable);
  keys_->setItem(row, 0, name);
  keys_->setItem(row, 1, new QTableWidgetItem(shown(value)));
  const DocumentView::Table* skin = view_->table({"skin", ""});
  const bool faired =
      skin && std::find(skin->values.begin(), skin->values.end(),
                        SceneText::Value("fair", "\"variation\"")) != skin->values.end();
  const QStringList entries = enum_values(item_.table, key, value, faired);
  if (entries.isEmpty()) return;
  auto* list = new QComboBox;
  list->addItems(entries);
  list->setCurrentText(shown(value));
  input_filter_.watch(list);
  QObject::connect(list, QOverload<int>::of(&QComboBox::activated), this,
                   [this, list, row] { keys_->item(row, 1)->setText(list->currentText()); });
  keys_->setCellWidget(row, 1, list);
}

void PropertyPanel::fill_description() {
  if (!view_->network) return;
  const NetworkReport& network = *view_->network;
  QStringList entries;
  if (item_.kind == Kind::Alternative &&
      item_.number < static_cast<int>(network.ambiguous_regions.size())) {
    const auto choice = network.ambiguous_regions[static_cast<size_t>(item_.number)];
    entries << shown(choice.text);
    for (int i = 0; i < static_cast<int>(choice.alternatives.size()); ++i)
      add_button(kUseAlternative, [choice, i] { return alternative_edits(choice, i); });
  }
  for (const auto& region : network.regions) {
    if (item_.kind != Kind::Region || region.name != item_.name) continue;
    if (!region.rejection_reason.empty()) entries << shown(region.rejection_reason);
    for (const std::string& defect : region.defects) entries << shown(defect);
    for (const std::string& warning : region.warnings) entries << shown(warning);
  }
  for (const auto& join : network.joins) {
    const bool line = item_.kind == Kind::Join || item_.kind == Kind::Line;
    const bool whole = item_.kind == Kind::Line && join.line.starts_with(item_.name + ".");
    if (!line || (join.line != item_.name && !whole) || join.kind == "free edge") continue;
    QString continuity = shown((whole ? join.line + ": " : "") + join.kind);
    if (join.requested) continuity = text(kRequested).arg(continuity);
    const double angle = join.kind == "G0" ? join.max_deg : join.max_inside_deg;
    entries << text(kAngleOfNormals).arg(continuity, shown(format_number(angle)));
    if (!join.why.empty()) entries << shown(join.why);
    const auto edits = [this, line = join.line](std::optional<std::string> chosen) {
      return join_edits(SceneText(view_->text), line, chosen);
    };
    if (whole) continue;  // segments are edited one by one: a click selects one
    add_button(kCrease, [edits] { return edits("G0"); });
    add_button(kSmooth, [edits] { return edits("smooth"); });
    add_button(kAutomatic, [edits] { return edits({}); });
  }
  description_->setText(entries.join("\n"));
}

void PropertyPanel::fill_line() {
  const bool line = item_.kind == Kind::Line || item_.kind == Kind::Join;
  const std::string name = defining_line(SceneText(view_->text), item_.name);
  if (view_->mesh || !line || name.empty()) return;
  const auto fair = [this, name](const std::string& more) {
    return std::vector<DocumentCommand>{
        {.kind = CommandKind::Add,
         .table = {"fair", ""},
         .text = "{ name = " + SceneText::toml_value(view_->free_name("fair")) + ", curves = [" +
                 SceneText::toml_value(name) + "]" + more + " }"}};
  };
  add_button(kFair, [fair] { return fair(""); });
  const std::vector<Vec3> points = defining_points(SceneText(view_->text), name);
  if (points.empty()) return;
  add_button(kFairLocally, [this, fair, points] {
    const int point = selection_.point();
    if (point < 0) return std::vector<DocumentCommand>{};
    // Radius: up to the adjacent points.
    double radius = 0;
    const Vec3& p = points[static_cast<size_t>(point)];
    for (int i = std::max(0, point - 1); i <= point + 1 && i < static_cast<int>(points.size()); ++i)
      radius = std::max(radius, (points[static_cast<size_t>(i)] - p).norm());
    const std::string size = SceneText::toml_value(std::stod(format_number(radius)));
    return fair(", brush = { at = " + SceneText::toml_value(p) + ", radius = " + size +
                " }, wavelength = " + size);
  });
  if (!tangent_edits(SceneText(view_->text), name).empty())
    add_button(kEditTangents, [this, name] { return tangent_edits(SceneText(view_->text), name); });
  add_button(kSplit, [this, name] { return split_edits(*view_, name, selection_.point()); });
  add_button(kJoinNext, [this, name] {
    return join_line_edits(*view_, name);
  })->setToolTip(text(kJoinNextTip));
  for (int axis = 0; axis < 3; ++axis)
    add_button(kMirrors[axis], [this, name, axis] { return mirror_edits(*view_, name, axis); });
}

void PropertyPanel::fill_stress() {
  if (!view_->surface || view_->mesh) return;
  const std::string name = item_.name;
  if (item_.kind == Kind::Line || item_.kind == Kind::Join) {
    const std::string now = support_of(SceneText(view_->text), name);
    const auto support = [&](const char* what, const char* kind) {
      add_button(what,
                 [this, name, kind] { return support_edits(SceneText(view_->text), name, kind); });
      button(what)->setEnabled(now != kind);  // disabled, not hidden: positions stay the same
    };
    support(kClampEdge, "clamped");
    support(kPinEdge, "pinned");
    button(kPinEdge)->setToolTip(text(kPinEdgeTip));
    support(kRemoveSupport, "");
  }
  if (item_.kind != Kind::Region) return;
  add_button(kInflate, [this, name] {
    return std::vector<DocumentCommand>{
        {.kind = CommandKind::Add,
         .table = {"load", ""},
         .text = "{ name = " + SceneText::toml_value(view_->free_name("pressure")) +
                 ", type = \"pressure\", faces = [" + SceneText::toml_value(name) +
                 "], value = 0 }"},
        {.kind = CommandKind::SolveToEquilibrium}};  // a step of its own
  })->setToolTip(text(kInflateTip));
  if (!view_->has_stress) return;
  add_button(kAddPressure, [this, name] {
    return stress_load_edits(SceneText(view_->text),
                             "{ pressure = 0.001, face = " + SceneText::toml_value(name) + " }");
  });
  // A unit force against the normal, at the point of the surface that was clicked.
  add_button(kAddPointForce, [this]() -> std::vector<DocumentCommand> {
    const auto surface_point = selection_.surface_point();
    if (!surface_point) return {};
    return stress_load_edits(
        SceneText(view_->text),
        "{ point = " + SceneText::toml_value(rounded_point(surface_point->present, view_->size)) +
            ", force = " + SceneText::toml_value(rounded_point(-surface_point->normal, 1)) + " }");
  });
  add_button(kAddGravity, [this] {
    const bool metres = view_->unit == "m";
    return stress_load_edits(SceneText(view_->text), std::string("{ gravity = [0, 0, ") +
                                                         (metres ? "-9.81" : "-9810") + "] }");
  });
}

void PropertyPanel::fill_mesh() {
  if (!view_->mesh) return;
  const std::string part = item_.name;
  const SceneText scene(view_->text);
  if (view_->timeline) {
    if (item_.kind == Kind::Part && !scene.has({"handle", part}))
      add_button(kPartUses[static_cast<int>(PartUse::Handle)],
                 [this, part] { return sequence_handle_edits(SceneText(view_->text), part); });
    return;
  }
  if (item_.kind == Kind::Part) {
    const PartUse now = use_of(scene, part);
    for (const PartUse use : {PartUse::Rigid, PartUse::TranslationOnly, PartUse::Handle,
                              PartUse::Fixed, PartUse::Interest, PartUse::Free})
      if (use != now)
        add_button(kPartUses[static_cast<int>(use)], [this, part, use] {
          return use_edits(SceneText(view_->text), *view_->mesh, part, use);
        });
    if (part.starts_with("hole-") && now == PartUse::Free) add_keep_all_button();
    if (now != PartUse::Free) description_->setText(text(kPartUseLabels[static_cast<int>(now)]));
  }
  if (item_.kind == Kind::Parts) add_keep_all_button();
  if (item_.kind == Kind::Table && item_.table.kind == "edit")
    add_button(kNewEdit, [this] {
      const std::string fixed = SceneText(view_->text).value(item_.table, "fixed");
      return std::vector<DocumentCommand>{
          {.kind = CommandKind::Add,
           .table = {"edit", ""},
           .text = "{ name = " + SceneText::toml_value(view_->free_name("edit")) +
                   (fixed.empty() ? "" : ", fixed = " + fixed) + " }"}};
    });
}

void PropertyPanel::add_keep_all_button() {
  add_button(kKeepAll, [] {
    return std::vector<DocumentCommand>{
        {.kind = CommandKind::Add, .table = {"features", ""}, .text = "{ of = [\"hole-*\"] }"}};
  });
}

QPushButton* PropertyPanel::add_button(const char* what,
                                       std::function<std::vector<DocumentCommand>()> edits) {
  auto* button = new QPushButton(text(what));
  button->setObjectName(what);
  auto* grid = static_cast<QGridLayout*>(buttons_->layout());
  const int number = grid->count();
  grid->addWidget(button, number / 2, number % 2);
  QObject::connect(button, &QPushButton::clicked, this, [this, edits] {
    for (DocumentCommand& command : edits()) post_(std::move(command));
  });
  return button;
}

QPushButton* PropertyPanel::button(const char* what) const {
  return buttons_->findChild<QPushButton*>(what);
}

namespace {

struct KeyValues {
  // Separated by blanks; kinds "": top level of the scene, "*": any.
  const char *kinds, *key, *values;
};

constexpr KeyValues kKeyValues[] = {
    {"", "unit", "mm cm m in ft"},
    {"curve curves", "role", "outline hole inner"},
    {"curve curves", "alignment", "auto aligned embedded"},
    {"face", "domain", "auto polygon projected developable"},
    {"join", "continuity", "G0 G1 smooth"},
    {"stiffness", "type", "alpha beta"},
    {"mesh", "domain", "auto polygon projected developable annulus"},
    {"mesh", "mesher", "delaunay fan"},
    {"mesh", "element", "hct z12"},
    {"skin", "load_units", "relative absolute"},
    {"skin", "boundary", "curves corners"},
    {"skin", "fair", "auto bending variation loft"},
    {"skin", "noisy_curves", "fair keep"},
    {"skin", "symmetry", "x y z"},
    {"fair", "minimize", "bending variation"},
    {"feature features", "keep", "shape orientation"},
    {"output", "step_form", "auto face exact"},
};

}  // namespace

QStringList enum_values(const SceneTable& table, const std::string& key, const std::string& value,
                        bool faired) {
  if (value == "true" || value == "false") return {"true", "false"};
  for (const KeyValues& one : kKeyValues) {
    const QStringList kinds = QString(one.kinds).split(' ');
    if (key != one.key || !kinds.contains(QString::fromStdString(table.kind))) continue;
    const bool more = faired && table.kind == "join";
    QStringList values;
    for (const QString& word : (one.values + QString(more ? " G2" : "")).split(' '))
      values << '"' + word + '"';
    const QString now = QString::fromStdString(value);
    return values.contains(now) ? values : QStringList{};
  }
  return {};
}

}  // namespace batten::studio
