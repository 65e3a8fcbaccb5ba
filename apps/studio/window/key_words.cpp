#include "batten/apps/studio/window/key_words.h"

#include <algorithm>

namespace batten::studio {
namespace {

struct KeyWords {
  const char *kinds, *key, *words;  // apart by blanks; kinds "": the top of a scene, "*": any
};

constexpr KeyWords kKeyWords[] = {
    {"", "unit", "mm cm m in ft"},
    {"line lines", "role", "outline hole inner"},
    {"line lines", "treatment", "auto fitted embedded"},
    {"region", "domain", "auto polygon plane sheet"},
    {"join", "kind", "crease smooth"},
    {"weight", "kind", "alpha beta"},
    {"skin", "domain", "auto polygon plane sheet ring"},
    {"skin", "mesher", "delaunay fan"},
    {"skin", "units", "relative absolute"},
    {"skin", "hold", "lines corners"},
    {"skin", "fair", "auto bending variation loft"},
    {"skin", "element", "hct z12"},
    {"skin", "symmetry", "x y z"},
    {"feature features", "keep", "shape direction"},
    {"output", "step_form", "auto face exact"},
};

}  // namespace

QStringList words_of_key(const SceneTable& table, const std::string& key, const std::string& value,
                         bool faired) {
  if (value == "true" || value == "false") return {"true", "false"};
  for (const KeyWords& one : kKeyWords) {
    const QStringList kinds = QString(one.kinds).split(' ');
    if (key != one.key || !kinds.contains(QString::fromStdString(table.kind))) continue;
    const bool more = faired && table.kind == "join";
    QStringList words;
    for (const QString& word : (one.words + QString(more ? " tangent curvature" : "")).split(' '))
      words << '"' + word + '"';
    const QString now = QString::fromStdString(value);
    return words.contains(now) ? words : QStringList{};
  }
  return {};
}

}  // namespace batten::studio
