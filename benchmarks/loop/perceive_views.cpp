#include "benchmarks/loop/perceive_views.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <utility>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/best_exposed.h"
#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/score/order_statistics.h"
#include "perception/splats/splat_geometry.h"
#include "perception/splats/splat_render.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/measure.h"
#include "sim/imaging/image_io.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr int kEnoughViews = 3;
constexpr std::size_t kPictures = 4;

struct Looks {
  const LearnedDistance* network = nullptr;
  std::vector<double> psnr_db, exposed_psnr_db, ssim, flip, learned;
  /// @param plain  the image at the mean exposure
  void add(const FidelityPlanes& image, const FidelityPlanes& plain, const SplatView& view) {
    const FidelityPlanes& photograph = view.full.color.channel;
    const Image<std::uint8_t> counted = counted_pixels(view.full.weight);
    // A photograph that a mask leaves nothing of says nothing.
    if (!counted.empty() &&
        std::all_of(counted.begin(), counted.end(), [](std::uint8_t x) { return x == 0; }))
      return;
    const FidelityPlanes inside = where_counted(image, photograph, counted);
    const ImageFidelity scores = score_fidelity(inside, photograph, counted);
    if (network) learned.push_back(network->between(inside, photograph));
    psnr_db.push_back(scores.psnr_db);
    exposed_psnr_db.push_back(
        cousin::psnr_db(best_exposed(plain, photograph, counted), photograph, counted));
    ssim.push_back(scores.ssim);
    flip.push_back(scores.flip);
  }
};

void add_row(const std::string& metric, double value, const char* unit, std::int64_t n,
             ScoreRow row, std::vector<ScoreRow>& rows) {
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  rows.push_back(std::move(row));
}

void add_looks(const std::string& set, const Looks& looks, const ScoreRow& base,
               std::vector<ScoreRow>& rows) {
  const auto n = static_cast<std::int64_t>(looks.psnr_db.size());
  if (n == 0) return;
  add_row(set + ".psnr", mean(looks.psnr_db), "dB", n, base, rows);
  add_row(set + ".psnr_exposed", mean(looks.exposed_psnr_db), "dB", n, base, rows);
  add_row(set + ".ssim", mean(looks.ssim), "1", n, base, rows);
  add_row(set + ".flip", mean(looks.flip), "1", n, base, rows);
  if (looks.network) add_row(set + ".lpips", mean(looks.learned), "1", n, base, rows);
}

Image<Rgb8> side_by_side(const Image<Rgb8>& left, const Image<Rgb8>& right) {
  Image<Rgb8> both(left.width() + right.width(), left.height());
  for (int y = 0; y < left.height(); ++y) {
    const auto row = both.row(y);
    std::copy(left.row(y).begin(), left.row(y).end(), row.begin());
    std::copy(right.row(y).begin(), right.row(y).end(), row.begin() + left.width());
  }
  return both;
}

/// Scores the model by all placed views, and keeps pictures of some.
void look(const ViewsPipelineConfig& config, const Capture& capture, const Estimate& estimate,
          const std::vector<Image<std::uint8_t>>& masks, const ViewsFindings& findings,
          const fs::path& pictures, const LearnedDistance* learned, const ScoreRow& base,
          std::vector<ScoreRow>& rows) {
  const std::vector<SplatView> views = splat_views(capture, estimate.poses, masks);
  const bool some_held_out = is_held_out(config, 0);
  std::vector<std::size_t> shown;  // places
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (is_held_out(config, i) == some_held_out) shown.push_back(i);
  }
  const std::size_t count = std::min(shown.size(), kPictures);
  for (std::size_t i = 0; i < count; ++i) shown[i] = shown[i * shown.size() / count];
  shown.resize(count);
  Looks train{learned}, held_out{learned};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const SplatView& view = views[i];
    const ColorPlanes drawn =
        render_splats(estimate.splats, view.full.camera, view.camera_from_world).color;
    const FidelityPlanes image = as_exposed(drawn, view, findings).channel;
    const bool has_exposures = findings.exposures.status == ExposureStatus::ok;
    const FidelityPlanes plain =
        has_exposures
            ? as_exposed(drawn, view.full.camera, 0, findings.exposures.vignetting).channel
            : image;
    (is_held_out(config, i) ? held_out : train).add(image, plain, view);
    if (pictures.empty() || std::find(shown.begin(), shown.end(), i) == shown.end()) continue;
    const int id = capture.frames[static_cast<std::size_t>(view.frame)].id;
    write_png(pictures / (scene_id(id) + ".png"),
              side_by_side(rgb_of(view.full.color.channel), rgb_of(image)));
  }
  add_looks("train", train, base, rows);
  add_looks("held_out", held_out, base, rows);
}

void count_seen(const Estimate& estimate, const fs::path& file, const ScoreRow& base,
                std::vector<ScoreRow>& rows) {
  const auto n = static_cast<std::int64_t>(estimate.splats.splats.size());
  add_row("gaussians", static_cast<double>(n), "1", 1, base, rows);
  if (estimate.depths.empty()) return;  // somebody's stage gave none: who sees what is not known
  SplatDepthImages depths;
  depths.poses = estimate.poses;
  depths.depths = estimate.depths;
  for (std::size_t v = depths.poses.size(); v-- > 0;) {  // those that show something
    if (depths.poses[v].status == PoseStatus::ok && !depths.depths[v].depth_m.empty()) continue;
    depths.poses.erase(depths.poses.begin() + static_cast<std::ptrdiff_t>(v));
    depths.depths.erase(depths.depths.begin() + static_cast<std::ptrdiff_t>(v));
  }
  const std::vector<int> seen = views_that_see(estimate.splats, depths);
  const auto enough =
      std::count_if(seen.begin(), seen.end(), [](int views) { return views >= kEnoughViews; });
  if (n > 0)
    add_row("gaussians.seen_by_" + std::to_string(kEnoughViews),
            static_cast<double>(enough) / static_cast<double>(n), "1", n, base, rows);
  if (file.empty()) return;
  std::string text = "views\n";
  for (const int views : seen) text += std::to_string(views) + "\n";
  write_file(file, text);
}

/// Of each frame trained on ln of its light over the geometric mean's, and its standard deviation;
/// empty where a photograph shares too little with others. And the vignetting, in the first lines.
void write_exposures(const fs::path& file, const Capture& capture, const ViewsFindings& findings) {
  if (findings.exposures.status != ExposureStatus::ok) return;
  const ViewExposures& exposures = findings.exposures;
  std::ostringstream text;
  text.precision(6);
  text
      << "# ln of light in the image at r of its half diagonal: vignetting_a r^2 + vignetting_b r^4"
      << "\n# vignetting_a = " << exposures.vignetting.a
      << "\n# vignetting_b = " << exposures.vignetting.b << "\nframe,log_gain,sigma\n";
  for (std::size_t v = 0; v < findings.exposed_frames.size(); ++v) {
    text << capture.frames[static_cast<std::size_t>(findings.exposed_frames[v])].id << ',';
    if (std::isfinite(exposures.log_gain[v]))
      text << exposures.log_gain[v] << ',' << exposures.sigma[v];
    else
      text << ',';
    text << '\n';
  }
  write_file(file, text.str());
}

void warn_of_exposures(const ViewsFindings& findings, const Warn& warn) {
  const ViewExposures& exposures = findings.exposures;
  const std::size_t views = exposures.log_gain.size();
  const auto unknown =
      static_cast<std::size_t>(std::count_if(exposures.log_gain.begin(), exposures.log_gain.end(),
                                             [](double gain) { return !std::isfinite(gain); }));
  if (views == 0 || (exposures.status == ExposureStatus::ok && unknown == 0)) return;
  warn("exposures of " + std::to_string(unknown) + " of " + std::to_string(views) +
       " photographs could not be measured: too little surface was found that they share with " +
       "others" +
       (exposures.status == ExposureStatus::ok ? "" : "; all are trained on as they are"));
}

/// Those of the configuration's folder, one for each frame; none where it names none.
/// @throws std::runtime_error naming the file if it is no mask of its photograph, or the folder if
/// it holds none of any frame
std::vector<Image<std::uint8_t>> read_masks(const std::string& folder, const Capture& capture) {
  std::vector<Image<std::uint8_t>> masks;
  if (folder.empty()) return masks;
  bool has_one = false;
  for (const Frame& frame : capture.frames) {
    Image<std::uint8_t>& mask = masks.emplace_back();
    const fs::path file = fs::path(folder) / (scene_id(frame.id) + ".png");
    if (frame.sensors.empty() || frame.sensors.front().color.empty() || !fs::exists(file)) continue;
    const Image<Rgb8>& color = frame.sensors.front().color;
    try {
      mask = reduced_mask(read_png8(file), color.width(), color.height());
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(file.string() + ": " + error.what());
    }
    has_one = true;
  }
  if (!has_one)
    throw std::runtime_error(folder + ": holds no mask of any frame (\"" +
                             scene_id(capture.frames.empty() ? 0 : capture.frames.front().id) +
                             ".png\")");
  return masks;
}

/// What an earlier run left beside its seams.
void remove_earlier(const fs::path& estimate_dir) {
  for (const char* file : {"scores.csv", "splats_seen.csv", "exposures.csv"})
    remove_own(estimate_dir / file);
  const fs::path pictures = estimate_dir / "pictures";
  if (fs::symlink_status(pictures).type() != fs::file_type::directory) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(pictures)) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") == 6 && name.ends_with(".png") && name.size() == 10)
      files.push_back(entry.path());
  }
  for (const fs::path& picture : files) remove_own(picture);  // others are somebody's own
}

void warn_of_lengths(const ViewsFindings& findings, bool are_somebodys, bool is_metric,
                     const Warn& warn) {
  if (warn && !findings.sfm_doubts.empty()) warn("structure from motion: " + findings.sfm_doubts);
  if (warn && !is_metric)
    warn(are_somebodys ? "poses are somebody's: lengths are in their unit"
                       : "poses are of COLMAP and no board gave them a scale: lengths are in its "
                         "model's own unit");
}

ScoreRow views_row(const std::string& name, const ViewsPipelineConfig& config, std::uint64_t seed) {
  ScoreRow base;
  base.suite = "views";
  base.scene = name;
  base.case_name = "photographs";
  base.method = to_string(config.method);
  base.seed = seed;
  return base;
}

void add_mesh_rows(const Estimate& estimate, bool is_metric, const ScoreRow& base,
                   std::vector<ScoreRow>& rows) {
  for (const Surface& surface : estimate.surfaces) {
    if (surface.status == SurfaceStatus::ok)
      add_row("mesh.area", mass_properties(surface.mesh).area_m2, is_metric ? "m2" : "unit2", 1,
              base, rows);
  }
}

}  // namespace

ViewsRun perceive_views(const Capture& capture, const ViewsPipelineConfig& config,
                        std::uint64_t seed, const std::vector<StageSource>& sources,
                        int scene_index, const std::string& name, const fs::path& estimate_dir,
                        const Progress& progress, const Warn& warn,
                        const LearnedDistance* learned) {
  const Capture small = reduced(capture, config.largest_side_px);
  const std::uint64_t own_seed = Rng(seed).fork(static_cast<std::uint64_t>(scene_index))();
  const auto file = [&](const char* of) {
    return estimate_dir.empty() ? fs::path() : estimate_dir / of;
  };
  const std::vector<Image<std::uint8_t>> masks = read_masks(config.masks, small);
  if (!estimate_dir.empty()) remove_earlier(estimate_dir);
  const auto findings = std::make_shared<ViewsFindings>();
  ViewsRun run;
  run.estimate = perceive_with(
      [&](const SplatWatch& watch) {
        SplatWatch own = watch;
        if (warn) own.left_early = warn;
        Stages stages =
            with_stage_sources(views_stages(config, capture, own_seed, own, findings, masks),
                               sources, views_stage_order(), scene_index, warn);
        stages.poses = [poses = std::move(stages.poses), &capture, side = config.largest_side_px](
                           const Capture& photographs, const Estimate& so_far) {
          return reduced(poses(photographs, so_far), capture, side);  // somebody's too
        };
        return stages;
      },
      [&](const Stages& stages, const StageObserver& observe) {
        return run_stages(small, stages, views_stage_order(), observe);
      },
      views_stage_order(), sources, scene_index, estimate_dir, progress);
  if (warn) warn_of_exposures(*findings, warn);
  const bool are_somebodys =
      std::any_of(sources.begin(), sources.end(),
                  [](const StageSource& source) { return source.stage == "poses"; });
  // What unit somebody's poses have is not known.
  const bool is_metric = findings->is_metric && !are_somebodys;
  warn_of_lengths(*findings, are_somebodys, is_metric, warn);
  const Estimate& estimate = run.estimate;
  const ScoreRow base = views_row(name, config, seed);
  if (estimate.splats.splats.empty() && !estimate.splats.why_none.empty())
    run.rows.push_back(untrained_row(base, estimate.splats));
  if (!estimate.splats.splats.empty()) {
    look(config, small, estimate, masks, *findings, file("pictures"), learned, base, run.rows);
    count_seen(estimate, file("splats_seen.csv"), base, run.rows);
    if (!estimate_dir.empty()) write_exposures(file("exposures.csv"), small, *findings);
  }
  add_row("cloud.points", static_cast<double>(estimate.cloud.size()), "1", 1, base, run.rows);
  add_mesh_rows(estimate, is_metric, base, run.rows);
  score_timings(estimate, base, run.rows);
  if (!estimate_dir.empty()) write_file(file("scores.csv"), to_csv(run.rows));
  return run;
}

}  // namespace cousin
