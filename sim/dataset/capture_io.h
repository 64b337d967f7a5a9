#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// SCENE_DIR (a dataset's 000000/): rig.json, scene_camera.json and images. Numbers print so that
/// they read back equal.
/// Frame ids are 0..999999 and unique; sensor names are of a-z 0-9 _. @throws std::invalid_argument
/// otherwise.
void write_capture(const std::filesystem::path& scene_dir, const Capture& capture);

/// The files below SCENE_DIR that a frame's images, those that are not empty, are written to.
std::vector<std::filesystem::path> frame_image_files(const Capture& capture,
                                                     std::size_t frame_index);
/// One frame's images and nothing else, for shards; rig.json and scene_camera.json follow by
/// write_capture_index, which lists the images that are in `capture` or already on disk.
void write_frame_images(const std::filesystem::path& scene_dir, const Capture& capture,
                        std::size_t frame_index);
void write_capture_index(const std::filesystem::path& scene_dir, const Capture& capture);

/// Reads a scene of a dataset, ours or a real one; never looks into truth/. A frame whose image is
/// missing, truncated or of another size than its camera is an error that names file and frame.
Capture read_capture(const std::filesystem::path& scene_dir);

/// Scene folders (six digits) of a dataset, sorted.
std::vector<std::filesystem::path> scene_folders(const std::filesystem::path& dataset);

}  // namespace cousin
