// The light and the dark look of all widgets.
#pragma once

#include <QApplication>
#include <QPalette>

namespace batten::studio {

/// Gives the program Qt's Fusion style in light or dark colours.
inline void apply_theme(QApplication& application, bool dark) {
  application.setStyle("Fusion");
  QPalette palette;
  const auto set = [&](QPalette::ColorRole role, const char* light, const char* night) {
    palette.setColor(role, QColor(dark ? night : light));
  };
  set(QPalette::Window, "#f2f4f7", "#26292e");
  set(QPalette::WindowText, "#1d2127", "#e4e7ec");
  set(QPalette::Base, "#ffffff", "#1d2024");
  set(QPalette::AlternateBase, "#eef1f5", "#2b2f35");
  set(QPalette::Text, "#1d2127", "#e4e7ec");
  set(QPalette::Button, "#e8ebf0", "#31353c");
  set(QPalette::ButtonText, "#1d2127", "#e4e7ec");
  set(QPalette::ToolTipBase, "#fffbe6", "#3a3f47");
  set(QPalette::ToolTipText, "#1d2127", "#e4e7ec");
  set(QPalette::Highlight, "#2f6fb3", "#3d7fc4");
  set(QPalette::HighlightedText, "#ffffff", "#ffffff");
  set(QPalette::PlaceholderText, "#8a919c", "#7d848f");
  for (const auto role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText})
    palette.setColor(QPalette::Disabled, role, QColor(dark ? "#6b727c" : "#9aa1ab"));
  application.setPalette(palette);
}

}  // namespace batten::studio
