// A document on a thread of its own, so that a window never waits for it.
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

#include "batten/apps/commands/documents/document.h"

namespace batten {

/// Does commands on a document in their order, on its own thread, and tells what came of them.
///
/// While a slider is dragged its moves come faster than answers: of those that wait for one
/// parameter only the newest is done, and the shape follows each (`answer`), or all that move at
/// once; so with a point that is dragged. After every command there is a new view with its stresses,
/// and where the shape moved a new frame; during a drag of sliders, frames only. What was
/// done is recorded as a script that gives the same bits again (run_script()).
///
/// All calls are from one thread, the window's. `wake` is called from the worker's thread when there
/// is something new; it must only pass that on. The last state is kept in `recovery` while there
/// are changes, written whole or not at all, and removed when it is not needed any more.
class DocumentWorker {
 public:
  explicit DocumentWorker(std::function<void()> wake, std::filesystem::path recovery = {});
  /// Stops what is being done, and waits for that.
  ~DocumentWorker();
  DocumentWorker(const DocumentWorker&) = delete;
  DocumentWorker& operator=(const DocumentWorker&) = delete;

  void post(DocumentCommand command);
  /// Asks for the place of the surface nearest to a point; `found` is called by take_update().
  void query_surface_point(const Vec3& near, std::function<void(const SurfacePoint&)> found);
  /// Shows another frame of a sequence, counted from 0; of those that wait only the newest.
  void show_frame(int frame);
  /// The user does not want the changes: the recovery file goes, and there is none any more.
  void discard_changes();
  /// What is solved for beside the shape: after each command, and in a drag as long as that keeps up
  /// with the hand.
  void analyse(Analysis what);
  /// Lets the shape move, one second of its time in a second of the clock where steps keep up. Sliders
  /// act on it; other commands end the motion first, and it begins anew from rest.
  void set_simulating(bool on);
  /// Stops the command that is being done, and forgets those that wait.
  void cancel();

  /// Something that was refused or missed, in words.
  struct Message {
    std::string command, text;
    bool rejected = true;  ///< false: done, but a promise was missed
  };
  struct Update {
    std::shared_ptr<const DocumentView> view;  ///< null: as before
    const Frame* frame = nullptr;  ///< null: as before; valid until the next take_update()
    std::shared_ptr<const StressView> stress;  ///< null: as before; without values: none any more
    std::vector<Message> messages;
    std::vector<DocumentCommand> written;  ///< saves, exports and runs that were done
    bool busy = false;
    std::string stage;  ///< of what is being done
    double fraction = 0;
    bool simulating = false;  ///< steps of a motion are done; they do not count as busy
    double update_ms = 0;  ///< mean time of an answer and its frame in the last drag; 0: none yet
  };
  Update take_update();
  /// What was done, one command a line.
  std::vector<std::string> script() const;

 private:
  struct PointQuery {
    Vec3 near;
    std::function<void(const SurfacePoint&)> found;
  };
  struct Task {
    DocumentCommand command;
    std::shared_ptr<PointQuery> query;  // instead of a command
    int frame = -1;                     // to be shown, instead of a command
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
  Document document_;                      // of the worker's thread
  std::set<std::string> changed_sliders_;  // since the last answer; of the worker's thread
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
  int document_number_ = 0;  // documents so far
  std::chrono::steady_clock::time_point next_step_;
  double stress_s_ = 0;  // that the last stresses took; of the worker's thread
  std::atomic<Analysis> analysis_ = Analysis::None;
  std::atomic<bool> cancelled_ = false, stopping_ = false, discarded_ = false;
  std::thread thread_;
};

}  // namespace batten
