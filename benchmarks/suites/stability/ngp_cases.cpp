#include "benchmarks/suites/stability/ngp_cases.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/suites/stability/splat_cube.h"
#include "perception/ngp/ngp.h"
#include "perception/splats/splat_render.h"

namespace cousin {
namespace {

constexpr int kViews = 8;

/// Photographs of the cube from a ring about it.
std::vector<NgpView> ring_views() {
  const SplatModel model = cube_of_splats();
  std::vector<NgpView> views;
  for (int i = 0; i < kViews; ++i) {
    NgpView view{cube_camera(), ring_pose(i), {}, {}};
    view.color = rgb_of(render_splats(model, view.camera, view.camera_from_world).color.channel);
    views.push_back(std::move(view));
  }
  return views;
}

NgpConfig short_training(bool quick) {
  NgpConfig config;
  config.iterations = quick ? 75 : 150;
  config.samples_per_step = 8192;
  config.grid.log2_table = 13;
  config.occupancy_cells = 32;
  config.steps = 256;
  config.cascades = 2;
  return config;
}

double not_finite(const std::vector<float>& values) {
  return static_cast<double>(
      std::count_if(values.begin(), values.end(), [](float x) { return !std::isfinite(x); }));
}

double psnr_of(const NgpModel& model, const NgpView& view) {
  const NgpImage image = render_ngp(model, view.camera, view.camera_from_world);
  return psnr_db(fidelity_planes(image.color), fidelity_planes(view.color));
}

/// Rows of photographs that can be learned: `least_db` is what an empty field does not have of
/// them, 10 dB of the ring's; of black ones it has all.
void add_learned(const std::string& name, const std::vector<NgpView>& views, double least_db,
                 const NgpConfig& config, std::vector<StabilityRow>& rows) {
  const NgpTraining training = train_ngp(views, config);
  rows.push_back(make_row(name, "trained", "", 1, training.status == NgpStatus::ok, false));
  if (training.status != NgpStatus::ok) return;
  rows.push_back(make_row(name, "numbers not finite", "", 0,
                          not_finite(training.model.table) + not_finite(training.model.weights)));
  rows.push_back(make_row(name, "PSNR of the first photograph", "dB", least_db,
                          lesser(100.0, psnr_of(training.model, views.front())), false));
}

void add_refused(const std::string& name, const std::vector<NgpView>& views, NgpStatus expected,
                 const NgpConfig& config, std::vector<StabilityRow>& rows) {
  const NgpTraining training = train_ngp(views, config);
  rows.push_back(make_row(name, std::string(to_string(expected)) + ", with its reason", "", 1,
                          training.status == expected && !training.reason.empty(), false));
}

void photograph_cases(const NgpConfig& config, std::vector<StabilityRow>& rows) {
  const std::vector<NgpView> ring = ring_views();
  add_learned("8 photographs", ring, 18, config, rows);
  add_refused("one photograph", {ring.front()}, NgpStatus::too_few_views, config, rows);
  add_refused("no photograph", {}, NgpStatus::too_few_views, config, rows);
  std::vector<NgpView> black = ring, white = ring;
  const Camera& camera = ring.front().camera;
  for (NgpView& view : black) view.color = Image<Rgb8>(camera.width_px, camera.height_px);
  for (NgpView& view : white)
    view.color = Image<Rgb8>(camera.width_px, camera.height_px, {255, 255, 255});
  add_learned("8 photographs, all black", black, 30, config, rows);
  add_learned("8 photographs, all white", white, 10, config, rows);
  std::vector<NgpView> swapped = ring;
  for (int i = 0; i < kViews; ++i)
    swapped[static_cast<std::size_t>(i)].camera_from_world = ring_pose((i * 3 + 1) % kViews);
  add_learned("each photograph with another's pose", swapped, 14, config, rows);
  // Views trained on do not tell wrong poses: one that is held out does.
  const auto held_out_db = [&](const std::vector<NgpView>& views) {
    const std::vector<NgpView> others(views.begin() + 1, views.end());
    return psnr_of(train_ngp(others, config).model, ring.front());
  };
  rows.push_back(make_row("each photograph with another's pose",
                          "a held-out view has less PSNR than with its own poses by", "dB", 0.3,
                          held_out_db(ring) - held_out_db(swapped), false));
  std::vector<NgpView> masked = ring;
  for (NgpView& view : masked)
    view.mask = Image<std::uint8_t>(camera.width_px, camera.height_px, 0);
  add_refused("masks that leave no pixel", masked, NgpStatus::no_pixels, config, rows);
  masked.front() = ring.front();
  add_learned("masks that leave one photograph of 8", masked, 18, config, rows);
}

void camera_cases(const NgpConfig& config, std::vector<StabilityRow>& rows) {
  const std::vector<NgpView> ring = ring_views();
  add_refused("one photograph eight times, from one place", std::vector<NgpView>(8, ring.front()),
              NgpStatus::no_volume, config, rows);
  std::vector<NgpView> away = ring;
  for (NgpView& view : away) {
    const Eigen::Vector3d place = centre_in_world_m(view.camera_from_world);
    view.camera_from_world = look_at(place, 2 * place);
  }
  add_refused("cameras that look away from each other", away, NgpStatus::no_volume, config, rows);
  std::vector<NgpView> parallel = ring;
  for (std::size_t i = 0; i < parallel.size(); ++i) {
    const double x = 0.1 * static_cast<double>(i);
    parallel[i].camera_from_world = look_at({x, 0, 1}, {x, 0, 0}, Eigen::Vector3d::UnitY());
  }
  add_refused("cameras side by side", parallel, NgpStatus::no_volume, config, rows);
  for (const double unit : {1e-3, 1e3}) {
    std::vector<NgpView> scaled = ring;
    for (NgpView& view : scaled) view.camera_from_world.translation_m *= unit;
    add_learned(unit < 1 ? "a thousandth of the size" : "a thousand times the size", scaled, 18,
                config, rows);
  }
  std::vector<NgpView> far = ring;
  const Eigen::Vector3d shift_m(3e6, -4e6, 1e6);
  for (NgpView& view : far)
    view.camera_from_world.translation_m -= view.camera_from_world.rotation * shift_m;
  add_learned("5000 km from the origin", far, 18, config, rows);
}

}  // namespace

std::vector<StabilityRow> ngp_cases(bool quick) {
  const NgpConfig config = short_training(quick);
  std::vector<StabilityRow> rows;
  photograph_cases(config, rows);
  camera_cases(config, rows);
  return rows;
}

}  // namespace cousin
