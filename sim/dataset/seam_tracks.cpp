// tracks.json
//   {"tracks": [{"id": 0, "boxes": [3, 17], "centre_in_world_m": [3] or null,
//                "covariance_m2": [3 x 3, row-major] or null}]}
// "boxes" are ids of boxes.json, each in one track alone. The last two keys may be absent.

#include <set>

#include "sim/dataset/json_covariance.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxTracks = 10'000'000;
constexpr std::size_t kMaxTrackBoxes = 1'000'000;  ///< of one track
constexpr int kMaxTrackId = 999'999'999;           ///< the tree's own entry comes behind
constexpr int kMaxTrackBoxId = 2'000'000'000;      ///< as of boxes.json

Track read_track(const JsonNode& node, std::set<int>& ids, std::set<int>& boxes) {
  node.expect_keys({"id", "boxes"}, {"centre_in_world_m", "covariance_m2"});
  Track track;
  track.id = static_cast<int>(node["id"].integer(0, kMaxTrackId));
  if (!ids.insert(track.id).second) node["id"].fail("occurs twice");
  for (const JsonNode& box : node["boxes"].elements(kMaxTrackBoxes)) {
    track.boxes.push_back(static_cast<int>(box.integer(0, kMaxTrackBoxId)));
    if (!boxes.insert(track.boxes.back()).second) box.fail("is in two tracks");
  }
  if (node.has("centre_in_world_m") && !node["centre_in_world_m"].is_null())
    track.centre_in_world_m = node["centre_in_world_m"].vector<3>();
  if (node.has("covariance_m2") && !node["covariance_m2"].is_null())
    track.covariance_m2 = covariance_from(node["covariance_m2"], 3);
  return track;
}

}  // namespace

std::string tracks_to_json(const Tracks& tracks) {
  Json list = Json::array();
  for (const Track& track : tracks) {
    const bool is_placed = track.centre_in_world_m.allFinite();
    const bool is_sure = track.covariance_m2.trace() > 0;
    list.push_back(
        {{"id", track.id},
         {"boxes", track.boxes},
         {"centre_in_world_m", is_placed ? to_json(track.centre_in_world_m) : Json(nullptr)},
         {"covariance_m2", is_sure ? to_json(track.covariance_m2) : Json(nullptr)}});
  }
  Json root = Json::object();
  root["tracks"] = std::move(list);
  return to_text(root);
}

Tracks tracks_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"tracks"});
  Tracks tracks;
  std::set<int> ids, boxes;
  for (const JsonNode& node : root["tracks"].elements(kMaxTracks))
    tracks.push_back(read_track(node, ids, boxes));
  return tracks;
}

}  // namespace cousin
