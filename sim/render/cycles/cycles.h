#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Blender 3.4's Cycles as a second opinion: a program, on the CPU, without its denoiser; adaptive
/// only where a run says so.
struct CyclesConfig {
  std::string program = "blender";
  std::filesystem::path folder;  ///< made; holds the scene's files and the images
  int threads = 2;
  int max_bounces = 4;
  double time_limit_s = 21600;  ///< of one run of the program, which is ended then
};

struct CyclesRun {
  int samples = 64;  ///< a pixel; adaptive: at most
  int seed = 0;
  double noise_threshold = 0;  ///< > 0: adaptive sampling stops a pixel there
  double filter_width_px = 1;  ///< of the box; 0.01 for geometry at pixel centres
};

struct CyclesImage {
  Image<Rgbf> radiance;           ///< linear sRGB
  Image<float> depth_m;           ///< along the axis; NaN = no surface
  Image<Eigen::Vector3f> normal;  ///< for shading, unit, in the camera, towards it; zero = none
  Image<std::int32_t> instance;   ///< Instance::id; -1 = none
  double seconds = 0;             ///< of the render call, its share of set-up included
};

/// Whether the program can be started.
bool has_cycles(const std::string& program = "blender");

/// Renders a scene as it stands at the view's time through the first row's pose.
///
/// Exact for: diffuse surfaces and leaves without a coat (ior 1), vertex albedo and normals, suns,
/// lamps, and everything in the sky, which is handed over as one picture of 1024 x 512 whatever it
/// is made of. A coat becomes a GGX layer mixed in by Fresnel's share, metal, glass and water
/// Cycles' own, and flesh its random walk of the same mean free path: near, not equal. Through
/// water Cycles' suns shine by refracted paths alone. Prints, noise and projectors have no
/// counterpart. The first run also pays for building Cycles' tree.
/// @throws std::invalid_argument for a scene or lens (pinhole and Kannala-Brandt only) that it
/// cannot express, naming what; std::runtime_error if the program fails or an image is not as
/// asked for.
std::vector<CyclesImage> render_with_cycles(const Scene& scene, const TrueView& view,
                                            const CyclesConfig& config,
                                            const std::vector<CyclesRun>& runs);

enum class SceneFile { blend, gltf };
/// Saves the scene with lights, materials and camera for other programs, by way of Blender.
void save_with_blender(const Scene& scene, const TrueView& view, const CyclesConfig& config,
                       SceneFile format, const std::filesystem::path& file);

}  // namespace cousin
