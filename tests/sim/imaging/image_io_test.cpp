#include "sim/imaging/image_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/types/rng.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ImageIo : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("cousin_image_io_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::vector<std::uint8_t>& bytes) const {
    fs::remove(folder_ / name);  // ext4 flushes a file that is cut and written again
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return folder_ / name;
  }
  std::vector<std::uint8_t> bytes_of(const fs::path& file) const {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
};

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

Image<Rgb8> noise(int width, int height) {
  Image<Rgb8> image(width, height);
  Rng rng(3);
  for (Rgb8& p : image) {
    const std::uint64_t bits = rng();
    p = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
         static_cast<std::uint8_t>(bits >> 16)};
  }
  return image;
}

/// A smooth picture: what JPEG is made for.
Image<Rgb8> gradient(int width, int height) {
  Image<Rgb8> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(x * 255 / width),
                     static_cast<std::uint8_t>(y * 255 / height), 90};
    }
  }
  return image;
}

TEST_F(ImageIo, PngsRoundTrip) {
  const Image<Rgb8> color = noise(37, 21);
  write_png(folder_ / "c.png", color);
  EXPECT_EQ(read_color(folder_ / "c.png"), color);
  Image<std::uint8_t> grey(5, 3);
  Image<std::uint16_t> deep(5, 3);
  for (int i = 0; i < 15; ++i) {
    grey(i % 5, i / 5) = static_cast<std::uint8_t>(17 * i);
    deep(i % 5, i / 5) = static_cast<std::uint16_t>(4369 * i);
  }
  write_png(folder_ / "g.png", grey);
  write_png(folder_ / "d.png", deep);
  EXPECT_EQ(read_png8(folder_ / "g.png"), grey);
  EXPECT_EQ(read_png16(folder_ / "d.png"), deep);
}

TEST_F(ImageIo, GreyPngIsSpreadToColour) {
  write_png(folder_ / "g.png", Image<std::uint8_t>(4, 4, 77));
  EXPECT_EQ(read_color(folder_ / "g.png"), Image<Rgb8>(4, 4, Rgb8{77, 77, 77}));
  write_png(folder_ / "d.png", Image<std::uint16_t>(4, 4, 77 * 257));
  EXPECT_EQ(read_color(folder_ / "d.png"), Image<Rgb8>(4, 4, Rgb8{77, 77, 77}));
}

TEST_F(ImageIo, ExrKeepsEveryBitEvenNan) {
  Image<float> depth(19, 33);
  Rng rng(5);
  for (float& d : depth) d = static_cast<float>(uniform(rng, -1, 1));
  depth(0, 0) = std::numeric_limits<float>::quiet_NaN();
  depth(18, 32) = std::numeric_limits<float>::infinity();
  depth(3, 3) = std::numeric_limits<float>::denorm_min();
  write_exr(folder_ / "z.exr", depth);
  const Image<float> back = read_exr(folder_ / "z.exr");
  ASSERT_EQ(back.width(), 19);
  ASSERT_EQ(back.height(), 33);
  EXPECT_EQ(std::memcmp(back.data(), depth.data(), depth.size() * sizeof(float)), 0);
}

TEST_F(ImageIo, JpegOfASmoothPictureIsClose) {
  const Image<Rgb8> image = gradient(120, 80);
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, 95);
  EXPECT_EQ(encode_jpeg(image, 95), bytes);
  const Image<Rgb8> back = decode_jpeg(bytes);
  ASSERT_EQ(back.width(), 120);
  double sum = 0;
  for (std::size_t i = 0; i < image.size(); ++i)
    sum += std::abs(image.data()[i].r - back.data()[i].r);
  EXPECT_LT(sum / static_cast<double>(image.size()), 2);  // codes; chroma is stored at half size
  EXPECT_EQ(read_color(write("a.jpg", bytes)), back);
}

TEST_F(ImageIo, EncodedPngIsTheFile) {
  const Image<Rgb8> image = gradient(20, 10);
  write_png(folder_ / "a.png", image);
  EXPECT_EQ(bytes_of(folder_ / "a.png"), encode_png(image));
}

TEST_F(ImageIo, MissingAndForeignFilesAreNamed) {
  EXPECT_THAT(error_of([&] { read_color(folder_ / "none.png"); }),
              AllOf(HasSubstr("none.png"), HasSubstr("No such file")));
  EXPECT_THAT(error_of([&] { read_color(folder_); }), HasSubstr("not a regular file"));
  const fs::path text = write("text.png", {'h', 'e', 'l', 'l', 'o', ' ', 'w', 'o', 'r', 'l', 'd'});
  EXPECT_THAT(error_of([&] { read_color(text); }), HasSubstr("text.png: neither a PNG nor a JPEG"));
  EXPECT_THAT(error_of([&] { read_png8(text); }), HasSubstr("text.png: not a PNG"));
  EXPECT_THAT(error_of([&] { read_exr(text); }), HasSubstr("text.png: EXR"));
  EXPECT_THAT(error_of([&] { read_color(write("empty.png", {})); }), HasSubstr("empty.png"));
}

TEST_F(ImageIo, AnotherKindOfPngIsAnError) {
  write_png(folder_ / "c.png", gradient(4, 4));
  write_png(folder_ / "d.png", Image<std::uint16_t>(4, 4, 9));
  EXPECT_THAT(error_of([&] { read_png8(folder_ / "c.png"); }),
              HasSubstr("8-bit colour PNG; expected 8-bit grey"));
  EXPECT_THAT(error_of([&] { read_png8(folder_ / "d.png"); }),
              HasSubstr("16-bit grey PNG; expected 8-bit grey"));
  EXPECT_THAT(error_of([&] { read_png16(folder_ / "c.png"); }), HasSubstr("expected 16-bit grey"));
}

TEST_F(ImageIo, EveryTruncationIsAnError) {
  write_png(folder_ / "a.png", noise(16, 16));
  write_exr(folder_ / "a.exr", Image<float>(16, 16, 0.5F));
  const std::vector<std::uint8_t> png = bytes_of(folder_ / "a.png"),
                                  exr = bytes_of(folder_ / "a.exr");
  const std::vector<std::uint8_t> jpeg = encode_jpeg(noise(16, 16), 90);
  const auto cut = [](const std::vector<std::uint8_t>& bytes, std::size_t size) {
    return std::vector<std::uint8_t>(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(size));
  };
  for (std::size_t size = 0; size < png.size(); ++size) {
    EXPECT_NE(error_of([&] { read_color(write("cut.png", cut(png, size))); }), "")
        << size << " bytes of PNG";
  }
  for (std::size_t size = 0; size < jpeg.size(); ++size) {
    EXPECT_NE(error_of([&] { decode_jpeg(cut(jpeg, size)); }), "") << size << " bytes of JPEG";
  }
  for (std::size_t size = 0; size < exr.size(); ++size) {
    EXPECT_NE(error_of([&] { read_exr(write("cut.exr", cut(exr, size))); }), "")
        << size << " bytes of EXR";
  }
}

TEST_F(ImageIo, FlippedBitsAreReadOrRefusedNeverMore) {
  write_exr(folder_ / "a.exr", Image<float>(16, 16, 0.5F));
  const std::vector<std::uint8_t> seeds[] = {
      encode_png(noise(12, 9)), encode_jpeg(noise(12, 9), 80), bytes_of(folder_ / "a.exr")};
  Rng rng(11);
  for (const auto& good : seeds) {
    for (int trial = 0; trial < 300; ++trial) {
      std::vector<std::uint8_t> bad = good;
      for (int flips = 0; flips < 4; ++flips)
        bad[uniform_index(rng, bad.size())] ^= 1U << uniform_index(rng, 8);
      const fs::path file = write("bad", bad);
      error_of([&] { read_color(file); });
      error_of([&] { read_exr(file); });
    }
  }
}

TEST_F(ImageIo, AHugeClaimIsRefusedBeforeMemoryIsTaken) {
  std::vector<std::uint8_t> jpeg = encode_jpeg(gradient(16, 16), 90);
  for (std::size_t i = 0; i + 9 < jpeg.size(); ++i) {
    if (jpeg[i] != 0xFF || jpeg[i + 1] != 0xC0) continue;
    for (const int k : {5, 7}) jpeg[i + static_cast<std::size_t>(k)] = 0x3F;  // 16 144 x 16 144
  }
  EXPECT_THAT(error_of([&] { decode_jpeg(jpeg); }), HasSubstr("cannot hold"));
  std::vector<std::uint8_t> png = encode_png(gradient(16, 16));
  png[16] = 0x7F;  // the width's highest byte; the checksum is wrong too, but neither allocates
  EXPECT_NE(error_of([&] { read_color(write("huge.png", png)); }), "");
}

TEST_F(ImageIo, EmptyImagesAndBadQualityAreTheCallersMistake) {
  EXPECT_THROW(write_png(folder_ / "e.png", Image<Rgb8>()), std::invalid_argument);
  EXPECT_THROW(write_exr(folder_ / "e.exr", Image<float>(0, 5)), std::invalid_argument);
  EXPECT_THROW(encode_jpeg(gradient(4, 4), 0), std::invalid_argument);
  EXPECT_THROW(encode_jpeg(gradient(4, 4), 101), std::invalid_argument);
  EXPECT_TRUE(fs::is_empty(folder_));
}

/// Files may not grow beyond `bytes` while this lives, which is how a full disk looks to a writer.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit small{bytes, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

TEST_F(ImageIo, AFullDiskIsAnErrorAndLeavesTheOldFile) {
  write_png(folder_ / "a.png", gradient(4, 4));
  const std::vector<std::uint8_t> before = bytes_of(folder_ / "a.png");
  std::string png_error, exr_error;
  {
    const SmallDisk disk(1000);
    png_error = error_of([&] { write_png(folder_ / "a.png", noise(64, 64)); });
    exr_error = error_of([&] {
      Image<float> depth(64, 64);
      Rng rng(1);
      for (float& d : depth) d = static_cast<float>(uniform(rng));
      write_exr(folder_ / "a.exr", depth);
    });
  }
  EXPECT_THAT(png_error, AllOf(HasSubstr("cannot write"), HasSubstr("a.png")));
  EXPECT_THAT(exr_error, AllOf(HasSubstr("cannot write"), HasSubstr("a.exr")));
  EXPECT_EQ(bytes_of(folder_ / "a.png"), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);  // nothing half-written
}

TEST_F(ImageIo, AFolderThatCannotBeMadeIsNamed) {
  write_png(folder_ / "a.png", gradient(4, 4));
  EXPECT_THAT(error_of([&] { write_png(folder_ / "a.png" / "b.png", gradient(4, 4)); }),
              HasSubstr("b.png"));
}

}  // namespace
}  // namespace cousin
