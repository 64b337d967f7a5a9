#include "sim/imaging/exif.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "sim/imaging/image_io.h"
#include "sim/imaging/image_size.h"
#include "sim/types/rng.h"
#include "tests/sim/dataset/temporary_folder.h"
#include "tests/sim/imaging/exif_bytes.h"

namespace cousin {
namespace {

std::vector<std::uint8_t> small_jpeg() { return encode_jpeg(Image<Rgb8>(24, 16, {9, 8, 7}), 90); }

ExifWriter phone(ByteOrder order) {
  ExifWriter writer(order);
  writer.add_text(0x010F, "Acme");
  writer.add_text(0x0110, "Acme One ");
  writer.add_short(false, 0x0112, 6);
  writer.add_ratio(true, 0x920A, 425, 100);
  writer.add_short(true, 0xA405, 26);
  writer.add_long(true, 0xA002, 4032);
  writer.add_short(true, 0xA003, 3024);
  writer.add_ratio(true, 0xA20E, 18143, 1);
  writer.add_short(true, 0xA210, 2);
  return writer;
}

TEST(Exif, BothByteOrdersGiveTheTags) {
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    const ExifTags tags = exif_tags(with_exif(small_jpeg(), phone(order).block()));
    EXPECT_EQ(tags.orientation, 6);
    EXPECT_EQ(tags.focal_length_mm, 4.25);
    EXPECT_EQ(tags.focal_length_35mm_mm, 26);
    EXPECT_EQ(tags.imager_pixels_per_mm, 18143 / 25.4);
    EXPECT_EQ(tags.width_px, 4032);
    EXPECT_EQ(tags.height_px, 3024);
    EXPECT_EQ(tags.camera, "Acme One");
  }
}

TEST(Exif, ThePictureIsReadAsItIsStored) {
  const std::vector<std::uint8_t> turned =
      with_exif(small_jpeg(), phone(ByteOrder::little).block());
  EXPECT_EQ(decode_jpeg(turned), decode_jpeg(small_jpeg()));
}

TEST(Exif, FilesWithoutABlockHaveNoTags) {
  for (const std::vector<std::uint8_t>& bytes :
       {small_jpeg(), encode_png(Image<Rgb8>(3, 2)), std::vector<std::uint8_t>{}}) {
    const ExifTags tags = exif_tags(bytes);
    EXPECT_EQ(tags.orientation, 1);
    EXPECT_FALSE(tags.focal_length_mm);
    EXPECT_EQ(tags.camera, "");
  }
}

TEST(Exif, NumbersThatAreNoneAreAbsent) {
  ExifWriter writer(ByteOrder::big);
  writer.add_short(false, 0x0112, 9);
  writer.add_ratio(true, 0x920A, 5, 0);
  writer.add_short(true, 0xA405, 0);
  writer.add_long(true, 0xA002, 4000000000U);
  writer.add_ratio(true, 0xA20E, 100, 1);
  writer.add_long(true, 0xA210, 4000000000U);
  const ExifTags tags = exif_tags(with_exif(small_jpeg(), writer.block()));
  EXPECT_EQ(tags.orientation, 1);
  EXPECT_FALSE(tags.focal_length_mm);
  EXPECT_FALSE(tags.focal_length_35mm_mm);
  EXPECT_FALSE(tags.width_px);
  EXPECT_FALSE(tags.imager_pixels_per_mm);
}

/// Under sanitizers this finds any read beyond the block.
TEST(Exif, CutAndChangedBlocksAreReadWithinTheirBounds) {
  const std::vector<std::uint8_t> whole = with_exif(small_jpeg(), phone(ByteOrder::little).block());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const ExifTags tags = exif_tags({whole.data(), size});
    EXPECT_TRUE(tags.orientation == 1 || tags.orientation == 6);
  }
  Rng rng(5);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> changed = whole;
    for (int k = 0; k < 4; ++k)
      changed[rng() % changed.size()] = static_cast<std::uint8_t>(rng() & 255);
    const ExifTags tags = exif_tags(changed);
    EXPECT_TRUE(tags.orientation >= 1 && tags.orientation <= 8);
  }
}

TEST(Exif, EveryOrientationHasItsWords) {
  EXPECT_EQ(orientation_text(1), "nothing");
  EXPECT_EQ(orientation_text(3), "turns it by 180 degrees");
  EXPECT_EQ(orientation_text(6), "turns it by 90 degrees clockwise");
  EXPECT_EQ(orientation_text(0), "nothing");
  EXPECT_EQ(orientation_text(99), "nothing");
}

TEST(ImageSize, IsThatOfThePixels) {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, const std::vector<std::uint8_t>& bytes) {
    std::ofstream(folder.path() / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return folder.path() / name;
  };
  const auto jpeg = write("a.jpg", with_exif(small_jpeg(), phone(ByteOrder::big).block()));
  const auto png = write("a.png", encode_png(Image<Rgb8>(5, 7)));
  EXPECT_EQ(read_image_size(jpeg).width_px, 24);
  EXPECT_EQ(read_image_size(jpeg).height_px, 16);
  EXPECT_EQ(read_image_size(png).width_px, 5);
  EXPECT_EQ(read_image_size(png).height_px, 7);
  EXPECT_EQ(read_exif(jpeg).orientation, 6);
  EXPECT_FALSE(has_alpha(png));
  EXPECT_NE(error_of([&] {
              read_image_size(write("no.png", {1, 2, 3}));
            }).find("no.png: neither"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              read_image_size(write("cut.jpg", {0xFF, 0xD8, 0xFF, 0xE0}));
            }).find("cut.jpg: JPEG: truncated"),
            std::string::npos);
}

}  // namespace
}  // namespace cousin
