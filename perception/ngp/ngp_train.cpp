#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include "perception/ngp/ngp_file.h"
#include "perception/ngp/ngp_rays.h"
#include "sim/types/rng.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

using namespace ngp;

constexpr int kGroups = 16;       ///< of rays, summed apart: the most threads that march and learn
constexpr int kTrainBundle = 16;  ///< rays that pass the networks together
constexpr double kHuber = 0.1;    ///< where the loss turns from square to straight
constexpr int kWarmUp = 256;      ///< steps in which every cell's density is looked at
constexpr int kUpdateEvery = 16;  ///< steps between looks at densities
constexpr int kCellShare = 4;     ///< later, a look takes one cell in this many
constexpr float kThin = 0.01F;    ///< optical thickness of a step that counts as empty

// Adam [Kingma & Ba 2015] with the reference's numbers; its mean of the weights over the last steps
// is left out.
constexpr float kBeta1 = 0.9F, kBeta2 = 0.99F, kEpsilon = 1e-15F, kDecay = 1e-6F;

/// Rays that pass the networks together, and what they should show.
struct TrainingBundle {
  RayBundle rays;  ///< in the end `points` has the loss's derivatives in place of the features
  std::vector<std::array<float, kHarmonics>> basis;
  std::vector<std::array<float, 3>> wanted;
};

/// What one group of rays gives in one step.
struct Group {
  std::vector<TrainingBundle>
      bundles;  ///< the first `used` are of this step, the others keep their memory
  std::size_t used = 0;
  FieldBatch<float> batch, gradient;
  std::vector<float> d_log_density, d_weights;
  double loss = 0;
  std::int64_t samples = 0, drawn = 0;  ///< rays with a pixel that counts

  std::span<TrainingBundle> all() { return std::span(bundles).first(used); }
};

class Trainer {
 public:
  /// @param state  at iteration 0: begins anew, else it goes on
  Trainer(std::span<const NgpView> views, const NgpConfig& config, NgpModel& model,
          NgpTrainState& state)
      : views_(views),
        config_(config),
        model_(model),
        state_(state),
        levels_(grid_levels(config.grid)),
        kernels_(dense_kernels()),
        shape_(network_shape(config)),
        march_(march_config(config)),
        rng_(Rng(config.seed).fork("ngp")) {
    for (std::size_t v = 0; v < views.size(); ++v) {
      std::size_t same = 0;
      while (same < v && !(views[same].camera == views[v].camera)) ++same;
      directions_.push_back(same < v ? directions_[same]
                                     : std::make_shared<const Image<Eigen::Vector3f>>(
                                           pixel_directions(views[v].camera)));
      const Pose world_from_camera = inverse(views[v].camera_from_world);
      origins_.push_back(
          ((world_from_camera.translation_m - model.volume.centre_in_world_m) / model.volume.side_m)
              .cast<float>());
      turns_.push_back(world_from_camera.rotation.toRotationMatrix().cast<float>());
    }
    for (std::size_t c = 0; c < 3; ++c) background_[c] = static_cast<float>(config.background[c]);
    if (state.iteration == 0) start();
    d_table_.assign(model_.table.size(), 0);
    groups_.resize(kGroups);
  }

  /// One step; returns the mean loss of its rays, nothing where masks left none of those drawn.
  std::optional<double> step() {
    const int iteration = state_.iteration;
    if (iteration % kUpdateEvery == 0) look_for_matter(iteration);
    const int rays_of_group = std::max(1, state_.rays / kGroups);
    const Rng step_rng = rng_.fork("step").fork(static_cast<std::uint64_t>(iteration));
    tbb::parallel_for(0, kGroups, [&](int g) {
      march_group(groups_[static_cast<std::size_t>(g)], rays_of_group,
                  step_rng.fork(static_cast<std::uint64_t>(g)));
    });
    encode_groups();
    tbb::parallel_for(0, kGroups, [&](int g) {
      learn_group(groups_[static_cast<std::size_t>(g)], rays_of_group);
    });
    double loss = 0;
    std::int64_t samples = 0, drawn = 0;
    for (const Group& group : groups_) {
      loss += group.loss;
      samples += group.samples;
      drawn += group.drawn;
    }
    state_.samples += samples;
    update(iteration);
    const int rays = rays_of_group * kGroups;
    const double per_ray = std::max(1.0, static_cast<double>(samples) / rays);
    state_.rays = rays_in_limits(config_.samples_per_step / per_ray);
    ++state_.iteration;
    if (drawn == 0) return std::nullopt;
    return loss / (3.0 * static_cast<double>(drawn));
  }

 private:
  static int rays_in_limits(double rays) {
    return static_cast<int>(std::clamp(rays, 256.0, static_cast<double>(kMostRays)));
  }

  void start() {
    Rng draw = rng_.fork("table");
    model_.table.resize(table_size(levels_));
    for (float& number : model_.table) number = static_cast<float>(uniform(draw, -1e-4, 1e-4));
    Rng weights = rng_.fork("weights");
    const int sizes[5][2] = {{shape_.encoded, kWidth},
                             {kWidth, kGeometry},
                             {kGeometry + kHarmonics, kWidth},
                             {kWidth, kWidth},
                             {kWidth, kColors}};
    for (const auto& [inputs, outputs] : sizes) {
      const double limit = std::sqrt(6.0 / (inputs + outputs));
      for (int i = 0; i < inputs * outputs; ++i)
        model_.weights.push_back(static_cast<float>(uniform(weights, -limit, limit)));
    }
    state_.table_first.assign(model_.table.size(), 0);
    state_.table_second.assign(model_.table.size(), 0);
    state_.weights_first.assign(model_.weights.size(), 0);
    state_.weights_second.assign(model_.weights.size(), 0);
    mark_seen();
    state_.rays = rays_in_limits(config_.samples_per_step / 64);
  }

  /// Cells that no view sees stay empty.
  void mark_seen() {
    Occupancy& grid = model_.occupancy;
    grid.resolution = config_.occupancy_cells;
    const std::size_t cells =
        grid.cells_of_cube() * static_cast<std::size_t>(model_.volume.cascades);
    grid.thickness.assign(cells, -1);
    grid.filled.assign(cells, 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells, 4096), [&](const auto& range) {
      for (std::size_t cell = range.begin(); cell < range.end(); ++cell) {
        const Eigen::Vector3d middle =
            cell_middle(grid, cell).cast<double>() * model_.volume.side_m +
            model_.volume.centre_in_world_m;
        const double radius = 0.9 * cell_side(grid, cell) * model_.volume.side_m;
        for (const NgpView& view : views_) {
          const Eigen::Vector3d at = view.camera_from_world * middle;
          if (at.z() < -radius) continue;
          bool sees = at.norm() < 2 * radius;
          if (!sees && at.z() > 0) {
            const auto pixel = project(view.camera, at);
            const double margin = view.camera.fx_px * radius / at.z() + 1;
            sees = pixel && pixel->x() > -margin && pixel->y() > -margin &&
                   pixel->x() < view.camera.width_px + margin &&
                   pixel->y() < view.camera.height_px + margin;
          }
          if (!sees) continue;
          grid.thickness[cell] = 0;
          grid.filled[cell] = 1;
          break;
        }
      }
    });
  }

  void look_for_matter(int iteration) {
    Occupancy& grid = model_.occupancy;
    const int share = iteration < kWarmUp ? 1 : kCellShare;
    const auto turn = static_cast<std::size_t>(iteration / kUpdateEvery);
    const Rng draw = rng_.fork("cells").fork(static_cast<std::uint64_t>(iteration));
    const std::size_t cells = grid.thickness.size();
    const auto shortest = static_cast<float>(march_.shortest);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells, 2048), [&](const auto& range) {
      DensityScratch scratch;
      std::vector<Eigen::Vector3f> at;
      std::vector<std::size_t> which;
      for (std::size_t cell = range.begin(); cell < range.end(); ++cell) {
        if (grid.thickness[cell] < 0) continue;
        // Neighbours take turns, so that each look covers the whole.
        if (share > 1 && (cell * 0x9E3779B97F4A7C15ULL >> 40) % static_cast<std::size_t>(share) !=
                             turn % static_cast<std::size_t>(share))
          continue;
        Rng of_cell = draw.fork(cell);
        const float side = cell_side(grid, cell);
        const Eigen::Vector3f off(static_cast<float>(uniform(of_cell, -0.5, 0.5)),
                                  static_cast<float>(uniform(of_cell, -0.5, 0.5)),
                                  static_cast<float>(uniform(of_cell, -0.5, 0.5)));
        at.push_back(cell_middle(grid, cell) + side * off);
        which.push_back(cell);
      }
      if (at.empty()) return;
      std::vector<float> density(at.size());
      densities(model_, levels_, kernels_, at, scratch, density);
      const float fade = share > 1 ? 0.8F : 0.95F;
      for (std::size_t i = 0; i < which.size(); ++i) {
        float& thickness = grid.thickness[which[i]];
        thickness = std::max(thickness * fade, density[i] * shortest);
      }
    });
    double sum = 0;
    std::size_t seen = 0;
    for (const float thickness : grid.thickness) {
      if (thickness < 0) continue;
      sum += thickness;
      ++seen;
    }
    const float limit = std::min(
        kThin, static_cast<float>(sum / static_cast<double>(std::max<std::size_t>(seen, 1))));
    for (std::size_t cell = 0; cell < cells; ++cell)
      grid.filled[cell] = grid.thickness[cell] >= 0 && grid.thickness[cell] >= limit;
  }

  /// A pixel to train on; masked ones are drawn again a few times, then left out.
  bool draw_ray(Rng& rng, std::size_t& view, int& x, int& y) const {
    for (int attempt = 0; attempt < 32; ++attempt) {
      view = uniform_index(rng, views_.size());
      const NgpView& of = views_[view];
      x = static_cast<int>(uniform_index(rng, static_cast<std::uint64_t>(of.camera.width_px)));
      y = static_cast<int>(uniform_index(rng, static_cast<std::uint64_t>(of.camera.height_px)));
      if (of.mask.empty() || of.mask(x, y)) return true;
    }
    return false;
  }

  void march_group(Group& group, int rays, Rng rng) {
    group.used = 0;
    group.drawn = 0;
    for (int first = 0; first < rays; first += kTrainBundle) {
      if (group.used == group.bundles.size()) group.bundles.emplace_back();
      TrainingBundle& bundle = group.bundles[group.used];
      bundle.rays.clear();
      bundle.basis.clear();
      bundle.wanted.clear();
      for (int r = first; r < std::min(first + kTrainBundle, rays); ++r) {
        std::size_t view = 0;
        int x = 0, y = 0;
        const bool drawn = draw_ray(rng, view, x, y);
        const auto jitter = static_cast<float>(uniform(rng));
        if (!drawn) continue;
        const Eigen::Vector3f& direction = (*directions_[view])(x, y);
        if (direction.squaredNorm() == 0) continue;
        const Eigen::Vector3f ray = turns_[view] * direction;
        bundle.rays.add(model_, march_, origins_[view], ray, jitter);
        bundle.basis.push_back(harmonics(ray));
        const Rgb8 color = views_[view].color(x, y);
        bundle.wanted.push_back({static_cast<float>(color.r) / 255,
                                 static_cast<float>(color.g) / 255,
                                 static_cast<float>(color.b) / 255});
      }
      if (bundle.wanted.empty()) continue;
      bundle.rays.place(model_);
      group.drawn += static_cast<std::int64_t>(bundle.wanted.size());
      ++group.used;
    }
  }

  /// Level after level, for all samples of the step: one level's table fits a core's own cache, all
  /// of them do not.
  void encode_groups() {
    const std::size_t groups = groups_.size();
    tbb::parallel_for(std::size_t{0}, levels_.size() * groups, [&](std::size_t task) {
      for (TrainingBundle& bundle : groups_[task % groups].all())
        bundle.rays.points.encode_level(model_, levels_, task / groups);
    });
  }

  void learn_group(Group& group, int rays) {
    group.d_weights.assign(shape_.size(), 0);
    group.loss = 0;
    group.samples = 0;
    for (TrainingBundle& bundle : group.all()) learn(group, bundle, rays);
  }

  void learn(Group& group, TrainingBundle& bundle, int rays) {
    bundle.rays.pass(model_, kernels_, bundle.basis, group.batch);
    FieldBatch<float>& gradient = group.gradient;
    gradient.resize(shape_, group.batch.samples);
    std::fill(gradient.color.begin(), gradient.color.end(), 0.0F);
    group.d_log_density.assign(static_cast<std::size_t>(gradient.samples), 0);
    const auto scale = static_cast<float>(1.0 / (3.0 * rays * kGroups));
    for (std::size_t r = 0; r < bundle.wanted.size(); ++r) {
      const RaySamples<float> samples = bundle.rays.ray(group.batch, r);
      const RayColor<float> color = composite(samples, background_);
      std::array<float, 3> d_color;
      for (std::size_t c = 0; c < 3; ++c) {
        const float off = color.color[c] - bundle.wanted[r][c];
        const auto limit = static_cast<float>(kHuber);
        const float size = std::abs(off);
        group.loss += size <= limit ? 0.5 * off * off / limit : size - 0.5 * limit;
        d_color[c] = scale * std::clamp(off / limit, -1.0F, 1.0F);
      }
      const int begin = bundle.rays.begin[r];
      composite_backward(samples, color, d_color, group.d_log_density.data() + begin,
                         gradient.color.data() + begin);
    }
    if (gradient.samples == 0) return;
    field_backward(shape_, kernels_, model_.weights.data(), group.batch, group.d_log_density.data(),
                   gradient, group.d_weights.data());
    group.samples += static_cast<std::int64_t>(bundle.rays.samples.size());
    std::swap(gradient.encoded, bundle.rays.points.features);
  }

  static void adapt(float& value, float& m, float& v, float gradient, float rate, float fix1,
                    float fix2) {
    m = kBeta1 * m + (1 - kBeta1) * gradient;
    v = kBeta2 * v + (1 - kBeta2) * gradient * gradient;
    value -= rate * (m * fix1) / (std::sqrt(v * fix2) + kEpsilon);
  }

  void update(int iteration) {
    // The reference falls by .33 every 10,000 steps from 20,000 on.
    const double fall = iteration < 20000 ? 1 : std::pow(0.33, 1 + (iteration - 20000) / 10000);
    const auto rate = static_cast<float>(config_.learning_rate * fall);
    const auto fix1 = static_cast<float>(1 / (1 - std::pow(kBeta1, iteration + 1)));
    const auto fix2 = static_cast<float>(1 / (1 - std::pow(kBeta2, iteration + 1)));
    for (std::size_t i = 0; i < model_.weights.size(); ++i) {
      float gradient = kDecay * model_.weights[i];
      for (const Group& group : groups_) gradient += group.d_weights[i];
      adapt(model_.weights[i], state_.weights_first[i], state_.weights_second[i], gradient, rate,
            fix1, fix2);
    }
    // A level's table belongs to one task: its sums keep their order.
    tbb::parallel_for(std::size_t{0}, levels_.size(), [&](std::size_t l) {
      const GridLevel& level = levels_[l];
      for (Group& group : groups_) {
        for (const TrainingBundle& bundle : group.all()) {
          const EncodedPoints& points = bundle.rays.points;
          const float* d = points.features.data() + kFeatures * l * points.x.size();
          add_derivatives(level, points.x.data(), points.y.data(), points.z.data(),
                          points.columns(), d, d + points.x.size(), d_table_.data());
        }
      }
      // Entries that no sample touched stay, as the reference's do.
      for (std::size_t i = level.offset; i < level.offset + std::size_t{kFeatures} * level.entries;
           ++i) {
        if (d_table_[i] == 0) continue;
        adapt(model_.table[i], state_.table_first[i], state_.table_second[i], d_table_[i], rate,
              fix1, fix2);
        d_table_[i] = 0;
      }
    });
  }

  std::span<const NgpView> views_;
  NgpConfig config_;
  NgpModel& model_;
  NgpTrainState& state_;
  std::vector<GridLevel> levels_;
  DenseKernels<float> kernels_;
  NetworkShape shape_;
  MarchConfig march_;
  Rng rng_;
  std::vector<std::shared_ptr<const Image<Eigen::Vector3f>>> directions_;
  std::vector<Eigen::Vector3f> origins_;
  std::vector<Eigen::Matrix3f> turns_;
  std::array<float, 3> background_{};
  std::vector<Group> groups_;
  std::vector<float> d_table_;
};

void check(const NgpView& view, std::size_t index) {
  const std::string name = "view " + std::to_string(index);
  validate(view.camera);
  const auto fits = [&](const auto& image) {
    return image.width() == view.camera.width_px && image.height() == view.camera.height_px;
  };
  if (!fits(view.color))
    throw std::invalid_argument(name + ": image of " + std::to_string(view.color.width()) + " x " +
                                std::to_string(view.color.height()) + " but the camera has " +
                                std::to_string(view.camera.width_px) + " x " +
                                std::to_string(view.camera.height_px));
  if (!view.mask.empty() && !fits(view.mask))
    throw std::invalid_argument(name + ": the mask has another size than the image");
  if (!view.camera_from_world.translation_m.allFinite() ||
      !view.camera_from_world.rotation.coeffs().allFinite())
    throw std::invalid_argument(name + ": the pose is not finite");
}

SavedNgpTraining begin_or_go_on(std::span<const NgpView> views, const NgpConfig& config,
                                const NgpCheckpoint& checkpoint) {
  SavedNgpTraining saved;
  saved.model.config = config;
  if (checkpoint.file.empty()) return saved;
  saved.fingerprint = ngp_fingerprint(views, config);
  if (!std::filesystem::exists(checkpoint.file)) return saved;
  try {
    SavedNgpTraining kept = read_ngp_training(checkpoint.file);
    // What a file says its model is decides the sizes of its arrays.
    if (kept.fingerprint == saved.fingerprint &&
        to_toml(fields(kept.model.config)) == to_toml(fields(saved.model.config)))
      return kept;
    throw std::runtime_error(checkpoint.file.string() +
                             ": the checkpoint is of other views or another configuration");
  } catch (const std::runtime_error&) {
    if (!checkpoint.replaces_other) throw;
  }
  return saved;
}

bool any_pixel_counts(std::span<const NgpView> views) {
  return std::any_of(views.begin(), views.end(), [](const NgpView& view) {
    return view.mask.empty() ||
           std::any_of(view.mask.begin(), view.mask.end(), [](std::uint8_t m) { return m != 0; });
  });
}

/// What is told and written after an iteration.
/// @param loss  of this iteration alone
void keep_iteration(double loss, int iterations, const NgpSnapshots& snapshots,
                    const std::function<void(int, int)>& progress, const NgpCheckpoint& checkpoint,
                    SavedNgpTraining& saved) {
  const int done = saved.state.iteration;
  const bool is_last = done == iterations;
  if ((done % 100 == 0 || is_last) && saved.loss_count > 0) {
    saved.curve.push_back({done, saved.wall_s, saved.cpu_s, saved.loss_sum / saved.loss_count});
    saved.loss_sum = 0;
    saved.loss_count = 0;
  }
  if (progress) progress(done, iterations);
  if (snapshots.take &&
      std::find(snapshots.at.begin(), snapshots.at.end(), done) != snapshots.at.end())
    snapshots.take({done, saved.wall_s, saved.cpu_s, loss}, saved.model);
  if (!checkpoint.file.empty() && (done % checkpoint.every == 0 || is_last))
    write_ngp_training(checkpoint.file, saved);
}

}  // namespace

NgpTraining train_ngp(std::span<const NgpView> views, const NgpConfig& config,
                      const NgpSnapshots& snapshots, const std::function<void(int, int)>& progress,
                      const NgpCheckpoint& checkpoint) {
  validate(config);
  if (!checkpoint.file.empty() && checkpoint.every < 1)
    throw std::invalid_argument("ngp: a checkpoint every " + std::to_string(checkpoint.every) +
                                " iterations is not at least 1");
  for (std::size_t v = 0; v < views.size(); ++v) check(views[v], v);
  const StageClock clock("ngp");
  NgpTraining training;
  const auto refuse = [&](NgpStatus status, const std::string& reason) {
    training.status = status;
    training.reason = reason;
    training.timing = clock.finish();
    return training;
  };
  if (views.size() < 2)
    return refuse(NgpStatus::too_few_views, std::to_string(views.size()) + " views; at least 2");
  if (!any_pixel_counts(views)) return refuse(NgpStatus::no_pixels, "all masks are empty");
  SavedNgpTraining saved = begin_or_go_on(views, config, checkpoint);
  NgpModel& model = saved.model;
  NgpTrainState& state = saved.state;
  if (state.iteration == 0) {
    model.volume = ngp_volume(config, views);
    if (snapshots.begin) snapshots.begin();
  }
  if (!(model.volume.side_m > 0))
    return refuse(NgpStatus::no_volume,
                  "most cameras look in parallel, or away from their common centre; give "
                  "centre_m and side_m");

  Trainer trainer(views, config, model, state);
  while (state.iteration < config.iterations) {
    const StageClock step_clock("iteration");
    const std::optional<double> mean = trainer.step();
    const double loss = mean.value_or(0);
    const StageTiming took = step_clock.finish();
    saved.wall_s += took.wall_s;
    saved.cpu_s += took.cpu_s;
    saved.loss_sum += loss;
    saved.loss_count += mean ? 1 : 0;
    const int done = state.iteration;
    if (!std::isfinite(loss)) {
      training.model = std::move(model);
      return refuse(NgpStatus::not_finite,
                    "the loss is not finite at step " + std::to_string(done - 1));
    }
    keep_iteration(loss, config.iterations, snapshots, progress, checkpoint, saved);
  }
  training.curve = std::move(saved.curve);
  training.samples = state.samples;
  training.model = std::move(model);
  if (state.samples == 0)
    return refuse(NgpStatus::no_volume,
                  "no ray that was drawn meets a part of the cubes that a camera sees");
  training.status = NgpStatus::ok;
  training.timing = clock.finish();
  return training;
}

}  // namespace cousin
