#include <stdexcept>
#include <string>

#include "sim/physics/settle.h"

namespace cousin {

Fields fields(SettleConfig& c) {
  return {
      {"step_s", &c.step_s, "time step", 1e-6, 0.01},
      {"friction", &c.friction, "sliding friction coefficient", 0, 10},
      {"spinning_friction_m", &c.spinning_friction_m, "torque against spin over normal force", 0,
       0.01},
      {"rolling_friction_m", &c.rolling_friction_m, "torque against rolling over normal force", 0,
       0.01},
      {"drag_per_s", &c.drag_per_s, "decay rate of velocities", 0, 100},
      {"drop_height_m", &c.drop_height_m, "lowest point above what lies below", 0, 1},
      {"max_time_s", &c.max_time_s, "simulated time before giving up", 0.05, 60},
      {"rest_energy_j", &c.rest_energy_j, "kinetic energy at rest", 1e-18, 1},
      {"max_penetration_m", &c.max_penetration_m, "deepest allowed overlap", 0, 0.01},
      {"board_half_m", &c.board_half_m, "half the side of the square to stay on", 1e-3, 100},
      {"contacts_per_body", &c.contacts_per_body, "that there is room for", 10, 1000},
      {"noslip_iterations", &c.noslip_iterations, "of the engine's no-slip solver", 0, 100},
  };
}

void validate(const SettleConfig& config) {
  if (!(config.step_s > 0 && config.max_time_s > config.step_s)) {
    throw std::invalid_argument("settle: step_s is " + std::to_string(config.step_s) +
                                " and max_time_s " + std::to_string(config.max_time_s) +
                                "; the step must be positive and below it");
  }
}

std::string_view to_string(SettleStatus status) {
  switch (status) {
    case SettleStatus::ok:
      return "ok";
    case SettleStatus::not_at_rest:
      return "not_at_rest";
    case SettleStatus::penetrates:
      return "penetrates";
    case SettleStatus::left_board:
      return "left_board";
    case SettleStatus::engine_warning:
      return "engine_warning";
    case SettleStatus::not_built:
      return "not_built";
  }
  return "unknown";
}

}  // namespace cousin
