// SPDX-License-Identifier: MPL-2.0
// The main window of batten-studio.
#pragma once

#include <QElapsedTimer>
#include <QMainWindow>
#include <QPointer>
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>

#include "batten/apps/documents/document_worker.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/window/model_tree.h"
#include "batten/apps/studio/window/property_panel.h"
#include "batten/apps/studio/window/slider_panels.h"
#include "batten/apps/studio/window/tour.h"

class QAction;
class QActionGroup;
class QComboBox;
class QLabel;
class QListWidget;
class QListWidgetItem;
class QProgressBar;
class QDockWidget;
class QPushButton;

namespace batten::studio {

/// Menus, panels and the 3-D view of one document, which lives on a worker thread. Every change is
/// a DocumentCommand, so all changes can be posted, recorded, undone and replayed.
class MainWindow : public QMainWindow {
 public:
  /// `recovery`: file in which unsaved changes are kept until they are saved; empty: none.
  explicit MainWindow(std::filesystem::path recovery = {});
  ~MainWindow() override;

  /// Opens a scene, mesh or curve file.
  void open(const std::filesystem::path& file);
  /// Restores changes that a killed window has left in this recovery file.
  void recover(const std::filesystem::path& file);
  /// Sends a command to the document.
  void post(DocumentCommand command);
  /// Opens the door-panel example and starts the guided tour.
  void start_tour();

  // Access for tests and tours to the widgets that the user can operate.
  ShapeView& view() { return *view_; }
  SliderPanel& sliders() { return *sliders_; }
  PropertyPanel& properties() { return *properties_; }
  ModelTree& tree() { return *tree_; }
  TimelinePanel& timeline() { return *timeline_; }
  QAction* action(const char* text) const;  ///< by its English text
  const DocumentView& document() const { return *shown_; }
  DocumentWorker& worker() { return *worker_; }
  Tour* tour() { return tour_; }  ///< null: no tour is running
  QComboBox& shading() { return *shading_; }
  QComboBox& paint() { return *paint_; }
  QComboBox& modes() { return *modes_; }
  QStringList messages() const;
  /// Processes events until the worker is idle. Returns false after `seconds`.
  bool wait(double seconds = 60);

 protected:
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  QAction* add(QMenu* menu, const char* what, const QKeySequence& key, std::function<void()> act);
  void make_menus();
  void make_tools();
  void make_panels();
  void make_status();
  void take_update();
  void show_title();
  void show_tools();
  void set_shading_mode(Shading shading);
  void select_mode(int mode);
  void set_simulating(bool on);
  void update_tour();
  void show_stress(const StressView& stress);
  void show_modes(const StressView& stress);
  void show_missing_stress();
  void reset_tools();
  QString in_folder(const QString& name = {}) const;
  void show_problem();
  void show_state(const DocumentWorker::Update& update);
  void save(bool as);
  void ask_export();
  QString stem() const;
  void ask_open();
  void save_script();
  void remove_selected();
  void note_recent(const QString& file);
  void fill_recent();
  void set_dark(bool dark);
  bool may_close();

  std::unique_ptr<DocumentWorker> worker_;
  std::shared_ptr<const DocumentView> shown_ = std::make_shared<DocumentView>();
  ShapeView* view_ = nullptr;
  SliderPanel* sliders_ = nullptr;
  PropertyPanel* properties_ = nullptr;
  ModelTree* tree_ = nullptr;
  TimelinePanel* timeline_ = nullptr;
  QDockWidget* frames_ = nullptr;
  QListWidget* messages_ = nullptr;
  QListWidgetItem* problem_ = nullptr;
  QMenu *recent_ = nullptr, *view_menu_ = nullptr;
  QAction *undo_ = nullptr, *redo_ = nullptr;
  QLabel *state_ = nullptr, *update_rate_ = nullptr;
  QProgressBar* progress_ = nullptr;
  QPushButton* stop_ = nullptr;
  QComboBox *shading_ = nullptr, *plane_ = nullptr, *paint_ = nullptr, *modes_ = nullptr;
  // Containers of these combo boxes.
  QAction *plane_bar_ = nullptr, *paint_bar_ = nullptr, *modes_bar_ = nullptr;
  QAction* motion_ = nullptr;
  QPointer<Tour> tour_;
  InputEventFilter input_filter_;
  QElapsedTimer stress_shown_;
  bool busy_ = false;
  bool touring_ = false;  // the tour's example is open
  std::atomic<bool> woken_ = false;
};

}  // namespace batten::studio
