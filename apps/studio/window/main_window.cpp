// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/window/main_window.h"

#include <QAction>
#include <QActionGroup>
#include <QApplication>
#include <QCloseEvent>
#include <QComboBox>
#include <QDir>
#include <QDockWidget>
#include <QFile>
#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QListWidget>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QPalette>
#include <QProgressBar>
#include <QPushButton>
#include <QSettings>
#include <QStatusBar>
#include <QToolBar>
#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/apps/documents/line_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"

namespace batten::studio {
// Light and dark theme of all widgets.

/// Applies Qt's Fusion style in light or dark colours.
inline void apply_theme(QApplication& application, bool dark) {
  application.setStyle("Fusion");
  QPalette palette;
  const auto set = [&](QPalette::ColorRole role, const char* light, const char* night) {
    palette.setColor(role, QColor(dark ? night : light));
  };
  set(QPalette::Window, "#f2f4f7", "#26292e");
  set(QPalette::WindowText, "#1d2127", "#e4e7ec");
  set(QPalette::Base, "#ffffff", "#1d2024");
  set(QPalette::AlternateBase, "#eef1f5", "#2b2f35");
  set(QPalette::Text, "#1d2127", "#e4e7ec");
  set(QPalette::Button, "#e8ebf0", "#31353c");
  set(QPalette::ButtonText, "#1d2127", "#e4e7ec");
  set(QPalette::ToolTipBase, "#fffbe6", "#3a3f47");
  set(QPalette::ToolTipText, "#1d2127", "#e4e7ec");
  set(QPalette::Highlight, "#2f6fb3", "#3d7fc4");
  set(QPalette::HighlightedText, "#ffffff", "#ffffff");
  set(QPalette::PlaceholderText, "#8a919c", "#7d848f");
  for (const auto role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText})
    palette.setColor(QPalette::Disabled, role, QColor(dark ? "#6b727c" : "#9aa1ab"));
  application.setPalette(palette);
}

namespace {

using CommandKind = DocumentCommand::CommandKind;
constexpr int kMessageHeight = 120;

QDockWidget* dock(QMainWindow* window, const char* title, QWidget* content,
                  Qt::DockWidgetArea area) {
  auto* dock = new QDockWidget(text(title), window);
  dock->setObjectName(title);
  dock->setWidget(content);
  window->addDockWidget(area, dock);
  return dock;
}

}  // namespace

MainWindow::MainWindow(std::filesystem::path recovery) {
  // The worker thread notifies the window, which processes all pending updates at once in its event
  // loop.
  worker_ = std::make_unique<DocumentWorker>(
      [this] {
        if (!woken_.exchange(true))
          QMetaObject::invokeMethod(
              this, [this] { take_update(); }, Qt::QueuedConnection);
      },
      std::move(recovery));
  setAcceptDrops(true);
  setDockNestingEnabled(true);
  make_panels();
  make_menus();
  make_tools();
  make_status();
  resize(1360, 860);
  set_dark(QSettings().value("dark", false).toBool());
  view_->set_tool(Tool::Select);
  show_title();
}

MainWindow::~MainWindow() {
  worker_.reset();  // before the widgets that its updates use
}

void MainWindow::make_panels() {
  const auto post = [this](DocumentCommand command) { this->post(std::move(command)); };
  view_ =
      new ShapeView(this, {[this](DocumentCommand command) {
                             if (command.kind == CommandKind::SetSlider)
                               sliders_->show_live_value(command.key, command.value);
                             this->post(std::move(command));
                           },
                           [this](const Vec3& near, std::function<void(const PickedPoint&)> found) {
                             worker_->query_surface_point(near, std::move(found));
                           },
                           [this](const std::string& line, const std::string& region) {
                             if (!line.empty())
                               tree_->select_line(line);
                             else if (!region.empty())
                               tree_->select_region(region);
                             else
                               tree_->clear_selection();
                           },
                           [this](const QString& hint) { statusBar()->showMessage(hint); }});
  setCentralWidget(view_);
  tree_ = new ModelTree(this, [this](const ModelTree::Item& item) {
    properties_->refresh(shown_, item);
    using Kind = ModelTree::Item::Kind;
    const std::string& kind = item.table.kind;
    const bool acts =
        kind == "load" || kind == "stiffness" || (kind == "constraint" && !shown_->mesh);
    const bool nothing = (item.kind == Kind::Table && !acts) || item.kind == Kind::Alternative;
    std::string name = nothing ? "" : item.name;
    if (kind == "edit.handle") name = item.name.substr(item.name.rfind('.') + 1);
    view_->select(name);
  });
  properties_ = new PropertyPanel(
      this, post,
      {[this] { return view_->selected_point(); }, [this] { return view_->clicked(); }});
  sliders_ = new SliderPanel(this, post);
  messages_ = new QListWidget;
  messages_->setWordWrap(true);
  timeline_ = new TimelinePanel(this, [this](int frame) { worker_->show_frame(frame); });
  dock(this, kModel, tree_, Qt::LeftDockWidgetArea);
  dock(this, kProperties, properties_, Qt::LeftDockWidgetArea);
  dock(this, kSliders, sliders_, Qt::RightDockWidgetArea);
  frames_ = dock(this, kFrames, timeline_, Qt::BottomDockWidgetArea);
  QDockWidget* below = dock(this, kMessages, messages_, Qt::BottomDockWidgetArea);
  splitDockWidget(frames_, below, Qt::Vertical);
  below->setMaximumHeight(kMessageHeight);
  frames_->hide();
}

QAction* MainWindow::add(QMenu* menu, const char* what, const QKeySequence& key,
                         std::function<void()> act) {
  QAction* action = menu->addAction(text(what));
  action->setObjectName(what);
  action->setShortcut(key);
  QObject::connect(action, &QAction::triggered, this, [act = std::move(act)] { act(); });
  return action;
}

void MainWindow::make_menus() {
  QMenu* file = menuBar()->addMenu(text(kFile));
  add(file, kNew, QKeySequence::New, [this] {
    if (!may_close()) return;
    touring_ = false;
    post({.kind = CommandKind::New, .key = "mm"});
  });
  add(file, kOpen, QKeySequence::Open, [this] { ask_open(); });
  recent_ = file->addMenu(text(kRecent));
  fill_recent();
  add(file, kSave, QKeySequence::Save, [this] { save(false); });
  add(file, kSaveAs, QKeySequence::SaveAs, [this] { save(true); });
  file->addSeparator();
  add(file, kExport, QKeySequence("Ctrl+E"), [this] { ask_export(); });
  add(file, kRun, {}, [this] {
    const QString folder = QFileDialog::getExistingDirectory(this, text(kRun), in_folder());
    if (!folder.isEmpty()) post({.kind = CommandKind::Run, .file = folder.toStdString()});
  });
  add(file, kSaveScript, {}, [this] { save_script(); });
  file->addSeparator();
  add(file, kQuit, QKeySequence::Quit, [this] { close(); });
  QMenu* edit = menuBar()->addMenu(text(kEdit));
  undo_ = add(edit, kUndo, QKeySequence::Undo, [this] {
    if (!view_->undo_pending()) post({.kind = CommandKind::Undo});
  });
  redo_ = add(edit, kRedo, QKeySequence::Redo, [this] { post({.kind = CommandKind::Redo}); });
  add(edit, kRemove, QKeySequence::Delete, [this] { remove_selected(); });
  view_menu_ = menuBar()->addMenu(text(kViewMenu));
  add(view_menu_, kZoomToFit, QKeySequence("F"), [this] { view_->fit(); });
  add(view_menu_, kFront, QKeySequence("1"),
      [this] { view_->look_along(Vec3::UnitY(), Vec3::UnitZ()); });
  add(view_menu_, kSide, QKeySequence("2"),
      [this] { view_->look_along(-Vec3::UnitX(), Vec3::UnitZ()); });
  add(view_menu_, kTop, QKeySequence("3"),
      [this] { view_->look_along(-Vec3::UnitZ(), Vec3::UnitY()); });
  add(view_menu_, kIsometric, QKeySequence("4"), [this] {
    view_->look_along({1, 1.6, -0.9}, Vec3::UnitZ());
  });
  view_menu_->addSeparator();
  const auto check = [this](const char* what, const QKeySequence& key,
                            std::function<void(bool)> act) {
    QAction* action = view_menu_->addAction(text(what));
    action->setObjectName(what);
    action->setCheckable(true);
    action->setShortcut(key);
    QObject::connect(action, &QAction::toggled, this, std::move(act));
    return action;
  };
  QMenu* panels = view_menu_->addMenu(text(kPanels));
  for (QDockWidget* one : findChildren<QDockWidget*>())
    if (one != frames_) panels->addAction(one->toggleViewAction());
  check(kPerspective, QKeySequence("5"), [this](bool on) { view_->set_perspective(on); });
  check(kMeshEdges, QKeySequence("M"), [this](bool on) { view_->set_mesh(on); });
  check(kSection, QKeySequence("X"), [this](bool on) { view_->set_section(on); });
  check(kCombs, QKeySequence("C"), [this](bool on) { view_->set_combs(on); });
  add(menuBar()->addMenu(text(kHelp)), kTour, {}, [this] {
    if (may_close()) start_tour();
  });
  check(kDarkTheme, {}, [this](bool on) {
    set_dark(on);
  })->setChecked(QSettings().value("dark", false).toBool());
}

void MainWindow::make_status() {
  state_ = new QLabel;
  update_rate_ = new QLabel;
  progress_ = new QProgressBar;
  progress_->setMaximumWidth(220);
  progress_->setRange(0, 100);
  stop_ = new QPushButton(text(kStop));
  stop_->setObjectName(kStop);
  QObject::connect(stop_, &QPushButton::clicked, this, [this] { worker_->cancel(); });
  for (QWidget* part : std::initializer_list<QWidget*>{update_rate_, state_, progress_, stop_})
    statusBar()->addPermanentWidget(part);
  progress_->hide();
  stop_->hide();
}

void MainWindow::open(const std::filesystem::path& file) {
  note_recent(QString::fromStdString(std::filesystem::absolute(file).string()));
  touring_ = false;
  messages_->clear();
  problem_ = nullptr;
  post({.kind = CommandKind::Open, .file = std::filesystem::absolute(file)});
}

void MainWindow::start_tour() {
  delete tour_;
  open(tour_scene().toStdString());
  touring_ = true;
  tour_ = new Tour(view_);
}

void MainWindow::recover(const std::filesystem::path& file) {
  post({.kind = CommandKind::Recover, .file = file});
}

void MainWindow::post(DocumentCommand command) {
  busy_ = true;
  worker_->post(std::move(command));
}

// -- updates from the worker
// -------------------------------------------------------------------------

void MainWindow::take_update() {
  woken_ = false;
  if (!worker_) return;
  const DocumentWorker::Update update = worker_->take_update();
  busy_ = update.busy;
  if (motion_->isChecked() != update.simulating) {
    motion_->setChecked(update.simulating);
    show_tools();
    view_->show_hint();
  }
  for (const DocumentCommand& done : update.written) {
    if (done.kind == CommandKind::Save) touring_ = false;
    const char* const what = done.kind == CommandKind::Save     ? kSaved
                             : done.kind == CommandKind::Export ? kExported
                                                                : kSceneRunDone;
    statusBar()->showMessage(
        text(what).arg(done.file.empty() ? shown(shown_->title) : shown(done.file.string())));
  }
  // Messages of earlier steps are greyed out when another step is done.
  if (update.view && update.view->text != shown_->text)
    for (int i = 0; i < messages_->count(); ++i)
      if (messages_->item(i) != problem_) {
        messages_->item(i)->setIcon({});
        messages_->item(i)->setForeground(palette().brush(QPalette::Disabled, QPalette::Text));
      }
  for (const auto& message : update.messages) {
    auto* item = new QListWidgetItem(shown(message.text), messages_);
    item->setToolTip(QString::fromStdString(message.command));
    item->setIcon(style()->standardIcon(message.rejected ? QStyle::SP_MessageBoxCritical
                                                         : QStyle::SP_MessageBoxWarning));
    messages_->scrollToBottom();
  }
  constexpr int soon = 300;  // ms: displayed values are kept until then
  const bool computing = update.frame && !update.stress && shown_->has_stress &&
                         shading_->currentIndex() == static_cast<int>(Shading::Stress) &&
                         !(stress_shown_.isValid() && stress_shown_.elapsed() < soon);
  if (update.view) {
    const bool more_handles =
        update.view->mesh && update.view->handles.size() > shown_->handles.size();
    if (update.view->document_number != shown_->document_number) reset_tools();
    shown_ = update.view;
    if (more_handles && !action(kSelect)->isChecked()) action(kSelect)->trigger();
    show_problem();
    tree_->refresh(*shown_);
    sliders_->refresh(*shown_);
    timeline_->refresh(*shown_);
    frames_->setVisible(shown_->timeline.has_value());
    properties_->refresh(shown_, tree_->current());
    view_->refresh(update);
    show_tools();
    undo_->setEnabled(shown_->can_undo);
    redo_->setEnabled(shown_->can_redo);
    show_title();
  } else {
    view_->refresh(update);
  }
  if (computing) view_->set_text(text(kComputing));
  if (update.stress && shown_->has_stress) {
    stress_shown_.start();
    show_stress(*update.stress);
  }
  if (update.view) show_missing_stress();
  update_tour();
  if (update.frame || !update.busy) timeline_->frame_drawn();
  show_state(update);
}

// Resets the tool settings for a new document.
void MainWindow::reset_tools() {
  plane_->setCurrentIndex(0);
  statusBar()->clearMessage();
}

// Shows why the curves make no surface, as long as this is the case.
void MainWindow::show_problem() {
  delete problem_;
  problem_ = nullptr;
  if (shown_->problem.empty()) return;
  // Dangling ends are normal while the user is drawing: show a count. Other problems are shown in
  // full.
  const QString problem = shown(shown_->problem);
  const int open = problem.count("is not connected to any other curve");
  problem_ = new QListWidgetItem(open > 0 ? text(kOpenEnds).arg(open) : problem, messages_);
  problem_->setToolTip(problem);
  problem_->setIcon(style()->standardIcon(QStyle::SP_MessageBoxInformation));
  messages_->scrollToBottom();
}

void MainWindow::show_title() {
  const std::string folder = shown_->folder.empty() ? "" : shown_->folder + "/";
  setWindowTitle(shown(folder + (shown_->title.empty() ? "untitled" : shown_->title)) + "[*] — " +
                 text(kProgram));
  setWindowModified(shown_->changed);
}

void MainWindow::show_state(const DocumentWorker::Update& update) {
  state_->setText(shown_->surface
                      ? shown(format_count(static_cast<long>(shown_->regions.size()), "face") +
                              ", " + format_count(shown_->triangles, "element"))
                      : text(kNoSurface));
  update_rate_->clear();
  if (update.simulating)
    update_rate_->setText(text(kSimulating));
  else if (update.update_ms > 0)
    update_rate_->setText(text(kUpdatesPerSecond).arg(std::lround(1000 / update.update_ms)));
  const bool long_work = update.busy && !update.stage.empty();
  progress_->setVisible(long_work);
  stop_->setVisible(long_work);
  progress_->setFormat(QString::fromStdString(update.stage) + " %p%");
  progress_->setValue(static_cast<int>(100 * update.fraction));
}

QStringList MainWindow::messages() const {
  QStringList list;
  for (int i = 0; i < messages_->count(); ++i) list << messages_->item(i)->text();
  return list;
}

QAction* MainWindow::action(const char* what) const { return findChild<QAction*>(what); }

bool MainWindow::wait(double seconds) {
  QElapsedTimer timer;
  timer.start();
  int idle = 0;
  while (idle < 3) {
    QApplication::processEvents(QEventLoop::AllEvents, 20);
    take_update();
    idle = busy_ ? 0 : idle + 1;
    if (timer.elapsed() > 1000 * seconds) return false;
  }
  return true;
}

void MainWindow::set_dark(bool dark) {
  QSettings().setValue("dark", dark);
  apply_theme(*qApp, dark);
  view_->set_dark(dark);
}

// Opening, saving, exporting, and the check for unsaved changes.

namespace {

/// The text of a menu entry as a title.
QString title(const char* menu) { return text(menu).remove('&'); }

/// File filter for the format of the input mesh.
QString original_format(const QString& ending) {
  constexpr std::pair<const char*, const char*> decks[] = {{"bdf nas dat", "Nastran deck"},
                                                           {"inp", "Abaqus deck"},
                                                           {"k key dyn", "LS-DYNA deck"},
                                                           {"rad", "Radioss deck"},
                                                           {"msh", "Gmsh mesh"},
                                                           {"unv", "Universal file"}};
  for (const auto& [endings, deck] : decks)
    if (QString(endings).split(' ').contains(ending.toLower()))
      return text(kOriginalFormat).arg(deck, "." + ending);
  return text(kOriginalMesh).arg("." + ending);
}

}  // namespace

void MainWindow::ask_open() {
  if (!may_close()) return;
  QStringList meshes;
  for (const std::string& extension : MeshFile::readable_extensions())
    meshes += "*" + QString::fromStdString(extension);
  const QString file = QFileDialog::getOpenFileName(this, title(kOpen), in_folder(),
                                                    text(kSceneFiles).arg(meshes.join(' ')));
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
