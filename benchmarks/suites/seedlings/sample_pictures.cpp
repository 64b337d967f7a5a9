#include "benchmarks/suites/seedlings/sample_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/suites/seedlings/surface_coverage.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

constexpr int kQuality = 92;  ///< of JPEG: pages are small

void put(const FidelityPlanes& planes, int left_px, Image<Rgb8>& into) {
  const Image<Rgb8> image = rgb_of(planes);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) into(left_px + x, y) = image(x, y);
  }
}

const FidelityPlanes& photograph_of(const SampleView& view) {
  return view.photograph.full.color.channel;
}

FidelityPlanes image_of(const TrainedField& field, const SampleView& view) {
  return field.render(view.photograph);
}

double covered_share(const FieldViews& views, std::size_t held_out) {
  CoverageShare share;
  share.add(views.seen[held_out], views.held_out[held_out]->shown);
  return share.seen_by(kEnoughViews);
}

std::size_t least_covered(const FieldViews& views) {
  std::size_t least = 0;
  for (std::size_t i = 1; i < views.held_out.size(); ++i) {
    if (covered_share(views, i) < covered_share(views, least)) least = i;
  }
  return least;
}

/// The photograph with a red tint where too few views see the surface.
FidelityPlanes holes_in_red(const SampleView& view, const Image<std::uint16_t>& seen) {
  FidelityPlanes planes = photograph_of(view);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen.data()[i] >= kEnoughViews) continue;
    planes[0].data()[i] = 0.5F + 0.5F * planes[0].data()[i];
    planes[1].data()[i] *= 0.5F;
    planes[2].data()[i] *= 0.5F;
  }
  return planes;
}

}  // namespace

Image<Rgb8> side_by_side(const FidelityPlanes& left, const FidelityPlanes& right) {
  constexpr int kGap_px = 4;
  const int width = left[0].width();
  Image<Rgb8> both(width + kGap_px + right[0].width(),
                   std::max(left[0].height(), right[0].height()), {255, 255, 255});
  put(left, 0, both);
  put(right, width + kGap_px, both);
  return both;
}

void write_sample_pictures(const std::filesystem::path& report, const SeedlingsJob& job,
                           const TrainedField& field, const FieldViews& views) {
  ReportScene scene;
  scene.name = job.grid.name;
  const std::string of = job.sample.light + ", " + job.case_name() + ", " + job.plan.method + ", " +
                         std::to_string(field.scores.back().steps) + " steps";
  const auto add = [&](const std::string& name, const std::string& caption,
                       const Image<Rgb8>& image) {
    scene.pictures.push_back({name, of + ". " + caption, encode_jpeg(image, kQuality)});
  };
  const SampleView& trained = *views.train.front();
  add("Trained on", "Left: photograph, right: the model's image",
      side_by_side(photograph_of(trained), image_of(field, trained)));
  const std::size_t least = least_covered(views);
  const SampleView& held_out = *views.held_out[least];
  add("Held out", "Left: photograph, right: the model's image",
      side_by_side(photograph_of(held_out), image_of(field, held_out)));
  char share[96];
  std::snprintf(share, sizeof share, "Red: seen by fewer than %d of the views trained on, %.1f %%",
                kEnoughViews, 100 * (1 - covered_share(views, least)));
  add("Held out: what few views see", share,
      side_by_side(photograph_of(held_out), holes_in_red(held_out, views.seen[least])));
  if (job.plan.method == kOurs) scene.splats = without_directions(field.splats);
  write_report_scene(report, scene);
}

}  // namespace cousin
