// Photographs of a camera that nobody has calibrated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/exif_focal.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/temporary_folder.h"
#include "tests/sim/imaging/exif_bytes.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class Photographs : public testing::Test {
 protected:
  void write(const std::string& name, const ExifWriter& exif, int width_px = 400,
             int height_px = 300) {
    const std::vector<std::uint8_t> bytes =
        with_exif(encode_jpeg(Image<Rgb8>(width_px, height_px), 90), exif.block());
    write_file(folder_.path() / name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  static ExifWriter phone(unsigned film_mm, ByteOrder order = ByteOrder::big) {
    ExifWriter exif(order);
    exif.add_short(true, 0xA405, film_mm);
    return exif;
  }
  Capture import(const LensOfPhotographs& solve = {}) {
    return import_folder(folder_.path(), "", solve);
  }
  TemporaryFolder folder_;
};

TEST_F(Photographs, TheFocalLengthOnFilmIsAlongTheDiagonal) {
  write("a.jpg", phone(26));
  write("b.jpg", phone(26, ByteOrder::little));
  const Capture capture = import();
  // 400 x 300: 500 px along the 43.27 mm of film.
  const Camera& camera = capture.rig[0].camera;
  EXPECT_NEAR(camera.fx_px, 26 * 500 / std::hypot(36.0, 24.0), 1e-9);
  EXPECT_EQ(camera.fy_px, camera.fx_px);
  EXPECT_EQ(camera.cx_px, 199.5);
  EXPECT_EQ(camera.model, LensModel::pinhole);
  EXPECT_EQ(capture.frames[1].sensors[0].reported, camera);
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("300.5 px, standard deviation 15.02 px (5 %)"),
                                         HasSubstr("EXIF of a.jpg: 26 mm on 35 mm film"),
                                         HasSubstr("2 of 2 photographs"))));
}

TEST_F(Photographs, AnImagersResolutionIsScaledToTheCopy) {
  ExifWriter exif(ByteOrder::little);
  exif.add_ratio(true, 0x920A, 50, 1);
  exif.add_ratio(true, 0xA20E, 4000, 1);
  exif.add_short(true, 0xA210, 3);  // a centimetre: 400 pixels a millimetre
  exif.add_long(true, 0xA002, 4000);
  exif.add_long(true, 0xA003, 3000);
  write("a.jpg", exif);
  EXPECT_NEAR(import().rig[0].camera.fx_px, 50 * 400 / 10.0, 1e-9);
  write("a.jpg", exif, 300, 400);  // turned by a program, the tags are as they were
  EXPECT_NEAR(import().rig[0].camera.fx_px, 50 * 400 / 10.0, 1e-9);
}

TEST_F(Photographs, ACutPictureHasNoFocalLength) {
  ExifWriter exif = phone(26);
  exif.add_long(true, 0xA002, 4000);
  exif.add_long(true, 0xA003, 3000);
  write("a.jpg", exif, 300, 300);
  EXPECT_THAT(error_of([&] { import(); }), AllOf(HasSubstr("EXIF"), HasSubstr("--intrinsics")));
}

TEST_F(Photographs, TwoStatementsThatDifferAreBothSaid) {
  ExifWriter exif = phone(26);
  exif.add_ratio(true, 0x920A, 50, 1);
  exif.add_ratio(true, 0xA20E, 10, 1);
  exif.add_short(true, 0xA210, 4);
  write("a.jpg", exif);
  EXPECT_THAT(import().warnings,
              testing::ElementsAre(AllOf(HasSubstr("is 300.5 px"), HasSubstr("is 500 px"))));
}

TEST_F(Photographs, TwoLensesAreRefused) {
  write("a.jpg", phone(26));
  write("b.jpg", phone(52));
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("a.jpg"), HasSubstr("b.jpg"), HasSubstr("one lens at a time")));
  EXPECT_EQ(import_folder(folder_.path(), "300,300,199.5,149.5").frames.size(), 2U);
}

TEST_F(Photographs, WithoutExifTheCallerSolves) {
  write_png(folder_.path() / "a.png", Image<Rgb8>(400, 300));
  const Capture capture = import([](const Capture& photographs) {
    const Image<Rgb8>& color = photographs.frames.at(0).sensors.at(0).color;
    return AssumedLens{camera_of_focal(320, color.width(), color.height()), 8, "made up"};
  });
  EXPECT_EQ(capture.rig[0].camera.fx_px, 320);
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("320 px, standard deviation 8 px (2.5 %)"),
                                         HasSubstr("made up"))));
}

TEST_F(Photographs, ATurnedPictureIsUsedAsItIsStoredAndThatIsSaid) {
  ExifWriter exif = phone(26);
  exif.add_short(false, 0x0112, 6);
  write("a.jpg", exif);
  write("b.jpg", phone(26));
  const Capture capture = import_folder(folder_.path(), "300,300,199.5,149.5");
  EXPECT_EQ(capture.frames[0].sensors[0].color.width(), 400);
  EXPECT_THAT(capture.warnings, testing::ElementsAre(AllOf(HasSubstr("a.jpg: EXIF orientation 6"),
                                                           HasSubstr("1 of 2 images"))));
}

TEST_F(Photographs, FilesThatAreNotReadAreSaid) {
  write("a.jpg", phone(26));
  write_file(folder_.path() / "b.HEIC", "x");
  write_file(folder_.path() / "._a.jpg", "what macOS writes beside it");
  EXPECT_THAT(import().warnings,
              testing::Contains(HasSubstr("1 pictures are not read, as b.HEIC")));
  fs::remove(folder_.path() / "a.jpg");
  EXPECT_THAT(error_of([&] { import(); }), AllOf(HasSubstr("no .png"), HasSubstr("b.HEIC")));
}

TEST_F(Photographs, NamesThatAreNotUtf8AreRefused) {
  write("caf\xe9.jpg", phone(26));
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("\"caf\\xe9.jpg\""), HasSubstr("not UTF-8")));
}

TEST_F(Photographs, LinksOutOfTheFolderAreRefused) {
  const TemporaryFolder secret;
  write_png(secret.path() / "s.png", Image<Rgb8>(400, 300));
  fs::create_symlink(secret.path() / "s.png", folder_.path() / "a.png");
  EXPECT_THAT(error_of([&] { import(); }), HasSubstr("symbolic link"));
}

}  // namespace
}  // namespace cousin
