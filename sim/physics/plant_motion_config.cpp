#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/physics/plant_motion.h"

namespace cousin {

std::string_view to_string(PlantStatus status) {
  switch (status) {
    case PlantStatus::ok:
      return "ok";
    case PlantStatus::not_at_rest:
      return "not_at_rest";
    case PlantStatus::broke:
      return "broke";
    case PlantStatus::penetrates:
      return "penetrates";
    case PlantStatus::engine_warning:
      return "engine_warning";
    case PlantStatus::not_built:
      return "not_built";
  }
  return "unknown";
}

Fields fields(SagConfig& c) {
  return {
      {"step_s", &c.step_s, "time step", 1e-6, 0.01},
      {"inertia_time_s", &c.inertia_time_s, "T of the inertia T^2 k of every hinge", 1e-6, 1},
      {"damping_per_s", &c.damping_per_s, "decay rate of all motion", 0, 1000},
      {"max_time_s", &c.max_time_s, "simulated time before giving up", 0.1, 100},
      {"rest_m", &c.rest_m, "how far a section may stray in 0.2 s of rest", 1e-9, 0.01},
      {"friction", &c.friction, "sliding friction coefficient", 0, 10},
      {"max_penetration_m", &c.max_penetration_m, "deepest allowed overlap", 0, 0.01},
      {"gravity_m_s2", &c.gravity_m_s2, "downwards", 0, 100},
  };
}

void validate(const SagConfig& config) {
  SagConfig copy = config;
  check_limits(fields(copy), "sag");
  if (config.step_s > config.inertia_time_s) {
    throw std::invalid_argument("sag: step_s is " + std::to_string(config.step_s) +
                                "; it must be at most inertia_time_s, " +
                                std::to_string(config.inertia_time_s));
  }
}

Fields fields(SwayConfig& c) {
  return Fields{
             {"step_s", &c.step_s, "time step", 1e-6, 0.01},
             {"sample_s", &c.sample_s, "between frames", 1e-6, 10},
             {"duration_s", &c.duration_s, "of the motion", 1e-6, 600},
             {"air_density_kg_m3", &c.air_density_kg_m3, "of air", 0, 10},
             {"drag_coefficient", &c.drag_coefficient, "of stems, as cylinders", 0, 10},
             {"gravity_m_s2", &c.gravity_m_s2, "downwards", 0, 100},
             {"contacts", &c.contacts, "loads and stems touch"},
         } +
         nested("wind", fields(c.wind));
}

void validate(const SwayWindows& windows) {
  if (!(windows.lead_s >= 0 && windows.lead_s <= 100)) {
    throw std::invalid_argument("sway: lead_s is " + std::to_string(windows.lead_s) +
                                "; it must be in [0, 100]");
  }
  constexpr double kFar_s = 1e6;
  double last_s = -kFar_s;
  for (const SwayWindows::Span& span : windows.spans) {
    if (!(span.begin_s >= last_s && span.end_s >= span.begin_s && span.end_s <= kFar_s)) {
      throw std::invalid_argument("sway: a window from " + std::to_string(span.begin_s) + " to " +
                                  std::to_string(span.end_s) + " s is not one, or not sorted");
    }
    last_s = span.begin_s;
  }
}

void validate(const SwayConfig& config) {
  SwayConfig copy = config;
  check_limits(fields(copy), "sway");
  const double steps = config.sample_s / config.step_s;
  if (std::abs(steps - std::round(steps)) > 1e-6 || steps < 0.5) {
    throw std::invalid_argument("sway: sample_s is " + std::to_string(config.sample_s) +
                                "; it must be a whole number of steps of " +
                                std::to_string(config.step_s));
  }
}

}  // namespace cousin
