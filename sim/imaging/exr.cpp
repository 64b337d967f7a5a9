#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"

namespace cousin::imaging {
namespace {

class MemoryIn : public Imf::IStream {
 public:
  MemoryIn(std::span<const std::uint8_t> bytes, const std::string& name)
      : IStream(name.c_str()), bytes_(bytes) {}
  bool read(char out[], int count) override {
    if (count < 0 || static_cast<std::size_t>(count) > bytes_.size() - at_)
      throw std::runtime_error("truncated");
    std::memcpy(out, bytes_.data() + at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::size_t>(count);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override {
    if (position > bytes_.size()) throw std::runtime_error("truncated");
    at_ = position;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class MemoryOut : public Imf::OStream {
 public:
  MemoryOut() : OStream("EXR in memory") {}
  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ + size > bytes.size()) bytes.resize(at_ + size);
    std::memcpy(bytes.data() + at_, data, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }

  std::vector<std::uint8_t> bytes;

 private:
  std::size_t at_ = 0;
};

std::string depth_channel(const Imf::ChannelList& channels) {
  if (channels.findChannel("Z")) return "Z";
  if (channels.begin() == channels.end()) throw std::runtime_error("no channel");
  return channels.begin().name();
}

/// The named channels; without names, the depth channel.
std::vector<Image<float>> decode(std::span<const std::uint8_t> bytes, const std::string& name,
                                 std::vector<std::string> names) {
  Imf::Header::setMaxImageSize(65535, 65535);
  MemoryIn in(bytes, name);
  Imf::InputFile file(in);
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  check_image_size("data window", static_cast<std::uint64_t>(std::max<std::int64_t>(width, 0)),
                   static_cast<std::uint64_t>(std::max<std::int64_t>(height, 0)));
  // Every compression shrinks a constant image less than this.
  if (static_cast<std::uint64_t>(width * height) / 2048 > bytes.size()) {
    throw std::runtime_error("truncated: " + std::to_string(bytes.size()) + " bytes cannot hold " +
                             std::to_string(width) + " x " + std::to_string(height) + " pixels");
  }
  const Imf::ChannelList& channels = file.header().channels();
  if (names.empty()) names.push_back(depth_channel(channels));
  std::vector<Image<float>> images;
  Imf::FrameBuffer buffer;
  for (const std::string& channel : names) {
    const Imf::Channel* layout = channels.findChannel(channel);
    if (!layout) throw std::runtime_error("lacks the channel " + channel);
    if (layout->xSampling != 1 || layout->ySampling != 1) {
      throw std::runtime_error("channel " + channel + " is subsampled; expected one value a pixel");
    }
    images.emplace_back(static_cast<int>(width), static_cast<int>(height));
    buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, images.back().data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return images;
}

}  // namespace

Image<float> decode_exr(std::span<const std::uint8_t> bytes, const std::string& name) {
  try {
    return std::move(decode(bytes, name, {}).front());
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": EXR: " + error.what());
  }
}

std::vector<Image<float>> decode_exr_channels(std::span<const std::uint8_t> bytes,
                                              const std::string& name,
                                              const std::vector<std::string>& channels) {
  if (channels.empty()) return {};
  try {
    return decode(bytes, name, channels);
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": EXR: " + error.what());
  }
}

namespace {

struct Plane {
  const char* name;
  const float* first;
};

/// Planes of `width` x `height` pixels, `stride` bytes from one pixel to the next.
std::vector<std::uint8_t> encode(int width, int height, std::size_t stride,
                                 std::initializer_list<Plane> planes) {
  check_encodable(width, height);
  Imf::Header header(width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  for (const Plane& plane : planes) {
    header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
    // OpenEXR's interface lacks const; it only reads.
    buffer.insert(plane.name, Imf::Slice::Make(Imf::FLOAT, const_cast<float*>(plane.first),
                                               header.dataWindow(), stride));
  }
  MemoryOut out;
  {
    Imf::OutputFile file(out, header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  }  // the destructor writes the line offsets
  return std::move(out.bytes);
}

}  // namespace

std::vector<std::uint8_t> encode_exr(const Image<float>& image) {
  return encode(image.width(), image.height(), sizeof(float), {{"Z", image.data()}});
}

std::vector<std::uint8_t> encode_exr(const Image<Rgbf>& image) {
  if (image.empty()) check_encodable(image.width(), image.height());
  const Rgbf* first = image.data();
  return encode(image.width(), image.height(), sizeof(Rgbf),
                {{"R", &first->r}, {"G", &first->g}, {"B", &first->b}});
}

std::vector<std::uint8_t> encode_exr(const Image<Eigen::Vector3f>& image) {
  if (image.empty()) check_encodable(image.width(), image.height());
  const float* first = image.data()->data();
  return encode(image.width(), image.height(), sizeof(Eigen::Vector3f),
                {{"X", first}, {"Y", first + 1}, {"Z", first + 2}});
}

}  // namespace cousin::imaging
