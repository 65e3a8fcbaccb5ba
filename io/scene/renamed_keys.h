// Keys of older versions of Batten, and names that other programs use for the same things.
#pragma once

#include <string>

namespace toml {
inline namespace v3 {
class table;
}  // namespace v3
}  // namespace toml

namespace batten {

/// Kinds of scenes, which have different keys.
enum class SceneKind { Surface, Deform, Sequence };

/// Throws InputError "FILE:LINE:COLUMN: found the key 'line' …, expected 'curve'" at the first key
/// or value of `root`, in the order of the file, that has another name now. Other unknown keys are
/// left to TomlTable.
void refuse_renamed_keys(const toml::table& root, SceneKind kind, const std::string& file);

}  // namespace batten
