#include "benchmarks/calibration/calibration_errors.h"
#include <cstdio>
using namespace cousin;
int main() {
  Camera t; t.model = LensModel::opencv5; t.width_px = 640; t.height_px = 480; t.fx_px = t.fy_px = 390; t.cx_px = 322; t.cy_px = 243;
  t.distortion = {-.055, .06, 1e-3, 1e-3, -.016};
  auto show = [&](const char* n, const Camera& c) { auto e = calibration_errors(t, c); std::printf("%s %g %g px, fruit %g mm, seed %g um\n", n, e.projection_px, e.projection_worst_px, e.fruit_m * 1e3, e.seed_m * 1e6); };
  show("same", t);
  Camera c = t; c.cx_px += 5; show("cx+5", c);
  c = t; c.fx_px *= 1.01; c.fy_px *= 1.01; show("f 1%", c);
  c = t; c.distortion = {}; show("no dist", c);
  c = t; c.distortion[2] = .015; c.cy_px = 266; show("paper", c);
}
