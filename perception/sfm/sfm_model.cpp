#include "perception/sfm/sfm_model.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "sim/types/utf8.h"

namespace cousin {

SfmModel sfm_model(const ColmapTracks& tracks, const std::vector<std::string>& names,
                   const std::string& where) {
  std::map<std::string, int> index_of_name;
  for (std::size_t i = 0; i < names.size(); ++i)
    index_of_name.emplace(names[i], static_cast<int>(i));
  std::map<int, const ColmapImage*> placed;  // by index
  std::map<int, int> index_of_id;
  for (const auto& [id, image] : tracks.model.images) {
    const auto found = index_of_name.find(image.name);
    if (found == index_of_name.end()) {
      throw std::runtime_error(where + ": the model has a photograph \"" +
                               cut_utf8(image.name, 200) + "\" that it was not given");
    }
    if (!placed.emplace(found->second, &image).second)
      throw std::runtime_error(where + ": \"" + image.name + "\" occurs twice");
    index_of_id[id] = found->second;
  }
  SfmModel model;
  for (const auto& [index, image] : placed) {
    model.images.push_back(index);
    model.lenses.push_back(tracks.model.cameras.at(image->camera));
    model.camera_from_world.push_back(image->camera_from_world);
  }
  for (const ColmapPoint& point : tracks.points) {
    std::map<int, Eigen::Vector2d> sightings;  // a track may touch an image twice: the first counts
    for (const ColmapSighting& seen : point.sightings)
      sightings.emplace(index_of_id.at(seen.image), seen.pixel_px);
    if (sightings.size() < 2) continue;
    SfmPoint own{point.in_world, point.color, {}};
    for (const auto& [image, pixel_px] : sightings) own.sightings.push_back({image, pixel_px});
    model.points.push_back(std::move(own));
  }
  return model;
}

}  // namespace cousin
