#include "sim/dataset/import_images.h"

#include <stdexcept>
#include <string>

#include "sim/dataset/for_each_frame.h"
#include "sim/imaging/image_io.h"

namespace cousin {

void check_image_size(const std::filesystem::path& file, int frame, int width_px, int height_px,
                      const Camera& camera) {
  if (width_px == camera.width_px && height_px == camera.height_px) return;
  throw std::runtime_error(file.string() + " (frame " + std::to_string(frame) + "): the image is " +
                           std::to_string(width_px) + " x " + std::to_string(height_px) +
                           " pixels; its camera has " + std::to_string(camera.width_px) + " x " +
                           std::to_string(camera.height_px));
}

void read_frame_colors(Capture& capture, const std::vector<std::filesystem::path>& images) {
  for_each_frame(images.size(), [&](std::size_t i) {
    Frame& frame = capture.frames[i];
    SensorFrame& sensor = frame.sensors.front();
    sensor.color = read_color(images[i]);
    check_image_size(images[i], frame.id, sensor.color.width(), sensor.color.height(),
                     sensor.reported);
  });
}

}  // namespace cousin
