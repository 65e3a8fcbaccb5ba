// SPDX-License-Identifier: MPL-2.0
// Contents of a Stress, for the front ends of Batten.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/io/report/report.h"
#include "batten/scenes/model_data.h"
#include "batten/scenes/stress.h"

namespace batten::detail {

/// The table [stress] as TOML text on single lines. Messages name supports[0], … and the keys.
struct StressTable {
  std::vector<std::pair<std::string, std::string>> values;  ///< keys with their values
  std::vector<std::string> supports, loads;                 ///< inline tables: { curve = "rim" }
  std::string settings = {};                                ///< further keys, any number of lines
  double accuracy = 0;  ///< StressSettings::accuracy; not part of the text
  bool empty() const;
  bool operator==(const StressTable&) const = default;
};

/// The settings as text. Throws InputError for numbers that are not finite.
StressTable stress_table(const StressSettings& settings);
/// Reads a table as the [stress] of a scene with this unit. The locations in its messages refer to
/// the file kStressFile; with_settings() replaces them.
SceneStress parsed_table(const StressTable& table, const std::string& unit);
inline constexpr const char* kStressFile = "stress()";
/// A message in which the setting that a line of the table comes from replaces its location:
/// "stress() supports[0]: found …".
std::string with_settings(const StressTable& table, const std::string& unit,
                          const std::string& message);

/// stress() for settings as text. Throws its exceptions.
Stress stress_of_table(const Model& model, const StressTable& table, const Progress& progress);

/// Results of a stress analysis. Immutable, apart from what is computed at the first use. Keeps no
/// factorization: a study may keep many of them.
struct StressData {
  explicit StressData(std::shared_ptr<const ModelData> of) : model(std::move(of)) {}

  std::shared_ptr<const ModelData> model;
  Scene scene;        ///< the scene of the model with this [stress]
  std::string table;  ///< [stress] with its header; empty: that of the model
  StressReport report;
  std::vector<std::string> warnings, failed_checks;
  std::vector<StressCase> cases;
  size_t governing = 0;
  std::vector<ShellSection> sections;                ///< one, or one per triangle
  std::vector<Points> displacements;                 ///< dofs of each case, n×3
  std::vector<ShellTemperature> temperatures;        ///< of each case
  std::vector<std::vector<Points>> buckling_shapes;  ///< of each case
  std::vector<Points> mode_shapes;

  /// Index of a load case; "": the governing one. Throws InputError for an unknown name.
  size_t index(const std::string& load_case) const;
  StressPoint at(const Vec3& p, size_t load_case) const;
  const std::vector<double>& von_mises(size_t load_case) const;
  std::vector<double> von_mises(size_t load_case, const std::string& side) const;
  std::vector<double> thickness() const;
  const std::vector<double>& displacement(size_t load_case) const;
  /// One of these mode shapes at the points of the model's facets. `key`: the setting for them.
  std::vector<double> mode(const std::vector<Points>& shapes, int index,
                           const std::string& key) const;

 private:
  struct Fields {
    std::unique_ptr<const ShellStresses> stresses;
    std::unique_ptr<const Surface> moved;  // whose positions are displacements
    std::unique_ptr<const std::vector<double>> von_mises, displacement;
  };
  // The following functions need the lock.
  Fields& fields(size_t load_case) const;
  const ShellStresses& made_stresses(size_t load_case) const;
  const Surface& made_moved(size_t load_case) const;
  std::vector<double> made_positions(const Surface& surface) const;
  /// value(stress) at the points of the model's facets.
  template <class Value>
  std::vector<double> made_values(size_t load_case, const Value& value) const;

  mutable std::mutex mutex_;
  mutable std::unique_ptr<const ShellAssembler> assembler_;
  mutable std::vector<Fields> fields_;
};

}  // namespace batten::detail
