#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/mesh_io.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written in memory order");

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string cloud_bytes(const Cloud& cloud, const std::vector<int>* instance) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(cloud.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float "
      "ny\n"
      "property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float sigma\n" +
      (instance ? "property int instance\n" : "") + "end_header\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint& p = cloud[i];
    for (int k = 0; k < 3; ++k) put(bytes, p.position_m[k]);
    for (int k = 0; k < 3; ++k) put(bytes, p.normal[k]);
    put(bytes, p.color.r);
    put(bytes, p.color.g);
    put(bytes, p.color.b);
    put(bytes, p.sigma_m);
    if (instance) put(bytes, static_cast<std::int32_t>((*instance)[i]));
  }
  return bytes;
}

using SetValue = std::function<void(std::size_t, double)>;

/// Calls set(point, value) for a column if the file has it; `low` and `high` bound its values.
/// @returns whether the file has it
bool set_each(const geometry::PlyElement& vertices, const fs::path& file, const char* name,
              double low, double high, const SetValue& set) {
  const std::vector<double>* column = vertices.column(name);
  if (!column) return false;
  for (std::size_t i = 0; i < column->size(); ++i) {
    const double value = (*column)[i];
    if (!(value >= low && value <= high))
      throw std::runtime_error(file.string() + ": vertex " + std::to_string(i) + ": " + name +
                               " = " + std::to_string(value) + " is out of range");
    set(i, value);
  }
  return true;
}

}  // namespace

void write_ply(const fs::path& file, const Mesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertices_m.size()) +
                      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    for (int k = 0; k < 3; ++k) put(bytes, v[k]);
  }
  for (const auto& t : mesh.triangles) {
    put(bytes, std::uint8_t{3});
    for (const std::uint32_t v : t) put(bytes, v);
  }
  geometry::write_whole(file, bytes);
}

void write_ply(const fs::path& file, const Cloud& cloud) {
  geometry::write_whole(file, cloud_bytes(cloud, nullptr));
}

void write_ply(const fs::path& file, const Clusters& clusters) {
  if (clusters.instance.size() != clusters.cloud.size()) {
    throw std::invalid_argument(file.string() + ": clusters have " +
                                std::to_string(clusters.instance.size()) + " instances for " +
                                std::to_string(clusters.cloud.size()) + " points");
  }
  geometry::write_whole(file, cloud_bytes(clusters.cloud, &clusters.instance));
}

Clusters read_cloud_ply(const fs::path& file) {
  const std::string bytes = geometry::read_whole(file);
  const geometry::Ply ply = geometry::parse_ply(bytes, file.string());
  const geometry::PlyElement* vertices = ply.element("vertex");
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(file.string() + ": " + what);
  };
  if (!vertices) fail("there is no element \"vertex\"");
  Clusters result;
  result.cloud.resize(vertices->count);
  result.instance.assign(vertices->count, -1);
  const auto each = [&](const char* name, double low, double high, const SetValue& set) {
    return set_each(*vertices, file, name, low, high, set);
  };
  constexpr double kAny = std::numeric_limits<float>::max();
  const char* const axes[3] = {"x", "y", "z"};
  const char* const normals[3] = {"nx", "ny", "nz"};
  for (int k = 0; k < 3; ++k) {
    if (!each(axes[k], -kAny, kAny, [&](std::size_t i, double v) {
          result.cloud[i].position_m[k] = static_cast<float>(v);
        })) {
      fail(std::string("vertices have no ") + axes[k]);
    }
    each(normals[k], -kAny, kAny,
         [&](std::size_t i, double v) { result.cloud[i].normal[k] = static_cast<float>(v); });
  }
  // Integers of 255, or floats of 1.
  const auto channel = [&](const char* name, std::uint8_t Rgb8::*of) {
    bool is_float = false;
    for (std::size_t k = 0; k < vertices->columns.size(); ++k)
      is_float |= vertices->columns[k] == name && vertices->is_float[k];
    const double full = is_float ? 1 : 255;
    each(name, 0, full, [&](std::size_t i, double v) {
      result.cloud[i].color.*of = static_cast<std::uint8_t>(std::lround(is_float ? 255 * v : v));
    });
  };
  channel("red", &Rgb8::r);
  channel("green", &Rgb8::g);
  channel("blue", &Rgb8::b);
  each("sigma", 0, kAny,
       [&](std::size_t i, double v) { result.cloud[i].sigma_m = static_cast<float>(v); });
  each("instance", -1, 1e6, [&](std::size_t i, double v) {
    if (v != std::floor(v))
      fail("vertex " + std::to_string(i) + ": instance = " + std::to_string(v) +
           " is not a whole number");
    result.instance[i] = static_cast<int>(v);
    result.count = std::max(result.count, result.instance[i] + 1);
  });
  return result;
}

}  // namespace cousin
