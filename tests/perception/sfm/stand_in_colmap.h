#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "perception/sfm/colmap_files.h"
#include "sim/dataset/atomic_file.h"
#include "tests/perception/sfm/plant_views.h"
#include "tests/sim/dataset/colmap_bytes.h"

namespace cousin {

/// A shell script in COLMAP's place, in a folder of its own. It notes each command in `calls` and
/// its arguments in `arguments`; its mapper leaves what lies in `models`.
class StandInColmap {
 public:
  /// @param instead  shell text that runs after a command is noted and before it does its work
  explicit StandInColmap(const std::filesystem::path& folder, const std::string& instead = "")
      : folder_(folder) {
    std::filesystem::create_directories(folder / "models");
    write_file(program(),
               "#!/bin/sh\nhere=$(dirname \"$0\")\ncommand=$1\n"
               "echo \"$command\" >> \"$here/calls\"\n"
               "for word in \"$@\"; do echo \"$word\" >> \"$here/arguments\"; done\n" +
                   instead +
                   "\ncase $command in\n"
                   "help) echo 'COLMAP 3.8 -- stand-in' ;;\n"
                   "mapper)\n"
                   "  while [ $# -gt 0 ]; do\n"
                   "    [ \"$1\" = --output_path ] && out=$2\n"
                   "    shift\n"
                   "  done\n"
                   "  cp -r \"$here/models/.\" \"$out/\" ;;\n"
                   "esac\n");
    std::filesystem::permissions(program(), std::filesystem::perms::owner_all);
  }
  std::string program() const { return (folder_ / "colmap").string(); }
  std::string calls() const { return text("calls"); }
  std::string arguments() const { return text("arguments"); }

  /// Puts a model of the images that the views placed as number `index`, its ids against the
  /// names' order.
  void add_model(int index, const PlantViews& views) {
    ColmapTracks tracks;
    tracks.model.cameras[1] = views.lens;
    constexpr int kMostImages = 1000;
    for (std::size_t i = 0; i < views.model.images.size(); ++i) {
      const int image = views.model.images[i];
      tracks.model.images[kMostImages - image] = {colmap_image_name(image), 1,
                                                  views.model.camera_from_world[i]};
    }
    for (const SfmPoint& point : views.model.points) {
      ColmapPoint own{point.in_world_m, point.color, 0, {}};
      for (const SfmSighting& seen : point.sightings)
        own.sightings.push_back({kMostImages - seen.image, seen.pixel_px});
      tracks.points.push_back(own);
    }
    const ColmapFiles files = colmap_bytes(tracks);
    const std::filesystem::path folder = folder_ / "models" / std::to_string(index);
    write_file(folder / "cameras.bin", files.cameras);
    write_file(folder / "images.bin", files.images);
    write_file(folder / "points3D.bin", files.points);
  }

 private:
  std::string text(const char* name) const {
    const std::filesystem::path file = folder_ / name;
    return std::filesystem::exists(file) ? read_file(file) : "";
  }
  std::filesystem::path folder_;
};

}  // namespace cousin
