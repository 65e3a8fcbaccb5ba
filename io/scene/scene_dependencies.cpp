#include "batten/io/scene/scene_dependencies.h"

#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

constexpr const char* kActing[] = {"load", "weight", "move", "constraint", "parameter"};
/// What is made of a shape, and does not change it.
constexpr const char* kMadeOf[] = {"motion", "picture", "sweep", "output",
                                   "stress", "compare", "name"};

void erase_number(toml::table& table, const char* key) {
  if (table.contains(key) && table.get(key)->is_number()) table.erase(key);
}

}  // namespace

SceneDependencies scene_dependencies(const SceneText& scene) {
  SceneDependencies parts;
  toml::table root = parse_toml(scene.text(), {}, "a scene");
  for (const char* kind : kActing) {
    int number = 0;
    if (toml::array* list = root[kind].as_array())
      for (toml::node& node : *list) {
        toml::table* table = node.as_table();
        if (!table) continue;
        ++number;
        const std::string name =
            (*table)["name"].value_or(std::string("#") + std::to_string(number));
        erase_number(*table, "value");
        table->erase("to");
        parts.session_parts[std::string(kind) + " " + name] = to_toml(*table);
      }
    root.erase(kind);
  }
  for (const char* kind : kMadeOf) root.erase(kind);
  if (toml::table* skin = root["skin"].as_table()) {
    for (const char* key : {"alpha", "beta"}) erase_number(*skin, key);
    if (const auto boundary = (*skin)["hold"].value<std::string>())
      parts.session_parts["skin hold"] = *boundary;  // a session's own
  }
  parts.model = to_toml(root);
  root.erase("skin");
  parts.lines = to_toml(root);
  return parts;
}

}  // namespace batten
