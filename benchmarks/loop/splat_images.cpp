#include "benchmarks/loop/splat_images.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "perception/splats/splat_render.h"

namespace cousin {
namespace {

bool has_pixels(const Image<std::uint8_t>& mask) {
  return std::any_of(mask.begin(), mask.end(), [](std::uint8_t x) { return x != 0; });
}

/// Not zero where the photograph shows more of the scene than of what is behind it.
Image<std::uint8_t> objects_of(const SplatViewLevel& level, const Image<std::uint8_t>& counted) {
  Image<std::uint8_t> mask(level.behind.width(), level.behind.height());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const bool counts = counted.empty() || counted.data()[i] != 0;
    mask.data()[i] = counts && level.behind.data()[i] < 0.5F;
  }
  return mask;
}

/// Mean of scores that are over at least one pixel. One that is not a number then is the image's
/// fault, and stays; an infinite PSNR, of equal images, is left out.
struct Mean {
  double sum = 0;
  std::int64_t count = 0;
  void add(double value, bool has_pixels = true) {
    if (!has_pixels || std::isinf(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : kNaN; }
};

/// Means over squares of pixels.
Image<float> small(const Image<float>& image) {
  constexpr int kSide = kSmallPhotograph;
  Image<float> out(image.width() / kSide, image.height() / kSide);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      float sum = 0;
      for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) sum += image(kSide * x + i, kSide * y + j);
      out(x, y) = sum / (kSide * kSide);
    }
  }
  return out;
}

FidelityPlanes small(const FidelityPlanes& image) {
  return {small(image[0]), small(image[1]), small(image[2])};
}

/// What photographs say of a model, over one kind of them.
struct PhotographMeans {
  Mean psnr, object, whole, whole_small, ssim, ssim_object, ssim_whole, flip, flip_object,
      flip_whole;
  Mean lpips, lpips_whole;

  struct Looks {
    double psnr, ssim, flip, lpips;
    bool has_pixels;
  };
  static Looks looks_of(const FidelityPlanes& image, const SplatViewLevel& level,
                        const LearnedDistance* learned) {
    const FidelityPlanes& truth = level.color.channel;
    const Image<std::uint8_t> counted = counted_pixels(level.weight);
    const FidelityPlanes inside = where_counted(image, truth, counted);
    return {psnr_db(image, truth, counted), cousin::ssim(inside, truth, counted),
            cousin::flip(inside, truth, counted), learned ? learned->between(inside, truth) : kNaN,
            counted.empty() || cousin::has_pixels(counted)};
  }

  void add_whole(const FidelityPlanes& image, const Looks& looks, const SplatViewLevel& level,
                 const LearnedDistance* learned) {
    const FidelityPlanes& truth = level.color.channel;
    whole.add(looks.psnr, looks.has_pixels);
    ssim_whole.add(looks.ssim, looks.has_pixels);
    flip_whole.add(looks.flip, looks.has_pixels);
    lpips_whole.add(looks.lpips, learned != nullptr);
    const Image<std::uint8_t> counted_small =
        level.weight.empty() ? Image<std::uint8_t>{} : counted_pixels(small(level.weight));
    whole_small.add(psnr_db(small(image), small(truth), counted_small), looks.has_pixels);
  }

  void add(const SeedsImageRenderer& render, const ScoredPhotograph& photograph,
           const LearnedDistance* learned) {
    const SplatViewLevel& level = photograph.view.full;
    const Pose& pose = photograph.view.camera_from_world;
    const FidelityPlanes image = render(level.camera, pose);
    const FidelityPlanes& truth = level.color.channel;
    const Image<std::uint8_t> counted = counted_pixels(level.weight);
    const Looks part = looks_of(image, level, learned);
    psnr.add(part.psnr, part.has_pixels);
    ssim.add(part.ssim, part.has_pixels);
    flip.add(part.flip, part.has_pixels);
    lpips.add(part.lpips, learned != nullptr);
    if (photograph.whole) {
      const SplatViewLevel& all = photograph.whole->full;
      const FidelityPlanes drawn = render(all.camera, pose);
      add_whole(drawn, looks_of(drawn, all, learned), all, learned);
    } else {
      add_whole(image, part, level, learned);
    }
    if (!level.behind.empty()) {
      const Image<std::uint8_t> objects = objects_of(level, counted);
      const bool has_object = has_pixels(objects);
      object.add(psnr_db(image, truth, objects), has_object);
      const FidelityPlanes of_objects = where_counted(image, truth, objects);
      ssim_object.add(cousin::ssim(of_objects, truth, objects), has_object);
      flip_object.add(cousin::flip(of_objects, truth, objects), has_object);
    }
  }

  void append(const std::string& prefix, const ScoreRow& base, std::vector<ScoreRow>& rows) const {
    const auto add = [&](const char* metric, const Mean& mean, const char* unit) {
      if (mean.count == 0) return;
      ScoreRow row = base;
      row.metric = prefix + metric;
      row.value = mean.value();
      row.unit = unit;
      row.n = mean.count;
      rows.push_back(row);
    };
    add("psnr", psnr, "dB");
    add("psnr_object", object, "dB");
    add("psnr_whole", whole, "dB");
    add("psnr_whole_small", whole_small, "dB");
    add("ssim_whole", ssim_whole, "1");
    add("flip_whole", flip_whole, "1");
    add("lpips_whole", lpips_whole, "1");
    add("ssim", ssim, "1");
    add("ssim_object", ssim_object, "1");
    add("flip", flip, "1");
    add("flip_object", flip_object, "1");
    add("lpips", lpips, "1");
  }
};

/// A margin that no photograph is wide enough for.
constexpr int kWholePhotograph_px = 10000;

std::vector<SplatView> spread(const std::vector<SplatView>& views, std::size_t most) {
  const std::size_t count = std::min(views.size(), most);
  std::vector<SplatView> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(views[i * views.size() / count]);
  return some;
}

}  // namespace

std::vector<ScoredPhotograph> scored_photographs(const Capture& capture, const Poses& poses,
                                                 const SeedsPipelineConfig& config, int margin_px,
                                                 std::size_t most_views) {
  const auto views_with = [&](int margin) {
    return seed_views(capture, poses, volume_of(config, board_of(capture, config)), config.green,
                      margin, config.splats.most_pixels);
  };
  std::vector<SplatView> trained, held_out;
  for (SplatView& view : views_with(margin_px))
    (is_held_out(config.splats, view.frame) ? held_out : trained).push_back(std::move(view));
  std::map<int, SplatView> wholes;  // of parts, by frame
  if (margin_px < kWholePhotograph_px) {
    for (SplatView& view : views_with(kWholePhotograph_px))
      wholes.emplace(view.frame, std::move(view));
  }
  std::vector<ScoredPhotograph> photographs;
  for (const auto* views : {&trained, &held_out}) {
    for (SplatView& view : spread(*views, most_views)) {
      ScoredPhotograph photograph{std::move(view), views == &held_out, std::nullopt};
      if (const auto whole = wholes.find(photograph.view.frame); whole != wholes.end())
        photograph.whole = std::move(whole->second);
      photographs.push_back(std::move(photograph));
    }
  }
  return photographs;
}

ScoredPhotograph made_small(const ScoredPhotograph& photograph) {
  const SplatViewLevel& level = photograph.view.full;
  ScoredPhotograph made{{photograph.view.frame, photograph.view.camera_from_world, {}},
                        photograph.held_out,
                        std::nullopt};
  SplatViewLevel next;
  next.camera = level.camera;
  next.camera.width_px = level.camera.width_px / kSmallPhotograph;
  next.camera.height_px = level.camera.height_px / kSmallPhotograph;
  next.camera.fx_px /= kSmallPhotograph;
  next.camera.fy_px /= kSmallPhotograph;
  next.camera.cx_px = (level.camera.cx_px + 0.5) / kSmallPhotograph - 0.5;
  next.camera.cy_px = (level.camera.cy_px + 0.5) / kSmallPhotograph - 0.5;
  next.color.channel = small(level.color.channel);
  if (!level.weight.empty()) next.weight = small(level.weight);
  if (!level.behind.empty()) next.behind = small(level.behind);
  made.view.full = std::move(next);
  return made;
}

std::vector<ScoreRow> photograph_rows(const std::vector<ScoredPhotograph>& photographs,
                                      const SeedsImageRenderer& render, const ScoreRow& base,
                                      const LearnedDistance* learned) {
  PhotographMeans trained, held_out;
  for (const ScoredPhotograph& photograph : photographs) {
    (photograph.held_out ? held_out : trained).add(render, photograph, learned);
  }
  std::vector<ScoreRow> rows;
  trained.append("train.", base, rows);
  held_out.append("held_out.", base, rows);
  return rows;
}

std::vector<ScoreRow> splat_image_rows(const Capture& capture, const Estimate& estimate,
                                       const SeedsPipelineConfig& config,
                                       const SeedsScoreLabels& labels,
                                       const LearnedDistance* learned, std::size_t most_views) {
  if (estimate.splats.splats.empty()) return {};
  ScoreRow base = labelled_row(labels);
  for (const StageTiming& timing : estimate.timings) {
    if (timing.stage != "splats") continue;
    base.wall_s = timing.wall_s;
    base.cpu_s = timing.cpu_s;
    base.peak_rss_mb = timing.peak_rss_mb;
    base.peak_above_start_mb = timing.peak_above_start_mb;
  }
  const int margin_px = config.method == SeedsMethod::splats_paper
                            ? config.splats.reference_margin_px
                            : config.splats.margin_px;
  std::vector<ScoreRow> rows = photograph_rows(
      scored_photographs(capture, estimate.poses, config, margin_px, most_views),
      [&](const Camera& camera, const Pose& pose) {
        return render_splats(estimate.splats, camera, pose).color.channel;
      },
      base, learned);
  ScoreRow row = base;
  row.metric = "gaussians";
  row.value = static_cast<double>(estimate.splats.splats.size());
  row.unit = "1";
  row.n = 1;
  rows.push_back(row);
  return rows;
}

}  // namespace cousin
