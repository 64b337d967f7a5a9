#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/device.h"
#include "sim/truth/truth_images.h"
#include "sim/types/capture.h"

namespace cousin {

/// Where a depth camera's images come from.
enum class DepthBy {
  matched,  ///< as the device does it: by stereo, both infrared images are rendered and matched
  model,    ///< of stereo: noise, holes and edges are put on true depth: several times as fast
};

struct RigCaptureConfig {
  DepthBy depth_by = DepthBy::matched;
  bool knows_pose = false;         ///< the rig sits on an arm that reports where it is,
  double pose_error_m = 0.0002;    ///< with an error of this sigma, each axis, at each frame
  double pose_error_rad = 0.0005;  ///< and of this one about each axis
  /// Automatic exposure is for what lies within this of the view's focus; 0: for the highlights.
  double metered_m = 0;
};
Fields fields(RigCaptureConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const RigCaptureConfig& config);

/// Linear radiance of a view; what is random in it comes from the stream.
using RadianceRenderer = std::function<Image<Rgbf>(const TrueView&, const Rng&)>;

/// What a rig hands over at one instant, and what is true of it.
struct RigFrame {
  Frame frame;
  Image<float> noise_free_depth_m;     ///< of the depth sensor; empty if it took no depth
  Image<std::uint8_t> invalid_reason;  ///< an InvalidReason each
};

/// One particular rig carried along a scene's views. A frame is a pure function of (configuration,
/// scene, stream, frame): any subset may be taken, in any order, on any number of threads.
///
/// Sensors, in this order: of a phone `rgb`; of a rig its cameras; of a stereo depth camera `rgb`,
/// `ir_left`, `ir_right` and `depth`, whose pixels are the left imager's; of one by time of flight
/// or structured light `rgb` and `depth`.
class RigCapture {
 public:
  /// Draws the unit and its views. @param rays, scene  must outlive this.
  /// @throws std::invalid_argument if the configuration is invalid, or depth by the model is asked
  /// of a device without projector (the model knows nothing of a scene's own texture) or one whose
  /// depth is not by stereo.
  RigCapture(const DeviceConfig& device, const RigCaptureConfig& config, const RayScene& rays,
             const Scene& scene, const Rng& rng);
  ~RigCapture();
  RigCapture(RigCapture&&) noexcept;

  /// What the rig says of itself; whichever streams are taken.
  std::vector<SensorReport> reports() const;
  /// True lenses and poses, one entry for each sensor.
  const std::vector<SensorViews>& views() const;
  /// A frame as take() gives it, without images.
  Frame reported(int frame) const;
  /// The same with an image of one pixel in each place where take() gives one.
  Frame outline(int frame, const Streams& streams) const;
  /// Renders and senses what is asked for and nothing else: without colour and raw no light is
  /// traced, without infrared and depth by matching no infrared.
  /// @param repeat  another number draws other noise of the colour, and other light paths, from the
  /// same place by the same unit
  /// @throws std::invalid_argument for a stream that the rig does not have.
  RigFrame take(int frame, const Streams& streams, const RadianceRenderer& radiance,
                std::uint64_t repeat = 0) const;
  /// True disparity of the first sensor's pixels in the second; empty if the rig has one sensor or
  /// a depth camera's.
  ViewMatch disparity(int frame) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All frames of a rig. Images of the truth are those that `needs` asks of the depth sensor; what
/// cameras see is render_truth's.
struct RigRun {
  std::vector<SensorReport> rig;
  std::vector<Frame> frames;
  std::vector<TruthImages> truth;  ///< one for each frame
};
/// @param progress  called with the number of frames that are done; may be empty.
RigRun take_all(const RigCapture& rig, const Streams& streams, const TruthNeeds& needs,
                const RadianceRenderer& radiance,
                const std::function<void(int done, int total)>& progress = {});

}  // namespace cousin
