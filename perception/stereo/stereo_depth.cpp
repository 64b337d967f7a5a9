#include "perception/stereo/stereo_depth.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/stereo/disparity_lookup.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

/// What a frame's depths follow from.
struct FoundPair {
  const Rectification& geometry;
  const PairDisparities& disparities;
  double calibration_px;
};

/// Depth along the axis of the first camera, whose rectified one shares its centre.
void look_up(const FoundPair& pair, const Camera& camera, FrameDepth& depth) {
  const bool has_sigma = !pair.disparities.sigma_px.empty();
  depth.depth_m = Image<float>(camera.width_px, camera.height_px, kNone);
  if (has_sigma) depth.sigma_m = depth.depth_m;
  const Lens lens(camera), rectified(pair.geometry.camera);
  const double focal_baseline = pair.geometry.camera.fx_px * pair.geometry.baseline_m;
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const auto ray = lens.unproject(Eigen::Vector2d(x, y));
      if (!ray || !(ray->z() > 0)) continue;
      const Eigen::Vector3d turned = pair.geometry.rectified_from_left * *ray;
      const auto pixel = rectified.project(turned);
      if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) continue;
      const KnownDisparity found =
          disparity_at(pair.disparities.disparity_px, pair.disparities.sigma_px, *pixel);
      const auto disparity_px = static_cast<double>(found.disparity_px);
      if (!(disparity_px > 0)) continue;
      // The rectified depth is along another axis: the same point's distance is what both share.
      const double depth_m = focal_baseline / disparity_px / turned.z() * ray->z();
      depth.depth_m(x, y) = static_cast<float>(depth_m);
      if (!has_sigma) continue;
      const double off_px = std::hypot(static_cast<double>(found.sigma_px), pair.calibration_px);
      depth.sigma_m(x, y) = static_cast<float>(depth_m * off_px / disparity_px);
    }
  });
}

PairMatchConfig to_nearest(PairMatchConfig pair, const Rectification& geometry, double nearest_m) {
  if (!(nearest_m > 0)) return pair;
  const double most_px = geometry.camera.fx_px * geometry.baseline_m / nearest_m;
  if (!(most_px <= geometry.camera.width_px)) {
    throw std::invalid_argument("stereo depth: nearest_m = " + std::to_string(nearest_m) + " is " +
                                std::to_string(most_px) + " px of disparity; the limit is " +
                                std::to_string(geometry.camera.width_px) + ", the image's width");
  }
  pair.range_px = std::max(1, static_cast<int>(std::ceil(most_px)));
  return pair;
}

constexpr std::array<Named<PairMatcher>, 2> kPairMatchers = {
    {{PairMatcher::ours, "ours"}, {PairMatcher::opencv, "opencv"}}};

}  // namespace

std::string_view to_string(PairMatcher matcher) {
  return name_in<PairMatcher>(kPairMatchers, matcher);
}
TextField matcher_field(PairMatcher& matcher) {
  return choice_field<PairMatcher>("method", kPairMatchers, matcher);
}

Fields fields(StereoDepthConfig& c) {
  DisparityRefinementConfig& refine = c.pair.refine;
  return {
      {"range_px", &c.pair.range_px, "largest disparity; 0: the images say so", 0, 4000},
      {"nearest_m", &c.nearest_m, "disparities end there in place of range_px; 0: there", 0, 1e6},
      {"most_apart_s", &c.most_apart_s, "exposures farther apart are no pair", 0, 1000},
      {"align_rows", &c.pair.align_rows, "move the right image's rows to where the images agree"},
      {"calibration_px", &c.calibration_px,
       "deviation of a frame's disparities by what the calibration is off", 0, 100},
      {"uniqueness", &c.pair.match.uniqueness, "least share that the best match is better by", 0,
       0.99},
      {"speckle_px", &c.pair.speckle_px, "ours: smaller patches are left out", 1, 100000},
      {"least_matched", &c.pair.least_matched,
       "of the pixels with texture; a frame with fewer is not solved", 0, 1},
      {"radius_px", &refine.radius_px, "ours: half the window of the least squares", 1, 15},
      {"least_likeness", &refine.least_likeness, "ours: correlation of both windows", 0, 0.999},
      {"most_sigma_px", &refine.most_sigma_px, "ours: disparities known worse are left out", 0.001,
       10},
      {"sigma_floor_px", &refine.sigma_floor_px, "ours: deviation of the best pixels", 0, 10}};
}

void validate(const StereoDepthConfig& config) {
  StereoDepthConfig copy = config;
  check_limits(fields(copy), "stereo_depth");
  validate(config.pair.match);
  const DisparityRefinementConfig& refine = config.pair.refine;
  if (!(refine.sigma_floor_px < refine.most_sigma_px))
    throw std::invalid_argument("stereo depth: sigma_floor_px " +
                                std::to_string(refine.sigma_floor_px) +
                                " is not below most_sigma_px " +
                                std::to_string(refine.most_sigma_px) + ": nothing would be left");
}

StereoMeasure measure_stereo(const Capture& capture, std::size_t frame,
                             const StereoDepthConfig& config) {
  validate(config);
  check_stereo_rig(capture);
  const Frame& seen = capture.frames.at(frame);
  StereoMeasure result;
  result.depth.frame = seen.id;
  result.findings.why_none = why_no_stereo_pair(capture, seen, config.most_apart_s);
  if (!result.findings.why_none.empty()) return result;
  RectifiedPair pair = rectified_pair(capture, seen);
  PairDisparities disparities =
      match_pair(pair, to_nearest(config.pair, pair.geometry, config.nearest_m));
  result.findings = disparities.findings;
  if (!result.findings.why_none.empty()) return result;
  // Centres of images and turns of cameras are off along rows as much as across.
  const double calibration_px = std::hypot(config.calibration_px, result.findings.rows_off.rms_px);
  look_up({pair.geometry, disparities, calibration_px}, seen.sensors[0].reported, result.depth);
  return result;
}

FrameDepth depth_of_stereo(const Capture& capture, std::size_t frame,
                           const StereoDepthConfig& config) {
  const Frame& seen = capture.frames.at(frame);
  check_stereo_rig(capture);
  if (const std::string why = why_no_stereo_pair(capture, seen, config.most_apart_s); !why.empty())
    throw std::invalid_argument("stereo depth: frame " + std::to_string(seen.id) + ": " + why);
  StereoMeasure measured = measure_stereo(capture, frame, config);
  if (!measured.depth.depth_m.empty()) return std::move(measured.depth);
  const Camera& camera = seen.sensors[0].reported;  // nothing is found in it
  measured.depth.depth_m = Image<float>(camera.width_px, camera.height_px, kNone);
  return std::move(measured.depth);
}

}  // namespace cousin
