#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/fit_sensor/hidden_device.h"

namespace cousin {
namespace {

TEST(FitSensor, Explore) {
  int inside = 0, all = 0;
  for (int i = 0; i < 6; ++i) {
    const Rng rng = Rng(5).fork(static_cast<std::uint64_t>(i));
    const HiddenDevice device = draw_hidden_device("d457", rng);
    const RecordingPlan plan;
    const SensorFit fit = fit_frames(record(device, plan, rng), geometry_of(device, plan),
                                     rig_choice("d457"), "hidden");
    for (const std::string& p : fit.problems) printf("PROBLEM %s\n", p.c_str());
    for (const HiddenParameter& p : hidden_parameters(device, fit)) {
      printf("%d %-28s true %10.5f est %10.5f [%10.5f %10.5f] %s z=%.2f\n", i, p.name.c_str(), p.truth,
             p.estimate.value, p.estimate.low, p.estimate.high, is_inside(p) ? "" : "OUT",
             (p.estimate.value - p.truth) / (p.estimate.high - p.estimate.low) * 3.92);
      inside += is_inside(p);
      ++all;
    }
    if (i == 0)
      for (const WallStatistics& w : fit.depth->walls)
        printf("%s q %.4f sp %.4f/%.4f te %.4f/%.4f bend %.4f p %.3f wrong %.4f inc %.3f tiles %d ripple %d\n", w.name.c_str(), w.quantum_px,
               w.spatial_px.value, spatial_px_at(device, w.depth_m), w.temporal_px.value,
               temporal_px_at(device, w.depth_m), w.bend_px, w.bend_p, w.wrong, w.incidence_rad, w.tiles, w.ripple_seen);
    for (const HeldOut& h : fit.depth->held_out) printf("held %s %.3f +- %.3f\n", h.wall.c_str(), h.ratio, h.sigma);
    printf("chi2 %.1f p %.3f; gain chi2 %.1f p %.3f\n", fit.depth->chi2, fit.depth->p, fit.gain->chi2, fit.gain->p);
    if (i == 0) printf("%s\n", fit.preset_toml.c_str());
  }
  printf("inside %d of %d\n", inside, all);
}

}  // namespace
}  // namespace cousin
