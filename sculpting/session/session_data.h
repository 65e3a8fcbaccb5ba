// Inside of a sculpting session: its state, its history, and its operations.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "batten/fem/surface_transfer.h"
#include "batten/sculpting/session/session.h"
#include "batten/sculpting/session/session_engine.h"

namespace batten {
namespace live {

// All that undo puts back.
struct State {
  std::shared_ptr<System> system;
  Parameters parameters;
  Shape shape;
  bool in_motion = false;
  Motion motion;
  std::vector<double> shape_values;  // values of the parameters when the shape was made
  // The last answer that converged.
  Points good_x;
  std::shared_ptr<const Rest> good_rest;
  std::vector<double> good_values;
  std::vector<char> fresh;  // parameters that have not acted on the shape yet: good at 0
};

inline constexpr const char* kAxes[] = {".x", ".y", ".z"};
inline constexpr size_t kPage = 4096;  // of a record

struct Display {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const DisplayPattern> pattern;
  std::unique_ptr<DisplayPoints> points;
};

template <class Things, class Name>
int find(const Things& things, const Name& name_of, const std::string& name) {
  for (size_t i = 0; i < things.size(); ++i)
    if (name_of(*things[i]) == name) return static_cast<int>(i);
  return -1;
}
inline const std::string& name_of(const PlacedLoad& p) { return p.load.name; }
inline const std::string& name_of(const PlacedWeight& p) { return p.weight.name; }
inline const std::string& name_of(const PlacedConstraint& p) { return p.constraint.name; }
inline const std::string& name_of(const PlacedMove& p) { return p.move.name; }

template <class Things>
int index_of(const Things& things, const std::string& name) {
  return find(
      things, [](const auto& p) -> const std::string& { return name_of(p); }, name);
}

}  // namespace live

struct SculptingSession::Data {
  SessionOptions options;
  live::State now;
  std::deque<live::State> undone_to, redone_to;
  bool joins = false;  // what is set or stepped now belongs to the last step of the history
  bool recording = false;
  std::vector<Operation> record;
  live::Engine engine;
  std::vector<double> values, before;
  std::vector<std::string> value_names;
  live::Display display;
  Frame frame;
  long frames = 0, version = 0, shown = -1;  // the version of the shape that was drawn
  Progress progress;

  live::System& system() { return *now.system; }
  const ModelLayout& layout() { return now.system->layout(); }
  double size() { return layout().size(); }
  Points absolute(const Points& x) {
    return x + system().parts->ones * system().origin().transpose();
  }
  Surface surface() { return layout().surface(absolute(now.shape.x)); }

  // -- history ------------------------------------------------------------------------------------
  live::State saved() const;
  void remember(live::State before);
  void remember_start();
  size_t bytes() const;
  void put_back(live::State state);
  bool go(std::deque<live::State>& from, std::deque<live::State>& to);
  void note(const Operation& op);
  // Changes values of parameters, as one step of the history for a whole drag; a value that is
  // refused leaves no step.
  template <class Change>
  void change_values(const Change& change) {
    if (joins) {
      change();
      return;
    }
    live::State before = saved();
    change();
    remember(std::move(before));
    joins = true;
  }

  // -- answers ------------------------------------------------------------------------------------
  void read_values() { values = now.parameters.values(); }
  void mark_good();
  void fall_back();
  live::Engine::Run in_steps(const std::vector<double>& goal);
  bool has_scans();
  bool plan_joins();
  Points bent_from(std::shared_ptr<const live::Rest> rest);
  void find_rest(bool anew);
  Answer settle(bool anew = true);
  Answer settle_once(bool anew);
  Answer quick(int most, double tolerance);
  Answer step();

  // -- edits --------------------------------------------------------------------------------------
  void rebuild(live::Definition def);
  void name_values();
  void hold();
  void stay();
  void require_free_name(const std::string& name);
  void add_parameters(const std::string& name, std::vector<NamedValue> given,
                      const std::vector<std::string>& wanted, const std::vector<double>& start);
  void add(const Load& load, const std::vector<NamedValue>& parameters);
  void add(const WeightField& weight, const std::vector<NamedValue>& parameters);
  void add(const Constraint& constraint, const std::vector<NamedValue>& parameters);
  void add(const LineMove& move, const std::vector<NamedValue>& parameters);
  void add(const CharacterLine& line, const std::vector<NamedValue>& parameters);
  void require_lines(const char* what);
  CarriedOver move_to(ModelLayout layout);
  CarriedOver carried(const ModelLayout& layout, const Points& dofs);
  void carry_places(const ModelLayout& layout, live::Definition& def);
  void change(const Constraint& constraint);
  std::vector<std::string> names();
  std::string near_to(const std::string& name);
  void remove(const std::string& name);
  void refuse_if_used(const std::string& line);
  void set_line(const std::string& name, const HermiteCurve& curve);
  void start_motion(const Motion& m);
  RefinementReport refine(const Refinement& refinement);
  HermiteCurve line(const std::string& name);
  SkinnedRegion made(int region);
  void draw(Frame& to);
  double elastic_energy(const Points& x);
  void edit(const Operation::Edit& edit);
};

}  // namespace batten
