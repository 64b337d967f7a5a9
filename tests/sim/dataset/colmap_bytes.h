#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "sim/dataset/colmap_tracks.h"

namespace cousin {

template <class Number>
void append(std::string& bytes, Number value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

/// Binary files of a model with its points, as COLMAP writes them. Points are numbered from
/// `first_point`; each sighting is a point of its image.
inline ColmapFiles colmap_bytes(const ColmapTracks& tracks, std::uint64_t first_point = 1) {
  ColmapFiles files = colmap_binary(tracks.model);
  std::map<int, std::vector<std::pair<Eigen::Vector2d, std::uint64_t>>> of_image;
  files.points.clear();
  append(files.points, static_cast<std::uint64_t>(tracks.points.size()));
  for (std::size_t i = 0; i < tracks.points.size(); ++i) {
    const ColmapPoint& point = tracks.points[i];
    append(files.points, first_point + i);
    for (int k = 0; k < 3; ++k) append(files.points, point.in_world[k]);
    files.points += {static_cast<char>(point.color.r), static_cast<char>(point.color.g),
                     static_cast<char>(point.color.b)};
    append(files.points, point.error_px);
    append(files.points, static_cast<std::uint64_t>(point.sightings.size()));
    for (const ColmapSighting& seen : point.sightings) {
      auto& own = of_image[seen.image];
      append(files.points, static_cast<std::int32_t>(seen.image));
      append(files.points, static_cast<std::int32_t>(own.size()));
      own.emplace_back(seen.pixel_px, first_point + i);
    }
  }
  files.images.clear();
  append(files.images, static_cast<std::uint64_t>(tracks.model.images.size()));
  for (const auto& [id, image] : tracks.model.images) {
    append(files.images, static_cast<std::int32_t>(id));
    const Eigen::Quaterniond& q = image.camera_from_world.rotation;
    const Eigen::Vector3d& t = image.camera_from_world.translation_m;
    for (const double number : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()})
      append(files.images, number);
    append(files.images, static_cast<std::int32_t>(image.camera));
    files.images += image.name + '\0';
    append(files.images, static_cast<std::uint64_t>(of_image[id].size()));
    for (const auto& [pixel_px, point] : of_image[id]) {
      append(files.images, pixel_px.x() + 0.5);
      append(files.images, pixel_px.y() + 0.5);
      append(files.images, point);
    }
  }
  return files;
}

}  // namespace cousin
