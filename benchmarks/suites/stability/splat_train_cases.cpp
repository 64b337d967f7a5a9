#include "benchmarks/suites/stability/splat_train_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/suites/stability/splat_cube.h"
#include "perception/splats/splat_ply.h"
#include "perception/splats/splat_render.h"
#include "perception/splats/splat_start.h"
#include "perception/splats/train_splats.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kViews = 8;

constexpr SplatGrowth kGrowths[] = {SplatGrowth::fixed, SplatGrowth::adaptive,
                                    SplatGrowth::budgeted, SplatGrowth::mcmc};

/// Photographs of the cube from a ring about it.
std::vector<SplatView> ring_views() {
  const SplatModel model = cube_of_splats();
  std::vector<SplatView> views;
  for (int i = 0; i < kViews; ++i) {
    SplatView view;
    view.frame = i;
    view.camera_from_world = ring_pose(i);
    SplatViewLevel level;
    level.camera = cube_camera();
    level.color = render_splats(model, level.camera, view.camera_from_world).color;
    view.full = level;
    views.push_back(std::move(view));
  }
  return views;
}

SplatModel grey_start() {
  return splats_from_points(
      random_start_points({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 300, Rng(1).fork("start")));
}

SplatTrainConfig short_training(SplatGrowth growth) {
  SplatTrainConfig config;
  config.steps = 200;
  config.growth = growth;
  config.most_splats = 600;
  config.grow_every = 20;
  config.report_every = 20;
  config.gradient_limit = 1e-5;
  return config;
}

template <class Change>
void change_colors(std::vector<SplatView>& views, const Change& change) {
  for (SplatView& view : views) {
    for (Image<float>& channel : view.full.color.channel) {
      for (float& x : channel) x = change(x);
    }
  }
}

double not_finite(const SplatModel& model) {
  return static_cast<double>(std::count_if(model.splats.begin(), model.splats.end(),
                                           [](const Splat& splat) { return !is_finite(splat); }));
}

double not_finite(const ColorPlanes& color) {
  double count = 0;
  for (const Image<float>& channel : color.channel) {
    count += static_cast<double>(
        std::count_if(channel.begin(), channel.end(), [](float x) { return !std::isfinite(x); }));
  }
  return count;
}

/// Of what a model shows in a photograph's place.
double psnr_of(const SplatModel& model, const SplatView& view) {
  const SplatViewLevel& level = view.full;
  return psnr_db(render_splats(model, level.camera, view.camera_from_world).color.channel,
                 level.color.channel);
}

/// What trainings by all kinds of growth come to on the same photographs.
struct Trained {
  int with_status = 0;
  double not_finite = 0;
  double least_psnr_db = std::numeric_limits<double>::infinity();  ///< of the first photograph
};

/// That of the cube, in a photograph's size.
Camera photograph_camera() {
  Camera camera = cube_camera();
  const double scale = 720.0 / camera.height_px;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px *= scale;
  camera.fy_px *= scale;
  camera.cx_px = 639.5;
  camera.cy_px = 359.5;
  return camera;
}

/// Statuses that a training may end with, as a row's name has them.
using Statuses = std::vector<SplatTrainStatus>;

std::string text_of(const Statuses& statuses) {
  std::string text = "of four kinds of growth, ";
  for (std::size_t i = 0; i < statuses.size(); ++i)
    text += (i == 0 ? "" : " or ") + to_string(statuses[i]);
  return text;
}

Trained train_by_all(const std::vector<SplatView>& views, const SplatModel& start,
                     const Statuses& expected) {
  Trained all;
  for (const SplatGrowth growth : kGrowths) {
    const SplatTraining training = train_splats(views, start, short_training(growth));
    const bool is_expected =
        std::find(expected.begin(), expected.end(), training.status) != expected.end();
    all.with_status += is_expected ? 1 : 0;
    all.not_finite += not_finite(training.model);
    if (expected.front() != SplatTrainStatus::ok) continue;
    const SplatViewLevel& level = views.front().full;
    all.not_finite += not_finite(
        render_splats(training.model, level.camera, views.front().camera_from_world).color);
    all.least_psnr_db = lesser(all.least_psnr_db, psnr_of(training.model, views.front()));
  }
  return all;
}

/// Rows of photographs that can be learned. `least_db` is what the untrained start does not have:
/// 14 to 15 dB of the ring's photographs, 11 and 6 with half or all of it in one place, 10 of black
/// ones and 3 of white ones, which 200 steps do not reach.
void add_learned(const std::string& name, const std::vector<SplatView>& views, double least_db,
                 std::vector<StabilityRow>& rows, const SplatModel& start = grey_start(),
                 const Statuses& expected = {SplatTrainStatus::ok}) {
  const Trained all = train_by_all(views, start, expected);
  rows.push_back(make_row(name, text_of(expected), "", 4, all.with_status, false));
  rows.push_back(make_row(name, "values not finite", "", 0, all.not_finite));
  rows.push_back(make_row(name, "least PSNR of the first photograph", "dB", least_db,
                          all.least_psnr_db, false));
}

/// A row of photographs that cannot.
void add_refused(const std::string& name, const std::vector<SplatView>& views,
                 SplatTrainStatus expected, std::vector<StabilityRow>& rows,
                 const SplatModel& start = grey_start()) {
  const Trained all = train_by_all(views, start, {expected});
  rows.push_back(make_row(name, text_of({expected}), "", 4, all.with_status, false));
}

void photograph_cases(std::vector<StabilityRow>& rows) {
  const std::vector<SplatView> ring = ring_views();
  add_learned("8 photographs", ring, 18, rows);
  add_learned("one photograph", {ring.front()}, 18, rows);
  add_learned("one photograph eight times", std::vector<SplatView>(kViews, ring.front()), 18, rows);

  std::vector<SplatView> black = ring;
  change_colors(black, [](float) { return 0.0F; });
  // The background's colour: nothing at all is the best model.
  add_learned("8 photographs, all black", black, 30, rows, grey_start(),
              {SplatTrainStatus::ok, SplatTrainStatus::nothing_left});
  std::vector<SplatView> white = ring;
  change_colors(white, [](float) { return 1.0F; });
  add_learned("8 photographs, all white", white, 5, rows);

  std::vector<SplatView> swapped = ring;
  for (int i = 0; i < kViews; ++i)
    swapped[static_cast<std::size_t>(i)].camera_from_world = ring_pose((i * 3 + 1) % kViews);
  add_learned("each photograph with another's pose", swapped, 18, rows);
  // Views trained on do not tell wrong poses: one that is held out does.
  const auto held_out_db = [&](const std::vector<SplatView>& views) {
    const std::vector<SplatView> others(views.begin() + 1, views.end());
    return psnr_of(train_splats(others, grey_start(), short_training(SplatGrowth::budgeted)).model,
                   ring.front());
  };
  rows.push_back(make_row("each photograph with another's pose",
                          "a held-out view has less PSNR than with its own poses by", "dB", 2,
                          held_out_db(ring) - held_out_db(swapped), false));

  std::vector<SplatView> away = ring;
  for (SplatView& view : away) {
    const Eigen::Vector3d place = inverse(view.camera_from_world).translation_m;
    view.camera_from_world = look_at(place, 2 * place);
  }
  add_refused("cameras that look away from the Gaussians", away, SplatTrainStatus::nothing_seen,
              rows);

  std::vector<SplatView> masked = ring;
  for (SplatView& view : masked) {
    view.full.weight = Image<float>(view.full.camera.width_px, view.full.camera.height_px);
  }
  add_refused("masks that leave no pixel", masked, SplatTrainStatus::nothing_to_learn, rows);
  masked.front() = ring.front();
  add_learned("masks that leave one photograph of 8", masked, 18, rows);

  std::vector<SplatView> broken = ring;
  change_colors(broken, [](float) { return kNan; });
  add_refused("photographs of NaN", broken, SplatTrainStatus::not_finite, rows);
  add_refused("no photograph", {}, SplatTrainStatus::no_views, rows);
}

void start_cases(std::vector<StabilityRow>& rows) {
  const std::vector<SplatView> ring = ring_views();
  SplatModel none = grey_start();
  for (Splat& s : none.splats) s.centre_m.x() = kNan;
  add_refused("start of NaN", ring, SplatTrainStatus::no_start, rows, none);
  SplatModel mixed = grey_start();
  mixed.splats.insert(mixed.splats.end(), none.splats.begin(), none.splats.end());
  for (std::size_t i = 0; i < mixed.splats.size(); i += 5) {
    Splat& s = mixed.splats[i];
    switch (i / 5 % 5) {
      case 0:
        s.rotation_wxyz.setZero();
        break;
      case 1:
        s.log_scale = {-20, -20, -20};
        break;  // 2e-9 m
      case 2:
        s.log_scale = {7, -20, -20};
        break;  // a needle of 1 km
      case 3:
        s.opacity_logit = -INFINITY;
        break;
      case 4:
        s.opacity_logit = INFINITY;
        break;
    }
  }
  add_learned("start half of NaN, with needles, points, no turns, opacities 0 and 1", ring, 18,
              rows, mixed);
  SplatModel at_camera = grey_start();
  for (std::size_t i = 0; i < at_camera.splats.size(); i += 2) {
    const Pose world_from_camera = inverse(ring_pose(static_cast<int>(i / 2)));
    at_camera.splats[i].centre_m = world_from_camera.translation_m.cast<float>();
  }
  add_learned("half of the start at the cameras' centres", ring, 15, rows, at_camera);
  const std::vector<StartPoint> same(300);
  add_learned("300 Gaussians in one place", ring, 10, rows, splats_from_points(same));
}

constexpr std::size_t kColumns = 14;  // of a row of degree 0

/// Writes a PLY of the reference's 62 columns, or of the 14 that a degree of 0 needs, whose rows
/// are `row(i)`; the other columns are 0.
template <class Row>
void write_rows(const fs::path& file, std::size_t count, const Row& row, bool whole = false) {
  std::vector<std::string> names = {"x", "y", "z"};
  if (whole) names.insert(names.end(), {"nx", "ny", "nz"});
  names.insert(names.end(), {"f_dc_0", "f_dc_1", "f_dc_2"});
  for (int i = 0; whole && i < 45; ++i) names.push_back("f_rest_" + std::to_string(i));
  const std::size_t jump = names.size() - 6;  // between the sixth column of a row and the next
  for (const char* name :
       {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    names.emplace_back(name);
  std::ofstream out(file, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << count << "\n";
  for (const std::string& name : names) out << "property float " << name << "\n";
  out << "end_header\n";
  constexpr std::size_t kChunk = 100'000;
  std::vector<float> rows;
  for (std::size_t begin = 0; begin < count; begin += kChunk) {
    rows.clear();
    for (std::size_t i = begin; i < std::min(count, begin + kChunk); ++i) {
      const std::array<float, kColumns> values = row(i);
      std::vector<float> columns(names.size(), 0.0F);
      std::copy_n(values.begin(), 3, columns.begin());
      std::copy_n(values.begin() + 3, 3, columns.begin() + (whole ? 6 : 3));
      std::copy_n(values.begin() + 6, kColumns - 6,
                  columns.begin() + static_cast<std::ptrdiff_t>(6 + jump));
      rows.insert(rows.end(), columns.begin(), columns.end());
    }
    out.write(reinterpret_cast<const char*>(rows.data()),
              static_cast<std::streamsize>(rows.size() * sizeof(float)));
  }
}

/// What reading says; empty if it does not complain.
std::string refusal(const fs::path& file, const SplatPlyConfig& config = {}) {
  try {
    (void)read_splat_ply(file, config);
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

void file_cases(bool quick, std::vector<StabilityRow>& rows) {
  const ScratchFolder scratch("cousin-stability");
  const fs::path file = scratch.path() / "splats.ply";
  Rng rng = Rng(1).fork("file");
  const auto good = [&](std::size_t) {
    std::array<float, kColumns> row{};
    for (std::size_t k = 0; k < 3; ++k) row[k] = static_cast<float>(uniform(rng, -0.5, 0.5));
    for (std::size_t k = 7; k < 10; ++k) row[k] = -6;
    row[10] = 1;
    return row;
  };

  write_rows(file, 1000, [&](std::size_t i) {
    auto row = good(i);
    if (i % 10 == 0) row[i / 10 % kColumns] = i % 20 == 0 ? kNan : INFINITY;
    if (i % 10 == 5) row[10] = 0;  // no turn
    return row;
  });
  const SplatFile holed = read_splat_ply(file);
  const std::string damaged = "PLY of 1000 rows, 100 with NaN or infinity, 100 of no turn";
  rows.push_back(make_row(damaged, "rows not counted as such", "", 0,
                          std::abs(100.0 - static_cast<double>(holed.not_finite)) +
                              std::abs(100.0 - static_cast<double>(holed.zero_rotations))));
  rows.push_back(
      make_row(damaged, "values not finite in its picture", "", 0,
               not_finite(render_splats(holed.model, cube_camera(), view_of_cube()).color)));
  const bool refuses = !refusal(file, {.invalid = SplatPlyConfig::Invalid::refuse}).empty();
  rows.push_back(make_row(damaged, "refused where that is asked for", "", 1, refuses, false));

  const std::size_t most = quick ? 200'000 : SplatPlyConfig().most_splats;
  write_rows(file, most, good, true);
  const std::string longest = "PLY of " + std::to_string(most) + " Gaussians";
  {
    SplatFile whole = read_splat_ply(file);
    rows.push_back(make_row(longest, "Gaussians read", "", static_cast<double>(most),
                            static_cast<double>(whole.model.splats.size()), false));
    rows.push_back(
        make_row(longest, "values not finite in its picture", "", 0,
                 not_finite(render_splats(whole.model, cube_camera(), view_of_cube()).color)));
    for (Splat& splat : whole.model.splats) splat.log_scale.setConstant(-4.5F);
    rows.push_back(
        make_row(longest + " of 11 mm", "values not finite in its picture of 1280 x 720", "", 0,
                 not_finite(render_splats(whole.model, photograph_camera(), view_of_cube(),
                                          {.most_pairs = most / 2})  // in parts, of fewer too
                                .color)));
  }
  const std::string limit = refusal(file, {.most_splats = most - 1});
  const bool is_named = limit.find(std::to_string(most)) != std::string::npos;
  rows.push_back(
      make_row(longest, "refused by a limit of one less, by name", "", 1, is_named, false));
  fs::resize_file(file, fs::file_size(file) - 1);
  rows.push_back(
      make_row(longest + ", one byte short", "refused", "", 1, !refusal(file).empty(), false));
}

}  // namespace

std::vector<StabilityRow> splat_train_cases(bool quick) {
  std::vector<StabilityRow> rows;
  photograph_cases(rows);
  start_cases(rows);
  file_cases(quick, rows);
  return rows;
}

}  // namespace cousin
