// SPDX-License-Identifier: MPL-2.0
// Implementation of a sculpting session: its state, history and operations.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/progress.h"
#include "batten/fem/refinement.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/sculpting/session/undo_history.h"

namespace batten {
namespace detail {

inline constexpr const char* kAxes[] = {".x", ".y", ".z"};
inline constexpr size_t kRecordPage = 4096;  // operations per page of a record

struct SessionDisplay {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const DisplayTopology> pattern;
  std::unique_ptr<DisplayPoints> points;
};

template <class Items, class Name>
int find(const Items& things, const Name& name_of, const std::string& name) {
  for (size_t i = 0; i < things.size(); ++i)
    if (name_of(*things[i]) == name) return static_cast<int>(i);
  return -1;
}
inline const std::string& name_of(const AttachedLoad& p) { return p.load.name; }
inline const std::string& name_of(const AttachedStiffnessField& p) { return p.weight.name; }
inline const std::string& name_of(const AttachedConstraint& p) { return p.constraint.name; }
inline const std::string& name_of(const AttachedOffset& p) { return p.move.name; }

template <class Items>
int index_of(const Items& things, const std::string& name) {
  return find(
      things, [](const auto& p) -> const std::string& { return name_of(p); }, name);
}

}  // namespace detail

/// A state of a session that other sessions can start from. Its system has no factors, and nothing
/// in it is ever changed.
struct SessionSnapshot {
  SessionOptions options;
  detail::SessionState state;
};

struct SessionData {
  SessionOptions options;
  detail::SessionState now;
  detail::UndoHistory history;
  bool coalesces = false;  // the current set() or step() belongs to the last history step
  bool recording = false;
  std::vector<Operation> record;
  detail::SessionEngine engine;
  std::vector<double> values, before;
  std::vector<std::string> value_names;
  detail::SessionDisplay display;
  Frame frame;
  long frames = 0, version = 0, shown = -1;  // shown: version of the shape that was drawn last
  Progress progress;

  detail::SessionSystem& system() { return *now.system; }
  const ModelLayout& layout() { return now.system->layout(); }
  double size() { return layout().size(); }
  Points absolute(const Points& x) {
    return x + system().parts->ones * system().origin().transpose();
  }
  Surface surface() { return layout().surface(absolute(now.shape.x)); }

  // -- history ------------------------------------------------------------------------------------
  detail::SessionState snapshot() const;
  void push_history(detail::SessionState before);
  void restore_state(detail::SessionState state);
  void record_operation(const Operation& op);
  // Records an operation and calls run(). A cancelled operation changes nothing, so that it is
  // removed from the record.
  template <class Run>
  auto recorded(const Operation& op, const Run& run) {
    record_operation(op);
    try {
      return run();
    } catch (const CancelledError&) {
      if (recording) record.pop_back();
      throw;
    }
  }
  // Changes parameter values; a whole drag is one step of the history. A rejected value leaves no
  // step.
  template <class Change>
  void change_values(const Change& change) {
    if (coalesces) {
      change();
      return;
    }
    detail::SessionState before = snapshot();
    change();
    push_history(std::move(before));
    coalesces = true;
  }

  // -- solves -----------------------------------------------------------------------------------
  void read_values() { values = now.parameters.values(); }
  void require_matrix();
  void mark_converged();
  void restore_converged();
  detail::SessionEngine::SolveStatus step_loads(const std::vector<double>& goal);
  bool has_point_clouds();
  bool plan_joins();
  Points deformed_from(std::shared_ptr<const detail::RestConfiguration> rest);
  void update_rest_shape(bool anew);
  SolveReport solve_to_equilibrium_or_keep();
  SolveReport solve_to_equilibrium(bool anew = true);
  SolveReport solve_once(bool anew);
  SolveReport solve_preview(int most, double tolerance);
  SolveReport step();

  // -- edits --------------------------------------------------------------------------------------
  void rebuild(detail::SessionDefinition def);
  void update_value_names();
  void solve_constrained();
  void keep_shape();
  void require_free_name(const std::string& name);
  void add_parameters(const std::string& name, std::vector<ScalarParameter> given,
                      const std::vector<std::string>& wanted, const std::vector<double>& start);
  void add(const Load& load, const std::vector<ScalarParameter>& parameters);
  void add(const StiffnessField& weight, const std::vector<ScalarParameter>& parameters);
  void add(const Constraint& constraint, const std::vector<ScalarParameter>& parameters);
  void add(const LineOffset& move, const std::vector<ScalarParameter>& parameters);
  void add(const CharacterLine& line, const std::vector<ScalarParameter>& parameters);
  void require_lines(const char* what);
  SurfaceTransfer change_layout(ModelLayout layout);
  SurfaceTransfer transferred(const ModelLayout& layout, const Points& dofs);
  void transfer_reference_shapes(const ModelLayout& layout, detail::SessionDefinition& def);
  void change(const Constraint& constraint);
  std::vector<std::string> names();
  void remove(const std::string& name);
  void require_unused(const std::string& line);
  void set_line(const std::string& name, const HermiteCurve& curve);
  void start_motion(const Motion& m);
  RefinementReport refine(const Refinement& refinement);
  HermiteCurve line(const std::string& name);
  SkinnedRegion skinned_region(int region);
  void draw(Frame& to);
  double elastic_energy(const Points& x);
  void edit(const Operation::Edit& edit);
};

}  // namespace batten
