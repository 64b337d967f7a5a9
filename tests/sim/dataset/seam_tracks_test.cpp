// tracks.json: all comes back, and what cannot be is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/seam_json.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

void expect_refused_tracks(const std::string& track, const std::string& where,
                           const std::string& why) {
  EXPECT_THAT([&] { tracks_from_json(R"({"tracks": [)" + track + "]}", "tracks.json"); },
              testing::ThrowsMessage<std::runtime_error>(
                  AllOf(HasSubstr("tracks.json: /tracks/" + where), HasSubstr(why))))
      << track;
}

TEST(SeamTracks, TracksComeBack) {
  Track placed;
  placed.id = 3;
  placed.boxes = {4, 9, 17};
  placed.centre_in_world_m = {0.25, -1.5, 1.125};
  placed.covariance_m2 << 4e-4, 1e-5, 0, 1e-5, 9e-4, 0, 0, 0, 1e-4;
  Track bare;
  bare.id = 4;
  const Tracks tracks = tracks_from_json(tracks_to_json({placed, bare}), "tracks.json");
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_EQ(tracks[0].id, 3);
  EXPECT_EQ(tracks[0].boxes, placed.boxes);
  EXPECT_EQ(tracks[0].centre_in_world_m, placed.centre_in_world_m);
  EXPECT_EQ(tracks[0].covariance_m2, placed.covariance_m2);
  EXPECT_TRUE(tracks[1].boxes.empty());
  EXPECT_TRUE(tracks[1].centre_in_world_m.array().isNaN().all());
  EXPECT_EQ(tracks[1].covariance_m2.norm(), 0);
}

TEST(SeamTracks, WhatCannotBeIsRefusedByItsPlace) {
  expect_refused_tracks(R"({"id": -1, "boxes": []})", "0/id", "-1");
  expect_refused_tracks(R"({"id": 1, "boxes": [2]}, {"id": 1, "boxes": []})", "1/id", "twice");
  expect_refused_tracks(R"({"id": 1, "boxes": [2]}, {"id": 2, "boxes": [2]})", "1/boxes/0",
                        "two tracks");
  expect_refused_tracks(R"({"id": 1, "boxes": [], "centre_in_world_m": [1, 2]})",
                        "0/centre_in_world_m", "3 numbers");
  expect_refused_tracks(R"({"id": 1, "boxes": [], "covariance_m2": [1, 0, 0, 0, -1, 0, 0, 0, 1]})",
                        "0/covariance_m2", "negative");
  expect_refused_tracks(R"({"id": 1, "boxes": [], "frames": [1]})", "0", "frames");
}

}  // namespace
}  // namespace cousin
