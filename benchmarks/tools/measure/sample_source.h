#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// One capture to measure: a folder of photographs, a video, or a scene of a dataset.
struct SamplePlace {
  enum class Kind { photographs, video, scene };
  std::string name;    ///< of the sample in tables
  std::string source;  ///< name of the source that it is one of
  std::filesystem::path path;
  Kind kind = Kind::photographs;
};

/// The captures that each source holds, in the order of their names. A source is a video, a folder
/// of photographs of one board, a dataset, or a folder of such folders and videos.
/// @throws std::runtime_error naming a source that holds none, or two samples of one name
std::vector<SamplePlace> sample_places(const std::vector<std::string>& sources);

struct SampleReading {
  std::string intrinsics;  ///< as for import_folder; "" = EXIF's focal length, else assumed
  int frames = 0;          ///< of a video; 0 = 60
};

/// Of photographs whose focal length nobody says, 0.85 of the larger side is assumed: the board
/// tells a better one later. @throws as import_folder, read_capture, extract_sharp_frames
Capture read_sample(const SamplePlace& place, const SampleReading& reading);

}  // namespace cousin
