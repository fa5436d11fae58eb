// Typed cells of fields: pixels, map cells, beams and other numbers. Some fields have no cells.
#include "sft/cells.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <ranges>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/MultiEchoLaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/msg_text.h"
#include "tests/support/point_cloud.h"

namespace sft {
namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using test::Arrived;
using test::message_of;
using Rgb = std::array<std::uint8_t, 3>;

static_assert(std::random_access_iterator<Cells<Rgb>::iterator>);
static_assert(std::ranges::random_access_range<Cells<float>> && std::ranges::sized_range<Cells<float>>);
static_assert(std::ranges::view<Cells<float>> && std::ranges::borrowed_range<Cells<float>>);
static_assert(std::is_trivially_copyable_v<Cells<Rgb>> && sizeof(Cells<Rgb>) <= 48);

/// Returns an image in which each pixel holds its position. Three bytes of padding follow each row.
Image image(std::uint32_t height, std::uint32_t width) {
  Image made;
  made.height = height;
  made.width = width;
  made.encoding = "rgb8";
  made.step = 3 * width + 3;
  made.data.resize(std::size_t{height} * made.step, 0xEE);
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      std::uint8_t* const pixel = made.data.data() + row * made.step + 3 * column;
      pixel[0] = static_cast<std::uint8_t>(row);
      pixel[1] = static_cast<std::uint8_t>(column);
      pixel[2] = 0;
    }
  }
  return made;
}

TEST(CellsTest, PixelsAreThoseOfTheImageOrOfItsPart) {
  const Arrived whole(image(20, 30));
  const Arrived part(image(20, 30), "data[rows 4:20:5, columns 3:28:2]");
  const auto of_whole = whole.view().data<Rgb>(), of_part = part.view().data<Rgb>();
  ASSERT_TRUE(of_whole && of_part) << message_of(of_whole) << message_of(of_part);
  EXPECT_EQ(of_whole->rows(), 20U);
  EXPECT_EQ(of_whole->columns(), 30U);
  EXPECT_EQ(of_part->rows(), 4U);
  EXPECT_EQ(of_part->columns(), 13U);
  EXPECT_EQ(of_whole->at(19, 29), (Rgb{19, 29, 0}));
  EXPECT_EQ(of_part->at(3, 12), (Rgb{19, 27, 0}));
  EXPECT_EQ(of_part->back(), (Rgb{19, 27, 0}));
  std::size_t i = 0;
  for (const auto [row, column, blue] : *of_whole) {
    EXPECT_EQ(row, i / 30);
    EXPECT_EQ(column, i % 30);
    EXPECT_EQ((*of_whole)[i++], (Rgb{row, column, blue}));
  }
  EXPECT_EQ(i, 600U);
  EXPECT_EQ(std::ranges::count_if(*of_part, [](Rgb pixel) { return pixel[0] == 9; }), 13);
}

TEST(CellsTest, ARowIsASpanWhereItsCellsLieTogether) {
  const Arrived whole(image(20, 30));
  const auto pixels = whole.view().data<Rgb>();
  ASSERT_TRUE(pixels && pixels->row(19));
  EXPECT_TRUE(std::ranges::equal(*pixels->row(19), *pixels | std::views::drop(19 * 30)));
  EXPECT_EQ(pixels->row(0)->data(), reinterpret_cast<const Rgb*>(whole.view().data().data()));
}

TEST(CellsTest, ARowIsNoSpanOfCellsThatAreApartOrSwappedOrNotAligned) {
  LaserScan scan;
  scan.ranges = {1, 2, 3, 4, 5};
  const Arrived beams(scan);
  const detail::CellGrid together{.first = reinterpret_cast<const std::byte*>(beams.view().ranges().data()),
                                  .row_step = 20,
                                  .column_step = 4,
                                  .rows = 1,
                                  .columns = 5};
  detail::CellGrid apart = together, swapped = together, shifted = together;
  apart.column_step = 8;
  swapped.is_swapped = true;
  shifted.first += 2;
  EXPECT_TRUE(Cells<float>(together, {}).row(0));
  EXPECT_FALSE(Cells<float>(apart, {}).row(0));
  EXPECT_FALSE(Cells<float>(swapped, {}).row(0));
  EXPECT_FALSE(Cells<float>(shifted, {}).row(0));
}

TEST(CellsTest, APixelOfAnotherSizeIsAnErrorThatNamesBoth) {
  const Arrived sample(image(2, 3));
  EXPECT_EQ(message_of(sample.view().data<std::uint8_t>()), "a cell of 'data' has 3 bytes, not 1");
  EXPECT_EQ(sample.view().data<float>().error().code, Errc::type_mismatch);
  EXPECT_FALSE(sample.state().is_malformed());
}

TEST(CellsTest, AnImageInPlanesHasNoCells) {
  Image planes = image(2, 4);
  planes.encoding = "nv12";
  EXPECT_EQ(message_of(Arrived(planes).view().data<std::uint8_t>()),
            "'data' has no cells of one size in its encoding");
}

TEST(CellsTest, PixelsOfABigEndianImageAreSwapped) {
  Image deep = image(1, 2);
  deep.encoding = "16UC2";
  deep.is_bigendian = 1;
  deep.step = 8;
  deep.data = {1, 2, 3, 4, 5, 6, 7, 8};
  using Pair = std::array<std::uint16_t, 2>;
  const Arrived sample(deep);
  const auto pairs = sample.view().data<Pair>();
  ASSERT_TRUE(pairs) << message_of(pairs);
  EXPECT_EQ(pairs->at(0, 1), (Pair{0x506, 0x708}));
  EXPECT_EQ((*cells_of<Pair>(sample.dynamic_view(), "data"))[0], (Pair{0x102, 0x304}));
  deep.encoding = "32FC1";
  deep.data = {0x3F, 0xC0, 0, 0, 0xC0, 0, 0, 0};
  const Arrived depth(deep);
  const auto values = depth.view().data<float>();
  ASSERT_TRUE(values) << message_of(values);
  EXPECT_TRUE(std::ranges::equal(*values, std::array{1.5F, -2.F}));
}

TEST(CellsTest, AnImageThatIsShorterThanItsHeightSaysIsEmpty) {
  Image too_tall = image(2, 3);
  too_tall.height = 3;
  const Arrived sample(too_tall);
  const auto pixels = sample.view().data<Rgb>();
  ASSERT_TRUE(pixels) << message_of(pixels);
  EXPECT_TRUE(pixels->empty());
  EXPECT_EQ(pixels->begin(), pixels->end());
}

TEST(CellsTest, AMapHasRowsAndColumnsOfItsInfo) {
  OccupancyGrid map;
  map.info.height = 2;
  map.info.width = 3;
  map.data = {0, 1, 2, 3, 4, -1};
  const Arrived sample(map);
  const auto cells = sample.view().data<std::int8_t>();
  ASSERT_TRUE(cells) << message_of(cells);
  EXPECT_EQ(cells->rows(), 2U);
  EXPECT_EQ(cells->at(1, 2), -1);
  EXPECT_EQ(cells->at(1, 0), 3);
}

TEST(CellsTest, BeamsAndOtherNumbersAreOneRow) {
  LaserScan scan;
  scan.ranges = {1, 2, 3, 4, 5};
  const Arrived whole(scan);
  const Arrived part(scan, "ranges[1::2]");
  EXPECT_EQ(whole.view().ranges<float>()->rows(), 1U);
  EXPECT_EQ(whole.view().ranges<float>()->columns(), 5U);
  EXPECT_TRUE(std::ranges::equal(*part.view().ranges<float>(), std::array{2.F, 4.F}));
  const auto none = whole.view().intensities<float>();
  ASSERT_TRUE(none) << message_of(none);
  EXPECT_TRUE(none->empty());
}

TEST(CellsTest, OfAMemberInASequenceAreItsElements) {
  sensor_msgs::msg::MultiEchoLaserScan scan;
  scan.ranges.resize(2);
  scan.ranges[1].echoes = {7, 8, 9};
  const Arrived sample(scan);
  const auto echoes = sample.view().ranges()[1].echoes<float>();
  ASSERT_TRUE(echoes) << message_of(echoes);
  EXPECT_TRUE(std::ranges::equal(*echoes, std::array{7.F, 8.F, 9.F}));
  const auto same = cells_of<float>(sample.dynamic_view(), "ranges[1].echoes");
  ASSERT_TRUE(same) << message_of(same);
  EXPECT_EQ(same->back(), 9.F);
}

template <class C>
concept has_row_spans = requires(const C& cells) {
  cells.row(0);
};
static_assert(has_row_spans<Cells<Rgb>>);
static_assert(!has_row_spans<Cells<std::tuple<float, float>>>, "a tuple has its members in another order");

TEST(CellsTest, TheCellsOfACloudHaveChannelsAndAreReadAsPoints) {
  test::Random random(1);
  const Arrived sample(test::random_cloud(random, 2, 3));
  EXPECT_EQ(message_of(cells_of<std::uint8_t>(sample.dynamic_view(), "data")),
            "the cells of 'data' have channels: read its points");
}

TEST(CellsTest, ByteOrderIsThatOfBytesAndNotOfLargerElements) {
  constexpr const char* text =
      "uint32 columns\nbool is_bigendian\nfloat32[] heights  # @sft_layout "
      "columns=columns byte_order=is_bigendian\n";
  const DynamicType type = from_msg("test_msgs/msg/Heights", text).value();
  const auto cdr =
      cdr_from_json(type.type(), R"({"columns": 2, "is_bigendian": true, "heights": [1.5, 2]})").value();
  const std::vector<std::byte> body(cdr.begin() + 4, cdr.end());
  const FieldMask mask = type.support().full();
  std::vector<std::uint32_t> index(type.support().index_slots());
  const detail::SampleState state{.body = body.data(),
                                  .body_bytes = static_cast<std::uint32_t>(body.size()),
                                  .index = index.data(),
                                  .mask = &mask};
  ASSERT_EQ(detail::build_index(state, type.type(), index), detail::WalkStatus::ok);
  const auto heights = cells_of<float>(DynamicView(state, type.type()), "heights");
  ASSERT_TRUE(heights) << message_of(heights);
  EXPECT_TRUE(std::ranges::equal(*heights, std::array{1.5F, 2.F}));
}

TEST(CellsTest, OfAMapNeedNeitherItsScaleNorItsOrigin) {
  OccupancyGrid map;
  map.info.height = map.info.width = 1;
  map.data = {7};
  const Arrived full(map);
  using M = OccupancyGrid::Field;
  const auto cells = detail::view_of<OccupancyGrid, M::data | M::info.height | M::info.width>(full.state())
                         .data<std::int8_t>();
  ASSERT_TRUE(cells) << message_of(cells);
  EXPECT_EQ(cells->front(), 7);
}

TEST(CellsTest, AFieldThatWasNotSentIsAnErrorThatNamesIt) {
  const Image message = image(2, 3);
  const Arrived sample(message, "data, height, width, step, is_bigendian");
  const auto selected_view = detail::view_of<Image, selected>(sample.state());
  EXPECT_EQ(message_of(selected_view.data<Rgb>()), "'encoding' was not sent in this sample");
  EXPECT_EQ(selected_view.data<Rgb>().error().code, Errc::unavailable);
  // A sample in shared memory also has fields that are not declared. The error for using such a field is the
  // same as in a sample from another host.
  const Arrived full(message);
  const FieldMask declared(Image::Field::data);
  const DynamicView view(full.state(), type_support<Image>().type(), declared);
  EXPECT_EQ(message_of(cells_of<Rgb>(view, "data")), "'height' was not sent in this sample");
}

TEST(CellsTest, OfADeclaredPartNeedNoOtherFieldToBeDeclared) {
  const Arrived part(image(20, 30), "data[rows 4:20:5]");
  const auto pixels = detail::view_of<Image, Image::Field::data.rows(4, 20, 5)>(part.state()).data<Rgb>();
  ASSERT_TRUE(pixels) << message_of(pixels);
  EXPECT_EQ(pixels->rows(), 4U);
}

template <class T>
class RecordedCells : public ::testing::Test {
 protected:
  explicit RecordedCells(const T& message, const char* selection = "*") : sample_(message, selection) {
    state_ = sample_.state();
    state_.log = &log_;
  }
  auto view() const { return detail::view_of<T, recorded>(state_); }
  std::string read() const {
    const std::uint64_t word = words_[0].found | words_[0].missed;
    return type_support<T>().format_mask(FieldMask::from_words(type_support<T>().leaves(), {&word, 1}));
  }

  const Arrived<T> sample_;
  detail::SampleState state_;
  std::vector<detail::AccessWord> words_ = std::vector<detail::AccessWord>(1);
  detail::AccessLog log_{words_, nullptr};
};

struct RecordedPixels : RecordedCells<Image> {
  RecordedPixels() : RecordedCells(image(2, 3)) {}
};

TEST_F(RecordedPixels, AreReadWithAllThatTheirLayoutNeedsAndNothingElse) {
  EXPECT_TRUE(view().data<Rgb>());
  EXPECT_EQ(read(), "height, width, encoding, is_bigendian, step, data");
}

struct MissedPixels : RecordedCells<Image> {
  MissedPixels() : RecordedCells(image(2, 3), "data") {}
};

TEST_F(MissedPixels, AreAskedForWithAllThatTheyNeedAtOnce) {
  EXPECT_EQ(message_of(view().data<Rgb>()), "'height' was not sent in this sample");
  EXPECT_EQ(read(), "height, width, encoding, is_bigendian, step, data");
}

struct RecordedBeams : RecordedCells<LaserScan> {
  RecordedBeams() : RecordedCells(LaserScan{}) {}
};

TEST_F(RecordedBeams, AreReadAlone) {
  EXPECT_TRUE(view().ranges<float>());
  EXPECT_EQ(read(), "ranges");
}

}  // namespace
}  // namespace sft
