#include "sim/dataset/exr_vectors.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <array>
#include <cstring>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

constexpr std::array<const char*, 3> kChannels = {"X", "Y", "Z"};
static_assert(sizeof(Eigen::Vector3f) == 12);

class MemoryOut : public Imf::OStream {
 public:
  MemoryOut() : Imf::OStream("memory") {}
  void write(const char* bytes, int count) override {
    const std::size_t end = at_ + static_cast<std::size_t>(count);
    if (bytes_.size() < end) bytes_.resize(end);
    std::memcpy(bytes_.data() + at_, bytes, static_cast<std::size_t>(count));
    at_ = end;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

class MemoryIn : public Imf::IStream {
 public:
  explicit MemoryIn(const std::string& bytes) : Imf::IStream("memory"), bytes_(bytes) {}
  bool read(char* out, int count) override {
    const auto wanted = static_cast<std::size_t>(count);
    if (at_ > bytes_.size() || bytes_.size() - at_ < wanted)
      throw std::runtime_error("the file is truncated");
    std::memcpy(out, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

/// Slices of the image's memory; `base` is where pixel (0, 0) of the file's coordinates lies.
Imf::FrameBuffer frame_buffer(char* base, int width) {
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < 3; ++c) {
    buffer.insert(kChannels[c],
                  Imf::Slice(Imf::FLOAT, base + 4 * c, 12, 12 * static_cast<std::size_t>(width)));
  }
  return buffer;
}

}  // namespace

void write_exr_vectors(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image) {
  Imf::Header header(image.width(), image.height());
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const char* channel : kChannels) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  MemoryOut stream;
  {
    Imf::OutputFile out(stream, header);
    out.setFrameBuffer(frame_buffer(
        reinterpret_cast<char*>(const_cast<Eigen::Vector3f*>(image.data())), image.width()));
    out.writePixels(image.height());
  }  // the destructor writes the line offsets
  write_file(file, stream.bytes());
}

Image<Eigen::Vector3f> read_exr_vectors(const std::filesystem::path& file) {
  const std::string bytes = read_file(file, std::size_t{1} << 33);
  try {
    MemoryIn stream(bytes);
    Imf::InputFile in(stream);
    const Imath::Box2i window = in.header().dataWindow();
    const auto width = static_cast<std::int64_t>(window.max.x) - window.min.x + 1;
    const auto height = static_cast<std::int64_t>(window.max.y) - window.min.y + 1;
    if (width < 1 || height < 1 || width > 65535 || height > 65535 ||
        width * height > (std::int64_t{1} << 28)) {
      throw std::runtime_error("the size is outside 1..65535 a side and 2^28 pixels");
    }
    if (window.min.x != 0 || window.min.y != 0)
      throw std::runtime_error("the data window does not start at 0, 0");
    for (const char* name : kChannels) {
      const Imf::Channel* channel = in.header().channels().findChannel(name);
      if (channel == nullptr || channel->type != Imf::FLOAT || channel->xSampling != 1 ||
          channel->ySampling != 1) {
        throw std::runtime_error(std::string("lacks the 32-bit float channel ") + name);
      }
    }
    Image<Eigen::Vector3f> image(static_cast<int>(width), static_cast<int>(height),
                                 Eigen::Vector3f::Zero());
    in.setFrameBuffer(frame_buffer(reinterpret_cast<char*>(image.data()), image.width()));
    in.readPixels(0, image.height() - 1);
    return image;
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace cousin
