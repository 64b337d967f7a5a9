#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"
#include "sim/physics/convex_parts.h"
#include "sim/types/mesh.h"
#include "sim/types/pose.h"

namespace cousin {

/// Contacts of millimetre bodies in MuJoCo 2.2: a step of at most 0.5 ms, solref = 2 steps, solimp
/// .99 .999 .0001, elliptic cones, Newton and no-slip iterations. With the engine's defaults a seed
/// sinks 0.37 mm into the board whatever it weighs (benchmarks/suites/stability/contact_cases.h
/// measures both).
struct SettleConfig {
  double step_s = 0.0005;
  double friction = 0.5;
  double spinning_friction_m =
      2e-5;  ///< torque against spin over normal force: about the radius of a contact patch
  double rolling_friction_m =
      2e-5;  ///< torque against rolling over normal force; lets slender grains come to rest
  double drag_per_s = 1.0;      ///< decay rate of velocities, as by air
  double drop_height_m = 0.01;  ///< lowest point above the board or the bodies below
  double max_time_s = 3.0;
  double rest_energy_j =
      1e-12;  ///< total kinetic energy below which, held for 50 ms, all are at rest
  double max_penetration_m = 2e-5;
  double board_half_m = 0.05;  ///< bodies whose centroid leaves this square have left the board
  int noslip_iterations = 3;
  int contacts_per_body = 30;  ///< that the engine has room for; its memory grows with the square
};
Fields fields(SettleConfig& config);
void validate(const SettleConfig& config);

struct SettleBody {
  const Mesh* mesh = nullptr;  ///< closed, centroid at the origin; must outlive the call
  double mass_kg = 0;
  Pose world_from_body;  ///< at release; its height is set by drop_height_m
  /// convex_parts(*mesh), for a body that is dropped more than once; null = made here. Must outlive
  /// the call.
  const ConvexParts* parts = nullptr;
};

enum class SettleStatus { ok, not_at_rest, penetrates, left_board, engine_warning, not_built };
std::string_view to_string(SettleStatus status);
struct SettleResult {
  SettleStatus status = SettleStatus::not_at_rest;
  std::vector<Pose> world_from_body;  ///< at rest
  double kinetic_energy_j = 0;        ///< at the end
  double max_penetration_m =
      0;  ///< of the true meshes' vertices into the board and into other bodies' convex parts
  double time_s = 0;          ///< simulated
  int warnings = 0;           ///< of the engine, all kinds
  std::string first_warning;  ///< its text
};

/// Drops closed bodies on the plane z = 0 until they rest. Non-convex bodies collide as convex
/// parts that follow their shape (convex_parts.h); masses and inertias are those of the exact mesh.
/// Repeats bit by bit on one machine.
/// @throws std::invalid_argument for a body without mesh or mass; std::runtime_error if the engine
/// refuses the model.
SettleResult settle(const std::vector<SettleBody>& bodies, const SettleConfig& config = {});

}  // namespace cousin
