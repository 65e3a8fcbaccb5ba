// The words that a key of a scene may have, for lists to choose from.
#pragma once

#include <QStringList>
#include <string>

#include "batten/io/scene/scene_text.h"

namespace batten::studio {

/// The values, as TOML writes them, of a key that has a few: "true" and "false" where the value is one
/// of these, the words that docs/scenes.md names else; none for all other keys. The value itself is
/// always among them. `faired`: the scene's [skin] has fair = "variation", which knows more joins.
QStringList enum_values(const SceneTable& table, const std::string& key, const std::string& value,
                        bool faired);

}  // namespace batten::studio
