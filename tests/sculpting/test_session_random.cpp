// Operations at random on the door, in one session: rows hold, undo and replay give the same bits,
// memory stays.
#include <cstdio>
#include <map>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "batten/core/errors.h"
#include "batten/tests/catch.h"
#include "session_scenes.h"

using namespace batten_test;

namespace {

RegionLayout coarse_door() { return door_layout(120, 4); }

SessionOptions few_bytes() {
  SessionOptions options;
  options.history_bytes = size_t(48) << 20;
  return options;
}

// Bytes that the program holds; 0 where nobody counts them.
size_t bytes_held() {
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return 0;
#endif
}

class Sculptor {
 public:
  explicit Sculptor(unsigned seed) : random_(seed), session_(coarse_door(), few_bytes()) {
    session_.record(true);
    session_.add(LiveLoad{"swell", LiveLoad::Pressure{}});
    session_.add(LiveLoad{"push", LiveLoad::Uniform{{0, 1, 0}, {}}});
    session_.add(LiveLoad{"finger", LiveLoad::Point{{-100, 60, 0}, {0, 1, 0}}});
    session_.add(WeightField{"stiff", WeightField::Kind::Bending, {Area::NearLine{"rib", 80}}, {}});
    session_.settle();
    normal_size_ =
        (session_.dofs() - Points::Zero(session_.dofs().rows(), 3)).cwiseAbs().maxCoeff();
  }

  SculptingSession& session() { return session_; }
  const std::map<std::string, int>& done() const { return done_; }
  const std::map<std::string, int>& refused() const { return refused_; }
  double worst_residual() const { return worst_; }
  int bits_lost() const { return bits_lost_; }
  bool finite() const { return finite_; }
  int most_triangles() const { return most_triangles_; }

  void operate() {
    const std::string what = draw();
    try {
      perform(what);
      ++done_[what];
    } catch (const Error& e) {
      ++refused_[what];
      last_refusal_ = e.what();
    }
    worst_ = std::max(worst_, session_.residual());
    const Points x = session_.dofs();
    finite_ = finite_ && x.allFinite() && x.cwiseAbs().maxCoeff() < 100 * normal_size_;
    most_triangles_ = std::max(most_triangles_, session_.layout().mesh()->triangle_count());
  }
  const std::string& last_refusal() const { return last_refusal_; }

 private:
  std::string draw() {
    static const std::vector<std::pair<std::string, double>> kinds = {
        {"load", 30},  {"weight", 3},   {"goal", 12},    {"move", 10},  {"add point", 5},
        {"normal", 3}, {"remove", 6},   {"add move", 3}, {"line", 4},   {"inner line", 2},
        {"refine", 2}, {"undo", 10},    {"redo", 4},     {"motion", 3}, {"springs", 2},
        {"settle", 4}, {"undo bits", 4}};
    double sum = 0;
    for (const auto& [name, weight] : kinds) sum += weight;
    double at = random_.between(0, sum);
    for (const auto& [name, weight] : kinds)
      if ((at -= weight) < 0) return name;
    return "load";
  }
  std::vector<std::string> of(const std::string& beginning) {
    std::vector<std::string> some;
    for (const std::string& name : session_.names())
      if (name.rfind(beginning, 0) == 0) some.push_back(name);
    return some;
  }
  template <class List>
  const auto& one_of(const List& list) {
    return list[static_cast<size_t>(random_.between(0, 0.9999) * static_cast<double>(list.size()))];
  }
  // On the surface as it is, inside of the trim.
  Vec3 place() {
    const Surface shape = shape_of(session_);
    for (;;) {
      const Location where{
          static_cast<int>(random_.between(0, 0.9999) * shape.mesh().triangle_count()),
          Vec3::Constant(1.0 / 3)};
      if (!shape.trim() || shape.trim()->share(where.triangle) > 0.99) return shape.position(where);
    }
  }
  std::string fresh(const std::string& beginning) { return beginning + std::to_string(count_++); }
  // Undo may have put back a motion.
  void answer() {
    try {
      session_.answer(3, 1e-6);
    } catch (const InputError&) {
      session_.stop_motion();
      session_.answer(3, 1e-6);
    }
  }

  void perform(const std::string& what) {
    if (what == "load") {
      static const std::vector<std::pair<std::string, double>> loads = {
          {"swell", 20}, {"push", 20}, {"finger", 5}};
      const auto& [name, range] = one_of(loads);
      for (int n = 0; n < 3; ++n) {
        session_.set(name, range * random_());
        answer();
      }
    } else if (what == "weight") {
      session_.set("stiff", 20 * random_.between(0, 1));
      answer();
    } else if (what == "goal") {
      const auto pins = of("pin");
      if (pins.empty()) return;
      const std::string axis = one_of(pins) + ".y";
      for (int n = 0; n < 3; ++n) {
        session_.set(axis, session_.parameters().value(axis) + 5 * random_());
        answer();
      }
    } else if (what == "move") {
      const auto moves = of("raise");
      if (moves.empty()) return;
      session_.set(one_of(moves), 15 * random_());
      answer();
    } else if (what == "add point") {
      if (of("pin").size() >= 6) return;
      const Vec3 at = place();
      session_.add(
          LiveConstraint{fresh("pin"), LiveConstraint::Point{at, at + Vec3(0, 5 * random_(), 0)}});
    } else if (what == "normal") {
      if (of("lean").size() >= 3) return;
      session_.add(LiveConstraint{
          fresh("lean"),
          LiveConstraint::Normal{place(), Vec3(0.1 * random_(), 1, 0.1 * random_())}});
    } else if (what == "remove") {
      std::vector<std::string> all;
      for (const char* kind : {"pin", "lean", "raise", "bulge", "swage"})
        for (auto& name : of(kind)) all.push_back(name);
      if (!all.empty()) session_.remove(one_of(all));
    } else if (what == "add move") {
      if (of("raise").size() >= 3) return;
      static const std::vector<std::string> lines = {"rib", "window line", "hinge hollow"};
      const std::string& line = one_of(lines);
      LineMove move{fresh("raise"), line, {}, line == "hinge hollow" ? 0 : 0.2};
      if (random_() > 0) move.direction = Vec3::UnitY();
      session_.add(move, {slider(move.name, 5 * random_())});
    } else if (what == "line") {
      const HermiteCurve rib = session_.layout().line("rib");
      Points dofs = rib.dofs();
      const double height = 3 * random_();
      for (int i = 1; i + 1 < rib.node_count(); ++i)
        dofs(rib.mesh().position_dof(i), 1) += height * std::sin(pi * i / (rib.node_count() - 1));
      session_.set_line("rib", HermiteCurve(rib.mesh(), dofs));
    } else if (what == "inner line") {
      if (!of("swage").empty()) return;
      std::vector<Vec3> points;
      const Surface shape = shape_of(session_);
      const Vec3 from(-150 + 60 * random_(), 60, 20 + 20 * random_());
      for (int i = 0; i <= 6; ++i)
        points.push_back(shape.position(shape.closest_point(from + Vec3(25 * i, 0, 2 * i)).where));
      const std::string name = fresh("swage");
      session_.add(
          CharacterLine{name, curve_through_points(name, points), CharacterLine::Role::Inner});
    } else if (what == "refine") {
      Refinement refinement;
      if (random_() > 0)
        refinement.where = Refinement::Brush{{{place(), 60, 1}}};
      else
        refinement.where = Refinement::Jumps{0.05};
      refinement.smallest = 15;
      refinement.most_triangles = 2000;
      session_.refine(refinement);
    } else if (what == "undo") {
      const int times = random_() > 0.8 ? 6 : 1;
      for (int n = 0; n < times; ++n) session_.undo();
    } else if (what == "redo") {
      session_.redo();
    } else if (what == "motion") {
      session_.start_motion({.dt = 0.02, .damping = 5, .theta = random_() > 0 ? 1.0 : 0.5});
      for (int n = 0; n < 3; ++n) session_.step();
      session_.stop_motion();
      answer();
    } else if (what == "springs") {
      if (!of("bulge").empty()) return;
      LiveLoad::Springs springs;
      std::vector<Vec3> to;
      for (int n = 0; n < 4; ++n) {
        springs.at.push_back(place());
        to.push_back(springs.at.back() + Vec3(0, 20, 0));
      }
      springs.target = LiveLoad::Springs::Places{to};
      const std::string name = fresh("bulge");
      session_.add(LiveLoad{name, springs}, {slider(name, 2)});
      answer();
    } else if (what == "settle") {
      session_.settle();
    } else {  // "undo bits"
      const Points before = session_.dofs();
      const auto values = session_.parameters().values();
      const Vec3 at = place();
      bool added = false;
      try {
        session_.add(LiveConstraint{fresh("pin"), LiveConstraint::Point{at, at}});
        added = true;
      } catch (const ConflictError&) {
      }
      if (added) session_.undo();
      if (!same_bits(before, session_.dofs()) || values != session_.parameters().values())
        ++bits_lost_;
    }
  }

  Random random_;
  SculptingSession session_;
  std::map<std::string, int> done_, refused_;
  std::string last_refusal_;
  double worst_ = 0, normal_size_ = 0;
  int count_ = 0, bits_lost_ = 0, most_triangles_ = 0;
  bool finite_ = true;
};

void run(int operations, unsigned seed) {
  Sculptor sculptor(seed);
  size_t bytes_early = 0, bytes_late = 0;
  for (int n = 1; n <= operations; ++n) {
    sculptor.operate();
    INFO("operation " << n << ": residual " << sculptor.worst_residual());
    REQUIRE(sculptor.worst_residual() <= 1e-10);
    REQUIRE(sculptor.finite());
    if (n == operations / 5) bytes_early = bytes_held();
    if (n == operations) bytes_late = bytes_held();
  }
  CHECK(sculptor.bits_lost() == 0);
  CHECK(sculptor.most_triangles() <= 2000);
  int done = 0, refused = 0;
  std::string table;
  for (const auto& [what, count] : sculptor.done()) {
    done += count;
    table += what + " " + std::to_string(count) + ", ";
  }
  table += "refused: ";
  for (const auto& [what, count] : sculptor.refused()) {
    refused += count;
    table += what + " " + std::to_string(count) + ", ";
  }
  INFO(table << sculptor.last_refusal());
  CHECK(refused < operations / 5);
  CHECK(sculptor.done().size() >= 15);
  if (operations >= 1000) {
    std::printf("%s\nresidual %.2e, bytes %zu then %zu, most triangles %d\n", table.c_str(),
                sculptor.worst_residual(), bytes_early, bytes_late, sculptor.most_triangles());
    // The history is full in both cases.
    CHECK(static_cast<double>(bytes_late) <= 1.2 * static_cast<double>(bytes_early) + (16 << 20));
  }
  SculptingSession again(coarse_door(), few_bytes());
  again.replay(sculptor.session().recorded());
  CHECK(same_bits(again.dofs(), sculptor.session().dofs()));
  CHECK(again.parameters().values() == sculptor.session().parameters().values());
  CHECK(again.names() == sculptor.session().names());
}

}  // namespace

TEST_CASE("three hundred operations at random on the door") { run(300, 1); }

TEST_CASE("ten thousand operations at random on the door", "[.long]") { run(10000, 7); }
