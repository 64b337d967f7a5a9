#include "sim/dataset/colmap_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/sim/dataset/colmap_bytes.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// Two photographs, numbered against their names' order, and two points.
ColmapTracks small_tracks() {
  ColmapTracks tracks;
  tracks.model.cameras[3] = {.width_px = 20,
                             .height_px = 12,
                             .fx_px = 30,
                             .fy_px = 31,
                             .cx_px = 9.5,
                             .cy_px = 5.5,
                             .distortion = {},
                             .spline = {}};
  tracks.model.images[7] = {"a.png", 3, Pose{}};
  tracks.model.images[2] = {"b.png", 3, Pose{Eigen::Quaterniond::Identity(), {0.1, 0, 0}}};
  tracks.points.push_back({{0.1, 0.2, 3}, {1, 2, 3}, 0.25, {{7, {4, 5}}, {2, {3, 5.25}}}});
  tracks.points.push_back({{-0.1, 0.2, 4}, {255, 0, 9}, -1, {{2, {0, 0}}}});
  return tracks;
}

ColmapTracks read(const ColmapFiles& files) { return colmap_tracks_from_binary(files, "m"); }

TEST(ColmapTracks, PointsAndTheirSightingsReadBack) {
  const ColmapTracks tracks = small_tracks(), back = read(colmap_bytes(tracks));
  ASSERT_EQ(back.points.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back.points[i].in_world, tracks.points[i].in_world);
    EXPECT_EQ(back.points[i].color, tracks.points[i].color);
    EXPECT_EQ(back.points[i].error_px, tracks.points[i].error_px);
    ASSERT_EQ(back.points[i].sightings.size(), tracks.points[i].sightings.size());
    for (std::size_t k = 0; k < back.points[i].sightings.size(); ++k) {
      EXPECT_EQ(back.points[i].sightings[k].image, tracks.points[i].sightings[k].image);
      EXPECT_EQ(back.points[i].sightings[k].pixel_px, tracks.points[i].sightings[k].pixel_px);
    }
  }
  EXPECT_EQ(back.model.images.at(7).name, "a.png");
}

TEST(ColmapTracks, PixelsCountFromTheFirstPixelsCentre) {
  // COLMAP's (0.5, 0.5) is the middle of the first pixel.
  ColmapTracks tracks = small_tracks();
  const ColmapFiles files = colmap_bytes(tracks);
  std::string half;
  append(half, 0.5);
  EXPECT_THAT(files.images, HasSubstr(half + half));
  EXPECT_EQ(read(files).points[1].sightings[0].pixel_px, Eigen::Vector2d(0, 0));
}

TEST(ColmapTracks, EveryCutOfTheFilesIsAnErrorThatNamesTheFile) {
  const ColmapFiles whole = colmap_bytes(small_tracks());
  for (std::size_t size = 0; size < whole.points.size(); ++size) {
    ColmapFiles cut = whole;
    cut.points.resize(size);
    EXPECT_THAT(error_of([&] { read(cut); }), HasSubstr("m/points3D.bin: byte ")) << size;
  }
  for (std::size_t size = 0; size < whole.images.size(); ++size) {
    ColmapFiles cut = whole;
    cut.images.resize(size);
    EXPECT_THAT(error_of([&] { read(cut); }), HasSubstr("m/images.bin: byte ")) << size;
  }
}

/// The files with one number of points3D.bin set.
template <class Number>
std::string error_with(std::size_t place, Number value) {
  ColmapFiles files = colmap_bytes(small_tracks());
  std::string raw;
  append(raw, value);
  files.points.replace(place, raw.size(), raw);
  return error_of([&] { read(files); });
}

TEST(ColmapTracks, WhatATrackNamesMustExist) {
  // Counts 8, then id 8, place 24, colour 3, error 8, sightings 8, image 4, index 4.
  constexpr std::size_t kPlace = 16, kError = 43, kCount = 51, kImage = 59, kIndex = 63;
  EXPECT_THAT(error_with(kImage, std::int32_t{8}), HasSubstr("image 8 is not in the file"));
  EXPECT_THAT(error_with(kIndex, std::int32_t{1}), HasSubstr("point 1 of image 7, which has 1"));
  EXPECT_THAT(error_with(kIndex, std::int32_t{-1}), HasSubstr("point -1 of image 7"));
  EXPECT_THAT(error_with(kPlace, std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("the point is not finite"));
  EXPECT_THAT(error_with(kError, std::numeric_limits<double>::infinity()),
              HasSubstr("its error is not finite"));
  EXPECT_THAT(error_with(kCount, std::uint64_t{1} << 60),
              HasSubstr("the count 1152921504606846976 needs more bytes"));
  EXPECT_THAT(error_with(std::size_t{0}, std::uint64_t{1} << 60), HasSubstr("needs more bytes"));
  EXPECT_THAT(error_with(std::size_t{8}, std::uint64_t{2}), HasSubstr("point 2 occurs twice"));
}

}  // namespace
}  // namespace cousin
