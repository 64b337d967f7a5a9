#pragma once

#include <cstdint>
#include <string_view>

#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/stem/node_matching.h"
#include "perception/stem/node_shift.h"
#include "perception/stem/plant_height.h"
#include "perception/stem/stem_fit.h"

namespace cousin {

/// `ours` fits a smooth stem to nodes matched in their order; `triangulation` places each of these
/// nodes by itself; `paper` matches by the epipolar test and takes mid-points [Maize 3.1]. All take
/// keypoints from outside: there is no detector yet.
enum class MaizeMethod { ours, triangulation, paper };

/// Each frame of a stereo pair by itself, in the axes of its left camera.
struct MaizePipelineConfig {
  MaizeMethod method = MaizeMethod::ours;
  double sigma_px = 1;         ///< of a keypoint whose detector says nothing of it
  double lens_px = 0.2;        ///< of what the reported lens is off in one place
  double most_apart_s = 0.05;  ///< exposures farther apart are no pair
  bool match_images = true;    ///< ours: shifts from the images themselves
  bool measure_height = true;  ///< else plants have no height
  /// Of an image: a frame with more keypoints is not solved, for matching takes the square of their
  /// number and a stem its cube.
  int most_points = 250;
  NodeMatchConfig match;
  NodeShiftConfig shift;
  StemFitConfig stem;
  PlantHeightConfig height;
};
Fields fields(MaizePipelineConfig& config);
void validate(const MaizePipelineConfig& config);
std::string_view to_string(MaizeMethod method);

PipelineNeeds needs(const MaizePipelineConfig& config);
/// A sentence for each setting that the method does not use.
std::vector<std::string> unused_settings(const MaizePipelineConfig& config);
/// @throws std::invalid_argument if the capture is not of a stereo pair
void check_capture(const Capture& capture, const MaizePipelineConfig& config);

/// Plants of a frame are numbered from this times the frame's place in the capture.
inline constexpr int kPlantsOfFrame = 1000;

/// Stages fits and traits.
///
/// Keypoints: an entry's first point is a root, its others are nodes in any order; what belongs
/// together in the two images, and which node is which plant's, is found here. Missing points are
/// passed over.
///
/// Fits: a "stem" a plant (stem_fit.h); a frame without any has one that says why.
///
/// Traits are of one plant in one frame (SpecimenTraits::frame): internode_I between its points I -
/// 1 and I from the lowest on, as a chord, internode_geodesic_I along the stem, and plant_height.
Stages stages_for(const MaizePipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const MaizePipelineConfig& config);

}  // namespace cousin
