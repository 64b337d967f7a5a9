#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cousin {

enum class ByteOrder { little, big };

/// Writes the EXIF block that a test wants: tags of the first directory and of EXIF's own.
class ExifWriter {
 public:
  explicit ExifWriter(ByteOrder order) : order_(order) {}
  void add_short(bool is_exif, unsigned tag, unsigned value) {
    rows(is_exif).push_back({tag, 3, 1, {value}, {}});
  }
  void add_long(bool is_exif, unsigned tag, unsigned value) {
    rows(is_exif).push_back({tag, 4, 1, {value}, {}});
  }
  void add_ratio(bool is_exif, unsigned tag, unsigned above, unsigned below) {
    rows(is_exif).push_back({tag, 5, 1, {above, below}, {}});
  }
  void add_text(unsigned tag, const std::string& text) {
    first_.push_back({tag, 2, static_cast<unsigned>(text.size() + 1), {}, text + '\0'});
  }

  /// "Exif\0\0" and the TIFF file.
  std::string block() const {
    const std::size_t first_at = 8, exif_at = first_at + 2 + 12 * (first_.size() + 1) + 4;
    std::size_t data_at = exif_at + 2 + 12 * exif_.size() + 4;
    std::string text = order_ == ByteOrder::big ? "MM" : "II", data;
    put(text, 42, 2);
    put(text, first_at, 4);
    const auto directory = [&](std::vector<Row> rows) {
      put(text, rows.size(), 2);
      for (const Row& row : rows) {
        put(text, row.tag, 2);
        put(text, row.type, 2);
        put(text, row.count, 4);
        std::string value = row.text;
        for (const unsigned number : row.numbers) put(value, number, row.type == 3 ? 2 : 4);
        if (value.size() <= 4) {
          value.resize(4);
          text += value;
        } else {
          put(text, data_at + data.size(), 4);
          data += value;
        }
      }
      put(text, 0, 4);
    };
    std::vector<Row> first = first_;
    first.push_back({0x8769, 4, 1, {static_cast<unsigned>(exif_at)}, {}});
    directory(first);
    directory(exif_);
    return std::string("Exif\0\0", 6) + text + data;
  }

 private:
  struct Row {
    unsigned tag, type, count;
    std::vector<unsigned> numbers;
    std::string text;
  };
  std::vector<Row>& rows(bool is_exif) { return is_exif ? exif_ : first_; }
  void put(std::string& to, std::size_t number, std::size_t size) const {
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t shift = 8 * (order_ == ByteOrder::big ? size - 1 - i : i);
      to += static_cast<char>(number >> shift & 255);
    }
  }
  ByteOrder order_;
  std::vector<Row> first_, exif_;
};

/// The JPEG file with that block in it.
inline std::vector<std::uint8_t> with_exif(const std::vector<std::uint8_t>& jpeg,
                                           const std::string& block) {
  const std::size_t length = block.size() + 2;
  std::vector<std::uint8_t> file = {0xFF,
                                    0xD8,
                                    0xFF,
                                    0xE1,
                                    static_cast<std::uint8_t>(length >> 8),
                                    static_cast<std::uint8_t>(length & 255)};
  file.insert(file.end(), block.begin(), block.end());
  file.insert(file.end(), jpeg.begin() + 2, jpeg.end());
  return file;
}

}  // namespace cousin
