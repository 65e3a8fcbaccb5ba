// The window's files: opened, saved, exported, and the guard of changes that are not saved.
#include <QCloseEvent>
#include <QDir>
#include <QFile>
#include <QFileDialog>
#include <QFileInfo>
#include <QListWidget>
#include <QMenu>
#include <QMessageBox>
#include <QMimeData>
#include <QSettings>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/apps/studio/window/main_window.h"

namespace batten::studio {
namespace {

using CommandKind = DocumentCommand::CommandKind;

/// A menu's text as a title.
QString title(const char* menu) { return text(menu).remove('&'); }

}  // namespace

void MainWindow::ask_open() {
  if (!may_close()) return;
  const QString file =
      QFileDialog::getOpenFileName(this, title(kOpen), in_folder(), text(kSceneFiles));
  if (!file.isEmpty()) open(file.toStdString());
}

void MainWindow::save(bool as) {
  // The door of the tour is everybody's: it is saved elsewhere.
  if (!as && !touring_ && shown_->title != "untitled") return post({.kind = CommandKind::Save});
  QString file = QFileDialog::getSaveFileName(this, title(kSaveAs), in_folder(stem() + ".toml"),
                                              text(kSavedFiles));
  if (file.isEmpty()) return;
  if (!file.endsWith(".toml")) file += ".toml";
  note_recent(file);
  post({.kind = CommandKind::Save, .file = file.toStdString()});
}

// A name for what is written, without its ending.
QString MainWindow::stem() const {
  const std::string& name = shown_->title == "untitled" && !shown_->regions.empty() && shown_->mesh
                                ? shown_->regions.front()
                                : shown_->title;
  return QFileInfo(shown(name)).completeBaseName();
}

void MainWindow::ask_export() {
  QString filter;
  QString kinds = text(kExportFiles);
  if (shown_->mesh) {
    const QString ending = QFileInfo(shown(shown_->regions.front())).suffix();
    kinds = text(kMeshFiles);
    if (!shown_->timeline) kinds = text(kOriginalFormat).arg("." + ending) + ";;" + kinds;
  }
  QString file = QFileDialog::getSaveFileName(this, title(kExport), in_folder(stem() + "-out"),
                                              kinds, &filter);
  if (file.isEmpty()) return;
  const int star = filter.indexOf("*.");
  if (!file.contains('.') && star >= 0)
    file += filter.mid(star + 1, filter.indexOf(')') - star - 1);
  post({.kind = CommandKind::Export, .file = file.toStdString()});
}

void MainWindow::save_script() {
  const QString name =
      QFileDialog::getSaveFileName(this, title(kSaveScript), in_folder(), text(kScriptFiles));
  if (name.isEmpty()) return;
  QFile file(name);
  if (!file.open(QIODevice::WriteOnly)) {
    messages_->addItem(name + ": " + file.errorString());
    return;
  }
  for (const std::string& line : worker_->script()) file.write((line + "\n").c_str());
}

void MainWindow::remove_selected() {
  if (view_->remove_point()) return;
  ModelTree::Item item = tree_->current();
  if (item.kind == ModelTree::Item::Kind::Join)
    item.table = {"line", defining_line(SceneText(shown_->text), item.name)};
  if (item.table.kind == "line" && item.table.name.empty()) return;  // of a file
  if (const auto part = properties_->selected_stress_part()) {
    for (DocumentCommand& edit : remove_stress_part(SceneText(shown_->text), *part))
      post(std::move(edit));
    return;
  }
  if (!item.table.kind.empty()) post({.kind = CommandKind::Remove, .table = item.table});
}

// A name in the folder of the last scene that was opened or saved; the home folder before.
QString MainWindow::in_folder(const QString& name) const {
  const QString last = QSettings().value("recent").toStringList().value(0);
  const QDir folder(touring_ || last.isEmpty() ? QDir::homePath() : QFileInfo(last).path());
  return name.isEmpty() ? folder.path() : folder.filePath(name);
}

void MainWindow::note_recent(const QString& file) {
  QStringList files = QSettings().value("recent").toStringList();
  files.removeAll(file);
  files.prepend(file);
  while (files.size() > 10) files.removeLast();
  QSettings().setValue("recent", files);
  fill_recent();
}

void MainWindow::fill_recent() {
  recent_->clear();
  for (const QString& file : QSettings().value("recent").toStringList())
    QObject::connect(recent_->addAction(file), &QAction::triggered, this, [this, file] {
      if (may_close()) open(file.toStdString());
    });
  recent_->setEnabled(!recent_->isEmpty());
}

bool MainWindow::may_close() {
  if (!shown_->changed) return true;
  const auto answer = QMessageBox::question(
      this, text(kProgram), text(kUnsaved).arg(QString::fromStdString(shown_->title)),
      QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel,
      touring_ ? QMessageBox::Discard : QMessageBox::Save);
  if (answer == QMessageBox::Cancel) return false;
  if (answer == QMessageBox::Discard) return true;
  save(false);
  wait();
  return !shown_->changed;
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (!may_close()) return event->ignore();
  worker_->discard_changes();
  event->accept();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QString file = event->mimeData()->urls().value(0).toLocalFile();
  if (!file.isEmpty() && may_close()) open(file.toStdString());
}

}  // namespace batten::studio
