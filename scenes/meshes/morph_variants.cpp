// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_variants.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
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

/// Writes the variants one by one.
class VariantWriter {
 public:
  VariantWriter(MorphSolver& solver, const DeformScene& scene, const MeshFile& file,
                const std::vector<MeshDimension>& dimensions, const DesignTable& design,
                const OutputFolder& out, const Progress& progress)
      : solver_(solver),
        scene_(scene),
        file_(file),
        dimensions_(dimensions),
        design_(design),
        out_(out),
        progress_(progress),
        columns_(design.parameters) {
    for (const RequirementSpec& rule : scene.requirements)
      if (!rule.adjust.text.empty() &&
          std::find(columns_.begin(), columns_.end(), rule.adjust.text) == columns_.end())
        columns_.push_back(rule.adjust.text);
  }

  DeformReport::Variants write(DeformReport& report) {
    std::string table = header();
    DeformReport::Variants variants{isize(design_.rows), 0, kTable};
    std::string first_failure;
    const size_t digits = std::max<size_t>(3, std::to_string(design_.rows.size()).size());
    for (size_t i = 0; i < design_.rows.size(); ++i) {
      progress_.update("variants",
                       static_cast<double>(i) / static_cast<double>(design_.rows.size()));
      std::string number = std::to_string(i + 1);
      number.insert(0, digits - number.size(), '0');
      DeformScene variant = scene_;
      set_variant(variant, design_, i);
      const std::string status = add_variant("variant-" + number, variant, report, table);
      if (status == "ok") continue;
      if (variants.failed++ == 0) first_failure = "variant " + number + ": " + status;
    }
    write_file_atomically(out_.file(kTable), [&](std::ostream& text) { text << table; });
    report.files.push_back(kTable);
    if (variants.failed > 0)
      report.failed_checks.push_back({"variants", std::to_string(variants.failed) + " of " +
                                                      format_count(design_.rows.size(), "variant") +
                                                      " failed, the first is " + first_failure});
    return variants;
  }

 private:
  std::string header() const {
    std::string text = "variant";
    for (const std::string& name : columns_) text += "," + csv_cell(name);
    for (const MeshDimension& d : dimensions_) text += "," + csv_cell(d.name());
    return text +
           ",largest_displacement,worst_aspect,worst_warpage_deg,worst_jacobian,inverted_faces,"
           "status,file\n";
  }

  /// Adds a row, and writes the mesh of a variant; returns the status.
  std::string add_variant(const std::string& name, DeformScene& variant, DeformReport& report,
                          std::string& table) {
    std::string status = "ok", written;
    std::optional<DeformReport> measured;
    try {
      meet_requirements(solver_, variant, dimensions_, cancellable());
      measured.emplace();
      measured->unit = scene_.unit;
      measure_morph(*measured, file_, solver_, dimensions_);
      const std::vector<FailedCheck> failed = failed_checks(*measured, solver_, dimensions_);
      if (!failed.empty()) status = failed.front().what + " " + failed.front().detail;
      if (!scene_.mesh_out.empty()) written = write_mesh(name, report);
    } catch (const CancelledError&) {
      throw;
    } catch (const FileError&) {
      throw;
    } catch (const Error& e) {
      status = e.what();
      measured.reset();
    }
    table += name.substr(name.find('-') + 1);
    for (const std::string& column : columns_)
      table += "," + shortest_text(value_of(variant, column));
    append_measures(measured, table);
    table += "," + csv_cell(status) + "," + csv_cell(written) + "\n";
    return status;
  }

  void append_measures(const std::optional<DeformReport>& measured, std::string& table) const {
    if (!measured) {
      table += std::string(dimensions_.size() + 5, ',');
      return;
    }
    for (const auto& d : measured->dimensions) table += "," + shortest_text(d.after);
    for (const double value :
         {measured->largest_displacement, measured->after.aspect.worst,
          measured->after.warpage_degrees.worst, measured->after.jacobian.worst,
          static_cast<double>(measured->inverted.size())})
      table += "," + shortest_text(value);
  }

  std::string write_mesh(const std::string& name, DeformReport& report) const {
    const std::string file = name + "/" + scene_.mesh_out;
    std::filesystem::create_directories(out_.file(name));
    const MeshWriteOptions options{scene_.large_field_nodes, out_.folder() / name};
    const MeshFile::Rounding rounding =
        file_.write(out_.file(file), node_positions(solver_.shape(), file_), options);
    report.rounding = std::max(report.rounding, rounding.largest);
    report.files.push_back(file);
    for (const auto& beside : file_.included_files())
      report.files.push_back(name + "/" + beside.string());
    return file;
  }

  static double value_of(const DeformScene& scene, const std::string& name) {
    for (const Parameter& p : scene.parameters())
      if (p.name == name) return p.value;
    return 0;
  }

  /// Progress without reports, which would replace those of the variants.
  Progress cancellable() const { return {{}, progress_.cancelled}; }

  MorphSolver& solver_;
  const DeformScene& scene_;
  const MeshFile& file_;
  const std::vector<MeshDimension>& dimensions_;
  const DesignTable& design_;
  const OutputFolder& out_;
  const Progress& progress_;
  std::vector<std::string> columns_;  // parameters in the table
};

}  // namespace

void check_design(const DeformScene& scene, const DesignTable& design) {
  DeformScene variant = scene;
  for (size_t row = 0; row < design.rows.size(); ++row) set_variant(variant, design, row);
}

void write_variants(DeformReport& report, MorphSolver& solver, const DeformScene& scene,
                    const MeshFile& file, const std::vector<MeshDimension>& dimensions,
                    const DesignTable& design, const OutputFolder& out, const Progress& progress) {
  report.variants =
      VariantWriter(solver, scene, file, dimensions, design, out, progress).write(report);
}

}  // namespace batten
