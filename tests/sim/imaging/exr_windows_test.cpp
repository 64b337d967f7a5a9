#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfEnvmapAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/imaging/exr_size.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// What a pixel of the display window at (x, y) holds.
float value_at(int x, int y) { return static_cast<float>(100 * y + x + 1); }

Imath::Box2i box(int left, int top, int right, int bottom) {
  return {Imath::V2i(left, top), Imath::V2i(right, bottom)};
}

/// One part of a file to be written: its windows, its channels, all with the same numbers.
struct Part {
  Imath::Box2i display = box(0, 0, 7, 3), data = box(0, 0, 7, 3);
  std::vector<std::string> channels = {"R", "G", "B"};
  Imf::PixelType type = Imf::FLOAT;
  std::string name = "part";

  Imf::Header header() const {
    Imf::Header h(display, data);
    h.setName(name);
    for (const std::string& channel : channels) h.channels().insert(channel, Imf::Channel(type));
    return h;
  }
  int width() const { return data.max.x - data.min.x + 1; }
  int height() const { return data.max.y - data.min.y + 1; }
  /// Calls write(buffer) with the pixels.
  void pixels(const std::function<void(const Imf::FrameBuffer&)>& write) const {
    std::vector<float> floats;
    std::vector<half> halves;
    std::vector<unsigned> wholes;
    for (int y = data.min.y; y <= data.max.y; ++y) {
      for (int x = data.min.x; x <= data.max.x; ++x) {
        floats.push_back(value_at(x, y));
        halves.emplace_back(value_at(x, y));
        wholes.push_back(static_cast<unsigned>(value_at(x, y)));
      }
    }
    void* first = floats.data();
    std::size_t size = sizeof(float);
    if (type == Imf::HALF) {
      first = halves.data();
      size = sizeof(half);
    } else if (type == Imf::UINT) {
      first = wholes.data();
    }
    Imf::FrameBuffer buffer;
    for (const std::string& channel : channels)
      buffer.insert(channel, Imf::Slice::Make(type, first, data, size));
    write(buffer);
  }
};

class ExrWindows : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("cousin_exr_windows_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    file_ = folder_ / "a.exr";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const Part& part, const std::function<void(Imf::Header&)>& change = {}) const {
    Imf::Header header = part.header();
    if (change) change(header);
    Imf::OutputFile out(file_.c_str(), header);
    part.pixels([&](const Imf::FrameBuffer& buffer) {
      out.setFrameBuffer(buffer);
      out.writePixels(part.height());
    });
  }
  void write_parts(const std::vector<Part>& parts) const {
    std::vector<Imf::Header> headers;
    for (const Part& part : parts) {
      headers.push_back(part.header());
      headers.back().setType("scanlineimage");
    }
    Imf::MultiPartOutputFile out(file_.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
      const Part& part = parts[static_cast<std::size_t>(i)];
      Imf::OutputPart one(out, i);
      part.pixels([&](const Imf::FrameBuffer& buffer) {
        one.setFrameBuffer(buffer);
        one.writePixels(part.height());
      });
    }
  }
  std::string color_error() const {
    try {
      read_exr_color(file_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  std::string depth_error() const {
    try {
      read_exr(file_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_, file_;
};

TEST_F(ExrWindows, ASmallerDataWindowIsPutInItsPlaceInTheDark) {
  write({.data = box(4, 1, 6, 2)});
  const Image<Rgbf> image = read_exr_color(file_);
  ASSERT_EQ(image.width(), 8);
  ASSERT_EQ(image.height(), 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      const bool inside = x >= 4 && x <= 6 && y >= 1 && y <= 2;
      EXPECT_EQ(image(x, y).g, inside ? value_at(x, y) : 0) << x << " " << y;
    }
  }
}

TEST_F(ExrWindows, ALargerDataWindowIsCutToWhatIsShown) {
  write({.display = box(2, 1, 5, 2), .data = box(-3, -2, 9, 7)});
  const Image<Rgbf> image = read_exr_color(file_);
  ASSERT_EQ(image.width(), 4);
  ASSERT_EQ(image.height(), 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) EXPECT_EQ(image(x, y).b, value_at(x + 2, y + 1));
}

TEST_F(ExrWindows, WhatIsNotThereOfADepthIsNoMeasurement) {
  write({.data = box(6, 2, 9, 9), .channels = {"Z"}});
  const Image<float> depth_m = read_exr(file_);
  ASSERT_EQ(depth_m.width(), 8);
  EXPECT_TRUE(std::isnan(depth_m(5, 3)));
  EXPECT_EQ(depth_m(7, 3), value_at(7, 3));
}

TEST_F(ExrWindows, ADataWindowBesideTheDisplayWindowIsRefusedWithBoth) {
  write({.data = box(8, 0, 15, 3)});
  EXPECT_THAT(color_error(), AllOf(HasSubstr("a.exr"), HasSubstr("(8, 0) to (15, 3)"),
                                   HasSubstr("(0, 0) to (7, 3)")));
}

TEST_F(ExrWindows, ChannelsAreChosenByNameNeverByOrder) {
  write({.channels = {"A", "Z"}});
  EXPECT_EQ(read_exr(file_)(3, 2), value_at(3, 2));
  write({.channels = {"depth"}});
  EXPECT_EQ(read_exr(file_)(3, 2), value_at(3, 2));
  write({.channels = {"A", "N.X"}});
  EXPECT_THAT(depth_error(), AllOf(HasSubstr("lacks the channel Z"), HasSubstr("A, N.X")));
  EXPECT_THAT(color_error(), AllOf(HasSubstr("R, G, B or Y"), HasSubstr("A, N.X")));
}

TEST_F(ExrWindows, LuminanceIsGreyAndChromaIsRefused) {
  write({.channels = {"Y"}});
  EXPECT_EQ(read_exr_color(file_)(3, 2), (Rgbf{value_at(3, 2), value_at(3, 2), value_at(3, 2)}));
  write({.channels = {"BY", "RY", "Y"}});
  EXPECT_THAT(color_error(), HasSubstr("luminance and chroma"));
}

TEST_F(ExrWindows, HalfFloatsAreReadAndWholeNumbersRefused) {
  write({.type = Imf::HALF});
  EXPECT_EQ(read_exr_color(file_)(3, 2).r, value_at(3, 2));
  write({.channels = {"Z"}, .type = Imf::UINT});
  EXPECT_THAT(depth_error(), AllOf(HasSubstr("channel Z"), HasSubstr("uint")));
}

TEST_F(ExrWindows, TilesAreRead) {
  const Part part{.data = box(1, 1, 6, 3)};
  Imf::Header header = part.header();
  header.setTileDescription(Imf::TileDescription(4, 4));
  {
    Imf::TiledOutputFile out(file_.c_str(), header);
    part.pixels([&](const Imf::FrameBuffer& buffer) {
      out.setFrameBuffer(buffer);
      out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
    });
  }
  const Image<Rgbf> image = read_exr_color(file_);
  EXPECT_EQ(image(6, 3).r, value_at(6, 3));
  EXPECT_EQ(image(7, 3).r, 0);
}

TEST_F(ExrWindows, OfSeveralPartsTheOneWithTheChannelsIsRead) {
  write_parts({{.channels = {"A"}, .name = "alpha"}, {.data = box(2, 2, 5, 3), .name = "light"}});
  EXPECT_EQ(read_exr_color(file_)(5, 3).r, value_at(5, 3));
  EXPECT_EQ(read_exr_color(file_)(0, 0).r, 0);
  write_parts({{.name = "left"}, {.name = "right"}});
  EXPECT_THAT(color_error(), HasSubstr("2 of its 2 parts"));
}

TEST_F(ExrWindows, KeysThatChangeTheMeaningAreRefusedByName) {
  write({}, [](Imf::Header& h) { h.pixelAspectRatio() = 2; });
  EXPECT_THAT(color_error(), HasSubstr("pixelAspectRatio 2"));
  write({}, [](Imf::Header& h) { h.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_CUBE)); });
  EXPECT_THAT(color_error(), HasSubstr("envmap is a cube"));
  Imf::Chromaticities aces;
  aces.red = {0.7347F, 0.2653F};
  write({},
        [&](Imf::Header& h) { h.insert("chromaticities", Imf::ChromaticitiesAttribute(aces)); });
  EXPECT_THAT(color_error(), HasSubstr("chromaticities"));
  write({}, [](Imf::Header& h) {
    h.insert("chromaticities", Imf::ChromaticitiesAttribute(Imf::Chromaticities()));
    h.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_LATLONG));
  });
  EXPECT_EQ(color_error(), "");
}

TEST_F(ExrWindows, SizesAreThoseOfTheLargestWindow) {
  write({.display = box(0, 0, 99, 49), .data = box(0, 0, 0, 0)});
  EXPECT_EQ(exr_pixels(file_), 5000U);
  write({.display = box(0, 0, 0, 0), .data = box(0, 0, 7, 3)});
  EXPECT_EQ(exr_pixels(file_), 32U);
  write_parts({{.name = "small"}, {.data = box(0, 0, 19, 9), .name = "large"}});
  EXPECT_EQ(exr_pixels(file_), 200U);
}

}  // namespace
}  // namespace cousin
