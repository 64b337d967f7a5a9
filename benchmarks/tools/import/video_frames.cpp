#include "benchmarks/tools/import/video_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeLimit_s = 1800;
constexpr int kMostCandidates = 1000;
constexpr int kCandidatesPerFrame = 5;
/// The middle of each candidate, at the video's own resolution.
constexpr int kPartWidth_px = 640, kPartHeight_px = 480;
constexpr std::size_t kPartBytes = std::size_t{kPartWidth_px} * kPartHeight_px;
/// Containers of pictures; playlists, which name other files, are not among them.
const char* const kContainers = "mov,matroska,webm,avi,mpegts,mpeg,ogg,flv,asf,mjpeg,h264,hevc";

void run(const fs::path& video, ProgramCall call, const fs::path& log) {
  const std::string program = call.words.front();
  if (find_program(program).empty())
    throw std::runtime_error(video.string() + ": the program " + program +
                             " is not there; videos need ffmpeg (Debian: apt install ffmpeg)");
  call.log = log;
  call.time_limit_s = kTimeLimit_s;
  const ProgramOutcome outcome = run_program(call);
  if (!succeeded(outcome))
    throw std::runtime_error(video.string() + ": not read as a video: " + outcome.reason +
                             last_lines(log));
}

std::vector<std::string> input_words(const fs::path& video) {
  return {"-protocol_whitelist", "file", "-format_whitelist",
          kContainers,           "-i",   "file:" + fs::absolute(video).string()};
}

std::vector<std::string> ffmpeg_words(const fs::path& video, const std::string& filter) {
  std::vector<std::string> words = {"ffmpeg", "-v", "error", "-nostdin", "-y"};
  const std::vector<std::string> input = input_words(video);
  words.insert(words.end(), input.begin(), input.end());
  for (const std::string& word : {std::string("-map"), std::string("0:v:0"), std::string("-vf"),
                                  filter, std::string("-fps_mode"), std::string("passthrough")})
    words.push_back(word);
  return words;
}

struct VideoLength {
  double duration_s = 0;
  double rate_hz = 0;
};

/// A number, or a ratio "30000/1001"; nothing for "0/0" and the like.
std::optional<double> positive(const nlohmann::json& node, const char* key) {
  if (!node.is_object() || !node.contains(key) || !node[key].is_string()) return std::nullopt;
  double above = 0, below = 1;
  if (std::sscanf(node[key].get<std::string>().c_str(), "%lf/%lf", &above, &below) < 1)
    return std::nullopt;
  const double value = above / below;
  if (!(value > 0 && value < 1e9)) return std::nullopt;
  return value;
}

VideoLength length_of(const fs::path& video, const fs::path& scratch) {
  ProgramCall call;
  const fs::path answer = scratch / "probe.json";
  call.words = {"ffprobe",
                "-v",
                "error",
                "-select_streams",
                "v:0",
                "-show_entries",
                "stream=width,height,avg_frame_rate,duration:format=duration",
                "-of",
                "json",
                "-o",
                answer.string()};
  const std::vector<std::string> input = input_words(video);
  call.words.insert(call.words.end(), input.begin(), input.end());
  run(video, call, scratch / "probe.log");
  const auto json = nlohmann::json::parse(read_file(answer), nullptr, false);
  if (!json.is_object() || !json.contains("streams") || !json["streams"].is_array() ||
      json["streams"].empty())
    throw std::runtime_error(video.string() + ": has no stream of pictures");
  const nlohmann::json& stream = json["streams"][0];
  for (const char* side : {"width", "height"}) {
    if (!stream.contains(side) || !stream[side].is_number_integer() || stream[side] < 1 ||
        stream[side] > 16384)
      throw std::runtime_error(video.string() + ": its " + side + " is not in [1, 16384] pixels");
  }
  std::optional<double> duration = positive(stream, "duration");
  if (!duration && json.contains("format")) duration = positive(json["format"], "duration");
  const std::optional<double> rate = positive(stream, "avg_frame_rate");
  if (!duration || !rate)
    throw std::runtime_error(video.string() + ": does not say its duration and frame rate");
  return {*duration, *rate};
}

/// Sharpness of each candidate, from the raw middles in a file.
std::vector<double> sharpness_in(const fs::path& raw) {
  std::ifstream in(raw, std::ios::binary);
  std::vector<unsigned char> part(kPartBytes);
  std::vector<double> result;
  while (in.read(reinterpret_cast<char*>(part.data()), kPartBytes))
    result.push_back(sharpness(part.data(), kPartWidth_px, kPartHeight_px));
  return result;
}

/// The sharpest of each of `count` even intervals, in order.
std::vector<std::size_t> best_of_intervals(const std::vector<double>& values, std::size_t count) {
  count = std::min(count, values.size());
  std::vector<std::size_t> best;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t k) {
      return values.begin() + static_cast<std::ptrdiff_t>(k * values.size() / count);
    };
    best.push_back(static_cast<std::size_t>(std::max_element(at(i), at(i + 1)) - values.begin()));
  }
  return best;
}

}  // namespace

double sharpness(const unsigned char* grey, int width_px, int height_px) {
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < height_px; ++y) {
    const unsigned char* row = grey + static_cast<std::ptrdiff_t>(y) * width_px;
    for (int x = 1; x + 1 < width_px; ++x) {
      const int value =
          4 * row[x] - row[x - 1] - row[x + 1] - row[x - width_px] - row[x + width_px];
      sum += value;
      squares += static_cast<double>(value) * value;
    }
  }
  const double n = static_cast<double>(std::max(1, (width_px - 2) * (height_px - 2)));
  return squares / n - sum / n * (sum / n);
}

std::vector<double> extract_sharp_frames(const fs::path& video, int count, const fs::path& folder) {
  if (count < 1 || count > 1000)
    throw std::invalid_argument("--frames " + std::to_string(count) + " is not in [1, 1000]");
  if (!fs::is_regular_file(video)) throw std::runtime_error(video.string() + ": no such file");
  const ScratchFolder scratch("cousin_frames");
  const VideoLength length = length_of(video, scratch.path());
  const int candidates = std::min(kCandidatesPerFrame * count, std::max(kMostCandidates, count));
  double rate_hz = length.rate_hz;
  std::string filter;
  if (length.duration_s * length.rate_hz > candidates) {
    rate_hz = candidates / length.duration_s;
    filter = "fps=" + std::to_string(rate_hz) + ",";
  }
  ProgramCall call;
  const fs::path raw = scratch.path() / "middles.raw";
  call.words = ffmpeg_words(video, filter + "crop=w='min(iw,640)':h='min(ih,480)',scale=640:480");
  for (const std::string& word :
       {std::string("-frames:v"), std::to_string(2 * kMostCandidates), std::string("-pix_fmt"),
        std::string("gray"), std::string("-f"), std::string("rawvideo"), raw.string()})
    call.words.push_back(word);
  run(video, call, scratch.path() / "middles.log");
  const std::vector<std::size_t> chosen =
      best_of_intervals(sharpness_in(raw), static_cast<std::size_t>(count));
  if (chosen.empty()) throw std::runtime_error(video.string() + ": has no picture");

  fs::create_directories(folder);
  std::string select;
  for (const std::size_t frame : chosen)
    select += (select.empty() ? "" : "+") + std::string("eq(n,") + std::to_string(frame) + ")";
  call.words = ffmpeg_words(video, filter + "select='" + select + "'");
  for (const std::string& word :
       {std::string("-pix_fmt"), std::string("rgb24"), std::string("-start_number"),
        std::string("0"), std::string("-f"), std::string("image2"), (folder / "%06d.png").string()})
    call.words.push_back(word);
  run(video, call, scratch.path() / "pictures.log");
  std::vector<double> times_s;
  for (const std::size_t frame : chosen) times_s.push_back(static_cast<double>(frame) / rate_hz);
  return times_s;
}

}  // namespace cousin
