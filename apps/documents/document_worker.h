// SPDX-License-Identifier: MPL-2.0
// Runs a document on its own thread, so that the window stays responsive.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "batten/apps/documents/document.h"

namespace batten {

/// Executes commands on a document in order, on its own thread, and reports the results.
///
/// Slider moves during a drag arrive faster than solutions. Of the waiting moves of one parameter
/// only the latest is executed, followed by a quick update (`update`); several moving parameters
/// share one update. The same applies to a dragged point.
///
/// After each command there is a new view with its stresses, and a new frame if the shape changed;
/// during slider drags, frames only. The executed commands are recorded as a script that reproduces
/// the same bits (run_script()).
///
/// All functions must be called from one thread, that of the window. `wake` is called from the
/// worker's thread when there is an update; it must only notify the window. While there are unsaved
/// changes, the last state is kept in the file `recovery`, written atomically and removed when it
/// is no longer needed.
class DocumentWorker {
 public:
  explicit DocumentWorker(std::function<void()> wake, std::filesystem::path recovery = {});
  /// Cancels the current command and waits for its end.
  ~DocumentWorker();
  DocumentWorker(const DocumentWorker&) = delete;
  DocumentWorker& operator=(const DocumentWorker&) = delete;

  /// Appends a command to the queue.
  void post(DocumentCommand command);
  /// Queries the surface point nearest to a point; take_update() calls `found` with the result.
  void query_surface_point(const Vec3& near, std::function<void(const PickedPoint&)> found);
  /// Shows another frame of a sequence (0-based); only the latest waiting request is executed.
  void show_frame(int frame);
  /// Discards unsaved changes: removes the recovery file, and writes none any more.
  void discard_changes();
  /// Selects the analysis performed beside the shape: after each command, and during drags as long
  /// as it is fast enough.
  void analyse(Analysis what);
  /// Starts or stops the dynamic simulation, in real time if the steps are fast enough. Sliders act
  /// on it; any other command stops the motion first, after which it restarts from rest.
  void set_simulating(bool on);
  /// Cancels the current command and discards the waiting ones.
  void cancel();

  /// A rejected command or a failed check, as text.
  struct Message {
    std::string command, text;
    bool rejected = true;  ///< false: executed, but a check failed
  };
  /// Changes since the last take_update().
  struct Update {
    std::shared_ptr<const DocumentView> view;  ///< null: unchanged
    const Frame* frame = nullptr;  ///< null: unchanged; valid until the next take_update()
    /// null: unchanged; without values: no stresses any more.
    std::shared_ptr<const StressView> stress;
    std::vector<Message> messages;
    std::vector<DocumentCommand> written;  ///< completed saves, exports and runs
    bool busy = false;
    std::string stage;  ///< stage of the current command
    double fraction = 0;
    bool simulating = false;  ///< a motion is running; this does not count as busy
    double update_ms = 0;  ///< mean time of an update with its frame in the last drag; 0: none yet
  };
  /// Collects what is new since the last call.
  Update take_update();
  /// The executed commands, one per line.
  std::vector<std::string> script() const;

 private:
  struct PointQuery {
    Vec3 near;
    std::function<void(const PickedPoint&)> found;
  };
  struct Task {
    DocumentCommand command;
    std::shared_ptr<PointQuery> query;  // instead of a command
    int frame = -1;                     // frame to show instead of a command; -1: none
  };
  static bool is_move_from(const Task& task, const DocumentCommand& move);
  void work();
  bool next(Task& task);
  bool do_command(const DocumentCommand& command);
  void run_motion_step(const DocumentCommand& step);
  void preview_until_converged();
  bool has_other_slider_move(const std::string& parameter);
  void answer_query(const std::shared_ptr<PointQuery>& query);
  void publish_frame();
  void publish_view();
  std::shared_ptr<const StressView> solved_stress();
  void report_message(const DocumentCommand& command, const std::string& text, bool rejected);
  void write_recovery(const DocumentView& view);
  Progress progress();

  std::function<void()> wake_;
  std::filesystem::path recovery_;
  Document document_;                      // used by the worker's thread only
  std::set<std::string> changed_sliders_;  // since the last update; worker's thread only
  FrameExchange frames_;
  mutable std::mutex mutex_;
  std::condition_variable waiting_;
  std::deque<Task> tasks_;
  std::shared_ptr<const DocumentView> view_;
  std::shared_ptr<const StressView> stress_;
  std::vector<Message> messages_;
  std::vector<DocumentCommand> written_;
  std::vector<std::function<void()>> callbacks_;
  std::vector<std::string> script_;
  std::string stage_, written_recovery_;
  double fraction_ = 0, update_ms_ = 0;
  bool busy_ = false, simulating_ = false;
  int document_number_ = 0;  // number of documents so far
  std::chrono::steady_clock::time_point next_step_;
  double stress_s_ = 0;  // duration of the last stress analysis; worker's thread only
  std::atomic<Analysis> analysis_ = Analysis::None;
  std::atomic<bool> cancelled_ = false, stopping_ = false, discarded_ = false;
  std::thread thread_;
};

}  // namespace batten
