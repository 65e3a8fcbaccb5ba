// SPDX-License-Identifier: MPL-2.0
// Candidate layouts of one face: the default one if it is valid, otherwise a better one.
#include "batten/skinning/surfaces/layout_candidate.h"

#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten;
using batten_test::error_message;
using batten_test::Random;
using Catch::Matchers::Contains;
using Role = CharacterLine::Role;

namespace {

CharacterLine line(const std::string& name, const std::vector<Vec3>& points,
                   Role role = Role::Outline) {
  return {name, curve_through_points(name, points), role};
}

std::vector<CharacterLine> square() {
  return {line("a", {{0, 0, 0}, {1, 0, 0}}), line("b", {{1, 0, 0}, {1, 1, 0}}),
          line("c", {{1, 1, 0}, {0, 1, 0}}), line("d", {{0, 1, 0}, {0, 0, 0}})};
}

ModelMetadata metadata() { return {"model", 1.5, 1e-4, Vec3::Zero(), 0.1}; }

RegionRequest region_request(const std::vector<CharacterLine>& lines, int inner = 0) {
  RegionRequest w{"region", lines, inner, {}, 0};
  w.skin.edge_length = 0.25;
  return w;
}

// Sides of three points each between corners around an axis, alternately up and down.
std::vector<CharacterLine> rough_loop(Random& random) {
  const int corners = 3 + static_cast<int>(random.between(0, 5));
  std::vector<Vec3> at;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, r = 1 + 0.5 * random();
    at.emplace_back(r * std::cos(angle), r * std::sin(angle), 1.2 * random());
  }
  std::vector<CharacterLine> lines;
  for (int i = 0; i < corners; ++i) {
    const Vec3 &a = at[i], &b = at[(i + 1) % corners];
    const Vec3 middle = 0.5 * (a + b) + 0.9 * Vec3(random(), random(), random());
    lines.push_back(line("side " + std::to_string(i), {a, middle, b}));
  }
  return lines;
}

double least_jacobian(const LayoutCandidate& candidate) {
  return measure(candidate.layout->region(candidate.shape)).min_jacobian_ratio;
}

}  // namespace

TEST_CASE("a face without defects is the one that its curves suggest", "[skinning][surfaces]") {
  const RegionRequest w = region_request(square());
  const LayoutCandidate candidate = best_layout(w, metadata(), {});
  const RegionLayout usual("region", w.lines, w.skin);
  CHECK(candidate.layout->domain() == SkinOptions::Domain::Polygon);
  CHECK(candidate.layout->mesh()->vertices() == usual.mesh()->vertices());
  CHECK(candidate.warnings.empty());
}

TEST_CASE("an inner curve that leaves the face is left out, with its reason",
          "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = square();
  lines.push_back(line("rib", {{0.5, 0.2, 0}, {0.5, 1.7, 0.3}}, Role::Inner));
  const LayoutCandidate candidate = best_layout(region_request(lines, 1), metadata(), {});
  CHECK_FALSE(candidate.layout->has_line("rib"));
  REQUIRE(candidate.warnings.size() == 1);
  CHECK_THAT(candidate.warnings[0], Contains("inner curves are ignored") && Contains("'rib'"));
}

TEST_CASE("a face that no candidate can make is refused with the reason of the first one",
          "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = square();
  lines.pop_back();
  const RegionRequest w = region_request(lines);
  CHECK(error_message([&] { best_layout(w, metadata(), {}); }) ==
        error_message([&] { RegionLayout("region", w.lines, w.skin); }));
}

TEST_CASE("rough outlines: no trial is worse than the usual way, and some are saved by another",
          "[skinning][surfaces]") {
  Random random(11);
  int saved = 0, first_failed = 0;
  for (int i = 0; i < 12; ++i) {
    const RegionRequest w = region_request(rough_loop(random));
    double usual = -1e300;
    try {
      LayoutCandidate first{
          std::make_shared<RegionLayout>("region", w.lines, w.skin), {}, {}, {w.skin, true}, {}};
      first.shape = ModelLayout(metadata(), {first.layout}, {}).minimize_energy({});
      usual = least_jacobian(first);
    } catch (const Error&) {
      ++first_failed;
    }
    try {
      const LayoutCandidate best = best_layout(w, metadata(), {});
      CAPTURE(i, usual);
      CHECK(least_jacobian(best) >= std::min(usual, 0.05));
      if (usual < 0.05 && least_jacobian(best) >= 0.05) {
        ++saved;
        CHECK(best.warnings.empty());
      }
    } catch (const Error&) {
      CHECK(usual == -1e300);
    }
  }
  CAPTURE(first_failed, saved);

  CHECK(saved >= 1);
}
