#include "benchmarks/tools/import/import_capture.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "benchmarks/tools/import/unknown_lens.h"
#include "benchmarks/tools/import/video_frames.h"
#include "sim/dataset/import.h"
#include "sim/process/scratch_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Blender's sets have a file for each part.
fs::path transforms_file(const fs::path& source) {
  if (!fs::is_directory(source) || fs::exists(source / "transforms.json"))
    return fs::is_directory(source) ? source / "transforms.json" : source;
  std::vector<std::string> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(source)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("transforms") && name.ends_with(".json")) others.push_back(name);
  }
  std::sort(others.begin(), others.end());
  std::string text = source.string() + ": no transforms.json";
  for (const std::string& name : others)
    text += (name == others.front() ? "; give one of " : ", ") + (source / name).string();
  throw std::runtime_error(text);
}

Capture import_video(const ImportRequest& request) {
  const ScratchFolder scratch("cousin_video");
  const fs::path pictures = scratch.path() / "pictures";
  const std::vector<double> times_s =
      extract_sharp_frames(request.source, request.frames > 0 ? request.frames : 60, pictures);
  Capture capture = import_folder(pictures, request.intrinsics, [](const Capture& photographs) {
    return unknown_lens(photographs);
  });
  for (std::size_t i = 0; i < capture.frames.size(); ++i) capture.frames[i].time_s = times_s.at(i);
  // The user knows the video, not the folder of its frames.
  for (std::string& warning : capture.warnings) {
    if (const std::size_t at = warning.find(pictures.string()); at != std::string::npos)
      warning.replace(at, pictures.string().size(), request.source.string());
  }
  return capture;
}

/// An option that the format has no use for is a mistake.
void refuse_options(const ImportRequest& request) {
  const std::string& format = request.format;
  const auto is_one_of = [&](std::initializer_list<const char*> formats) {
    return std::find(formats.begin(), formats.end(), format) != formats.end();
  };
  if (is_one_of({"nerfstudio", "colmap", "phenomenal"}) && !request.intrinsics.empty())
    throw std::invalid_argument("--intrinsics: " + format + " has its own lens");
  if (has_labels(request) && !request.intrinsics.empty())
    throw std::invalid_argument("--intrinsics: labelled photographs are of any cameras");
  if (request.depth_unit_m && !is_one_of({"rgbd", "tum", "nerfstudio"}))
    throw std::invalid_argument("--depth-unit: " + format +
                                " has no depth; rgbd, tum and nerfstudio do");
  if (request.length_unit_m && !is_one_of({"rgbd", "stereo"}))
    throw std::invalid_argument("--length-unit: " + format +
                                " has no calibration of two cameras; rgbd and stereo do");
  if (request.frames > 0 && format != "video")
    throw std::invalid_argument("--frames: all images of " + format +
                                " are read; it is for --format video");
}

}  // namespace

Capture import_capture(const ImportRequest& request) {
  refuse_options(request);
  const std::string& format = request.format;
  if (format == "rgbd")
    return import_rgbd(request.source, request.intrinsics,
                       {request.depth_unit_m, request.length_unit_m});
  if (format == "stereo")
    return import_stereo(request.source, request.intrinsics, request.length_unit_m);
  if (format == "nerfstudio")
    return import_nerfstudio(transforms_file(request.source), request.depth_unit_m);
  if (format == "colmap") return import_colmap(request.source);
  if (format == "tum") return import_tum(request.source, request.intrinsics, request.depth_unit_m);
  if (format == "phenomenal") return import_phenomenal(request.source);
  if (format == "video") return import_video(request);
  if (format != "folder") {
    throw std::invalid_argument("--format \"" + format +
                                "\" is not one of rgbd, stereo, tum, nerfstudio, colmap, "
                                "phenomenal, folder, video, coco, yolo");
  }
  if (fs::is_regular_file(request.source))
    throw std::runtime_error(request.source.string() +
                             ": a file, not a folder; a video is --format video");
  return import_folder(request.source, request.intrinsics,
                       [](const Capture& photographs) { return unknown_lens(photographs); });
}

bool has_labels(const ImportRequest& request) {
  return request.format == "coco" || request.format == "yolo";
}

LabelledPhotographs import_labelled(const ImportRequest& request) {
  refuse_options(request);
  return request.format == "coco" ? import_coco(request.source) : import_yolo(request.source);
}

}  // namespace cousin
