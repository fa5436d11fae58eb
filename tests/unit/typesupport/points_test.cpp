// Typed columns of clouds: their values in both layouts, errors, ranges, and the reads that recorded samples
// record.
#include "sft/points.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <ranges>
#include <string>
#include <tuple>
#include <vector>
#include <views.hpp>

#include "sft/detail/parts_in_place.h"
#include "sft/dynamic_view.h"
#include "tests/support/point_cloud.h"

namespace sft {
namespace {

using sensor_msgs::msg::PointCloud2;
using test::Arrived;
using test::message_of;
using F = PointCloud2::Field;
using Xyz = Cells<std::tuple<float, float, float>>;

static_assert(std::random_access_iterator<Xyz::iterator>);
static_assert(std::ranges::random_access_range<Xyz> && std::ranges::sized_range<Xyz>);
static_assert(std::ranges::common_range<Xyz> && std::ranges::view<Xyz> && std::ranges::borrowed_range<Xyz>);
static_assert(std::is_trivially_copyable_v<Xyz> && sizeof(Xyz) <= 64);

/// Returns the points as bits, because random values may be NaN.
template <class... Ts>
std::vector<std::array<std::uint64_t, sizeof...(Ts)>> bits_of(const Cells<std::tuple<Ts...>>& points) {
  std::vector<std::array<std::uint64_t, sizeof...(Ts)>> bits;
  for (const auto point : points) {
    auto& one = bits.emplace_back();
    std::apply(
        [&](const auto&... value) {
          std::size_t i = 0;
          (std::memcpy(&one[i++], &value, sizeof value), ...);
        },
        point);
  }
  return bits;
}

class PointsTest : public test::RandomTest {
 protected:
  PointCloud2 cloud(std::uint32_t height, std::uint32_t width) {
    return test::random_cloud(random, height, width);
  }
  /// Returns the cloud without padding after the rows.
  PointCloud2 dense_cloud(std::uint32_t height, std::uint32_t width) {
    PointCloud2 dense = cloud(height, width);
    dense.row_step = width * dense.point_step;
    dense.data.resize(std::size_t{height} * dense.row_step);
    return dense;
  }
};

TEST_F(PointsTest, ReadsTheSameFromTheWholeCloudAndFromAPackedPart) {
  for (const PointCloud2& whole : {cloud(7, 13), dense_cloud(7, 13), cloud(1, 91)}) {
    const Arrived full(whole);
    const Arrived packed(whole, "data{x,y,z}");
    ASSERT_TRUE(full.is_good() && packed.is_good());
    ASSERT_EQ(packed.view().point_step(), 12U);
    const auto of_full = full.view().points<float, float, float>("x", "y", "z");
    const auto of_packed = packed.view().points<float, float, float>("x", "y", "z");
    ASSERT_TRUE(of_full && of_packed) << message_of(of_full) << message_of(of_packed);
    EXPECT_EQ(of_full->size(), 91U);
    EXPECT_EQ(of_full->rows(), whole.height);
    EXPECT_EQ(of_packed->rows(), whole.height);
    EXPECT_EQ(of_packed->columns(), whole.width);
    EXPECT_EQ(bits_of(*of_full), bits_of(*of_packed));
  }
}

TEST_F(PointsTest, ReadsAllTypesAtUnalignedOffsetsWhereverRowsBegin) {
  const PointCloud2 whole = cloud(5, 9);
  const Arrived sample(whole);
  const auto points = sample.view()
                          .points<float, double, std::uint8_t, std::uint16_t, std::int8_t, std::uint32_t,
                                  std::int16_t, std::int32_t>("intensity", "time", "reflectivity", "ring",
                                                              "temperature", "tag", "drift", "phase");
  ASSERT_TRUE(points) << message_of(points);
  const auto same = [](auto a, auto b) { return std::memcmp(&a, &b, sizeof a) == 0; };
  for (std::size_t row = 0; row < 5; ++row) {
    for (std::size_t column = 0; column < 9; ++column) {
      const std::size_t at = row * whole.row_step + column * 48;
      const auto [intensity, time, reflectivity, ring, temperature, tag, drift, phase] =
          points->at(row, column);
      EXPECT_TRUE(same(intensity, test::value_at<float>(whole, at + 13)));
      EXPECT_TRUE(same(time, test::value_at<double>(whole, at + 17)));
      EXPECT_EQ(reflectivity, test::value_at<std::uint8_t>(whole, at + 25));
      EXPECT_EQ(ring, test::value_at<std::uint16_t>(whole, at + 27));
      EXPECT_EQ(temperature, test::value_at<std::int8_t>(whole, at + 29));
      EXPECT_EQ(tag, test::value_at<std::uint32_t>(whole, at + 30));
      EXPECT_EQ(drift, test::value_at<std::int16_t>(whole, at + 34));
      EXPECT_EQ(phase, test::value_at<std::int32_t>(whole, at + 36));
    }
  }
}

TEST_F(PointsTest, ValuesOfABigEndianCloudAreSwapped) {
  PointCloud2 whole = cloud(2, 3);
  whole.is_bigendian = true;
  const std::array<std::uint8_t, 4> one_and_a_half{0x3F, 0xC0, 0, 0};
  std::ranges::copy(one_and_a_half, whole.data.begin() + 48 + 13);
  const std::array<std::uint8_t, 8> minus_two{0xC0, 0, 0, 0, 0, 0, 0, 0};
  std::ranges::copy(minus_two, whole.data.begin() + 48 + 17);
  whole.data[48 + 25] = 200;
  whole.data[48 + 27] = 1;
  whole.data[48 + 28] = 2;
  const Arrived full(whole);
  const Arrived part(whole, "data{intensity,ring,time,reflectivity}");
  for (const Arrived<PointCloud2>* sample : {&full, &part}) {
    const auto points = sample->view().points<float, double, std::uint8_t, std::uint16_t>(
        "intensity", "time", "reflectivity", "ring");
    ASSERT_TRUE(points) << message_of(points);
    EXPECT_EQ((*points)[1], std::tuple(1.5F, -2.0, std::uint8_t{200}, std::uint16_t{0x102}));
  }
}

TEST_F(PointsTest, AMissingChannelIsAnErrorThatNamesThoseOfTheCloud) {
  PointCloud2 whole = cloud(2, 3);
  whole.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"far", 45, 7, 1}, {"none", 0, 7, 0}, {"odd", 0, 9, 1}};
  const Arrived sample(whole);
  for (const char* name : {"ring", "", "X"}) {
    const auto points = sample.view().points<float, float>("x", name);
    ASSERT_FALSE(points) << name;
    EXPECT_EQ(points.error().code, Errc::unknown_field);
    EXPECT_EQ(points.error().message, "the cloud has no channel '" + std::string(name) + "'; it has x, y");
  }
  const auto fault_of = [&](const char* name) { return message_of(sample.view().points<float>(name)); };
  EXPECT_EQ(fault_of("none"), "channel 'none' has a count of 0");
  EXPECT_EQ(fault_of("odd"), "channel 'odd' has the unknown type 9");
  EXPECT_EQ(fault_of("far"), "channel 'far' ends 1 bytes behind the end of its point");
  EXPECT_FALSE(sample.state().is_malformed());
  const Arrived nothing(PointCloud2{});
  EXPECT_EQ(message_of(nothing.view().points<float>("x")), "the cloud has no channel 'x'; it has none");
}

TEST_F(PointsTest, AChannelOfAnotherTypeIsAnErrorThatNamesBoth) {
  const Arrived sample(cloud(2, 3));
  const auto points = sample.view().points<float, float>("x", "ring");
  ASSERT_FALSE(points);
  EXPECT_EQ(points.error().code, Errc::type_mismatch);
  EXPECT_EQ(points.error().message, "channel 'ring' is uint16, not float");
  EXPECT_EQ(message_of(sample.view().points<std::int16_t>("ring")), "channel 'ring' is uint16, not int16");
  EXPECT_EQ(message_of(sample.view().points<float>("time")), "channel 'time' is double, not float");
}

TEST_F(PointsTest, TheFirstOfTwoChannelsWithOneNameCounts) {
  PointCloud2 whole = cloud(1, 2);
  const Arrived sample(whole);
  EXPECT_EQ(message_of(sample.view().points<std::uint16_t>("x")), "channel 'x' is float, not uint16");
  whole.fields[0].offset = 45;  // the first channel counts although its bytes are beyond the point
  const Arrived other(whole);
  EXPECT_FALSE(other.view().points<std::uint16_t>("x"));
}

TEST_F(PointsTest, AnErrorNamesAsManyChannelsAsASelectionCan) {
  PointCloud2 whole = cloud(1, 1);
  const auto named = [&whole](std::size_t channels) {
    whole.fields.assign(channels, {"n", 0, 7, 1});
    const std::string message = message_of(Arrived(whole).view().points<float>("x"));
    return std::pair(std::ranges::count(message, 'n'), message.ends_with(", ..."));
  };
  const auto [all, all_are_cut] = named(Selection::channels_max);
  const auto [some, some_are_cut] = named(Selection::channels_max + 1);
  EXPECT_FALSE(all_are_cut);
  EXPECT_TRUE(some_are_cut);
  EXPECT_EQ(some, all);
}

TEST_F(PointsTest, AChannelThatACloudHasTwiceStandsForNoOther) {
  PointCloud2 whole = cloud(1, 2);
  whole.fields = {{"x", 0, 7, 1}, {"x", 4, 7, 1}, {"y", 8, 7, 1}};
  const Arrived twice(whole);
  whole.fields = {{"x", 0, 7, 1}, {"y", 8, 7, 1}};
  const Arrived once(whole);
  const auto points = twice.view().points<float, float>("x", "y");
  ASSERT_TRUE(points) << message_of(points);
  EXPECT_EQ(bits_of(*points), bits_of(*once.view().points<float, float>("x", "y")));
}

TEST_F(PointsTest, NamesInErrorsCanBeSentToATerminal) {
  PointCloud2 whole = cloud(1, 1);
  whole.fields = {{"a\x1b[2J", 0, 7, 1}, {std::string(1000, 'n'), 0, 7, 1}, {"good", 0, 7, 1}};
  EXPECT_EQ(message_of(Arrived(whole).view().points<float>("x")),
            "the cloud has no channel 'x'; it has ..., ..., good");
  whole.fields.assign(10'000, {"x", 0, 7, 1});
  EXPECT_LT(message_of(Arrived(whole).view().points<float>("y")).size(), 1000U);
}

TEST_F(PointsTest, ACloudThatContradictsItselfIsAnErrorThatNamesTheNumbers) {
  const PointCloud2 whole = cloud(3, 4);
  const auto error_with = [&](void (*change)(PointCloud2&)) {
    PointCloud2 changed = whole;
    change(changed);
    const Arrived sample(changed);
    const auto points = sample.view().points<float>("x");
    EXPECT_TRUE(points || points.error().code == Errc::malformed);
    return message_of(points);
  };
  constexpr const char* text =
      "the cloud contradicts itself: 3 x 4 points, point_step 48 and row_step 191 do not fit the 636 bytes "
      "of "
      "data";
  EXPECT_EQ(error_with([](PointCloud2& c) { c.row_step = 191; }), text);
  EXPECT_NE(error_with([](PointCloud2& c) { c.height = 4; }), "no error");
  EXPECT_NE(error_with([](PointCloud2& c) { c.width = 5; }), "no error")
      << "a point is larger than what is left of the row";
  EXPECT_NE(error_with([](PointCloud2& c) { c.row_step = 0; }), "no error");
  EXPECT_NE(error_with([](PointCloud2& c) { c.point_step = 54; }), "no error");
  EXPECT_NE(error_with([](PointCloud2& c) { c.height = c.width = c.row_step = 0xFFFF'FFFF; }), "no error");
  EXPECT_NE(error_with([](PointCloud2& c) { c.data.clear(); }), "no error");
  EXPECT_NE(error_with([](PointCloud2& c) { c.data.resize(3 * 212 - 21); }), "no error");
}

TEST_F(PointsTest, ACloudOfNoRowsOrNoColumnsHasNoPoints) {
  for (const auto field : {&PointCloud2::height, &PointCloud2::width}) {
    PointCloud2 none = cloud(3, 4);
    none.*field = 0;
    const Arrived sample(none);
    const auto points = sample.view().points<float>("x");
    ASSERT_TRUE(points) << message_of(points);
    EXPECT_EQ(points->begin(), points->end());
  }
}

// Drivers that organise a cloud may leave the old row_step, the size of the whole cloud, or 0.
TEST_F(PointsTest, RowsFollowEachOtherWhereTheDataHasJustTheBytesOfThePointsWhateverRowStepSays) {
  PointCloud2 whole = dense_cloud(4, 5);
  const Arrived honest(whole);
  const auto expected = bits_of(honest.view().points<float, float, float>("x", "y", "z").value());
  for (const std::uint32_t row_step : {0U, 1U, 4 * 5 * whole.point_step, 0xFFFF'FFFFU}) {
    whole.row_step = row_step;
    const Arrived full(whole), packed(whole, "data{x,y,z}"), window(whole, "data{x}[rows 1:4, columns ::2]");
    for (const Arrived<PointCloud2>* sample : {&full, &packed}) {
      const auto points = sample->view().points<float, float, float>("x", "y", "z");
      ASSERT_TRUE(points) << message_of(points);
      EXPECT_EQ(points->rows(), 4U);
      EXPECT_EQ(bits_of(*points), expected) << row_step;
    }
    EXPECT_EQ(window.view().points<float>("x")->size(), 3 * 3U) << row_step;
  }
}

TEST_F(PointsTest, TheLastRowNeedsNoPaddingAndTheLengthOfAnOnlyRowDoesNotCount) {
  PointCloud2 whole = cloud(3, 4);
  whole.data.resize(3 * 212 - 20);
  EXPECT_EQ(Arrived(whole).view().points<float>("x")->size(), 12U);
  whole = cloud(1, 4);
  whole.row_step = 1;
  const Arrived sample(whole);
  const auto points = sample.view().points<float>("x");
  ASSERT_TRUE(points);
  EXPECT_EQ(std::ranges::distance(*points), 4);
}

TEST_F(PointsTest, IsARangeForTheAlgorithmsOfTheStandard) {
  PointCloud2 whole = cloud(4, 6);
  for (std::size_t i = 0; i < 24; ++i) {
    const float x = static_cast<float>(i) / 2;
    std::memcpy(whole.data.data() + i / 6 * whole.row_step + i % 6 * 48, &x, sizeof x);
  }
  const Arrived sample(whole);
  const auto points = sample.view().points<float>("x").value();
  const auto x_of = [](const auto& point) { return std::get<0>(point); };
  EXPECT_EQ(std::ranges::lower_bound(points, 4.5F, {}, x_of) - points.begin(), 9);
  EXPECT_EQ(x_of(*std::ranges::max_element(points, {}, x_of)), 11.5F);
  EXPECT_EQ(std::ranges::count_if(
                points, [](float x) { return x < 3; }, x_of),
            6);
  std::vector<float> back;
  for (const auto [x] : points | std::views::reverse | std::views::drop(2) | std::views::take(15))
    back.push_back(x);
  ASSERT_EQ(back.size(), 15U);
  EXPECT_EQ(back.front(), 10.5F);
  EXPECT_EQ(back.back(), 3.5F);
  EXPECT_EQ(x_of(points.front()), 0);
  EXPECT_EQ(x_of(points.back()), 11.5F);
}

TEST_F(PointsTest, AnIteratorJumpsToWhereItWouldHaveWalked) {
  for (const PointCloud2& whole : {cloud(4, 5), dense_cloud(4, 5), cloud(20, 1), cloud(1, 20)}) {
    const Arrived sample(whole);
    const auto points = sample.view().points<std::uint32_t>("tag").value();
    for (std::ptrdiff_t from = 0; from <= 20; ++from) {
      for (std::ptrdiff_t to = 0; to <= 20; ++to) {
        auto walked = points.begin() + from;
        for (std::ptrdiff_t at = from; at < to; ++at) ++walked;
        for (std::ptrdiff_t at = from; at > to; --at) --walked;
        const auto jumped = points.begin() + from + (to - from);
        ASSERT_EQ(walked, jumped);
        ASSERT_EQ(walked - points.begin(), to);
        ASSERT_EQ(points.end() - jumped, 20 - to);
        ASSERT_EQ(points.begin() + from < jumped, from < to);
        if (to == 20) continue;
        ASSERT_EQ(*walked, points[static_cast<std::size_t>(to)]);
        ASSERT_EQ(*walked, points.begin()[to]);
      }
    }
  }
}

TEST_F(PointsTest, ACloudInAnotherMessageHasPointsToo) {
  views::Recording recording;
  recording.left.label = "l";
  recording.cloud = cloud(3, 5);
  const Arrived sample(recording);
  const auto points = sample.view().cloud().points<float, std::uint16_t>("x", "ring");
  ASSERT_TRUE(points) << message_of(points);
  EXPECT_EQ(bits_of(*points),
            bits_of(*Arrived(recording.cloud).view().points<float, std::uint16_t>("x", "ring")));

  views::Clouds clouds{.name = "both", .clouds = {cloud(2, 2), cloud(3, 7)}};
  const Arrived several(clouds);
  const auto of_second = several.view().clouds()[1].points<std::uint32_t>("tag");
  ASSERT_TRUE(of_second) << message_of(of_second);
  EXPECT_EQ(bits_of(*of_second), bits_of(*Arrived(clouds.clouds[1]).view().points<std::uint32_t>("tag")));
}

TEST_F(PointsTest, ADeclaredMaskWithAllFieldsOfACloudIsEnough) {
  constexpr Mask<PointCloud2> mask =
      F::height | F::width | F::fields | F::is_bigendian | F::point_step | F::row_step | F::data;
  const PointCloud2 whole = cloud(3, 4);
  const test::Encoded sample(whole, mask);
  const auto points = detail::view_of<PointCloud2, mask>(sample.state()).points<double>("time");
  ASSERT_TRUE(points) << message_of(points);
  EXPECT_EQ(bits_of(*points), bits_of(*Arrived(whole).view().points<double>("time")));
}

/// A recorded sample of a cloud with these fields.
class RecordedCloud {
 public:
  RecordedCloud(const PointCloud2& cloud, const Mask<PointCloud2>& mask) : encoded_(cloud, mask) {
    state_ = encoded_.state();
    state_.log = &log_;
  }
  auto view() const { return detail::view_of<PointCloud2, recorded>(state_); }
  DynamicView dynamic_view() const { return {state_, detail::TypeTable<PointCloud2>::type}; }
  FieldMask found() const { return read(&detail::AccessWord::found); }
  FieldMask missed() const { return read(&detail::AccessWord::missed); }

 private:
  FieldMask read(std::atomic<std::uint64_t> detail::AccessWord::*which) const {
    const std::uint64_t word = words_[0].*which;
    return FieldMask::from_words(detail::leaf_count_of<PointCloud2>, {&word, 1});
  }

  std::vector<detail::AccessWord> words_ = std::vector<detail::AccessWord>(1);
  detail::AccessLog log_{words_, nullptr};
  test::Encoded encoded_;
  detail::SampleState state_;
};

const FieldMask needed(F::height | F::width | F::fields | F::is_bigendian | F::point_step | F::row_step |
                       F::data);

TEST_F(PointsTest, ARecordedSampleNotesAllFieldsThatPointsNeed) {
  const RecordedCloud sample(cloud(2, 3), all<PointCloud2>), other(cloud(2, 3), all<PointCloud2>);
  EXPECT_TRUE(sample.view().points<float>("x"));
  EXPECT_TRUE(points_of<float>(other.dynamic_view(), "x"));
  for (const RecordedCloud* one : {&sample, &other}) {
    EXPECT_EQ(one->found(), needed);
    EXPECT_TRUE(one->missed().empty());
  }
}

TEST_F(PointsTest, AFieldThatWasNotSentIsAnErrorAndAllThatAreMissingAreNoted) {
  const Mask<PointCloud2> sent = F::height | F::width | F::data | F::fields.size | F::fields.each.name;
  const RecordedCloud sample(cloud(2, 3), sent), other(cloud(2, 3), sent);
  const auto points = sample.view().points<float>("x");
  const auto dynamic_points = points_of<float>(other.dynamic_view(), "x");
  ASSERT_FALSE(points);
  ASSERT_FALSE(dynamic_points);
  EXPECT_EQ(points.error().code, Errc::unavailable);
  EXPECT_EQ(points.error().message, "'fields' was not sent in this sample");
  EXPECT_EQ(dynamic_points.error().message, points.error().message);
  for (const RecordedCloud* one : {&sample, &other}) {
    EXPECT_EQ(one->found(), FieldMask(sent));
    EXPECT_EQ(one->missed(), needed - FieldMask(sent));
  }
}

/// Records the channels that are read. A channel's number is the first letter of its name.
struct ChannelListener final : detail::AccessLog::Listener {
  void first_read(std::size_t) noexcept override {}
  std::optional<std::size_t> number_of_channel(std::size_t, std::string_view name) noexcept override {
    return 32 + static_cast<std::size_t>(name[0] % 16);
  }
};

TEST_F(PointsTest, ChannelsThatOverlapAreReadAsWholePointsInWhateverOrderTheyAre) {
  using Channels = std::vector<sensor_msgs::msg::PointField>;
  const sensor_msgs::msg::PointField x{"x", 0, 7, 1}, y{"y", 4, 7, 1}, rgb{"rgb", 12, 7, 1},
      argb{"argb", 14, 6, 1};
  const std::vector<std::pair<Channels, bool>> clouds{
      {{x, y, rgb}, false},   {{rgb, y, x}, false},   {{y, rgb, x}, false},
      {{x, rgb, argb}, true}, {{argb, rgb, x}, true}, {{argb, x, rgb}, true},
  };
  for (const auto& [channels, overlap] : clouds) {
    PointCloud2 message = cloud(2, 3);
    message.fields = channels;
    const Arrived sample(message);
    ChannelListener listener;
    std::vector<detail::AccessWord> words(1);
    detail::AccessLog log(words, &listener);
    detail::SampleState state = sample.state();
    state.log = &log;
    ASSERT_TRUE((detail::view_of<PointCloud2, recorded>(state).points<float>("x")));
    EXPECT_EQ((words[0].found & FieldMask(F::data).word(0)) != 0, overlap);
    EXPECT_NE(words[0].found >> 32, 0U) << "the channel is noted";
  }
}

/// The data of a cloud, cut as a list instead of as points, because `width` belongs to the rule of another
/// field.
struct CutAsList final : detail::PartsInPlace {
  explicit CutAsList(const detail::SampleState& sample) : source(sample) {
    EXPECT_TRUE(cut.find(source, nullptr, data, part));
  }
  std::optional<detail::PartInPlace> find(std::size_t wanted) noexcept override {
    if (wanted != data.leaf) return {};
    return detail::PartInPlace{&source, data, &cut};
  }
  std::optional<std::span<const std::byte>> bytes_of(std::size_t) noexcept override { return {}; }
  const detail::SampleState& put_together() noexcept override { return source; }

  const detail::SampleState source;
  const std::uint32_t leaf = static_cast<std::uint32_t>(*FieldMask(F::data).begin());
  const detail::Layout::Field data = detail::field_at(detail::TypeTable<PointCloud2>::type, leaf);
  const Selection::Part part{.leaf = leaf, .columns = {.step = 4}};
  detail::Cut cut;
};

TEST_F(PointsTest, DataThatWasNotCutAsPointsHasNone) {
  const Arrived sample(cloud(2, 3));
  CutAsList parts(sample.state());
  detail::SampleState state = sample.state();
  state.parts = &parts;
  const auto points = detail::view_of<PointCloud2, all<PointCloud2>>(state).points<float>("time2");
  EXPECT_FALSE(points);
  const auto x = detail::view_of<PointCloud2, all<PointCloud2>>(state).points<double>("time");
  ASSERT_TRUE(x) << message_of(x);
  EXPECT_TRUE(x->empty());
}

TEST_F(PointsTest, ADynamicViewOfACloudHasTheSamePoints) {
  const PointCloud2 whole = cloud(3, 4);
  for (const char* selection : {"*", "data{x,ring}"}) {
    const Arrived sample(whole, selection);
    const auto points = points_of<float, std::uint16_t>(sample.dynamic_view(), "x", "ring");
    ASSERT_TRUE(points) << message_of(points);
    EXPECT_EQ(bits_of(*points), bits_of(*sample.view().points<float, std::uint16_t>("x", "ring")));
  }
  views::Clouds clouds{.name = "both", .clouds = {cloud(2, 2), whole}};
  const Arrived several(clouds);
  const auto of_second = points_of<double>(several.dynamic_view().find("clouds[1]"), "time");
  ASSERT_TRUE(of_second) << message_of(of_second);
  EXPECT_EQ(bits_of(*of_second), bits_of(*Arrived(whole).view().points<double>("time")));
}

TEST_F(PointsTest, ADynamicViewOfSomethingElseIsAnError) {
  const Arrived sample(cloud(1, 1));
  const DynamicView view = sample.dynamic_view();
  EXPECT_EQ(message_of(points_of<float>(view["width"], "x")), "'width' is uint32, not a cloud");
  EXPECT_EQ(message_of(points_of<float>(view["header"], "x")),
            "'header' is std_msgs::msg::Header, not a cloud");
  EXPECT_FALSE(points_of<float>(view["fields"], "x"));
  EXPECT_EQ(message_of(points_of<float>(view["clod"], "x")), message_of(view["clod"].as<int>()));
  const FieldMask declared = FieldMask(all<PointCloud2>) - FieldMask(F::data);
  EXPECT_EQ(
      message_of(points_of<float>({sample.state(), detail::TypeTable<PointCloud2>::type, declared}, "x")),
      "'data' was not sent in this sample");
}

}  // namespace
}  // namespace sft
