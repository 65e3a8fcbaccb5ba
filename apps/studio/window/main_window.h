// The window of batten-studio.
#pragma once

#include <QElapsedTimer>
#include <QMainWindow>
#include <QPointer>
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>

#include "batten/apps/commands/documents/document_worker.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/window/input_event_filter.h"
#include "batten/apps/studio/window/model_tree.h"
#include "batten/apps/studio/window/property_panel.h"
#include "batten/apps/studio/window/slider_panel.h"
#include "batten/apps/studio/window/timeline_panel.h"
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

/// Menus, panels and the view around one document, which lives on a worker's thread. Everything
/// that is done is a DocumentCommand: posted, recorded, undone and replayed alike.
class MainWindow : public QMainWindow {
 public:
  /// `recovery`: the file that keeps changes until they are saved; empty: none.
  explicit MainWindow(std::filesystem::path recovery = {});
  ~MainWindow() override;

  void open(const std::filesystem::path& file);
  /// Takes up changes that a window which was killed left in this file.
  void recover(const std::filesystem::path& file);
  void post(DocumentCommand command);
  /// Opens the door and shows what can be done with it.
  void start_tour();

  // For tests and tours: what the hand can reach.
  ShapeView& view() { return *view_; }
  SliderPanel& sliders() { return *sliders_; }
  PropertyPanel& properties() { return *properties_; }
  ModelTree& tree() { return *tree_; }
  TimelinePanel& timeline() { return *timeline_; }
  QAction* action(const char* text) const;  ///< by its English text
  const DocumentView& document() const { return *shown_; }
  DocumentWorker& worker() { return *worker_; }
  Tour* tour() { return tour_; }  ///< null: none
  QComboBox& shading() { return *shading_; }
  QComboBox& paint() { return *paint_; }
  QComboBox& modes() { return *modes_; }
  QStringList messages() const;
  /// Works off events until the worker has nothing to do; false after so many seconds.
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
  QAction *plane_bar_ = nullptr, *paint_bar_ = nullptr, *modes_bar_ = nullptr;  // their places
  QAction* motion_ = nullptr;
  QPointer<Tour> tour_;
  InputEventFilter input_filter_;
  QElapsedTimer stress_shown_;
  bool busy_ = false;
  bool touring_ = false;  // the open scene is the tour's door
  std::atomic<bool> woken_ = false;
};

}  // namespace batten::studio
