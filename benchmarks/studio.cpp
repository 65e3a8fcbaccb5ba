// SPDX-License-Identifier: MPL-2.0
// A drag in the window: time of an update, compared with a session alone, and of drawing.
//
// The view is drawn with the available OpenGL (in tests and here: Mesa on the processor). All times
// are wall-clock times: updates are computed on the worker thread, drawing is on the main thread.
#include <QVTKOpenGLNativeWidget.h>
#include <vtkRenderWindow.h>
#include <QApplication>
#include <QElapsedTimer>
#include <QSurfaceFormat>

#include <filesystem>
#include <fstream>
#include <thread>

#include "batten/apps/documents/document_worker.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/benchmarks/bench.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/meshes/edit_session.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten::studio;

namespace {

constexpr int kMoves = 40;

std::filesystem::path panel(const std::filesystem::path& folder, double edge) {
  const auto file = folder / "panel.toml";
  std::ofstream(file) << "unit = \"mm\"\n[[curve]]\nname = \"rim\"\npoints = [[0,0,0], [400,0,0], "
                         "[400,300,0], [0,300,0], [0,0,0]]\n[mesh]\nedge_length = "
                      << edge << "\n[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = 1\n";
  return file;
}

/// The panel of the benchmark `deform` as an OBJ file, with a scene that lifts its patch.
std::filesystem::path mesh_panel(const std::filesystem::path& folder, int vertices) {
  const batten_test::MeshModel model = batten_test::holed_panel(vertices);
  write_mesh(folder / "panel.obj", model.shells);
  const auto nodes = [](const std::vector<int>& of) {
    std::string list;
    for (const int v : of) list += (list.empty() ? "" : ", ") + std::to_string(v + 1);
    return "nodes = [" + list + "]\n";
  };
  const auto file = folder / "edit.toml";
  std::ofstream(file) << "unit = \"mm\"\nmesh = \"panel.obj\"\n"
                      << "[[select]]\nname = \"strips\"\n"
                      << nodes(model.fixed) << "[[select]]\nname = \"patch\"\n"
                      << nodes(model.handle)
                      << "[[features]]\nof = [\"hole-*\"]\n[[edit]]\nname = \"lift\"\nfixed = "
                         "\"strips\"\n[[edit.handle]]\nname = \"patch\"\ntranslate = [0, 0, 30]\n"
                         "rotate = { axis = [1, 2, 0.5], angle = 20 }\n";
  return file;
}

/// A parameter, and its values during the drag.
struct Slider {
  std::string name;
  double at(int move) const { return middle + size * std::sin(0.3 * move); }
  double middle = 2, size = 1;
};
const Slider kInflate{"swell"}, kLift{"lift.patch.z", 40, 15};

struct Times {
  int triangles = 0;
  double update_ms = 0;  // on the worker thread, from the command to the frame
  double draw_ms = 0;    // taking the frame and drawing it
  long most_behind = 0;  // largest number of updates newer than the drawn one
  double frames = 0;     // frames per second during a continuous drag
};

// Time of an edit, ms, as measured by the benchmark `deform`: all positions, no frame.
double headless_edits(const std::filesystem::path& file) {
  const DeformScene scene = read_deform_scene(file);
  const MeshSource source = read_source(scene.mesh);
  VertexSelector select(scene, source.file, source.prepared.mesh);
  const AttachedNodes attached(source.file.other_elements(), source.prepared.mesh, scene.following);
  const SharedConstraints shared =
      gather_shared_constraints(scene, select, attached, source.prepared.mesh);
  DeformTask task = make_deform_task(scene, scene.edits[0], shared, select, source.prepared.mesh);
  FormFeatureDeformer deformer(source.prepared.mesh, task.problem);
  std::vector<double> times;
  for (int i = 0; i < kMoves; ++i)
    times.push_back(bench::wall_seconds_of([&] {
      task.edit.handles[0].translation.z() = kLift.at(i);
      deformer.deform(task.edit);
    }));
  return 1e3 * bench::median(times);
}

// Time of an update of a session alone, ms, as measured by the benchmark `drag`.
double headless_updates(const std::filesystem::path& file) {
  Document document;
  document.apply({.kind = DocumentCommand::CommandKind::Open, .file = file});
  SculptingSession& session = *document.session();
  Frame frame;
  session.draw(frame);
  std::vector<double> times;
  for (int i = 0; i < kMoves; ++i)
    times.push_back(bench::wall_seconds_of([&] {
      session.set(kInflate.name, kInflate.at(i));
      session.solve_preview();
      session.draw(frame);
    }));
  return 1e3 * bench::median(times);
}

class Drag {
 public:
  Drag(const std::filesystem::path& file, Slider slider)
      : slider_(std::move(slider)),
        worker_([] {}),
        view_(nullptr, {[](DocumentCommand) {}, {}, {}, [](const QString&) {}}) {
    view_.resize(1000, 700);
    view_.show();
    QApplication::processEvents();
    worker_.post({.kind = DocumentCommand::CommandKind::Open, .file = file});
    while (true) {
      const auto update = worker_.take_update();
      view_.refresh(update);
      if (update.view && update.view->surface) {
        times.triangles = update.view->triangles;
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  void one_by_one() {
    std::vector<double> updates, draws;
    for (int i = 0; i < kMoves; ++i) {
      DocumentWorker::Update update;
      updates.push_back(bench::wall_seconds_of([&] {
        worker_.post({.kind = DocumentCommand::CommandKind::SetSlider,
                      .key = slider_.name,
                      .value = slider_.at(i)});
        for (update = worker_.take_update(); !update.frame; update = worker_.take_update())
          std::this_thread::sleep_for(std::chrono::microseconds(50));
      }));
      draws.push_back(draw(update));
      while (worker_.take_update().busy) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    times.update_ms = 1e3 * bench::median(updates);
    times.draw_ms = 1e3 * bench::median(draws);
  }

  // A continuous drag: each iteration posts a move and draws the newest frame.
  void at_once() {
    QElapsedTimer clock;
    clock.start();
    int frames = 0;
    long drawn = 0;
    for (int i = 0; clock.elapsed() < 3000; ++i) {
      worker_.post({.kind = DocumentCommand::CommandKind::SetSlider,
                    .key = slider_.name,
                    .value = slider_.at(i)});
      const auto update = worker_.take_update();
      if (!update.frame) continue;
      // Intermediate frames that are skipped do not count: the newest one is drawn.
      const auto newer = worker_.take_update();
      if (newer.frame) {
        times.most_behind = std::max(times.most_behind, newer.frame->number - update.frame->number);
        draw(newer);
      } else {
        draw(update);
      }
      ++frames;
      drawn = std::max(drawn, times.most_behind);
    }
    times.frames = 1e3 * frames / static_cast<double>(clock.elapsed());
  }

  Times times;

 private:
  double draw(const DocumentWorker::Update& update) {
    return bench::wall_seconds_of([&] {
      view_.refresh(update);
      view_.renderWindow()->WaitForCompletion();
      QApplication::processEvents();
    });
  }
  Slider slider_;
  DocumentWorker worker_;
  ShapeView view_;
};

}  // namespace

int main(int argc, char** argv) {
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QApplication application(argc, argv);
  const auto folder = std::filesystem::temp_directory_path() / "batten_bench_studio";
  std::filesystem::create_directories(folder);
  bench::Table table;
  table.add({"", "triangles", "session ms", "update ms", "draw ms", "frames/s", "behind"});
  bench::Checks checks;
  const auto measure = [&](const std::string& name, double session_ms,
                           const std::filesystem::path& file, const Slider& slider) {
    Drag drag(file, slider);
    drag.one_by_one();
    drag.at_once();
    const Times& t = drag.times;
    table.add({name, std::to_string(t.triangles), bench::text("%.2f", session_ms),
               bench::text("%.2f", t.update_ms), bench::text("%.2f", t.draw_ms),
               bench::text("%.1f", t.frames), std::to_string(t.most_behind)});
    checks.at_most("update over session, " + name, t.update_ms / session_ms, 1.1);
    checks.at_most("updates behind, " + name, static_cast<double>(t.most_behind), 1);
  };
  for (const auto& [name, edge] :
       {std::pair("5k", 7.44), std::pair("20k", 3.72), std::pair("100k", 1.665)}) {
    if (argc > 1 && std::string(argv[1]) != name) continue;
    const auto file = panel(folder, edge);
    measure(name, headless_updates(file), file, kInflate);
  }
  for (const auto& [name, vertices] :
       {std::pair("mesh 14k", 14000), std::pair("mesh 100k", 100000)}) {
    if (argc > 1 && std::string(argv[1]) != name) continue;
    const auto file = mesh_panel(folder, vertices);
    measure(name, headless_edits(file), file, kLift);
  }
  std::filesystem::remove_all(folder);
  table.print();
  checks.print("studio");
  return 0;
}
