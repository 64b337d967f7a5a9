// libjpeg reports errors by longjmp; see png.cpp for how that is kept apart from destructors.

// jpeglib.h needs the first two before it, jerror.h needs jpeglib.h.
// clang-format off
#include <cstddef>
#include <cstdio>
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

#include <csetjmp>
#include <cstdlib>
#include <stdexcept>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

struct ErrorManager {
  jpeg_error_mgr base;  // first, so that libjpeg's pointer is ours
  jmp_buf jump;
  char text[JMSG_LENGTH_MAX];
};

[[noreturn]] void jump_out(j_common_ptr info) {
  auto* manager = reinterpret_cast<ErrorManager*>(info->err);
  info->err->format_message(info, manager->text);
  longjmp(manager->jump, 1);
}

/// libjpeg only warns of a truncated or damaged file and fills it with grey. Here that is an error.
void judge_warning(j_common_ptr info, int level) {
  if (level >= 0) return;  // a trace
  switch (info->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:  // padding that some cameras write
    case JWRN_ADOBE_XFORM:
    case JWRN_JFIF_MAJOR:
      return;
    default:
      jump_out(info);
  }
}

/// A hostile progressive file repeats scans without end; real ones have about ten.
void limit_scans(j_common_ptr info) {
  auto* decoder = reinterpret_cast<j_decompress_ptr>(info);
  if (decoder->input_scan_number <= 100) return;
  auto* manager = reinterpret_cast<ErrorManager*>(info->err);
  std::snprintf(manager->text, sizeof manager->text, "more than 100 scans");
  longjmp(manager->jump, 1);
}

jpeg_error_mgr* start(ErrorManager& manager) {
  jpeg_std_error(&manager.base);
  manager.base.error_exit = jump_out;
  manager.base.emit_message = judge_warning;
  manager.base.output_message = [](j_common_ptr) {};
  manager.text[0] = '\0';
  return &manager.base;
}

struct Decoder {
  ErrorManager errors;
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct info{};
  Decoder() { info.err = start(errors); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { jpeg_destroy_decompress(&info); }
};

bool read_header(Decoder& decoder, const std::uint8_t* bytes, std::size_t size) {
  if (setjmp(decoder.errors.jump)) return false;
  jpeg_create_decompress(&decoder.info);
  decoder.progress.progress_monitor = limit_scans;
  decoder.info.progress = &decoder.progress;
  jpeg_mem_src(&decoder.info, bytes, static_cast<unsigned long>(size));
  jpeg_read_header(&decoder.info, TRUE);
  return true;
}

bool read_rows(Decoder& decoder, JSAMPLE* pixels) {
  if (setjmp(decoder.errors.jump)) return false;
  decoder.info.out_color_space = JCS_RGB;
  decoder.info.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&decoder.info);
  const std::size_t stride = std::size_t{decoder.info.output_width} * 3;
  while (decoder.info.output_scanline < decoder.info.output_height) {
    JSAMPROW row = pixels + stride * decoder.info.output_scanline;
    jpeg_read_scanlines(&decoder.info, &row, 1);
  }
  jpeg_finish_decompress(&decoder.info);
  return true;
}

struct Encoder {
  ErrorManager errors;
  jpeg_compress_struct info{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  Encoder() { info.err = start(errors); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() {
    jpeg_destroy_compress(&info);
    std::free(bytes);
  }
};

bool write_rows(Encoder& encoder, const Image<Rgb8>& image, int quality) {
  if (setjmp(encoder.errors.jump)) return false;
  jpeg_create_compress(&encoder.info);
  jpeg_mem_dest(&encoder.info, &encoder.bytes, &encoder.size);
  encoder.info.image_width = static_cast<JDIMENSION>(image.width());
  encoder.info.image_height = static_cast<JDIMENSION>(image.height());
  encoder.info.input_components = 3;
  encoder.info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&encoder.info);
  jpeg_set_quality(&encoder.info, quality, TRUE);
  encoder.info.dct_method = JDCT_ISLOW;
  jpeg_start_compress(&encoder.info, TRUE);
  while (encoder.info.next_scanline < encoder.info.image_height) {
    const Rgb8* pixels = image.row(static_cast<int>(encoder.info.next_scanline)).data();
    // libjpeg's interface lacks const; it only reads.
    JSAMPROW row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(pixels));
    jpeg_write_scanlines(&encoder.info, &row, 1);
  }
  jpeg_finish_compress(&encoder.info);
  return true;
}

}  // namespace

namespace imaging {

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

Image<Rgb8> decode_jpeg(std::span<const std::uint8_t> bytes, const std::string& name) {
  if (!is_jpeg(bytes)) throw std::runtime_error(name + ": not a JPEG file");
  Decoder decoder;
  if (!read_header(decoder, bytes.data(), bytes.size())) {
    throw std::runtime_error(name + ": JPEG: " + decoder.errors.text);
  }
  const std::uint64_t width = decoder.info.image_width, height = decoder.info.image_height;
  check_image_size(name, width, height);
  if (decoder.info.num_components != 1 && decoder.info.num_components != 3) {
    throw std::runtime_error(name + ": a JPEG of " + std::to_string(decoder.info.num_components) +
                             " components; expected grey or colour");
  }
  // A block of 8 x 8 takes a bit or more, so a small file cannot ask for a large image.
  if (width * height / 512 > bytes.size()) {
    throw std::runtime_error(name + ": JPEG: truncated: " + std::to_string(bytes.size()) +
                             " bytes cannot hold " + std::to_string(width) + " x " +
                             std::to_string(height) + " pixels");
  }
  // A progressive file is held as two bytes a number until its last scan.
  const std::uint64_t per_pixel = jpeg_has_multiple_scans(&decoder.info) ? 9 : 3;
  check_memory(name, bytes.size() + width * height * per_pixel, "its pixels");
  Image<Rgb8> image(static_cast<int>(width), static_cast<int>(height));
  if (!read_rows(decoder, reinterpret_cast<JSAMPLE*>(image.data()))) {
    throw std::runtime_error(name + ": JPEG: " + decoder.errors.text);
  }
  return image;
}

}  // namespace imaging

std::vector<std::uint8_t> encode_jpeg(const Image<Rgb8>& image, int quality) {
  imaging::check_encodable(image.width(), image.height());
  if (image.width() > JPEG_MAX_DIMENSION || image.height() > JPEG_MAX_DIMENSION) {
    throw std::invalid_argument("a JPEG has at most " + std::to_string(JPEG_MAX_DIMENSION) +
                                " pixels a side");
  }
  if (quality < 1 || quality > 100) {
    throw std::invalid_argument("JPEG quality " + std::to_string(quality) +
                                ": must be in [1, 100]");
  }
  Encoder encoder;
  if (!write_rows(encoder, image, quality))
    throw std::runtime_error(std::string("JPEG: ") + encoder.errors.text);
  return {encoder.bytes, encoder.bytes + encoder.size};
}

}  // namespace cousin
