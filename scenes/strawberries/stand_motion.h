#pragma once

#include <string>
#include <vector>

#include "scenes/strawberries/plant_rows.h"
#include "scenes/strawberries/truss.h"
#include "sim/config/fields.h"
#include "sim/physics/rigid_sway.h"

namespace cousin {

/// A hand that pushes a truss where it forks first, and lets go while a view is taken.
struct TrussPush {
  double force_n = 0;                            ///< largest; 0 = no hand
  int truss = 0;                                 ///< the number in its name
  double azimuth_rad = 1.57, elevation_rad = 0;  ///< where it pushes to, from +x to +y and up
  int view = 0;                                  ///< whose time_s is the middle of the push
  double seconds = 0.5;
};

/// What moves a stretch while it is photographed.
struct StandWind {
  WindConfig wind;  ///< still by default
  TrussPush push;
};
/// "wind", "gusts." and "push.": keys of a scene.
Fields fields(StandWind& config);
inline bool is_still(const StandWind& config) {
  return config.wind.mean_speed_m_s == 0 && config.push.force_n == 0;
}

/// Trusses about the times of views, from 0.05 s before each to 0.2 s after, which is what
/// exposures, readouts and a rig's other sensors see; each view in gusts of its own that begin
/// before it, from rest on. Empty: nothing moves.
/// @param rest  of bending_plant(trusses)  @param times_s  at least 0.25 s apart
/// @throws std::invalid_argument for a hand on a truss or view that is not there;
/// std::runtime_error with the status and the stalk where one breaks or the engine gives up.
std::vector<BentPlant> sway_trusses(const std::vector<Truss>& trusses, const BentPlant& rest,
                                    const StandWind& config, const std::vector<double>& times_s,
                                    const Rng& rng);
/// Those of some of the stems.
std::vector<BentPlant> frames_of(const std::vector<BentPlant>& frames, std::size_t first_stem,
                                 std::size_t end_stem);

/// A piece of a truss's stalks as it hangs, in the world, and its motion.
struct StalkPart {
  std::string name;  ///< "" for the whole, else " stalk SS piece K"
  ObjectModel model;
  std::vector<TimedPose> motion;
};
/// At rest one model, a part each stalk; in motion a piece for each section, which parts from its
/// neighbours by its radius times the turn of the hinge between them.
std::vector<StalkPart> stalk_parts(const Truss& truss, const std::vector<BentPlant>& frames,
                                   int sides);

/// Gives leaves their motion in the wind, each swinging about its base.
void sway_leaves(Scene& scene, const std::vector<LoneLeaf>& leaves, const StandWind& config,
                 const RigidSwayConfig& sway, const std::vector<double>& times_s, const Rng& rng);

}  // namespace cousin
