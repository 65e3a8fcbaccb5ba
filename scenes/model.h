// SPDX-License-Identifier: MPL-2.0
// Models: curves, the surface through them, and everything that acts on it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/core/progress.h"
#include "batten/scenes/gradients.h"

namespace batten {

class HermiteCurve;  // fem/curves/hermite_curve.h
class Mesh;          // scenes/mesh.h
namespace detail {
struct ModelData;  // scenes/model_data.h
}

/// A curve as input of skin(): points that a smooth curve with corners passes through, or a curve.
struct InputLine {
  std::string name;
  std::vector<Vec3> points = {};  ///< two or more points, model units; empty if `curve` is given
  std::shared_ptr<const HermiteCurve> curve = nullptr;
};

/// Options of skin(), with the meanings and defaults of docs/scenes.md. Lengths are in model units.
struct SkinSettings {
  std::string name = "surface";
  std::string unit = "mm";  ///< "mm", "cm", "m", "in" or "ft"
  /// Largest distance of the surface's curves from the given ones; 0: 1e-4 of the size of the face.
  double fit_tolerance = 0;
  double edge_length = 0;   ///< target length of element edges; 0: 1/20 or 1/40 of the size
  double corner_angle = 0;  ///< angle at which a curve has a corner, degrees; 0: 20
  std::vector<std::string> inner = {};   ///< names of curves that lie on a face
  std::vector<std::string> holes = {};   ///< names of closed curves that trim a face
  std::vector<std::string> smooth = {};  ///< names of curves along which faces meet smoothly (G1)
  std::vector<std::string> crease = {};  ///< names of curves along which faces meet in a crease
  /// Further settings as the text of a scene without curves and unit, such as "[skin]\nalpha = 1".
  std::string settings = "";
};

/// A point of a surface, with its geometry.
struct SurfacePoint {
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit normal x_u × x_v / |x_u × x_v|
  /// Principal curvatures, k1 ≥ k2, 1/length; positive where the surface bends towards the normal.
  double k1 = 0, k2 = 0;
  std::string face;
  double u = 0, v = 0;  ///< parameters of the point in the domain of `face`
  /// Distance from the query point to the surface point; 0 if the point was not searched.
  double distance = 0;
};

/// An edge of a model: a curve, or part of one, at which faces end or meet.
struct ModelEdge {
  std::string name;
  std::vector<std::string> faces;  ///< names of the faces at the edge
  std::string continuity;          ///< "free edge", "G0", "G1" or "non-manifold"
  /// Largest angle between the normals of the two faces along the edge, degrees; 0 for other edges.
  double angle_deg = 0;
  double gap = 0;  ///< largest distance between the two faces at the edge, model units
};

/// Triangles of a surface for display, with exact points and normals. Faces have points of their own
/// along shared curves, because the normals differ there.
struct Facets {
  std::vector<double> points, normals;  ///< x, y, z of each point in turn
  /// Principal curvatures k1 ≥ k2 of each point in turn, 1/length, positive where the surface bends
  /// towards its normal: recovered_curvatures() in fem/surface.h, with the error O(h²).
  std::vector<double> curvatures;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> faces;  ///< index into Model::faces() of each triangle
};

/// A view for Model::picture().
struct PictureView {
  int width = 1600, height = 1000;       ///< pixels
  double azimuth = -30, elevation = 30;  ///< direction of view, degrees
  std::string field = "none";            ///< "none", "mean", "gauss" or "faces"
  int contours = 0, zebra = 0;           ///< number of height contours, of zebra stripes; 0: none
  bool mesh = false;                     ///< true: draws the element edges
  std::string title = "";
};

/// Curves, the surface through them, and everything that acts on it: parameters, loads, constraints
/// and curve offsets.
///
///     Model model = skin({{"front", {…}}, {"right", {…}}, {"back", {…}}, {"left", {…}}});
///     Session session(model);
///     session.add_pressure("swell", {.value = 20});
///     session.solve();
///     model = session.model();          // with the pressure "swell"
///     model.save("panel.step");         // or .toml: the scene, which every program opens
///
/// A model is an immutable value: copies share their data, and cost nothing. All functions may be
/// called by several threads at once. Every model has a scene, the text of docs/scenes.md: scene()
/// is the model, and parse(scene()) is the same model.
///
/// Lengths are in the unit() of the model, and angles in degrees. Functions that take a name throw
/// InputError, with the nearest name, if the model does not have it.
class Model {
 public:
  explicit Model(std::shared_ptr<const detail::ModelData> data) : data_(std::move(data)) {}

  std::string name() const;
  std::string unit() const;                 ///< "mm", "cm", "m", "in" or "ft"
  std::vector<std::string> faces() const;   ///< names of the faces that have a surface
  std::vector<std::string> curves() const;  ///< names of the input curves
  /// Largest allowed distance between an input curve and the curve on the surface.
  double fit_tolerance() const;
  /// `count` ≥ 2 points along an input curve, uniform in its parameter.
  std::vector<Vec3> curve(const std::string& name, int count = 97) const;

  /// Values of all parameters, by name (Scene::parameters() in io/scene/scene.h).
  std::map<std::string, double> parameters() const;
  /// The model of the same curves for other parameter values. Throws as parse(), and InputError for
  /// an unknown name or a value out of range.
  Model with_values(const std::map<std::string, double>& values,
                    const Progress& progress = {}) const;
  /// The scene as text, with all loads, constraints and offsets. Relative paths refer to folder().
  std::string scene() const;
  std::filesystem::path folder() const;

  // Evaluation.

  /// The point of the surface nearest to `p`. Cost: O(triangles) at the first call, then
  /// O(log triangles).
  SurfacePoint nearest(const Vec3& p) const;
  /// The point of a face at the parameters (u, v), as in SurfacePoint. Throws InputError if they are
  /// outside of the domain of the face.
  SurfacePoint at(const std::string& face, double u, double v) const;
  double area() const;  ///< total area of all faces
  /// Enclosed volume; throws InputError unless the faces form closed, orientable shells.
  double volume() const;
  Box3 bounds() const;  ///< bounding box of the facets
  std::vector<ModelEdge> edges() const;
  /// Area and volume with their derivatives with respect to the parameters. Computes the derivative
  /// of the shape at the first call: about six solves per parameter. Throws InputError if the model
  /// comes from a session that was not in equilibrium, or if its elements change with the parameters
  /// (fitted and lofted shapes), and the exceptions of with_values().
  ModelGradients gradients(const Progress& progress = {}) const;
  /// How much each load, curve offset and slider displaces the surface, to find values that have a
  /// visible effect. Cost: a session, and one or two solves per parameter. Throws InputError for a
  /// model without surface.
  std::vector<LoadEffect> load_effects(const Progress& progress = {}) const;
  int element_count() const;     ///< number of finite elements of all faces
  const Facets& facets() const;  ///< triangles for display; computed at the first call

  /// One mesh of all faces, without cracks when it is deformed: faces that share a curve share its
  /// vertices. It has a set of triangles for each face and a set of vertices for each curve, and
  /// Mesh::corner_normals().
  Mesh mesh() const;

  // Quality and output.

  /// Everything that was measured, as the JSON text of report.json (docs/scenes.md).
  std::string report(const Progress& progress = {}) const;
  /// The failed checks as sentences with the measured value; empty if all checks passed.
  std::vector<std::string> failed_checks(const Progress& progress = {}) const;
  /// Writes the model to a file, complete or not at all, and returns the failed checks.
  ///
  /// The extension selects the format: .step .iges .brep .glb .stl .obj .ply .off .3mf .vtp .vtu
  /// .inp (requires [stress]), and .toml for the scene. Throws InputError for another extension.
  std::vector<std::string> save(const std::filesystem::path& file,
                                const Progress& progress = {}) const;
  /// Draws the surface to a PNG file. Without an X server, it starts a virtual one
  /// (io/pictures/display.h). Call it on the main thread.
  void picture(const std::filesystem::path& file, const PictureView& view = {}) const;

  // For Batten's own front ends.
  const detail::ModelData& data() const { return *data_; }
  const std::shared_ptr<const detail::ModelData>& shared_data() const { return data_; }

 private:
  std::shared_ptr<const detail::ModelData> data_;
};

/// Fits surfaces through curves, and finds the faces that these bound. The same curves give the same
/// model whether they come as arrays, in a scene or from a file. Throws InputError, ConflictError,
/// NoSolutionError, CancelledError. Source: [CelnikerGossard1991].
Model skin(const std::vector<InputLine>& curves, const SkinSettings& settings = {},
           const Progress& progress = {});
/// The model of a scene file (.toml), or of the curves in a curve or CAD file. `values`: parameter
/// values that replace those of the scene. Throws InputError ("FILE:LINE:COLUMN: found …, expected
/// …"), ConflictError, NoSolutionError, CancelledError.
Model load(const std::filesystem::path& file, const std::map<std::string, double>& values = {},
           const Progress& progress = {});
/// The model of a scene given as text; relative paths in it refer to `folder`. Throws as load().
Model parse(const std::string& scene, const std::filesystem::path& folder = ".",
            const std::map<std::string, double>& values = {}, const Progress& progress = {});

}  // namespace batten
