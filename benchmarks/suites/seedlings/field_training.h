#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/suites/seedlings/field_scores.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/splats/splat_model.h"
#include "perception/splats/view_exposures.h"

namespace cousin {

/// Methods as the tables call them.
inline constexpr const char* kReference = "3DGS, reference schedule";
inline constexpr const char* kOurs = "3DGS, ours";
inline constexpr const char* kNgp = "Instant-NGP";

/// One method on one set of views.
struct FieldPlan {
  std::string method = kReference;
  /// Steps after which it is scored, rising. The reference's schedule is one training of 30,000
  /// steps that is left after the last of these; so is the radiance field's, whose schedule has no
  /// end; ours is a training of its own for each, since its schedule ends with its steps.
  std::vector<int> at;
  int start_points = 20000;  ///< of Gaussians
  int ngp_samples = 65536;   ///< of a step of the radiance field, about
  /// Ours: Gaussians that each of `at` may have; empty: as training has by default.
  std::vector<int> most_splats = {};
};

struct TrainedField {
  std::string status;  ///< "ok", or why there are no scores
  std::vector<FieldScores> scores;
  FieldRenderer render;     ///< of the last scores' model
  SplatModel splats;        ///< that model, if it is of Gaussians
  ViewExposures exposures;  ///< of the views trained on, if the method measured them
};

/// What Gaussians begin from. Radiance fields need none.
struct FieldStart {
  std::vector<StartPoint> points;  ///< the reference's; and ours where nothing is swept
  /// Ours: surfaces swept in `volume`, and `beside`, what a sweep does not find.
  SweepVolume volume;
  std::vector<StartPoint> beside;
};

/// Trains and scores. Seconds of ours are with those of its sweep.
/// @param unfinished  folder of this training alone: Gaussians that were stopped go on from here;
/// empty: none do
TrainedField train_field(const FieldPlan& plan, const FieldViews& views, const FieldStart& start,
                         std::uint64_t seed, const std::filesystem::path& unfinished = {});

}  // namespace cousin
