// Actions of the main window: opening, saving, exporting, and the check for unsaved changes.

#include <QAction>
#include <QActionGroup>
#include <QCloseEvent>
#include <QComboBox>
#include <QDir>
#include <QFile>
#include <QFileDialog>
#include <QFileInfo>
#include <QListWidget>
#include <QMenu>
#include <QMessageBox>
#include <QMimeData>
#include <QSettings>
#include <QStatusBar>
#include <QToolBar>
#include <algorithm>
#include <utility>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/apps/studio/window/main_window.h"

namespace batten::studio {
namespace {

using CommandKind = DocumentCommand::CommandKind;

/// The text of a menu entry as a title.
QString title(const char* menu) { return text(menu).remove('&'); }

/// File filter for the format of the input mesh.
QString original_format(const QString& ending) {
  constexpr std::pair<const char*, const char*> decks[] = {{"bdf nas dat", "Nastran deck"},
                                                           {"inp", "Abaqus deck"},
                                                           {"k key dyn", "LS-DYNA deck"},
                                                           {"rad", "Radioss deck"}};
  for (const auto& [endings, deck] : decks)
    if (QString(endings).split(' ').contains(ending.toLower()))
      return text(kOriginalFormat).arg(deck, "." + ending);
  return text(kOriginalMesh).arg("." + ending);
}

}  // namespace

void MainWindow::ask_open() {
  if (!may_close()) return;
  const QString file =
      QFileDialog::getOpenFileName(this, title(kOpen), in_folder(), text(kSceneFiles));
  if (!file.isEmpty()) open(file.toStdString());
}

void MainWindow::save(bool as) {
  // The example of the tour must not be overwritten: save it elsewhere.
  if (!as && !touring_ && shown_->title != "untitled") return post({.kind = CommandKind::Save});
  QString file = QFileDialog::getSaveFileName(this, title(kSaveAs), in_folder(stem() + ".toml"),
                                              text(kSavedFiles));
  if (file.isEmpty()) return;
  if (!file.endsWith(".toml")) file += ".toml";
  note_recent(file);
  post({.kind = CommandKind::Save, .file = file.toStdString()});
}

// Suggested name for output files, without extension.
QString MainWindow::stem() const {
  const std::string& name = shown_->title == "untitled" && !shown_->regions.empty() && shown_->mesh
                                ? shown_->regions.front()
                                : shown_->title;
  return QFileInfo(shown(name)).completeBaseName();
}

void MainWindow::ask_export() {
  QString filter;
  QString kinds = text(kExportFiles);
  if (shown_->mesh) {
    const QString ending = QFileInfo(shown(shown_->regions.front())).suffix();
    kinds = text(kMeshFiles);
    if (!shown_->timeline) kinds = original_format(ending) + ";;" + kinds;
  }
  QString file = QFileDialog::getSaveFileName(this, title(kExport), in_folder(stem() + "-out"),
                                              kinds, &filter);
  if (file.isEmpty()) return;
  const int star = filter.indexOf("*.");
  if (!file.contains('.') && star >= 0)
    file += filter.mid(star + 1, filter.indexOf(')') - star - 1);
  post({.kind = CommandKind::Export, .file = file.toStdString()});
}

void MainWindow::save_script() {
  const QString name =
      QFileDialog::getSaveFileName(this, title(kSaveScript), in_folder(), text(kScriptFiles));
  if (name.isEmpty()) return;
  QFile file(name);
  if (!file.open(QIODevice::WriteOnly)) {
    messages_->addItem(name + ": " + file.errorString());
    return;
  }
  for (const std::string& line : worker_->script()) file.write((line + "\n").c_str());
}

void MainWindow::remove_selected() {
  if (view_->remove_point()) return;
  ModelTree::Item item = tree_->current();
  if (item.kind == ModelTree::Item::Kind::Join)
    item.table = {"curve", defining_line(SceneText(shown_->text), item.name)};
  if (item.table.kind == "curve" && item.table.name.empty()) return;  // the curve comes from a file
  if (const auto part = properties_->selected_stress_part()) {
    for (DocumentCommand& edit : remove_stress_part(SceneText(shown_->text), *part))
      post(std::move(edit));
    return;
  }
  if (!item.table.kind.empty() && shown_->table(item.table))
    post({.kind = CommandKind::Remove, .table = item.table});
}

// A name in the folder of the scene that was opened or saved last, initially the home folder.
QString MainWindow::in_folder(const QString& name) const {
  const QString last = QSettings().value("recent").toStringList().value(0);
  const QDir folder(touring_ || last.isEmpty() ? QDir::homePath() : QFileInfo(last).path());
  return name.isEmpty() ? folder.path() : folder.filePath(name);
}

void MainWindow::note_recent(const QString& file) {
  QStringList files = QSettings().value("recent").toStringList();
  files.removeAll(file);
  files.prepend(file);
  while (files.size() > 10) files.removeLast();
  QSettings().setValue("recent", files);
  fill_recent();
}

void MainWindow::fill_recent() {
  recent_->clear();
  for (const QString& file : QSettings().value("recent").toStringList())
    QObject::connect(recent_->addAction(file), &QAction::triggered, this, [this, file] {
      if (may_close()) open(file.toStdString());
    });
  recent_->setEnabled(!recent_->isEmpty());
}

bool MainWindow::may_close() {
  if (!shown_->changed) return true;
  const auto answer = QMessageBox::question(
      this, text(kProgram), text(kUnsaved).arg(QString::fromStdString(shown_->title)),
      QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel,
      touring_ ? QMessageBox::Discard : QMessageBox::Save);
  if (answer == QMessageBox::Cancel) return false;
  if (answer == QMessageBox::Discard) return true;
  save(false);
  wait();
  return !shown_->changed;
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (!may_close()) return event->ignore();
  worker_->discard_changes();
  event->accept();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QString file = event->mimeData()->urls().value(0).toLocalFile();
  if (!file.isEmpty() && may_close()) open(file.toStdString());
}

// Tool bars, and the display of stresses, mode shapes and motion.

namespace {

constexpr int kModeLetters = 16;

Analysis analysis_of(Shading shading) {
  return shading == Shading::Stress  ? Analysis::Stress
         : shading == Shading::Modes ? Analysis::Modes
                                     : Analysis::None;
}

}  // namespace

void MainWindow::make_tools() {
  QToolBar* bar = addToolBar(text(kTools));
  bar->setObjectName(kTools);
  bar->setMovable(false);
  auto* group = new QActionGroup(this);
  const auto tool = [&](const char* what, const char* key, Tool which) {
    QAction* action = bar->addAction(text(what));
    action->setObjectName(what);
    action->setCheckable(true);
    action->setShortcut(QKeySequence(key));
    action->setToolTip(text(what) + " (" + key + ")");
    group->addAction(action);
    QObject::connect(action, &QAction::triggered, this, [this, which] {
      view_->set_tool(which);
      plane_bar_->setVisible(which == Tool::Draw);
      paint_bar_->setVisible(which == Tool::Paint && !shown_->mesh);
    });
    return action;
  };
  tool(kSelect, "S", Tool::Select)->setChecked(true);
  tool(kPush, "P", Tool::Push);
  tool(kFixPoint, "H", Tool::FixPoint);
  tool(kDraw, "D", Tool::Draw);
  tool(kMeasure, "K", Tool::Measure);
  tool(kPaint, "B", Tool::Paint);
  tool(kLasso, "L", Tool::Lasso);
  plane_ = new QComboBox;
  for (const char* plane : kPlanes) plane_->addItem(text(plane));
  QObject::connect(plane_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
                   [this](int index) { view_->set_plane(static_cast<DrawPlane>(index)); });
  plane_bar_ = bar->addWidget(plane_);
  plane_bar_->setVisible(false);
  paint_ = new QComboBox;
  for (const auto& [what, kind] : kPaints) paint_->addItem(text(what), kind);
  QObject::connect(
      paint_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
      [this](int index) { view_->set_paint(kPaints[static_cast<size_t>(index)].second); });
  paint_->setToolTip(text(kPaintTip));
  paint_bar_ = bar->addWidget(paint_);
  paint_bar_->setVisible(false);
  bar->addSeparator();
  bar->addAction(undo_);
  bar->addAction(redo_);
  bar->addSeparator();
  shading_ = new QComboBox;
  for (const char* shading : kShadings) shading_->addItem(text(shading));
  QObject::connect(shading_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
                   [this](int index) { set_shading_mode(static_cast<Shading>(index)); });
  bar->addWidget(shading_);
  modes_ = new QComboBox;
  for (QComboBox* list : {plane_, paint_, shading_, modes_}) input_filter_.watch(list);
  modes_->setMinimumContentsLength(kModeLetters);
  QObject::connect(modes_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
                   [this](int mode) { select_mode(mode); });
  modes_bar_ = bar->addWidget(modes_);
  modes_bar_->setVisible(false);
  bar->addSeparator();
  motion_ = bar->addAction(text(kSimulate));
  motion_->setObjectName(kSimulate);
  motion_->setCheckable(true);
  motion_->setShortcut(QKeySequence("T"));
  motion_->setToolTip(text(kSimulateTip));
  QObject::connect(motion_, &QAction::triggered, this, [this](bool on) { set_simulating(on); });
}

void MainWindow::set_shading_mode(Shading shading) {
  const Analysis what = analysis_of(shading);
  worker_->analyse(what);
  view_->set_shading(shading);
  view_->animate_mode(shading == Shading::Modes);
  modes_bar_->setVisible(shading == Shading::Modes);
  view_->set_text({});
  show_missing_stress();
  update_tour();
}

// Shows a hint if stresses are selected but the scene does not define [stress].
void MainWindow::show_missing_stress() {
  const auto shading = static_cast<Shading>(shading_->currentIndex());
  if (shown_->has_stress || analysis_of(shading) == Analysis::None) return;
  modes_->clear();
  view_->set_text(text(kNoStress));
}

void MainWindow::select_mode(int mode) {
  if (mode < 0) return;
  view_->set_mode(mode);
  view_->set_text(
      text(kModeLegend).arg(mode + 1).arg(modes_->itemData(mode).toDouble(), 0, 'g', 4));
}

// Updates the list of modes and keeps the selection.
void MainWindow::show_modes(const StressView& stress) {
  const int before = std::max(0, modes_->currentIndex());
  modes_->blockSignals(true);
  modes_->clear();
  for (size_t i = 0; i < stress.frequencies.size(); ++i)
    modes_->addItem(text(kModeOf).arg(i + 1).arg(stress.frequencies[i], 0, 'g', 4),
                    stress.frequencies[i]);
  modes_->setCurrentIndex(std::min(before, modes_->count() - 1));
  modes_->blockSignals(false);
  select_mode(modes_->currentIndex());
}

void MainWindow::update_tour() {
  if (!tour_) return;
  Tour::Observation observation;
  for (const auto& slider : shown_->sliders)
    if (slider.name == "swell") observation.swell = slider.value;
  using Mark = DocumentView::Mark;
  observation.pushes = static_cast<int>(
      std::count_if(shown_->marks.begin(), shown_->marks.end(),
                    [](const Mark& mark) { return mark.kind == Mark::Kind::Load; }));
  observation.can_redo = shown_->can_redo;
  observation.line_selected = tree_->current().kind == ModelTree::Item::Kind::Line;
  observation.shading = static_cast<Shading>(shading_->currentIndex());
  tour_->observe(observation);
}

void MainWindow::set_simulating(bool on) {
  worker_->set_simulating(on);
  motion_->setChecked(on);
  show_tools();
  view_->show_hint();
  if (on) statusBar()->showMessage(text(kHintSimulating));
}

void MainWindow::show_stress(const StressView& stress) {
  const auto digits = [](double value) { return QString::number(value, 'g', 3); };
  if (!stress.problem.empty()) return view_->set_text(shown(stress.problem));
  if (shading_->currentIndex() == static_cast<int>(Shading::Modes)) return show_modes(stress);
  QString overlay_text =
      text(kStressLegend)
          .arg(digits(stress.von_mises), stress_unit(shown_->unit), shown(stress.load_case),
               digits(stress.displacement), shown(shown_->unit))
          .arg(stress.deformation_scale);
  if (stress.yield > 0 && stress.von_mises > 0)
    overlay_text += text(kSafety).arg(digits(stress.yield / stress.von_mises));
  view_->set_text(overlay_text);
}

// Enables the tools that suit the document: surfaces can be pushed, fixed and drawn, meshes
// encircled.
void MainWindow::show_tools() {
  const bool mesh = shown_->mesh != nullptr, moves = motion_->isChecked();
  for (const char* what : {kPush, kFixPoint}) {
    QAction* tool = action(what);
    tool->setEnabled(!mesh && !moves);
    const QString key = " (" + tool->shortcut().toString() + ")";
    tool->setToolTip(moves ? text(kStopSimulationFirst).arg(text(what)) : text(what) + key);
  }
  action(kDraw)->setEnabled(!mesh || shown_->timeline);
  action(kLasso)->setEnabled(mesh);
  action(kPaint)->setEnabled(shown_->surface);
  motion_->setEnabled(moves || (shown_->surface && !mesh));
  for (const char* what : {kPush, kFixPoint, kDraw, kPaint, kLasso})
    if (action(what)->isChecked() && !action(what)->isEnabled()) action(kSelect)->trigger();
}

}  // namespace batten::studio
