#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/for_each_frame.h"

namespace cousin {

/// Calls `work(i, picture)` for these pictures of a scene on all threads and reports progress;
/// `done` counts over scenes.
template <class Work>
void for_each_picture(const ExportJob& job, const ExportScene& scene,
                      const std::vector<const ExportPicture*>& pictures, int& done,
                      const Work& work) {
  constexpr std::size_t kAtOnce = 16;
  const int total = picture_count(job.scenes);
  for (std::size_t first = 0; first < pictures.size(); first += kAtOnce) {
    job.progress("labels of scene " + std::to_string(scene.number), done, total);
    const std::size_t count = std::min(kAtOnce, pictures.size() - first);
    for_each_frame(count, [&](std::size_t i) { work(first + i, *pictures[first + i]); });
    done += static_cast<int>(count);
  }
}

}  // namespace cousin
