#include "benchmarks/suites/light/light_suite.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/suites/light/closed_forms.h"
#include "benchmarks/suites/light/image_error.h"
#include "benchmarks/suites/light/leafy_runs.h"
#include "benchmarks/suites/light/light_page.h"
#include "sim/render/truth_pass.h"
#include "sim/types/pi.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

ScoreRow row_of(const std::string& scene, const std::string& case_name, const std::string& method,
                const std::string& metric, double value, const std::string& unit, std::int64_t n,
                std::uint64_t seed) {
  ScoreRow row;
  row.suite = "light";
  row.scene = scene;
  row.case_name = case_name;
  row.method = method;
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  row.seed = seed;
  row.peak_rss_mb = peak_rss_mb();
  row.peak_above_start_mb = row.peak_rss_mb - start_rss_mb();
  return row;
}

/// An error, the seconds of one image, and whether it is adaptive.
struct Point {
  double error = 0;
  double seconds = 0;
  bool is_adaptive = false;
  double cost() const { return error * error * seconds; }  ///< error falls as 1 / sqrt(seconds)
};

/// The least cost of a renderer's settings: adaptive thresholds are tried, the best one counts.
double least_cost(const std::vector<Point>& points, bool is_adaptive) {
  double least = std::numeric_limits<double>::infinity();
  for (const Point& p : points) {
    if (p.is_adaptive == is_adaptive) least = std::min(least, p.cost());
  }
  return least;
}

/// Rows of one renderer's runs: the error against its converged image if there is one, the error
/// from pairs, the seconds.
std::vector<Point> add_runs(ScoreFile& file, const std::string& method,
                            const std::vector<LeafyRun>& runs,
                            const std::optional<Reference>& reference, std::uint64_t seed) {
  std::vector<Point> points;
  for (const LeafyRun& run : runs) {
    const auto pixels = static_cast<std::int64_t>(run.images[0].size());
    const Rng rng = Rng(seed).fork("error").fork(method).fork(run.setting);
    const auto add = [&](const char* metric, const WithInterval& error) {
      ScoreRow row = row_of("leafy", run.setting, method, metric, error.value, "1", pixels, seed);
      row.ci_low = error.low;
      row.ci_high = error.high;
      row.wall_s = run.seconds;
      file.scores.push_back(row);
    };
    const WithInterval pair = pair_error(run.images[0], run.images[1], rng);
    WithInterval error = pair;
    if (reference) {
      error = reference_error(run.images[0], *reference, rng);
      add("relative_error", error);
    }
    add("relative_error.pair", pair);
    file.scores.push_back(
        row_of("leafy", run.setting, method, "seconds.image", run.seconds, "s", 2, seed));
    points.push_back({error.value, run.seconds, run.is_adaptive});
  }
  return points;
}

/// The last run of a kind: the one of most samples.
const LeafyRun& last_of(const std::vector<LeafyRun>& runs, bool is_adaptive) {
  const auto found = std::find_if(runs.rbegin(), runs.rend(),
                                  [&](const LeafyRun& r) { return r.is_adaptive == is_adaptive; });
  return *found;
}

/// Share of the pixels where both see the same instance that agree in depth and in normal.
void add_agreement(ScoreFile& file, const TruthImages& truth, const CyclesImage& theirs,
                   std::uint64_t seed) {
  std::int64_t same = 0, both = 0, depth = 0, normal = 0;
  const double least_cosine = std::cos(0.5 * kPi / 180);
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    const int id = truth.instance.data()[i];
    if (id != theirs.instance.data()[i]) continue;
    ++same;
    if (id < 0) continue;
    ++both;
    const double ratio = static_cast<double>(truth.depth_m.data()[i]) /
                         static_cast<double>(theirs.depth_m.data()[i]);
    depth += std::abs(ratio - 1) <= 1e-4;
    const Eigen::Vector3d n = theirs.normal.data()[i].cast<double>();
    normal +=
        n.norm() > 0 && truth.normal.data()[i].cast<double>().dot(n.normalized()) >= least_cosine;
  }
  const auto pixels = static_cast<std::int64_t>(truth.instance.size());
  const auto share = [](std::int64_t a, std::int64_t b) {
    return static_cast<double>(a) / static_cast<double>(std::max<std::int64_t>(b, 1));
  };
  const auto add = [&](const char* metric, double value, std::int64_t n) {
    file.scores.push_back(
        limited(row_of("leafy", "geometry at pixel centres", "ours", metric, value, "1", n, seed),
                at_least(0.999)));
  };
  add("agreement.instance", share(same, pixels), pixels);
  add("agreement.depth", share(depth, both), both);
  add("agreement.normal", share(normal, both), both);
}

constexpr double kDeviations99 = 2.576;  ///< half of the 99 % interval

/// What an estimate is off its closed form, with a 95 % interval; it passes within the 99 % one.
void add_closed_forms(ScoreFile& file, const LightConfig& config) {
  for (const ClosedForm& form : closed_forms(config.closed_form_samples, config.seed)) {
    const double deviation = form.estimate / form.truth - 1;
    const double sigma = form.standard_error / form.truth;
    ScoreRow row = limited(row_of("closed forms", form.name, "ours", "deviation", deviation, "1",
                                  form.samples, config.seed),
                           about(0, kDeviations99 * sigma + 2e-5));
    row.ci_low = deviation - 1.96 * sigma;
    row.ci_high = deviation + 1.96 * sigma;
    file.scores.push_back(row);
    file.scores.push_back(row_of("closed forms", form.name, "ours", "deviation.half_width_99",
                                 kDeviations99 * sigma, "1", form.samples, config.seed));
  }
}

void add_not_built(ScoreFile& file, std::uint64_t seed) {
  for (const char* metric : {"agreement.instance", "agreement.depth", "agreement.normal",
                             "mean_radiance_ratio", "time_ratio.plain", "time_ratio.adaptive"}) {
    ScoreRow row = row_of("leafy", "beside Cycles", "ours", metric, ScoreRow::kNone, "1", 0, seed);
    row.status = ScoreStatus::not_built;
    file.scores.push_back(row);
  }
}

void add_time_ratios(ScoreFile& file, const std::vector<Point>& ours,
                     const std::vector<Point>& theirs, std::uint64_t seed) {
  for (const bool is_adaptive : {false, true}) {
    const double ratio = least_cost(theirs, is_adaptive) / least_cost(ours, is_adaptive);
    file.scores.push_back(limited(row_of("leafy", "Cycles' time over ours to one error", "ours",
                                         is_adaptive ? "time_ratio.adaptive" : "time_ratio.plain",
                                         ratio, "1", static_cast<std::int64_t>(ours.size()), seed),
                                  at_least(is_adaptive ? 2 : 1.5)));
  }
}

}  // namespace

Fields fields(LightConfig& c) {
  return {
      {"width_px", &c.width_px, "of the leafy scene's image", 8, 8192},
      {"height_px", &c.height_px, "of the leafy scene's image", 8, 8192},
      {"samples", &c.samples, "a pixel, of both renderers", 1, 1 << 20},
      {"adaptive_samples", &c.adaptive_samples, "a pixel on average, of ours", 16, 1 << 20},
      {"thresholds", &c.thresholds, "of Cycles' adaptive sampling", 1e-5, 1},
      {"most_samples", &c.most_samples, "a pixel, of Cycles' adaptive sampling", 1, 1 << 20},
      {"reference_passes", &c.reference_passes, "of each converged image; below 2: none", 0, 1000},
      {"reference_samples", &c.reference_samples, "a pixel of a pass", 1, 1 << 20},
      {"closed_form_samples", &c.closed_form_samples, "of each closed form", 8192, 1 << 30},
  };
}

LightConfig quick(LightConfig config) {
  config.samples = {4, 16};
  config.adaptive_samples = {32};
  config.thresholds = {0.05};
  config.reference_passes = 0;
  config.closed_form_samples = 1 << 17;
  return config;
}

LightResult light_suite(const LightConfig& config, const Progress& progress) {
  const std::uint64_t seed = config.seed;
  const int steps = 3 + static_cast<int>(config.samples.size() + config.adaptive_samples.size()) +
                    2 * config.reference_passes;
  int done = 0;
  const Say say = [&](const std::string& what) {
    if (progress) progress(what, done++, steps);
  };
  LightResult result;
  ScoreFile& file = result.file;
  say("closed forms");
  add_closed_forms(file, config);

  const LeafyScene leafy(config);
  const std::vector<LeafyRun> ours = our_runs(leafy, config, say);
  const std::optional<Reference> our_converged = our_reference(leafy, config, say);
  const std::vector<Point> our_points = add_runs(file, "ours", ours, our_converged, seed);
  const Image<Rgbf>& our_best =
      our_converged ? our_converged->mean : last_of(ours, false).images[0];
  // Samples that follow the error may bias an image; the means tell.
  const auto pixels = static_cast<std::int64_t>(our_best.size());
  const auto add_ratio = [&](const char* name, double ratio) {
    file.scores.push_back(
        row_of("leafy", name, "ours", "mean_radiance_ratio", ratio, "1", pixels, seed));
  };
  add_ratio("adaptive over plain",
            mean_luminance(last_of(ours, true).images[0]) / mean_luminance(our_best));
  if (!has_cycles()) {
    add_not_built(file, seed);
    return result;
  }

  say("leafy scene, Cycles");
  const CyclesRuns cycles = cycles_runs(leafy, config);
  const std::optional<Reference> their_converged =
      cycles_reference(leafy, config, cycles.one_sample, say);
  say("comparison");
  const std::vector<Point> their_points =
      add_runs(file, "cycles", cycles.runs, their_converged, seed);
  const TruthImages truth = render_truth(leafy.rays, leafy.scene, leafy.view,
                                         {.depth = true, .normal = true, .instance = true});
  add_agreement(file, truth, cycles.geometry, seed);
  const Image<Rgbf>& their_best =
      their_converged ? their_converged->mean : last_of(cycles.runs, false).images[0];
  add_ratio("beside Cycles", mean_luminance(our_best) / mean_luminance(their_best));
  add_time_ratios(file, our_points, their_points, seed);
  result.pictures.name = "leafy";
  add_light_pictures(result.pictures, our_best, their_best);
  add_depth_picture(result.pictures, truth.depth_m, cycles.geometry.depth_m, truth.instance,
                    cycles.geometry.instance);
  return result;
}

}  // namespace cousin
