#include "planner/sensed/gray_image.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

#include "leeway/robots/text.h"
#include "planner/sensed/cloud_source.h"
#include "robots/base/read_file.h"
#include "robots/mesh/scan.h"

namespace leeway::planner {
namespace {

constexpr std::size_t kMostPixels = std::size_t{1} << 26U;

void requirePixels(const CloudSource& source, std::size_t width, std::size_t height,
                   CloudPlace place) {
  if (width > 0 && height > 0 && height <= kMostPixels / width) return;
  source.fail(place, fmt::format("the picture has {} x {} pixels; at least one and up to {} are "
                                 "accepted",
                                 width, height, kMostPixels));
}

// PNG

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1A\n", 8);

/// The state that libpng's callbacks share. libpng reports errors by long jumps, which must not
/// skip the destructor of any object.
struct PngReading {
  const char* at;
  const char* end;
  char message[120];
  png_structp png;
  png_infop info;
};

void readPngBytes(png_structp png, png_bytep to, std::size_t count) {
  auto& reading = *static_cast<PngReading*>(png_get_io_ptr(png));
  if (static_cast<std::size_t>(reading.end - reading.at) < count)
    png_error(png, "the file ends early");
  std::memcpy(to, reading.at, count);
  reading.at += count;
}

[[noreturn]] void keepPngError(png_structp png, png_const_charp message) {
  auto& reading = *static_cast<PngReading*>(png_get_error_ptr(png));
  std::strncpy(reading.message, message, sizeof reading.message - 1);
  png_longjmp(png, 1);
}

void ignorePngWarning(png_structp, png_const_charp) {}

/// False for an error, which is in `reading`.
bool readPngHeader(PngReading& reading) {
  if (setjmp(png_jmpbuf(reading.png)) != 0) return false;
  png_set_read_fn(reading.png, &reading, readPngBytes);
  png_read_info(reading.png, reading.info);
  png_set_packing(reading.png);
  png_set_interlace_handling(reading.png);
  png_read_update_info(reading.png, reading.info);
  return true;
}

bool readPngRows(PngReading& reading, png_bytep* rows) {
  if (setjmp(png_jmpbuf(reading.png)) != 0) return false;
  png_read_image(reading.png, rows);
  png_read_end(reading.png, nullptr);
  return true;
}

class PngFile {
 public:
  explicit PngFile(const CloudSource& source)
      : source_(source),
        reading_{source.text().data(),
                 source.text().data() + source.text().size(),
                 {},
                 nullptr,
                 nullptr} {
    reading_.png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading_, keepPngError, ignorePngWarning);
    if (reading_.png != nullptr) reading_.info = png_create_info_struct(reading_.png);
    if (reading_.info == nullptr) throw std::bad_alloc();
  }
  ~PngFile() { png_destroy_read_struct(&reading_.png, &reading_.info, nullptr); }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  GrayImage read() {
    if (!source_.text().starts_with(kPngSignature))
      source_.fail({}, "does not begin as a PNG does; a grey PNG is expected");
    if (!readPngHeader(reading_)) fail();
    GrayImage image;
    image.width = png_get_image_width(reading_.png, reading_.info);
    image.height = png_get_image_height(reading_.png, reading_.info);
    requirePixels(source_, image.width, image.height, {0, 16});
    const std::string_view header = source_.text().substr(24, 2);
    image.bits = static_cast<unsigned char>(header[0]);
    if (header[1] != PNG_COLOR_TYPE_GRAY)
      source_.fail({0, 25},
                   "the picture has colours, a palette or alpha; one channel of grey is "
                   "expected");
    readPixels(image);
    return image;
  }

 private:
  [[noreturn]] void fail() const {
    source_.fail({0, static_cast<std::size_t>(reading_.at - source_.text().data())},
                 fmt::format("is no PNG that can be read: {}", reading_.message));
  }

  void readPixels(GrayImage& image) {
    const std::size_t row_bytes = png_get_rowbytes(reading_.png, reading_.info);
    std::vector<png_byte> bytes(row_bytes * image.height);
    std::vector<png_bytep> rows(image.height);
    for (std::size_t r = 0; r < image.height; ++r) rows[r] = bytes.data() + r * row_bytes;
    source_.pause(0);
    if (!readPngRows(reading_, rows.data())) fail();
    image.values.resize(image.width * image.height);
    for (std::size_t i = 0; i < image.values.size(); ++i)
      image.values[i] = image.bits == 16
                            ? static_cast<std::uint16_t>(bytes[2 * i] << 8U | bytes[2 * i + 1])
                            : bytes[i];
  }

  const CloudSource& source_;
  PngReading reading_;
};

// PGM: https://netpbm.sourceforge.net/doc/pgm.html

class PgmFile {
 public:
  explicit PgmFile(const CloudSource& source) : source_(source), words_(source.text()) {}

  GrayImage read() {
    const std::string_view magic = nextWord();
    if (magic != "P2" && magic != "P5")
      source_.fail({1, 0}, fmt::format("begins with {}; P2 or P5, as a PGM does, is expected",
                                       robots::shown(magic)));
    GrayImage image;
    image.width = nextCount("the width");
    image.height = nextCount("the height");
    requirePixels(source_, image.width, image.height, place());
    greatest_ = nextCount("the greatest value");
    if (greatest_ < 1 || greatest_ > 65535)
      source_.fail(place(),
                   fmt::format("the greatest value is {}; 1 to 65535 is accepted", greatest_));
    image.bits = greatest_ > 255 ? 16 : 8;
    if (magic == "P2")
      readText(image);
    else
      readBytes(image);
    return image;
  }

 private:
  CloudPlace place() const { return {static_cast<std::size_t>(words_.line()), 0}; }

  /// The next word after comments, which end with their line.
  std::string_view nextWord() {
    std::string_view word = words_.next();
    while (word.starts_with('#')) {
      words_.restOfLine();
      word = words_.next();
    }
    last_ = word;
    return word;
  }

  std::size_t nextCount(std::string_view what) {
    const std::string_view word = nextWord();
    if (word.empty())
      source_.fail(place(), fmt::format("the file ends where {} is expected", what));
    return readCount(source_, word, what, place());
  }

  std::uint16_t checked(std::size_t value, std::size_t pixel, CloudPlace place) const {
    if (value > greatest_)
      source_.fail(place, fmt::format("pixel {} has the value {}; up to {}, as the header says, is "
                                      "accepted",
                                      pixel, value, greatest_));
    return static_cast<std::uint16_t>(value);
  }

  void readText(GrayImage& image) {
    const std::size_t count = image.width * image.height;
    // Each pixel but the last takes two bytes or more. This keeps a header that lies from using
    // memory.
    if (source_.text().size() < 2 * count - 1) failCut(image);
    image.values.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      source_.pause(i);
      const std::size_t value = nextCount(fmt::format("pixel {} of {}", i, count));
      image.values.push_back(checked(value, i, place()));
    }
    if (const std::string_view word = nextWord(); !word.empty())
      source_.fail(place(), fmt::format("{} stands after the last of {} x {} pixels; the end is "
                                        "expected",
                                        robots::shown(word), image.width, image.height));
    if (const char last = source_.text().back(); last >= '0' && last <= '9')
      source_.fail(place(),
                   "the file ends within its last number, which may have lost digits; a line end "
                   "behind it is expected");
  }

  void readBytes(GrayImage& image) {
    // One blank parts the header from the pixels.
    const std::size_t begin = std::min<std::size_t>(
        static_cast<std::size_t>(last_.data() + last_.size() - source_.text().data()) + 1,
        source_.text().size());
    const std::string_view bytes = source_.text().substr(begin);
    const std::size_t size = image.bits == 16 ? 2 : 1, count = image.width * image.height;
    if (bytes.size() < size * count) failCut(image);
    if (bytes.size() > size * count)
      source_.fail({0, begin + size * count},
                   fmt::format("{} bytes stand after the last of {} x {} pixels; the end is "
                               "expected",
                               bytes.size() - size * count, image.width, image.height));
    image.values.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = [&](std::size_t b) { return static_cast<unsigned char>(bytes[b]); };
      const unsigned value =
          size == 2 ? static_cast<unsigned>(at(2 * i)) << 8U | at(2 * i + 1) : at(i);
      image.values[i] = checked(value, i, {0, begin + size * i});
    }
  }

  [[noreturn]] void failCut(const GrayImage& image) const {
    source_.fail(
        {0, source_.text().size()},
        fmt::format("the file ends before the last of {} x {} pixels", image.width, image.height));
  }

  const CloudSource& source_;
  robots::Words words_;
  std::string_view last_;
  std::size_t greatest_ = 0;
};

}  // namespace

GrayImage readGrayImage(const std::string& path, std::string_view kind, const robots::Stop& stop) {
  const std::string ending = robots::endingOf(path);
  if (ending != ".png" && ending != ".pgm")
    throw robots::InputError(
        path, 0,
        fmt::format("has the ending '{}', where {} is expected; .png and .pgm are accepted", ending,
                    kind));
  const CloudSource source = readSource(path, kind, stop);
  return ending == ".png" ? PngFile(source).read() : PgmFile(source).read();
}

}  // namespace leeway::planner
