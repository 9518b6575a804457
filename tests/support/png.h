#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace leeway {

/// A PNG for tests, written without compression.
struct PngWriter {
  std::uint32_t width = 1, height = 1;
  int bits = 16;
  int color = 0;  ///< 0: grey
  bool interlaced = false;

  /// `values` row by row. Below 8 bits they share bytes, and with colours each fills all channels.
  std::string write(const std::vector<std::uint16_t>& values) const {
    std::string rows;
    struct Pass {
      std::uint32_t x, y, dx, dy;
    };
    static constexpr Pass kAdam7[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                      {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    const auto add = [&](const Pass& pass) {
      if (pass.x >= width) return;
      for (std::uint32_t y = pass.y; y < height; y += pass.dy) {
        rows.push_back('\0');  // no filter
        int free_bits = 0;
        for (std::uint32_t x = pass.x; x < width; x += pass.dx) {
          const unsigned value = values[std::size_t{y} * width + x];
          for (int c = 0; c < (color == 0 ? 1 : color == 4 ? 2 : 3); ++c) {
            if (bits == 16) rows.push_back(static_cast<char>(value >> 8U));
            if (bits >= 8) rows.push_back(static_cast<char>(value));
          }
          if (bits >= 8) continue;
          if (free_bits == 0) {
            rows.push_back('\0');
            free_bits = 8;
          }
          free_bits -= bits;
          rows.back() = static_cast<char>(static_cast<unsigned char>(rows.back()) |
                                          (value << static_cast<unsigned>(free_bits)));
        }
      }
    };
    if (interlaced)
      for (const Pass& pass : kAdam7) add(pass);
    else
      add({0, 0, 1, 1});
    std::string header = word(width) + word(height);
    header.push_back(static_cast<char>(bits));
    header.push_back(static_cast<char>(color));
    header += std::string(2, '\0') + (interlaced ? '\1' : '\0');
    return "\x89PNG\r\n\x1A\n" + chunk("IHDR", header) + chunk("IDAT", stored(rows)) +
           chunk("IEND", "");
  }

  static std::string word(std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8)
      bytes.push_back(static_cast<char>(value >> static_cast<unsigned>(shift)));
    return bytes;
  }
  static std::string chunk(const std::string& name, const std::string& data) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const char c : name + data) {
      crc ^= static_cast<unsigned char>(c);
      for (int k = 0; k < 8; ++k) crc = (crc & 1U) != 0 ? 0xEDB88320U ^ (crc >> 1U) : crc >> 1U;
    }
    return word(static_cast<std::uint32_t>(data.size())) + name + data + word(~crc);
  }

 private:
  /// A zlib stream of blocks that are stored as they are.
  static std::string stored(const std::string& data) {
    std::string bytes("\x78\x01", 2);
    std::uint32_t a = 1, b = 0;
    for (const char c : data) {
      a = (a + static_cast<unsigned char>(c)) % 65521;
      b = (b + a) % 65521;
    }
    for (std::size_t at = 0; at == 0 || at < data.size(); at += 65535) {
      const std::string block = data.substr(at, 65535);
      bytes.push_back(at + 65535 >= data.size() ? '\1' : '\0');
      for (const std::size_t size : {block.size(), ~block.size()}) {
        bytes.push_back(static_cast<char>(size));
        bytes.push_back(static_cast<char>(size >> 8U));
      }
      bytes += block;
    }
    return bytes + word(b << 16U | a);
  }
};

}  // namespace leeway
