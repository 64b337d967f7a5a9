#pragma once

#include <string>
#include <vector>

#include "sim/physics/bending_plant.h"
#include "sim/physics/engine.h"

// A BendingPlant in MuJoCo. Private to physics and to those that measure the engine.

namespace cousin {

struct PlantEngine {
  double step_s = 0.001;
  std::string integrator = "Euler";  ///< Euler, implicit, RK4
  double gravity_m_s2 = 9.81;
  bool contacts = true;  ///< by the engine's PGS: a few contacts on many hinges
  double friction = 0.3;
  bool twists = true;  ///< false: hinges bend only
  /// T of an inertia T^2 k added to every hinge: slows a mode to omega / sqrt(1 + (T omega)^2) and
  /// leaves rest where it is. The engine reckons contacts without the damping that its step takes
  /// implicitly, so a chain stiffer than the step jumps on what it lies on for ever.
  double inertia_time_s = 0;
  double least_damping_s = 0;  ///< tau of c = tau k is at least this
};

/// One hinge of three axes: two to bend, one to twist.
struct PlantHinge {
  std::size_t stem = 0;
  int node = 0;         ///< of the section that it moves, 1..segments
  int body = 0;         ///< the engine's
  int first_angle = 0;  ///< the engine's address of its first angle, in positions and speeds alike
  double stiffness_n_m = 0;  ///< E I / segment, for one axis of bending
  double radius_m = 0;       ///< of the stem at the hinge
  Eigen::Vector3d at_m;      ///< unloaded, in the world
  Eigen::Vector3d along;     ///< unit, unloaded
};

struct HingedPlant {
  EngineModel model;
  std::vector<PlantHinge> hinges;        ///< stem by stem, from the base
  std::vector<std::size_t> first_hinge;  ///< of each stem
  std::vector<int> load_body;            ///< the engine's, of each load
  int axes = 3;                          ///< of a hinge
};

/// @throws std::invalid_argument as validate(plant); std::runtime_error if the engine refuses.
HingedPlant make_plant_model(const BendingPlant& plant, const PlantEngine& engine);

/// Where all sections are.
BentPlant bent_plant(const BendingPlant& plant, const HingedPlant& plant_model, const mjData& data);
/// Puts the hinges at the angles of `bent`, at rest. @throws std::invalid_argument if it is of
/// another plant.
void set_bent(const HingedPlant& plant_model, const BentPlant& bent, mjData& data);

/// Where a stem is most strained.
struct PlantStress {
  double ratio = 0;  ///< stress over the stem's strength
  double stress_pa = 0;
  int stem = -1;
  double share = 0;
};
/// The largest stress over strength of all hinges: bending, E r theta / segment, and what hangs
/// below it along the stem over the cross-section.
PlantStress largest_stress(const BendingPlant& plant, const HingedPlant& plant_model,
                           const mjData& data);

/// Elastic energy in the hinges and kinetic energy of all bodies.
struct PlantEnergy {
  double elastic_j = 0;
  double kinetic_j = 0;
};
PlantEnergy energy_of(const HingedPlant& plant_model, const mjData& data);

}  // namespace cousin
