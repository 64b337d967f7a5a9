// Calibration files, a folder a scene: OUT/000000/rgb.yaml. Where a sensor's frames report
// different lenses (autofocus), a file a frame: rgb_000003.yaml.

#include <algorithm>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/export_pictures.h"
#include "sim/dataset/json_interop.h"

namespace cousin {
namespace {

/// The rig's cameras at one frame.
std::vector<CalibratedCamera> cameras_at(const ExportScene& scene, std::size_t frame,
                                         const ExportOptions& options) {
  std::vector<CalibratedCamera> cameras;
  Pose first_from_world;
  for (std::size_t s = 0; s < scene.capture.rig.size(); ++s) {
    const ExportCamera camera = camera_of(scene, {frame, s, {}, false}, options.true_cameras);
    CalibratedCamera& c = cameras.emplace_back();
    c.name = scene.capture.rig[s].name;
    c.camera = handed_over(camera.camera, options);
    c.camera_from_reference = scene.capture.rig[s].sensor_from_rig;
    if (!options.true_cameras) continue;
    // The rig is where its first sensor's report puts it.
    if (s == 0) first_from_world = *camera.camera_from_world;
    c.camera_from_reference = *camera.camera_from_world * inverse(first_from_world) *
                              scene.capture.rig.front().sensor_from_rig;
  }
  return cameras;
}

bool same_cameras(const std::vector<CalibratedCamera>& a, const std::vector<CalibratedCamera>& b) {
  const auto same = [](const CalibratedCamera& p, const CalibratedCamera& q) {
    const Pose &x = p.camera_from_reference, &y = q.camera_from_reference;
    // True poses of two frames give the rig's own but for rounding.
    return p.camera == q.camera && (x.translation_m - y.translation_m).norm() < 1e-9 &&
           angle_rad(x.rotation * y.rotation.conjugate()) < 1e-9;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

/// `write(folder, ending of the files' stems, cameras)`; a lens that is refused says what helps.
template <class Write>
void write_calibration(const ExportJob& job, const ExportScene& scene, const std::string& ending,
                       const std::vector<CalibratedCamera>& cameras, const Write& write) {
  try {
    write(job.out / six_digits(scene.number), ending, cameras);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(scene.folder.string() + ": " + error.what() +
                                "; --undistort gives the pinhole camera of undistorted pictures");
  }
}

/// Writes each scene's calibration, or each frame's where they differ.
template <class Write>
void for_each_calibration(ExportJob& job, const Write& write) {
  int done = 0;
  for (const ExportScene& scene : job.scenes) {
    job.progress("calibration of " + six_digits(scene.number), done++,
                 static_cast<int>(job.scenes.size()));
    const std::size_t frames = scene.capture.frames.size();
    if (frames == 0) continue;
    const std::vector<CalibratedCamera> first = cameras_at(scene, 0, job.options);
    bool one = true;
    for (std::size_t f = 1; f < frames; ++f)
      one = one && same_cameras(first, cameras_at(scene, f, job.options));
    if (one) {
      write_calibration(job, scene, "", first, write);
      continue;
    }
    job.warnings.push_back(six_digits(scene.number) +
                           ": cameras differ from frame to frame: a file for each");
    for (std::size_t f = 0; f < frames; ++f) {
      write_calibration(job, scene, "_" + six_digits(scene.capture.frames[f].id),
                        cameras_at(scene, f, job.options), write);
    }
  }
}

}  // namespace

void export_opencv(ExportJob& job) {
  for_each_calibration(job, [](const auto& folder, const std::string& ending, const auto& cameras) {
    for (const CalibratedCamera& c : cameras)
      write_once(folder / (c.name + ending + ".yaml"), opencv_yaml(c, cameras.front()));
  });
}

void export_ros(ExportJob& job) {
  for_each_calibration(job, [](const auto& folder, const std::string& ending, const auto& cameras) {
    for (const CalibratedCamera& c : cameras)
      write_once(folder / (c.name + ending + ".yaml"), ros_camera_info(c));
  });
}

void export_kalibr(ExportJob& job) {
  for_each_calibration(job, [](const auto& folder, const std::string& ending, const auto& cameras) {
    write_once(folder / ("camchain" + ending + ".yaml"), kalibr_camchain(cameras));
  });
}

void export_mrcal(ExportJob& job) {
  for_each_calibration(job, [](const auto& folder, const std::string& ending, const auto& cameras) {
    for (const CalibratedCamera& c : cameras)
      write_once(folder / (c.name + ending + ".cameramodel"), mrcal_cameramodel(c));
  });
}

}  // namespace cousin
