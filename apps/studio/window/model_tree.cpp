// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/window/model_tree.h"

#include <QHeaderView>
#include <QScrollBar>
#include <QStyle>
#include <algorithm>

#include "batten/apps/documents/load_edits.h"
#include "batten/apps/documents/mesh_edits.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

using Kind = ModelTree::Item::Kind;

/// The value of a key of a table, without quotes; empty: the table does not have it.
std::string plain(const DocumentView::Table& table, const char* key) {
  for (const auto& [name, value] : table.values)
    if (name == key)
      return value.size() > 1 && value.front() == '"' ? value.substr(1, value.size() - 2) : value;
  return "";
}

bool acts(const std::string& kind) {
  return kind == "load" || kind == "stiffness" || kind == "constraint" || kind == "offset" ||
         kind == "parameter";
}

/// True for tables that have a group of their own if the document is a mesh.
bool is_of_mesh(const std::string& kind) {
  constexpr const char* kinds[] = {"select",   "cut",        "feature",
                                   "features", "constraint", "relation",
                                   "chain",    "curve",      "position_constraint",
                                   "edit",     "handle",     "operation"};
  return std::find(std::begin(kinds), std::end(kinds), kind.substr(0, kind.find('.'))) !=
         std::end(kinds);
}

constexpr int kWidth = 280;  // fits two adjacent buttons in the panel below

/// The domain of a face for display.
std::string domain_label(const std::string& domain) {
  return domain == "polygon" ? "n-sided" : domain == "annulus" ? "annular" : domain;
}

/// The kind of a table for display, such as "position constraint".
QString kind_label(const std::string& kind) {
  return shown(kind.substr(kind.find('.') + 1)).replace('_', ' ');
}

/// The type of a load, constraint or stiffness field for display.
QString type_label(const DocumentView::Table& table) {
  const std::string& kind = table.name.kind;
  const std::string type = plain(table, "type");
  if (kind == "stiffness") return text(type == "alpha" ? kMembrane : kBending);
  return kind_label(type.empty() ? kind : type);
}

QString degrees(double value) { return QString::number(value, 'g', 2) + "°"; }

}  // namespace

ModelTree::ModelTree(QWidget* parent, std::function<void(const Item&)> on_selected)
    : QTreeWidget(parent), on_selected_(std::move(on_selected)) {
  setColumnCount(2);
  setHeaderHidden(true);
  setUniformRowHeights(true);
  header()->setSectionResizeMode(0, QHeaderView::ResizeToContents);
  setMinimumWidth(kWidth);
  QObject::connect(this, &QTreeWidget::currentItemChanged, this, [this](QTreeWidgetItem* item) {
    if (!filling_ && item) on_selected_(current());
  });
}

QTreeWidgetItem* ModelTree::group(const char* title, int count) {
  auto* item = new QTreeWidgetItem(this, {text(title), QString::number(count)});
  QFont bold = item->font(0);
  bold.setBold(true);
  item->setFont(0, bold);
  item->setData(0, Qt::UserRole, -1);
  return item;
}

void ModelTree::add(QTreeWidgetItem* group, const QString& name, const QString& detail, Item item,
                    const QString& wrong) {
  auto* row = new QTreeWidgetItem(group, {name, detail});
  row->setData(0, Qt::UserRole, static_cast<int>(items_.size()));
  items_.push_back(std::move(item));
  if (wrong.isEmpty()) return;
  row->setIcon(0, style()->standardIcon(QStyle::SP_MessageBoxWarning));
  row->setToolTip(0, wrong);
  row->setToolTip(1, wrong);
}

void ModelTree::refresh(const DocumentView& view) {
  const Item before = current();
  const bool other = document_number_ != view.document_number;
  document_number_ = view.document_number;
  filling_ = true;
  const int scrolled = verticalScrollBar()->value();
  for (int i = 0; i < topLevelItemCount(); ++i)
    open_[topLevelItem(i)->text(0)] = topLevelItem(i)->isExpanded();
  if (other) open_.clear();
  clear();
  items_.clear();
  view.mesh ? fill_mesh(view) : fill_shape(view);
  fill_tables(view);
  constexpr int few = 12;
  for (int i = 0; i < topLevelItemCount(); ++i) {
    QTreeWidgetItem* item = topLevelItem(i);
    const bool usual = i + 1 < topLevelItemCount() && item->childCount() <= few;
    item->setExpanded(open_.value(item->text(0), usual));
  }
  restore_selection(other ? Item{} : before);
  verticalScrollBar()->setValue(other ? 0 : scrolled);
  filling_ = false;
  // Select the most frequently used entry of a mesh.
  if (other && view.mesh && !view.timeline) select(Kind::Parts, "");
}

// Restores the selection after the tree has been rebuilt.
void ModelTree::restore_selection(const Item& before) {
  if (before.kind == Kind::Table || before.kind == Kind::StressPart) {
    for (QTreeWidgetItemIterator it(this); *it; ++it) {
      const int number = (*it)->data(0, Qt::UserRole).toInt();
      if (number < 0) continue;
      const Item& item = items_[static_cast<size_t>(number)];
      if (item.kind == before.kind && item.table == before.table && item.number == before.number)
        setCurrentItem(*it);
    }
  } else if (before.kind != Kind::None) {
    select(before.kind, before.name);
  }
}

void ModelTree::fill_shape(const DocumentView& view) {
  auto* lines = group(kCurves, static_cast<int>(view.lines.size()));
  for (const auto& line : view.lines) {
    const SceneTable table{"curve", line.line};
    add(lines, shown(line.line), "",
        {Kind::Line, line.line, view.table(table) ? table : SceneTable{}});
  }
  auto* surfaces = group(kFaces, static_cast<int>(view.regions.size()));
  if (view.network)
    for (const auto& region : view.network->regions) {
      QStringList wrong;
      if (!region.rejection_reason.empty()) wrong << shown(region.rejection_reason);
      for (const std::string& defect : region.defects) wrong << shown(defect);
      const SceneTable table{"face", region.name};
      add(surfaces, shown(region.name),
          shown(region.shape.empty() ? domain_label(region.domain) : region.shape),
          {Kind::Region, region.name, view.table(table) ? table : SceneTable{}}, wrong.join("\n"));
    }
  else
    for (const std::string& region : view.regions)
      add(surfaces, shown(region), "", {Kind::Region, region, {}});
  if (view.network) {
    auto* joins = group(kEdges, static_cast<int>(view.network->joins.size()));
    for (const auto& join : view.network->joins) {
      QString detail = shown(join.kind);
      if (join.kind == "smooth") detail += " " + degrees(join.max_inside_deg);
      if (join.kind == "G0") detail += " " + degrees(join.max_deg);
      add(joins, shown(join.line), detail, {Kind::Join, join.line, {}}, shown(join.why));
    }
    if (!view.network->ambiguous_regions.empty()) {
      auto* ambiguous_regions =
          group(kAlternatives, static_cast<int>(view.network->ambiguous_regions.size()));
      int number = 0;
      for (const auto& choice : view.network->ambiguous_regions) {
        Item item{Kind::Alternative, "", {}, number};
        add(ambiguous_regions, shown(choice.text), "", std::move(item));
        ambiguous_regions->child(number++)->setToolTip(0, shown(choice.text));
      }
    }
  }
}

void ModelTree::fill_mesh(const DocumentView& view) {
  const SceneText scene(view.text);
  auto* proposals = group(kHolesAndCreases, 0);
  auto* selections = group(kSelections, 0);
  proposals->setData(0, Qt::UserRole, static_cast<int>(items_.size()));
  items_.push_back({Item::Kind::Parts, "", {}});
  for (const MeshView::Part& part : view.mesh->parts) {
    const bool proposal = part.kind == MeshView::Part::Kind::Proposal;
    const SceneTable table{"select", part.name};
    const char* use = kPartUseLabels[static_cast<int>(use_of(scene, part.name))];
    QString detail = *use       ? text(use)
                     : proposal ? "⌀ " + QString::number(part.diameter, 'g', 3)
                                : QString();
    const bool set = part.kind == MeshView::Part::Kind::Set;
    const QString name = shown(set ? part.key + " " + part.name : part.name);
    add(proposal ? proposals : selections, name, detail,
        {Item::Kind::Part, part.name, view.table(table) ? table : SceneTable{}});
  }
  auto* kept = group(kFeaturesAndConstraints, 0);
  auto* edits = group(view.timeline ? kOperations : kEdits, 0);
  for (const auto& table : view.tables) {
    const std::string& kind = table.name.kind;
    if (!is_of_mesh(kind) || kind == "select" || kind == "operation.keyframe.handle") continue;
    const bool edit = kind.starts_with("edit") || kind.starts_with("operation");
    QString name = shown(table.name.name);
    if (kind == "edit.handle") name = "    " + shown(plain(table, "name"));
    if (kind == "operation.keyframe") name = "    " + shown(plain(table, "frame"));
    if (kind == "features") name = shown(plain(table, "of"));
    add(edit ? edits : kept, name, kind_label(kind),
        {Item::Kind::Table, table.name.name, table.name});
  }
  for (QTreeWidgetItem* one : {proposals, selections, kept, edits})
    one->setText(1, QString::number(one->childCount()));
}

void ModelTree::fill_tables(const DocumentView& view) {
  auto* acting = view.mesh ? nullptr : group(kLoadsAndConstraints, 0);
  auto* scene = group(kScene, 0);
  for (const auto& table : view.tables) {
    const std::string& kind = table.name.kind;
    const bool shape = kind == "curve" || (kind == "face" && !table.name.name.empty());
    const bool part = kind == "stress.supports" || kind == "stress.loads";
    if (view.mesh ? is_of_mesh(kind) : shape || (kind.find('.') != std::string::npos && !part))
      continue;
    const bool act = acting && (acts(kind) || part);
    const QString name =
        kind.empty() ? shown(view.title) : shown(table.name.name.empty() ? kind : table.name.name);
    add(act ? acting : scene, name,
        act ? type_label(table) : shown(kind == table.name.name ? "" : kind),
        {Kind::Table, table.name.name, table.name});
  }
  // Options can be added to tables that do not exist yet.
  for (const char* kind : {"skin", "mesh"}) {
    const SceneTable options{kind, ""};
    if (!view.mesh && view.surface && !view.table(options))
      add(scene, kind, "", {Kind::Table, "", options});
  }
  int number = 0;
  if (acting)
    for (const StressPart& part : stress_parts(SceneText(view.text)))
      add(acting, part.of.empty() ? kind_label(part.kind) : shown(part.of),
          part.of.empty() ? "stress" : kind_label(part.kind),
          {Kind::StressPart, part.of, {"stress", ""}, number++});
  if (acting) acting->setText(1, QString::number(acting->childCount()));
  scene->setText(1, "");
}

void ModelTree::select(Item::Kind kind, const std::string& name) {
  for (QTreeWidgetItemIterator it(this); *it; ++it) {
    const int number = (*it)->data(0, Qt::UserRole).toInt();
    if (number < 0) continue;
    const Item& item = items_[static_cast<size_t>(number)];
    if (item.kind != kind || item.name != name) continue;
    setCurrentItem(*it);
    scrollToItem(*it);
    return;
  }
}

void ModelTree::select_line(const std::string& line) {
  const Item before = current();
  select(Item::Kind::Line, line);
  if (current().kind != Kind::Line || current().name != line) select(Kind::Join, line);
  if (current().name == before.name && current().kind == before.kind) on_selected_(current());
}

void ModelTree::select_region(const std::string& region) {
  const Item before = current();
  select(Item::Kind::Region, region);
  if (current().name != region) select(Item::Kind::Part, region);
  if (current().name != region) select(Item::Kind::Table, region);
  if (current().name == before.name && current().kind == before.kind) on_selected_(current());
}

void ModelTree::clear_selection() {
  setCurrentItem(nullptr);
  on_selected_({});
}

ModelTree::Item ModelTree::current() const {
  const QTreeWidgetItem* item = currentItem();
  const int number = item ? item->data(0, Qt::UserRole).toInt() : -1;
  return number >= 0 && static_cast<size_t>(number) < items_.size()
             ? items_[static_cast<size_t>(number)]
             : Item{};
}

}  // namespace batten::studio
