// Reading by name: the fields that can be read, and the errors for fields that are absent.
#include "sft/dynamic_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstring>
#include <optional>
#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>
#include <vector>

#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using test::Encoded;
using ::testing::HasSubstr;

PointCloud2 cloud() {
  PointCloud2 c;
  c.header.stamp.sec = -7;
  c.header.frame_id = "lidar";
  c.height = 3'000'000'000;
  c.fields.resize(3);
  c.fields[0].name = "x";
  c.fields[1].name = "intensity";
  c.fields[1].datatype = 7;
  c.fields[2].offset = 8;
  c.data = {1, 2, 3, 4};
  c.is_dense = true;
  return c;
}

class DynamicViewTest : public ::testing::Test {
 protected:
  static std::string message(const DynamicView& view) {
    return view.error() == nullptr ? "" : view.error()->message;
  }
  template <class T>
  static std::string refusal(const Result<T>& result) {
    return result ? "" : result.error().message;
  }

  const StructType& type = TypeTable<PointCloud2>::type;
  Encoded encoded{cloud()};
  DynamicView view{encoded.state(), type};
};

TEST_F(DynamicViewTest, ReadsFieldsByTheirNames) {
  EXPECT_EQ(view["header"]["stamp"]["sec"].as<std::int32_t>(), -7);
  EXPECT_EQ(view["header"]["frame_id"].as<std::string_view>(), "lidar");
  EXPECT_EQ(view["height"].as<std::uint32_t>(), 3'000'000'000);
  EXPECT_EQ(view["is_dense"].as<bool>(), true);
  EXPECT_EQ(view["fields"][1]["name"].as<std::string>(), "intensity");
  EXPECT_EQ(view["fields"][2]["offset"].as<std::uint64_t>(), 8U);
  EXPECT_EQ(view["fields"].size(), 3U);
  EXPECT_EQ(view["data"][3].as<int>(), 4);
}

TEST_F(DynamicViewTest, ReadsFieldsByTheirPaths) {
  EXPECT_EQ(view.find("header.stamp.sec").as<int>(), -7);
  EXPECT_EQ(view.find("fields[1].datatype").as<int>(), 7);
  EXPECT_EQ(view["fields"].find("[1].name").as<std::string>(), "intensity");
  EXPECT_EQ(view.find("").type(), &type);
  for (const char* path : {"fields[", "fields[x]", "fields[1", "fields[-1]", "fields[1]]", "header..stamp"}) {
    EXPECT_NE(view.find(path).error(), nullptr) << path;
  }
}

TEST_F(DynamicViewTest, SpansPointIntoTheSample) {
  const auto data = view["data"].as<std::span<const std::uint8_t>>().value();
  ASSERT_EQ(data.size(), 4U);
  EXPECT_EQ(data[2], 3);
  EXPECT_GE(reinterpret_cast<const std::byte*>(data.data()), encoded.state().body);
  EXPECT_EQ(view["data"].as<std::span<const std::byte>>()->size(), 4U);
  EXPECT_THAT(refusal(view["data"].as<std::span<const std::int8_t>>()), HasSubstr("sequence<uint8>"));
  EXPECT_THAT(refusal(view["fields"].as<std::span<const std::uint8_t>>()), HasSubstr("PointField"));
}

TEST_F(DynamicViewTest, IteratesOverMembersAndElements) {
  std::string names;
  for (const DynamicView& m : view.members()) names += std::string(m.name()) + ' ';
  EXPECT_EQ(names, "header height width fields is_bigendian point_step row_step data is_dense ");
  names.clear();
  for (const DynamicView& field : view["fields"].elements())
    names += field["name"].as<std::string>().value() + ' ';
  EXPECT_EQ(names, "x intensity  ");
}

TEST_F(DynamicViewTest, TellsWhatThingsAre) {
  EXPECT_TRUE(view.is_struct());
  EXPECT_TRUE(view["fields"].is_collection());
  EXPECT_EQ(view["fields"].shape(), Shape::sequence);
  EXPECT_EQ(view["fields"].kind(), Kind::structure);
  EXPECT_EQ(view["fields"][0].shape(), Shape::single);
  EXPECT_EQ(view["height"].kind(), Kind::uint32);
  EXPECT_EQ(view["header"].type()->name, "std_msgs::msg::Header");
}

TEST_F(DynamicViewTest, NumbersThatDoNotFitAreNotCut) {
  EXPECT_THAT(refusal(view["height"].as<std::int32_t>()), HasSubstr("'height' does not fit"));
  EXPECT_THAT(refusal(view["header"]["stamp"]["sec"].as<unsigned>()), HasSubstr("does not fit"));
  EXPECT_THAT(refusal(view["height"].as<bool>()), HasSubstr("does not fit"));
  EXPECT_THAT(refusal(view["height"].as<std::string>()), HasSubstr("does not fit"));
  EXPECT_EQ(view["height"].as<double>(), 3e9);
  EXPECT_THAT(refusal(view["height"].as<float>()), HasSubstr("does not fit"));
}

TEST_F(DynamicViewTest, WhatDoesNotExistIsNamedWithWhatMayHaveBeenMeant) {
  EXPECT_EQ(message(view["hieght"]),
            "sensor_msgs::msg::PointCloud2 has no member 'hieght'; did you mean 'height'?");
  EXPECT_THAT(message(view["fields"][3]), HasSubstr("'fields' has 3 elements"));
  EXPECT_THAT(message(view["fields"][-1]), HasSubstr("'fields' has 3 elements"));
  EXPECT_THAT(message(view["height"]["x"]), HasSubstr("is no struct"));
  EXPECT_THAT(message(view["height"][0]), HasSubstr("neither array nor sequence"));
  EXPECT_THAT(refusal(view["header"].as<int>()), HasSubstr("'header' is std_msgs::msg::Header"));
  EXPECT_THAT(refusal(view["height"].size()), HasSubstr("'height' is uint32, not an array"));
}

TEST_F(DynamicViewTest, AnErrorGoesThroughAllThatIsAskedOfIt) {
  const DynamicView wrong = view["headr"]["stamp"][3]["sec"];
  EXPECT_FALSE(wrong);
  EXPECT_FALSE(wrong.is_absent());
  EXPECT_THAT(refusal(wrong.as<int>()), HasSubstr("did you mean 'header'?"));
  EXPECT_THAT(refusal(wrong.size()), HasSubstr("did you mean 'header'?"));
  for (const DynamicView& m : wrong.members()) ADD_FAILURE() << m.name();
  for (const DynamicView& e : wrong.elements()) ADD_FAILURE() << e.name();
  EXPECT_FALSE(encoded.state().is_malformed());
}

TEST_F(DynamicViewTest, FieldsThatWereNotSentAreAbsentAndNeverZero) {
  const Encoded masked(cloud(), F::width | F::fields.each.name);
  const DynamicView some(masked.state(), type);
  EXPECT_TRUE(some["width"]);
  EXPECT_EQ(some["fields"][1]["name"].as<std::string>(), "intensity");
  for (const char* path : {"height", "header", "header.stamp.sec", "data", "data[0]", "fields[0].offset"}) {
    EXPECT_FALSE(some.find(path)) << path;
    EXPECT_TRUE(some.find(path).is_absent()) << path;
  }
  const auto height = some["height"].as<std::uint32_t>();
  ASSERT_FALSE(height);
  EXPECT_EQ(height.error().code, Errc::unavailable);
  EXPECT_EQ(height.error().message, "'height' was not sent in this sample");
  EXPECT_FALSE(some["data"].size());
  EXPECT_FALSE(some["data"].as<std::span<const std::uint8_t>>());
  EXPECT_THAT(message(some["header"]["stmp"]), HasSubstr("did you mean 'stamp'?"));
}

TEST_F(DynamicViewTest, ASequenceMayHaveBeenSentWithItsLengthOnly) {
  const Encoded masked(cloud(), Mask<PointCloud2>(F::fields.size));
  const DynamicView fields = DynamicView(masked.state(), type)["fields"];
  EXPECT_TRUE(fields.has_only_size());
  EXPECT_EQ(fields.size(), 3U);
  EXPECT_TRUE(fields[2].is_absent());
  EXPECT_TRUE(fields[2]["name"].is_absent());
  EXPECT_NE(fields[3].error(), nullptr);
  for (const DynamicView& e : fields.elements()) ADD_FAILURE() << e.name();
}

/// A view of a recorded sample.
class RecordedDynamicViewTest : public DynamicViewTest {
 protected:
  using Leaves = std::vector<std::size_t>;

  DynamicView masked(const Mask<PointCloud2>& mask) {
    sample.emplace(cloud(), mask);
    state = sample->state();
    state.log = &log;
    return {state, type};
  }
  Leaves found() const { return leaves_of(words[0].found); }
  Leaves missed() const { return leaves_of(words[0].missed); }

  std::vector<AccessWord> words = std::vector<AccessWord>(1);
  AccessLog log{words, nullptr};
  std::optional<Encoded> sample;
  SampleState state;

 private:
  Leaves leaves_of(const std::atomic<std::uint64_t>& word) const {
    const FieldMask mask = FieldMask::from_words(leaf_count(type), std::vector{word.load()});
    return {mask.begin(), mask.end()};
  }
};

TEST_F(RecordedDynamicViewTest, ValuesThatAreAskedForAreNoted) {
  const DynamicView some = masked(F::width | F::header.stamp);
  EXPECT_TRUE(some["width"].as<int>());
  EXPECT_TRUE(some["header"]["stamp"]["nanosec"].as<int>());
  EXPECT_FALSE(some["height"].as<int>());
  EXPECT_FALSE(some["data"].size());
  EXPECT_FALSE(some["fields"][1]["name"].as<std::string>());
  EXPECT_EQ(found(), (Leaves{1, 4}));
  EXPECT_EQ(missed(), (Leaves{3, 6, 13}));
}

TEST_F(RecordedDynamicViewTest, WhetherThereIsAValueIsNotedToo) {
  const DynamicView some = masked(F::width);
  EXPECT_TRUE(some);
  EXPECT_TRUE(some["width"]);
  EXPECT_FALSE(some["header"]);
  EXPECT_TRUE(some["is_dense"].is_absent());
  EXPECT_FALSE(some["widht"]);
  EXPECT_EQ(found(), (Leaves{4}));
  EXPECT_EQ(missed(), (Leaves{0}));
}

TEST_F(RecordedDynamicViewTest, ReadingElementsWhoseNumberAloneWasSentIsRecordedAsMissed) {
  const DynamicView fields = masked(F::fields.size)["fields"];
  int n = 0;
  for (const DynamicView& field : fields.elements()) n += field["datatype"].as<int>() ? 100 : 1;
  EXPECT_EQ(n, 3);
  EXPECT_EQ(found(), (Leaves{5}));
  EXPECT_EQ(missed(), (Leaves{8}));
}

TEST_F(RecordedDynamicViewTest, NoBytesVouchForTheirNumberWhichIsLimited) {
  const DynamicView fields = masked(F::fields.size)["fields"];
  const std::uint32_t huge = 0xFFFF'FFFF;
  std::memcpy(sample->body(), &huge, sizeof huge);
  EXPECT_EQ(std::ranges::distance(fields.elements().begin(), fields.elements().end()), max_empty_elements);
}

TEST_F(DynamicViewTest, EnumerationsHaveNames) {
  torture::Nested value;
  value.paint = torture::Color::BLUE;
  const Encoded sample(value);
  const DynamicView paint = DynamicView(sample.state(), TypeTable<torture::Nested>::type)["paint"];
  EXPECT_EQ(paint.enumerator(), "BLUE");
  EXPECT_EQ(paint.as<int>(), 7);
  EXPECT_EQ(view["height"].enumerator(), std::nullopt);
}

TEST_F(DynamicViewTest, FlagsOfABitmaskAreJoined) {
  static constexpr std::array<Enumerator, 2> flags{{{"READ", 1}, {"WRITE", 4}}};
  static constexpr EnumType access{"Access", true, flags};
  static constexpr std::array<Member, 1> members{
      {{.name = "access", .kind = Kind::uint8, .enumeration = &access}}};
  const StructType file("File", members);
  const FieldMask mask = FieldMask::full(1);
  const auto text = [&](unsigned value) {
    alignas(8) std::array<std::byte, 8> body{static_cast<std::byte>(value)};
    const SampleState s{.body = body.data(), .body_bytes = 1, .mask = &mask};
    return DynamicView(s, file)["access"].enumerator();
  };
  EXPECT_EQ(text(5), "READ | WRITE");
  EXPECT_EQ(text(4), "WRITE");
  EXPECT_EQ(text(0), std::nullopt);
  EXPECT_EQ(text(3), std::nullopt);
}

// ---- hostile bytes ----

TEST_F(DynamicViewTest, AnOffsetOutsideOfTheBodyIsMalformed) {
  encoded.index()[0] = encoded.state().body_bytes;
  EXPECT_EQ(view.find("header.stamp.sec").as<int>().error().code, Errc::malformed);
  EXPECT_TRUE(encoded.state().is_malformed());
}

TEST_F(DynamicViewTest, ASlotWithoutOffsetIsMalformedWhereTheMaskHasTheField) {
  encoded.index()[3] = no_offset;
  EXPECT_EQ(view["height"].error()->code, Errc::malformed);
  EXPECT_TRUE(encoded.state().is_malformed());
}

TEST_F(DynamicViewTest, LengthsBeyondTheBodyAreMalformed) {
  const auto put = [&](std::size_t slot, std::uint32_t length) {
    std::memcpy(encoded.body() + encoded.index()[slot], &length, sizeof length);
  };
  put(2, 1000);  // the length of header.frame_id
  EXPECT_EQ(view.find("header.frame_id").as<std::string>().error().code, Errc::malformed);
  put(9, 0xffffffff);  // the length of data
  EXPECT_EQ(view["data"].size().error().code, Errc::malformed);
  EXPECT_EQ(view["data"][0].error()->code, Errc::malformed);
  EXPECT_EQ(view["data"].as<std::span<const std::uint8_t>>().error().code, Errc::malformed);
  std::size_t n = 0;
  for (const DynamicView& e : view["data"].elements()) n += e.error()->code == Errc::malformed ? 1 : 100;
  EXPECT_EQ(n, 1U);
}

TEST_F(DynamicViewTest, IterationOverElementsThatTheBytesDoNotHoldEndsWithAnError) {
  const std::uint32_t length = 0xffffffff;
  std::memcpy(encoded.body() + encoded.index()[5], &length, sizeof length);  // the length of fields
  std::size_t n = 0;
  bool malformed = false;
  for (const DynamicView& e : view["fields"].elements()) {
    ASSERT_LT(++n, 100U);
    malformed = e.error() != nullptr;
  }
  EXPECT_TRUE(malformed);
  EXPECT_NE(view["fields"][4'000'000'000].error(), nullptr);
}

}  // namespace
}  // namespace sft
