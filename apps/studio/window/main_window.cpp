#include "batten/apps/studio/window/main_window.h"

#include <QApplication>
#include <QCloseEvent>
#include <QComboBox>
#include <QDockWidget>
#include <QFileDialog>
#include <QLabel>
#include <QListWidget>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QPalette>
#include <QProgressBar>
#include <QPushButton>
#include <QSettings>
#include <QStatusBar>
#include <cmath>

#include "batten/apps/studio/view/strings.h"
#include "batten/io/files/text.h"

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
  view_ = new ShapeView(this,
                        {[this](DocumentCommand command) {
                           if (command.kind == CommandKind::SetSlider)
                             sliders_->show_live_value(command.key, command.value);
                           this->post(std::move(command));
                         },
                         [this](const Vec3& near, std::function<void(const SurfacePoint&)> found) {
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

}  // namespace batten::studio
