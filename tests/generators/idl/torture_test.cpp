// These tests check the code that the compiler generates for torture.idl.
#include "torture.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sft/detail/encode.h"
#include "sft/detail/walk.h"
#include "sft/mask.h"

namespace {

template <class T>
constexpr auto& members = sft::detail::TypeTable<T>::members;

template <class T>
const sft::StructType::Member& member(std::string_view name) {
  for (const sft::StructType::Member& m : members<T>) {
    if (m.name == name) return m;
  }
  throw std::out_of_range(std::string(name));
}

/// An encoded value, and a view of it. R is a parameter only because g++ 12 crashes on ViewOf<T, sft::all<T>>
/// at this point.
template <class T, sft::Req<T> R = sft::all<T>>
class Encoded {
 public:
  explicit Encoded(const T& value) {
    const sft::StructType& type = sft::detail::TypeTable<T>::type;
    const std::uint32_t size = sft::detail::encoded_size(type, &value, mask_).bytes;
    body_.resize(size / 8 + 1);
    const auto body = std::as_writable_bytes(std::span(body_)).first(size);
    sft::detail::encode(type, &value, mask_, body, index_);
    state_ = {.body = body.data(), .body_bytes = size, .index = index_.data(), .mask = &mask_};
  }
  Encoded(const Encoded&) = delete;

  sft::detail::ViewOf<T, R> view() const { return sft::detail::view_of<T, R>(state_); }

 private:
  sft::FieldMask mask_{R.mask};
  std::vector<std::uint64_t> body_;  // words, so that the body is aligned to 8 bytes
  std::vector<std::uint32_t> index_ =
      std::vector<std::uint32_t>(sft::detail::slot_count(sft::detail::TypeTable<T>::type));
  sft::detail::SampleState state_;
};

template <class T>
auto mask_of(const T& fields) {
  return sft::Mask<typename T::Type>(fields);
}

TEST(Constants, HaveTypesAndValuesOfTheIdl) {
  static_assert(std::is_same_v<decltype(torture::BITS), const std::uint8_t>);
  static_assert(torture::YES && torture::QUOTE == '\'' && torture::NEWLINE == '\n' && torture::BITS == 0xF0);
  static_assert(torture::LEAST_INT8 == -128);
  static_assert(torture::LEAST_INT64 == std::numeric_limits<std::int64_t>::min());
  static_assert(torture::MOST_UINT64 == std::numeric_limits<std::uint64_t>::max());
  static_assert(torture::TENTH == 0.1F && torture::ONE == 1.0 && torture::GREAT == 1e300);
  static_assert(torture::ROWS == 2 && torture_base::LENGTH == 3 && ORPHANS == 2);
  static_assert(torture::FAVOURITE == torture::Color::GREEN);
  static_assert(torture::TILDE == '~');
  EXPECT_EQ(torture::ESCAPES, "~JA \\x41 '");
  EXPECT_EQ(torture::GREETING, "say \"hi\"\tto \xC2\xB5\\");
}

TEST(Constants, OfAModuleNamedAfterAStructAreItsMembers) {
  using torture::Constants;
  static_assert(Constants::LOW == 1 && Constants::class_ == 1.5F && Constants::COLOR == torture::Color::BLUE);
  EXPECT_EQ(Constants::TEXT, "text");
  EXPECT_EQ(torture::Nobody_Constants::ALONE, 1);
}

TEST(Constants, GiveWayToMembersAndToTheStructItself) {
  EXPECT_EQ(torture::Constants{.value = 9}.value, 9);
  EXPECT_EQ(torture::Constants::value_, 4);
  EXPECT_EQ(torture::Constants::Constants_, 3);
}

TEST(Enumerations, HaveTheirValuesAndWidth) {
  static_assert(static_cast<int>(torture::Color::BLUE) == 7);
  static_assert(sizeof(torture::Color) == 4 && sizeof(torture::Tiny) == 1);
  EXPECT_EQ(member<torture::Defaults>("color").kind, sft::detail::Kind::int32);
  EXPECT_EQ(member<torture::Defaults>("tiny").kind, sft::detail::Kind::int8);
}

TEST(Bitmasks, AreUnsignedIntegersOfTheirWidth) {
  using torture::Bitmasks;
  static_assert(std::is_same_v<std::underlying_type_t<torture::Lamps>, std::uint8_t>);
  static_assert(std::is_same_v<std::underlying_type_t<torture::Doors>, std::uint16_t>);
  static_assert(std::is_same_v<std::underlying_type_t<torture::Flags>, std::uint32_t>);
  static_assert(std::is_same_v<std::underlying_type_t<torture::Seats>, std::uint64_t>);
  EXPECT_EQ(member<Bitmasks>("lamps").kind, sft::detail::Kind::uint8);
  EXPECT_EQ(member<Bitmasks>("three").kind, sft::detail::Kind::uint16);
  EXPECT_EQ(member<Bitmasks>("state").kind, sft::detail::Kind::uint32);
  EXPECT_EQ(member<Bitmasks>("many").kind, sft::detail::Kind::uint64);
}

TEST(Bitmasks, HaveABitForEachFlag) {
  static_assert(static_cast<int>(torture::Flags::PAUSED) == 8);
  static_assert(static_cast<int>(torture::Flags::class_ended) == 16);
  static_assert(static_cast<std::uint64_t>(torture::Seats::virtual_) == std::uint64_t{1} << 63);
}

TEST(Bitmasks, AreCombinedByOperatorsThatNeedNoUsing) {
  using torture::Flags;
  static_assert((Flags::STARTED | Flags::PAUSED) == torture::BUSY);
  static_assert((torture::BUSY & Flags::PAUSED) == Flags::PAUSED);
  static_assert((torture::BUSY ^ Flags::PAUSED) == Flags::STARTED);
  static_assert((torture::BUSY & ~Flags::STARTED) == Flags::PAUSED);
  static_assert(static_cast<std::uint8_t>(~torture::Lamps::LEFT) == 0xFE);
}

TEST(Bitmasks, StartWithoutFlagsOrWithTheirDefault) {
  EXPECT_EQ(torture::Bitmasks{}.flags, torture::Flags{});
  EXPECT_EQ(torture::Bitmasks{}.initial, torture::BUSY);
}

TEST(Bitmasks, AreReadAsSuch) {
  torture::Bitmasks value;
  value.doors = torture::Doors::BACK;
  value.many = {torture::Seats::DRIVER, torture::Seats::virtual_};
  const Encoded<torture::Bitmasks> encoded(value);
  static_assert(std::is_same_v<decltype(encoded.view().doors()), torture::Doors>);
  EXPECT_EQ(encoded.view().doors(), torture::Doors::BACK);
  EXPECT_EQ(encoded.view().many()[1], torture::Seats::virtual_);
}

TEST(Bitmasks, AreDescribedByTheirTable) {
  const sft::EnumType& flags = *member<torture::Bitmasks>("four").enumeration;
  EXPECT_TRUE(flags.is_bitmask);
  EXPECT_EQ(flags.name, "torture::Flags");
  ASSERT_EQ(flags.enumerators.size(), 3U);
  EXPECT_EQ(flags.enumerators[1].name, "PAUSED");
  EXPECT_EQ(flags.enumerators[1].value, 8U);
  EXPECT_FALSE(member<torture::Defaults>("color").enumeration->is_bitmask);
}

TEST(Defaults, InitializeTheOwnedStruct) {
  const torture::Defaults d;
  EXPECT_TRUE(d.flag);
  EXPECT_EQ(d.separator, '\\');
  EXPECT_EQ(d.bits, 255);
  EXPECT_EQ(d.small, -5);
  EXPECT_EQ(d.far, -2'000'000'000);
  EXPECT_EQ(d.farthest, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(d.quarter, 0.25F);
  EXPECT_EQ(d.three, 3.0);
  EXPECT_EQ(d.label, "none \"yet\"");
}

TEST(Defaults, AreReadThoughIdlcLosesThem) {
  const torture::LostDefaults d;
  EXPECT_EQ(d.id, -5);
  EXPECT_EQ(d.product, 14);
  EXPECT_EQ(d.lines, 0x1F);
  EXPECT_TRUE(d.answer);
  EXPECT_EQ(d.name, "abcd");
  EXPECT_EQ(d.state, torture::BUSY);
}

TEST(Defaults, OfCollectionsAreWrittenAsInPython) {
  const torture::LostDefaults d;
  EXPECT_EQ(d.texts, (torture::Texts{"it's", "say \"hi\"", "two\nlines", ""}));
  EXPECT_EQ(d.square, (torture::Square{{{1.5, -2}, {1e3, 0.1}}}));
  EXPECT_EQ(d.letters, (torture::Letters{'(', ','}));
  EXPECT_EQ(d.flags, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(d.one, std::vector<std::uint8_t>{1});
  EXPECT_TRUE(d.none.empty());
}

TEST(Defaults, OfEnumerationsAreTheirDefaultLiteralOrTheirFirst) {
  const torture::Defaults d;
  EXPECT_EQ(d.color, torture::Color::RED);
  EXPECT_EQ(d.mood, torture::Mood::CALM);
  EXPECT_EQ(d.level, torture_base::Level::LOW);
}

TEST(Defaults, AreZeroWhereTheIdlSaysNothing) {
  EXPECT_EQ(torture::Primitives{}, (torture::Primitives{.a_boolean = false, .a_double = 0.0}));
  EXPECT_EQ(torture::Arrays{}.grid[1][2], torture_base::Point{});
}

TEST(OwnedTypes, FollowTypedefsAndDimensions) {
  using torture::Arrays;
  using torture::Sequences;
  static_assert(std::is_same_v<decltype(Arrays::two), std::array<std::array<std::int32_t, 3>, 2>>);
  static_assert(std::is_same_v<decltype(Arrays::matrix), std::array<std::array<std::int32_t, 2>, 3>>);
  static_assert(std::is_same_v<decltype(Arrays::matrices), std::array<torture::Matrix, 5>>);
  static_assert(std::is_same_v<decltype(Arrays::triple), torture_base::Triple>);
  static_assert(std::is_same_v<decltype(Sequences::nicknames), std::vector<std::string>>);
  static_assert(std::is_same_v<decltype(Sequences::dots), std::vector<torture_base::Point>>);
  static_assert(std::is_same_v<decltype(torture::Nested::paint), torture::Color>);
}

TEST(OwnedTypes, HoldBooleansOfCollectionsAsBytes) {
  static_assert(std::is_same_v<decltype(torture::Primitives::a_boolean), bool>);
  static_assert(std::is_same_v<decltype(torture::Arrays::flags), std::array<std::uint8_t, 4>>);
  static_assert(std::is_same_v<decltype(torture::Sequences::flags), std::vector<std::uint8_t>>);
  EXPECT_EQ(member<torture::Arrays>("flags").kind, sft::detail::Kind::boolean);
  EXPECT_EQ(member<torture::Sequences>("flags").kind, sft::detail::Kind::boolean);
}

TEST(Table, HasAKindForEachPrimitive) {
  using enum sft::detail::Kind;
  const std::vector expected{boolean, octet,  character, int8,    uint8,   int16,  int16,
                             uint16,  uint16, int32,     int32,   uint32,  uint32, int64,
                             int64,   uint64, uint64,    float32, float64, string};
  std::vector<sft::detail::Kind> kinds;
  for (const sft::StructType::Member& m : members<torture::Primitives>) kinds.push_back(m.kind);
  EXPECT_EQ(kinds, expected);
}

TEST(Table, HasShapesAndCounts) {
  EXPECT_EQ(member<torture::Primitives>("a_long").shape, sft::detail::Shape::single);
  EXPECT_EQ(member<torture::Arrays>("grid").shape, sft::detail::Shape::array);
  EXPECT_EQ(member<torture::Arrays>("grid").count, 6U);
  EXPECT_EQ(member<torture::Arrays>("matrices").count, 30U);
  EXPECT_EQ(member<torture::Sequences>("dots").shape, sft::detail::Shape::sequence);
  EXPECT_EQ(member<torture::Sequences>("dots").type, &sft::detail::TypeTable<torture_base::Point>::type);
}

TEST(Table, HasBounds) {
  EXPECT_EQ(member<torture::Sequences>("eight").bound, 8U);
  EXPECT_EQ(member<torture::Sequences>("two_points").bound, 2U);
  EXPECT_EQ(member<torture::Sequences>("texts").bound, 0U);
  EXPECT_EQ(member<torture::Sequences>("nicknames").bound, 4U);
  EXPECT_EQ(member<torture::Sequences>("nicknames").string_bound, 16U);
  EXPECT_EQ(member<torture::Arrays>("short_texts").string_bound, 8U);
}

TEST(Table, HasKeysAndUnits) {
  EXPECT_TRUE(member<torture::Nested>("header").key);
  EXPECT_TRUE(member<torture::Nested>("speed").key);
  EXPECT_FALSE(member<torture::Nested>("name").key);
  EXPECT_EQ(member<torture::Nested>("speed").unit, "m/s");
}

TEST(Table, KeepsNamesOfTheIdl) {
  using torture::names::Words;
  EXPECT_EQ(member<Words>("class").offset, offsetof(Words, class_));
  EXPECT_EQ(member<Words>("std").offset, offsetof(Words, std));
  EXPECT_EQ(sft::detail::TypeTable<torture::names::View_>::type.name, "torture::names::View");
  EXPECT_EQ(sft::detail::TypeTable<torture::std_::sft_::std_>::type.name, "torture::std::sft::std");
}

TEST(Numbering, CountsLeavesDepthFirst) {
  static_assert(sft::detail::leaf_count_of<torture::Primitives> == 20);
  static_assert(sft::detail::leaf_count_of<torture::Arrays> == 8 + 2 + 2 + 3);
  static_assert(sft::detail::leaf_count_of<torture::Sequences> == 8 + 3 + 3 + 4 + 1 + 3 + 1);
  using F = torture::Nested::Field;
  EXPECT_TRUE(mask_of(F::header.stamp.sec).contains(0));
  EXPECT_TRUE(mask_of(F::speed).contains(3));
  EXPECT_TRUE(mask_of(F::primitives.a_boolean).contains(4));
  EXPECT_TRUE(mask_of(F::arrays.one).contains(4 + 20));
  EXPECT_TRUE(mask_of(F::many.size).contains(4 + 20 + 15 + 23));
  EXPECT_TRUE(mask_of(F::many.each.points.each.x).contains(4 + 20 + 15 + 23 + 1 + 8 + 1));
}

TEST(FieldNames, ReachIntoNestedStructsAndCollections) {
  using F = torture::Nested::Field;
  EXPECT_EQ(mask_of(F::many), F::many.size | F::many.each);
  EXPECT_EQ(mask_of(F::few), mask_of(F::few.each));
  EXPECT_EQ(F::header.frame_id | F::name, F::name | F::header.frame_id);
}

TEST(FieldNames, OfCppWordsAndOfOurOwnHaveAnUnderscore) {
  using W = torture::names::Words::Field;
  using M = torture::names::Members::Field;
  EXPECT_TRUE(mask_of(W::class_).contains(0));
  EXPECT_TRUE(mask_of(W::std).contains(6));
  EXPECT_TRUE(mask_of(M::at).contains(0));
  EXPECT_TRUE(mask_of(M::at__).contains(1));
  EXPECT_TRUE(mask_of(M::View_).contains(2));
}

TEST(FieldNames, ThatClashAfterThatGetAnotherUnderscore) {
  using torture::names::Clashes;
  EXPECT_EQ(member<Clashes>("class").offset, offsetof(Clashes, class__));
  EXPECT_EQ(member<Clashes>("class_").offset, offsetof(Clashes, class_));
  EXPECT_EQ(member<Clashes>("View_").offset, offsetof(Clashes, View_));
  EXPECT_EQ(member<Clashes>("View").offset, offsetof(Clashes, View__));
}

TEST(Views, GiveEachKindOfMember) {
  torture::Sequences value;
  value.flags = {1, 0};
  value.colors = {torture::Color::BLUE, torture::Color::GREEN};
  value.texts = {"a", "bc"};
  value.points = {{1, 2}, {3, 4}};
  const Encoded<torture::Sequences> encoded(value);
  const auto view = encoded.view();
  EXPECT_EQ(view.flags()[0], 1);
  EXPECT_EQ(view.colors()[0], torture::Color::BLUE);
  EXPECT_EQ(*++view.texts().begin(), "bc");
  EXPECT_EQ((*++view.points().begin()).y(), 4.0F);
}

TEST(Views, GiveEnumerationsAndBooleansAsSuch) {
  const Encoded<torture::Defaults> encoded(torture::Defaults{.color = torture::Color::GREEN});
  static_assert(std::is_same_v<decltype(encoded.view().color()), torture::Color>);
  static_assert(std::is_same_v<decltype(encoded.view().flag()), bool>);
  EXPECT_EQ(encoded.view().color(), torture::Color::GREEN);
  EXPECT_EQ(encoded.view().tiny(), torture::Tiny::SMALL);
  EXPECT_TRUE(encoded.view().flag());
}

TEST(Views, HaveGettersOfAllNames) {
  torture::names::Members value;
  value.at = 1;
  value.at__ = 2;
  value.View_ = 3;
  value.data = {4};
  value.Mask = 5;
  const Encoded<torture::names::Members> encoded(value);
  EXPECT_EQ(encoded.view().at(), 1);
  EXPECT_EQ(encoded.view().at__(), 2);
  EXPECT_EQ(encoded.view().View_(), 3);
  EXPECT_EQ(encoded.view().data()[0], 4);
  EXPECT_EQ(encoded.view().Mask(), 5);
}

template <class V>
concept can_read_name = requires(const V& view) {
  view.name();
};

TEST(Views, LackGettersOfFieldsOutsideTheDeclaredMask) {
  using F = torture::Nested::Field;
  static_assert(can_read_name<sft::detail::ViewOf<torture::Nested, sft::all<torture::Nested>>>);
  static_assert(can_read_name<sft::detail::ViewOf<torture::Nested, F::header | F::name>>);
  static_assert(!can_read_name<sft::detail::ViewOf<torture::Nested, F::header | F::speed>>);
}

TEST(LoanSizes, NameTheSequencesOfPrimitivesAndEnumerations) {
  using torture::Sequences;
  using Loan = Sequences::LoanView<sft::detail::LoanedPlace<Sequences>>;
  static_assert(Loan::reservations({}).size() == 7);
  const auto reservations = Loan::reservations({.bytes = 3, .ids = 5});
  EXPECT_EQ(reservations[1].leaf, 1U);
  EXPECT_EQ(reservations[1].length, 3U);
  EXPECT_EQ(reservations[2].length, std::nullopt);
  EXPECT_EQ(reservations[6].leaf, sft::detail::leaf_count_of<Sequences> - 1);
  EXPECT_EQ(reservations[6].length, 5U);
}

TEST(LoanViews, GiveWritableSpans) {
  using torture::Sequences;
  using Loan = Sequences::LoanView<sft::detail::LoanedPlace<Sequences>>;
  static_assert(std::is_same_v<decltype(std::declval<Loan>().flags()), std::span<std::uint8_t>>);
  static_assert(std::is_same_v<decltype(std::declval<Loan>().colors()), std::span<torture::Color>>);
}

TEST(LoanViews, ReserveNothingWhereThereIsNoSequence) {
  using Loan = torture::Primitives::LoanView<sft::detail::LoanedPlace<torture::Primitives>>;
  EXPECT_TRUE(Loan::reservations({}).empty());
}

TEST(Modules, WithNamesThatHideOthersStillMeanWhatTheIdlSays) {
  using torture::namespace_::torture::torture_base::Both;
  static_assert(std::is_same_v<decltype(Both::point), ::torture_base::Point>);
  static_assert(std::is_same_v<decltype(Both::own), torture::namespace_::torture::torture_base::Point>);
  static_assert(std::is_same_v<decltype(Both::outer), ::torture::Primitives>);
  EXPECT_EQ(sft::detail::leaf_count_of<Both>, 20U + 2 + 3 + 1);
}

}  // namespace
