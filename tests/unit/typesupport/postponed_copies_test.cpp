// Postponed copies: a few bytes are copied at a time, and never more bytes than announced.
#include "sft/detail/postponed_copies.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace sft {
namespace {

using namespace detail;

/// The value is "abcdefghijklmnopqrstuvwxyz". The body has dots until its letters are copied.
class PostponedCopiesTest : public ::testing::Test {
 protected:
  PostponedCopiesTest() { body_.fill('.'); }

  bool postpone(std::size_t at, std::size_t bytes) { return copies_.add(place(at), source(at), bytes); }
  std::string body() const { return {body_.data(), body_.size()}; }
  /// Returns the bytes that a reader finds if it looks up the whole body now.
  std::string located() {
    const Segment whole{place(0), body_.size()};
    std::vector<Segment> parts;
    copies_.locate({&whole, 1}, parts);
    std::string found;
    for (const Segment& part : parts) found.append(reinterpret_cast<const char*>(part.data), part.bytes);
    return found;
  }

  PostponedCopies copies_{4};

 private:
  std::byte* place(std::size_t at) { return reinterpret_cast<std::byte*>(&body_[at]); }
  const std::byte* source(std::size_t at) const { return reinterpret_cast<const std::byte*>(&letters_[at]); }

  const std::string letters_ = "abcdefghijklmnopqrstuvwxyz";
  std::array<char, 26> body_{};
};

TEST_F(PostponedCopiesTest, AreMadeOfAsManyBytesAsIsSaid) {
  ASSERT_TRUE(postpone(0, 6));
  ASSERT_TRUE(postpone(10, 6));
  copies_.make(4);
  EXPECT_EQ(body(), "abcd......................");
  copies_.make(4);
  EXPECT_EQ(body(), "abcdef....kl..............");
  EXPECT_FALSE(copies_.empty());
  copies_.make(4);
  EXPECT_EQ(body(), "abcdef....klmnop..........");
  EXPECT_TRUE(copies_.empty());
}

TEST_F(PostponedCopiesTest, AreFoundWhereTheyAreUntilThen) {
  ASSERT_TRUE(postpone(2, 6));
  ASSERT_TRUE(postpone(10, 6));
  for (const std::size_t bytes : {0, 1, 4, 6, 1}) {
    copies_.make(bytes);
    EXPECT_EQ(located(), "..cdefgh..klmnop..........");
  }
  EXPECT_EQ(body(), "..cdefgh..klmnop..........");
}

TEST_F(PostponedCopiesTest, ThatAreShortOrTooManyAreNotTaken) {
  EXPECT_FALSE(postpone(0, 3));
  for (std::size_t i = 0; i < 8; ++i) EXPECT_TRUE(postpone(0, 4));
  EXPECT_FALSE(postpone(0, 4));
  copies_.clear();
  EXPECT_TRUE(copies_.empty());
  EXPECT_TRUE(postpone(0, 4));
}

}  // namespace
}  // namespace sft
