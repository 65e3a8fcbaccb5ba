// SPDX-License-Identifier: MPL-2.0
// Sets of B-spline patches as CAD files.
#include "batten/io/cad/continuity_report.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

#include <fstream>

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// Two bilinear patches side by side, the second tilted by 45 degrees.
std::string two_patches() {
  const auto patch = [](const std::string& coefs) {
    const std::string knots = "<KnotVector degree=\"1\">0 0 1 1</KnotVector>";
    return "<Geometry type=\"TensorBSpline2\" id=\"0\"><Basis type=\"TensorBSplineBasis2\">"
           "<Basis type=\"BSplineBasis\" index=\"0\">" +
           knots + "</Basis><Basis type=\"BSplineBasis\" index=\"1\">" + knots +
           "</Basis></Basis><coefs geoDim=\"3\">\n" + coefs + "</coefs></Geometry>\n";
  };
  return "<xml>\n" + patch("0 0 0\n2 0 0\n0 3 0\n2 3 0\n") + patch("2 0 0\n3 0 1\n2 3 0\n3 3 1\n") +
         "</xml>\n";
}

std::filesystem::path put(const std::string& text) {
  const auto path = scratch("patches") / "set.xml";
  std::ofstream(path) << text;
  return path;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("patches that touch share their edge, with the continuity of their poles", "[io][cad]") {
  const auto file = put(two_patches());
  const ContinuityReport report = measure_continuity(file, 1e-3);
  CHECK(report.faces == 2);
  CHECK(report.edges == 7);
  REQUIRE(report.inner.size() == 1);
  CHECK(report.inner[0].angle_deg == Approx(45));
  CHECK(report.inner[0].length == Approx(3));
  CHECK(read_cad_lines(file, 1e-3).size() == 7);
  CHECK(read_cad_surfaces(file, 1e-3).size() == 2);
}

TEST_CASE("patches that cannot be are refused by their number", "[io][cad]") {
  const auto error_of = [](const std::string& text) {
    return error_message([&] { read_cad_lines(put(text), 1e-3); });
  };
  const std::string good = two_patches();
  CHECK_THAT(error_of(good.substr(0, good.size() / 2)), Contains("XML"));
  CHECK_THAT(error_of(""), Contains("set.xml"));
  CHECK_THAT(error_of("<xml></xml>"), Contains("no Geometry"));
  CHECK_THAT(error_of(replaced(good, "2 3 0", "2 3")), Contains("patch 1: found 11 coordinates"));
  CHECK_THAT(error_of(replaced(good, "3 0 1", "3 nan 1")), Contains("patch 2: found 'nan'"));
  CHECK_THAT(error_of(replaced(good, "0 0 1 1", "0 1 0 1")), Contains("knots that fall"));
  CHECK_THAT(error_of(replaced(good, "0 0 1 1", "0 0.5 1 1")), Contains("clamp"));
  CHECK_THAT(error_of(replaced(good, "degree=\"1\"", "degree=\"99\"")), Contains("degree"));
  CHECK_THAT(error_of(replaced(good, "geoDim=\"3\"", "geoDim=\"2\"")),
             Contains("three coordinates"));
}
