// SPDX-License-Identifier: MPL-2.0
// Session logs: reading a written log gives the same operations, bit for bit.
#include <cmath>
#include <cstring>
#include <fstream>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/sessions/session_log.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
using Catch::Matchers::Contains;
using Kind = Operation::Kind;

namespace {

const double kThird = 1.0 / 3, kTiny = 4.9406564584124654e-324, kHuge = -1.7976931348623157e308;

Operation edit(Operation::Edit what) {
  return {Kind::Edit, 0, 0, std::make_shared<const Operation::Edit>(std::move(what))};
}

HermiteCurve wavy(bool closed) {
  const int nodes = closed ? 4 : 5;
  CurveMesh mesh({0, 0.1, kThird, 0.5, 2}, closed, {1});
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < dofs.rows(); ++i) dofs.row(i) << std::sin(i + nodes), -kThird * i, kTiny;
  return {mesh, dofs};
}

ScalarParameter swell() {
  ScalarParameter p;
  p.name = "swell \"ä\"";
  p.value = 0.1;
  p.max = kThird;
  p.offset = -0.0;
  p.keyframes = {{0, 0.1}, {kThird, -7}};
  return p;
}

std::vector<Operation> everything() {
  const Area::Painted::Stroke stroke{{kThird, 2, 3}, 0.7, -1};
  Load::AttractorSprings places, rail, floor;
  places.at = rail.at = floor.at = {{1, kThird, 3}, {4, 5, 6}};
  places.target = Load::AttractorSprings::TargetPoints{{{0.1, 0.2, 0.3}, {7, 8, 9}}};
  rail.target = Load::AttractorSprings::Curve{wavy(true)};
  rail.rest_length = kThird;
  floor.target = Load::AttractorSprings::Plane{{1, 2, 3}, {0, 0, 1}};
  floor.falloff = 5;
  ScalarParameter follower;
  follower.name = "f";
  follower.rule_terms = {{"swell", kThird}, {"beta", -2}};
  follower.offset = 0.3;
  CharacterLine line{"crease",
                     curve_from_hermite(HermiteCurve(
                         {0, 1, 3}, (Points(3, 3) << 0, 0, 0, 1, kThird, 0, 3, 1, 0).finished(),
                         (Points(3, 3) << 1, 0, 0, 1, 1, 0, 1, 0, kThird).finished())),
                     CharacterLine::Role::Inner, CharacterLine::MeshAlignment::Embedded};
  using C = Constraint;
  return {
      {Kind::Set, 3, kThird, nullptr},
      {Kind::Set, 0, kTiny, nullptr},
      {Kind::Set, 1, kHuge, nullptr},
      {Kind::Set, 1, -0.0, nullptr},
      {Kind::SolveToEquilibrium, 0, 0, nullptr},
      {Kind::SolvePreview, 4, 1e-6, nullptr},
      {Kind::Step, 0, 0, nullptr},
      {Kind::StopMotion, 0, 0, nullptr},
      {Kind::Undo, 0, 0, nullptr},
      {Kind::Redo, 0, 0, nullptr},
      edit(Operation::Add{Load{"swell", Load::Pressure{}}, {swell(), follower}}),
      edit(Operation::Add{Load{"u", Load::Uniform{{0, kThird, 1}, {Area::NearLine{"rim", kThird}}}},
                          {}}),
      edit(Operation::Add{
          Load{"p", Load::Pressure{{Area::Painted{{stroke, stroke}}, {"top", "left"}}}}, {}}),
      edit(Operation::Add{Load{"g", Load::Gravity{{0, 0, -1}}}, {}}),
      edit(Operation::Add{Load{"f", Load::Point{{1, 2, 3}, {4, 5, kThird}}}, {}}),
      edit(Operation::Add{Load{"l", Load::Line{"rim", {4, 5, 6}}}, {}}),
      edit(Operation::Add{Load{"s1", places}, {}}),
      edit(Operation::Add{Load{"s2", rail}, {}}),
      edit(Operation::Add{Load{"s3", floor}, {}}),
      edit(Operation::Add{Load{"m", Load::PointCloudSprings{{{1, 2, kThird}}}}, {}}),
      edit(Operation::Add{StiffnessField{"w", StiffnessField::Kind::Bending, {}, {}}, {}}),
      edit(Operation::Add{
          StiffnessField{"w2", StiffnessField::Kind::Stretching, {}, Vec2(kThird, 1)}, {}}),
      edit(Operation::Add{StiffnessField{"w3", StiffnessField::Kind::Bending, {}, "rim"}, {}}),
      edit(Operation::Add{C{"c", C::Point{{1, 2, 3}, {4, kThird, 6}}}, {}}),
      edit(Operation::Add{C{"n", C::Normal{{1, 2, 3}, {0, 0, 1}}}, {}}),
      edit(Operation::Add{C{"t", C::Tangent{{1, 2, 3}, {0, 1}, {0, 0, 1}}}, {}}),
      edit(Operation::Add{C{"ln", C::LineNormal{"rim", {}}}, {}}),
      edit(Operation::Add{C{"ln2", C::LineNormal{"rim", Vec3(1, 0, kThird)}}, {}}),
      edit(Operation::Add{LineOffset{"rib", "rim", {}, kThird}, {}}),
      edit(Operation::Add{LineOffset{"rib2", "rim", Vec3(0, 0, 1), 0}, {}}),
      edit(Operation::Add{line, {}}),
      edit(Operation::Change{C{"c", C::Point{{1, 2, 3}, {0.1, 0.2, 0.3}}}}),
      edit(Operation::Remove{"c"}),
      edit(Operation::SetLine{"rim", wavy(false)}),
      edit(Refinement{Refinement::Brush{{stroke}}, kThird, 1000}),
      edit(Refinement{Refinement::JumpIndicator{kThird}, 0, 5}),
      edit(Motion{kThird, 2, 0.1, 0.5}),
      edit(Operation::AddParameter{swell()}),
      edit(Operation::SetRule{"swell", {{"bolder", kThird}}, -kThird}),
      edit(Operation::SetRule{"swell", {}, 0}),
      {Kind::Time, 0, kThird, nullptr},
  };
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

TEST_CASE("a log with every operation is read back bit-identically",
          "[io][sessions][session_log]") {
  const std::vector<Operation> operations = everything();
  const std::string text = session_log_text(operations);
  const std::vector<Operation> back = parse_session_log(text, "log");
  REQUIRE(back.size() == operations.size());
  for (size_t i = 0; i < back.size(); ++i) {
    INFO("operation " << i);
    CHECK(back[i].kind == operations[i].kind);
    CHECK(back[i].index == operations[i].index);
    CHECK(same_bits(back[i].value, operations[i].value));
    CHECK(bool(back[i].edit) == bool(operations[i].edit));
    if (back[i].edit) CHECK(back[i].edit->index() == operations[i].edit->index());
  }
  // Numbers have all digits, so equal texts prove that nothing is lost.
  CHECK(session_log_text(back) == text);

  const auto& add = std::get<Operation::Add>(*back[10].edit);
  CHECK(add.parameters[0].name == "swell \"ä\"");
  CHECK(add.parameters[0].min == -std::numeric_limits<double>::infinity());
  CHECK(add.parameters[0].max == kThird);
  CHECK(add.parameters[0].keyframes[1].time == kThird);
  CHECK(add.parameters[1].rule_terms[1].of == "beta");
  const auto& set = std::get<Operation::SetLine>(*back[33].edit);
  CHECK(set.curve.dofs() == wavy(false).dofs());
  CHECK(set.curve.mesh().corners() == std::vector<int>{1});
  const auto& rail = std::get<Load::AttractorSprings>(
      std::get<Load>(std::get<Operation::Add>(*back[17].edit).what).kind);
  CHECK(std::get<Load::AttractorSprings::Curve>(rail.target).curve.closed());
  const auto& line = std::get<CharacterLine>(std::get<Operation::Add>(*back[30].edit).what);
  CHECK(line.mesh_alignment == CharacterLine::MeshAlignment::Embedded);
  const auto& given = std::get<CharacterLine>(std::get<Operation::Add>(*operations[30].edit).what);
  for (const double t : {0.0, 0.3, 1.0, 2.7, 3.0})
    CHECK(line.curve->evaluate(t) == given.curve->evaluate(t));
}

TEST_CASE("a log is written completely or not at all", "[io][sessions][session_log]") {
  const auto folder = batten_test::scratch("session_log");
  write_session_log(folder / "a.jsonl", everything());
  CHECK(session_log_text(read_session_log(folder / "a.jsonl")) == session_log_text(everything()));
  CHECK_THAT(error_message([&] { read_session_log(folder / "b.jsonl"); }),
             Contains("no such file"));
  std::vector<Operation> bad = {{Kind::Set, 0, std::nan(""), nullptr}};
  CHECK_THAT(error_message([&] { write_session_log(folder / "c.jsonl", bad); }),
             Contains("found nan"));
  bad = {edit(Operation::Add{
      CharacterLine{"arc",
                    curve_from_formula(0, 1, [](double t, int) { return Vec3(t, t * t, 0); }),
                    CharacterLine::Role::Inner, CharacterLine::MeshAlignment::Auto},
      {}})};
  CHECK_THAT(error_message([&] { write_session_log(folder / "c.jsonl", bad); }),
             Contains("'arc'") && Contains("not piecewise cubic"));
  bad = {edit(Operation::Add{
      CharacterLine{"bent", curve_through_points("bent", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}),
                    CharacterLine::Role::Inner, CharacterLine::MeshAlignment::Auto},
      {}})};
  CHECK_THAT(error_message([&] { write_session_log(folder / "c.jsonl", bad); }),
             Contains("'bent'") && Contains("corner"));
  CHECK_FALSE(std::filesystem::exists(folder / "c.jsonl"));
}

TEST_CASE("errors in a log are reported with their line", "[io][sessions][session_log]") {
  const std::string head = "{\"batten\":\"session\",\"version\":2}\n{\"do\":\"solve\"}\n";
  const auto says = [&](const std::string& line) {
    return error_message([&] { parse_session_log(head + line + "\n", "log"); });
  };
  CHECK(says("").empty());
  CHECK_THAT(says("{\"do\":\"set\",\"para"), Contains("log:3: found a line that is not JSON"));
  CHECK_THAT(says("[1]"), Contains("log:3: found no \"do\""));
  CHECK_THAT(says("{\"do\":\"slove\"}"), Contains("log:3:") && Contains("did you mean 'solve'?"));
  CHECK_THAT(says("{\"do\":7}"), Contains("log:3: found 7 for 'do', expected a text"));
  CHECK_THAT(says("{\"do\":\"set\",\"value\":1}"), Contains("log:3: found no 'parameter'"));
  CHECK_THAT(says("{\"do\":\"set\",\"parameter\":-1,\"value\":1}"), Contains("found -1"));
  CHECK_THAT(says("{\"do\":\"set\",\"parameter\":1.5,\"value\":1}"), Contains("found 1.5"));
  CHECK_THAT(says("{\"do\":\"set\",\"parameter\":1,\"value\":\"x\"}"),
             Contains("log:3: found \"x\" for 'value', expected a number"));
  CHECK_THAT(says("{\"do\":\"set\",\"parameter\":1,\"value\":1,\"vlaue\":2}"),
             Contains("found 'vlaue'") && Contains("did you mean 'value'?"));
  CHECK_THAT(says("{\"do\":\"add\"}"), Contains("log:3: found 'add' without an item"));
  CHECK_THAT(says("{\"do\":\"add\",\"load\":{\"name\":\"a\",\"type\":\"presure\"}}"),
             Contains("log:3:") && Contains("did you mean 'pressure'?"));
  CHECK_THAT(says("{\"do\":\"add\",\"load\":{\"name\":\"a\",\"type\":\"point\",\"at\":[1,2]}}"),
             Contains("log:3: found [1,2] for 'at', expected 3 numbers"));
  CHECK_THAT(
      says("{\"do\":\"set_curve\",\"name\":\"a\",\"geometry\":{\"parameters\":[0,1],\"closed\":"
           "false,\"corners\":[],\"dofs\":[[0,0,0]]}}"),
      Contains("log:3: "));
  CHECK_THAT(error_message([&] { parse_session_log("", "log"); }),
             Contains("log:1: found an empty file"));
  CHECK_THAT(error_message([&] { parse_session_log("{\"batten\":3}\n", "log"); }),
             Contains("log:1: found another file than a session log"));
  CHECK(error_message(
            [&] { parse_session_log("{\"batten\":\"session\",\"version\":1}\n", "log"); }) ==
        "log:1: found version 1 of the session log format, expected version 2: record the session "
        "again with this program");
  CHECK_THAT(error_message([&] { parse_session_log("{\"batten\":\"session\"}\n", "log"); }),
             Contains("log:1: found no version of the session log format, expected version 2"));
}
