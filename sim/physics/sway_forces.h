#pragma once

#include <vector>

#include "sim/physics/plant_model.h"
#include "sim/physics/plant_motion.h"

namespace cousin {

// Private to sim/physics: what moves a plant.

StemStrain strain_of(const PlantStress& stress);

/// @throws std::invalid_argument as sway().
void check_sway(const BendingPlant& plant, const std::vector<HandPush>& pushes,
                const SwayConfig& config);

/// Forces of the air and of hands on one motion's bodies. Keeps references.
class SwayForces {
 public:
  SwayForces(const BendingPlant& plant, const HingedPlant& engine, const SwayConfig& config,
             const std::vector<HandPush>& pushes, WindField wind);

  /// From now on bodies feel the air where they are in `rest`, not where they have moved to: as
  /// good where they move by less than gusts are long, and ten times as fast.
  void fix_air(const mjData& rest);

  /// Steps that forces are held for: gusts are slower.
  long hold_steps() const;
  void apply(mjData& data);

 private:
  Eigen::Vector3d air_m_s(const mjData& data, int body) const;
  void advance_air(double time_s);
  Eigen::Vector3d drag_n(const mjData& data, int body, const Eigen::Vector3d& along,
                         double drag_area_m2) const;
  void push_stem(mjData& data, const PlantHinge& hinge) const;
  void push_load(mjData& data, std::size_t i) const;
  void push_by_hand(mjData& data, const HandPush& push) const;

  const BendingPlant& plant_;
  const HingedPlant& engine_;
  const SwayConfig& config_;
  const std::vector<HandPush>& pushes_;
  WindField wind_;
  // Of the air held at rest: each mode's angle at each body (a column) and at the time.
  Eigen::Matrix3Xd amplitudes_m_s_;
  Eigen::ArrayXXd cosines_, sines_;
  Eigen::ArrayXd time_cosines_, time_sines_;
};

}  // namespace cousin
