// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_variants.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <mutex>
#include <optional>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/files/text.h"
#include "batten/scenes/meshes/derivative_files.h"
#include "batten/scenes/meshes/dimension_requirements.h"
#include "batten/scenes/meshes/morph_measures.h"

namespace batten {
namespace {

constexpr char kTable[] = "variants.csv";

std::string shortest_text(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

/// Sets the parameters of one variant.
void set_variant(DeformScene& scene, const DesignTable& design, size_t row) {
  const std::string where = "variant " + std::to_string(row + 1) + ": ";
  for (size_t p = 0; p < design.parameters.size(); ++p)
    scene.set(design.parameters[p], design.rows[row][p], where);
}

/// What one variant adds to the results.
struct Variant {
  std::string number, status = "ok", row;
  std::vector<std::string> files;
  double rounding = 0;
};

/// The variants of one run.
class VariantWriter {
 public:
  VariantWriter(const DeformScene& scene, const MeshFile& file,
                const std::vector<MeshDimension>& dimensions, const DesignTable& design,
                const OutputFolder& out)
      : scene_(scene),
        file_(file),
        dimensions_(dimensions),
        design_(design),
        out_(out),
        digits_(std::max<size_t>(3, std::to_string(design.rows.size()).size())),
        columns_(design.parameters) {
    for (const RequirementSpec& rule : scene.requirements)
      if (!rule.adjust.text.empty() &&
          std::find(columns_.begin(), columns_.end(), rule.adjust.text) == columns_.end())
        columns_.push_back(rule.adjust.text);
  }

  std::string header() const {
    std::string text = "variant";
    for (const std::string& name : columns_) text += "," + csv_cell(name);
    for (const MeshDimension& d : dimensions_) text += "," + csv_cell(d.name());
    return text +
           ",largest_displacement,worst_aspect,worst_warpage_deg,worst_jacobian,inverted_faces,"
           "status,file\n";
  }

  /// Solves, measures and writes one variant.
  Variant write(size_t row, MorphSolver& solver) const {
    Variant variant;
    variant.number = std::to_string(row + 1);
    variant.number.insert(0, digits_ - variant.number.size(), '0');
    DeformScene scene = scene_;
    set_variant(scene, design_, row);
    std::optional<DeformReport> measured;
    try {
      meet_requirements(solver, scene, dimensions_);
      measured.emplace();
      measured->unit = scene.unit;
      measure_morph(*measured, file_, solver, dimensions_);
      const std::vector<FailedCheck> failed = failed_checks(*measured, solver, dimensions_);
      if (!failed.empty()) variant.status = failed.front().what + " " + failed.front().detail;
      if (!scene.mesh_out.empty()) write_mesh(variant, solver);
    } catch (const CancelledError&) {
      throw;
    } catch (const FileError&) {
      throw;
    } catch (const Error& e) {
      variant.status = e.what();
      measured.reset();
    }
    variant.row = variant.number;
    for (const std::string& column : columns_)
      variant.row += "," + shortest_text(value_of(scene, column));
    append_measures(measured, variant.row);
    variant.row += "," + csv_cell(variant.status) + "," +
                   (variant.files.empty() ? "" : csv_cell(variant.files.front())) + "\n";
    return variant;
  }

 private:
  void append_measures(const std::optional<DeformReport>& measured, std::string& row) const {
    if (!measured) {
      row += std::string(dimensions_.size() + 5, ',');
      return;
    }
    for (const auto& d : measured->dimensions) row += "," + shortest_text(d.after);
    for (const double value :
         {measured->largest_displacement, measured->after.aspect.worst,
          measured->after.warpage_degrees.worst, measured->after.jacobian.worst,
          static_cast<double>(measured->inverted.size())})
      row += "," + shortest_text(value);
  }

  void write_mesh(Variant& variant, const MorphSolver& solver) const {
    const std::string folder = "variant-" + variant.number;
    const std::string file = folder + "/" + scene_.mesh_out;
    const std::filesystem::path tree = folder / file_.folder_in_tree();
    std::filesystem::create_directories(out_.file(tree.string()));
    const MeshWriteOptions options{scene_.large_field_nodes, out_.folder() / tree};
    const DeferredFlush deferred;  // OutputFolder::commit() flushes all files
    variant.rounding =
        file_.write(out_.file(file), node_positions(solver.shape(), file_), options).largest;
    variant.files.push_back(file);
    for (const auto& beside : file_.included_files())
      variant.files.push_back((tree / beside).lexically_normal().string());
  }

  static double value_of(const DeformScene& scene, const std::string& name) {
    for (const Parameter& p : scene.parameters())
      if (p.name == name) return p.value;
    return 0;
  }

  const DeformScene& scene_;
  const MeshFile& file_;
  const std::vector<MeshDimension>& dimensions_;
  const DesignTable& design_;
  const OutputFolder& out_;
  size_t digits_;                     // of the number of a variant
  std::vector<std::string> columns_;  // parameters in the table
};

/// Number of solvers that work at the same time: each has its own factorization.
int worker_count(int rows, int nodes) {
  constexpr int most_nodes = 400000;  // of all workers, because of their memory
  return std::clamp(most_nodes / std::max(nodes, 1), 1, std::min(thread_count(), rows));
}

/// All variants; each worker takes the next one.
std::vector<Variant> all_variants(const VariantWriter& writer, MorphSolver& solver,
                                  const DeformScene& scene, int rows, const Progress& progress) {
  std::vector<Variant> variants(static_cast<size_t>(rows));
  std::atomic<int> next = 0;
  std::mutex reporting;
  parallel_for(worker_count(rows, solver.mesh().vertex_count()), [&](int worker) {
    std::optional<MorphSolver> own;
    if (worker > 0) own.emplace(scene, solver.source(), solver.tolerance());
    for (int row = next++; row < rows; row = next++) {
      variants[static_cast<size_t>(row)] =
          writer.write(static_cast<size_t>(row), own ? *own : solver);
      const std::lock_guard lock(reporting);
      progress.update("variants", static_cast<double>(row + 1) / rows);
    }
  });
  return variants;
}

}  // namespace

void check_design(const DeformScene& scene, const DesignTable& design) {
  DeformScene variant = scene;
  for (size_t row = 0; row < design.rows.size(); ++row) set_variant(variant, design, row);
}

void write_variants(DeformReport& report, MorphSolver& solver, const DeformScene& scene,
                    const MeshFile& file, const std::vector<MeshDimension>& dimensions,
                    const DesignTable& design, const OutputFolder& out, const Progress& progress) {
  check_design(scene, design);
  const VariantWriter writer(scene, file, dimensions, design, out);
  const auto variants = all_variants(writer, solver, scene, isize(design.rows), progress);
  std::string table = writer.header(), first_failure;
  DeformReport::Variants summary{isize(variants), 0, kTable};
  for (const Variant& variant : variants) {
    table += variant.row;
    report.rounding = std::max(report.rounding, variant.rounding);
    report.files.insert(report.files.end(), variant.files.begin(), variant.files.end());
    if (variant.status != "ok" && summary.failed++ == 0)
      first_failure = "variant " + variant.number + ": " + variant.status;
  }
  write_file_atomically(out.file(kTable), [&](std::ostream& text) { text << table; });
  report.files.push_back(kTable);
  if (summary.failed > 0)
    report.failed_checks.push_back({"variants", std::to_string(summary.failed) + " of " +
                                                    format_count(variants.size(), "variant") +
                                                    " failed, the first is " + first_failure});
  report.variants = summary;
}

}  // namespace batten
