#include "collision/base/byte_stream.h"

#include <gtest/gtest.h>

namespace leeway::collision {
namespace {

std::vector<std::byte> written() {
  ByteWriter to;
  to.value(std::uint8_t{7});
  to.array(std::vector<double>{1.5, -2});
  to.array(std::vector<std::int32_t>{});
  to.value(2.5F);
  return to.take();
}

TEST(ByteStream, ReadsWhatWasWritten) {
  const std::vector<std::byte> bytes = written();
  ByteReader from(bytes);
  EXPECT_EQ(from.value<std::uint8_t>(), 7);
  const std::span<const double> numbers = from.view<double>();
  ASSERT_EQ(numbers.size(), 2U);
  EXPECT_EQ(numbers[1], -2);
  EXPECT_TRUE(from.array<std::int32_t>().empty());
  EXPECT_FALSE(from.atEnd());
  EXPECT_EQ(from.value<float>(), 2.5F);
  EXPECT_TRUE(from.atEnd());
  EXPECT_EQ(from.value<std::uint8_t>(), 0);
  EXPECT_TRUE(from.failed());
}

TEST(ByteStream, FailsForGoodWhereBytesAreMissing) {
  std::vector<std::byte> bytes = written();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ByteReader from(std::span<const std::byte>(bytes).first(size));
    from.value<std::uint8_t>();
    from.array<double>();
    from.array<std::int32_t>();
    from.value<float>();
    EXPECT_TRUE(from.failed()) << size;
    EXPECT_FALSE(from.atEnd());
  }
  // A length beyond any possible one.
  std::fill_n(bytes.begin() + 1, 8, std::byte{0xff});
  ByteReader from(bytes);
  from.value<std::uint8_t>();
  EXPECT_TRUE(from.view<double>().empty());
  EXPECT_TRUE(from.failed());
}

TEST(ByteStream, RefusesBytesThatAreNotAligned) {
  const std::vector<std::byte> bytes = written();
  EXPECT_TRUE(ByteReader(std::span<const std::byte>(bytes).subspan(1)).failed());
}

}  // namespace
}  // namespace leeway::collision
