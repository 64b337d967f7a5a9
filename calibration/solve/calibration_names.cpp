// What a solver, a status and a parameter are called.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "calibration/solve/calibrate.h"

namespace cousin {

std::string_view to_string(CalibrationSolver solver) {
  constexpr std::array<std::string_view, 3> kNames = {"opencv", "ceres", "mrcal"};
  return kNames.at(static_cast<std::size_t>(solver));
}

CalibrationSolver calibration_solver_from_string(std::string_view text) {
  for (const CalibrationSolver solver :
       {CalibrationSolver::opencv, CalibrationSolver::ceres, CalibrationSolver::mrcal}) {
    if (to_string(solver) == text) return solver;
  }
  throw std::invalid_argument("calibration solver \"" + std::string(text) +
                              "\" is not one of opencv, ceres, mrcal");
}

std::string_view to_string(CalibrationStatus status) {
  constexpr std::array<std::string_view, 5> kNames = {"ok", "not_determined", "not_converged",
                                                      "bad_input", "not_built"};
  return kNames.at(static_cast<std::size_t>(status));
}

int parameter_index(const CalibrationResult& result, std::string_view name) {
  const auto at = std::find(result.parameters.begin(), result.parameters.end(), name);
  return at == result.parameters.end() ? -1 : static_cast<int>(at - result.parameters.begin());
}

double deviation(const CalibrationResult& result, std::string_view name) {
  const int i = parameter_index(result, name);
  return i < 0 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(result.covariance(i, i));
}

}  // namespace cousin
