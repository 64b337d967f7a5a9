#include "benchmarks/tools/import/unknown_lens.h"

#include <algorithm>
#include <cmath>

#include "perception/sfm/self_calibration.h"

namespace cousin {
namespace {

constexpr std::size_t kMostPhotographs = 40;
constexpr std::size_t kLeastPhotographs = 3;
constexpr double kMostSigmaShare = 0.1;

/// Evenly spread over all.
ColmapInput input_of(const Capture& photographs) {
  ColmapInput input;
  const std::size_t all = photographs.frames.size(), count = std::min(all, kMostPhotographs);
  for (std::size_t i = 0; i < count; ++i)
    input.images.push_back(&photographs.frames[i * all / count].sensors.front().color);
  input.pairs = image_pairs(static_cast<int>(count), {.choice = PairChoice::exhaustive});
  return input;
}

AssumedLens usual_lens(const Image<Rgb8>& image, const std::string& why) {
  AssumedLens lens;
  const double focal_px = 0.85 * std::max(image.width(), image.height());
  lens.camera = camera_of_focal(focal_px, image.width(), image.height());
  lens.focal_sigma_px = 0.25 * focal_px;
  lens.from =
      "an assumption, 0.85 of the larger side without distortion: no photograph has a focal length "
      "in EXIF, and " +
      why + "; give --intrinsics, see `cousin calibrate`";
  return lens;
}

}  // namespace

AssumedLens unknown_lens(const Capture& photographs, const ColmapConfig& config) {
  const Image<Rgb8>& first = photographs.frames.at(0).sensors.at(0).color;
  if (photographs.frames.size() < kLeastPhotographs)
    return usual_lens(first, "self-calibration needs " + std::to_string(kLeastPhotographs) +
                                 " photographs, not " + std::to_string(photographs.frames.size()));
  ColmapConfig self = config;
  self.lens = ColmapLens::self;
  const ColmapRun run = run_colmap(input_of(photographs), self);
  if (run.status != ColmapStatus::ok)
    return usual_lens(first, "self-calibration failed (" + std::string(to_string(run.status)) +
                                 ": " + run.reason + ")");
  const SelfCalibration found = self_calibrate(run.model, std::nullopt);
  const double sigma_px = deviation(found, "fx_px");
  if (found.status != CalibrationStatus::ok || !(sigma_px < kMostSigmaShare * found.lens.fx_px))
    return usual_lens(first, "the photographs do not determine the lens (" + found.reason + ")");
  AssumedLens lens{found.lens, sigma_px, ""};
  lens.from = "by self-calibration: COLMAP placed " + std::to_string(run.model.images.size()) +
              " photographs, " + std::to_string(found.observations) +
              " sightings; the deviation is that of the fit";
  return lens;
}

}  // namespace cousin
