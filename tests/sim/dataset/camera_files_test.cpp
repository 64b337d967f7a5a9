// Calibration files of other programs: read back by us, by OpenCV and by mrcal.
#include "sim/dataset/camera_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "sim/dataset/import.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/sample_lenses.h"
#include "tests/sim/dataset/temporary_folder.h"

#if COUSIN_WITH_MRCAL
extern "C" {
#include <mrcal/mrcal.h>
}
#endif

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kTolerance_px = 1e-9;  // the project's demand; text keeps every bit

/// The refusal of a lens, or "" if it was written.
template <class Write>
std::string refusal(const Write& write) {
  try {
    write();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

CalibratedCamera calibrated(const Camera& camera) {
  Rng rng(3);
  return {"rgb", camera, odd_pose(rng)};
}

TEST(CameraFiles, OpenCvAndRosYamlReadBackWithEveryDigit) {
  int opencv = 0, ros = 0;
  for (const Camera& lens : odd_lenses()) {
    const CalibratedCamera camera = calibrated(lens);
    const std::string why =
        "sensor \"rgb\" has the lens model " + std::string(to_string(lens.model));
    std::string text;
    const std::string no_opencv = refusal([&] { text = opencv_yaml(camera, camera); });
    if (no_opencv.empty()) {
      EXPECT_LE(largest_difference_px(lens, camera_from_yaml(text, "c")), kTolerance_px);
      ++opencv;
    } else {
      EXPECT_THAT(no_opencv, AllOf(HasSubstr(why), HasSubstr("OpenCV")));
    }
    const std::string no_ros = refusal([&] { text = ros_camera_info(camera); });
    if (no_ros.empty()) {
      EXPECT_LE(largest_difference_px(lens, camera_from_yaml(text, "c")), kTolerance_px);
      ++ros;
    } else {
      EXPECT_THAT(no_ros, AllOf(HasSubstr(why), HasSubstr("ROS")));
    }
  }
  EXPECT_EQ(opencv, 6);  // all but splines
  EXPECT_EQ(ros, 5);     // nor thin prisms
}

/// OpenCV's own reader and projection.
TEST(CameraFiles, OpenCvProjectsWhatItReadsToOurPixels) {
  for (const Camera& lens : odd_lenses()) {
    if (lens.model == LensModel::splined_stereographic) continue;
    const CalibratedCamera camera = calibrated(lens);
    const CalibratedCamera first{"left", lens, {}};
    const cv::FileStorage file(opencv_yaml(camera, first),
                               cv::FileStorage::READ | cv::FileStorage::MEMORY);
    cv::Mat matrix, distortion, turn, shift;
    file["camera_matrix"] >> matrix;
    file["distortion_coefficients"] >> distortion;
    file["R"] >> turn;
    file["T"] >> shift;
    EXPECT_EQ(static_cast<int>(file["image_width"]), 640);
    EXPECT_EQ(matrix.at<double>(0, 2), lens.cx_px);  // both count from a pixel's centre
    const auto points = points_in_view(lens, 1000);
    std::vector<cv::Point3d> in_camera;
    for (const Eigen::Vector3d& p : points) in_camera.emplace_back(p.x(), p.y(), p.z());
    std::vector<cv::Point2d> pixels;
    const cv::Vec3d zero(0, 0, 0);
    if (lens.model == LensModel::kannala_brandt4) {
      cv::fisheye::projectPoints(in_camera, pixels, zero, zero, matrix, distortion);
    } else {
      cv::projectPoints(in_camera, zero, zero, matrix, distortion, pixels);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d ours = *project(lens, points[i]);
      EXPECT_LT((ours - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm(), kTolerance_px);
    }
    // X_camera = R X_first + T.
    const Eigen::Vector3d there = camera.camera_from_reference * points[0];
    for (int row = 0; row < 3; ++row) {
      const double x = turn.at<double>(row, 0) * points[0].x() +
                       turn.at<double>(row, 1) * points[0].y() +
                       turn.at<double>(row, 2) * points[0].z() + shift.at<double>(row);
      EXPECT_NEAR(x, there[row], 1e-12);
    }
  }
}

TEST(CameraFiles, KalibrChainsReadBackWithPosesBetweenNeighbours) {
  const std::vector<Camera> lenses = odd_lenses();
  Rng rng(9);
  std::vector<CalibratedCamera> cameras;
  for (const std::size_t lens : {0U, 1U, 5U}) {
    cameras.push_back({"cam" + std::to_string(cameras.size()), lenses[lens], odd_pose(rng)});
  }
  const std::string text = kalibr_camchain(cameras);
  const std::vector<CalibratedCamera> back = cameras_from_kalibr(text, "chain");
  ASSERT_EQ(back.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE(largest_difference_px(cameras[i].camera, back[i].camera), kTolerance_px);
    const Pose from_first =
        cameras[i].camera_from_reference * inverse(cameras[0].camera_from_reference);
    EXPECT_LT(angle_rad(from_first.rotation * back[i].camera_from_reference.rotation.conjugate()),
              1e-12);
    EXPECT_LT((from_first.translation_m - back[i].camera_from_reference.translation_m).norm(),
              1e-12);
  }
  // One camera serves as intrinsics of a folder; of several nobody knows which.
  EXPECT_LE(
      largest_difference_px(lenses[1], camera_from_yaml(kalibr_camchain({cameras[1]}), "one")),
      kTolerance_px);
  EXPECT_THAT(error_of([&] { camera_from_yaml(text, "chain"); }), HasSubstr("cam0 and cam1"));
  for (const std::size_t lens : {2U, 3U, 4U, 6U}) {
    EXPECT_THAT(refusal([&] {
                  kalibr_camchain({{"rgb", lenses[lens], {}}});
                }),
                AllOf(HasSubstr("\"rgb\""), HasSubstr("Kalibr"),
                      HasSubstr(std::string(to_string(lenses[lens].model)))));
  }
}

TEST(CameraFiles, CameraModelsOfMrcalReadBackWithEveryDigit) {
  int written = 0;
  for (const Camera& lens : odd_lenses()) {
    const CalibratedCamera camera = calibrated(lens);
    std::string text;
    const std::string no = refusal([&] { text = mrcal_cameramodel(camera); });
    if (!no.empty()) {
      EXPECT_EQ(lens.model, LensModel::kannala_brandt4);
      EXPECT_THAT(no, AllOf(HasSubstr("kannala_brandt4"), HasSubstr("mrcal")));
      continue;
    }
    ++written;
    const CalibratedCamera back = camera_from_mrcal(text, "c");
    EXPECT_EQ(back.camera, lens);
    // Through a rotation vector of up to pi and back.
    const Pose difference = camera.camera_from_reference * inverse(back.camera_from_reference);
    EXPECT_LT(angle_rad(difference.rotation), 1e-14);
    EXPECT_LT(difference.translation_m.norm(), 1e-14);
  }
  EXPECT_EQ(written, 6);
  std::vector<Camera> lenses = odd_lenses();
  Camera spline = lenses.back();
  spline.spline.fov_x_rad = 1.7;
  EXPECT_THAT(refusal([&] { mrcal_cameramodel({"rgb", spline, {}}); }), HasSubstr("degrees"));
}

#if COUSIN_WITH_MRCAL
/// mrcal's own reader and projection.
TEST(CameraFiles, MrcalProjectsWhatItReadsToOurPixels) {
  for (const Camera& lens : odd_lenses()) {
    if (lens.model == LensModel::kannala_brandt4) continue;
    const CalibratedCamera camera = calibrated(lens);
    const std::string text = mrcal_cameramodel(camera);
    mrcal_cameramodel_t* model =
        mrcal_read_cameramodel_string(text.c_str(), static_cast<int>(text.size()));
    ASSERT_NE(model, nullptr) << text.substr(0, 200);
    EXPECT_EQ(model->imagersize[0], 640U);
    EXPECT_EQ(model->imagersize[1], 480U);
    const Eigen::Vector3d r(model->rt_cam_ref), t(model->rt_cam_ref + 3);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(r.norm(), r.normalized()));
    EXPECT_LT(angle_rad(turn * camera.camera_from_reference.rotation.conjugate()), 1e-12);
    EXPECT_LT((t - camera.camera_from_reference.translation_m).norm(), 1e-12);
    for (const Eigen::Vector3d& point : points_in_view(lens, 1000)) {
      mrcal_point3_t p;
      p.x = point.x(), p.y = point.y(), p.z = point.z();
      mrcal_point2_t q;
      ASSERT_TRUE(mrcal_project(&q, nullptr, nullptr, &p, 1, &model->lensmodel, model->intrinsics));
      EXPECT_LT((*project(lens, point) - Eigen::Vector2d(q.x, q.y)).norm(), kTolerance_px);
    }
    mrcal_free_cameramodel(&model);
  }
}
#endif

TEST(CameraFiles, WrongFilesAreErrorsWithFileAndKey) {
  const std::string good = mrcal_cameramodel({"rgb", odd_lenses()[2], {}});
  const auto error = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return error_of([&] { camera_from_mrcal(text, "c.cameramodel"); });
  };
  EXPECT_THAT(error("'imagersize'", "'size'"),
              HasSubstr("c.cameramodel: the key \"imagersize\" is missing"));
  EXPECT_THAT(error("640, 480", "640.5, 480"), HasSubstr("imagersize"));
  EXPECT_THAT(error("640, 480", "640, nan"), HasSubstr("imagersize: number 2"));
  EXPECT_THAT(error("OPENCV5", "OPENCV8"), HasSubstr("LENSMODEL_OPENCV8 has 12"));
  EXPECT_THAT(error("OPENCV5", "CAHVOR"), HasSubstr("LENSMODEL_CAHVOR"));
  EXPECT_THAT(error("}", ""), HasSubstr("does not end"));
  EXPECT_THAT(error("{", "["), HasSubstr("does not start"));
  EXPECT_THAT(error("[ 5", "[ -5"), HasSubstr("fx_px"));
  EXPECT_THAT(error("'intrinsics': [", "'intrinsics': ]"), HasSubstr("bracket"));
  EXPECT_THAT(error("OPENCV5", "SPLINED_STEREOGRAPHIC_order=3_Nx=999999_Ny=3_fov_x_deg=90"),
              HasSubstr("Nx"));
  // What a calibration leaves beside the camera is passed over.
  EXPECT_EQ(error("{",
                  "{ 'valid_intrinsics_region': [ [ 1, 2 ], [ 3, 4 ] ], # \"region\n"
                  "'optimization_inputs': b'}]{',"),
            "");

  const std::string chain = kalibr_camchain({{"rgb", odd_lenses()[1], {}}});
  const auto kalibr_error = [&](const std::string& from, const std::string& to) {
    std::string text = chain;
    text.replace(text.find(from), from.size(), to);
    return error_of([&] { cameras_from_kalibr(text, "chain.yaml"); });
  };
  EXPECT_THAT(kalibr_error("pinhole", "omni"), HasSubstr("cam0.camera_model = omni"));
  EXPECT_THAT(kalibr_error("radtan", "fov"), HasSubstr("cam0.distortion_model = fov"));
  EXPECT_THAT(kalibr_error("[640, 480]", "[640]"), HasSubstr("cam0.resolution"));
  EXPECT_THAT(kalibr_error("[640, 480]", "[1e99, 480]"), HasSubstr("cam0.resolution"));
  EXPECT_THAT(kalibr_error("cam0", "left"), HasSubstr("cam0.intrinsics"));
}

}  // namespace
}  // namespace cousin
