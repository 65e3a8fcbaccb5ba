// Functions by which scenes read selections and features. Internal.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene_selections.h"
#include "batten/io/scene/scene_words.h"

namespace batten {

PlacedWord word_of(const TomlTable& table, const std::string& key);
/// Whole numbers of nodes. Throws InputError for others.
long label_of(const TomlTable& table, const std::string& key, double value);
std::vector<long> labels_of(const TomlTable& table, const std::string& key);

/// [proposals]: what features are proposed.
void read_proposals(const TomlTable& root, ProposalOptions& options);
/// [[select]] and [[cut]], which share their names. Files are relative to `folder`.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene);
/// [[feature]] one by one, and [[features]], many of a kind. `kept`: names that are taken.
std::vector<FeatureRule> read_features(const TomlTable& root, Names& kept);

}  // namespace batten
