#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfEnvmapAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"
#include "sim/types/memory_limit.h"

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

struct Size {
  int width = 0, height = 0;
};

Size size_of(const Imath::Box2i& window, const char* what) {
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  check_image_size(what, static_cast<std::uint64_t>(std::max<std::int64_t>(width, 0)),
                   static_cast<std::uint64_t>(std::max<std::int64_t>(height, 0)));
  return {static_cast<int>(width), static_cast<int>(height)};
}

std::string text_of(const Imath::Box2i& w) {
  return "(" + std::to_string(w.min.x) + ", " + std::to_string(w.min.y) + ") to (" +
         std::to_string(w.max.x) + ", " + std::to_string(w.max.y) + ")";
}

std::string names_of(const Imf::ChannelList& channels) {
  std::string names;
  for (auto c = channels.begin(); c != channels.end(); ++c)
    names += (names.empty() ? "" : ", ") + std::string(c.name());
  return names;
}

/// The channels that were asked for, of several choices the first that is there, whole.
std::vector<std::string> chosen(const Imf::ChannelList& channels,
                                const std::vector<std::vector<std::string>>& choices) {
  for (const std::vector<std::string>& names : choices) {
    const auto is_there = [&](const std::string& n) { return channels.findChannel(n) != nullptr; };
    if (names.empty()) {  // the only one, whatever its name
      const auto first = channels.begin();
      if (first != channels.end() && ++channels.begin() == channels.end()) return {first.name()};
    } else if (std::all_of(names.begin(), names.end(), is_there)) {
      return names;
    }
  }
  return {};
}

/// Keys that change what numbers mean or where pixels lie.
void check_meaning(const Imf::Header& header) {
  const float aspect = header.pixelAspectRatio();
  if (!(std::abs(aspect - 1) < 1e-3F))
    throw std::runtime_error("pixelAspectRatio " + std::to_string(aspect) + "; expected 1");
  const auto* map = header.findTypedAttribute<Imf::EnvmapAttribute>("envmap");
  if (map && map->value() != Imf::ENVMAP_LATLONG)
    throw std::runtime_error("envmap is a cube; expected latitude and longitude");
  const auto* primaries = header.findTypedAttribute<Imf::ChromaticitiesAttribute>("chromaticities");
  if (!primaries) return;
  const Imf::Chromaticities& given = primaries->value();
  const Imf::Chromaticities srgb;  // of Rec. 709
  const auto is_near = [](const Imath::V2f& a, const Imath::V2f& b) {
    return (a - b).length() < 0.005F;
  };
  if (!is_near(given.red, srgb.red) || !is_near(given.green, srgb.green) ||
      !is_near(given.blue, srgb.blue) || !is_near(given.white, srgb.white))
    throw std::runtime_error("chromaticities are not those of Rec. 709 (sRGB), which are expected");
}

void check_channel(const Imf::ChannelList& channels, const std::string& name) {
  const Imf::Channel& channel = *channels.findChannel(name);
  if (channel.xSampling != 1 || channel.ySampling != 1)
    throw std::runtime_error("channel " + name + " is subsampled; expected one value a pixel");
  if (channel.type == Imf::UINT)
    throw std::runtime_error("channel " + name + " is of whole numbers (uint); expected float");
  if (name == "Y" && (channels.findChannel("RY") || channels.findChannel("BY")))
    throw std::runtime_error("channels Y, RY, BY are luminance and chroma; expected R, G, B");
}

/// What lies of a data window in its place in the display window.
Image<float> placed(const Image<float>& data, const Imath::Box2i& from, const Imath::Box2i& window,
                    Size size, float fill) {
  Image<float> image(size.width, size.height, fill);
  const int left = std::max(from.min.x, window.min.x), right = std::min(from.max.x, window.max.x);
  const int top = std::max(from.min.y, window.min.y), bottom = std::min(from.max.y, window.max.y);
  for (int y = top; y <= bottom; ++y) {
    const float* first = data.row(y - from.min.y).data() + (left - from.min.x);
    std::copy(first, first + (right - left + 1),
              image.row(y - window.min.y).data() + (left - window.min.x));
  }
  return image;
}

/// Of an Imf::InputFile or an Imf::InputPart.
template <class File>
std::vector<Image<float>> read_channels(File& file, const std::vector<std::string>& names,
                                        std::size_t file_bytes, const std::string& name,
                                        float fill) {
  const Imf::Header& header = file.header();
  check_meaning(header);
  const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
  const Size size = size_of(data, "data window"), picture = size_of(display, "display window");
  const std::uint64_t pixels = std::uint64_t(size.width) * std::uint64_t(size.height);
  // Every compression shrinks a constant image less than this.
  if (pixels / 2048 > file_bytes) {
    throw std::runtime_error("truncated: " + std::to_string(file_bytes) + " bytes cannot hold " +
                             std::to_string(size.width) + " x " + std::to_string(size.height) +
                             " pixels");
  }
  const bool is_whole = data == display;
  if (!is_whole && !data.intersects(display)) {
    throw std::runtime_error("the data window " + text_of(data) +
                             " lies outside of the display window " + text_of(display));
  }
  const std::uint64_t shown = std::uint64_t(picture.width) * std::uint64_t(picture.height);
  check_memory(name, (pixels + 2 * shown) * sizeof(float) * names.size(),
               std::to_string(names.size()) + " channels of " + std::to_string(picture.width) +
                   " x " + std::to_string(picture.height) + " pixels");
  std::vector<Image<float>> images;
  Imf::FrameBuffer buffer;
  for (const std::string& channel : names) {
    check_channel(header.channels(), channel);
    images.emplace_back(size.width, size.height);
    buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, images.back().data(), data));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(data.min.y, data.max.y);
  if (is_whole) return images;
  for (Image<float>& image : images) image = placed(image, data, display, picture, fill);
  return images;
}

[[noreturn]] void fail_lacking(const std::vector<std::vector<std::string>>& choices,
                               const std::string& there) {
  std::string wanted;
  for (const std::vector<std::string>& names : choices) {
    if (names.empty()) continue;
    wanted += wanted.empty() ? "" : " or ";
    for (std::size_t i = 0; i < names.size(); ++i) wanted += (i > 0 ? ", " : "") + names[i];
  }
  throw std::runtime_error("lacks the channel " + wanted + "; there are: " + there);
}

/// Channels by the first choice that the file has.
std::vector<Image<float>> decode(std::span<const std::uint8_t> bytes, const std::string& name,
                                 const std::vector<std::vector<std::string>>& choices, float fill) {
  Imf::Header::setMaxImageSize(65535, 65535);
  // The version's flags [OpenEXR File Layout]: bit 11 deep data, bit 12 several parts.
  const unsigned flags = bytes.size() > 5 ? bytes[5] : 0;
  if ((flags & 0x08U) != 0) throw std::runtime_error("deep data; expected one value a pixel");
  MemoryIn in(bytes, name);
  if ((flags & 0x10U) == 0) {
    Imf::InputFile file(in);
    const std::vector<std::string> names = chosen(file.header().channels(), choices);
    if (names.empty()) fail_lacking(choices, names_of(file.header().channels()));
    return read_channels(file, names, bytes.size(), name, fill);
  }
  Imf::MultiPartInputFile file(in);
  std::vector<int> parts;
  std::string there;
  for (int i = 0; i < file.parts(); ++i) {
    if (!chosen(file.header(i).channels(), choices).empty()) parts.push_back(i);
    there += (i > 0 ? "; " : "") + names_of(file.header(i).channels());
  }
  if (parts.empty()) fail_lacking(choices, there);
  if (parts.size() > 1) {
    throw std::runtime_error(std::to_string(parts.size()) + " of its " +
                             std::to_string(file.parts()) +
                             " parts have the channels; expected one that has");
  }
  Imf::InputPart part(file, parts.front());
  const std::vector<std::string> names = chosen(part.header().channels(), choices);
  return read_channels(part, names, bytes.size(), name, fill);
}

}  // namespace

std::vector<Image<float>> decode_exr(std::span<const std::uint8_t> bytes, const std::string& name,
                                     const std::vector<std::vector<std::string>>& choices,
                                     float fill) {
  try {
    return decode(bytes, name, choices, fill);
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
