// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/document_worker.h"

#include <fstream>
#include <new>

#include "batten/apps/documents/line_edits.h"
#include "batten/io/files/atomic_file.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;
using Clock = std::chrono::steady_clock;
constexpr double kStep = 0.02;  // time step of a motion, s

}  // namespace

DocumentWorker::DocumentWorker(std::function<void()> wake, std::filesystem::path recovery)
    : wake_(std::move(wake)), recovery_(std::move(recovery)) {
  view_ = std::make_shared<const DocumentView>(view_of(document_));
  thread_ = std::thread([this] { work(); });
}

DocumentWorker::~DocumentWorker() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = cancelled_ = true;
    tasks_.clear();
  }
  waiting_.notify_all();
  thread_.join();
}

void DocumentWorker::post(DocumentCommand command) {
  {
    const std::lock_guard lock(mutex_);
    // A released slider does not stop the motion: it continues, and the value is kept.
    if (command.kind == CommandKind::SolveToEquilibrium && simulating_)
      command.kind = CommandKind::SolvePreview;
    if (command.kind == CommandKind::SetSlider)
      for (auto it = tasks_.rbegin(); it != tasks_.rend(); ++it) {
        if (it->query || it->frame >= 0 || it->command.kind != CommandKind::SetSlider) break;
        if (it->command.key != command.key) continue;
        it->command.value = command.value;
        return;
      }
    // A point that is still dragged: the waiting move takes the latest position.
    if (command.kind == CommandKind::Move && !tasks_.empty() &&
        is_move_from(tasks_.back(), command)) {
      tasks_.back().command.text = std::move(command.text);
      return;
    }
    tasks_.push_back({std::move(command), nullptr, -1});
  }
  waiting_.notify_all();
}

bool DocumentWorker::is_move_from(const Task& task, const DocumentCommand& move) {
  if (task.query || task.frame >= 0 || task.command.kind != CommandKind::Move) return false;
  const std::vector<Vec3> a = parse_points(task.command.text), b = parse_points(move.text);
  return !a.empty() && !b.empty() && a.front() == b.front();
}

void DocumentWorker::query_surface_point(const Vec3& near,
                                         std::function<void(const PickedPoint&)> found) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back({{}, std::make_shared<PointQuery>(PointQuery{near, std::move(found)}), -1});
  }
  waiting_.notify_all();
}

void DocumentWorker::show_frame(int frame) {
  {
    const std::lock_guard lock(mutex_);
    if (!tasks_.empty() && tasks_.back().frame >= 0)
      tasks_.back().frame = frame;
    else
      tasks_.push_back({{}, nullptr, frame});
  }
  waiting_.notify_all();
}

void DocumentWorker::cancel() {
  const std::lock_guard lock(mutex_);
  tasks_.clear();
  if (busy_) cancelled_ = true;
}

void DocumentWorker::discard_changes() {
  cancel();
  discarded_ = true;
  std::error_code none;
  if (!recovery_.empty()) std::filesystem::remove(recovery_, none);
}

void DocumentWorker::analyse(Analysis what) {
  if (analysis_.exchange(what) == what || what == Analysis::None) return;
  post({.kind = CommandKind::SolvePreview});  // triggers the analysis
}

void DocumentWorker::set_simulating(bool on) {
  {
    const std::lock_guard lock(mutex_);
    if (simulating_ == on) return;
    simulating_ = on;
    next_step_ = Clock::now();
    if (!on) tasks_.push_back({{.kind = CommandKind::SolveToEquilibrium}, nullptr, -1});
  }
  waiting_.notify_all();
}

DocumentWorker::Update DocumentWorker::take_update() {
  Update update;
  std::vector<std::function<void()>> callbacks;
  {
    const std::lock_guard lock(mutex_);
    update.view = std::move(view_);
    view_ = nullptr;
    update.stress = std::move(stress_);
    stress_ = nullptr;
    update.messages.swap(messages_);
    update.written.swap(written_);
    callbacks.swap(callbacks_);
    update.busy = busy_ || !tasks_.empty();
    update.simulating = simulating_;
    update.stage = stage_;
    update.fraction = fraction_;
    update.update_ms = update_ms_;
  }
  update.frame = frames_.latest();
  for (const auto& answer : callbacks) answer();
  return update;
}

std::vector<std::string> DocumentWorker::script() const {
  const std::lock_guard lock(mutex_);
  return script_;
}

Progress DocumentWorker::progress() {
  Progress progress;
  progress.cancelled = [this] { return cancelled_.load(); };
  progress.report = [this](std::string_view stage, double fraction) {
    {
      const std::lock_guard lock(mutex_);
      stage_ = stage;
      fraction_ = fraction;
    }
    wake_();
  };
  return progress;
}

bool DocumentWorker::next(Task& task) {
  std::unique_lock lock(mutex_);
  busy_ = false;
  stage_.clear();
  fraction_ = 0;
  if (tasks_.empty()) {
    lock.unlock();
    wake_();
    lock.lock();
  }
  const auto waits = [&] { return stopping_ || !tasks_.empty(); };
  if (simulating_)
    waiting_.wait_until(lock, next_step_, waits);
  else
    waiting_.wait(lock, [&] { return waits() || simulating_; });
  if (stopping_) return false;
  cancelled_ = false;
  if (tasks_.empty()) {
    task = {{.kind = CommandKind::Step, .value = kStep}, nullptr, -1};
    next_step_ = std::max(next_step_ + std::chrono::milliseconds(20), Clock::now());
    return true;
  }
  task = std::move(tasks_.front());
  tasks_.pop_front();
  busy_ = true;
  return true;
}

void DocumentWorker::work() {
  for (Task task; next(task);) {
    if (task.query) {
      answer_query(task.query);
      continue;
    }
    if (task.frame >= 0) {
      document_.show_frame(task.frame);
      publish_frame();
      publish_view();
      continue;
    }
    if (task.command.kind == CommandKind::Step) {
      run_motion_step(task.command);
      continue;
    }
    if (task.command.kind != CommandKind::SetSlider) {
      do_command(task.command);
      publish_frame();
      publish_view();
      continue;
    }
    const auto start = Clock::now();
    do_command(task.command);
    if (has_other_slider_move(task.command.key)) continue;
    preview_until_converged();
    constexpr double keeps_up = 0.06;  // s; analyse during drags only below this duration
    std::shared_ptr<const StressView> stress;
    if (stress_s_ < keeps_up) stress = solved_stress();
    const double ms = 1e3 * seconds_since(start);
    const std::lock_guard lock(mutex_);
    if (stress) stress_ = std::move(stress);
    update_ms_ = update_ms_ > 0 ? 0.8 * update_ms_ + 0.2 * ms : ms;
  }
}

// Several parameters may change at once: update the shape after all of them.
bool DocumentWorker::has_other_slider_move(const std::string& parameter) {
  changed_sliders_.insert(parameter);
  const std::lock_guard lock(mutex_);
  if (!tasks_.empty() && !tasks_.front().query && tasks_.front().frame < 0 &&
      tasks_.front().command.kind == CommandKind::SetSlider &&
      !changed_sliders_.contains(tasks_.front().command.key))
    return true;
  changed_sliders_.clear();
  return false;
}

// Updates the shape during a drag, repeatedly until it converges or another task waits.
void DocumentWorker::preview_until_converged() {
  constexpr int most = 20;
  const DocumentCommand answer{.kind = CommandKind::SolvePreview};
  for (int i = 0; i < most; ++i) {
    do_command(answer);
    publish_frame();
    wake_();
    if (document_.is_at_rest()) return;
    const std::lock_guard lock(mutex_);
    if (!tasks_.empty() || stopping_) return;
  }
}

void DocumentWorker::run_motion_step(const DocumentCommand& step) {
  const bool done = do_command(step);
  publish_frame();
  if (!done) {
    const std::lock_guard lock(mutex_);
    simulating_ = false;
  }
  wake_();
}

bool DocumentWorker::do_command(const DocumentCommand& command) {
  bool done = true;
  try {
    document_.apply(command, progress());
    if (!document_.run_messages().empty()) report_message(command, document_.run_messages(), false);
  } catch (const NoSolutionError& e) {
    done = false;
    report_message(command, e.what(), true);  // also recorded, because the shape was reset
  } catch (const std::bad_alloc&) {
    report_message(command, "not enough memory", true);
    return false;
  } catch (const std::exception& e) {
    report_message(command, e.what(), true);
    return false;
  }
  const std::lock_guard lock(mutex_);
  script_.push_back(script_line(command));
  if (command.kind == CommandKind::Save || command.kind == CommandKind::Export ||
      command.kind == CommandKind::Run)
    written_.push_back(command);
  if (command.kind == CommandKind::Open || command.kind == CommandKind::New ||
      command.kind == CommandKind::Recover) {
    update_ms_ = 0;
    simulating_ = false;  // a new document is not in motion
    ++document_number_;
  }
  return done;
}

void DocumentWorker::answer_query(const std::shared_ptr<PointQuery>& query) {
  try {
    const PickedPoint nearest_point = document_.content().nearest_point(query->near);
    const std::lock_guard lock(mutex_);
    callbacks_.push_back([query, nearest_point] { query->found(nearest_point); });
  } catch (const Error&) {
    return;  // there is no surface
  }
  wake_();
}

void DocumentWorker::report_message(const DocumentCommand& command, const std::string& text,
                                    bool rejected) {
  const std::lock_guard lock(mutex_);
  messages_.push_back({script_line(command), text, rejected});
}

void DocumentWorker::publish_frame() {
  try {
    if (document_.draw(frames_.writing())) frames_.publish();
  } catch (const std::exception& e) {
    report_message({}, e.what(), true);
  }
}

// Null if no analysis is requested; without values if it has no result, which removes the old one.
std::shared_ptr<const StressView> DocumentWorker::solved_stress() {
  const Analysis what = analysis_;
  if (what == Analysis::None) return nullptr;
  const auto start = Clock::now();
  std::shared_ptr<const StressView> stress = document_.stress(what);
  if (!stress) stress = std::make_shared<const StressView>();
  stress_s_ = seconds_since(start);
  return stress;
}

// Publishes the view together with its stresses.
void DocumentWorker::publish_view() {
  auto view = std::make_shared<DocumentView>(view_of(document_));
  view->document_number = document_number_;
  write_recovery(*view);
  std::shared_ptr<const StressView> stress = solved_stress();
  {
    const std::lock_guard lock(mutex_);
    view_ = std::move(view);
    if (stress) stress_ = std::move(stress);
  }
  wake_();
}

void DocumentWorker::write_recovery(const DocumentView& view) {
  if (recovery_.empty() || discarded_) return;
  const std::string now = view.changed ? document_.recovery_text(recovery_.parent_path()) : "";
  if (now == written_recovery_) return;
  try {
    if (now.empty())
      std::filesystem::remove(recovery_);
    else
      write_file_atomically(recovery_, [&](std::ostream& out) { out << now; });
    written_recovery_ = now;
  } catch (const std::exception& e) {
    report_message({}, std::string("cannot write the recovery file: ") + e.what(), true);
  }
}

}  // namespace batten
