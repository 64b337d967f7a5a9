#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "perception/ngp/hash_grid.h"
#include "perception/ngp/occupancy.h"
#include "sim/config/fields.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"
#include "sim/types/seams.h"

namespace cousin {

/// A neural radiance field on a multi-resolution hash grid, trained and rendered on a CPU: the
/// Instant-NGP baseline [Müller, Evans, Schied & Keller, ACM TOG 41(4), 2022].
struct NgpConfig {
  int iterations = 7000;
  int samples_per_step = 65536;  ///< about; the number of rays follows
  ngp::HashGridConfig grid;
  int occupancy_cells = 64;  ///< along a side of each cube
  int steps = 512;           ///< shortest step: the inner cube's diagonal over this
  int cascades = 4;          ///< cubes, each twice the one inside; 1 = nothing beyond the inner one
  double side_m = 0;         ///< of the inner cube; 0 = median distance of cameras to its centre
  std::vector<double> centre_m;  ///< of the cubes; empty = point nearest to all optical axes
  double learning_rate = 0.01;
  std::vector<double> background{0, 0, 0};  ///< sRGB 0..1, behind everything
  std::uint64_t seed = 1;
};
Fields fields(NgpConfig& config);
void validate(const NgpConfig& config);

/// One photograph with its camera, of any lens model. What lies behind the plane through a camera
/// counts as not seen by it: a fisheye's image beyond 90 degrees is not explained.
struct NgpView {
  Camera camera;
  Pose camera_from_world;
  Image<Rgb8> color;
  Image<std::uint8_t> mask;  ///< zero = the pixel is not trained on; empty = all are
};

/// The volume that a configuration asks for, or that the views suggest. side_m is 0 where they do
/// not: fewer than half of the cameras have the point in front of them that their optical axes pass
/// nearest to.
ngp::NgpVolume ngp_volume(const NgpConfig& config, std::span<const NgpView> views);

struct NgpModel {
  NgpConfig config;
  ngp::NgpVolume volume;
  ngp::Occupancy occupancy;
  std::vector<float> table;    ///< numbers of the hash grid's corners
  std::vector<float> weights;  ///< of both networks, layer after layer, outputs x inputs
};

enum class NgpStatus { ok, too_few_views, no_pixels, no_volume, not_finite };
std::string_view to_string(NgpStatus status);

struct NgpPoint {
  int iteration = 0;
  /// Since training began, in iterations alone: this run's and those it goes on from. CPU is of all
  /// threads of the process.
  double wall_s = 0, cpu_s = 0;
  double loss = 0;  ///< Huber, mean over the channels of the rays since the last point
};
struct NgpTraining {
  NgpStatus status = NgpStatus::too_few_views;
  std::string reason;  ///< empty if ok
  NgpModel model;
  std::vector<NgpPoint> curve;
  StageTiming timing;        ///< of this call
  std::int64_t samples = 0;  ///< that passed the networks
};

/// Called after each of `at` iterations with what has been learned so far; not again for those that
/// an earlier call has done.
struct NgpSnapshots {
  std::vector<int> at;
  std::function<void(const NgpPoint&, const NgpModel&)> take;
  /// Called where a training begins that does not go on from a checkpoint. May be empty.
  std::function<void()> begin;
};

/// Where a training keeps itself, so that one that was stopped goes on and ends in the same bytes.
struct NgpCheckpoint {
  std::filesystem::path file;  ///< empty = none. If it exists, training goes on from it
  int every = 500;             ///< iterations
  /// A file that is of another training, or that is damaged, is begun anew in place of an error.
  bool replaces_other = false;
};

/// Needs at least 2 views. The same bytes on any number of threads of one kind of processor (the
/// kernels of AVX2 add in another order than the portable ones). @param progress  called with
/// (iteration, iterations). @throws std::invalid_argument for a bad configuration, an image or mask
/// of another size than its camera's, or a camera that `validate` refuses. @throws
/// std::runtime_error if the checkpoint cannot be read or written, or is of other views or another
/// configuration.
NgpTraining train_ngp(std::span<const NgpView> views, const NgpConfig& config,
                      const NgpSnapshots& snapshots = {},
                      const std::function<void(int, int)>& progress = {},
                      const NgpCheckpoint& checkpoint = {});

/// A field as a file of its own, to be drawn later. @throws std::runtime_error naming the file
void write_ngp(const std::filesystem::path& file, const NgpModel& model);
/// @throws std::runtime_error naming the file and what is wrong: not a field, cut off, altered, or
/// of other sizes than its configuration asks for
NgpModel read_ngp(const std::filesystem::path& file);

struct NgpImage {
  Image<Rgb8> color;
  Image<float> depth_m;  ///< along the axis, mean of the samples by weight; NaN where alpha < 1/2
  Image<float> alpha;
};
/// One view of a model; pixels whose lens model has no direction show the background.
NgpImage render_ngp(const NgpModel& model, const Camera& camera, const Pose& camera_from_world);

}  // namespace cousin
