// Masks of other programs: COCO's run lengths and polygons as outlines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "sim/dataset/mask_codes.h"
#include "sim/dataset/seam_json.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string entry(const std::string& segmentation, const std::string& more = "") {
  return R"([{"image_id": 3, "category_id": 1, "score": 0.9, "instance_id": 5, "segmentation": )" +
         segmentation + more + "}]";
}

Silhouettes read(const std::string& segmentation, const MaskImages& images = {}) {
  return silhouettes_from_json(entry(segmentation), "masks.json", images);
}

std::string refusal(const std::string& segmentation, const std::string& more = "",
                    const MaskImages& images = {}) {
  return error_of([&] { silhouettes_from_json(entry(segmentation, more), "masks.json", images); });
}

/// Filled by the even-odd rule: whether a pixel's centre is inside.
Image<std::uint8_t> filled(const std::vector<OutlinePoint>& outline, int width, int height) {
  Image<std::uint8_t> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bool inside = false;
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const Eigen::Vector2d a = outline[i].pixel_px.cast<double>();
        const Eigen::Vector2d b = outline[(i + 1) % outline.size()].pixel_px.cast<double>();
        const double row = y + 1e-4;
        if ((a.y() > row) == (b.y() > row)) continue;
        if (a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) < x) inside = !inside;
      }
      if (inside) image(x, y) = 255;
    }
  }
  return image;
}

/// A disc of radius 9.3 px about (20.2, 15.4).
Image<std::uint8_t> disc() {
  Image<std::uint8_t> mask(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (std::hypot(x - 20.2, y - 15.4) < 9.3) mask(x, y) = 255;
    }
  }
  return mask;
}

std::string compressed(const Image<std::uint8_t>& mask) {
  return R"({"size": [30, 40], "counts": ")" + coco_run_lengths(mask, 0, 0, 40, 30) + "\"}";
}

std::string uncompressed(const Image<std::uint8_t>& mask) {
  std::string list;
  for (const std::int64_t run : runs_of_coco(coco_run_lengths(mask, 0, 0, 40, 30)))
    list += (list.empty() ? "" : ", ") + std::to_string(run);
  return R"({"size": [30, 40], "counts": [)" + list + "]}";
}

TEST(SeamMasks, RunLengthsGiveTheOutlineOfTheirPixels) {
  for (const std::string& text : {compressed(disc()), uncompressed(disc())}) {
    const Silhouettes masks = read(text);
    ASSERT_EQ(masks.size(), 1U);
    EXPECT_EQ(masks[0].frame, 3);
    EXPECT_EQ(masks[0].instance, 5);
    EXPECT_EQ(filled(masks[0].outline, 40, 30), disc());
    double sum = 0, squares = 0;
    int counted = 0;
    for (const OutlinePoint& point : masks[0].outline) {
      const Eigen::Vector2f from_middle = point.pixel_px - Eigen::Vector2f(20.2F, 15.4F);
      if (!point.on_object) continue;
      EXPECT_GT(point.normal.dot(from_middle.normalized()), 0.9F);
      EXPECT_NEAR(point.sigma_px, 1 / std::sqrt(12.0), 1e-5);
      const double off = from_middle.norm() - 9.3;
      sum += off;
      squares += off * off;
      ++counted;
    }
    EXPECT_GT(counted, 50);
    EXPECT_NEAR(sum / counted, 0, 0.1);             // rounded, not moved
    EXPECT_LT(std::sqrt(squares / counted), 0.45);  // half a pixel's diagonal at most 0.7
  }
}

TEST(SeamMasks, PartsAndHolesAreOneOutlineThatFillsTheVeryPixels) {
  Image<std::uint8_t> mask = disc();
  for (int y = 12; y < 17; ++y) {
    for (int x = 16; x < 22; ++x) mask(x, y) = 0;  // a hole
  }
  for (int y = 2; y < 6; ++y) {
    for (int x = 30; x < 37; ++x) mask(x, y) = 255;  // another part
  }
  const Silhouettes masks = read(compressed(mask));
  EXPECT_EQ(filled(masks[0].outline, 40, 30), mask);
  // Read back from our own file it is the same.
  const Silhouettes again = silhouettes_from_json(silhouettes_to_json(masks, 0), "again.json");
  EXPECT_EQ(filled(again[0].outline, 40, 30), mask);
  EXPECT_EQ(again[0].outline.size(), masks[0].outline.size());
}

TEST(SeamMasks, SeveralPolygonsAreWhatPycocotoolsFills) {
  // Two squares that overlap are their union; each covers the pixels whose centres it holds.
  const Silhouettes two =
      read("[[10, 10, 20, 10, 20, 20, 10, 20], [15, 15, 25, 15, 25, 25, 15, 25]]");
  Image<std::uint8_t> squares(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const bool a = x >= 10 && x < 20 && y >= 10 && y < 20;
      const bool b = x >= 15 && x < 25 && y >= 15 && y < 25;
      if (a || b) squares(x, y) = 255;
    }
  }
  EXPECT_EQ(filled(two[0].outline, 40, 30), squares);
}

TEST(SeamMasks, AnEmptyMaskIsAnEmptyOutline) {
  for (const char* nothing : {"[]", R"({"size": [30, 40], "counts": [1200]})"})
    EXPECT_TRUE(read(nothing)[0].outline.empty()) << nothing;
}

TEST(SeamMasks, ABorderOfTheImageIsNotTheObjects) {
  // All of a 4 x 3 image: every edge is the image's.
  const Silhouettes all = read(R"({"size": [3, 4], "counts": [0, 12]})");
  ASSERT_EQ(all[0].outline.size(), 14U + 1);
  for (const OutlinePoint& point : all[0].outline) EXPECT_FALSE(point.on_object);
}

TEST(SeamMasks, RunLengthsNameWhatIsWrong) {
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": [1199]})"),
              AllOf(HasSubstr("masks.json: /0/segmentation/counts"), HasSubstr("cover 1199 pixels"),
                    HasSubstr("1200")));
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": [1000, 300]})"), HasSubstr("run 1 is 300"));
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": [1000, -1, 201]})"),
              HasSubstr("/counts/1 = -1 is outside"));
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": "0 1"})"), HasSubstr("character 1"));
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": "o"})"), HasSubstr("ends within a run"));
  EXPECT_THAT(refusal(R"({"size": [30], "counts": [30]})"), HasSubstr("[height, width]"));
  EXPECT_THAT(refusal(R"({"size": [0, 40], "counts": [0]})"), HasSubstr("/size/0 = 0"));
  EXPECT_THAT(refusal(R"({"size": [65535, 65535], "counts": [0, 4294836225]})"),
              AllOf(HasSubstr("65535 x 65535"), HasSubstr("the limit is 67108864 pixels")));
  EXPECT_THAT(refusal(R"({"size": [30, 40], "counts": [1200], "mode": 1})"),
              HasSubstr("unknown key \"mode\""));
  EXPECT_THAT(refusal("null"), HasSubstr("/0/segmentation = null"));
}

TEST(SeamMasks, KeysThatChangeWhatAMaskIsAreRefused) {
  const std::string square = "[[0, 0, 4, 0, 4, 4]]";
  EXPECT_EQ(refusal(square, R"(, "iscrowd": 0, "sensor": 0, "area": 8, "attributes": {}, "id": 1)"),
            "");
  EXPECT_THAT(refusal(square, R"(, "iscrowd": 1)"), HasSubstr("marks a crowd"));
  EXPECT_THAT(refusal(square, R"(, "sensor": 1)"), HasSubstr("/0/sensor = 1"));
  EXPECT_THAT(refusal(square, R"(, "unit": "mm")"), HasSubstr("unknown key \"unit\""));
  EXPECT_THAT(refusal("[[1, 2, 3, 4]]"), HasSubstr("fewer than 3 points"));  // a box to COCO
  EXPECT_THAT(error_of([] {
                silhouettes_from_json(R"({"images": [], "annotations": [], "categories": []})",
                                      "masks.json");
              }),
              HasSubstr("COCO results, the list \"annotations\" alone"));
}

TEST(SeamMasks, MasksOfOtherImagesAreRefused) {
  MaskImages images{.scene = 0, .size_px = {{3, {40, 30}}}};
  EXPECT_EQ(refusal(compressed(disc()), "", images), "");
  images.size_px[3] = {80, 60};
  EXPECT_THAT(
      refusal(compressed(disc()), "", images),
      AllOf(HasSubstr("/0/segmentation/size"), HasSubstr("[30, 40]"), HasSubstr("[60, 80]")));
  images.size_px = {{4, {40, 30}}};
  EXPECT_THAT(refusal("[]", "", images), HasSubstr("frame 3, which the capture does not have"));
  images.scene = 1;
  EXPECT_THAT(refusal("[]", "", images), HasSubstr("of scene 0, not of scene 1"));
}

TEST(SeamMasks, TheOutlineOfOneMaskIsBoundedWhileItIsMade) {
  // A comb: every second column of 2,000 x 1,200 pixels.
  std::string runs;
  for (int x = 0; x < 2000; ++x) runs += (x > 0 ? "," : "") + std::string("1200");
  const std::string comb = R"({"size": [1200, 2000], "counts": [)" + runs + "]}";
  EXPECT_THAT(refusal(comb), HasSubstr("more than 1000000 pixel edges"));
  set_memory_limit(10'000'000);
  EXPECT_THAT(refusal(comb), HasSubstr("the outline of a mask would take"));
  set_memory_limit(0);
}

TEST(SeamMasks, ManyOutlinesAreBoundedByTheMemoryLimit) {
  std::string text = "[";
  for (int i = 0; i < 100; ++i) {
    text += std::string(i > 0 ? "," : "") + R"({"image_id": 0, "instance_id": )" +
            std::to_string(i) + R"(, "segmentation": {"size": [60000, 1], "counts": [0, 60000]}})";
  }
  set_memory_limit(10'000'000);
  EXPECT_THAT(error_of([&] { silhouettes_from_json(text + "]", "masks.json"); }),
              AllOf(HasSubstr("masks.json: the outlines of the masks would take"),
                    HasSubstr("the limit is 10000000 bytes")));
  set_memory_limit(0);
}

}  // namespace
}  // namespace cousin
