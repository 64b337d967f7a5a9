#pragma once

#include <filesystem>

#include "benchmarks/suites/seedlings/seedlings_jobs.h"

namespace cousin {

/// The job's pictures for the page (write_report_scene, named as the job): a photograph that was
/// trained on and the held-out one whose surface the fewest views see, each beside the model's
/// image; of the latter also the pixels that fewer than kEnoughViews see, in red.
void write_sample_pictures(const std::filesystem::path& report, const SeedlingsJob& job,
                           const TrainedField& field, const FieldViews& views);

/// Photograph and image, side by side.
Image<Rgb8> side_by_side(const FidelityPlanes& left, const FidelityPlanes& right);

}  // namespace cousin
