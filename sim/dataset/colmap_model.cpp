// COLMAP's sparse model [colmap.github.io/format.html]; world to camera, x right, y down, z
// forward.
//   cameras.txt   CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
//   images.txt    IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of its points: triples
//                 X Y POINT3D_ID (-1: none). Programs that write no points write an empty line, or
//                 no line at all: each line is looked at
//   points3D.txt  not read, written empty
//   cameras.bin   u64 count; each i32 id, i32 model, u64 width, u64 height, f64 parameters
//   images.bin    u64 count; each i32 id, f64 q[4] t[3], i32 camera, name and a zero byte, u64
//                 points; each f64 x, y, u64 point
// Binary numbers are little-endian.

#include "sim/dataset/colmap_model.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "sim/dataset/byte_reader.h"
#include "sim/dataset/colmap_camera.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/text_fields.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian");

constexpr int kMaxId = 2147483647;
constexpr long long kMaxSide_px = 65535;
constexpr std::size_t kMaxNameChars = 4096;
constexpr double kMostNormError = 1e-2;  ///< of a quaternion; COLMAP normalises, and so do we

std::string camera_name(int id) { return "camera " + std::to_string(id); }

/// A pose of w x y z and a translation; COLMAP normalises, short decimals need it.
Pose pose_of(const std::array<double, 7>& numbers, const std::string& where) {
  for (const double number : numbers) {
    if (!std::isfinite(number))
      throw std::runtime_error(where + "a number of the pose is not finite");
  }
  for (std::size_t i = 4; i < numbers.size(); ++i) {
    if (std::abs(numbers[i]) > kMostCoordinate)
      throw std::runtime_error(where + "the place " + exact_text(numbers[i]) +
                               " is outside [-1e9, 1e9]");
  }
  Pose pose{Eigen::Quaterniond(numbers[0], numbers[1], numbers[2], numbers[3]),
            Eigen::Vector3d(numbers[4], numbers[5], numbers[6])};
  const double norm = pose.rotation.norm();
  if (!(std::abs(norm - 1) < kMostNormError)) {
    throw std::runtime_error(where + "the quaternion's norm " + exact_text(norm) +
                             " is not 1 to within 0.01");
  }
  if (std::abs(norm - 1) > 1e-12) pose.rotation.normalize();
  return pose;
}

std::vector<double> numbers_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation_m;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

void add_camera(ColmapModel& model, int id, const ColmapCamera& colmap, int width_px, int height_px,
                const std::string& where) {
  const Camera camera = from_colmap(colmap, width_px, height_px, where);
  if (!model.cameras.emplace(id, camera).second)
    throw std::runtime_error(where + camera_name(id) + " occurs twice");
}

void add_image(ColmapModel& model, int id, ColmapImage image, const std::string& where) {
  if (!model.cameras.contains(image.camera))
    throw std::runtime_error(where + camera_name(image.camera) + " is not in the file of cameras");
  if (image.name.empty() || image.name.size() > kMaxNameChars)
    throw std::runtime_error(where + "the name has " + std::to_string(image.name.size()) +
                             " characters; the limit is 1 to 4096");
  require_utf8(image.name, where.substr(0, where.size() - 2));
  if (!model.images.emplace(id, std::move(image)).second)
    throw std::runtime_error(where + "image " + std::to_string(id) + " occurs twice");
}

// ---- binary -------------------------------------------------------------------------------------

template <class Number>
void put(std::string& bytes, Number value) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

int size_px(std::uint64_t value, const std::string& where) {
  if (value < 1 || value > static_cast<std::uint64_t>(kMaxSide_px)) {
    throw std::runtime_error(where + "a side of " + std::to_string(value) +
                             " pixels is outside [1, 65535]");
  }
  return static_cast<int>(value);
}

void read_cameras(std::string_view bytes, const std::string& name, ColmapModel& model) {
  constexpr std::size_t kLeastBytes = 4 + 4 + 8 + 8 + 3 * 8;
  ByteReader in(bytes, name + "/cameras.bin");
  for (std::uint64_t left = in.count(kLeastBytes); left > 0; --left) {
    const std::string where = in.where();
    const auto id = in.take<std::int32_t>();
    ColmapCamera colmap = colmap_model_numbered(in.take<std::int32_t>(), where);
    const int width_px = size_px(in.take<std::uint64_t>(), where);
    const int height_px = size_px(in.take<std::uint64_t>(), where);
    for (double& parameter : colmap.parameters) parameter = in.take<double>();
    add_camera(model, id, colmap, width_px, height_px, where);
  }
}

void read_images(std::string_view bytes, const std::string& name, ColmapModel& model) {
  constexpr std::size_t kLeastBytes = 4 + 7 * 8 + 4 + 1 + 8, kPointBytes = 24;
  ByteReader in(bytes, name + "/images.bin");
  for (std::uint64_t left = in.count(kLeastBytes); left > 0; --left) {
    const std::string where = in.where();
    const auto id = in.take<std::int32_t>();
    std::array<double, 7> numbers{};
    for (double& number : numbers) number = in.take<double>();
    ColmapImage image;
    image.camera_from_world = pose_of(numbers, where);
    image.camera = in.take<std::int32_t>();
    image.name = in.text(kMaxNameChars);
    in.skip(in.count(kPointBytes) * kPointBytes);
    add_image(model, id, std::move(image), where);
  }
}

// ---- text ---------------------------------------------------------------------------------------

void read_camera(const TextLine& line, const std::string& where, ColmapModel& model) {
  const int id = static_cast<int>(line.integer(0, 0, kMaxId));
  ColmapCamera colmap = colmap_model_named(line.text(1), where);
  if (line.size() != 4 + colmap.parameters.size()) {
    line.fail("has " + std::to_string(line.size()) + " words; a camera " + colmap.model + " has " +
              std::to_string(4 + colmap.parameters.size()));
  }
  for (std::size_t i = 0; i < colmap.parameters.size(); ++i)
    colmap.parameters[i] = line.number(4 + i);
  add_camera(model, id, colmap, static_cast<int>(line.integer(2, 1, kMaxSide_px)),
             static_cast<int>(line.integer(3, 1, kMaxSide_px)), where);
}

void read_image(const TextLine& line, const std::string& where, ColmapModel& model) {
  std::array<double, 7> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = line.number(1 + i);
  ColmapImage image;
  image.camera_from_world = pose_of(numbers, where);
  image.camera = static_cast<int>(line.integer(8, 0, kMaxId));
  image.name = line.rest(9);
  add_image(model, static_cast<int>(line.integer(0, 0, kMaxId)), std::move(image), where);
}

/// Nothing, or triples of which the third is a point's number; -1 is none, which old programs wrote
/// as 2^64 - 1.
bool is_points(const TextLine& line) {
  if (line.size() % 3 != 0) return false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!(i % 3 == 2 ? line.is_integer(i) : line.is_number(i))) return false;
  }
  return true;
}

/// A turn of unit length, and a camera that there is: points are not mistaken for that.
bool is_image(const TextLine& line, const ColmapModel& model) {
  if (line.size() < 10 || !line.is_integer(0) || !line.is_integer(8)) return false;
  for (std::size_t i = 1; i < 8; ++i) {
    if (!line.is_number(i)) return false;
  }
  const Eigen::Vector4d q(line.number(1), line.number(2), line.number(3), line.number(4));
  const double camera = line.number(8);
  return std::abs(q.norm() - 1) < kMostNormError && camera >= 0 && camera <= kMaxId &&
         model.cameras.contains(static_cast<int>(camera));
}

/// Passes over the line of an image's points, which need not be there.
void skip_points(TextLines& lines, const ColmapModel& model) {
  while (!lines.at_end()) {
    TextLines ahead = lines;
    const TextLine line = ahead.next();
    const bool is_comment = line.size() > 0 && line.text(0).starts_with('#');
    if (!is_comment) {
      const bool points = is_points(line), image = is_image(line, model);
      if (points && image)
        line.fail("may be an image or the points of the one before; put a line between them");
      if (!points && !image)
        line.fail(
            "is neither the points of the image before it, X Y POINT3D_ID for each, nor an "
            "image");
      if (image) return;
    }
    lines = ahead;
    if (!is_comment) return;
  }
}

}  // namespace

ColmapFiles colmap_text(const ColmapModel& model) {
  ColmapFiles files;
  files.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const auto& [id, camera] : model.cameras) {
    const ColmapCamera colmap = to_colmap(camera, camera_name(id));
    files.cameras += std::to_string(id) + " " + colmap.model + " " +
                     std::to_string(camera.width_px) + " " + std::to_string(camera.height_px) +
                     " " + exact_text(colmap.parameters) + "\n";
  }
  files.images =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line POINTS2D[] (X Y POINT3D_ID)\n";
  for (const auto& [id, image] : model.images) {
    files.images += std::to_string(id) + " " + exact_text(numbers_of(image.camera_from_world)) +
                    " " + std::to_string(image.camera) + " " + image.name + "\n\n";
  }
  files.points = "# POINT3D_ID X Y Z R G B ERROR TRACK[] (IMAGE_ID POINT2D_IDX)\n";
  return files;
}

ColmapFiles colmap_binary(const ColmapModel& model) {
  ColmapFiles files;
  put(files.cameras, static_cast<std::uint64_t>(model.cameras.size()));
  for (const auto& [id, camera] : model.cameras) {
    const ColmapCamera colmap = to_colmap(camera, camera_name(id));
    put(files.cameras, static_cast<std::int32_t>(id));
    put(files.cameras, static_cast<std::int32_t>(colmap.model_id));
    put(files.cameras, static_cast<std::uint64_t>(camera.width_px));
    put(files.cameras, static_cast<std::uint64_t>(camera.height_px));
    for (const double parameter : colmap.parameters) put(files.cameras, parameter);
  }
  put(files.images, static_cast<std::uint64_t>(model.images.size()));
  for (const auto& [id, image] : model.images) {
    put(files.images, static_cast<std::int32_t>(id));
    for (const double number : numbers_of(image.camera_from_world)) put(files.images, number);
    put(files.images, static_cast<std::int32_t>(image.camera));
    files.images += image.name;
    files.images += '\0';
    put(files.images, std::uint64_t{0});
  }
  put(files.points, std::uint64_t{0});
  return files;
}

ColmapModel colmap_from_text(const ColmapFiles& files, const std::string& name) {
  ColmapModel model;
  const std::string cameras = name + "/cameras.txt", images = name + "/images.txt";
  for (const TextLine& line : records(files.cameras, cameras))
    read_camera(line, line.where() + "camera " + cut_utf8(line.text(0), 20) + ": ", model);
  TextLines lines(files.images, images);
  while (!lines.at_end()) {
    const TextLine line = lines.next();
    if (line.size() == 0 || line.text(0).starts_with('#')) continue;
    read_image(line, line.where() + "image " + cut_utf8(line.text(0), 20) + ": ", model);
    skip_points(lines, model);
  }
  return model;
}

ColmapModel colmap_from_binary(const ColmapFiles& files, const std::string& name) {
  ColmapModel model;
  read_cameras(files.cameras, name, model);
  read_images(files.images, name, model);
  return model;
}

}  // namespace cousin
