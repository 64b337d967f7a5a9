#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/learned/learned_distance.h"

namespace cousin {

/// A capture of seeds that models are trained on, by Gaussians or a radiance field.
struct SeedsTrainingTask {
  const SimulatedRun* run = nullptr;
  SeedsPipelineConfig pipeline;  ///< its method does not count
  std::uint64_t stage_seed = 0;
  SeedsScoreLabels labels;
  const LearnedDistance* learned = nullptr;
  Progress progress;
  std::vector<int> at;  ///< steps after which a model is measured, beside its last
  /// Trainings that were stopped go on from here, in a folder a method; empty: none do.
  std::filesystem::path unfinished;
  std::filesystem::path sfm_folder;  ///< where COLMAP keeps what it did; empty: nowhere
  /// Whose poses these are, with the seconds that they took; null: the pipeline's own.
  const Estimate* posed_by = nullptr;
};

struct MeasuredModel {
  Estimate estimate;
  ScoreFile file;  ///< the rows of the end, then those of `at`, whose case says the steps
};
/// The whole chain of a method that trains Gaussians; after each of `at` steps its model is
/// measured by the same chain, with the seconds that it would have taken to there. Specimens are of
/// the end. Each case says after how many steps.
MeasuredModel measure_by_splats(const SeedsTrainingTask& task, SeedsMethod method);

/// `splats` with scales, rotations and opacities at training's default rates, centres at a quarter
/// of theirs, and more Gaussians: for images, not for surfaces.
SeedsPipelineConfig pipeline_for_images(SeedsPipelineConfig pipeline, int steps);

/// Gaussians trained so from where those of `splats` begin: rows of photographs, method
/// "splats_images", of one training of so many steps.
std::vector<ScoreRow> measure_for_images(const SeedsTrainingTask& task, int steps);

/// Instant-NGP in the volume above the board on photographs of a third of the size, with the poses
/// of an estimate: rows "train." and "held_out.psnr_whole" and so on after each of `at` steps.
std::vector<ScoreRow> measure_by_ngp(const SeedsTrainingTask& task, const Poses& poses);

/// RMSE and MAPE of each trait with the seconds they cost: points of the error-against-time curves.
void add_curve_rows(const SeedsScores& scores, const Estimate& estimate,
                    const SeedsScoreLabels& labels, std::vector<ScoreRow>& rows);

}  // namespace cousin
