// The meaning of conditions. The tests follow the specification sentence by sentence (selection.md,
// "Conditions").
#include "sft/detail/conditions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <string>
#include <string_view>
#include <torture.hpp>
#include <vector>

#include "tests/support/asked.h"

namespace sft {
namespace {

using Condition = Selection::Condition;
using sensor_msgs::msg::BatteryState;
using torture::Primitives;

constexpr std::int64_t s = 1'000'000'000;
constexpr std::int64_t now_ns = 1'700'000'000 * s;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

std::vector<Condition> conditions_of(const TypeSupport& type, std::string_view text) {
  return type.parse_selection(text).value().gate().conditions;
}

/// The stream of samples of a gate without a rate limit. All samples that fulfil the conditions pass.
template <class T>
class Stream {
 public:
  explicit Stream(std::string_view text)
      : asked_(type_support<T>().type(), conditions_of(type_support<T>(), text)) {}

  /// Passes the first sample of the stream. Later samples are compared with the last sample that passed.
  Stream& first(const T& message, std::int64_t stamp_ns = now_ns) {
    asked_.holds(&message, stamp_ns, mask_);
    asked_.passed(&message, stamp_ns, mask_);
    return *this;
  }
  void begin() { asked_.begin(); }
  bool holds(const T& message, std::int64_t stamp_ns = now_ns) {
    return asked_.holds(&message, stamp_ns, mask_);
  }
  bool passes(const T& message, std::int64_t stamp_ns = now_ns) {
    const bool result = holds(message, stamp_ns);
    if (result) asked_.passed(&message, stamp_ns, mask_);
    return result;
  }

 private:
  FieldMask mask_ = type_support<T>().full();
  test::Asked asked_;
};

/// Returns true if the comparison holds for the message.
template <class T>
bool is_true(std::string_view condition, const T& message) {
  return Stream<T>("* @ " + std::string(condition)).holds(message);
}

/// Returns true if the condition, which has a `changed`, holds for the sample `to` after the sample `from`
/// has passed.
template <class T>
bool has_changed(std::string_view condition, const T& from, const T& to) {
  return Stream<T>("* @ " + std::string(condition)).first(from).holds(to);
}

BatteryState at_voltage(float voltage) {
  BatteryState battery;
  battery.voltage = voltage;
  return battery;
}
bool voltage_has_changed(std::string_view deadband, float from, float to) {
  return has_changed("changed(voltage) " + std::string(deadband), at_voltage(from), at_voltage(to));
}
Primitives with_double(double value) {
  Primitives message;
  message.a_double = value;
  return message;
}
Primitives with_llong(std::int64_t value) {
  Primitives message;
  message.a_llong = value;
  return message;
}
Primitives with_ullong(std::uint64_t value) {
  Primitives message;
  message.a_ullong = value;
  return message;
}

TEST(ConditionsTest, WithoutConditionsEachSampleFulfilsThem) {
  detail::Conditions none;
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(none.hold(detail::FieldSource::of_nothing(), now_ns));
  EXPECT_TRUE(none.hold(detail::FieldSource::of_nothing(), now_ns - 1));
  const TypeSupport& type = type_support<BatteryState>();
  EXPECT_FALSE(detail::Conditions(type.type(), conditions_of(type, "* @ every 2nd")).empty());
}

TEST(ConditionsTest, AFloatIsComparedByItsValueAndNotByItsDecimalText) {
  EXPECT_TRUE(is_true("voltage > 0.1", at_voltage(0.1F))) << "the float is 0.100000001490116";
  EXPECT_FALSE(is_true("voltage == 0.1", at_voltage(0.1F)));
  EXPECT_FALSE(is_true("voltage <= 0.1", at_voltage(0.1F)));
  EXPECT_TRUE(is_true("voltage == 0.5", at_voltage(0.5F)));
  EXPECT_TRUE(is_true("a_double == 0.1", with_double(0.1)));
}

TEST(ConditionsTest, IntegersAreComparedExactlyWithIntegersThatNoDoubleHolds) {
  EXPECT_FALSE(is_true("a_llong == 9007199254740993", with_llong(9'007'199'254'740'992)));
  EXPECT_TRUE(is_true("a_llong < 9007199254740993", with_llong(9'007'199'254'740'992)));
  EXPECT_TRUE(is_true("a_llong == 9223372036854775807", with_llong(INT64_MAX)));
  EXPECT_TRUE(is_true("a_llong == -9223372036854775808", with_llong(INT64_MIN)));
  EXPECT_TRUE(is_true("a_ullong == 18446744073709551615", with_ullong(UINT64_MAX)));
  EXPECT_TRUE(is_true("a_ullong > -1", with_ullong(UINT64_MAX)));
  EXPECT_TRUE(is_true("a_llong < 18446744073709551615", with_llong(-1)));
}

TEST(ConditionsTest, IntegersAreComparedExactlyWithRealNumbers) {
  EXPECT_TRUE(is_true("a_ullong < 18446744073709551616", with_ullong(UINT64_MAX)));
  EXPECT_FALSE(is_true("a_ullong == 18446744073709551616", with_ullong(UINT64_MAX)));
  EXPECT_TRUE(is_true("a_llong < 9223372036854775808", with_llong(INT64_MAX)));
  EXPECT_TRUE(is_true("a_llong > 4503599627370495.5", with_llong(4'503'599'627'370'496)));
  EXPECT_TRUE(is_true("a_llong < -0.5", with_llong(-1)));
  EXPECT_TRUE(is_true("a_llong > -1e300", with_llong(INT64_MIN)));
}

TEST(ConditionsTest, RealNumbersAreComparedExactlyWithIntegersThatNoDoubleHolds) {
  EXPECT_TRUE(is_true("a_double > 18446744073709551615", with_double(0x1p64)));
  EXPECT_TRUE(is_true("a_double < 9007199254740993", with_double(0x1p53)));
  EXPECT_FALSE(is_true("a_double == 9007199254740993", with_double(0x1p53)));
}

TEST(ConditionsTest, InfinityIsBeyondEachNumber) {
  EXPECT_TRUE(is_true("voltage > 1e308", at_voltage(infinity)));
  EXPECT_TRUE(is_true("voltage < -1e308", at_voltage(-infinity)));
  EXPECT_FALSE(is_true("voltage < 0", at_voltage(infinity)));
  EXPECT_TRUE(is_true("voltage != 18446744073709551615", at_voltage(infinity)));
}

TEST(ConditionsTest, NegativeZeroIsZero) {
  EXPECT_TRUE(is_true("voltage == 0", at_voltage(-0.0F)));
  EXPECT_FALSE(is_true("voltage < 0", at_voltage(-0.0F)));
  EXPECT_FALSE(voltage_has_changed("", 0.0F, -0.0F));
}

TEST(ConditionsTest, AValueThatIsNotANumberFulfilsNotEqualOnly) {
  for (const char* sign : {"<", "<=", ">", ">=", "=="}) {
    EXPECT_FALSE(is_true("voltage " + std::string(sign) + " 0", at_voltage(not_a_number))) << sign;
    EXPECT_FALSE(is_true("a_double " + std::string(sign) + " 0.5", with_double(NAN))) << sign;
  }
  EXPECT_TRUE(is_true("voltage != 0", at_voltage(not_a_number)));
  EXPECT_TRUE(is_true("a_double != 0.5", with_double(-NAN)));
}

TEST(ConditionsTest, ABooleanCountsAsZeroOrOne) {
  BatteryState battery;
  EXPECT_TRUE(is_true("present == false", battery));
  EXPECT_TRUE(is_true("present < 0.5", battery));
  battery.present = true;
  EXPECT_TRUE(is_true("present == true", battery));
  EXPECT_TRUE(is_true("present > 0.5", battery));
  EXPECT_TRUE(is_true("present != 2", battery));
  EXPECT_TRUE(has_changed("changed(present)", BatteryState{}, battery));
  EXPECT_FALSE(has_changed("changed(present) 1", BatteryState{}, battery));
}

TEST(ConditionsTest, AnEnumerationCountsAsItsNumber) {
  torture::Defaults message;
  message.color = torture::Color::BLUE;
  EXPECT_TRUE(is_true("color == BLUE", message));
  EXPECT_TRUE(is_true("color == 7", message));
  EXPECT_TRUE(is_true("color > GREEN and color > 6.5", message));
  torture::Defaults green = message;
  green.color = torture::Color::GREEN;
  EXPECT_TRUE(has_changed("changed(color) 5", message, green));
  EXPECT_FALSE(has_changed("changed(color) 6", message, green));
}

TEST(ConditionsTest, AndBindsMoreStronglyThanOr) {
  BatteryState battery = at_voltage(5);
  EXPECT_TRUE(is_true("voltage == 5 or current == 1 and charge == 1", battery));
  EXPECT_FALSE(is_true("(voltage == 5 or current == 1) and charge == 1", battery));
  battery.charge = 1;
  EXPECT_TRUE(is_true("(voltage == 5 or current == 1) and charge == 1", battery));
}

TEST(ConditionsTest, AWordThatAnOperatorFollowsIsAField) {
  struct Words {
    double changed, every, at;
  };
  using Kind = StructType::Member::Kind;
  static constexpr StructType::Member members[] = {
      {.name = "changed", .kind = Kind::float64, .offset = offsetof(Words, changed), .stride = 8},
      {.name = "every", .kind = Kind::float64, .offset = offsetof(Words, every), .stride = 8},
      {.name = "at", .kind = Kind::float64, .offset = offsetof(Words, at), .stride = 8}};
  static constexpr StructType words("Words", members);
  const TypeSupport type(words);
  const Words message{1, 2, 3};
  for (const char* text : {"@ changed == 1", "@ every == 2", "@ at == 3 and every > 1"}) {
    test::Asked asked(words, conditions_of(type, text));
    EXPECT_TRUE(asked.holds(&message, now_ns, type.full())) << text;
  }
}

TEST(ConditionsTest, FieldsOfNestedStructsAreFields) {
  BatteryState battery;
  battery.header.stamp.sec = -5;
  battery.header.frame_id = "pack";
  EXPECT_TRUE(is_true("header.stamp.sec < -4", battery));
  EXPECT_TRUE(has_changed("changed(header.frame_id)", BatteryState{}, battery));
  EXPECT_TRUE(has_changed("changed(header.stamp.sec) 4.5", BatteryState{}, battery));
}

TEST(ConditionsTest, ChangedWithoutNamesIsAboutTheSingleValuesThatAreSelected) {
  const auto changes = [](const BatteryState& to) {
    return Stream<BatteryState>("header, voltage, cell_voltage @ changed").first({}).holds(to);
  };
  EXPECT_FALSE(changes({}));
  EXPECT_TRUE(changes(at_voltage(1)));
  BatteryState other;
  other.header.frame_id = "pack";
  EXPECT_TRUE(changes(other));
  other = {};
  other.current = 1;
  EXPECT_FALSE(changes(other)) << "it is not selected";
  other = {};
  other.cell_voltage = {1, 2};
  EXPECT_FALSE(changes(other)) << "it is no single value";
}

TEST(ConditionsTest, ChangedComparesWithTheLastSampleThatPassed) {
  Stream<BatteryState> stream("* @ changed(voltage) 1");
  stream.first(at_voltage(10));
  EXPECT_FALSE(stream.passes(at_voltage(10.75F)));
  EXPECT_TRUE(stream.passes(at_voltage(11.5F))) << "no more than 0.75 at once, but 1.5 in all";
  EXPECT_FALSE(stream.passes(at_voltage(10.5F)));
  EXPECT_FALSE(stream.passes(at_voltage(12.5F)));
  EXPECT_TRUE(stream.passes(at_voltage(10)));
}

TEST(ConditionsTest, ChangedHoldsAlsoForASampleThatTheRateWithholds) {
  Stream<BatteryState> stream("* @ changed(voltage)");
  stream.first(at_voltage(1));
  EXPECT_TRUE(stream.holds(at_voltage(2)));
  EXPECT_TRUE(stream.holds(at_voltage(2))) << "the former one did not pass";
  EXPECT_FALSE(stream.holds(at_voltage(1)));
}

TEST(ConditionsTest, ChangedHoldsIfAnyOfItsFieldsHasChanged) {
  BatteryState battery;
  battery.current = 1;
  EXPECT_TRUE(has_changed("changed(voltage, current)", BatteryState{}, battery));
  EXPECT_FALSE(has_changed("changed(voltage, charge)", BatteryState{}, battery));
  EXPECT_FALSE(has_changed("changed(voltage) and changed(current)", BatteryState{}, battery));
}

TEST(ConditionsTest, ADeadbandIsHowFarANumberMayBeFromItsFormerValue) {
  EXPECT_FALSE(voltage_has_changed("0.5", 3, 3.5F));
  EXPECT_TRUE(voltage_has_changed("0.5", 3, std::nextafter(3.5F, 4.0F)));
  EXPECT_FALSE(voltage_has_changed("0.5", 3, 2.5F));
  EXPECT_TRUE(voltage_has_changed("0.5", 3, std::nextafter(2.5F, 2.0F)));
  EXPECT_TRUE(voltage_has_changed("0.5", -0.3F, 0.3F));
  EXPECT_FALSE(has_changed(
      "changed(an_int8) 255",
      [] {
        Primitives message;
        message.an_int8 = -128;
        return message;
      }(),
      [] {
        Primitives message;
        message.an_int8 = 127;
        return message;
      }()));
}

TEST(ConditionsTest, ADeadbandInPercentIsAPartOfTheAbsoluteFormerValue) {
  EXPECT_FALSE(voltage_has_changed("25%", 4, 5));
  EXPECT_TRUE(voltage_has_changed("25%", 5, 3.5F));
  EXPECT_FALSE(voltage_has_changed("25%", 5, 4)) << "20 % of the former value, though 25 % of the new one";
  EXPECT_FALSE(voltage_has_changed("25%", -4, -5));
  EXPECT_TRUE(voltage_has_changed("25%", -4, -5.25F));
  EXPECT_TRUE(voltage_has_changed("25%", -4, 4));
  EXPECT_FALSE(voltage_has_changed("200%", -4, 4));
}

TEST(ConditionsTest, AnyPartOfZeroIsNothing) {
  EXPECT_FALSE(voltage_has_changed("1000%", 0, 0));
  EXPECT_FALSE(voltage_has_changed("1000%", 0, -0.0F));
  EXPECT_TRUE(voltage_has_changed("1000%", 0, 1e-45F));
}

TEST(ConditionsTest, WithoutADeadbandTheLeastDifferenceIsAChange) {
  EXPECT_TRUE(voltage_has_changed("", 4, std::nextafter(4.0F, 5.0F)));
  EXPECT_TRUE(voltage_has_changed("0%", 4, std::nextafter(4.0F, 5.0F)));
  EXPECT_TRUE(has_changed("changed(a_llong)", with_llong(INT64_MAX), with_llong(INT64_MAX - 1)));
  EXPECT_TRUE(has_changed("changed(a_ullong)", with_ullong(UINT64_MAX), with_ullong(UINT64_MAX - 1)));
  EXPECT_TRUE(has_changed("changed(a_double)", with_double(0), with_double(5e-324)));
}

TEST(ConditionsTest, IntegersMayBeAsFarFromEachOtherAsTheirRangeIsWide) {
  EXPECT_TRUE(has_changed("changed(a_llong) 1e18", with_llong(INT64_MIN), with_llong(INT64_MAX)));
  EXPECT_FALSE(has_changed("changed(a_llong) 2e19", with_llong(INT64_MIN), with_llong(INT64_MAX)));
  EXPECT_FALSE(has_changed("changed(a_llong) 2e19", with_llong(INT64_MAX), with_llong(INT64_MIN)));
  EXPECT_TRUE(has_changed("changed(a_ullong) 1.8e19", with_ullong(UINT64_MAX), with_ullong(0)));
  EXPECT_FALSE(has_changed("changed(a_llong) 100%", with_llong(INT64_MIN), with_llong(-1)));
  EXPECT_TRUE(has_changed("changed(a_llong) 199%", with_llong(INT64_MIN), with_llong(INT64_MAX)));
}

TEST(ConditionsTest, TheDistanceOfIntegersIsExact) {
  EXPECT_TRUE(has_changed("changed(a_llong) 9007199254740992", with_llong(0), with_llong((1LL << 53) + 1)));
  EXPECT_FALSE(has_changed("changed(a_llong) 9007199254740992", with_llong(1), with_llong((1LL << 53) + 1)));
  EXPECT_TRUE(has_changed("changed(a_llong) 100%", with_llong(-(1LL << 62)), with_llong(1)));
}

TEST(ConditionsTest, ADeadbandThatIsAnIntegerIsReadExactly) {
  for (const char* text : {"a_llong @ changed 9007199254740993", "a_ullong @ changed 18446744073709551615"}) {
    const TypeSupport& type = type_support<Primitives>();
    EXPECT_EQ(type.format_selection(type.parse_selection(text).value()), text);
  }
}

TEST(ConditionsTest, AValueThatIsNotANumberHasChangedIfTheOtherOneIsANumber) {
  EXPECT_FALSE(voltage_has_changed("", not_a_number, not_a_number));
  EXPECT_FALSE(voltage_has_changed("", not_a_number, -not_a_number)) << "it has other bits";
  for (const char* deadband : {"", "1e300", "1e300%"}) {
    EXPECT_TRUE(voltage_has_changed(deadband, not_a_number, 1)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, 1, not_a_number)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, infinity, not_a_number)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, not_a_number, -infinity)) << deadband;
  }
}

TEST(ConditionsTest, ANumberThatWasInfiniteHasChangedIfItIsAnotherOneNow) {
  for (const char* deadband : {"", "1e300", "1e300%"}) {
    EXPECT_FALSE(voltage_has_changed(deadband, infinity, infinity)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, infinity, -infinity)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, infinity, 3e38F)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, -infinity, 0)) << deadband;
    EXPECT_TRUE(voltage_has_changed(deadband, 1, infinity)) << deadband << ": infinitely far";
  }
}

TEST(ConditionsTest, ATextHasChangedIfAnyOfItHas) {
  const auto changes = [](std::string_view deadband, std::string from, std::string to) {
    BatteryState before, now;
    before.location = std::move(from);
    now.location = std::move(to);
    return has_changed("changed(location)" + std::string(deadband), before, now);
  };
  const std::string text(40, 'x');
  EXPECT_FALSE(changes("", "", ""));
  EXPECT_FALSE(changes("", text, text));
  EXPECT_TRUE(changes("", text, text + "x"));
  EXPECT_TRUE(changes("", text, text.substr(1)));
  EXPECT_TRUE(changes("", text, "y" + text.substr(1)));
  EXPECT_TRUE(changes("", "a", ""));
  EXPECT_TRUE(changes(" 1000", "1", "2")) << "deadbands do not count for texts";
  EXPECT_TRUE(changes(" 1000%", "1", "2"));
}

TEST(ConditionsTest, UntilASampleHasPassedWhateverAsksAboutEarlierOnesHolds) {
  for (const char* text : {"* @ changed(voltage) 5", "* @ every 3rd", "* @ every 10 s",
                           "* @ changed and every 3rd", "* @ voltage > 9 or every 10 s"}) {
    Stream<BatteryState> stream(text);
    EXPECT_TRUE(stream.holds({})) << text;
    EXPECT_TRUE(stream.passes({})) << text << ": the former one did not pass";
    EXPECT_FALSE(stream.holds(at_voltage(1))) << text;
    stream.begin();
    EXPECT_TRUE(stream.passes({})) << text << ": for the reader that begins";
    EXPECT_FALSE(stream.holds(at_voltage(1))) << text;
  }
}

TEST(ConditionsTest, AComparisonAsksAboutThisSampleAlsoIfItIsTheFirst) {
  Stream<BatteryState> stream("* @ voltage > 1");
  EXPECT_FALSE(stream.holds(at_voltage(1)));
  EXPECT_TRUE(stream.holds(at_voltage(2)));
  Stream<BatteryState> both("* @ voltage > 1 and changed(voltage) 5");
  EXPECT_FALSE(both.passes(at_voltage(0)));
  EXPECT_TRUE(both.passes(at_voltage(2)));
  EXPECT_FALSE(both.passes(at_voltage(3)));
}

TEST(ConditionsTest, EveryThirdHoldsForTheFirstSampleAndForEachThirdOneBehindItWhetherTheyPassOrNot) {
  Stream<BatteryState> stream("* @ every 3rd");
  stream.first({});
  for (int i = 1; i < 20; ++i) {
    const bool holds = i % 2 == 0 ? stream.holds({}) : stream.passes({});
    EXPECT_EQ(holds, i % 3 == 0) << i;
  }
}

TEST(ConditionsTest, SamplesAreCountedAlsoWhereTheAnswerIsKnownWithoutTheirNumber) {
  Stream<BatteryState> stream("* @ voltage > 0 and every 3rd");
  stream.first({});
  for (int i = 1; i < 20; ++i)
    EXPECT_EQ(stream.holds(at_voltage(i % 4 == 0 ? 0 : 1)), i % 4 != 0 && i % 3 == 0) << i;
}

TEST(ConditionsTest, EveryTenSecondsHoldsIfTheLastSampleThatPassedWasPublishedAtLeastSoLongAgo) {
  Stream<BatteryState> stream("* @ every 10 s");
  stream.first({});
  EXPECT_FALSE(stream.passes({}, now_ns));
  EXPECT_FALSE(stream.passes({}, now_ns + 10 * s - 1));
  EXPECT_TRUE(stream.passes({}, now_ns + 10 * s));
  EXPECT_FALSE(stream.passes({}, now_ns + 19 * s));
  EXPECT_TRUE(stream.holds({}, now_ns + 21 * s));
  EXPECT_TRUE(stream.passes({}, now_ns + 22 * s)) << "the former one did not pass";
  EXPECT_FALSE(stream.passes({}, now_ns + 31 * s));
  EXPECT_TRUE(stream.passes({}, now_ns + 32 * s));
}

TEST(ConditionsTest, APeriodBehindOrIsAHeartbeat) {
  Stream<BatteryState> stream("* @ changed(voltage) or every 10 s");
  stream.first(at_voltage(1));
  EXPECT_FALSE(stream.passes(at_voltage(1), now_ns + 5 * s));
  EXPECT_TRUE(stream.passes(at_voltage(2), now_ns + 6 * s));
  EXPECT_FALSE(stream.passes(at_voltage(2), now_ns + 15 * s)) << "the period counts from the change";
  EXPECT_TRUE(stream.passes(at_voltage(2), now_ns + 16 * s));
}

TEST(ConditionsTest, IfTheClockIsSetBackThePeriodBeginsAnew) {
  Stream<BatteryState> stream("* @ every 10 s");
  stream.first({});
  EXPECT_FALSE(stream.passes({}, now_ns - 3600 * s));
  EXPECT_FALSE(stream.passes({}, now_ns - 3600 * s + 9 * s));
  EXPECT_TRUE(stream.passes({}, now_ns - 3600 * s + 10 * s));
}

TEST(ConditionsTest, AClockThatIsSetBackIsNoticedAlsoWhereThePeriodIsNotAskedAbout) {
  Stream<BatteryState> stream("* @ voltage > 0 and every 10 s");
  stream.first({});
  EXPECT_FALSE(stream.passes(at_voltage(0), now_ns - 3600 * s));
  EXPECT_TRUE(stream.passes(at_voltage(1), now_ns - 3600 * s + 10 * s));
}

TEST(ConditionsTest, StampsMayBeAnyNumbers) {
  Stream<BatteryState> stream("* @ every 1 us");
  stream.first({}, INT64_MIN);
  EXPECT_TRUE(stream.passes({}, INT64_MAX));
  EXPECT_FALSE(stream.passes({}, INT64_MIN));
  EXPECT_FALSE(stream.passes({}, INT64_MIN + 999));
  EXPECT_TRUE(stream.passes({}, INT64_MIN + 1000));
}

TEST(ConditionsTest, OfAMessageOfWhichNothingIsKnownNumbersAreZeroAndTextsEmpty) {
  const TypeSupport& type = type_support<BatteryState>();
  const auto holds = [&](std::string_view text) {
    detail::Conditions conditions(type.type(), conditions_of(type, text));
    return conditions.hold(detail::FieldSource::of_nothing(), now_ns);
  };
  EXPECT_TRUE(holds("* @ voltage == 0 and present == false and header.stamp.sec == 0"));
  EXPECT_FALSE(holds("* @ voltage > 0"));
  detail::Conditions changes(type.type(), conditions_of(type, "* @ changed(voltage, location)"));
  changes.passed(detail::FieldSource::of_nothing(), now_ns);
  BatteryState battery;
  const auto message = detail::FieldSource::of_message(&battery);
  EXPECT_FALSE(changes.hold(message, now_ns));
  battery.location = "left";
  EXPECT_TRUE(changes.hold(message, now_ns));
  changes.passed(message, now_ns);
  EXPECT_TRUE(changes.hold(detail::FieldSource::of_nothing(), now_ns));
}

}  // namespace
}  // namespace sft
