#include "perception/splats/splat_frame.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace cousin {
namespace {

using Range = tbb::blocked_range<int>;

void fit(Image<float>& image, const SplatCamera& camera) {
  if (image.width() != camera.width_px || image.height() != camera.height_px) {
    image = Image<float>(camera.width_px, camera.height_px);
  }
}

/// A ray is deepest in a Gaussian of precision A, in the camera's frame, where the density along it
/// is largest: at r'Ac / r'Ar of the ray r with r.z = 1, c the centre. At the centre's own ray that
/// changes by the share -(e'Ar) / (r'Ar) along the unit vector e of the image [the idea of a depth
/// for each ray: Zhang et al., RaDe-GS, 2024].
void set_depth_slope(const SplatPlanes& planes, const SplatCamera& camera, int i, float* slope) {
  slope[0] = slope[1] = 0;
  const auto value = [&](int plane) { return static_cast<double>(planes.at(plane, i)); };
  Eigen::Vector3d centre_m, scale;
  for (int k = 0; k < 3; ++k) {
    centre_m[k] = value(SplatPlane::centre + k);
    scale[k] = std::exp(value(SplatPlane::log_scale + k));
  }
  const Eigen::Quaterniond q(value(SplatPlane::rotation), value(SplatPlane::rotation + 1),
                             value(SplatPlane::rotation + 2), value(SplatPlane::rotation + 3));
  using RowMajor = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d camera_from_world =
      Eigen::Map<const RowMajor>(camera.rotation).cast<double>();
  const Eigen::Vector3d c = camera_from_world * centre_m +
                            Eigen::Map<const Eigen::Vector3f>(camera.translation).cast<double>();
  const Eigen::Vector3d ray = c / c.z();
  const Eigen::Matrix3d axes =
      camera_from_world *
      (q.norm() < 1e-12 ? Eigen::Matrix3d::Identity() : q.normalized().toRotationMatrix());
  const Eigen::Vector3d precision = (scale.minCoeff() / scale.array()).square();
  const Eigen::Vector3d along = precision.cwiseProduct(axes.transpose() * ray);
  const Eigen::Vector3d a_ray = axes * along;
  const double denominator = ray.dot(a_ray);
  const double right = -a_ray.x() / denominator, down = -a_ray.y() / denominator;
  // A disc seen edge-on, or a needle along the ray, says nothing of where a surface is on its
  // length: its centre is the better guess.
  constexpr double kSteepest = 5.67;  ///< tan 80 degrees
  if (!(std::hypot(right, down) <= kSteepest)) return;
  slope[0] = static_cast<float>(right / static_cast<double>(camera.fx));
  slope[1] = static_cast<float>(down / static_cast<double>(camera.fy));
}

/// Resizes what is written anew in each frame: the old block goes before a larger one comes, so
/// that no two are held.
template <class T>
void refit(std::vector<T>& scratch, std::size_t size) {
  if (size > scratch.capacity()) {
    scratch = std::vector<T>();  // `= {}` would keep the block
    scratch.reserve(size + size / 4);
  }
  scratch.resize(size);
}

int tile_count(const TileLists& lists) { return lists.tiles_across * lists.tiles_down; }

}  // namespace

BlendTask blend_task(SplatFrame& frame, const std::array<float, 3>& background) {
  BlendTask task;
  task.projected = frame.projected.data();
  task.tile_begin = frame.lists.tile_begin.data();
  task.tile_splat = frame.lists.tile_splat.data();
  task.tile_pair = frame.lists.tile_pair.data();
  task.tiles_across = frame.lists.tiles_across;
  task.width_px = frame.camera.width_px;
  task.height_px = frame.camera.height_px;
  for (std::size_t k = 0; k < 3; ++k) {
    task.background[k] = background[k];
    task.color[k] = frame.color.channel[k].data();
  }
  task.transmittance = frame.transmittance.data();
  task.tile_done = frame.tile_done.data();
  task.touched = frame.touched.data();
  return task;
}

void draw_splats(const SplatKernels& kernels, const SplatPlanes& planes, int sh_degree,
                 const SplatCamera& camera, const std::array<float, 3>& background,
                 SplatDepths depths, SplatFrame& frame) {
  frame.camera = camera;
  frame.sh_degree = sh_degree;
  frame.projected.resize(static_cast<std::size_t>(planes.padded()));
  frame.depth_order.resize(static_cast<std::size_t>(planes.padded()));
  ProjectTask project;
  project.planes = &planes;
  project.camera = camera;
  project.sh_degree = sh_degree;
  project.projected = frame.projected.data();
  project.depth_order = frame.depth_order.data();
  const int vectors = planes.padded() / 8;
  tbb::parallel_for(Range(0, vectors, 64), [&](const Range& range) {
    kernels.project(project, 8 * range.begin(), 8 * range.end());
  });

  make_tile_lists(frame.projected.data(), frame.depth_order.data(), planes.size(), camera.width_px,
                  camera.height_px, frame.lists, frame.most_pairs);
  for (Image<float>& channel : frame.color.channel) fit(channel, camera);
  fit(frame.transmittance, camera);
  frame.tile_done.resize(static_cast<std::size_t>(tile_count(frame.lists)));
  refit(frame.touched, frame.lists.tile_splat.size());
  BlendTask blend = blend_task(frame, background);
  if (depths == SplatDepths::with) {
    fit(frame.depth_m, camera);
    fit(frame.mean_depth_m, camera);
    blend.depth_m = frame.depth_m.data();
    blend.mean_depth_m = frame.mean_depth_m.data();
    frame.depth_slope.resize(2 * frame.projected.size());
    tbb::parallel_for(0, planes.size(), [&](int i) {
      const auto place = static_cast<std::size_t>(i);
      if (frame.depth_order[place] == 0xffffffffU) return;
      set_depth_slope(planes, camera, i, &frame.depth_slope[2 * place]);
    });
    blend.depth_slope = frame.depth_slope.data();
  }
  tbb::parallel_for(Range(0, tile_count(frame.lists), 4), [&](const Range& range) {
    for (int tile = range.begin(); tile < range.end(); ++tile) kernels.blend(blend, tile);
  });
}

void blend_gradients(const SplatKernels& kernels, const ColorPlanes& color_gradient,
                     const std::array<float, 3>& background, SplatFrame& frame) {
  refit(frame.partials, frame.lists.tile_pair.size());
  BlendGradientTask task;
  task.blend = blend_task(frame, background);
  for (std::size_t k = 0; k < 3; ++k) task.color_gradient[k] = color_gradient.channel[k].data();
  task.partials = frame.partials.data();
  tbb::parallel_for(Range(0, tile_count(frame.lists), 4), [&](const Range& range) {
    for (int tile = range.begin(); tile < range.end(); ++tile) kernels.blend_gradient(task, tile);
  });
}

SplatPlanes parameter_gradients(const SplatKernels& kernels, const SplatPlanes& planes,
                                const SplatFrame& frame) {
  SplatPlanes gradients(SplatPlane::count, planes.size());
  SplatPlanes values = planes;
  UpdateTask task;
  task.planes = &values;
  task.camera = frame.camera;
  task.sh_degree = frame.sh_degree;
  task.projected = frame.projected.data();
  task.partials = frame.partials.data();
  task.pair_first = frame.lists.pair_first.data();
  task.pair_count = frame.lists.pair_count.data();
  task.gradients = &gradients;
  tbb::parallel_for(Range(0, planes.padded() / 8, 64), [&](const Range& range) {
    kernels.update(task, 8 * range.begin(), 8 * range.end());
  });
  return gradients;
}

}  // namespace cousin
