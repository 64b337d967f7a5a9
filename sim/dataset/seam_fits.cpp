// fits.json
//   {"fits": [{"instance": 0, "model": "sphere", "status": "ok", "reason": "",
//              "parameters": [{"name": "radius", "unit": "m", "value": number or null}],
//              "covariance": [row-major, as many rows as parameters] or null}]}
// Values of any unit that units.h knows are converted to its SI unit with their covariance, others
// are refused. "reason" and "covariance" may be absent.

#include <set>

#include "sim/dataset/json_covariance.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"
#include "sim/dataset/units.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxFits = 10'000'000;
constexpr std::size_t kMaxParameters = 1000;  ///< of one fit
constexpr int kMaxFitInstance = 1'000'000'000;

/// @param factors  out: of the parameters' units
void read_parameters(const JsonNode& node, Eigen::VectorXd& factors, ObjectFit& fit) {
  const std::vector<JsonNode> entries = node.elements(kMaxParameters);
  factors = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(entries.size()));
  std::set<std::string> names;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const JsonNode& entry = entries[i];
    entry.expect_keys({"name", "unit", "value"});
    FitParameter parameter;
    parameter.name = entry["name"].text(256);
    if (!names.insert(parameter.name).second) entry["name"].fail("occurs twice");
    try {
      const SiUnit unit = si_unit(entry["unit"].text(32));
      parameter.unit = unit.si_unit;
      factors[static_cast<Eigen::Index>(i)] = unit.factor;
      parameter.value = entry["value"].number_or_nan() * unit.factor;
    } catch (const std::invalid_argument& error) {
      entry["unit"].fail(error.what());
    }
    fit.parameters.push_back(std::move(parameter));
  }
}

void read_covariance(const JsonNode& node, const Eigen::VectorXd& factors, ObjectFit& fit) {
  fit.covariance = covariance_from(node, factors.size());
  fit.covariance = factors.asDiagonal() * fit.covariance * factors.asDiagonal();
}

ObjectFit read_fit(const JsonNode& node) {
  node.expect_keys({"instance", "model", "status", "parameters"}, {"reason", "covariance"});
  ObjectFit fit;
  fit.instance = static_cast<int>(node["instance"].integer(0, kMaxFitInstance));
  fit.model = node["model"].text(256);
  fit.status = node["status"].choice(
      {FitStatus::ok, FitStatus::too_few_points, FitStatus::degenerate, FitStatus::not_converged});
  if (node.has("reason")) fit.reason = node["reason"].text();
  Eigen::VectorXd factors;
  read_parameters(node["parameters"], factors, fit);
  if (node.has("covariance") && !node["covariance"].is_null())
    read_covariance(node["covariance"], factors, fit);
  return fit;
}

}  // namespace

std::string fits_to_json(const Fits& fits) {
  Json list = Json::array();
  for (const ObjectFit& fit : fits) {
    Json parameters = Json::array();
    for (const FitParameter& parameter : fit.parameters) {
      parameters.push_back({{"name", parameter.name},
                            {"unit", parameter.unit},
                            {"value", nan_to_null(parameter.value)}});
    }
    Json covariance;
    if (fit.covariance.size() > 0) covariance = to_json(fit.covariance);
    list.push_back({{"instance", fit.instance},
                    {"model", fit.model},
                    {"status", to_string(fit.status)},
                    {"reason", fit.reason},
                    {"parameters", parameters},
                    {"covariance", covariance}});
  }
  Json root = Json::object();
  root["fits"] = std::move(list);
  return to_text(root);
}

Fits fits_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"fits"});
  Fits fits;
  for (const JsonNode& node : root["fits"].elements(kMaxFits)) fits.push_back(read_fit(node));
  return fits;
}

}  // namespace cousin
