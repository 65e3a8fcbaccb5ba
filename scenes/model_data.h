// SPDX-License-Identifier: MPL-2.0
// Contents of a Model, for the front ends of Batten.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/report/report.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/model.h"
#include "batten/scenes/shapes/make_session.h"
#include "batten/scenes/shapes/shape_derivatives.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

/// A session that a model came from: its state, and what else a second session of it needs.
struct SessionOrigin {
  std::shared_ptr<const SessionSnapshot> state;
  std::shared_ptr<const SculptModel> model;
  SessionReference reference;
  SolveReport solve_report;
};

/// The scene of a model as text, its curves and its shape. Immutable, apart from what is computed at
/// the first use.
struct ModelData {
  /// Builds the model of a scene and solves for its shape. `text`: the text of the scene; `scene`:
  /// the scene that was read from it, possibly with other values. Throws as run_scene() does.
  ModelData(std::string text, Scene scene, const Progress& progress);
  /// Wraps another shape of the same curves, and the session that it came from.
  ModelData(std::string text, Scene scene, const ModelData& curves, SolvedShape shape,
            std::optional<SessionOrigin> origin);

  std::string text;  ///< the scene with its own values; those of `scene` may differ
  Scene scene;
  std::vector<CharacterLine> lines;
  std::shared_ptr<const BuiltModel> made;  ///< the model before any session
  SolvedShape shape;
  std::optional<SessionOrigin> origin;

  /// Throws InputError if no face has a surface.
  void require_surface() const;
  const Facets& facets() const;
  /// Locations of the points of facets(), in the mesh of the whole model.
  const std::vector<Location>& facet_locations() const;
  /// The model with this shape: joins, shells and their volumes as they are now.
  const SurfaceModel& measured() const;
  /// Measured quality of the shape (export_shape() without files).
  const Report& report(const Progress& progress) const;
  const ModelProjector& projector() const;
  /// Derivatives of the shape with respect to the parameters of the scene.
  const std::vector<ShapeDerivative>& shape_derivatives(const Progress& progress) const;
  double area() const;     ///< total area of all faces
  bool is_closed() const;  ///< true: the faces form closed, orientable shells

 private:
  struct LocatedFacets {
    Facets facets;
    std::vector<Location> locations;
  };
  const LocatedFacets& located_facets() const;

  /// The value of `slot`, computed at the first use. Computes it without the lock: it may poll for
  /// cancellation, and a callback may use the model. If several threads compute it, the first counts.
  template <class Value, class Make>
  const Value& lazily(std::unique_ptr<const Value>& slot, const Make& make) const {
    {
      const std::lock_guard lock(mutex_);
      if (slot) return *slot;
    }
    auto made = std::make_unique<const Value>(make());
    const std::lock_guard lock(mutex_);
    if (!slot) slot = std::move(made);
    return *slot;
  }

  mutable std::mutex mutex_;
  mutable std::unique_ptr<const LocatedFacets> facets_;
  mutable std::unique_ptr<const BuiltModel> measured_;
  mutable std::unique_ptr<const ModelProjector> projector_;
  mutable std::unique_ptr<const Report> report_;
  mutable std::unique_ptr<const std::vector<ShapeDerivative>> derivatives_;
};

/// The table [[curve]] of a curve as text. Throws InputError for fewer than two points.
std::string curve_table(const InputLine& line);

}  // namespace batten::detail
