// SPDX-License-Identifier: MPL-2.0
// Effects of loads, as batten info states them, and warnings about loads without visible effect.
#include <regex>

#include "batten/scenes/model.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

/// A square of size 141.4 with three parameters.
std::string scene(const std::string& unit, double side, const std::string& value) {
  const std::string s = std::to_string(side), half = std::to_string(side / 2);
  return "unit = \"" + unit + "\"\n[[curve]]\nname = \"rim\"\npoints = [[0,0,0], [" + s +
         ",0,0], [" + s + "," + s + ",0], [0," + s + ",0], [0,0,0]]\n" +
         "[[load]]\nname = \"push\"\ntype = \"point\"\nat = [" + half + "," + half +
         ",0]\ndirection = [0,0,1]\nvalue = " + value +
         "\n[[load]]\nname = \"wind\"\ntype = \"uniform\"\ndirection = [0,0,1]\nvalue = 0\n"
         "[[parameter]]\nname = \"both\"\nvalue = 0\nmax = 1\ndrives = [{name = \"wind\", "
         "factor = 50}]\n[mesh]\nedge_length = " +
         std::to_string(side / 5) + "\n";
}

std::map<std::string, batten::LoadEffect> effects_of(const batten::Model& model) {
  std::map<std::string, batten::LoadEffect> effects;
  for (const batten::LoadEffect& effect : model.load_effects()) effects[effect.parameter] = effect;
  return effects;
}

/// Largest height of the surface above the plane of its curves.
double height(const batten::Model& model) { return model.bounds().max().z(); }

}  // namespace

TEST_CASE("the effects of loads are the displacements that these cause", "[apps][load_effects]") {
  const batten::Model model = batten::parse(scene("mm", 100, "0"));
  const double size = 100 * std::sqrt(2.0);
  const auto effects = effects_of(model);
  REQUIRE(effects.size() == 2);  // wind is driven
  for (const std::string name : {"push", "both"}) {
    INFO(name);
    const batten::LoadEffect& effect = effects.at(name);
    CHECK(effect.displacement * effect.visible == Approx(0.01 * size));
    const double value = std::min(effect.visible, 1.0);  // the range of the slider
    CHECK(height(model.with_values({{name, value}})) ==
          Approx(value * effect.displacement).epsilon(0.03));
    CHECK((effect.at - batten::Vec3(50, 50, 0)).norm() < 20);  // of the nearest vertex
    CHECK(effect.face == model.faces()[0]);
  }
}

TEST_CASE("effects are independent of the length unit and of the value of a linear load",
          "[apps][load_effects]") {
  const auto mm = effects_of(batten::parse(scene("mm", 100, "0"))),
             m = effects_of(batten::parse(scene("m", 0.1, "0"))),
             pushed = effects_of(batten::parse(scene("mm", 100, "5")));
  CHECK(m.at("push").displacement == Approx(1e-3 * mm.at("push").displacement).epsilon(1e-3));
  CHECK(m.at("push").visible == Approx(mm.at("push").visible).epsilon(1e-3));
  CHECK(pushed.at("push").visible == Approx(mm.at("push").visible).epsilon(1e-3));
}

TEST_CASE("info states the effects, and run warns of loads far from them", "[apps][load_effects]") {
  const CliCase c("load_effects");
  const auto warning_at = [&](const std::string& value) {
    c.file("s.toml", scene("mm", 100, value));
    return c.run({"run", "s.toml", "--out", "out"}).err;
  };
  CHECK(warning_at("0").empty());
  CHECK(warning_at("5").empty());
  for (const std::string value : {"1e-5", "1e7"}) {
    const std::string warning = warning_at(value);
    INFO(warning);
    std::smatch found;
    REQUIRE(std::regex_search(warning, found,
                              std::regex("warning: the load 'push' = .* a value near ([^ ]+) "
                                         "displaces it by about 1 %\n")));
    CHECK(warning_at(found[1]).empty());
    CHECK(report(c, "out")["surface"]["max_displacement"].get<double>() ==
          Approx(0.01 * 100 * std::sqrt(2.0)).epsilon(0.01));
  }
  const CliResult info = c.run({"info", "s.toml"});
  CHECK(info.code == 0);
  CHECK_THAT(info.out, Catch::Matchers::Contains("  push: 1 displaces the surface by up to ") &&
                           Catch::Matchers::Contains("displaces it by about 1 % of its size"));
}
