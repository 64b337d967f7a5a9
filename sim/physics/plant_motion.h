#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"
#include "sim/physics/bending_plant.h"
#include "sim/physics/wind.h"

namespace cousin {

enum class PlantStatus {
  ok,
  not_at_rest,     ///< still moves at the end of max_time_s
  broke,           ///< a stem is strained beyond its strength
  penetrates,      ///< shapes overlap by more than max_penetration_m
  engine_warning,  ///< diverged, or out of room for contacts
  not_built        ///< without MuJoCo: nothing is bent
};
std::string_view to_string(PlantStatus status);

/// How weight and loads are let bend a plant to rest. Damping and inertia are not the plant's own
/// but what ends the motion soon; where it rests does not depend on them.
struct SagConfig {
  double step_s = 0.002;
  double inertia_time_s = 0.02;  ///< T of the inertia T^2 k added to every hinge: no mode is
                                 ///< faster than 1 / T
  double damping_per_s = 16;     ///< decay rate of all motion, as in a thick fluid
  double max_time_s = 10;
  double rest_m = 5e-5;  ///< no section leaves where it was by more for 0.2 s
  double friction = 0.3;
  double max_penetration_m = 5e-4;
  double gravity_m_s2 = 9.81;
};
Fields fields(SagConfig& config);
/// @throws std::invalid_argument naming key, value and limits, or for a step above inertia_time_s.
void validate(const SagConfig& config);

/// The most strained place.
struct StemStrain {
  double stress_pa = 0;
  double ratio = 0;  ///< over its stem's strength
  int stem = -1;
  double share = 0;
};

struct SagResult {
  PlantStatus status = PlantStatus::not_at_rest;
  BentPlant bent;
  double time_s = 0;             ///< simulated
  double moved_m = 0;            ///< farthest of a section within the last 0.2 s
  double max_penetration_m = 0;  ///< of loads into loads, stems and obstacles, of stems into
                                 ///< obstacles
  StemStrain strain;
  int warnings = 0;
  std::string first_warning;
};

/// The shape under weight. Repeats bit by bit on one machine.
/// @throws std::invalid_argument as validate(plant); std::runtime_error if the engine refuses it.
SagResult sag(const BendingPlant& plant, const SagConfig& config = {});

/// A hand that pushes a stem and lets go: a force that rises and falls as a half sine.
struct HandPush {
  int stem = 0;
  double share = 1;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< largest, in the world
  double begin_s = 0;
  double seconds = 0.5;
};

struct SwayConfig {
  double step_s = 0.001;
  double sample_s = 0.01;  ///< between the frames given back; a whole number of steps
  double duration_s = 2;
  double air_density_kg_m3 = 1.2;
  double drag_coefficient = 1.1;  ///< of a cylinder across the wind, Reynolds' number 1e2..1e4
  double gravity_m_s2 = 9.81;
  /// Loads with a shape, stems and obstacles touch. Where there are such, hinges get the inertia
  /// (2 step)^2 k, which slows a mode of f Hz by the share (4 pi f step)^2 / 2: chains stiffer than
  /// the step ring on what they touch. false: all pass through each other, and what rests on
  /// something falls.
  bool contacts = true;
  WindConfig wind;
};
Fields fields(SwayConfig& config);
/// @throws std::invalid_argument naming key, value and limits.
void validate(const SwayConfig& config);

struct SwayResult {
  PlantStatus status = PlantStatus::engine_warning;  ///< ok, broke, engine_warning or not_built
  std::vector<BentPlant> frames;                     ///< from time 0 on; ends where a stem broke
  StemStrain strain;                                 ///< largest of all times
  int warnings = 0;
  std::string first_warning;
};

/// The motion from a shape on, under wind and hands, with the stems' own damping. Drag acts on
/// sections and on loads, by the square of the air's speed past them; shadows of one on another are
/// left out.
/// @param from  as sag() found it.
/// @param rng  the gusts.
/// @throws std::invalid_argument as validate, and if a stem's damping_time_s is below the step: its
/// stiff modes would diverge.
SwayResult sway(const BendingPlant& plant, const BentPlant& from,
                const std::vector<HandPush>& pushes, const SwayConfig& config, Rng rng);

/// Stretches of time that somebody looks at, of a long motion.
struct SwayWindows {
  struct Span {
    double begin_s = 0, end_s = 0;
  };
  std::vector<Span> spans;  ///< sorted; they may overlap
  double lead_s = 1;        ///< the motion begins so long before the first, from a given shape
};
/// @throws std::invalid_argument for spans that end before they begin or are not sorted, or a lead
/// that is not in [0, 100].
void validate(const SwayWindows& windows);

/// As sway(), in a wind that other plants share, at the times of the windows: frames at whole
/// multiples of config.sample_s that cover each. After a pause of more than lead_s the motion
/// begins anew, lead_s before the next window: what was before has died away. Bodies feel the air
/// where they are at rest, so they must move by less than gusts are long. `config.duration_s` and
/// `config.wind` are not used.
SwayResult sway_windows(const BendingPlant& plant, const BentPlant& from,
                        const std::vector<HandPush>& pushes, const SwayConfig& config,
                        const WindField& wind, const SwayWindows& windows);

}  // namespace cousin
