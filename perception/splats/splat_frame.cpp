#include "perception/splats/splat_frame.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace cousin {
namespace {

using Range = tbb::blocked_range<int>;

void fit(Image<float>& image, const SplatCamera& camera) {
  if (image.width() != camera.width_px || image.height() != camera.height_px) {
    image = Image<float>(camera.width_px, camera.height_px);
  }
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
                  camera.height_px, frame.lists);
  for (Image<float>& channel : frame.color.channel) fit(channel, camera);
  fit(frame.transmittance, camera);
  frame.tile_done.resize(static_cast<std::size_t>(tile_count(frame.lists)));
  frame.touched.resize(frame.lists.tile_splat.size());
  BlendTask blend = blend_task(frame, background);
  if (depths == SplatDepths::with) {
    fit(frame.depth_m, camera);
    fit(frame.mean_depth_m, camera);
    blend.depth_m = frame.depth_m.data();
    blend.mean_depth_m = frame.mean_depth_m.data();
  }
  tbb::parallel_for(Range(0, tile_count(frame.lists), 4), [&](const Range& range) {
    for (int tile = range.begin(); tile < range.end(); ++tile) kernels.blend(blend, tile);
  });
}

void blend_gradients(const SplatKernels& kernels, const ColorPlanes& color_gradient,
                     const std::array<float, 3>& background, SplatFrame& frame) {
  frame.partials.resize(frame.lists.tile_pair.size());
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
