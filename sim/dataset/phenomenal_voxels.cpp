// A numpy .npz (a ZIP of .npy files [numpy.lib.format; PKWARE APPNOTE 4.3]) with
//   image.npy (bool, C order, 3 axes x y z), world_coordinate.npy (3 doubles, mm), voxels_size.npy
//   (1 double, mm).
// The centre of voxel (i, j, k) is world_coordinate + size (i, j, k)
// [github.com/openalea/phenomenal, VoxelGrid.from_image_3d].

#include <zlib.h>

#include <array>
#include <cstring>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw std::runtime_error(name + ": " + what);
}

/// Little-endian unsigned number of `count` bytes at `at`.
std::size_t number_at(const std::string& bytes, std::size_t at, std::size_t count,
                      const std::string& name) {
  if (at > bytes.size() || bytes.size() - at < count) fail(name, "truncated ZIP");
  std::size_t value = 0;
  for (std::size_t i = count; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::string inflate_raw(std::string_view packed, std::size_t size, const std::string& name) {
  std::string out(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) fail(name, "zlib does not start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = inflate(&stream, Z_FINISH);
  const bool complete = result == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  if (!complete) fail(name, "the compressed data is damaged or of another length than stated");
  return out;
}

/// The member `wanted` of a ZIP, by its central directory.
std::string zip_member(const std::string& zip, const std::string& wanted, const std::string& name) {
  const std::size_t end = zip.rfind("PK\x05\x06");
  if (end == std::string::npos) fail(name, "not a ZIP (no end record)");
  std::size_t entry = number_at(zip, end + 16, 4, name);
  const std::size_t count = number_at(zip, end + 10, 2, name);
  for (std::size_t i = 0; i < count; ++i) {
    if (number_at(zip, entry, 4, name) != 0x02014b50) fail(name, "the ZIP directory is damaged");
    const std::size_t method = number_at(zip, entry + 10, 2, name);
    const std::size_t packed_size = number_at(zip, entry + 20, 4, name);
    const std::size_t size = number_at(zip, entry + 24, 4, name);
    const std::size_t name_size = number_at(zip, entry + 28, 2, name);
    const std::size_t skip =
        name_size + number_at(zip, entry + 30, 2, name) + number_at(zip, entry + 32, 2, name);
    const std::size_t local = number_at(zip, entry + 42, 4, name);
    number_at(zip, entry + 46 + skip, 0, name);
    if (zip.compare(entry + 46, name_size, wanted) == 0) {
      if (size > kMaxBytes) fail(name, wanted + " has more than 2^30 bytes");
      const std::size_t data =
          local + 30 + number_at(zip, local + 26, 2, name) + number_at(zip, local + 28, 2, name);
      if (data > zip.size() || zip.size() - data < packed_size) fail(name, "truncated ZIP");
      const std::string_view packed(zip.data() + data, packed_size);
      if (method == 8) return inflate_raw(packed, size, name);
      if (method == 0 && packed_size == size) return std::string(packed);
      fail(name,
           wanted + " is compressed by method " + std::to_string(method) + "; 0 and 8 are read");
    }
    entry += 46 + skip;
  }
  fail(name, "lacks " + wanted);
}

struct Array {
  std::vector<std::size_t> shape;
  std::string data;
};

/// A .npy of `type` in C order with `rank` axes.
Array npy(const std::string& bytes, const std::string& type, std::size_t rank,
          const std::string& name) {
  if (!bytes.starts_with("\x93NUMPY\x01")) fail(name, "not a .npy of version 1");
  const std::size_t header_size = number_at(bytes, 8, 2, name);
  if (bytes.size() < 10 + header_size) fail(name, "truncated .npy");
  const std::string header = bytes.substr(10, header_size);
  if (header.find("'" + type + "'") == std::string::npos)
    fail(name, "the array is not of type " + type);
  if (header.find("'fortran_order': False") == std::string::npos)
    fail(name, "the array is not in C order");
  const std::size_t open = header.find('('), close = header.find(')');
  if (open == std::string::npos || close == std::string::npos || close < open)
    fail(name, "the array has no shape");
  Array array;
  std::size_t count = 1;
  for (std::size_t at = open + 1; at < close;) {
    std::size_t value = 0, digits = 0;
    for (; at < close && header[at] >= '0' && header[at] <= '9' && digits < 9; ++at, ++digits) {
      value = 10 * value + static_cast<std::size_t>(header[at] - '0');
    }
    if (digits == 0) {
      ++at;  // ", " and the L of Python 2
      continue;
    }
    array.shape.push_back(value);
    count = value == 0 || count <= kMaxBytes / value ? count * value : kMaxBytes + 1;
  }
  const std::size_t item = type == "|b1" ? 1 : 8;
  if (array.shape.size() != rank)
    fail(name, "the array does not have " + std::to_string(rank) + " axes");
  if (count > kMaxBytes / item || bytes.size() - 10 - header_size != count * item) {
    fail(name, "the array's bytes are not those of its shape");
  }
  array.data = bytes.substr(10 + header_size);
  return array;
}

double double_at(const Array& array, std::size_t index) {
  double value = 0;
  std::memcpy(&value, array.data.data() + 8 * index, 8);  // x86-64 and AArch64 are little-endian
  return value;
}

}  // namespace

VoxelCarving read_phenomenal_voxels(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string zip = read_file(file);
  const Array filled = npy(zip_member(zip, "image.npy", name), "|b1", 3, name + ": image.npy");
  const Array origin =
      npy(zip_member(zip, "world_coordinate.npy", name), "<f8", 1, name + ": world_coordinate.npy");
  const Array size =
      npy(zip_member(zip, "voxels_size.npy", name), "<f8", 0, name + ": voxels_size.npy");
  if (origin.shape.front() != 3) fail(name, "world_coordinate does not have 3 numbers");
  const Eigen::Vector3d origin_mm(double_at(origin, 0), double_at(origin, 1), double_at(origin, 2));
  const double voxel_mm = double_at(size, 0);
  if (!origin_mm.allFinite() || !(voxel_mm > 0 && voxel_mm < 1e6))
    fail(name, "the voxel size or origin is not finite");

  VoxelCarving carving{.voxel_m = 1e-3 * voxel_mm};
  for (std::size_t i = 0, at = 0; i < filled.shape[0]; ++i) {
    for (std::size_t j = 0; j < filled.shape[1]; ++j) {
      for (std::size_t k = 0; k < filled.shape[2]; ++k, ++at) {
        if (filled.data[at] == 0) continue;
        const Eigen::Vector3d index(static_cast<double>(i), static_cast<double>(j),
                                    static_cast<double>(k));
        carving.centres_m.push_back(1e-3 * (origin_mm + voxel_mm * index));
      }
    }
  }
  return carving;
}

}  // namespace cousin
