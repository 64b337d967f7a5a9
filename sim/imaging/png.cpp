// libpng reports errors by longjmp. Every function here that calls setjmp therefore has only plain
// locals; what owns memory lives in a struct of the caller, so a jump skips no destructor.

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"
#include "sim/types/memory_limit.h"

namespace cousin::imaging {
namespace {

struct Message {
  char text[256] = "unknown error";
};

void keep_error(png_structp png, png_const_charp text) {
  auto* message = static_cast<Message*>(png_get_error_ptr(png));
  std::snprintf(message->text, sizeof message->text, "%s", text);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

struct Header {
  png_uint_32 width = 0, height = 0;
  int bit_depth = 0, color_type = 0;
};

struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::uint8_t> rest;
  Message message;
  Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void read_data(png_structp png, png_bytep out, std::size_t count) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (count > reader->rest.size()) png_error(png, "truncated");
  std::memcpy(out, reader->rest.data(), count);
  reader->rest = reader->rest.subspan(count);
}

bool read_header(Reader& reader, Header& header) {
  reader.png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader.message, keep_error, ignore_warning);
  if (!reader.png) return false;
  if (setjmp(png_jmpbuf(reader.png))) return false;
  reader.info = png_create_info_struct(reader.png);
  if (!reader.info) return false;
  png_set_read_fn(reader.png, &reader, read_data);
  png_set_user_limits(reader.png, 65535, 65535);
  png_set_chunk_malloc_max(reader.png, 8U << 20);
  png_set_chunk_cache_max(reader.png, 64);
  png_read_info(reader.png, reader.info);
  png_get_IHDR(reader.png, reader.info, &header.width, &header.height, &header.bit_depth,
               &header.color_type, nullptr, nullptr, nullptr);
  return true;
}

/// Asks for 8-bit RGB from any kind of PNG, or leaves grey as it is.
enum class Wanted { rgb8, grey8, grey16 };

bool prepare(Reader& reader, Wanted wanted, std::size_t& row_bytes) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  if (wanted == Wanted::rgb8) {
    png_set_expand(reader.png);
    png_set_scale_16(reader.png);
    png_set_gray_to_rgb(reader.png);
    png_set_strip_alpha(reader.png);
  } else if (wanted == Wanted::grey8) {
    png_set_expand_gray_1_2_4_to_8(reader.png);
  } else {
    png_set_swap(reader.png);  // PNG is big-endian, this program little-endian
  }
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  row_bytes = png_get_rowbytes(reader.png, reader.info);
  return true;
}

bool read_rows(Reader& reader, png_bytepp rows) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_read_image(reader.png, rows);
  png_read_end(reader.png, nullptr);
  return true;
}

std::string kind_of(const Header& header) {
  const char* kind = header.color_type == PNG_COLOR_TYPE_GRAY         ? "grey"
                     : header.color_type == PNG_COLOR_TYPE_GRAY_ALPHA ? "grey with alpha"
                     : header.color_type == PNG_COLOR_TYPE_PALETTE    ? "palette"
                                                                      : "colour";
  return std::to_string(header.bit_depth) + "-bit " + kind;
}

template <class Pixel>
Image<Pixel> decode(std::span<const std::uint8_t> bytes, const std::string& name, Wanted wanted) {
  if (!is_png(bytes)) throw std::runtime_error(name + ": not a PNG file");
  Reader reader;
  reader.rest = bytes;
  Header header;
  if (!read_header(reader, header))
    throw std::runtime_error(name + ": PNG: " + reader.message.text);
  check_image_size(name, header.width, header.height);
  const bool grey = header.color_type == PNG_COLOR_TYPE_GRAY;
  if (wanted == Wanted::grey8 && !(grey && header.bit_depth <= 8)) {
    throw std::runtime_error(name + ": a " + kind_of(header) + " PNG; expected 8-bit grey");
  }
  if (wanted == Wanted::grey16 && !(grey && header.bit_depth == 16)) {
    throw std::runtime_error(name + ": a " + kind_of(header) + " PNG; expected 16-bit grey");
  }
  // Deflate shrinks at most 1032 times, so a small file cannot ask for a large image.
  const std::uint64_t stored =
      png_get_rowbytes(reader.png, reader.info) * std::uint64_t{header.height};
  if (stored / 1032 > bytes.size()) {
    throw std::runtime_error(name + ": PNG: truncated: " + std::to_string(bytes.size()) +
                             " bytes cannot hold " + std::to_string(header.width) + " x " +
                             std::to_string(header.height) + " pixels");
  }
  std::size_t row_bytes = 0;
  if (!prepare(reader, wanted, row_bytes))
    throw std::runtime_error(name + ": PNG: " + reader.message.text);
  check_memory(name, bytes.size() + std::uint64_t{header.width} * header.height * sizeof(Pixel),
               "its pixels");
  Image<Pixel> image(static_cast<int>(header.width), static_cast<int>(header.height));
  if (row_bytes != header.width * sizeof(Pixel))
    throw std::runtime_error(name + ": PNG: unexpected row size");
  std::vector<png_bytep> rows;
  rows.reserve(header.height);
  for (int y = 0; y < image.height(); ++y)
    rows.push_back(reinterpret_cast<png_bytep>(image.row(y).data()));
  if (!read_rows(reader, rows.data()))
    throw std::runtime_error(name + ": PNG: " + reader.message.text);
  return image;
}

struct Writer {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint8_t> bytes;
  Message message;
  Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};

bool append(Writer& writer, const std::uint8_t* data, std::size_t count) {
  try {
    writer.bytes.insert(writer.bytes.end(), data, data + count);
    return true;
  } catch (const std::bad_alloc&) {  // must not leave through libpng
    return false;
  }
}

void write_data(png_structp png, png_bytep data, std::size_t count) {
  if (!append(*static_cast<Writer*>(png_get_io_ptr(png)), data, count))
    png_error(png, "out of memory");
}

void flush_nothing(png_structp) {}

bool write_rows(Writer& writer, const Header& header, png_bytepp rows) {
  writer.png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer.message, keep_error, ignore_warning);
  if (!writer.png) return false;
  if (setjmp(png_jmpbuf(writer.png))) return false;
  writer.info = png_create_info_struct(writer.png);
  if (!writer.info) return false;
  png_set_write_fn(writer.png, &writer, write_data, flush_nothing);
  // On noisy photographs level 2 with one filter is several times faster than the default, for
  // files 2 % larger.
  png_set_compression_level(writer.png, 2);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(writer.png, writer.info, header.width, header.height, header.bit_depth,
               header.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  if (header.bit_depth == 16) png_set_swap(writer.png);
  png_write_image(writer.png, rows);
  png_write_end(writer.png, nullptr);
  return true;
}

template <class Pixel>
std::vector<std::uint8_t> encode(const Image<Pixel>& image, int bit_depth, int color_type) {
  check_encodable(image.width(), image.height());
  Writer writer;
  std::vector<png_bytep> rows;
  rows.reserve(static_cast<std::size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y) {
    // libpng's interface lacks const; it only reads.
    rows.push_back(reinterpret_cast<png_bytep>(const_cast<Pixel*>(image.row(y).data())));
  }
  const Header header{static_cast<png_uint_32>(image.width()),
                      static_cast<png_uint_32>(image.height()), bit_depth, color_type};
  if (!write_rows(writer, header, rows.data()))
    throw std::runtime_error(std::string("PNG: ") + writer.message.text);
  return std::move(writer.bytes);
}

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(const_cast<png_bytep>(bytes.data()), 0, 8) == 0;
}

Image<Rgb8> decode_png_color(std::span<const std::uint8_t> bytes, const std::string& name) {
  return decode<Rgb8>(bytes, name, Wanted::rgb8);
}

Image<std::uint8_t> decode_png8(std::span<const std::uint8_t> bytes, const std::string& name) {
  return decode<std::uint8_t>(bytes, name, Wanted::grey8);
}

Image<std::uint16_t> decode_png16(std::span<const std::uint8_t> bytes, const std::string& name) {
  return decode<std::uint16_t>(bytes, name, Wanted::grey16);
}

std::vector<std::uint8_t> encode_png_pixels(const Image<Rgb8>& image) {
  return encode(image, 8, PNG_COLOR_TYPE_RGB);
}

std::vector<std::uint8_t> encode_png_pixels(const Image<std::uint8_t>& image) {
  return encode(image, 8, PNG_COLOR_TYPE_GRAY);
}

std::vector<std::uint8_t> encode_png_pixels(const Image<std::uint16_t>& image) {
  return encode(image, 16, PNG_COLOR_TYPE_GRAY);
}

}  // namespace cousin::imaging
