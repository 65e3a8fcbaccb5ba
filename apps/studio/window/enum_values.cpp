#include "batten/apps/studio/window/enum_values.h"

#include <algorithm>

namespace batten::studio {
namespace {

struct KeyValues {
  const char *kinds, *key, *values;  // apart by blanks; kinds "": the top of a scene, "*": any
};

constexpr KeyValues kKeyValues[] = {
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

QStringList enum_values(const SceneTable& table, const std::string& key, const std::string& value,
                        bool faired) {
  if (value == "true" || value == "false") return {"true", "false"};
  for (const KeyValues& one : kKeyValues) {
    const QStringList kinds = QString(one.kinds).split(' ');
    if (key != one.key || !kinds.contains(QString::fromStdString(table.kind))) continue;
    const bool more = faired && table.kind == "join";
    QStringList values;
    for (const QString& word : (one.values + QString(more ? " tangent curvature" : "")).split(' '))
      values << '"' + word + '"';
    const QString now = QString::fromStdString(value);
    return values.contains(now) ? values : QStringList{};
  }
  return {};
}

}  // namespace batten::studio
