// SPDX-License-Identifier: MPL-2.0
// batten-studio: the graphical editor.
#include <QVTKOpenGLNativeWidget.h>
#include <QApplication>
#include <QDir>
#include <QLockFile>
#include <QMessageBox>
#include <QSettings>
#include <QStandardPaths>

#include <fstream>
#include <iostream>
#include <memory>

#include "batten/apps/studio/view/strings.h"
#include "batten/apps/studio/window/main_window.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/display.h"

/// Replaces a function of OpenBLAS, as in apps/cli/main.cpp: no threads.
extern "C" __attribute__((visibility("default"))) int openblas_num_threads_env() { return 1; }

namespace {

using namespace batten::studio;

/// Recovery file for the changes of this window, and a lock that shows that the window is alive.
/// Changes that killed windows have left are offered once.
struct Recovery {
  QString file;
  std::unique_ptr<QLockFile> lock;
  QString left;  // recovery file of a killed window; empty: none
};

Recovery recovery() {
  Recovery found;
  QDir folder(QStandardPaths::writableLocation(QStandardPaths::AppDataLocation));
  if (!folder.mkpath(".")) return found;
  for (int number = 1; number < 100; ++number) {
    const QString file = folder.filePath(QString("changes-%1.toml").arg(number));
    auto lock = std::make_unique<QLockFile>(file + ".lock");
    lock->setStaleLockTime(0);
    if (!lock->tryLock(0)) continue;  // in use by another window
    if (QFile::exists(file) && found.left.isEmpty()) found.left = file;
    found.file = file;
    found.lock = std::move(lock);
    break;
  }
  return found;
}

QString name_in(const QString& left) {
  std::ifstream file(left.toStdString());
  std::string line;
  std::getline(file, line);
  const size_t slash = line.find('/');
  return slash == std::string::npos ? text(kUntitled) : QString::fromStdString(line.substr(slash));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--help") {
    std::cout
        << "Graphical editor for surfaces, meshes and mesh sequences\nUsage: batten-studio "
           "[FILE]\n\n"
           "FILE is a scene, a file of curves, a mesh or a mesh sequence. Without FILE, the window "
           "opens an empty scene, or a guided tour at the first start.\n";
    return 0;
  }
  try {
    batten::require_visible_display();
  } catch (const batten::Error& e) {
    std::cerr << "batten-studio: "
              << batten::printable(e.what(), batten::LineFeeds::KeepBeforeIndent) << "\n";
    return 1;
  }
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QCoreApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QCoreApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
  QApplication application(argc, argv);
  QApplication::setOrganizationName("batten");
  QApplication::setApplicationName("studio");
  const Recovery kept = recovery();
  MainWindow window(kept.file.toStdString());
  window.show();
  if (!kept.left.isEmpty() &&
      QMessageBox::question(&window, text(kProgram), text(kRecover).arg(name_in(kept.left))) ==
          QMessageBox::Yes)
    window.recover(kept.left.toStdString());
  else if (argc > 1)
    window.open(argv[1]);
  else if (QSettings seen; !seen.value("toured", false).toBool()) {
    seen.setValue("toured", true);
    window.start_tour();
  }
  return QApplication::exec();
}
