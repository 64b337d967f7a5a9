#include "sim/imaging/image_io.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/imaging/codecs.h"
#include "sim/imaging/exr_color.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/file_bytes.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {}  // namespace

namespace imaging {

void check_encodable(int width, int height) {
  if (width > 0 && height > 0 && width <= 65535 && height <= 65535 &&
      static_cast<std::int64_t>(width) * height <= (std::int64_t{1} << 28)) {
    return;
  }
  throw std::invalid_argument(
      "an image of " + std::to_string(width) + " x " + std::to_string(height) +
      " pixels cannot be written; the limits are 1 to 65535 a side and 2^28 in all");
}

}  // namespace imaging

Image<Rgb8> read_color(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = imaging::read_bytes(file);
  if (imaging::is_png(bytes)) return imaging::decode_png_color(bytes, file.string());
  if (imaging::is_jpeg(bytes)) return imaging::decode_jpeg(bytes, file.string());
  throw std::runtime_error(file.string() + ": neither a PNG nor a JPEG file");
}

Image<std::uint8_t> read_png8(const std::filesystem::path& file) {
  return imaging::decode_png8(imaging::read_bytes(file), file.string());
}

Image<std::uint16_t> read_png16(const std::filesystem::path& file) {
  return imaging::decode_png16(imaging::read_bytes(file), file.string());
}

void write_exr_color(const std::filesystem::path& file, const Image<Rgbf>& image) {
  imaging::replace_file(file, imaging::encode_exr(image));
}

void write_exr_vectors(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image) {
  imaging::replace_file(file, imaging::encode_exr(image));
}

Image<Eigen::Vector3f> read_exr_vectors(const std::filesystem::path& file) {
  const std::vector<Image<float>> channels =
      imaging::decode_exr(imaging::read_bytes(file), file.string(), {{"X", "Y", "Z"}}, kNone);
  Image<Eigen::Vector3f> image(channels[0].width(), channels[0].height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = {channels[0].data()[i], channels[1].data()[i], channels[2].data()[i]};
  }
  return image;
}

Image<float> read_exr(const std::filesystem::path& file) {
  return std::move(
      imaging::decode_exr(imaging::read_bytes(file), file.string(), {{"Z"}, {}}, kNone).front());
}

std::vector<Image<float>> read_exr_channels(const std::filesystem::path& file,
                                            const std::vector<std::string>& channels) {
  if (channels.empty()) return {};
  return imaging::decode_exr(imaging::read_bytes(file), file.string(), {channels}, 0);
}

Image<Rgbf> read_exr_color(const std::filesystem::path& file) {
  const std::vector<Image<float>> channels =
      imaging::decode_exr(imaging::read_bytes(file), file.string(), {{"R", "G", "B"}, {"Y"}}, 0);
  const Image<float>&r = channels.front(), &b = channels.back();
  const Image<float>& g = channels[channels.size() / 2];
  Image<Rgbf> image(r.width(), r.height());
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = {r.data()[i], g.data()[i], b.data()[i]};
  return image;
}

void write_png(const std::filesystem::path& file, const Image<Rgb8>& image) {
  imaging::replace_file(file, imaging::encode_png_pixels(image));
}

void write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image) {
  imaging::replace_file(file, imaging::encode_png_pixels(image));
}

void write_png(const std::filesystem::path& file, const Image<std::uint16_t>& image) {
  imaging::replace_file(file, imaging::encode_png_pixels(image));
}

void write_exr(const std::filesystem::path& file, const Image<float>& image) {
  imaging::replace_file(file, imaging::encode_exr(image));
}

Image<Rgb8> decode_jpeg(const std::vector<std::uint8_t>& bytes) {
  return imaging::decode_jpeg(bytes, "JPEG");
}

std::vector<std::uint8_t> encode_png(const Image<Rgb8>& image) {
  return imaging::encode_png_pixels(image);
}

}  // namespace cousin
