// Types as bytes: a description is read back as the same type, and other bytes are refused.
#include "sft/detail/type_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

#include "sft/dynamic_type.h"
#include "tests/support/message_types.h"
#include "tests/support/test_seed.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using test::MessageType;
using ::testing::HasSubstr;

using Bytes = std::vector<std::byte>;

class EachType : public ::testing::TestWithParam<MessageType> {};

TEST_P(EachType, ComesBackFromItsDescriptionWithItsHashNameAndPaths) {
  const TypeSupport& compiled = *GetParam().support;
  const auto parsed = DynamicType::parse(describe(compiled.type()));
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(parsed->hash(), compiled.hash());
  EXPECT_EQ(parsed->support().hash(), compiled.hash());
  EXPECT_EQ(parsed->name(), compiled.name());
  EXPECT_EQ(parsed->support().index_slots(), compiled.index_slots());
  ASSERT_EQ(parsed->support().leaves(), compiled.leaves());
  for (std::size_t leaf = 0; leaf < compiled.leaves(); ++leaf)
    EXPECT_EQ(parsed->support().path(leaf), compiled.path(leaf));
}

TEST_P(EachType, KnowsTheFirstLeafOfEachMember) {
  const auto parsed = DynamicType::parse(describe(GetParam().type())).value();
  ASSERT_EQ(parsed.type().first_leaves.size(), parsed.type().members.size());
  for (std::size_t i = 0; i < parsed.type().members.size(); ++i)
    EXPECT_EQ(parsed.type().first_leaves[i], leaf_offset(parsed.type(), i));
}

TEST_P(EachType, IsDescribedInTheSameBytesAfterParsing) {
  const Bytes bytes = describe(GetParam().type());
  const auto parsed = DynamicType::parse(bytes).value();
  EXPECT_EQ(describe(parsed.type()), bytes);
  EXPECT_EQ(Bytes(parsed.description().begin(), parsed.description().end()), bytes);
}

INSTANTIATE_TEST_SUITE_P(Of, EachType,
                         ::testing::ValuesIn(test::all_types().begin(), test::all_types().end()),
                         [](const auto& type) { return type.param.short_name(); });

TEST(TypeDescriptionTest, KeepsUnitsKeysBoundsAndEnumerators) {
  const auto type = DynamicType::parse(describe(TypeTable<torture::Nested>::type)).value();
  const Member* speed = nullptr;
  for (const Member& m : type.type().members) speed = m.name == "speed" ? &m : speed;
  ASSERT_NE(speed, nullptr);
  EXPECT_EQ(speed->unit, "m/s");
  EXPECT_TRUE(speed->key);
  const auto bounded = DynamicType::parse(describe(TypeTable<proof::Bounded>::type)).value();
  EXPECT_EQ(bounded.type().members[0].string_bound, 8U);
  EXPECT_EQ(bounded.type().members[4].bound, 3U);
}

TEST(TypeDescriptionTest, OfAPointCloudTakesAFewHundredBytes) {
  EXPECT_EQ(describe(TypeTable<PointCloud2>::type).size(), 291U);
}

TEST(TypeDescriptionTest, ATypeOutlivesTheHandleThatWasParsed) {
  std::optional<DynamicType> first = DynamicType::parse(describe(TypeTable<PointCloud2>::type)).value();
  const DynamicType second = *first;
  const StructType* type = &first->type();
  first.reset();
  EXPECT_EQ(&second.type(), type);
  EXPECT_EQ(second.type().members[1].name, "height");
}

// ---- hostile bytes ----

/// A description written by hand.
class Handmade {
 public:
  Handmade& number(std::uint64_t n) {
    for (; n >= 0x80; n >>= 7) byte(static_cast<unsigned>(n & 0x7f) | 0x80);
    return byte(static_cast<unsigned>(n));
  }
  Handmade& byte(unsigned b) {
    bytes_.push_back(static_cast<std::byte>(b));
    return *this;
  }
  Handmade& text(std::string_view text) {
    number(text.size());
    for (const char c : text) byte(static_cast<std::uint8_t>(c));
    return *this;
  }
  /// A member of a struct. If the member is a struct itself, `type` is the number of that earlier struct.
  struct M {
    unsigned form;
    std::string name;
    std::uint64_t type = 0;
  };
  Handmade& structure(std::string_view name, const std::vector<M>& members) {
    text(name).number(members.size());
    for (const M& m : members) {
      byte(m.form).text(m.name);
      if ((m.form & 0x0f) == 14) number(m.type);
    }
    return *this;
  }
  std::string error(const DynamicType::Limits& limits = {}) const {
    const auto parsed = DynamicType::parse(bytes_, limits);
    return parsed ? "" : parsed.error().message;
  }

 private:
  Bytes bytes_;
};

/// Returns the beginning of a description: version 1, no enumerations, and `n` structs.
Handmade with_structs(std::uint64_t n) { return Handmade().byte(1).number(0).number(n); }

constexpr unsigned uint8 = 4;
constexpr unsigned nested_kind = 14;
constexpr unsigned array = 1 << 4;
constexpr unsigned sequence = 2 << 4;
constexpr unsigned attributes = 1 << 7;

TEST(HostileDescriptionTest, ThatIsWholeIsAccepted) {
  EXPECT_EQ(with_structs(1).structure("a::B", {{uint8, "x"}}).error(), "");
}

TEST(HostileDescriptionTest, NamesWhatIsWrong) {
  EXPECT_THAT(Handmade().error(), HasSubstr("byte 0 of the type description: it ends too early"));
  EXPECT_THAT(Handmade().byte(2).error(), HasSubstr("unknown version 2"));
  EXPECT_THAT(with_structs(0).error(), HasSubstr("no struct"));
  EXPECT_THAT(with_structs(1).structure("B", {}).text("more").error(), HasSubstr("'B' has no members"));
  EXPECT_THAT(with_structs(1).structure("B", {{15, "x"}}).error(), HasSubstr("unknown kind 15"));
  EXPECT_THAT(with_structs(1).structure("B", {{3 << 4, "x"}}).error(), HasSubstr("unknown shape 3"));
  EXPECT_THAT(with_structs(1).structure("B", {{uint8, "x"}, {uint8, "x"}}).error(), HasSubstr("named 'x'"));
  EXPECT_THAT(with_structs(1).structure("B", {{uint8, "x y"}}).error(), HasSubstr("no identifier"));
  EXPECT_THAT(with_structs(1).structure("B", {{uint8, ""}}).text("more").error(), HasSubstr("no identifier"));
  EXPECT_THAT(with_structs(1).structure("a:b", {{uint8, "x"}}).error(), HasSubstr("name of a type"));
  EXPECT_THAT(with_structs(1).structure("a::", {{uint8, "x"}}).error(), HasSubstr("name of a type"));
  EXPECT_THAT(with_structs(1).structure("B", {{uint8, "x"}}).byte(0).error(), HasSubstr("left over"));
}

TEST(HostileDescriptionTest, ArraysHaveElementsAndAttributesBelongToWhatTheyFit) {
  const auto with_member = [](unsigned form) {
    return with_structs(1).text("B").number(1).byte(form).text("x");
  };
  EXPECT_THAT(with_member(uint8 | array).number(0).error(), HasSubstr("elements of an array: 0"));
  EXPECT_THAT(with_member(uint8 | array).number(1ULL << 40).error(), HasSubstr("elements of an array"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(0).error(), HasSubstr("unknown attributes"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(32).error(), HasSubstr("unknown attributes"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(16).text("").error(), HasSubstr("a layout without roles"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(16).text("columns=x").error(),
              HasSubstr("the layout of member 'x': a layout belongs to a sequence of numbers"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(1).number(3).error(), HasSubstr("is no sequence"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(2).number(3).error(), HasSubstr("string's bound"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(4).number(0).error(), HasSubstr("there is not"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(8).text("").error(), HasSubstr("cannot be printed"));
  EXPECT_THAT(with_member(uint8 | attributes).byte(8).text("\x1b[2J").error(),
              HasSubstr("cannot be printed"));
  EXPECT_EQ(with_member(uint8 | attributes).byte(8).text("\xc2\xb5s").error(), "");
}

TEST(HostileDescriptionTest, EnumerationsHaveEnumeratorsThatFit) {
  const auto with_enumeration = [](unsigned form, std::uint64_t value, unsigned kind) {
    Handmade h = Handmade().byte(1).number(1);
    h.text("E").byte(form).number(1).text("A").number(value);
    return h.number(1).text("B").number(1).byte(kind | attributes).text("x").byte(4).number(0);
  };
  EXPECT_EQ(with_enumeration(0, 127, 3).error(), "");
  EXPECT_THAT(with_enumeration(0, 128, 3).error(), HasSubstr("too small"));
  EXPECT_EQ(with_enumeration(0, 255, uint8).error(), "");
  EXPECT_THAT(with_enumeration(0, 1, 12).error(), HasSubstr("no integer"));
  EXPECT_EQ(with_enumeration(1, 128, uint8).error(), "");
  EXPECT_THAT(with_enumeration(1, 3, uint8).error(), HasSubstr("'A' is not one bit"));
  EXPECT_THAT(with_enumeration(2, 1, uint8).error(), HasSubstr("neither enumeration nor bitmask"));
}

TEST(HostileDescriptionTest, EnumeratorsCountWhereverTheirEnumerationIsUsed) {
  Handmade h = Handmade().byte(1).number(1);
  h.text("E").byte(0).number(3).text("A").number(0).text("B").number(1).text("C").number(2);
  h.number(1).text("S").number(2);
  for (const char* name : {"x", "y"}) h.byte(uint8 | attributes).text(name).byte(4).number(0);
  EXPECT_EQ(h.error({.members = 8}), "");
  EXPECT_THAT(h.error({.members = 7}), HasSubstr("more than 7 members and enumerators"));
}

TEST(HostileDescriptionTest, OnlyEarlierStructsCanBeReferencedSoThatNothingIsRecursive) {
  EXPECT_THAT(with_structs(1).structure("A", {{nested_kind | sequence, "self", 0}}).error(),
              HasSubstr("earlier"));
  EXPECT_THAT(with_structs(1).structure("A", {{nested_kind, "none", UINT64_MAX}}).error(),
              HasSubstr("earlier"));
}

TEST(HostileDescriptionTest, ExponentialNestingIsRefusedBeforeItIsWalked) {
  Handmade bomb = with_structs(40);
  bomb.structure("S0", {{uint8, "a"}, {uint8, "b"}});
  for (std::uint64_t i = 1; i < 40; ++i)
    bomb.structure("S" + std::to_string(i), {{nested_kind, "a", i - 1}, {nested_kind, "b", i - 1}});
  EXPECT_THAT(bomb.error(), HasSubstr("more than 4096 fields"));
}

TEST(HostileDescriptionTest, DepthIsLimited) {
  const auto nest = [](std::uint64_t depth) {
    Handmade deep = with_structs(depth).structure("S0", {{uint8, "a"}});
    for (std::uint64_t i = 1; i < depth; ++i)
      deep.structure("S" + std::to_string(i), {{nested_kind, "a", i - 1}});
    return deep.error();
  };
  EXPECT_EQ(nest(32), "");
  EXPECT_EQ(
      nest(33),
      "'S32' has, with member 'a', more than 32 structs in one another: only programs that are compiled "
      "with the type can use it");
}

TEST(HostileDescriptionTest, SizeIsLimitedAndOnlyWhatIsBeyondALimitIsCalledSo) {
  const auto code_of = [](const Bytes& description) { return DynamicType::parse(description).error().code; };
  EXPECT_EQ(code_of(Bytes(65'537)), Errc::limit_exceeded);
  EXPECT_EQ(code_of(Bytes(65'536)), Errc::malformed);
}

TEST(HostileDescriptionTest, LongNamesThatAreRepeatedInManyPathsAreRefused) {
  Handmade wide = with_structs(3);
  std::vector<Handmade::M> members;
  for (int i = 0; i < 64; ++i) members.push_back({uint8, std::string(250, 'x') + std::to_string(i)});
  wide.structure("A", members);
  members.clear();
  for (int i = 0; i < 8; ++i) members.push_back({nested_kind, std::string(250, 'y') + std::to_string(i), 0});
  wide.structure("B", members);
  for (auto& m : members) m.type = 1;
  EXPECT_THAT(wide.structure("C", members).error(), HasSubstr("bytes of paths"));
}

TEST(HostileDescriptionTest, CountsThatTheBytesCannotHoldAllocateNothing) {
  EXPECT_THAT(with_structs(1ULL << 60).error(), HasSubstr("do not fit"));
  EXPECT_THAT(with_structs(1).text("A").number(1ULL << 60).error(), HasSubstr("do not fit"));
  EXPECT_THAT(Handmade().byte(1).number(1ULL << 60).error(), HasSubstr("do not fit"));
  EXPECT_THAT(with_structs(1).number(1ULL << 60).error(), HasSubstr("do not fit"));
}

TEST(HostileDescriptionTest, WhatIsOrderedOtherwiseRepeatedOrUnusedIsRefused) {
  const std::vector<Handmade::M> x{{uint8, "x"}};
  EXPECT_THAT(with_structs(2).structure("A", x).structure("B", x).error(), HasSubstr("order"));
  EXPECT_THAT(with_structs(2).structure("A", x).structure("A", x).error(), HasSubstr("two types are named"));
  EXPECT_THAT(with_structs(3)
                  .structure("A", x)
                  .structure("B", x)
                  .structure("C", {{nested_kind, "b", 1}, {nested_kind, "a", 0}})
                  .error(),
              HasSubstr("order"));
  EXPECT_THAT(with_structs(1).text("A").byte(0x81).byte(0).byte(uint8).text("x").error(), HasSubstr("order"))
      << "a number with a superfluous zero";
}

TEST(HostileDescriptionTest, NumbersBeyond64BitsAreRefused) {
  Handmade h = Handmade().byte(1);
  for (int i = 0; i < 12; ++i) h.byte(0xff);
  EXPECT_THAT(h.error(), HasSubstr("more than 64 bits"));
}

TEST(HostileDescriptionTest, LimitsAreTheCallers) {
  const Bytes bytes = describe(TypeTable<PointCloud2>::type);
  EXPECT_FALSE(DynamicType::parse(bytes, {.bytes = bytes.size() - 1}));
  EXPECT_FALSE(DynamicType::parse(bytes, {.leaves = 14}));
  EXPECT_TRUE(DynamicType::parse(bytes, {.bytes = bytes.size(), .leaves = 15}));
}

TEST(HostileDescriptionTest, EveryTruncationAndMostChangesAreRefusedAndNothingIsReadOutside) {
  SCOPED_TRACE("to repeat: SFT_TEST_SEED=" + std::to_string(test::test_seed()));
  test::Random random(test::test_seed());
  const Bytes whole = describe(TypeTable<torture::Nested>::type);
  for (std::size_t n = 0; n < whole.size(); ++n)
    EXPECT_FALSE(DynamicType::parse(std::span(whole).first(n))) << n;
  for (int round = 0; round < 20'000; ++round) {
    Bytes bytes = whole;
    for (int i = 0; i < 2; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const auto parsed = DynamicType::parse(bytes);
    if (parsed) {
      ASSERT_EQ(describe(parsed->type()), bytes);
    }
  }
}

}  // namespace
}  // namespace sft
