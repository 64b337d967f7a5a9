#include "benchmarks/suites/light/leafy_runs.h"

#include <cstdio>

#include "benchmarks/suites/light/reference_store.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

TrueView resized_view(const LightConfig& config) {
  TrueView view = leafy_view();
  view.camera = resized(view.camera, config.width_px, config.height_px);
  return view;
}

CyclesConfig cycles_config(const LightConfig& config) {
  CyclesConfig cycles;
  cycles.folder = config.folder / "cycles";
  cycles.threads = config.threads;
  return cycles;
}

std::string pass_text(const char* whose, int pass, int passes) {
  return std::string(whose) + " converged image, pass " + std::to_string(pass + 1) + " of " +
         std::to_string(passes);
}

}  // namespace

LeafyScene::LeafyScene(const LightConfig& config)
    : scene(leafy_scene()), view(resized_view(config)), rays(scene), tracer(rays, scene) {}

std::vector<LeafyRun> our_runs(const LeafyScene& leafy, const LightConfig& config, const Say& say) {
  std::vector<LeafyRun> runs;
  const auto run = [&](double samples, bool is_adaptive) {
    LeafyRun r;
    r.is_adaptive = is_adaptive;
    r.setting = std::string(is_adaptive ? "adaptive, " : "") +
                std::to_string(static_cast<int>(samples)) + " samples";
    say("leafy scene, ours, " + r.setting);
    const PathConfig path{.pixel_samples = static_cast<int>(samples), .adaptive = is_adaptive};
    const StageClock clock("images");
    for (std::uint64_t i = 0; i < 2; ++i)
      r.images[i] = leafy.tracer.render(leafy.view, path, Rng(config.seed).fork(i)).radiance;
    r.seconds = clock.finish().wall_s / 2;
    runs.push_back(std::move(r));
  };
  for (const double samples : config.samples) run(samples, false);
  for (const double samples : config.adaptive_samples) run(samples, true);
  return runs;
}

CyclesRuns cycles_runs(const LeafyScene& leafy, const LightConfig& config) {
  // The first run builds Cycles' tree; the second is geometry alone.
  std::vector<CyclesRun> orders = {{.samples = 1}, {.samples = 1, .filter_width_px = 0.01}};
  CyclesRuns result;
  const auto order = [&](const std::string& setting, CyclesRun run) {
    LeafyRun r;
    r.setting = setting;
    r.is_adaptive = run.noise_threshold > 0;
    result.runs.push_back(std::move(r));
    for (int i = 1; i <= 2; ++i) {
      run.seed = static_cast<int>(config.seed % 1000000) * 2 + i;
      orders.push_back(run);
    }
  };
  for (const double samples : config.samples) {
    const int n = static_cast<int>(samples);
    order(std::to_string(n) + " samples", {.samples = n});
  }
  for (const double threshold : config.thresholds) {
    char text[48];
    std::snprintf(text, sizeof text, "adaptive, threshold %.3g", threshold);
    order(text, {.samples = config.most_samples, .noise_threshold = threshold});
  }
  std::vector<CyclesImage> images =
      render_with_cycles(leafy.scene, leafy.view, cycles_config(config), orders);
  result.one_sample = std::move(images[0].radiance);
  result.geometry = std::move(images[1]);
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    LeafyRun& r = result.runs[i];
    CyclesImage &a = images[2 + 2 * i], &b = images[3 + 2 * i];
    r.seconds = 0.5 * (a.seconds + b.seconds);
    r.images[0] = std::move(a.radiance);
    r.images[1] = std::move(b.radiance);
  }
  return result;
}

std::optional<Reference> our_reference(const LeafyScene& leafy, const LightConfig& config,
                                       const Say& say) {
  if (config.reference_passes < 2) return std::nullopt;
  const auto image = [&](int samples, Rng rng) {
    return leafy.tracer.render(leafy.view, {.pixel_samples = samples}, rng).radiance;
  };
  // Draws of its own: the images that are measured go by the seed.
  const Rng rng = Rng(0).fork("reference");
  const std::string key =
      image_hash(image(1, rng)) + " " + std::to_string(config.reference_samples);
  return merge_passes(reference_passes(
      config.folder / "references", "ours", key, config.reference_passes, [&](int pass) {
        say(pass_text("our", pass, config.reference_passes));
        return image(config.reference_samples, rng.fork(static_cast<std::uint64_t>(pass) + 1));
      }));
}

std::optional<Reference> cycles_reference(const LeafyScene& leafy, const LightConfig& config,
                                          const Image<Rgbf>& one_sample, const Say& say) {
  if (config.reference_passes < 2) return std::nullopt;
  const std::string key = image_hash(one_sample) + " " + std::to_string(config.reference_samples);
  return merge_passes(reference_passes(
      config.folder / "references", "cycles", key, config.reference_passes, [&](int pass) {
        say(pass_text("Cycles'", pass, config.reference_passes));
        const int seed = 2'000'003 + pass;  // above those of the runs
        return render_with_cycles(leafy.scene, leafy.view, cycles_config(config),
                                  {{.samples = config.reference_samples, .seed = seed}})
            .front()
            .radiance;
      }));
}

}  // namespace cousin
