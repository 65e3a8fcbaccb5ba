// The shape of a model between its curves: of minimum curvature variation, lofted, or fitted to a
// target; and the rest shape that it gives a session.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/model/rest_shape_function.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/target/fit_model.h"

namespace batten {

/// Which shape a model gets between its curves.
struct FairShapeOptions {
  enum class Shape {
    MinimumBending,  ///< the given shape of minimum bending is kept
    /// Minimum variation of the faces with five or more sides, which have no rest shape
    /// (has_many_sides()): of HCT elements, without inner curves and holes, in models of up to
    /// 3,000 triangles. The others keep the given shape.
    Automatic,
    MinimumVariation,  ///< minimum variation of all faces: fair_model()
    Loft,              ///< loft_model() through `sections`
    Target             ///< fit_model() to `target`
  };
  Shape shape = Shape::Automatic;
  MinimumVariationOptions variation = {};  ///< strength and largest_move; others are overwritten
  /// Tolerance of smooth joins of minimum-variation surfaces, degrees.
  double join_tolerance_deg = ModelOptions{}.join_tolerance_deg;
  std::vector<std::string> sections = {};  ///< curves of a loft; see loft_shape()
  std::shared_ptr<const TargetSurface> target = nullptr;
  ModelFitOptions fit = {};  ///< options of fit_model(), such as the parts of the target
};

/// What fairing did to a shape.
struct FairingSummary {
  /// Set if the shape is a minimum-variation surface.
  std::optional<MinimumVariationSurface> surface;
  bool requested = true;        ///< false: chosen automatically for faces with five or more sides
  int regions = 0;              ///< number of faired faces
  bool lofted = false;          ///< true: the shape is a loft
  std::optional<ModelFit> fit;  ///< set if the shape is fitted to a target
  std::vector<UnchangedRegion> unchanged_regions;  ///< faces that were not faired
  /// If not empty: why fairing failed; the shape is then the one of minimum bending.
  std::string failure_reason;
};

/// The shape of a model's curves, without loads and constraints.
struct FairShape {
  std::shared_ptr<const ModelLayout> layout;  ///< the input layout, or a refinement
  Points dofs;  ///< absolute dofs on `layout`; no rows: the shape of minimum bending is kept
  /// Result of fairing. The function rest() of a live session updates it.
  std::shared_ptr<FairingSummary> fairing;
  /// Rest shape of the session's surface; empty: flat rest state.
  RestShapeFunction rest;
};

/// True if compute_fair_shape() would change the shape of minimum bending. `layout`: of the model,
/// or null if it has no faces. O(faces).
bool has_fair_shape(const FairShapeOptions& options, const ModelLayout* layout);

/// Computes the shape of a model between its curves.
///
/// `model`: the model in the shape of minimum bending, with its defects (fair_model()). `layout`:
/// its layout or a refinement. `bent`: absolute dofs of the shape of minimum bending on `layout`,
/// the start.
///
/// Shape::Automatic keeps the result for faces that move by at most 0.15 of their size, and only if
/// the solution converges without a defect; otherwise the shape of minimum bending stays. It fairs
/// all faces if none qualifies on `layout`: ask has_fair_shape() first.
///
/// FairShape::rest is the rest shape of a session. It is this shape at first. Under other
/// constraints of curves it is computed anew by fair_shape() or loft_shape(); for a target it is
/// the shape that bends least from this one.
///
/// If a requested minimum-variation surface fails, the summary has the reason, and `dofs` no rows.
/// Throws the exceptions of loft_model() and fit_model(), InputError for Shape::Target without a
/// target, and CancelledError. Cost: that of fair_model(), loft_model() or fit_model().
FairShape compute_fair_shape(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                             const Points& bent, const FairShapeOptions& options,
                             const Progress& progress = {});

}  // namespace batten
