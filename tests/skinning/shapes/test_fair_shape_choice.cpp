// SPDX-License-Identifier: MPL-2.0
// Selection of a model's shape between its curves, its rest shape for sessions, and its refinement
// at gaps.
#include <cmath>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/shapes/fair_shape.h"
#include "batten/skinning/surfaces/build_model.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sample_lines.h"

using namespace batten;
using namespace batten_test;

namespace {

using Shape = FairShapeOptions::Shape;

/// An unsolved model of one face, with a coarse mesh.
BuiltModel face_of(const std::vector<CharacterLine>& lines) {
  ModelBuildOptions options;
  options.single_face = true;
  options.model.skin.edge_length = 0.25;
  return build_model(lines, options);
}

FairShapeOptions of_shape(Shape shape) {
  FairShapeOptions options;
  options.shape = shape;
  return options;
}

/// The plane z = height.
class PlaneTarget : public TargetSurface {
 public:
  explicit PlaneTarget(double height) : height_(height) {}
  std::optional<Nearest> nearest(const Vec3& p, const Vec3&) const override {
    return Nearest{{p.x(), p.y(), height_}, Vec3::UnitZ(), false};
  }
  std::vector<Nearest> samples() const override {
    return {{Vec3(0, 0, height_), Vec3::UnitZ(), false}};
  }

 private:
  double height_;
};

}  // namespace

TEST_CASE("faces with five or more sides get a fair shape automatically, others do not",
          "[skinning][model]") {
  const BuiltModel five = face_of(curved_polygon(5, 0.2, 0.1)),
                   four = face_of(curved_polygon(4, 0.2, 0.1));
  CHECK(has_fair_shape({}, five.model.layout.get()));
  CHECK_FALSE(has_fair_shape({}, four.model.layout.get()));
  CHECK_FALSE(has_fair_shape({}, nullptr));
  CHECK_FALSE(has_fair_shape(of_shape(Shape::MinimumBending), five.model.layout.get()));
  CHECK(has_fair_shape(of_shape(Shape::Loft), nullptr));

  // Shallow: vertices of a deep one move by more than a face may that is faired automatically.
  const BuiltModel shallow = face_of(curved_polygon(5, 0.1, 0.1));
  const Points bent = shallow.model.layout->minimize_energy({});
  const FairShape fair = compute_fair_shape(shallow.model, shallow.model.layout, bent, {});
  CHECK_FALSE(fair.fairing->requested);
  REQUIRE(fair.fairing->surface);
  CHECK(fair.fairing->regions == 1);
  CHECK(fair.fairing->surface->functional < fair.fairing->surface->start_functional);
  REQUIRE(fair.rest);
}

TEST_CASE("the rest shape of a session is the fair shape at first", "[skinning][model]") {
  const BuiltModel five = face_of(curved_polygon(5, 0.2, 0.1));
  const Points bent = five.model.layout->minimize_energy({});
  FairShape fair =
      compute_fair_shape(five.model, five.model.layout, bent, of_shape(Shape::MinimumVariation));
  CHECK(fair.fairing->requested);
  const ConstraintSet rows = fair.layout->line_constraints();
  const Points none;
  const Progress progress;
  const Points start = fair.layout->minimize_energy({});
  CHECK(fair.rest({*fair.layout, rows, start, none, progress}) == fair.dofs);
  // Solved again from there under the same constraints, it is as fair but for the 3 % that the
  // descent takes for converged.
  const double functional = fair.fairing->surface->functional;
  const Points again = fair.rest({*fair.layout, rows, start, fair.dofs, progress});
  CHECK(again.rows() == fair.dofs.rows());
  CHECK(fair.fairing->surface->functional <= functional * 1.03);
  CHECK(fair.fairing->failure_reason.empty());
}

TEST_CASE("the shape of minimum bending is kept as it is", "[skinning][model]") {
  const BuiltModel five = face_of(curved_polygon(5, 0.2, 0.1));
  const Points bent = five.model.layout->minimize_energy({});
  const FairShape kept =
      compute_fair_shape(five.model, five.model.layout, bent, of_shape(Shape::MinimumBending));
  CHECK(kept.dofs == bent);
  CHECK_FALSE(kept.rest);
}

TEST_CASE("a flat face fits its plane, and a fit needs a target", "[skinning][model]") {
  const BuiltModel made = face_of(polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  const Points bent = made.model.layout->minimize_energy({});
  FairShapeOptions options = of_shape(Shape::Target);
  CHECK_FALSE(error_message([&] {
                compute_fair_shape(made.model, made.model.layout, bent, options);
              }).empty());
  options.target = std::make_shared<PlaneTarget>(0.0);
  options.fit.tolerance = 1e-6;
  const FairShape fitted = compute_fair_shape(made.model, made.model.layout, bent, options);
  REQUIRE(fitted.fairing->fit);
  CHECK(fitted.fairing->fit->reached);
  CHECK((fitted.dofs - bent).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("the bending energy is quadratic in the shape and 0 for a flat one",
          "[skinning][model]") {
  const BuiltModel made = face_of(curved_polygon(5, 0.2, 0));
  const ModelLayout& layout = *made.model.layout;
  SurfaceStiffness material = SurfaceStiffness::isotropic(0, 1);
  const Points bent = layout.minimize_energy(material);
  const double energy = bending_energy(layout, bent, material);
  CHECK(energy > 0);
  const Points origin = layout.position_dofs() * layout.origin().transpose();
  CHECK(bending_energy(layout, origin + 2 * (bent - origin), material) ==
        Approx(4 * energy).epsilon(1e-9));
  // Stretching stiffness has no effect.
  CHECK(bending_energy(layout, bent, SurfaceStiffness::isotropic(3, 1)) == energy);
  const BuiltModel flat = face_of(curved_polygon(5, 0, 0));
  CHECK(bending_energy(*flat.model.layout, flat.model.layout->minimize_energy(material), material) <
        1e-12);
}

TEST_CASE("triangles at gaps are bisected until the surface is on its embedded curves",
          "[skinning][model]") {
  std::vector<CharacterLine> lines = patch_with_inner_line();
  lines.back().mesh_alignment = CharacterLine::MeshAlignment::Embedded;
  const BuiltModel made = face_of(lines);
  ModelLayout layout = *made.model.layout;
  const auto solved = [&] {
    return std::vector<SkinnedRegion>{layout.skinned(0, layout.minimize_energy({}))};
  };
  const int before = layout.mesh()->triangle_count();
  GapRefinement refinement(layout);
  std::vector<SkinnedRegion> regions = solved();
  // A rib that is pulled off its curve, as by a load.
  Points dofs = layout.minimize_energy({});
  for (int v = 0; v < layout.mesh()->vertex_count(); ++v) dofs(3 * v, 2) += 0.01 * (v % 2);
  const SkinnedRegion pulled = layout.skinned(0, dofs);
  CHECK(max_line_gap({pulled}) > layout.tolerance());
  CHECK(refinement.bisect(layout, {pulled}));
  CHECK(layout.mesh()->triangle_count() > before);
  int rounds = 0;
  for (regions = solved(); refinement.bisect(layout, regions); regions = solved()) ++rounds;
  CHECK(rounds <= 7);
  CHECK(max_line_gap(regions) <= 0.7 * layout.tolerance());
  CHECK(max_line_gap({}) == 0);
}
