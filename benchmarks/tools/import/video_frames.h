#pragma once

#include <filesystem>
#include <vector>

namespace cousin {

/// Variance of the Laplacian of an 8-bit grey image, row by row: larger where it is sharper.
double sharpness(const unsigned char* grey, int width_px, int height_px);

/// Of `count` even intervals of a video's time, the sharpest of up to five frames each, by the
/// middle of the picture: PNG files 000000.png, ... in `folder`, which is made. Turned as the
/// video's rotation tag says. Fewer where the video has fewer frames. The programs ffmpeg and
/// ffprobe do it; they open nothing but the file, as a container of pictures.
/// @return times of the frames, seconds from the video's start.
/// @throws std::invalid_argument if `count` is not in [1, 1000]; std::runtime_error if a program is
/// not there, fails or takes half an hour, naming the video and what it says.
std::vector<double> extract_sharp_frames(const std::filesystem::path& video, int count,
                                         const std::filesystem::path& folder);

}  // namespace cousin
