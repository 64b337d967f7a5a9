#include "benchmarks/suites/calibration/choice_rows.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "benchmarks/score/distributions.h"
#include "benchmarks/score/rank_correlation.h"
#include "benchmarks/suites/calibration/calibration_causes.h"
#include "benchmarks/suites/calibration/calibration_row.h"
#include "benchmarks/suites/calibration/reprojection.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

/// One calibration with all that one might choose by.
struct Candidate {
  ReprojectionErrors reprojection;
  double predicted_px = 0;  ///< deviation of the projection, RMS over the image
  double error_px = 0;      ///< true, the same measure
};
using MaybeCandidate = std::optional<Candidate>;

double log_uniform(Rng& rng, double low, double high) {
  return std::exp(uniform(rng, std::log(low), std::log(high)));
}

/// How one owner goes about it: tilts of 3 to 45 degrees, 8 to 40 photographs, near or far, paper
/// bent by some tenths of a millimetre, corners found to .03 to .3 px.
CornerViewsConfig draw_owner(Rng rng) {
  CornerViewsConfig views = strawberry_views();
  views.tilt_rad = log_uniform(rng, 3, 45) * std::numbers::pi / 180;
  views.frames = 8 + static_cast<int>(33 * uniform(rng));
  const double near = log_uniform(rng, 0.7, 1.6);
  views.near_m *= near;
  views.far_m *= near;
  views.deformation_m.y() = 5e-4 * normal(rng);
  views.noise_px = log_uniform(rng, 0.03, 0.3);
  return views;
}

MaybeCandidate calibrated(const CornerViews& views, bool is_lean) {
  CalibrationConfig solve;
  solve.tolerance = 1e-10;
  if (is_lean) solve.fixed = {"k3", "p1", "p2"};
  const CalibrationResult found = calibrate(views.input, solve);
  if (found.cameras.empty() || found.covariance.size() == 0) return std::nullopt;
  Candidate candidate;
  candidate.reprojection = reprojection_errors(found);
  candidate.predicted_px = rms_deviation_px(projection_uncertainty(found, 0));
  candidate.error_px = projection_difference(views.cameras[0], found.cameras[0]).rms_px;
  if (!std::isfinite(candidate.predicted_px) || !std::isfinite(candidate.error_px))
    return std::nullopt;
  return candidate;
}

/// The camera's owner takes photographs once or twice, and has two programs: one with five
/// coefficients, and one with k1 and k2 alone, as MATLAB's default, whose corner finder is another.
struct Owner {
  MaybeCandidate full, lean_same_corners, lean_own_corners, full_other_photographs;
};

Owner run_owner(const Rng& rng) {
  const Camera truth = strawberry_camera();
  CornerViewsConfig config = draw_owner(rng.fork("owner"));
  const CornerViews views = make_corner_views({truth}, {Pose{}}, config, rng.fork("views"));
  Owner owner;
  owner.full = calibrated(views, false);
  owner.lean_same_corners = calibrated(views, true);
  // The same photographs by another finder: places as before, noise of another size.
  Rng finder = rng.fork("finder");
  config.noise_px *= log_uniform(finder, 0.5, 2);
  CornerViews own = views;
  CornerViewsConfig clean = config;
  clean.noise_px = 0;
  own.input = make_corner_views({truth}, {Pose{}}, clean, rng.fork("views")).input;
  for (TargetView& view : own.input.views) {
    for (TargetObservation& seen : view.points)
      seen.pixel_px += config.noise_px * Eigen::Vector2d(normal(finder), normal(finder));
  }
  owner.lean_own_corners = calibrated(own, true);
  const CornerViewsConfig again = draw_owner(rng.fork("another day"));
  owner.full_other_photographs =
      calibrated(make_corner_views({truth}, {Pose{}}, again, rng.fork("other views")), false);
  return owner;
}

using Criterion = double (*)(const Candidate&);
double by_rms(const Candidate& c) { return c.reprojection.rms_point_px; }
double by_tutorial(const Candidate& c) { return c.reprojection.tutorial_px; }
double by_distance(const Candidate& c) { return c.reprojection.mean_distance_px; }
double by_prediction(const Candidate& c) { return c.predicted_px; }

/// One way to be offered two calibrations, and what one goes by.
struct Choice {
  const char* name;
  const char* method;
  MaybeCandidate Owner::*second;
  Criterion of_first, of_second;
};

void correlation_rows(std::vector<ScoreRow>& rows, const std::vector<Owner>& owners,
                      std::uint64_t seed) {
  struct Case {
    const char* name;
    std::vector<Candidate> of;
  };
  Case full{"five coefficients", {}}, lean{"k1 and k2 alone", {}};
  for (const Owner& owner : owners) {
    if (owner.full) full.of.push_back(*owner.full);
    if (owner.lean_own_corners) lean.of.push_back(*owner.lean_own_corners);
  }
  for (const Case& c : {full, lean}) {
    std::vector<double> errors;
    for (const Candidate& candidate : c.of) errors.push_back(candidate.error_px);
    for (const auto& [method, criterion] :
         {std::pair<const char*, Criterion>{"reprojection error, RMS a point", by_rms},
          {"predicted deviation", by_prediction}}) {
      std::vector<double> values;
      for (const Candidate& candidate : c.of) values.push_back(criterion(candidate));
      const ScoreRow row = calibration_row("choosing a calibration", c.name, method, seed);
      rows.push_back(with_interval(
          row, "rank correlation with the true projection error", "1",
          rank_correlation(values, errors, Rng(seed).fork("ranks").fork(c.name).fork(method)),
          static_cast<std::int64_t>(values.size())));
    }
  }
}

}  // namespace

std::vector<ScoreRow> choice_scores(const ScoreRow& row, std::span<const CalibrationPair> pairs) {
  int right = 0;
  double sum = 0, worst = 1;
  for (const CalibrationPair& pair : pairs) {
    const int taken = pair.criterion[1] < pair.criterion[0] ? 1 : 0;
    const double over = pair.error[taken] / std::min(pair.error[0], pair.error[1]);
    right += pair.error[taken] <= pair.error[1 - taken];
    sum += over;
    worst = std::max(worst, over);
  }
  const auto n = static_cast<std::int64_t>(pairs.size());
  const BinomialInterval share = binomial_interval(right, n);
  std::vector<ScoreRow> rows;
  rows.push_back(with_interval(row, "choices that take the better one, share", "1",
                               {share.share, share.low, share.high}, n));
  rows.push_back(with_interval(row, "true error of the one taken over the better one's, mean", "1",
                               {sum / static_cast<double>(n)}, n));
  rows.push_back(with_interval(row, "true error of the one taken over the better one's, largest",
                               "1", {worst}, n));
  return rows;
}

std::vector<ScoreRow> choice_rows(std::uint64_t seed, bool quick) {
  std::vector<Owner> owners(quick ? 40 : 400);
  const Rng rng = Rng(seed).fork("choice");
  tbb::parallel_for(std::size_t{0}, owners.size(),
                    [&](std::size_t i) { owners[i] = run_owner(rng.fork(i)); });
  const char* const programs = "two programs, the same photographs";
  const char* const days = "one program, two sets of photographs";
  const std::vector<Choice> choices = {
      {programs, "as the paper: tutorial's error against the mean distance",
       &Owner::lean_own_corners, by_tutorial, by_distance},
      {programs, "reprojection error, RMS a point", &Owner::lean_own_corners, by_rms, by_rms},
      {programs, "predicted deviation", &Owner::lean_own_corners, by_prediction, by_prediction},
      {"two models, the same corners", "reprojection error, RMS a point", &Owner::lean_same_corners,
       by_rms, by_rms},
      {days, "reprojection error, RMS a point", &Owner::full_other_photographs, by_rms, by_rms},
      {days, "predicted deviation", &Owner::full_other_photographs, by_prediction, by_prediction}};
  std::vector<ScoreRow> rows;
  for (const Choice& choice : choices) {
    std::vector<CalibrationPair> pairs;
    for (const Owner& owner : owners) {
      const MaybeCandidate& a = owner.full;
      const MaybeCandidate& b = owner.*(choice.second);
      if (!a || !b) continue;
      pairs.push_back({{choice.of_first(*a), choice.of_second(*b)}, {a->error_px, b->error_px}});
    }
    const ScoreRow row =
        calibration_row("choosing a calibration", choice.name, choice.method, seed);
    const std::vector<ScoreRow> scores = choice_scores(row, pairs);
    rows.insert(rows.end(), scores.begin(), scores.end());
  }
  correlation_rows(rows, owners, seed);
  return rows;
}

}  // namespace cousin
