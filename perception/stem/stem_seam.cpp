#include "perception/stem/stem_seam.h"

#include <stdexcept>
#include <string>

namespace cousin {

ObjectFit stem_as_fit(const StemNodes& nodes, int instance, bool has_root) {
  ObjectFit fit;
  fit.instance = instance;
  fit.model = "stem";
  fit.status = nodes.status;
  fit.reason = nodes.reason;
  if (nodes.status != FitStatus::ok) return fit;
  const bool root_kept = has_root && nodes.places.front() == 0;
  for (std::size_t i = 0; i < nodes.nodes_m.size(); ++i) {
    const std::string name = "node_" + std::to_string(root_kept ? i : i + 1) + "_";
    const char* const axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k)
      fit.parameters.push_back({name + axes[k], "m", nodes.nodes_m[i](k)});
    fit.parameters.push_back({name + "along", "m", nodes.along_m[i]});
  }
  fit.covariance = nodes.covariance_m2;
  return fit;
}

FittedStem stem_of_fit(const ObjectFit& fit) {
  if (fit.model != "stem")
    throw std::invalid_argument("fits.json: object " + std::to_string(fit.instance) + " is a \"" +
                                fit.model + "\", not a \"stem\"");
  FittedStem stem;
  stem.nodes.status = fit.status;
  stem.nodes.reason = fit.reason;
  if (fit.status != FitStatus::ok) return stem;
  if (fit.parameters.empty() || fit.parameters.size() % 4 != 0)
    throw std::invalid_argument("fits.json: stem " + std::to_string(fit.instance) + " has " +
                                std::to_string(fit.parameters.size()) +
                                " parameters; four are asked for each node");
  stem.has_root = fit.parameters.front().name == "node_0_x";
  for (std::size_t i = 0; i + 3 < fit.parameters.size(); i += 4) {
    stem.nodes.places.push_back(static_cast<int>(i / 4));
    stem.nodes.nodes_m.emplace_back(fit.parameters[i].value, fit.parameters[i + 1].value,
                                    fit.parameters[i + 2].value);
    stem.nodes.along_m.push_back(fit.parameters[i + 3].value);
  }
  stem.nodes.covariance_m2 = fit.covariance;
  return stem;
}

}  // namespace cousin
