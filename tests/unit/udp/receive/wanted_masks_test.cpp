// These tests check the mask that is found for a datagram, given the masks that the readers of this process
// request.
#include "udp_transport/receive/wanted_masks.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "tests/unit/udp/messages.h"

namespace sft::udp {
namespace {

using test::fields;
using test::Image;
using test::Wide;
using Member = StructType::Member;

/// Returns a type with a sequence of structs. The leaves of the type are elements.size, elements[].a,
/// elements[].b and last.
const TypeSupport& type_with_elements() {
  static const std::array element_members{Member{.name = "a", .kind = Member::Kind::uint32},
                                          Member{.name = "b", .kind = Member::Kind::uint32}};
  static const StructType element("test::Element", element_members);
  static const std::array members{Member{.name = "elements",
                                         .kind = Member::Kind::structure,
                                         .shape = Member::Shape::sequence,
                                         .type = &element},
                                  Member{.name = "last", .kind = Member::Kind::uint32}};
  static const StructType type("test::Elements", members);
  static const TypeSupport support(type);
  return support;
}

class WantedMasksTest : public testing::Test {
 protected:
  WantedMasksTest() { want({"height", "data"}); }

  void want(std::initializer_list<const char*> masks) {
    std::vector<Selection> all;
    for (const char* mask : masks) all.push_back(fields<Image>(mask));
    wanted_.set(test::type_support<Image>(), all);
  }
  void want_wide(const FieldMask& mask) {
    const Selection all(mask);
    wanted_.set(test::type_support<Wide>(), {&all, 1});
  }

  /// Makes a short datagram that names the mask. Returns the mask that is found for the datagram.
  WantedMasks::Named named(const FieldMask& mask, std::uint8_t flags = 0) {
    datagram_ = {};
    datagram_.kind = DatagramKind::first;
    datagram_.first.flags = flags;
    datagram_.first.mask = mask.hash();
    payload_.clear();
    if ((flags & mask_words_follow) != 0) payload_ = mask.to_words();
    payload_.push_back(0x1122334455667788);
    return name();
  }
  /// Returns the mask that is found for the present datagram.
  WantedMasks::Named name() {
    datagram_.payload = std::as_bytes(std::span(payload_));
    return wanted_.named_by(datagram_);
  }
  WantedMasks::Named merged(const char* mask) { return named(fields<Image>(mask), merged_masks); }

  static constexpr std::uint8_t with_words = mask_words_follow | merged_masks;
  WantedMasks wanted_;
  Datagram datagram_;
  std::vector<std::uint64_t> payload_;
};

TEST_F(WantedMasksTest, KnowTheMasksThatAreWantedAndNoOthers) {
  const auto data = named(fields<Image>("data"));
  ASSERT_NE(data.mask, nullptr);
  EXPECT_EQ(*data.mask, fields<Image>("data"));
  const auto other = named(fields<Image>("data, height"));
  EXPECT_EQ(other.mask, nullptr);
  EXPECT_FALSE(other.malformed);
}

TEST_F(WantedMasksTest, KnowPartsOfFieldsByTheirHash) {
  const TypeSupport& type = test::type_support<Image>();
  const auto some = type.closed(type.parse_selection("data[::2]").value());
  const auto others = type.closed(type.parse_selection("data[::3]").value());
  const Selection all[] = {fields<Image>("data"), some};
  wanted_.set(type, all);
  EXPECT_EQ(named(fields<Image>("data")).parts, 0U);
  datagram_.first.mask = some.what_hash();
  const auto part = name();
  ASSERT_NE(part.mask, nullptr);
  EXPECT_EQ(*part.mask, fields<Image>("data"));
  EXPECT_EQ(part.parts, some.parts_hash());
  datagram_.first.mask = others.what_hash();
  EXPECT_EQ(name().mask, nullptr) << "nobody asked for it";
  EXPECT_EQ(merged("data, height").parts, 0U) << "a union has whole fields";
}

TEST_F(WantedMasksTest, KnowEachOfManySelections) {
  std::vector<Selection> all;
  for (int begin = 0; begin < 1000; ++begin)
    all.push_back(test::selection_of<Image>("data[" + std::to_string(begin) + ":2000]"));
  wanted_.set(test::type_support<Image>(), all);
  for (const Selection& selection : all) {
    (void)named(fields<Image>("data"));
    datagram_.first.mask = selection.hash();
    const WantedMasks::Named name = this->name();
    ASSERT_NE(name.mask, nullptr);
    EXPECT_EQ(name.parts, selection.parts_hash());
  }
}

/// Every host that can send to a group can forge datagrams with any hash of a selection and any flags.
TEST_F(WantedMasksTest, TakeNothingUnderAHashThatNobodyAskedFor) {
  const TypeSupport& type = test::type_support<Image>();
  const Selection asked = test::selection_of<Image>("data[::3]");
  wanted_.set(type, {&asked, 1});
  std::vector<std::uint64_t> hashes{0, ~std::uint64_t{0}, fields<Image>("data").hash(),
                                    test::selection_of<Image>("data[::3] @ height > 4").hash()};
  for (int step = 2; step < 100; ++step) {
    const std::string text = "data[::" + std::to_string(step) + "]";
    if (step != 3) hashes.push_back(test::selection_of<Image>(text).hash());
  }
  for (unsigned bit = 0; bit < 64; ++bit) hashes.push_back(asked.hash() ^ std::uint64_t{1} << bit);
  for (const std::uint64_t hash : hashes) {
    for (const std::uint8_t flag : {group_follows, merged_masks}) {
      (void)named(fields<Image>("data"), flag);
      datagram_.first.mask = hash;
      const WantedMasks::Named name = this->name();
      if (name.mask == nullptr) continue;
      EXPECT_EQ(flag, merged_masks) << hash;
      EXPECT_EQ(name.mask->hash(), hash) << "it is a mask, of whole fields";
      EXPECT_TRUE(name.mask->contains(asked.mask()));
      EXPECT_EQ(name.parts, 0U);
      EXPECT_EQ(name.conditions, 0U);
    }
  }
  (void)named(fields<Image>("data"), merged_masks);
  datagram_.first.mask = asked.hash();
  EXPECT_TRUE(name().malformed) << "a selection with parts is no union";
}

TEST_F(WantedMasksTest, KnowConditionsByTheirHash) {
  const TypeSupport& type = test::type_support<Image>();
  const Selection wide = type.closed(type.parse_selection("data @ width > 5 at most 10 Hz").value());
  const Selection all[] = {fields<Image>("data"), wide.without_rate()};
  wanted_.set(type, all);
  EXPECT_EQ(named(fields<Image>("data")).conditions, 0U);
  datagram_.first.mask = all[1].hash();
  const auto gated = name();
  ASSERT_NE(gated.mask, nullptr);
  EXPECT_EQ(*gated.mask, fields<Image>("data"));
  EXPECT_EQ(gated.parts, 0U);
  EXPECT_EQ(gated.conditions, all[1].gate_hash());
  datagram_.first.mask = wide.hash();
  EXPECT_EQ(name().mask, nullptr) << "the rate stands beside the name";
}

TEST_F(WantedMasksTest, TakeAMergedMaskThatContainsAWantedOne) {
  const auto both = merged("data, width");
  ASSERT_NE(both.mask, nullptr);
  EXPECT_EQ(*both.mask, fields<Image>("data, width"));
  const auto neither = merged("stamp, width");
  EXPECT_EQ(neither.mask, nullptr);
  EXPECT_FALSE(neither.malformed);
  EXPECT_NE(merged("data").mask, nullptr) << "it contains itself";
}

TEST_F(WantedMasksTest, ForgetMergedMasksOnceOthersAreWanted) {
  ASSERT_NE(merged("data, width").mask, nullptr);
  want({"stamp"});
  EXPECT_EQ(merged("data, width").mask, nullptr);
  EXPECT_NE(merged("stamp, width").mask, nullptr);
}

TEST_F(WantedMasksTest, RefuseAMergedMaskWithBitsThatTheTypeDoesNotHave) {
  ASSERT_NE(merged("*").mask, nullptr);
  datagram_.first.mask |= std::uint64_t{1} << 63;
  EXPECT_TRUE(name().malformed);
}

TEST_F(WantedMasksTest, RefuseAMergedMaskThatHasElementsWithoutTheirNumber) {
  const TypeSupport& type = type_with_elements();
  const FieldMask last = *type.parse_mask("last"), elements = *type.parse_mask("last elements[].a");
  const Selection wanted(last);
  wanted_.set(type, {&wanted, 1});
  EXPECT_TRUE(named(elements, merged_masks).malformed);
  EXPECT_NE(named(type.closed(elements), merged_masks).mask, nullptr);
  EXPECT_NE(named(type.closed(*type.parse_mask("last")), merged_masks).mask, nullptr);
}

TEST_F(WantedMasksTest, TakeTheWordsOfALongMaskOffThePayload) {
  want_wide(fields<Wide>("first"));
  const auto plain = named(fields<Wide>("first"), mask_words_follow);
  ASSERT_NE(plain.mask, nullptr);
  EXPECT_EQ(datagram_.payload.size(), 8U);
  const auto more = named(fields<Wide>("first, third"), with_words);
  ASSERT_NE(more.mask, nullptr);
  EXPECT_EQ(*more.mask, fields<Wide>("first, third"));
  EXPECT_EQ(datagram_.payload.size(), 8U);
}

TEST_F(WantedMasksTest, CountTheWordsOfAWholeDatagramNotAsItsBody) {
  want_wide(fields<Wide>("first"));
  named(fields<Wide>("first"), mask_words_follow);
  datagram_.kind = DatagramKind::whole;
  datagram_.first.total = 24;
  ASSERT_NE(name().mask, nullptr);
  EXPECT_EQ(datagram_.first.total, 8U);
}

TEST_F(WantedMasksTest, RefuseWordsThatAreNotThereOrNotNeededOrOfAnotherMask) {
  EXPECT_TRUE(named(fields<Image>("data"), mask_words_follow).malformed);
  EXPECT_TRUE(named(fields<Image>("data"), with_words).malformed);
  want_wide(fields<Wide>("first"));
  named(fields<Wide>("first"), with_words);
  payload_.resize(1);
  EXPECT_TRUE(name().malformed);
  named(fields<Wide>("first, second"), with_words);
  payload_[0] ^= 1;
  EXPECT_TRUE(name().malformed);
  EXPECT_EQ(named(fields<Wide>("second"), mask_words_follow).mask, nullptr);
}

TEST_F(WantedMasksTest, BelieveNoHashWhereTheWordsSayAnotherMask) {
  want_wide(fields<Wide>("first"));
  named(fields<Wide>("first"), mask_words_follow);
  payload_[1] ^= 1;
  EXPECT_EQ(name().mask, nullptr);
}

TEST_F(WantedMasksTest, KnowALongMergedMaskByItsHashOnceItsWordsCame) {
  want_wide(fields<Wide>("first"));
  const FieldMask both = fields<Wide>("first, third");
  EXPECT_TRUE(named(both, merged_masks).malformed) << "nobody can tell which mask that is";
  ASSERT_NE(named(both, with_words).mask, nullptr);
  const auto by_hash = named(both, merged_masks);
  ASSERT_NE(by_hash.mask, nullptr);
  EXPECT_EQ(*by_hash.mask, both);
}

TEST_F(WantedMasksTest, RememberEightMergedMasksAndForgetTheOldest) {
  want_wide(fields<Wide>("first"));
  std::vector<FieldMask> masks;
  for (const char* second : {"second.a", "second.b", "second.c", "second.d", "second.e", "second.f",
                             "second.g", "second.h", "second.i"})
    masks.push_back(fields<Wide>(std::string("first, ") + second));
  for (std::size_t i = 0; i < 8; ++i) ASSERT_NE(named(masks[i], with_words).mask, nullptr);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NE(named(masks[i], merged_masks).mask, nullptr) << i;
  ASSERT_NE(named(masks[8], with_words).mask, nullptr);
  EXPECT_TRUE(named(masks[0], merged_masks).malformed);
  for (std::size_t i = 1; i < 9; ++i) EXPECT_NE(named(masks[i], merged_masks).mask, nullptr) << i;
}

}  // namespace
}  // namespace sft::udp
