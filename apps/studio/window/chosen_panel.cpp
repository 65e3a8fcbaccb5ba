#include "batten/apps/studio/window/chosen_panel.h"

#include <QComboBox>
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/documents/mesh_edits.h"
#include "batten/apps/commands/documents/sequence_edits.h"
#include "batten/apps/commands/documents/word_edits.h"
#include "batten/apps/studio/view/texts.h"
#include "batten/apps/studio/window/key_words.h"

namespace batten::studio {
namespace {

using Verb = DocumentCommand::Verb;
using Kind = ModelTree::Item::Kind;

/// What was typed as a value of TOML: words that are none are meant as a text.
std::string as_value(const std::string& typed) {
  try {
    SceneText("key = " + typed);
    return typed;
  } catch (const Error&) {
    return SceneText::word(typed);
  }
}

}  // namespace

ChosenPanel::ChosenPanel(QWidget* parent, std::function<void(DocumentCommand)> post, Hand hand)
    : QWidget(parent),
      post_(std::move(post)),
      hand_(std::move(hand)),
      title_(new QLabel),
      words_(new QLabel),
      buttons_(new QWidget),
      keys_(new QTableWidget(0, 2)) {
  auto* column = new QVBoxLayout(this);
  QFont bold = title_->font();
  bold.setBold(true);
  title_->setFont(bold);
  words_->setWordWrap(true);
  words_->setSizePolicy(QSizePolicy::Ignored,
                        QSizePolicy::Preferred);  // long words keep no panel wide
  title_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  new QGridLayout(buttons_);
  buttons_->layout()->setContentsMargins(0, 0, 0, 0);
  keys_->setHorizontalHeaderLabels({text(kKey), text(kValue)});
  keys_->verticalHeader()->hide();
  keys_->horizontalHeader()->setStretchLastSection(true);
  column->addWidget(title_);
  column->addWidget(words_);
  column->addWidget(buttons_);
  column->addWidget(keys_, 8);
  column->addStretch(1);
  QObject::connect(keys_, &QTableWidget::cellChanged, this, [this](int row, int) {
    if (!filling_) state(row);
  });
}

// The scene states what stands in a row; of a new one when both cells are filled.
void ChosenPanel::state(int row) {
  const std::string key = keys_->item(row, 0)->text().trimmed().toStdString();
  const std::string typed = keys_->item(row, 1)->text().trimmed().toStdString();
  if (key.empty() || key == text(kNewKey).toStdString()) return;
  if (typed.empty()) {  // what comes next is its value
    keys_->setCurrentCell(row, 1);
    return keys_->editItem(keys_->item(row, 1));
  }
  const std::string value = as_value(typed);
  if (const auto part = chosen_stress()) {
    for (DocumentCommand& edit : stress_part_edits(SceneText(view_->text), *part, key, value))
      post_(std::move(edit));
    return;
  }
  post_({.verb = Verb::Set, .table = item_.table, .key = key, .text = value});
}

std::optional<StressPart> ChosenPanel::chosen_stress() const {
  if (item_.kind != Kind::StressPart) return std::nullopt;
  const std::vector<StressPart> parts = stress_parts(SceneText(view_->text));
  const auto number = static_cast<size_t>(item_.number);
  return number < parts.size() ? std::optional(parts[number]) : std::nullopt;
}

void ChosenPanel::take(std::shared_ptr<const DocumentView> view, const ModelTree::Item& item) {
  view_ = std::move(view);
  item_ = item;
  for (QPushButton* old : buttons_->findChildren<QPushButton*>()) delete old;
  title_->setText(shown(item.name.empty() ? item.table.kind : item.name));
  words_->clear();
  fill_table();
  fill_words();
  fill_mesh();
  fill_line();
  fill_stress();
  words_->setVisible(!words_->text().isEmpty());
}

void ChosenPanel::fill_table() {
  filling_ = true;
  keys_->setRowCount(0);
  const bool stated = item_.kind == Kind::Table || item_.table.kind != "";
  const DocumentView::Table* table = stated ? view_->table(item_.table) : nullptr;
  const std::optional<StressPart> part = chosen_stress();
  const std::vector<SceneText::Value> none;
  for (const auto& [key, value] : part ? part->values : table ? table->values : none)
    add_key(key, value);
  if (part || table) add_key(text(kNewKey).toStdString(), "");
  keys_->setVisible(keys_->rowCount() > 0);
  filling_ = false;
}

// A key that has a few words gets a list of them. The last one is for a hand to type another one.
void ChosenPanel::add_key(const std::string& key, const std::string& value) {
  const int row = keys_->rowCount();
  keys_->insertRow(row);
  auto* name = new QTableWidgetItem(shown(key));
  if (key == text(kNewKey).toStdString())
    name->setForeground(palette().brush(QPalette::Disabled, QPalette::Text));
  else
    name->setFlags(name->flags() & ~Qt::ItemIsEditable);
  keys_->setItem(row, 0, name);
  keys_->setItem(row, 1, new QTableWidgetItem(shown(value)));
  const DocumentView::Table* skin = view_->table({"skin", ""});
  const bool faired =
      skin && std::find(skin->values.begin(), skin->values.end(),
                        SceneText::Value("fair", "\"variation\"")) != skin->values.end();
  const QStringList words = words_of_key(item_.table, key, value, faired);
  if (words.isEmpty()) return;
  auto* list = new QComboBox;
  list->addItems(words);
  list->setCurrentText(shown(value));
  quiet_.quieten(list);
  QObject::connect(list, QOverload<int>::of(&QComboBox::activated), this,
                   [this, list, row] { keys_->item(row, 1)->setText(list->currentText()); });
  keys_->setCellWidget(row, 1, list);
}

void ChosenPanel::fill_words() {
  if (!view_->network) return;
  const NetworkReport& network = *view_->network;
  QStringList words;
  if (item_.kind == Kind::Choice && item_.number < static_cast<int>(network.choices.size())) {
    const auto choice = network.choices[static_cast<size_t>(item_.number)];
    words << shown(choice.text);
    for (int i = 0; i < static_cast<int>(choice.alternatives.size()); ++i)
      add_button(kTakeInstead, [choice, i] { return choice_edits(choice, i); });
  }
  for (const auto& region : network.regions) {
    if (item_.kind != Kind::Region || region.name != item_.name) continue;
    if (!region.why_not.empty()) words << shown(region.why_not);
    for (const std::string& flaw : region.flaws) words << shown(flaw);
    for (const std::string& warning : region.warnings) words << shown(warning);
  }
  for (const auto& join : network.joins) {
    const bool line = item_.kind == Kind::Join || item_.kind == Kind::Line;
    const bool whole = item_.kind == Kind::Line && join.line.starts_with(item_.name + ".");
    if (!line || (join.line != item_.name && !whole) || join.kind == "rim") continue;
    words << shown((whole ? join.line + ": " : "") + join.kind +
                   (join.asked ? " (asked for)" : "") + ": the normals differ by up to " +
                   number(join.kind == "crease" ? join.max_deg : join.max_inside_deg) + "°");
    if (!join.why.empty()) words << shown(join.why);
    const auto edits = [this, line = join.line](std::optional<std::string> kind) {
      return join_edits(SceneText(view_->text), line, kind);
    };
    if (whole) continue;  // each piece by itself: a click on it chooses it
    add_button(kCrease, [edits] { return edits("crease"); });
    add_button(kSmooth, [edits] { return edits("smooth"); });
    add_button(kAsFound, [edits] { return edits({}); });
  }
  words_->setText(words.join("\n"));
}

void ChosenPanel::fill_line() {
  const bool line = item_.kind == Kind::Line || item_.kind == Kind::Join;
  const std::string name = stated_line(SceneText(view_->text), item_.name);
  if (view_->mesh || !line || name.empty()) return;
  const auto fair = [this, name](const std::string& more) {
    return std::vector<DocumentCommand>{
        {.verb = Verb::Add,
         .table = {"fair", ""},
         .text = "{ name = " + SceneText::word(view_->free_name("fair")) + ", lines = [" +
                 SceneText::word(name) + "]" + more + " }"}};
  };
  add_button(kFair, [fair] { return fair(""); });
  const std::vector<Vec3> points = stated_points(SceneText(view_->text), name);
  if (points.empty()) return;
  add_button(kFairHere, [this, fair, points] {
    const int point = hand_.point();
    if (point < 0) return std::vector<DocumentCommand>{};
    // As far as the points beside it.
    double radius = 0;
    const Vec3& p = points[static_cast<size_t>(point)];
    for (int i = std::max(0, point - 1); i <= point + 1 && i < static_cast<int>(points.size()); ++i)
      radius = std::max(radius, (points[static_cast<size_t>(i)] - p).norm());
    const std::string size = SceneText::word(std::stod(number(radius)));
    return fair(", brush = { at = " + point_word(p) + ", radius = " + size +
                " }, wavelength = " + size);
  });
  if (!tangent_edits(SceneText(view_->text), name).empty())
    add_button(kTangents, [this, name] { return tangent_edits(SceneText(view_->text), name); });
  add_button(kSplit, [this, name] { return split_edits(*view_, name, hand_.point()); });
  add_button(kJoinLines, [this, name] { return join_line_edits(*view_, name); });
  for (int axis = 0; axis < 3; ++axis)
    add_button(kMirrors[axis], [this, name, axis] { return mirror_edits(*view_, name, axis); });
}

void ChosenPanel::fill_stress() {
  if (!view_->surface || view_->mesh) return;
  const std::string name = item_.name;
  if (item_.kind == Kind::Line || item_.kind == Kind::Join) {
    const std::string now = support_of(SceneText(view_->text), name);
    const auto support = [&](const char* what, const char* kind) {
      add_button(what,
                 [this, name, kind] { return support_edits(SceneText(view_->text), name, kind); });
      button(what)->setEnabled(now != kind);  // all stay in their places
    };
    support(kClamp, "clamped");
    support(kPin, "pinned");
    support(kNoSupport, "");
  }
  if (item_.kind != Kind::Region) return;
  add_button(kSwell, [this, name] {
    return std::vector<DocumentCommand>{
        {.verb = Verb::Add,
         .table = {"load", ""},
         .text = "{ name = " + SceneText::word(view_->free_name("swell")) +
                 ", type = \"pressure\", regions = [" + SceneText::word(name) + "], value = 0 }"},
        {.verb = Verb::Settle}};  // a step of its own
  });
  if (!view_->has_stress) return;
  add_button(kPressOn, [this, name] {
    return stress_load_edits(SceneText(view_->text),
                             "{ pressure = 0.001, region = " + SceneText::word(name) + " }");
  });
  // One unit of force against the normal, where the surface was clicked.
  add_button(kForceHere, [this]() -> std::vector<DocumentCommand> {
    const auto place = hand_.place();
    if (!place) return {};
    return stress_load_edits(SceneText(view_->text),
                             "{ point = " + point_word(rounded_point(place->present, view_->size)) +
                                 ", force = " + point_word(rounded_point(-place->normal, 1)) +
                                 " }");
  });
  add_button(kWeight, [this] {
    const bool metres = view_->unit == "m";
    return stress_load_edits(SceneText(view_->text), std::string("{ gravity = [0, 0, ") +
                                                         (metres ? "-9.81" : "-9810") + "] }");
  });
}

void ChosenPanel::fill_mesh() {
  if (!view_->mesh) return;
  const std::string part = item_.name;
  const SceneText scene(view_->text);
  if (view_->timeline) {
    if (item_.kind == Kind::Part && !scene.has({"handle", part}))
      add_button(kUses[static_cast<int>(PartUse::Handle)],
                 [this, part] { return sequence_handle_edits(SceneText(view_->text), part); });
    return;
  }
  if (item_.kind == Kind::Part) {
    const PartUse now = use_of(scene, part);
    for (const PartUse use : {PartUse::Rigid, PartUse::KeepsDirection, PartUse::Handle,
                              PartUse::Fixed, PartUse::Interest, PartUse::Free})
      if (use != now)
        add_button(kUses[static_cast<int>(use)], [this, part, use] {
          return use_edits(SceneText(view_->text), *view_->mesh, part, use);
        });
    if (part.starts_with("hole-") && now == PartUse::Free) add_keep_all();
    if (now != PartUse::Free) words_->setText(text(kUsed[static_cast<int>(now)]));
  }
  if (item_.kind == Kind::Parts) add_keep_all();
  if (item_.kind == Kind::Table && item_.table.kind == "edit")
    add_button(kNewEdit, [this] {
      const std::string fixed = SceneText(view_->text).value(item_.table, "fixed");
      return std::vector<DocumentCommand>{
          {.verb = Verb::Add,
           .table = {"edit", ""},
           .text = "{ name = " + SceneText::word(view_->free_name("edit")) +
                   (fixed.empty() ? "" : ", fixed = " + fixed) + " }"}};
    });
}

void ChosenPanel::add_keep_all() {
  add_button(kKeepAll, [] {
    return std::vector<DocumentCommand>{
        {.verb = Verb::Add, .table = {"features", ""}, .text = "{ of = [\"hole-*\"] }"}};
  });
}

void ChosenPanel::add_button(const char* what,
                             std::function<std::vector<DocumentCommand>()> edits) {
  auto* button = new QPushButton(text(what));
  button->setObjectName(what);
  auto* grid = static_cast<QGridLayout*>(buttons_->layout());
  const int number = grid->count();
  grid->addWidget(button, number / 2, number % 2);
  QObject::connect(button, &QPushButton::clicked, this, [this, edits] {
    for (DocumentCommand& command : edits()) post_(std::move(command));
  });
}

QPushButton* ChosenPanel::button(const char* what) const {
  return buttons_->findChild<QPushButton*>(what);
}

}  // namespace batten::studio
