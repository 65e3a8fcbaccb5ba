// SPDX-License-Identifier: MPL-2.0
// Meshes, their holes, and deformers that keep holes and other features exactly rigid.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/io/meshes/mesh_file_types.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/editing/feature_rotation_estimator.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

namespace detail {
struct SharedMesh;     // scenes/mesh_data.h
struct DeformerState;  // scenes/mesh_data.h
}  // namespace detail

/// A hole of a mesh: a closed boundary loop with its fitted circle (measure_hole()), and the
/// vertices around it.
struct Hole : HoleMeasure {
  std::string name;  ///< "hole-1", "hole-2" and so on, as in deform scenes
  /// Vertices of the hole and of the flange around it, ascending, for a feature of a Deformer.
  std::vector<int> vertices;
  std::vector<int> loop;  ///< vertices of the boundary loop in order, for measure_hole()
};

/// A mesh of triangles, quads and polygons, from a file or from arrays.
///
///     const Mesh mesh = read_mesh("plate.bdf");
///     DeformerSettings settings;
///     settings.fixed = mesh.vertices_in({0, 0, -1}, {10, 200, 1});
///     settings.handles = {{"end", mesh.vertices_in({290, 0, -1}, {300, 200, 1})}};
///     for (const Hole& hole : mesh.holes())
///       settings.features.push_back({hole.name, hole.vertices});
///     Deformer deformer(mesh, settings);
///     const Points bent = deformer.deform({{"end", {.translate = {0, 0, 50}}}});
///     mesh.save_as_read("bent.bdf", bent);
///
/// A mesh is an immutable value: copies share their data, and cost nothing. All functions may be
/// called by several threads at once. Vertices are the nodes of the file, numbered from 0, and
/// arrays of points have one row per vertex. Lengths are in the unit of the file.
class Mesh {
 public:
  /// A mesh of `points` and `faces`, each the indices of its vertices in order: triangles, quads
  /// and polygons, in any mixture. Throws InputError if there are no faces, an index is out of
  /// range, a coordinate is not finite, or a triangle has no area. Cost: as prepare()
  /// (mesh/prepared_mesh.h).
  Mesh(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& faces);
  /// A mesh of triangles, or of quads.
  template <std::size_t corners>
  requires(corners == 3 || corners == 4)
      Mesh(const std::vector<Vec3>& points, const std::vector<std::array<int, corners>>& faces)
      : Mesh(points, lists_of(faces)) {}
  explicit Mesh(std::shared_ptr<const detail::SharedMesh> data) : data_(std::move(data)) {}

  const Points& points() const;  ///< vertex positions, n×3
  /// Vertices of each face, in order around it. Second-order faces include the midside nodes.
  std::vector<std::vector<int>> faces() const;
  /// Vertices of the triangles into which the faces are split, counter-clockwise.
  const std::vector<std::array<int, 3>>& triangles() const;
  const std::vector<int>& triangle_faces() const;  ///< index of the face of each triangle
  /// Named sets: those of the file, or of the model the faces (triangles) and curves (vertices).
  const std::vector<MeshSet>& sets() const;
  /// Exact unit normals of the surface at the corners of the triangles, for the mesh of a model: row
  /// 3 t + c belongs to corner c of triangle t. No rows: the mesh is not that of a model.
  const Points& corner_normals() const;
  /// Closed loops of boundary vertices, with the surface on their left: outlines and holes.
  std::vector<std::vector<int>> boundary_loops() const;
  std::string format() const;  ///< format of the file, such as "Nastran bulk data"; else empty
  /// Sentences about repairs and unusual properties of the mesh.
  const std::vector<std::string>& notes() const;

  // Selections.

  /// The holes: all boundary loops except the longest one of each part of the mesh, its outline.
  ///
  /// The flange around a hole ends at a crease (detect_features() in
  /// mesh/features/feature_detection.h). If there is none, it has the width `flange_width` (model
  /// units, default 0: one ring of faces). Throws InputError if the width is negative or not
  /// finite. O(n log n).
  std::vector<Hole> holes(double flange_width = 0) const;
  /// The features that deform scenes propose (`[proposals]`): holes with their flanges, and areas
  /// inside closed creases (detect_features()). Throws InputError unless the crease angle is above 0
  /// and below 180 degrees, `flange_rings` is 1 or more and `flange_width` is finite and not
  /// negative. O(n log n).
  std::vector<DetectedFeature> suggested_features(
      const FeatureDetectionOptions& options = {}) const;
  /// Mesh saliency of every vertex, 0 to 1 (mesh_saliency() in mesh/selection.h). The length scale
  /// is the diagonal of the bounding box, so the values depend slightly on the orientation of the
  /// mesh. Cost: 10 s on one core for 100,000 vertices. Reference: [Lee2005].
  VecX saliency() const;
  /// The shortest path along edges through the vertices nearest to the given points, in order; it
  /// follows creases (crease_path() in mesh/features/feature_lines.h). For a chain of a Deformer.
  ///
  /// `closed`: the path returns to its first vertex, which is not repeated. Throws InputError if
  /// there are no points, a coordinate is not finite, or the points lie on parts of the mesh that
  /// are not connected. O(n log n) per point.
  std::vector<int> crease_path(const std::vector<Vec3>& through, bool closed = false) const;
  /// The vertices in an axis-aligned box, ascending: low ≤ p ≤ high in every coordinate, without
  /// vertices that belong to no face. Throws InputError unless low ≤ high.
  std::vector<int> vertices_in(const Vec3& low, const Vec3& high) const;
  std::vector<int> vertices_in(const Box3& box) const { return vertices_in(box.min(), box.max()); }
  Box3 bounds() const;  ///< bounding box of all faces

  // Output.

  /// The same faces and sets with other positions (n×3), as a mesh without a file. Throws as the
  /// constructor.
  Mesh with_points(const Points& points) const;
  /// Writes a mesh file; the extension selects the format: .obj .off .ply .stl .vtp .vtu, and with a
  /// unit .glb .3mf. `points`: other vertex positions, n×3. `unit`: length unit of the
  /// coordinates, "mm", "cm", "m", "in" or "ft". Throws InputError, FileError.
  void save(const std::filesystem::path& file, const std::string& unit = "") const;
  void save(const std::filesystem::path& file, const Points& points,
            const std::string& unit = "") const;
  /// Writes the file that was read, with new vertex positions (n×3) and everything else unchanged.
  /// Returns the largest rounding error of a coordinate, model units.
  ///
  /// `large_field`: write the moved nodes of Nastran decks in large-field format. Throws InputError
  /// if the mesh was not read from a file, and as MeshFile::write() (io/meshes/mesh_file.h);
  /// FileError.
  double save_as_read(const std::filesystem::path& file, const Points& points,
                      bool large_field = false) const;

  // For Batten's own front ends.
  const detail::SharedMesh& data() const { return *data_; }
  const std::shared_ptr<const detail::SharedMesh>& shared_data() const { return data_; }

 private:
  template <std::size_t corners>
  static std::vector<std::vector<int>> lists_of(
      const std::vector<std::array<int, corners>>& faces) {
    std::vector<std::vector<int>> lists;
    lists.reserve(faces.size());
    for (const auto& face : faces) lists.emplace_back(face.begin(), face.end());
    return lists;
  }

  std::shared_ptr<const detail::SharedMesh> data_;
};

/// Reads a mesh file: OBJ, OFF, PLY, STL, VTP, VTU, Nastran, Abaqus, LS-DYNA, Radioss
/// (io/meshes/mesh_file.h). Throws InputError, which begins with the file name.
Mesh read_mesh(const std::filesystem::path& file);

// Deformers.

/// Motion of a handle: p = about + scale · R (p⁰ - about) + translate, where p⁰ is the position of a
/// vertex in the mesh and R the rotation by `angle` about `axis`.
struct Move {
  Vec3 translate = Vec3::Zero();  ///< model units
  Vec3 axis = Vec3::UnitZ();      ///< direction of the rotation axis, of any length above 0
  double angle = 0;               ///< degrees; may exceed a full turn
  double scale = 1;               ///< above 0
  /// Fixed point of rotation and scale, model units; empty: the mean of the handle's vertices.
  std::optional<Vec3> about = {};
};

/// Vertices with a name.
struct VertexGroup {
  std::string name;
  std::vector<int> vertices;
};

/// Constraint that keeps the mean of vertices on a plane: the centre of a hole (Hole::loop), a
/// feature, or a single vertex.
struct OnPlane {
  std::string name;
  std::vector<int> vertices;
  Vec3 normal = Vec3::UnitZ();  ///< of any length above 0
  /// A point of the plane, model units; empty: the mean of the vertices in the mesh.
  std::optional<Vec3> origin = {};
};

/// Constraint that keeps the mean of vertices on a straight line.
struct OnLine {
  std::string name;
  std::vector<int> vertices;
  Vec3 direction = Vec3::UnitZ();  ///< of any length above 0
  /// A point of the line, model units; empty: the mean of the vertices in the mesh.
  std::optional<Vec3> origin = {};
};

/// What a Deformer fixes, moves and keeps. All vertices are indices from 0. Names and meanings are
/// those of deform scenes (docs/deform.md).
struct DeformerSettings {
  std::vector<int> fixed = {};             ///< vertices that stay where they are
  std::vector<VertexGroup> handles = {};   ///< groups that deform() moves
  std::vector<VertexGroup> features = {};  ///< groups that keep their shape and may rotate
  /// Features that keep their orientation, too.
  std::vector<VertexGroup> keep_orientation = {};
  /// The vertices that may move, apart from handles; empty: all.
  std::optional<std::vector<int>> region_of_interest = {};
  /// On-plane and along-line constraints, satisfied exactly. Each couples x, y and z by one or two
  /// equations; meant for up to a few hundred.
  std::vector<std::variant<OnPlane, OnLine>> constraints = {};
  /// Chains of mesh edges that keep their shape approximately, and resist bending like a strip of
  /// the mesh. `width` 0: a tenth of the length of the chain. (A rigid chain is a feature.)
  std::vector<CharacterChain> chains = {};
  /// Linear combinations of vertex positions with a prescribed value; exact, or soft if they have a
  /// weight. A position constraint is a combination of one vertex with the coefficient 1.
  std::vector<LinearConstraint> linear_constraints = {};
  /// How features and curvature rotate if no handle prescribes it. Harmonic: linear, for drags. The
  /// other modes estimate the rotations for each deform(); the default of deform scenes is
  /// Estimated.
  RotationMode rotation_mode = RotationMode::Harmonic;
  DeformProblem::Weighting weighting = DeformProblem::Weighting::Area;
};

/// Convergence of Deformer::deform().
struct DeformerReport {
  /// Iterations of the estimate of rotations; 0: the rotation mode needs none.
  int iterations = 0;
  bool converged = true;  ///< false: the rotations still changed after the last iteration
  /// Largest change of a coordinate by the last correction of rounding errors, relative to the size
  /// of the mesh; 0: no correction.
  double last_correction = 0;
};

/// Rates of change of the arguments of Deformer::deform(), or a gradient with respect to them, by
/// name; absent ones are 0.
struct DeformerRates {
  struct Move {
    Vec3 translate = Vec3::Zero();
    /// Of the rotation vector (direction: the axis; length: the angle), degrees.
    Vec3 rotation = Vec3::Zero();
    double scale = 0;
  };
  std::map<std::string, Move> moves = {};     ///< of handles
  std::map<std::string, double> scales = {};  ///< of features
  std::map<std::string, Vec3> origins = {};   ///< of constraints
  std::map<std::string, Vec3> targets = {};   ///< of linear constraints
};

/// Morphs a mesh whose form features keep their shape exactly. The linear system is factored once.
/// With RotationMode::Harmonic, each deform() then costs one pair of triangular solves; with the
/// other modes it iterates, and gives the result of `batten deform` for a scene with the same
/// constraints and `centres = "free"`.
///
/// Mean-curvature vectors of the mesh are preserved up to a smooth field of rotations; fixed
/// vertices, handles, features and constraints without weight are exact
/// (mesh/deform/form_feature_deformer.h, mesh/editing/mesh_editor.h). With RotationMode::Nonlinear
/// and Dual and without features, the result is an as-rigid-as-possible or a dual Laplacian
/// deformation. Calls from several threads are serialised. Example: see Mesh. References:
/// [Masuda2006]; [SorkineAlexa2007] (Nonlinear); [Au2006] (Dual).
class Deformer {
 public:
  /// Throws InputError if a vertex is out of range, a group has no vertices, two objects of a kind
  /// have the same name, a number is invalid, or nothing is fixed or moved; NoSolutionError if the
  /// factorization fails.
  Deformer(const Mesh& mesh, const DeformerSettings& settings);
  ~Deformer();
  Deformer(Deformer&&) noexcept;
  Deformer& operator=(Deformer&&) noexcept;

  /// Applies moves of handles and scale factors of features, by name, to the mesh (not to the
  /// result of the previous call), and returns the positions of all vertices, n×3. Handles without
  /// a move stay where they are.
  ///
  /// `scales`: factors above 0, default 1. `correct`: true: one more solve, which reduces rounding
  /// errors; rotation modes other than Harmonic always do this. `origins`: another point of the
  /// plane or line of a constraint. `targets`: another value of a linear constraint. Throws
  /// InputError for an unknown name (with the nearest one) and for invalid numbers, and
  /// ConflictError if moves or constraints contradict each other; positions() is then unchanged.
  Points deform(const std::map<std::string, Move>& moves,
                const std::map<std::string, double>& scales = {}, bool correct = false,
                const std::map<std::string, Vec3>& origins = {},
                const std::map<std::string, Vec3>& targets = {});

  /// Directional derivative of the positions at the last deform() (initially: at the mesh), n×3:
  /// Jacobian times vector. RotationMode::Harmonic: exact, with one solve
  /// (FormFeatureDeformer::tangent()). Other modes: central differences of order four, exact to about
  /// 1e-9 relative to the size of the mesh per unit step, with four solutions. Throws InputError for
  /// an unknown name or a rate that is not finite, and the exceptions of deform().
  Points jvp(const DeformerRates& rates);
  /// Gradient of Σ weights ∘ positions with respect to all arguments at the last deform(): vector
  /// times Jacobian. `weights`: n×3, the derivative of an objective with respect to the positions.
  /// RotationMode::Harmonic: exact, with one solve for all numbers (FormFeatureDeformer::gradient()).
  /// Other modes: one jvp() for each number of the result, which are seven for each handle, one for
  /// each feature and three for each constraint. Throws the exceptions of jvp(), and InputError for another number of
  /// rows.
  DeformerRates vjp(const Points& weights);

  Points positions() const;       ///< result of the last deform(), n×3
  DeformerReport report() const;  ///< convergence of the last deform()
  /// Largest violation of an exact constraint, relative to the size.
  double residual() const;
  int unknowns() const;  ///< unknowns per coordinate, after elimination of the constraints
  /// Sentences about parts of the mesh that contain no handle and no fixed vertex.
  const std::vector<std::string>& notes() const;
  const Mesh& mesh() const;
  const DeformerSettings& settings() const;

  detail::DeformerState& state() const { return *state_; }  ///< for Batten's front ends

 private:
  std::unique_ptr<detail::DeformerState> state_;
};

}  // namespace batten
