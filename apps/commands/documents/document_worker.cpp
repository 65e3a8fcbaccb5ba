#include "batten/apps/commands/documents/document_worker.h"

#include <fstream>
#include <new>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace {

using Verb = DocumentCommand::Verb;
using Clock = std::chrono::steady_clock;
constexpr double kStep = 0.02;  // of a motion, s

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
    // A slider that is let go: it swings on, but is seen and kept.
    if (command.verb == Verb::Settle && moving_) command.verb = Verb::Answer;
    if (command.verb == Verb::Slide)
      for (auto it = tasks_.rbegin(); it != tasks_.rend(); ++it) {
        if (it->question || it->frame >= 0 || it->command.verb != Verb::Slide) break;
        if (it->command.key != command.key) continue;
        it->command.value = command.value;
        return;
      }
    // A point that is dragged on: what waits is the newest place.
    if (command.verb == Verb::Move && !tasks_.empty() && is_move_from(tasks_.back(), command)) {
      tasks_.back().command.text = std::move(command.text);
      return;
    }
    tasks_.push_back({std::move(command), nullptr, -1});
  }
  waiting_.notify_all();
}

bool DocumentWorker::is_move_from(const Task& task, const DocumentCommand& move) {
  if (task.question || task.frame >= 0 || task.command.verb != Verb::Move) return false;
  const std::vector<Vec3> a = listed_points(task.command.text), b = listed_points(move.text);
  return !a.empty() && !b.empty() && a.front() == b.front();
}

void DocumentWorker::ask_place(const Vec3& near, std::function<void(const DocumentPlace&)> found) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back({{}, std::make_shared<Question>(Question{near, std::move(found)}), -1});
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

void DocumentWorker::forget_changes() {
  cancel();
  forgotten_ = true;
  std::error_code none;
  if (!recovery_.empty()) std::filesystem::remove(recovery_, none);
}

void DocumentWorker::analyse(Analysis what) {
  if (analysis_.exchange(what) == what || what == Analysis::None) return;
  post({.verb = Verb::Answer});  // so that it is solved for
}

void DocumentWorker::set_moving(bool on) {
  {
    const std::lock_guard lock(mutex_);
    if (moving_ == on) return;
    moving_ = on;
    next_step_ = Clock::now();
    if (!on) tasks_.push_back({{.verb = Verb::Settle}, nullptr, -1});
  }
  waiting_.notify_all();
}

DocumentWorker::News DocumentWorker::take_news() {
  News news;
  std::vector<std::function<void()>> answers;
  {
    const std::lock_guard lock(mutex_);
    news.view = std::move(view_);
    view_ = nullptr;
    news.stress = std::move(stress_);
    stress_ = nullptr;
    news.messages.swap(messages_);
    news.written.swap(written_);
    answers.swap(answers_);
    news.busy = busy_ || !tasks_.empty();
    news.moving = moving_;
    news.stage = stage_;
    news.fraction = fraction_;
    news.answer_ms = answer_ms_;
  }
  news.frame = frames_.latest();
  for (const auto& answer : answers) answer();
  return news;
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
  if (moving_)
    waiting_.wait_until(lock, next_step_, waits);
  else
    waiting_.wait(lock, [&] { return waits() || moving_; });
  if (stopping_) return false;
  cancelled_ = false;
  if (tasks_.empty()) {
    task = {{.verb = Verb::Step, .value = kStep}, nullptr, -1};
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
    if (task.question) {
      answer_question(task.question);
      continue;
    }
    if (task.frame >= 0) {
      document_.show_frame(task.frame);
      publish_frame();
      publish_view();
      continue;
    }
    if (task.command.verb == Verb::Step) {
      do_step(task.command);
      continue;
    }
    if (task.command.verb != Verb::Slide) {
      do_command(task.command);
      publish_frame();
      publish_view();
      continue;
    }
    const auto start = Clock::now();
    do_command(task.command);
    if (another_slides(task.command.key)) continue;
    answer_until_rest();
    constexpr double keeps_up = 0.06;  // s
    std::shared_ptr<const StressView> stress;
    if (stress_s_ < keeps_up) stress = solved_stress();
    const double ms = 1e3 * seconds_since(start);
    const std::lock_guard lock(mutex_);
    if (stress) stress_ = std::move(stress);
    answer_ms_ = answer_ms_ > 0 ? 0.8 * answer_ms_ + 0.2 * ms : ms;
  }
}

// A hand may move several parameters at once: the shape follows when all have moved.
bool DocumentWorker::another_slides(const std::string& parameter) {
  slid_.insert(parameter);
  const std::lock_guard lock(mutex_);
  if (!tasks_.empty() && !tasks_.front().question && tasks_.front().frame < 0 &&
      tasks_.front().command.verb == Verb::Slide && !slid_.contains(tasks_.front().command.key))
    return true;
  slid_.clear();
  return false;
}

// A drag's answer, and more while nothing else waits and it has not converged.
void DocumentWorker::answer_until_rest() {
  constexpr int most = 20;
  const DocumentCommand answer{.verb = Verb::Answer};
  for (int i = 0; i < most; ++i) {
    do_command(answer);
    publish_frame();
    wake_();
    if (document_.at_rest()) return;
    const std::lock_guard lock(mutex_);
    if (!tasks_.empty() || stopping_) return;
  }
}

void DocumentWorker::do_step(const DocumentCommand& step) {
  const bool done = do_command(step);
  publish_frame();
  if (!done) {
    const std::lock_guard lock(mutex_);
    moving_ = false;
  }
  wake_();
}

bool DocumentWorker::do_command(const DocumentCommand& command) {
  bool done = true;
  try {
    document_.apply(command, progress());
    if (!document_.told().empty()) tell(command, document_.told(), false);
  } catch (const NoSolutionError& e) {
    done = false;
    tell(command, e.what(), true);  // and it is recorded: the shape went back
  } catch (const std::bad_alloc&) {
    tell(command, "not enough memory", true);
    return false;
  } catch (const std::exception& e) {
    tell(command, e.what(), true);
    return false;
  }
  const std::lock_guard lock(mutex_);
  script_.push_back(script_line(command));
  if (command.verb == Verb::Save || command.verb == Verb::Export || command.verb == Verb::Run)
    written_.push_back(command);
  if (command.verb == Verb::Open || command.verb == Verb::New || command.verb == Verb::Recover) {
    answer_ms_ = 0;
    moving_ = false;  // another document rests
    ++opened_;
  }
  return done;
}

void DocumentWorker::answer_question(const std::shared_ptr<Question>& question) {
  try {
    const DocumentPlace place = document_.content().place(question->near);
    const std::lock_guard lock(mutex_);
    answers_.push_back([question, place] { question->found(place); });
  } catch (const Error&) {
    return;  // no surface there: nothing to find
  }
  wake_();
}

void DocumentWorker::tell(const DocumentCommand& command, const std::string& text, bool refused) {
  const std::lock_guard lock(mutex_);
  messages_.push_back({script_line(command), text, refused});
}

void DocumentWorker::publish_frame() {
  try {
    if (document_.draw(frames_.writing())) frames_.publish();
  } catch (const std::exception& e) {
    tell({}, e.what(), true);
  }
}

// Null where none are asked for; without values where there are none: what was there goes.
std::shared_ptr<const StressView> DocumentWorker::solved_stress() {
  const Analysis what = analysis_;
  if (what == Analysis::None) return nullptr;
  const auto start = Clock::now();
  std::shared_ptr<const StressView> stress = document_.stress(what);
  if (!stress) stress = std::make_shared<const StressView>();
  stress_s_ = seconds_since(start);
  return stress;
}

// With its stresses: news have both or none.
void DocumentWorker::publish_view() {
  auto view = std::make_shared<DocumentView>(view_of(document_));
  view->opened = opened_;
  keep(*view);
  std::shared_ptr<const StressView> stress = solved_stress();
  {
    const std::lock_guard lock(mutex_);
    view_ = std::move(view);
    if (stress) stress_ = std::move(stress);
  }
  wake_();
}

void DocumentWorker::keep(const DocumentView& view) {
  if (recovery_.empty() || forgotten_) return;
  const std::string now = view.changed ? document_.recovery_text(recovery_.parent_path()) : "";
  if (now == kept_) return;
  try {
    if (now.empty())
      std::filesystem::remove(recovery_);
    else
      write_whole_file(recovery_, [&](std::ostream& out) { out << now; });
    kept_ = now;
  } catch (const std::exception& e) {
    tell({}, std::string("the recovery file could not be written: ") + e.what(), true);
  }
}

}  // namespace batten
