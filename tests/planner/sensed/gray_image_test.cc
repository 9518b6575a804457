// Pictures with one channel: every form, and every kind of damage.

#include "planner/sensed/gray_image.h"

#include <gtest/gtest.h>

#include <random>

#include "leeway/robots/input_error.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/png.h"

namespace leeway::planner {
namespace {

class GrayImages : public testing::Test {
 protected:
  GrayImage read(const std::string& name, const std::string& contents) {
    return readGrayImage(folder_.write(name, contents), "a depth image", {});
  }
  void expectError(const std::string& name, const std::string& contents, int line,
                   std::initializer_list<std::string> words) {
    SCOPED_TRACE(name + ": " + contents.substr(0, 60));
    const std::string path = folder_.write(name, contents);
    robots::expectInputError([&] { readGrayImage(path, "a depth image", {}); }, path, line, words);
  }
  Folder folder_;
};

std::vector<std::uint16_t> randomValues(std::size_t count, int bits) {
  std::mt19937 random(7);
  std::vector<std::uint16_t> values(count);
  for (std::uint16_t& value : values)
    value = static_cast<std::uint16_t>(random() & ((1U << static_cast<unsigned>(bits)) - 1));
  return values;
}

TEST_F(GrayImages, PngsOfAllDepthsAreReadAsStored) {
  for (const int bits : {1, 2, 4, 8, 16})
    for (const bool interlaced : {false, true})
      for (const auto& [width, height] : {std::pair{1U, 1U}, {3U, 2U}, {13U, 9U}, {400U, 301U}}) {
        SCOPED_TRACE(testing::Message() << bits << " bits, " << width << " x " << height);
        const auto values = randomValues(std::size_t{width} * height, bits);
        const GrayImage image =
            read("a.PNG", PngWriter{width, height, bits, 0, interlaced}.write(values));
        EXPECT_EQ(image.width, width);
        EXPECT_EQ(image.height, height);
        EXPECT_EQ(image.bits, bits);
        EXPECT_EQ(image.values, values);
      }
}

TEST_F(GrayImages, GammaAndSignificantBitsChangeNoValue) {
  const std::vector<std::uint16_t> values = {1, 300, 40000, 65535};
  std::string png = PngWriter{2, 2, 16}.write(values);
  png.insert(8 + 25, PngWriter::chunk("gAMA", PngWriter::word(45455)) +
                         PngWriter::chunk("sBIT", std::string(1, '\x0C')) +
                         PngWriter::chunk("tRNS", std::string("\x01\x2C", 2)));
  EXPECT_EQ(read("a.png", png).values, values);
}

TEST_F(GrayImages, PgmsOfBothKinds) {
  const std::vector<std::uint16_t> values = {0, 1, 255, 256, 4000, 65535};
  const std::string text = "P2 # a comment 9 9\n# another\n 3\t2\n65535\n0 1 255\n256 4000 65535\n";
  EXPECT_EQ(read("a.pgm", text).values, values);
  EXPECT_EQ(read("a.pgm", text + " \n").width, 3U);
  const std::string bytes("\0\0\0\1\0\xFF\1\0\x0F\xA0\xFF\xFF", 12);
  EXPECT_EQ(read("a.pgm", "P5\n3 2\n65535\n" + bytes).values, values);
  // A blank, of whichever kind, ends the header; the pixels may look like blanks or comments.
  const GrayImage small = read("a.pgm", "P5 2 2 200 #\n \t");
  EXPECT_EQ(small.values, (std::vector<std::uint16_t>{'#', '\n', ' ', '\t'}));
  EXPECT_EQ(small.bits, 8);
}

TEST_F(GrayImages, DamagedPngsAreRefused) {
  const std::string good = PngWriter{4, 3, 16}.write(randomValues(12, 16));
  const std::vector<std::uint16_t> values = read("a.png", good).values;
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_THROW(read("a.png", good.substr(0, size)), robots::InputError) << size;
  int refused = 0;
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x11);
    try {
      EXPECT_EQ(read("a.png", bad).values, values) << at;
    } catch (const robots::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 60);
  expectError("a.png", "P5\n", 0, {"byte 0", "does not begin as a PNG does"});
  expectError("a.png", good.substr(0, good.size() - 20), 0, {"byte", "the file ends early"});
  expectError("a.png", "version https://git-lfs.github.com/spec/v1\n", 0, {"pointer of Git LFS"});
  expectError("a.tif", good, 0, {"'.tif'", "a depth image", ".png and .pgm"});
  for (const int color : {2, 4})
    expectError("a.png", PngWriter{1, 1, 8, color}.write({7}), 0, {"one channel of grey"});
  // A header that lies costs no memory.
  std::string lies = PngWriter{1, 1, 16}.write({7});
  const std::string size = PngWriter::word(900000);
  lies.replace(8, 25, PngWriter::chunk("IHDR", size + size + std::string("\x10\0\0\0\0", 5)));
  expectError("a.png", lies, 0, {"900000 x 900000 pixels", "67108864"});
}

TEST_F(GrayImages, DamagedPgmsNameTheLineOrByte) {
  expectError("a.pgm", "", 1, {"P2 or P5"});
  expectError("a.pgm", "P3\n1 1 9\n1", 1, {"'P3'"});
  expectError("a.pgm", "P2\n", 2, {"ends where the width"});
  expectError("a.pgm", "P2\n2 x 9\n", 2, {"the height is 'x'"});
  expectError("a.pgm", "P2\n2 -1 9\n", 2, {"the height is '-1'"});
  expectError("a.pgm", "P2\n0 1 9\n", 2, {"0 x 1 pixels"});
  expectError("a.pgm", "P2\n2000000000 2000000000 9\n1", 2, {"pixels; at least one"});
  expectError("a.pgm", "P2\n8000 8000 9\n1 2", 0, {"byte 18", "ends before the last of 8000"});
  expectError("a.pgm", "P2\n1 1\n0\n1", 3, {"the greatest value is 0"});
  expectError("a.pgm", "P2\n1 1\n65536\n1", 3, {"the greatest value is 65536"});
  expectError("a.pgm", "P2\n2 1\n9\n1\n10", 5, {"pixel 1 has the value 10; up to 9"});
  expectError("a.pgm", "P2\n2 1\n9\n1\n1.5", 5, {"'1.5'"});
  expectError("a.pgm", "P2\n2 2\n9\n1 2 3    ", 4, {"ends where pixel 3 of 4"});
  expectError("a.pgm", "P2\n1 1\n9\n1\n2", 5, {"'2' stands after the last"});
  expectError("a.pgm", "P2\n2 1\n99\n12\n3", 5, {"ends within its last number"});
  expectError("a.pgm", "P5 1 2 9\n\1", 0, {"byte 10", "ends before the last of 1 x 2"});
  expectError("a.pgm", "P5 1 2 300\n\1\1\1", 0, {"ends before the last"});
  expectError("a.pgm", "P5 1 2 9\n\1\2\3", 0, {"byte 11", "1 bytes stand after"});
  expectError("a.pgm", "P5 1 2 9\n\1\x0A", 0, {"byte 10", "pixel 1 has the value 10"});
  expectError("a.pgm", "P5 1 2 9", 0, {"byte 8", "ends before the last"});
}

}  // namespace
}  // namespace leeway::planner
