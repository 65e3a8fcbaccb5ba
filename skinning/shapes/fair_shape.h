// The shape of a model between its curves: a minimum-variation surface, a loft, or a fit to a
// target surface. Also provides the rest shape of a session.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/target/fit_model.h"

namespace batten {

/// Options of compute_fair_shape(): the kind of shape that a model has between its curves.
struct FairShapeOptions {
  enum class Shape {
    MinimumBending,  ///< the given shape of minimum bending energy is kept
    /// Minimum-variation surfaces for faces with five or more sides (has_many_sides()), because
    /// such faces have no rest shape. Conditions: HCT elements, no inner curves or holes in the
    /// face, and at most 3,000 triangles in the model. Other faces keep the given shape.
    Automatic,
    MinimumVariation,  ///< minimum-variation surfaces for all faces: fair_model()
    Loft,              ///< loft through `sections`: loft_model()
    Target             ///< fit to the surface `target`: fit_model()
  };
  Shape shape = Shape::Automatic;
  /// Options of the minimum-variation surfaces. Only strength and largest_move are used; the others
  /// are overwritten.
  MinimumVariationOptions variation = {};
  /// Tolerance of smooth joins of minimum-variation surfaces, degrees.
  double join_tolerance_deg = ModelOptions{}.join_tolerance_deg;
  /// Names of the section curves of a loft; see loft_shape().
  std::vector<std::string> sections = {};
  std::shared_ptr<const TargetSurface> target = nullptr;
  ModelFitOptions fit = {};  ///< options of fit_model(), such as the parts of the target
};

/// Result of fairing, for reports.
struct FairingSummary {
  /// The minimum-variation surface; empty if the shape is of another kind.
  std::optional<MinimumVariationSurface> surface;
  /// False: fairing was not requested, but may have been applied automatically to faces with five
  /// or more sides.
  bool requested = true;
  int regions = 0;              ///< number of faired faces
  bool lofted = false;          ///< true: the shape is a loft
  std::optional<ModelFit> fit;  ///< result of fit_model(); empty if the shape was not fitted
  std::vector<UnchangedRegion> unchanged_regions;  ///< faces that were not faired
  /// Reason why fairing failed, or "". After a failure, the model keeps the shape of minimum
  /// bending energy.
  std::string failure_reason;
};

/// Result of compute_fair_shape(): the shape of a model without loads or additional constraints.
struct FairShape {
  std::shared_ptr<const ModelLayout> layout;  ///< the given layout, or a refinement of it
  /// Absolute dofs on `layout`. No rows: the model keeps the shape of minimum bending energy.
  Points dofs;
  /// Result of fairing. `rest` updates it when a session calls that function.
  std::shared_ptr<FairingSummary> fairing;
  /// Function that computes the rest shape of a session; empty: the rest state is flat.
  RestShapeFunction rest;
};

/// True if compute_fair_shape() may change the shape of minimum bending energy. `layout`: layout of
/// the model, or null if the model has no faces. O(faces).
bool has_fair_shape(const FairShapeOptions& options, const ModelLayout* layout);

/// Computes the shape of a model between its curves.
///
/// `model`: the model in the shape of minimum bending energy; fair_model() uses the defects of this
/// shape. `layout`: layout of `model` or a refinement of it. `bent`: absolute dofs of the shape of
/// minimum bending energy on `layout`, from which the computation starts.
///
/// With Shape::Automatic, only faces that move by at most 0.15 of their size are faired. If the
/// solution does not converge, or if no face can be faired without a defect, the model keeps the
/// shape of minimum bending energy. Call has_fair_shape() first: if no face qualifies on `layout`,
/// Shape::Automatic fairs all faces.
///
/// FairShape::rest computes the rest shape of a session. Its first result is the computed shape.
/// When the constraints of the curves change, it calls fair_shape() or loft_shape() again; for
/// Shape::Target it selects the shape with the least bending energy relative to the fitted shape.
///
/// If a requested minimum-variation surface cannot be computed, `dofs` has no rows, and
/// FairingSummary::failure_reason describes the error. Throws as loft_model() and fit_model() do;
/// InputError for Shape::Target without a target; CancelledError. Cost: that of fair_model(),
/// loft_model() or fit_model().
FairShape compute_fair_shape(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                             const Points& bent, const FairShapeOptions& options,
                             const Progress& progress = {});

}  // namespace batten
