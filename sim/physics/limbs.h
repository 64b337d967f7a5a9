#pragma once

#include <string>
#include <vector>

#include "sim/physics/bending_plant.h"
#include "sim/physics/plant_motion.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Where something is fixed to a plant: the section of a stem at a share of its length.
struct LimbPlace {
  int stem = -1;  ///< -1: the ground
  double share = 0;
};

/// How a specimen's organs move apart: the stems that bend it, at rest as its model is drawn, and
/// what carries each triangle and each keypoint of that model.
struct Limbs {
  BendingPlant plant;                   ///< in the model's axes
  std::vector<std::string> stem_names;  ///< one a stem: "stalk", or the organ's name
  std::vector<LimbPlace> triangles;
  std::vector<LimbPlace> keypoints;
};

/// A model in pieces that each move as one rigid body: one for each section of a stem that carries
/// triangles. Where stems bend the pieces part or overlap by their radius times the hinge's angle.
struct LimbPieces {
  std::vector<ObjectModel> models;   ///< in the model's axes, all with its part names; the first
                                     ///< has its keypoints
  std::vector<LimbPlace> places;     ///< of each piece
  std::vector<int> keypoint_pieces;  ///< of each keypoint
};
/// The piece on the ground comes first. @throws std::invalid_argument if `limbs` is of another
/// model, or names stems that it does not have.
LimbPieces cut_model(const ObjectModel& model, const Limbs& limbs);

/// Puts the pieces in the place of a specimen's model: it keeps its id, name and traits and becomes
/// the first piece; the others are its organs (Instance::part_of), appended with ids above all
/// others.
/// @param models  of the pieces in scene.models, where several specimens may share them
/// @return places in scene.instances, one a piece
std::vector<std::size_t> split_specimen(Scene& scene, std::size_t specimen,
                                        const LimbPieces& pieces, const std::vector<int>& models);

/// A specimen that split_specimen has taken apart.
struct SplitSpecimen {
  const Limbs* limbs = nullptr;
  const LimbPieces* pieces = nullptr;
  std::vector<std::size_t> places;
  std::vector<HandPush> pushes;
};

/// Gives all pieces their motion in one wind, each specimen bent by its own stems from where its
/// first piece stands. Weight is in the shape that the model has: gravity is left out.
/// @throws std::runtime_error naming the specimen that the engine could not move, or that a build
/// without physics cannot.
void sway_limbs(Scene& scene, const std::vector<SplitSpecimen>& specimens, const WindField& wind,
                const SwayConfig& config, const SwayWindows& windows);

/// What exposures, readouts and a rig's other sensors see about the times of views.
SwayWindows windows_of(const Scene& scene, double lead_s);

}  // namespace cousin
