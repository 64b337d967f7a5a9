#include "benchmarks/renderers/renderers_suite.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "benchmarks/renderers/closed_forms.h"
#include "benchmarks/renderers/leafy_scene.h"
#include "sim/render/cycles/cycles.h"
#include "sim/render/path_tracer.h"
#include "sim/render/truth_pass.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr double kPi = std::numbers::pi;

ScoreRow row_of(const std::string& scene, const std::string& case_name, const std::string& method,
                const std::string& metric, double value, const std::string& unit, std::int64_t n,
                std::uint64_t seed) {
  ScoreRow row;
  row.suite = "renderers";
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

ScoreRow limited(ScoreRow row, bool passes) {
  row.status = passes ? ScoreStatus::pass : ScoreStatus::fail;
  return row;
}

double luminance(const Rgbf& c) {
  return 0.2126 * static_cast<double>(c.r) + 0.7152 * static_cast<double>(c.g) +
         0.0722 * static_cast<double>(c.b);
}

double mean_luminance(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += luminance(c);
  return sum / static_cast<double>(std::max<std::size_t>(image.size(), 1));
}

/// Relative error of one image from two with independent draws: the root of the mean over pixels of
/// (half the squared difference) / (mean of both + a tenth of the image's mean)^2. For an unbiased
/// renderer that is the error against its own converged image, without that image's own noise.
double relative_error(const Image<Rgbf>& a, const Image<Rgbf>& b) {
  const double floor = 0.1 * mean_luminance(a);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = luminance(a.data()[i]), y = luminance(b.data()[i]);
    const double scale = 0.5 * (x + y) + floor;
    if (scale > 0) sum += 0.5 * (x - y) * (x - y) / (scale * scale);
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// One setting of one renderer: its error and the seconds of one image.
struct Point {
  std::string setting;
  double error = 0;
  double seconds = 0;
  double cost() const { return error * error * seconds; }  ///< error falls as 1 / sqrt(seconds)
};

void add_point(ScoreFile& file, const std::string& method, const Point& p, std::uint64_t seed) {
  ScoreRow row =
      row_of("leafy", p.setting, method, "relative_error", p.error, "1", 640 * 480, seed);
  row.wall_s = p.seconds;
  file.scores.push_back(row);
  file.scores.push_back(
      row_of("leafy", p.setting, method, "seconds.image", p.seconds, "s", 2, seed));
}

/// The least cost of a renderer's settings: adaptive thresholds are tried, the best one counts.
const Point& best(const std::vector<Point>& points) {
  return *std::min_element(points.begin(), points.end(),
                           [](const Point& a, const Point& b) { return a.cost() < b.cost(); });
}

struct LeafyScene {
  Scene scene = leafy_scene();
  TrueView view = leafy_view();
  RayScene rays{scene};
  PathTracer tracer{rays, scene};
};

Point our_point(const LeafyScene& leafy, const PathConfig& config, std::uint64_t seed,
                Image<Rgbf>* image) {
  Image<Rgbf> images[2];
  const StageClock clock("images");
  for (std::uint64_t i = 0; i < 2; ++i)
    images[i] = leafy.tracer.render(leafy.view, config, Rng(seed).fork(i)).radiance;
  const double seconds = clock.finish().wall_s / 2;
  if (image) *image = images[0];
  return {std::string(config.adaptive ? "adaptive, " : "") + std::to_string(config.pixel_samples) +
              " samples",
          relative_error(images[0], images[1]), seconds};
}

/// Share of the pixels where both see the same instance that agree in depth and in normal.
void add_agreement(ScoreFile& file, const LeafyScene& leafy, const CyclesImage& theirs,
                   std::uint64_t seed) {
  const TruthImages truth = render_truth(leafy.rays, leafy.scene, leafy.view,
                                         {.depth = true, .normal = true, .instance = true});
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
                value >= 0.999));
  };
  add("agreement.instance", share(same, pixels), pixels);
  add("agreement.depth", share(depth, both), both);
  add("agreement.normal", share(normal, both), both);
}

void add_closed_forms(ScoreFile& file, std::uint64_t seed, bool quick) {
  for (const ClosedForm& form : closed_forms(quick ? 1 << 17 : 1 << 20, seed)) {
    ScoreRow row = limited(row_of("closed forms", form.name, "ours", "estimate_over_truth",
                                  form.estimate / form.truth, "1", form.samples, seed),
                           form.agrees);
    row.ci_low = (form.estimate - 1.96 * form.standard_error) / form.truth;
    row.ci_high = (form.estimate + 1.96 * form.standard_error) / form.truth;
    file.scores.push_back(row);
  }
}

}  // namespace

ScoreFile renderers_suite(std::uint64_t seed, const std::filesystem::path& folder, int threads,
                          bool quick, const Progress& progress) {
  const auto say = [&](const std::string& what, int done) {
    if (progress) progress(what, done, 4);
  };
  ScoreFile file;
  say("closed forms", 0);
  add_closed_forms(file, seed, quick);

  say("leafy scene, ours", 1);
  const LeafyScene leafy;
  const std::vector<int> counts = quick ? std::vector<int>{4, 16} : std::vector<int>{4, 16, 64};
  std::vector<Point> plain, adaptive;
  Image<Rgbf> ours, ours_adaptive;
  for (const int samples : counts) {
    plain.push_back(our_point(leafy, {.pixel_samples = samples}, seed, &ours));
    add_point(file, "ours", plain.back(), seed);
  }
  for (const int samples : quick ? std::vector<int>{32} : std::vector<int>{32, 64, 128}) {
    adaptive.push_back(
        our_point(leafy, {.pixel_samples = samples, .adaptive = true}, seed, &ours_adaptive));
    add_point(file, "ours", adaptive.back(), seed);
  }
  // Samples that follow the error may bias an image; the means tell.
  file.scores.push_back(row_of("leafy", "adaptive over plain", "ours", "mean_radiance_ratio",
                               mean_luminance(ours_adaptive) / mean_luminance(ours), "1", 640 * 480,
                               seed));

  say("leafy scene, Cycles", 2);
  if (!has_cycles()) {
    for (const char* metric : {"agreement.instance", "agreement.depth", "agreement.normal",
                               "mean_radiance_ratio", "time_ratio.plain", "time_ratio.adaptive"}) {
      ScoreRow row =
          row_of("leafy", "beside Cycles", "ours", metric, ScoreRow::kNone, "1", 0, seed);
      row.status = ScoreStatus::not_built;
      file.scores.push_back(row);
    }
    return file;
  }
  // The first run builds Cycles' tree; the second is geometry alone.
  std::vector<CyclesRun> runs = {{.samples = 1}, {.samples = 1, .filter_width_px = 0.01}};
  struct Setting {
    std::string name;
    CyclesRun run;
  };
  std::vector<Setting> settings;
  for (const int samples : counts)
    settings.push_back({std::to_string(samples) + " samples", {.samples = samples}});
  for (const double threshold :
       quick ? std::vector<double>{0.05} : std::vector<double>{0.05, 0.02, 0.01}) {
    settings.push_back({"adaptive, threshold " + std::to_string(threshold).substr(0, 4),
                        {.samples = 1024, .noise_threshold = threshold}});
  }
  for (const Setting& s : settings) {
    for (int i = 1; i <= 2; ++i) {
      runs.push_back(s.run);
      runs.back().seed = static_cast<int>(seed % 1000000) * 2 + i;
    }
  }
  CyclesConfig config;
  config.folder = folder;
  config.threads = threads;
  const std::vector<CyclesImage> theirs = render_with_cycles(leafy.scene, leafy.view, config, runs);

  say("comparison", 3);
  add_agreement(file, leafy, theirs[1], seed);
  std::vector<Point> their_plain, their_adaptive;
  const Image<Rgbf>* their_best = nullptr;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const CyclesImage &a = theirs[2 + 2 * i], &b = theirs[3 + 2 * i];
    const Point point{settings[i].name, relative_error(a.radiance, b.radiance),
                      0.5 * (a.seconds + b.seconds)};
    add_point(file, "cycles", point, seed);
    const bool is_plain = settings[i].run.noise_threshold == 0;
    (is_plain ? their_plain : their_adaptive).push_back(point);
    if (is_plain) their_best = &a.radiance;
  }
  file.scores.push_back(row_of("leafy", "beside Cycles", "ours", "mean_radiance_ratio",
                               mean_luminance(ours) / mean_luminance(*their_best), "1", 640 * 480,
                               seed));
  const double plain_ratio = best(their_plain).cost() / best(plain).cost();
  const double adaptive_ratio = best(their_adaptive).cost() / best(adaptive).cost();
  file.scores.push_back(
      limited(row_of("leafy", "Cycles' time over ours to one error", "ours", "time_ratio.plain",
                     plain_ratio, "1", static_cast<std::int64_t>(counts.size()), seed),
              plain_ratio >= 1.5));
  file.scores.push_back(
      limited(row_of("leafy", "Cycles' time over ours to one error", "ours", "time_ratio.adaptive",
                     adaptive_ratio, "1", static_cast<std::int64_t>(adaptive.size()), seed),
              adaptive_ratio >= 2));
  return file;
}

}  // namespace cousin
