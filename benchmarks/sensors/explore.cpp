#include <cstdio>
#include <cstdlib>
#include <chrono>
#include "benchmarks/sensors/depth_model_fit.h"
#include "benchmarks/sensors/depth_rows.h"
#include "sim/imaging/image_io.h"
using namespace cousin;
int main(int argc, char** argv) {
  std::string rig = "d457"; std::vector<std::string> sets;
  std::vector<double> zs = {0.4, 0.7, 1, 1.5, 2, 3, 4};
  double light = 0.02, inc = 0, albedo = 0.5, tex = 0; int frames = 4;
  for (int i = 1; i < argc; ++i) { std::string a = argv[i];
    if (a.rfind("rig=",0)==0) rig = a.substr(4); else if (a.rfind("light=",0)==0) light = atof(a.c_str()+6);
    else if (a.rfind("inc=",0)==0) inc = atof(a.c_str()+4); else if (a.rfind("albedo=",0)==0) albedo = atof(a.c_str()+7);
    else if (a.rfind("tex=",0)==0) tex = atof(a.c_str()+4); else if (a.rfind("frames=",0)==0) frames = atoi(a.c_str()+7);
    else if (a.rfind("z=",0)==0) zs = {atof(a.c_str()+2)}; else sets.push_back(a); }
  ActiveStereoConfig c = active_stereo_preset(rig);
  for (auto& s : sets) set_field(fields(c), s);
  const ActiveStereoUnit unit = make_active_stereo(c, Rng(3));
  if (frames == -2) { for (auto& r : depth_rows(1, true)) printf("%s | %s = %g %s %s\n", r.case_name.c_str(), r.metric.c_str(), r.value, r.unit.c_str(), std::string(to_string(r.status)).c_str()); return 0; }
  if (frames == -1) {
    for (auto& w : fit_walls(c)) { const WallView v = see_wall(w, c, unit, Rng(11)); auto s = score_full_model(v, c, unit, 2, Rng(5));
      printf("%g %g %g %g  %g %g %g  %g %g %g %g\n", w.distance_m, w.incidence_rad, w.light, w.albedo, s.signal_e, s.noise_e2, s.margin_e, s.fill, s.spatial_px, s.temporal_px, s.slope); }
    return 0;
  }
  if (frames == 0) {
    c.model = fit_depth_model(c, unit, 2, Rng(11), [](int i, int n) { if (i % 10 == 0) fprintf(stderr, "%d/%d\n", i, n); });
    printf("%s\n", to_toml(fields(c.model)).c_str()); fflush(stdout);
    for (auto& k : compare_models(test_walls(c), c, unit, 2, Rng(77)))
      printf("z %.2f inc %.2f light %.3f snr %.2f: fill %.4f %.4f  sigma %.4f %.4f ratio %.3f  spatial %.4f %.4f temporal %.4f %.4f slope %.3f\n", k.wall.distance_m, k.wall.incidence_rad, k.wall.light, k.full.log2_snr, k.full.fill, k.fast.fill, k.full.sigma_px, k.fast.sigma_px, k.fast.sigma_px / k.full.sigma_px, k.full.spatial_px, k.fast.spatial_px, k.full.temporal_px, k.fast.temporal_px, k.full.slope);
    return 0;
  }
  for (double z : zs) {
    const auto t0 = std::chrono::steady_clock::now();
    const WallView view = see_wall({z, inc, albedo, light, tex}, c, unit, Rng(5)); const WallScores s = score_full_model(view, c, unit, frames, Rng(6)); const WallScores m = score_fast_model(view, c, unit, frames, Rng(6));
    printf("  fast: fill %.4f sigma %.4f spatial %.4f temporal %.4f; snr %.2f slope %.3f wrong %.4f nb %.3f ripple %.4f band %.1f d %.1f\n", m.fill, m.sigma_px, m.spatial_px, m.temporal_px, s.log2_snr, s.slope, s.wrong, s.neighbours, s.ripple_px, s.band_px, s.disparity_px);
    const double dt = std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count();
    printf("z %.2f fill %.4f bias %.4f sigma %.4f spatial %.4f temporal %.4f sigma_m %.5f  (%.2f s)\n", z, s.fill, s.bias_px, s.sigma_px, s.spatial_px, s.temporal_px, s.sigma_m, dt);
  }
  if (getenv("PLATE")) {
    WallScene w = make_wall({1.2, 0, 0.5, light, tex});
    Instance plate = w.scene.instances[0]; plate.id = 2; plate.world_from_object.translation_m.x() = 0.7; plate.model = 1;
    ObjectModel m = w.scene.models[0]; for (auto& v : m.mesh.vertices_m) v *= 0.15 / 7.2; w.scene.models.push_back(m); w.scene.instances.push_back(plate);
    const RayScene rays(w.scene);
    const InfraredPair pair = render_infrared_pair(rays, w.scene, w.rig_from_world, c, unit, Rng(5));
    const StereoDepth d = sense_depth(pair, c, unit, Rng(6));
    FILE* f = fopen("/tmp/plate.raw", "wb");
    for (size_t i = 0; i < d.depth.size(); ++i) { float v[4] = {d.depth.data()[i] * 0.001f, pair.depth_m.data()[i], (float)d.reason.data()[i], d.disparity_px.data()[i]}; fwrite(v, 4, 4, f); }
    fclose(f); return 0;
  }
  const WallScene w = make_wall({zs[0], inc, albedo, light, tex});
  const RayScene rays(w.scene);
  auto t0 = std::chrono::steady_clock::now();
  const InfraredPair pair = render_infrared_pair(rays, w.scene, w.rig_from_world, c, unit, Rng(5));
  auto t1 = std::chrono::steady_clock::now();
  const StereoDepth d = sense_depth(pair, c, unit, Rng(6));
  auto t2 = std::chrono::steady_clock::now();
  auto reg = register_to_color(d.depth, c, unit);
  auto t3 = std::chrono::steady_clock::now();
  auto s = [](auto a, auto b) { return std::chrono::duration<double>(b - a).count(); };
  printf("render %.3f sense %.3f register %.3f\n", s(t0,t1), s(t1,t2), s(t2,t3));
  Image<Rgb8> out(d.left_codes.width(), d.left_codes.height());
  for (size_t i = 0; i < out.size(); ++i) { auto v = (std::uint8_t)std::min<int>(255, d.left_codes.data()[i]); out.data()[i] = {v,v,v}; }
  FILE* f = fopen("/tmp/ir.ppm", "wb"); fprintf(f, "P6 %d %d 255\n", out.width(), out.height()); fwrite(out.data(), 3, out.size(), f); fclose(f);
}
