#include "batten/apps/studio/window/chosen_panel.h"

#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>

#include "batten/apps/commands/documents/mesh_edits.h"
#include "batten/apps/commands/documents/word_edits.h"
#include "batten/apps/studio/view/texts.h"

namespace batten::studio {
namespace {

using Verb = DocumentCommand::Verb;
using Kind = ModelTree::Item::Kind;

}  // namespace

ChosenPanel::ChosenPanel(QWidget* parent, std::function<void(DocumentCommand)> post)
    : QWidget(parent),
      post_(std::move(post)),
      title_(new QLabel),
      words_(new QLabel),
      buttons_(new QWidget),
      keys_(new QTableWidget(0, 2)) {
  auto* column = new QVBoxLayout(this);
  QFont bold = title_->font();
  bold.setBold(true);
  title_->setFont(bold);
  words_->setWordWrap(true);
  new QVBoxLayout(buttons_);
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
    if (filling_) return;
    post_({.verb = Verb::Set,
           .table = item_.table,
           .key = keys_->item(row, 0)->text().toStdString(),
           .text = keys_->item(row, 1)->text().toStdString()});
  });
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
  words_->setVisible(!words_->text().isEmpty());
}

void ChosenPanel::fill_table() {
  filling_ = true;
  keys_->setRowCount(0);
  const bool stated = item_.kind == Kind::Table || item_.table.kind != "";
  const DocumentView::Table* table = stated ? view_->table(item_.table) : nullptr;
  if (table)
    for (const auto& [key, value] : table->values) {
      const int row = keys_->rowCount();
      keys_->insertRow(row);
      auto* name = new QTableWidgetItem(shown(key));
      name->setFlags(name->flags() & ~Qt::ItemIsEditable);
      keys_->setItem(row, 0, name);
      keys_->setItem(row, 1, new QTableWidgetItem(shown(value)));
    }
  keys_->setVisible(keys_->rowCount() > 0);
  filling_ = false;
}

void ChosenPanel::fill_words() {
  if (!view_->network) return;
  const NetworkReport& network = *view_->network;
  QStringList words;
  if (item_.kind == Kind::Choice && item_.choice < static_cast<int>(network.choices.size())) {
    const auto choice = network.choices[static_cast<size_t>(item_.choice)];
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
    const bool this_line = item_.kind == Kind::Join || item_.kind == Kind::Line;
    if (!this_line || join.line != item_.name || join.kind == "rim") continue;
    words << shown(join.kind + (join.asked ? " (asked for)" : "") +
                   ": the normals differ by up to " +
                   number(join.kind == "crease" ? join.max_deg : join.max_inside_deg) + "°");
    if (!join.why.empty()) words << shown(join.why);
    const auto edits = [this, line = join.line](std::optional<std::string> kind) {
      return join_edits(SceneText(view_->text), line, kind);
    };
    add_button(kCrease, [edits] { return edits("crease"); });
    add_button(kSmooth, [edits] { return edits("smooth"); });
    add_button(kAsFound, [edits] { return edits({}); });
  }
  words_->setText(words.join("\n"));
}

void ChosenPanel::fill_mesh() {
  if (!view_->mesh) return;
  const std::string part = item_.name;
  const SceneText scene(view_->text);
  if (item_.kind == Kind::Part) {
    const PartUse now = use_of(scene, part);
    for (const PartUse use :
         {PartUse::Rigid, PartUse::KeepsDirection, PartUse::Handle, PartUse::Fixed, PartUse::Free})
      if (use != now)
        add_button(kUses[static_cast<int>(use)], [this, part, use] {
          return use_edits(SceneText(view_->text), *view_->mesh, part, use);
        });
    if (now != PartUse::Free) words_->setText(text(kUsed[static_cast<int>(now)]));
  }
  if (item_.kind == Kind::Parts)
    add_button(kKeepAll, [] {
      return std::vector<DocumentCommand>{
          {.verb = Verb::Add, .table = {"features", ""}, .text = "{ of = [\"hole-*\"] }"}};
    });
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

void ChosenPanel::add_button(const char* what,
                             std::function<std::vector<DocumentCommand>()> edits) {
  auto* button = new QPushButton(text(what));
  button->setObjectName(what);
  buttons_->layout()->addWidget(button);
  QObject::connect(button, &QPushButton::clicked, this, [this, edits] {
    for (DocumentCommand& command : edits()) post_(std::move(command));
  });
}

QPushButton* ChosenPanel::button(const char* what) const {
  return buttons_->findChild<QPushButton*>(what);
}

}  // namespace batten::studio
