// SPDX-License-Identifier: MPL-2.0
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
    MinimumBending,  ///< the model keeps its shape of minimum bending energy
    /// Minimum-variation surfaces for faces with five or more sides (has_many_sides()), because
    /// these have no rest shape, and for faces that continue given surfaces, which a rest shape does
    /// not know. Conditions: HCT elements, no inner curves or holes in the face,
    /// and at most 3,000 triangles in the model. Other faces keep their shape.
    Automatic,
    MinimumVariation,  ///< minimum-variation surfaces for all faces: fair_model()
    Loft,              ///< loft through `sections`: loft_model()
    Target             ///< fit to the surface `target`: fit_model()
  };
  Shape shape = Shape::Automatic;
  /// Options of minimum-variation surfaces; only strength and largest_move are used.
  MinimumVariationOptions variation = {};
  /// Largest allowed angle at smooth joins of minimum-variation surfaces, degrees.
  double join_tolerance_deg = ModelOptions{}.join_tolerance_deg;
  /// Names of the section curves of a loft; see loft_shape().
  std::vector<std::string> sections = {};
  std::shared_ptr<const TargetSurface> target = nullptr;
  ModelFitOptions fit = {};  ///< options of fit_model(), such as the parts of the target
};

/// Result of fairing a model, for reports.
struct FairingSummary {
  /// The minimum-variation surface; empty if the shape is a loft, a fit, or not faired.
  std::optional<MinimumVariationSurface> surface;
  /// False: fairing was not requested, but may have been applied automatically to faces with five
  /// or more sides.
  bool requested = true;
  int regions = 0;              ///< number of faired faces
  bool lofted = false;          ///< true: the shape is a loft
  std::optional<ModelFit> fit;  ///< result of fit_model(); empty if the shape was not fitted
  std::vector<UnchangedRegion> unchanged_regions;  ///< faces that were not faired
  /// Reason why fairing failed, or "" if it did not. After a failure, the model keeps the shape of
  /// minimum bending energy.
  std::string failure_reason;
};

/// Result of compute_fair_shape(): the shape of a model without loads or additional constraints.
struct FairShape {
  std::shared_ptr<const ModelLayout> layout;  ///< the given layout, or a refinement of it
  /// Absolute dofs on `layout`. No rows: the model keeps the shape of minimum bending energy.
  Points dofs;
  /// Summary of the fairing. The function `rest` updates this summary when a session calls it.
  std::shared_ptr<FairingSummary> fairing;
  /// Function that computes the rest shape of a session; empty: the rest state is flat.
  RestShapeFunction rest;
};

/// True if compute_fair_shape() may change the shape of minimum bending energy. `layout`: layout of
/// the model, or null if the model has no faces. O(faces).
bool has_fair_shape(const FairShapeOptions& options, const ModelLayout* layout);

/// Computes the shape of a model between its curves, of the kind that `options` select.
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
/// FairShape::rest computes the rest shape of a session. The first call of this function returns
/// FairShape::dofs. When the constraints of the curves have changed, the function calls
/// fair_shape() or loft_shape() again; for Shape::Target the function selects the shape with the
/// least bending energy relative to the fitted shape.
///
/// If a requested minimum-variation surface cannot be computed, FairShape::dofs has no rows, and
/// FairingSummary::failure_reason describes the error. Throws as loft_model() and fit_model() do;
/// InputError for Shape::Target without a target; CancelledError. Cost: that of fair_model(),
/// loft_model() or fit_model().
FairShape compute_fair_shape(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                             const Points& bent, const FairShapeOptions& options,
                             const Progress& progress = {});

}  // namespace batten
