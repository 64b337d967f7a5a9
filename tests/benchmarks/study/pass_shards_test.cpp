#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/study/shard.h"
#include "benchmarks/suites/light/leafy_scene.h"
#include "sim/dataset/manifest.h"
#include "sim/render/path_tracer.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

template <class T>
std::string hash_of(const Image<T>& image) {
  return sha256_hex(
             std::string(reinterpret_cast<const char*>(image.data()), image.size() * sizeof(T))) +
         "\n";
}

/// What one process makes of the leafy scene: everything is built anew.
struct Worker {
  Scene scene = leafy_scene();
  RayScene rays{scene};
  PathTracer tracer{rays, scene};
  ActiveStereoConfig device = active_stereo_preset("d457");
  ActiveStereoUnit unit;

  Worker() {
    device.columns = static_cast<int>(device.mode_columns.front());
    unit = make_active_stereo(device, Rng(9).fork("unit"));
  }

  static Pose pose_of(int frame) {
    return look_at({-1.0 + 0.4 * frame, -0.7, 1.1}, {0, 0.05, 0.2});
  }
  TrueView view_of(int frame) const {
    TrueView view = leafy_view();
    view.frame = frame;
    view.camera = resized(view.camera, 48, 36);
    view.camera_from_world = view.camera_from_world_end = pose_of(frame);
    return view;
  }

  /// Hashes of all images of a frame: a pure function of the frame's number.
  std::string frame_text(int frame) const {
    const TrueView view = view_of(frame);
    const Rng rng = Rng(9).fork(static_cast<std::uint64_t>(frame));
    const PathImage plain = tracer.render(view, {.pixel_samples = 8}, rng.fork("light"));
    const PathImage adaptive = tracer.render(
        view, {.pixel_samples = 24, .adaptive = true, .min_samples = 8}, rng.fork("adaptive"));
    const TruthImages truth = render_truth(
        rays, scene, view, {.depth = true, .normal = true, .position = true, .instance = true});
    const InfraredPair pair =
        render_infrared_pair(rays, scene, pose_of(frame), device, unit, rng.fork("infrared"));
    const StereoDepth depth = sense_depth(pair, device, unit, rng.fork("exposure"));
    return hash_of(plain.radiance) + hash_of(adaptive.radiance) + hash_of(adaptive.samples) +
           hash_of(truth.depth_m) + hash_of(truth.normal) + hash_of(truth.position_m) +
           hash_of(truth.instance) + hash_of(pair.left.radiance) + hash_of(pair.right.projected) +
           hash_of(depth.left_codes) + hash_of(depth.depth) + hash_of(depth.reason);
  }
};

std::vector<ShardJob> jobs_of(const Worker& worker, int frames) {
  std::vector<ShardJob> jobs;
  for (int i = 0; i < frames; ++i) {
    jobs.push_back({"frame" + std::to_string(i) + ".txt", "leafy",
                    [&worker, i] { return worker.frame_text(i); }});
  }
  return jobs;
}

TEST(PassShards, LightInfraredAndTruthAreTheSameBytesWholeAndInShards) {
  constexpr int kFrames = 3;
  const fs::path folder = fs::path(testing::TempDir()) / "pass_shards";
  fs::remove_all(folder);
  const auto run = [&](const char* name, const Shard& shard, std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Worker worker;
    return run_shards(folder / name, jobs_of(worker, kFrames), shard);
  };
  const std::vector<ShardResult> whole = run("whole", {}, 2);
  // The last shard first, each by a process of its own, of other numbers of threads.
  run("parts", {2, 3}, 1);
  run("parts", {0, 3}, 7);
  const std::vector<ShardResult> parts = run("parts", {1, 3}, 2);
  ASSERT_EQ(parts.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_FALSE(is_missing(parts[i])) << parts[i].name;
    EXPECT_EQ(parts[i].error, "");
    EXPECT_EQ(parts[i].text, whole[i].text) << whole[i].name;
    if (i > 0) EXPECT_NE(whole[i].text, whole[i - 1].text);
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace cousin
