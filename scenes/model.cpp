// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/model.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene_paths.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/model_data.h"
#include "batten/scenes/shapes/load_effects.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/facets/welded_mesh.h"

namespace batten {
namespace detail {
namespace {

/// Facets of one face, with points and normals of the exact surface.
struct FacetsOfFace {
  DisplayFacets display;
  std::vector<SurfaceJet> jets;
  std::vector<Curvatures> curvatures;
};

Facets joined(const std::vector<FacetsOfFace>& faces) {
  Facets all;
  for (int r = 0; r < isize(faces); ++r) {
    const int first = static_cast<int>(all.points.size() / 3);
    for (const SurfaceJet& jet : faces[static_cast<size_t>(r)].jets) {
      const Vec3 normal = jet.normal();
      all.points.insert(all.points.end(), jet.x.data(), jet.x.data() + 3);
      all.normals.insert(all.normals.end(), normal.data(), normal.data() + 3);
    }
    for (const Curvatures& bend : faces[static_cast<size_t>(r)].curvatures)
      all.curvatures.insert(all.curvatures.end(), {bend.k1, bend.k2});
    for (std::array<int, 3> facet : faces[static_cast<size_t>(r)].display.tessellation.facets) {
      for (int& corner : facet) corner += first;
      all.triangles.push_back(facet);
      all.faces.push_back(r);
    }
  }
  return all;
}

std::vector<FacetsOfFace> facets_of(const std::vector<SkinnedRegion>& faces) {
  std::vector<FacetsOfFace> parts(faces.size());
  const auto all = pointers(faces);
  const double length = mean_facet_length(all);
  const int per_edge = display_facets_per_edge(all);
  parallel_for(isize(faces), [&](int r) {
    FacetsOfFace& part = parts[static_cast<size_t>(r)];
    const SkinnedRegion& face = faces[static_cast<size_t>(r)];
    part.display = batten::facets(face, per_edge, length);
    for (const Location& where : part.display.tessellation.points)
      part.jets.push_back(face.surface.jet(where));
    part.curvatures = recovered_curvatures(face.surface, part.display.tessellation);
  });
  return parts;
}

}  // namespace

ModelData::ModelData(std::string scene_text, Scene of, const Progress& progress)
    : text(std::move(scene_text)), scene(std::move(of)) {
  const ProgressScope scope(progress);
  progress.update("curves", 0);
  lines = faired_lines(scene, progress).lines;
  auto built = std::make_shared<BuiltModel>(build_model(scene, lines, progress));
  shape = solve_refined_shape(*built, scene, progress);
  made = std::move(built);
}

ModelData::ModelData(std::string scene_text, Scene of, const ModelData& curves, SolvedShape solved,
                     std::optional<SessionOrigin> from)
    : text(std::move(scene_text)),
      scene(std::move(of)),
      lines(curves.lines),
      made(curves.made),
      shape(std::move(solved)),
      origin(std::move(from)) {}

void ModelData::require_surface() const {
  if (shape.regions.empty())
    throw InputError(scene.name + ": found no surface, expected curves that bound a face");
}

const ModelData::LocatedFacets& ModelData::located_facets() const {
  return lazily(facets_, [this] {
    const std::vector<FacetsOfFace> parts = facets_of(shape.regions);
    LocatedFacets made{joined(parts), {}};
    for (int r = 0; r < isize(parts); ++r)
      for (const Location& where : parts[static_cast<size_t>(r)].display.tessellation.points)
        made.locations.push_back(shape.layout->to_model_location(r, where));
    return made;
  });
}

const Facets& ModelData::facets() const { return located_facets().facets; }

const std::vector<Location>& ModelData::facet_locations() const {
  return located_facets().locations;
}

const SurfaceModel& ModelData::measured() const {
  return lazily(measured_,
                [this] {
                  BuiltModel model = *made;
                  set_shape(model, shape);
                  return model;
                })
      .model;
}

const Report& ModelData::report(const Progress& progress) const {
  const ProgressScope scope(progress);
  return lazily(report_, [&] { return export_shape(scene, *made, shape, {}, progress); });
}

const std::vector<ShapeDerivative>& ModelData::shape_derivatives(const Progress& progress) const {
  return lazily(derivatives_,
                [&] { return batten::shape_derivatives(scene, *made, shape, progress); });
}

double ModelData::area() const {
  double sum = 0;
  for (const SkinnedRegion& face : shape.regions) sum += face.surface.area();
  return sum;
}

bool ModelData::is_closed() const {
  const std::vector<ModelShell>& shells = made->model.shells;
  return !shells.empty() && std::all_of(shells.begin(), shells.end(), [](const ModelShell& shell) {
    return shell.closed && shell.orientable;
  });
}

const ModelProjector& ModelData::projector() const {
  return lazily(projector_, [this] { return ModelProjector(*shape.layout, shape.dofs); });
}

}  // namespace detail

using detail::ModelData;

namespace {

[[noreturn]] void throw_unknown(const std::string& what, const std::string& name,
                                const std::vector<std::string>& names) {
  throw InputError("found the " + what + " name '" + name + "', expected one of the model's " +
                   what + "s" + did_you_mean(name, names));
}

Vec2 domain_point(const ParametricMesh& mesh, const Location& where) {
  return mesh.shape(where.triangle).point(where.L);
}

/// True if a point is in the domain of a face or, up to rounding, on its boundary.
bool in_domain(const Surface& surface, const Vec2& uv, const Location& nearest) {
  constexpr double rounding = 1e-9;
  const ParametricMesh& mesh = surface.mesh();
  const Vec2 found = domain_point(mesh, nearest);
  const double tolerance = rounding * mesh.edge_length(mesh.edges_of(nearest.triangle)[0]);
  if (!((found - mesh.image_near(uv, found)).norm() <= tolerance)) return false;
  if (!surface.trim()) return true;
  const DomainLoops& loops = surface.trim()->loops();
  for (const Vec2& shift : {Vec2(0, 0), Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)})
    if (loops.contains(mesh.wrapped(uv) + tolerance * shift)) return true;
  return false;
}

SurfacePoint point_of(const SkinnedRegion& face, const Location& where) {
  const SurfaceJet jet = face.surface.jet(where);
  const Curvatures curvature = curvatures(jet);
  const Vec2 uv = domain_point(face.surface.mesh(), where);
  return {jet.x, jet.normal(), curvature.k1, curvature.k2, face.name, uv[0], uv[1], 0};
}

const char* continuity(ModelJoin::Kind kind) {
  switch (kind) {
    case ModelJoin::Kind::FreeEdge:
      return "free edge";
    case ModelJoin::Kind::Crease:
      return "G0";
    case ModelJoin::Kind::Smooth:
      return "G1";
    case ModelJoin::Kind::NonManifold:
      break;
  }
  return "non-manifold";
}

PictureScene::Field field_from(const std::string& word) {
  if (word == "none") return PictureScene::Field::None;
  if (word == "mean") return PictureScene::Field::Mean;
  if (word == "gauss") return PictureScene::Field::Gauss;
  if (word == "faces") return PictureScene::Field::Regions;
  throw InputError("field: found '" + word + "', expected none, mean, gauss or faces" +
                   did_you_mean(word, {"none", "mean", "gauss", "faces"}));
}

}  // namespace

std::string Model::name() const { return data_->scene.name; }
std::string Model::unit() const { return data_->scene.unit; }

std::vector<std::string> Model::faces() const {
  std::vector<std::string> names;
  for (const SkinnedRegion& face : data_->shape.regions) names.push_back(face.name);
  return names;
}

std::vector<std::string> Model::curves() const {
  std::vector<std::string> names;
  for (const CharacterLine& line : data_->lines) names.push_back(line.name);
  return names;
}

double Model::fit_tolerance() const { return data_->made->fit_tolerance; }

std::vector<Vec3> Model::curve(const std::string& name, int count) const {
  if (count < 2) throw InputError("count: found " + std::to_string(count) + ", expected 2 or more");
  for (const CharacterLine& line : data_->lines) {
    if (line.name != name) continue;
    std::vector<Vec3> points;
    const InputCurve& curve = *line.curve;
    for (int i = 0; i < count; ++i)
      points.push_back(
          curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / (count - 1)));
    return points;
  }
  throw_unknown("curve", name, curves());
}

std::map<std::string, double> Model::parameters() const {
  std::map<std::string, double> values;
  for (const Parameter& p : data_->scene.parameters()) values[p.name] = p.value;
  return values;
}

Model Model::with_values(const std::map<std::string, double>& values,
                         const Progress& progress) const {
  Scene scene = data_->scene;
  bool live = true;  // the model of the curves can be reused
  for (const auto& [name, value] : values) {
    scene.set(name, value, "values: ");
    const bool material = name.starts_with("alpha") || name.starts_with("beta");
    live &= is_session_parameter(scene, name) && !(material && data_->made->network);
  }
  if (!live)
    return Model(std::make_shared<const ModelData>(data_->text, std::move(scene), progress));
  const ProgressScope scope(progress);
  SolvedShape shape = solve_refined_shape(*data_->made, scene, progress);
  return Model(std::make_shared<const ModelData>(data_->text, std::move(scene), *data_,
                                                 std::move(shape), std::nullopt));
}

std::string Model::scene() const {
  SceneText text(data_->text, data_->scene.file);
  if (text.value({}, "name").empty())  // the name of the file, which is not part of the text
    text.set({}, "name", SceneText::toml_value(data_->scene.name));
  const Scene original = parse_scene(data_->text, data_->scene.file);
  std::map<std::string, double> before;
  for (const Parameter& p : original.parameters()) before[p.name] = p.value;
  std::set<std::string> driven;
  for (const SceneRule& rule : data_->scene.rules) driven.insert(rule.driven);
  for (const Parameter& p : data_->scene.parameters())
    if (!driven.count(p.name) && before.at(p.name) != p.value) text.set_parameter(p.name, p.value);
  return text.text();
}

std::filesystem::path Model::folder() const { return folder_of(data_->scene.file); }

SurfacePoint Model::nearest(const Vec3& p) const {
  data_->require_surface();
  if (!p.allFinite()) throw InputError("point: found a number that is not finite");
  const ModelProjector::Nearest found = data_->projector().nearest_inside(p);
  SurfacePoint point =
      point_of(data_->shape.regions[static_cast<size_t>(found.at.region)], found.where);
  point.distance = (point.position - p).norm();
  return point;
}

SurfacePoint Model::at(const std::string& face, double u, double v) const {
  const Vec2 uv(u, v);
  for (const SkinnedRegion& region : data_->shape.regions) {
    if (region.name != face) continue;
    const Location where = region.surface.locate(uv);
    if (!in_domain(region.surface, uv, where))
      throw InputError("found the parameters (" + format_number(u) + ", " + format_number(v) +
                       "), expected a point in the domain of the face '" + face +
                       "'; nearest() returns the parameters of a point");
    return point_of(region, where);
  }
  throw_unknown("face", face, faces());
}

double Model::area() const { return data_->area(); }

double Model::volume() const {
  data_->require_surface();
  if (data_->made->model.shells.empty())
    throw InputError(data_->scene.name + ": found one open face, expected closed shells");
  if (!data_->is_closed())
    throw InputError(data_->scene.name +
                     ": found an open surface, expected closed shells, which have a volume");
  double volume = 0;
  for (const ModelShell& shell : data_->measured().shells) volume += shell.volume;
  return volume;
}

namespace {

double area_of(const ModelLayout& layout, const Points& shape) {
  double sum = 0;
  for (int r = 0; r < layout.region_count(); ++r) sum += layout.skinned(r, shape).surface.area();
  return sum;
}

double volume_of(const ModelLayout& layout, const Points& shape) {
  double sum = 0;
  for (int r = 0; r < layout.region_count(); ++r)
    sum += cone_volume(layout.skinned(r, shape), layout.origin());
  return sum;
}

/// Central difference of a measure of the shape along a rate of change.
template <class Measure>
double derivative_along(const ModelLayout& layout, const Points& shape, const Points& rate,
                        const Measure& measure) {
  constexpr double small = 1e-5;
  const double largest = rate.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return 0;
  const double step = small * layout.size() / largest;
  return (measure(layout, shape + step * rate) - measure(layout, shape - step * rate)) / (2 * step);
}

}  // namespace

std::vector<LoadEffect> Model::load_effects(const Progress& progress) const {
  const ProgressScope scope(progress);
  data_->require_surface();
  return batten::load_effects(data_->scene, *data_->made, data_->shape, progress);
}

ModelGradients Model::gradients(const Progress& progress) const {
  const ProgressScope scope(progress);
  data_->require_surface();
  const detail::ModelData& d = *data_;
  ModelGradients gradients;
  gradients.area.value = area();
  if (d.is_closed()) gradients.volume.emplace().value = volume();
  for (const ShapeDerivative& of : d.shape_derivatives(progress)) {
    const auto derivative = [&](const auto& measure) {
      return derivative_along(*d.shape.layout, d.shape.dofs, of.rate, measure);
    };
    gradients.area.gradient[of.parameter] = derivative(area_of);
    if (gradients.volume) gradients.volume->gradient[of.parameter] = derivative(volume_of);
  }
  return gradients;
}

Box3 Model::bounds() const {
  Box3 box;
  const std::vector<double>& points = facets().points;
  for (size_t i = 0; i < points.size(); i += 3)
    box.extend(Vec3(points[i], points[i + 1], points[i + 2]));
  return box;
}

std::vector<ModelEdge> Model::edges() const {
  std::vector<ModelEdge> edges;
  const SurfaceModel& model =
      data_->made->model.joins.empty() ? data_->made->model : data_->measured();
  for (const ModelJoin& join : model.joins) {
    ModelEdge edge{join.line, {}, continuity(join.kind), join.max_deg, join.max_gap};
    for (const int r : join.regions)
      edge.faces.push_back(model.regions[static_cast<size_t>(r)].plan.name);
    edges.push_back(std::move(edge));
  }
  if (!model.joins.empty()) return edges;
  for (const SkinnedRegion& face : data_->shape.regions)
    for (const auto& loop : face.boundary)
      for (const BoundarySegment& piece : loop) {
        const bool aligned = piece.kind == BoundarySegment::Kind::EdgeAligned;
        const auto at = static_cast<size_t>(piece.index);
        edges.push_back({aligned ? face.edge_aligned[at].line.name : face.embedded[at].line.name,
                         {face.name},
                         "free edge",
                         0,
                         0});
      }
  return edges;
}

int Model::element_count() const {
  int count = 0;
  for (const SkinnedRegion& face : data_->shape.regions)
    count += face.surface.mesh().triangle_count();
  return count;
}

const Facets& Model::facets() const {
  data_->require_surface();
  return data_->facets();
}

Mesh Model::mesh() const {
  data_->require_surface();
  WeldedMesh welded = welded_mesh(data_->shape.all());
  ShellMesh shells;
  shells.points = std::move(welded.points);
  for (const std::array<int, 3>& triangle : welded.triangles) shells.add_face(triangle);
  std::vector<MeshSet> sets;
  for (const std::string& face : faces()) sets.push_back({face, "", {}, {}});
  for (int t = 0; t < isize(welded.region); ++t)
    sets[static_cast<size_t>(welded.region[static_cast<size_t>(t)])].faces.push_back(t);
  for (const WeldedCurve& curve : welded.curves) {
    MeshSet set{curve.name, "", {}, {}};
    for (const WeldedCurve::Polyline& line : curve.polylines)
      set.nodes.insert(set.nodes.end(), line.vertices.begin(), line.vertices.end());
    sets.push_back(std::move(set));
  }
  auto mesh = std::make_shared<detail::SharedMesh>(std::move(shells), std::move(sets));
  mesh->corner_normals = std::move(welded.normals);
  return Mesh(std::move(mesh));
}

std::string Model::report(const Progress& progress) const {
  return to_json(data_->report(progress));
}

std::vector<std::string> Model::failed_checks(const Progress& progress) const {
  return sentences(data_->report(progress).failed_checks);
}

std::vector<std::string> Model::save(const std::filesystem::path& file,
                                     const Progress& progress) const {
  const ProgressScope scope(progress);
  if (file.extension() == ".toml") {
    const SceneText moved =
        with_moved_paths(SceneText(scene(), data_->scene.file), folder(), folder_of(file));
    write_file_atomically(file, [&](std::ostream& out) { out << moved.text(); });
    return {};
  }
  data_->require_surface();
  return sentences(
      export_shape(data_->scene, *data_->made, data_->shape, file, progress).failed_checks);
}

void Model::picture(const std::filesystem::path& file, const PictureView& view) const {
  data_->require_surface();
  PictureScene look;
  look.azimuth = view.azimuth;
  look.elevation = view.elevation;
  look.field = field_from(view.field);
  look.contours = view.contours;
  look.zebra = view.zebra;
  look.mesh = view.mesh;
  look.title = view.title;
  look.unit = data_->scene.unit;
  draw_picture(file, shape_picture(look, *data_->made, data_->shape), {view.width, view.height});
}

// Models from curves, files and text.

namespace {

/// A scene in memory: its relative paths refer to the folder of this name.
constexpr const char* kSceneInMemory = "scene";
constexpr const char* kSkin = "skin()";

Model made(const std::string& text, const std::filesystem::path& file,
           const std::map<std::string, double>& values, const Progress& progress) {
  Scene scene = parse_scene(text, file);
  for (const auto& [name, value] : values) scene.set(name, value, "values: ");
  return Model(std::make_shared<const ModelData>(text, std::move(scene), progress));
}

template <class Value>
std::string list_of(const std::vector<Value>& values) {
  std::vector<std::string> texts;
  for (const Value& value : values) texts.push_back(SceneText::toml_value(value));
  return SceneText::list(texts);
}

/// The key of the shape of a curve: its points, or a spline that is equal to the curve.
std::string shape_of(const InputLine& line) {
  if (!line.curve) {
    constexpr size_t fewest = 2;
    if (line.points.size() < fewest)
      throw InputError("curve '" + line.name + "': found " + std::to_string(line.points.size()) +
                       " points, expected 2 or more");
    return "points = " + list_of(line.points);
  }
  const CubicSpline spline = whole_spline(line.name, *line.curve);
  std::vector<double> knots;
  for (size_t k = 0; k < spline.knots.size(); ++k)
    knots.insert(knots.end(), static_cast<size_t>(spline.multiplicities[k]), spline.knots[k]);
  return "spline = " +
         SceneText::inline_table(
             {{"degree", "3"}, {"poles", list_of(spline.poles)}, {"knots", list_of(knots)}});
}

}  // namespace

std::string detail::curve_table(const InputLine& line) {
  return "\n[[curve]]\nname = " + SceneText::toml_value(line.name) + "\n" + shape_of(line) + "\n";
}

namespace {

void require_known(const std::vector<std::string>& names, const std::string& what,
                   const std::vector<std::string>& curves) {
  for (const std::string& name : names)
    if (std::find(curves.begin(), curves.end(), name) == curves.end())
      throw InputError(what + ": found the curve name '" + name + "', expected one of curves" +
                       did_you_mean(name, curves));
}

void require_size(double value, const std::string& what) {
  if (!(value >= 0) || !std::isfinite(value))
    throw InputError(what + ": found " + format_number(value) + ", expected a number above 0");
}

/// The scene of skin() without curves. `added`: number of lines before the first line of the
/// settings, apart from the unit.
std::string scene_without_curves(const SkinSettings& settings, int& added) {
  if (settings.unit.find_first_of("\"\\\n") != std::string::npos)
    throw InputError("unit: found '" + settings.unit + "', expected mm, cm, m, in or ft");
  std::string text;
  const auto add = [&](const std::string& key, const std::string& value) {
    text += key + " = " + value + "\n";
    ++added;
  };
  if (!settings.name.empty()) add("name", SceneText::toml_value(settings.name));
  if (settings.fit_tolerance > 0)
    add("fit_tolerance", SceneText::toml_value(settings.fit_tolerance));
  if (settings.corner_angle > 0) add("corner_angle", SceneText::toml_value(settings.corner_angle));
  text += "unit = \"" + settings.unit + "\"";
  if (!settings.settings.starts_with('\n')) text += "\n";
  return text + settings.settings;
}

/// Corrects the line numbers "skin():LINE:" of a message to those of the settings.
std::string with_lines_of_settings(const std::string& message, int added) {
  const std::string where = std::string(kSkin) + ":";
  const size_t at = message.find(where);
  if (at == std::string::npos) return message;
  const size_t from = at + where.size(), to = message.find(':', from);
  const int line = std::atoi(message.c_str() + from);
  if (to == std::string::npos || line <= added) return message;
  return message.substr(0, from) + std::to_string(line - added) + message.substr(to);
}

/// The key `role` of a curve; "": none.
std::string role_key(const std::string& curve, const SkinSettings& settings) {
  const auto listed = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), curve) != names.end();
  };
  if (listed(settings.holes)) return "role = \"hole\"\n";
  return listed(settings.inner) ? "role = \"inner\"\n" : "";
}

/// The scene of curves and settings, as text.
std::string scene_of(const std::vector<InputLine>& curves, const SkinSettings& settings,
                     int& added) {
  if (curves.empty()) throw InputError("curves: found none, expected one or more");
  std::vector<std::string> names;
  for (const InputLine& curve : curves) {
    if (curve.name.empty())
      throw InputError("curves: found an empty name, expected one with letters");
    if (std::find(names.begin(), names.end(), curve.name) != names.end())
      throw InputError("curves: found the name '" + curve.name +
                       "' twice, expected different names");
    names.push_back(curve.name);
  }
  require_known(settings.inner, "inner", names);
  require_known(settings.holes, "holes", names);
  require_known(settings.smooth, "smooth", names);
  require_known(settings.crease, "crease", names);
  require_size(settings.fit_tolerance, "fit_tolerance");
  require_size(settings.edge_length, "edge_length");
  require_size(settings.corner_angle, "corner_angle");
  SceneText scene(scene_without_curves(settings, added), kSkin);
  for (const SceneTable& table : scene.tables())
    if (table.kind == "curve" || table.kind == "curves")
      throw InputError("settings: found a [[curve]], expected none: curves are given as arrays");
  if (settings.edge_length > 0)
    scene.set({"mesh", ""}, "edge_length", SceneText::toml_value(settings.edge_length));
  for (const auto& [list, kind] : {std::pair(&settings.smooth, "G1"), {&settings.crease, "G0"}})
    if (!list->empty())
      scene.add("join", "{ curves = " + SceneText::toml_string_list(*list) + ", continuity = \"" +
                            kind + "\" }");
  std::string text = scene.text();
  for (const InputLine& curve : curves)
    text += detail::curve_table(curve) + role_key(curve.name, settings);
  return text;
}

}  // namespace

Model skin(const std::vector<InputLine>& curves, const SkinSettings& settings,
           const Progress& progress) {
  int added = 0;
  try {
    const std::string text = scene_of(curves, settings, added);
    return made(text, kSkin, {}, progress);
  } catch (const InputError& e) {
    const std::string message = with_lines_of_settings(e.what(), added);
    if (message == e.what()) throw;
    throw InputError(message);
  }
}

Model load(const std::filesystem::path& file, const std::map<std::string, double>& values,
           const Progress& progress) {
  const FileKind kind = file_kind(file);
  if (kind != FileKind::Cad && kind != FileKind::Lines)
    return made(read_input_file(file, "a scene (.toml)"), file, values, progress);
  require_input_file(file, "a curve file");
  const std::string text = "name = " + SceneText::toml_value(file.stem().string()) +
                           "\nunit = \"mm\"\n\n[[curves]]\nfile = " +
                           SceneText::toml_value(std::filesystem::absolute(file).string()) + "\n";
  return made(text, folder_of(file) / kSceneInMemory, values, progress);
}

Model parse(const std::string& scene, const std::filesystem::path& folder,
            const std::map<std::string, double>& values, const Progress& progress) {
  return made(scene, folder / kSceneInMemory, values, progress);
}

}  // namespace batten
