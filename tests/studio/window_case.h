// SPDX-License-Identifier: MPL-2.0
// Operates the window with synthetic mouse and keyboard events, under a virtual display.
#pragma once

#include <QVTKOpenGLNativeWidget.h>
#include <QApplication>
#include <QImage>
#include <QPushButton>
#include <QSurfaceFormat>
#include <QtTest/QTest>

#include <cstdlib>

#include "batten/apps/documents/line_edits.h"
#include "batten/apps/studio/window/main_window.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {

inline const std::filesystem::path kExamples = BATTEN_SOURCE_DIR "/examples";

/// The one QApplication of the program, with settings of its own.
inline QApplication& application() {
  static const std::filesystem::path folder = [] {
    const auto path = scratch("studio_settings");
    setenv("XDG_CONFIG_HOME", path.c_str(), 1);
    setenv("XDG_DATA_HOME", path.c_str(), 1);
    setenv("XDG_RUNTIME_DIR", path.c_str(), 1);
    QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
    return path;
  }();
  static int argc = 1;
  static char name[] = "test_studio";
  static char* argv[] = {name, nullptr};
  static QApplication* const application = [] {
    auto* made = new QApplication(argc, argv);  // never deleted: must outlive everything else
    QApplication::setOrganizationName("batten");
    QApplication::setApplicationName("studio-test");
    return made;
  }();
  return *application;
}

/// A visible window, and the actions of a user in it.
class WindowCase {
 public:
  WindowCase() {
    application();
    window = std::make_unique<batten::studio::MainWindow>();
    window->show();
    REQUIRE(QTest::qWaitForWindowExposed(window.get()));
    REQUIRE(window->wait());
  }

  batten::studio::ShapeView& view() { return window->view(); }
  const batten::DocumentView& document() { return window->document(); }
  void open(const std::filesystem::path& file) {
    window->open(file);
    REQUIRE(window->wait(300));
  }
  /// Creates straight curves "side 1", "side 2", … along the sides of a rectangle on the ground.
  std::vector<batten::Vec3> draw_sides() {
    const std::vector<batten::Vec3> corners = {{0, 0, 0}, {200, 0, 0}, {200, 120, 0}, {0, 120, 0}};
    for (size_t i = 0; i < 4; ++i)
      window->post(batten::line_command("side " + std::to_string(i + 1),
                                        {corners[i], corners[(i + 1) % 4]}));
    REQUIRE(window->wait());
    return corners;
  }
  /// Triggers the action of a menu or tool, by its text.
  void act(const char* what) {
    QAction* action = window->action(what);
    REQUIRE(action);
    action->trigger();
    REQUIRE(window->wait());
  }
  /// Presses a button of the property panel, by its text.
  void press(const char* what) {
    REQUIRE(window->properties().button(what));
    QTest::mouseClick(window->properties().button(what), Qt::LeftButton);
    REQUIRE(window->wait());
  }
  void click(const batten::Vec3& p) { click(view().pixel_of(p)); }
  void click(const QPoint& at) {
    QTest::mouseMove(&view(), at);
    QTest::mouseClick(&view(), Qt::LeftButton, {}, at);
    REQUIRE(window->wait());
  }
  /// Presses at a point, moves the pointer by `by` pixels in small steps, and releases.
  void drag(const batten::Vec3& from, const QPoint& by, int steps = 12) {
    const QPoint at = view().pixel_of(from);
    QTest::mousePress(&view(), Qt::LeftButton, {}, at);
    REQUIRE(window->wait());
    for (int i = 1; i <= steps; ++i) {
      move(at + by * i / steps);
      QTest::qWait(15);
    }
    REQUIRE(window->wait());
    move(at + by);
    REQUIRE(window->wait());
    QTest::mouseRelease(&view(), Qt::LeftButton, {}, at + by);
    REQUIRE(window->wait());
  }
  /// Presses at the first of these points, moves along them, and releases at the last.
  void stroke(const std::vector<QPoint>& points, Qt::KeyboardModifiers keys = {}) {
    QTest::mousePress(&view(), Qt::LeftButton, keys, points.front());
    constexpr int steps = 8;
    for (size_t i = 0; i + 1 < points.size(); ++i)
      for (int k = 1; k <= steps; ++k)
        move(points[i] + (points[i + 1] - points[i]) * k / steps, keys);
    QTest::mouseRelease(&view(), Qt::LeftButton, keys, points.back());
    REQUIRE(window->wait());
  }
  void move(const QPoint& at, Qt::KeyboardModifiers keys = {}) {
    QMouseEvent event(QEvent::MouseMove, at, view().mapToGlobal(at), Qt::NoButton, Qt::LeftButton,
                      keys);
    QApplication::sendEvent(&view(), &event);
  }
  void key(int key) {
    QTest::keyClick(&view(), static_cast<Qt::Key>(key));
    REQUIRE(window->wait());
  }
  /// Writes a picture of the window to studio-pictures in the build folder.
  QImage picture(const std::string& name) {
    QTest::qWait(300);  // a still picture is antialiased
    const QImage image = window->grab().toImage();
    const std::filesystem::path folder = BATTEN_BINARY_DIR "/studio-pictures";
    std::filesystem::create_directories(folder);
    REQUIRE(image.save(QString::fromStdString((folder / (name + ".png")).string())));
    return image;
  }

  std::unique_ptr<batten::studio::MainWindow> window;
};

}  // namespace batten_test
