#include "sim/imaging/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/imaging/file_bytes.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A .npy file as numpy.save writes it: version 1.0, the text padded to 64 bytes.
std::string npy_file(const std::string& dictionary, const std::string& numbers,
                     char major = '\x01') {
  std::string text = dictionary;
  const std::size_t before = major == '\x01' ? 10 : 12;
  while ((before + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string file = std::string("\x93NUMPY") + major + '\0';
  for (std::size_t i = 0; i < before - 8; ++i)
    file += static_cast<char>((text.size() >> (8 * i)) & 255U);
  return file + text + numbers;
}

std::string dictionary(const std::string& shape, const std::string& descr = "'<f4'",
                       const std::string& fortran_order = "False") {
  return "{'descr': " + descr + ", 'fortran_order': " + fortran_order + ", 'shape': " + shape +
         ", }";
}

std::string bytes_of(const std::vector<float>& numbers) {
  std::string bytes(numbers.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

std::span<const std::uint8_t> span_of(const std::string& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

/// What reading one channel says; empty if it reads.
std::string error_of_file(const std::string& bytes) {
  try {
    imaging::decode_npy(span_of(bytes), "a.npy");
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

class Npy : public testing::Test {
 protected:
  Npy() { std::filesystem::create_directories(folder_); }
  ~Npy() override { std::filesystem::remove_all(folder_); }
  std::string text_of(const std::filesystem::path& file) const {
    const std::vector<std::uint8_t> bytes = imaging::read_bytes(file);
    return {bytes.begin(), bytes.end()};
  }
  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      ("npy_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(Npy, EveryBitComesBack) {
  Image<float> depth_m(3, 2, 1 / 3.0F);
  depth_m(2, 0) = kNaN;
  depth_m(0, 1) = -0.0F;
  depth_m(1, 1) = std::numeric_limits<float>::infinity();
  write_npy(folder_ / "a.npy", depth_m);
  const Image<float> back = read_npy(folder_ / "a.npy");
  ASSERT_EQ(back.width(), 3);
  ASSERT_EQ(back.height(), 2);
  EXPECT_EQ(std::memcmp(back.data(), depth_m.data(), depth_m.size() * sizeof(float)), 0);

  Image<Eigen::Vector3f> normal(2, 3, {0.1F, -0.2F, kNaN});
  normal(1, 2) = {1, 2, 3};
  write_npy(folder_ / "n.npy", normal);
  const Image<Eigen::Vector3f> read = read_npy_vectors(folder_ / "n.npy");
  ASSERT_EQ(read.width(), 2);
  ASSERT_EQ(read.height(), 3);
  EXPECT_EQ(std::memcmp(read.data(), normal.data(), normal.size() * sizeof(Eigen::Vector3f)), 0);
  EXPECT_EQ(npy_pixels(folder_ / "n.npy"), 6U);
  EXPECT_THROW(write_npy(folder_ / "e.npy", Image<float>()), std::invalid_argument);
}

TEST_F(Npy, IsTheFileThatNumpySaves) {
  Image<float> image(3, 2);
  for (int i = 0; i < 6; ++i) image.data()[i] = static_cast<float>(i);
  write_npy(folder_ / "a.npy", image);
  // Row by row: numpy's last index is the column.
  const std::string expected = npy_file(dictionary("(2, 3)"), bytes_of({0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(text_of(folder_ / "a.npy"), expected);
  EXPECT_EQ(expected.size() % 64, 24U);
  write_npy(folder_ / "v.npy", Image<Eigen::Vector3f>(1, 1, {7, 8, 9}));
  EXPECT_EQ(text_of(folder_ / "v.npy"), npy_file(dictionary("(1, 1, 3)"), bytes_of({7, 8, 9})));
}

TEST_F(Npy, VersionsAndWaysToWriteTheSameHeaderAreRead) {
  const std::string numbers = bytes_of({1, 2});
  for (const std::string& text :
       {std::string("{'shape': (1, 2), 'fortran_order': False, 'descr': '<f4'}"),
        std::string("{\"descr\":\"<f4\",\"fortran_order\":False,\"shape\":(1,2)}"),
        std::string("  {'descr': '<f4', 'fortran_order': False, 'shape': ( 1 , 2 , ), }")}) {
    EXPECT_EQ(error_of_file(npy_file(text, numbers)), "") << text;
  }
  for (const char major : {'\x02', '\x03'})
    EXPECT_EQ(
        imaging::decode_npy(span_of(npy_file(dictionary("(1, 2)"), numbers, major)), "a")(1, 0), 2);
}

TEST_F(Npy, OtherArraysAreRefusedByWhatTheyHave) {
  const std::string numbers = bytes_of({1, 2, 3, 4, 5, 6});
  const auto said = [&](const std::string& text) { return error_of_file(npy_file(text, numbers)); };
  ASSERT_EQ(said(dictionary("(2, 3)")), "");
  EXPECT_THAT(said(dictionary("(2, 3)", "'<f8'")),
              AllOf(StartsWith("a.npy: "), HasSubstr("descr = '<f8'; expected '<f4'")));
  EXPECT_THAT(said(dictionary("(2, 3)", "'>f4'")), HasSubstr("descr = '>f4'"));
  EXPECT_THAT(said(dictionary("(2, 3)", "'|O'")), HasSubstr("descr = '|O'"));
  EXPECT_THAT(said(dictionary("(2, 3)", "[('x', '<f4'), ('y', '<f4')]")),
              HasSubstr("descr = [('x', '<f4'), ('y', '<f4')]"));
  EXPECT_THAT(said(dictionary("(2, 3)", "'<f4'", "True")),
              HasSubstr("fortran_order = True; expected False"));
  for (const char* shape : {"(6,)", "()", "(1, 2, 3)", "(1, 2, 3, 1)", "(-2, 3)", "(2, 3.0)",
                            "(99999999999999999999, 1)", "(2,, 3)"}) {
    EXPECT_THAT(said(dictionary(shape)), AllOf(HasSubstr(std::string("shape = ") + shape),
                                               HasSubstr("expected (height, width)")))
        << shape;
  }
  EXPECT_THAT(said(dictionary("(0, 3)")), HasSubstr("3 x 0 pixels; the limits are 1 to 65535"));
  EXPECT_THAT(said(dictionary("(65536, 1)")), HasSubstr("1 x 65536 pixels"));
  EXPECT_THAT(said(dictionary("(65535, 65535)")), HasSubstr("2^28"));
  EXPECT_THROW(
      imaging::decode_npy_vectors(span_of(npy_file(dictionary("(2, 3)"), numbers)), "a.npy"),
      std::runtime_error);
}

TEST_F(Npy, DamagedFilesAreRefused) {
  const std::string numbers = bytes_of({1, 2, 3, 4, 5, 6});
  const std::string good = npy_file(dictionary("(2, 3)"), numbers);
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(error_of_file(good.substr(0, size)), "") << size;
  EXPECT_THAT(error_of_file(good.substr(0, good.size() - 1)),
              HasSubstr("23 bytes follow the header; its shape needs 24"));
  EXPECT_THAT(error_of_file(good + "x"), HasSubstr("25 bytes follow"));
  EXPECT_THAT(error_of_file("P5 3 2 255 "), HasSubstr("not a NPY file"));
  EXPECT_THAT(error_of_file(npy_file(dictionary("(2, 3)"), numbers, '\x04')),
              HasSubstr("version 4.0; expected 1.0, 2.0 or 3.0"));
  EXPECT_THAT(error_of_file(npy_file(std::string(20000, ' '), numbers, '\x02')),
              AllOf(HasSubstr("a header of "), HasSubstr("the limit is 10000")));
  for (const char* text : {"", "{", "[1]", "{'descr': '<f4'}", "{'descr'}", "{descr: '<f4'}",
                           "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), 'more': 1}",
                           "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False}"}) {
    EXPECT_THAT(error_of_file(npy_file(text, numbers)), HasSubstr("header")) << text;
  }
}

TEST_F(Npy, MemoryIsBoundedAndTheSizeIsKnownFromTheHeader) {
  write_npy(folder_ / "a.npy", Image<float>(1000, 1000, 1.0F));
  EXPECT_EQ(npy_pixels(folder_ / "a.npy"), 1'000'000U);
  set_memory_limit(1'000'000);
  EXPECT_THAT(error_of_file(text_of(folder_ / "a.npy")),
              AllOf(HasSubstr("1000 x 1000 pixels"), HasSubstr("the limit is 1000000 bytes")));
  set_memory_limit(0);
  std::filesystem::resize_file(folder_ / "a.npy", 3000);
  EXPECT_THROW(npy_pixels(folder_ / "a.npy"), std::runtime_error);
  EXPECT_THROW(npy_pixels(folder_ / "absent.npy"), std::runtime_error);
}

}  // namespace
}  // namespace cousin
