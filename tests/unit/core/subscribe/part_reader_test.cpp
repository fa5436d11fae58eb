// Parts that stay in the whole sample are read as if they had been copied from it.
#include "core/subscribe/remote_copy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "sft/cells.h"
#include "sft/detail/view.h"
#include "sft/dynamic_view.h"
#include "tests/support/encoded.h"
#include "tests/support/random_layouts.h"
#include "tests/support/random_value.h"

namespace sft::core {
namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;

class PartReaderTest : public sft::test::RandomTest {
 protected:
  using Range = Selection::Range;
  using Part = Selection::Part;

  static int rounds() { return static_cast<int>(sft::test::test_rounds(500)); }

  template <class T>
  SampleHandle sample(const T& message) {
    const TypeSupport& type = type_support<T>();
    const detail::SampleLayout layout(type.index_slots());
    const sft::test::Encoded encoded(type.type(), &message, type.full());
    SampleHandle buffer = pool->take(layout.bytes(encoded.bytes().size()));
    std::ranges::copy(encoded.bytes(), buffer->data + layout.body_offset);
    std::copy_n(encoded.state().index, type.index_slots(), buffer->index());
    buffer->header().body_bytes = static_cast<std::uint32_t>(encoded.bytes().size());
    buffer->mask = type.full();
    buffer->parts = 0;
    return buffer;
  }
  template <class T>
  static std::shared_ptr<const Asked> asked(const Selection& selection) {
    return make_asked(type_support<T>(), type_support<T>().closed(selection), true, nullptr);
  }
  template <class T>
  static std::shared_ptr<const Asked> asked(const char* text) {
    return asked<T>(type_support<T>().parse_selection(text).value());
  }
  template <class T>
  std::shared_ptr<RemoteCopy> copier() const {
    return RemoteCopy::make(type_support<T>(), pool);
  }
  /// Returns a selection of a part of the given field and of random other fields.
  template <class T>
  Selection selection(std::string_view field, std::uint32_t rows, std::uint32_t columns, bool has_channels) {
    const TypeSupport& type = type_support<T>();
    Part part{.leaf = static_cast<std::uint32_t>(*type.find(field).value().begin()),
              .rows = rows == 1 ? Range{} : layouts.range(rows),
              .columns = layouts.range(columns)};
    if (has_channels && !layouts.one_in(3)) part.channels = layouts.channels();
    return Selection::make(values.mask(type.leaves()), {part}, {}).value();
  }

  static std::vector<std::byte> body(const detail::SampleState& state) {
    return {state.body, state.body + state.body_bytes};
  }
  /// Expects that getters return the same for the part in place and for a copy, and that both have the same
  /// encoding.
  template <class T>
  void expect_same(const T& message, const Selection& wanted) {
    SCOPED_TRACE(type_support<T>().format_selection(wanted));
    const TypeSupport& type = type_support<T>();
    const auto copies = copier<T>();
    const std::shared_ptr<const Asked> asked = this->asked<T>(wanted);
    const SampleHandle copy = copies->of(sample(message), *asked->plan);
    RemoteCopy::InPlace around = copies->in_place(sample(message), asked);
    ASSERT_EQ(static_cast<bool>(around.sample), static_cast<bool>(copy));
    if (!copy) return;
    EXPECT_EQ(around.sample->mask, copy->mask);
    EXPECT_EQ(around.sample->parts, copy->parts);
    detail::SampleState state = state_of(*around.sample, type.index_slots());
    const detail::SampleState expected = state_of(*copy, type.index_slots());
    if (around.parts == nullptr) {
      EXPECT_EQ(body(state), body(expected));
      return;
    }
    state.parts = around.parts;
    expect_same_getters<T>(state, expected);
    EXPECT_FALSE(state.is_malformed());
    EXPECT_EQ(body(around.parts->put_together()), body(expected));
    PartReader::end(around.parts);
  }
  template <class T>
  void expect_same_getters(const detail::SampleState& state, const detail::SampleState& expected);

  sft::test::RandomLayouts layouts{random};
  sft::test::RandomValues values{random};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(64 << 20);
};

template <class T>
auto view(const detail::SampleState& state) {
  return detail::view_of<T, all<T>>(state);
}
template <class Span>
std::vector<std::byte> bytes(const Span& span) {
  const auto raw = std::as_bytes(span);
  return {raw.begin(), raw.end()};
}

/// Returns the bytes of all cells. Expects that all ways to iterate return the same cells.
template <class Cell>
std::vector<std::byte> bytes_of_cells(const Cells<Cell>& cells) {
  std::vector<Cell> each(cells.begin(), cells.end());
  EXPECT_EQ(each.size(), cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::array<Cell, 3> same{each[i], cells[i], cells.at(i / cells.columns(), i % cells.columns())};
    EXPECT_TRUE(std::memcmp(&same[0], &same[1], sizeof(Cell)) == 0 &&
                std::memcmp(&same[0], &same[2], sizeof(Cell)) == 0)
        << "cell " << i;
  }
  return bytes(std::span<const Cell>(each));
}

template <class Cell>
void expect_same_cells(const Result<Cells<Cell>>& seen, const Result<Cells<Cell>>& right) {
  ASSERT_EQ(seen.has_value(), right.has_value()) << (seen ? "" : seen.error().message);
  if (!right) {
    EXPECT_EQ(seen.error().message, right.error().message);
    return;
  }
  EXPECT_EQ(seen->rows(), right->rows());
  EXPECT_EQ(seen->columns(), right->columns());
  EXPECT_EQ(bytes_of_cells(*seen), bytes_of_cells(*right));
  for (std::size_t row = 0; row < seen->rows(); ++row) {
    const auto span = seen->row(row), same = right->row(row);
    if (span && same) {
      EXPECT_EQ(bytes(*span), bytes(*same)) << "row " << row;
    }
  }
}

/// Expects that the cells in place equal those of the copy, with and without the compiled type. Returns the
/// cells that were read without the compiled type.
template <class Cell, class T>
Result<Cells<Cell>> expect_same_data(const detail::SampleState& state, const detail::SampleState& expected) {
  const Result<Cells<Cell>> right = view<T>(expected).template data<Cell>();
  const StructType& type = type_support<T>().type();
  expect_same_cells(view<T>(state).template data<Cell>(), right);
  expect_same_cells(cells_of<Cell>(DynamicView(state, type), "data"), right);
  expect_same_cells(cells_of<Cell>(DynamicView(expected, type), "data"), right);
  return right;
}

template <>
void PartReaderTest::expect_same_getters<PointCloud2>(const detail::SampleState& state,
                                                      const detail::SampleState& expected) {
  const auto seen = view<PointCloud2>(state), right = view<PointCloud2>(expected);
  EXPECT_EQ(seen.height(), right.height());
  EXPECT_EQ(seen.width(), right.width());
  EXPECT_EQ(seen.point_step(), right.point_step());
  EXPECT_EQ(seen.row_step(), right.row_step());
  ASSERT_EQ(seen.fields().size(), right.fields().size());
  for (std::size_t i = 0; i < right.fields().size(); ++i) {
    const std::string name(right.fields()[i].name());
    EXPECT_EQ(seen.fields()[i].name(), name);
    EXPECT_EQ(seen.fields()[i].offset(), right.fields()[i].offset());
    const auto points = seen.points<float>(name), in_copy = right.points<float>(name);
    ASSERT_EQ(points.has_value(), in_copy.has_value()) << name;
    if (!points) {
      EXPECT_EQ(points.error().message, in_copy.error().message);
      continue;
    }
    ASSERT_EQ(points->size(), in_copy->size()) << name;
    EXPECT_EQ(points->rows(), in_copy->rows());
    std::size_t at = 0;
    for (const auto& [value] : *points) {
      const float same = std::get<0>((*in_copy)[at]);
      EXPECT_EQ(std::memcmp(&value, &same, sizeof value), 0) << name << " of point " << at;
      const float direct = std::get<0>((*points)[at++]);
      EXPECT_EQ(std::memcmp(&value, &direct, sizeof value), 0);
    }
    EXPECT_EQ(at, in_copy->size());
  }
  EXPECT_EQ(bytes(seen.data()), bytes(right.data()));
}

TEST_F(PartReaderTest, PartsOfCloudsAreThoseOfACopy) {
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const PointCloud2 cloud = layouts.cloud();
    expect_same(cloud, selection<PointCloud2>("data", cloud.height, cloud.width, true));
  }
}

template <>
void PartReaderTest::expect_same_getters<Image>(const detail::SampleState& state,
                                                const detail::SampleState& expected) {
  const auto seen = view<Image>(state), right = view<Image>(expected);
  EXPECT_EQ(seen.height(), right.height());
  EXPECT_EQ(seen.step(), right.step());
  EXPECT_EQ(seen.encoding(), right.encoding());
  const auto greys = expect_same_data<std::uint8_t, Image>(state, expected);
  const auto colours = expect_same_data<std::array<std::uint8_t, 3>, Image>(state, expected);
  expect_same_data<std::uint16_t, Image>(state, expected);
  expect_same_data<std::array<std::uint16_t, 4>, Image>(state, expected);
  expect_same_data<float, Image>(state, expected);
  const bool is_packed = std::uint64_t{right.step()} * right.height() == right.data().size();
  if (is_packed && greys && right.step() == right.width()) {
    EXPECT_EQ(bytes_of_cells(*greys), bytes(right.data()));
  }
  if (is_packed && colours && right.step() == 3 * right.width()) {
    EXPECT_EQ(bytes_of_cells(*colours), bytes(right.data()));
  }
  EXPECT_EQ(bytes(seen.data()), bytes(right.data()));
}

TEST_F(PartReaderTest, PartsOfImagesAreThoseOfACopyAlsoWhereAnImageStaysWhole) {
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const Image image = layouts.image();
    expect_same(image, selection<Image>("data", image.height, image.width, false));
  }
}

template <>
void PartReaderTest::expect_same_getters<OccupancyGrid>(const detail::SampleState& state,
                                                        const detail::SampleState& expected) {
  const auto seen = view<OccupancyGrid>(state), right = view<OccupancyGrid>(expected);
  EXPECT_EQ(seen.info().width(), right.info().width());
  EXPECT_EQ(seen.info().origin().position().x(), right.info().origin().position().x());
  const auto cells = expect_same_data<std::int8_t, OccupancyGrid>(state, expected);
  if (cells && cells->size() == right.data().size()) {
    EXPECT_EQ(bytes_of_cells(*cells), bytes(right.data()));
  }
  EXPECT_EQ(bytes(seen.data()), bytes(right.data()));
}

TEST_F(PartReaderTest, PartsOfGridsAreThoseOfACopy) {
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const OccupancyGrid grid = layouts.grid();
    expect_same(grid, selection<OccupancyGrid>("data", grid.info.height, grid.info.width, false));
  }
}

template <>
void PartReaderTest::expect_same_getters<LaserScan>(const detail::SampleState& state,
                                                    const detail::SampleState& expected) {
  const auto seen = view<LaserScan>(state), right = view<LaserScan>(expected);
  EXPECT_EQ(seen.angle_increment(), right.angle_increment());
  const auto beams = right.ranges<float>();
  expect_same_cells(seen.ranges<float>(), beams);
  expect_same_cells(cells_of<float>(DynamicView(state, type_support<LaserScan>().type()), "ranges"), beams);
  ASSERT_TRUE(beams);
  EXPECT_EQ(bytes_of_cells(*beams), bytes(right.ranges()));
  EXPECT_EQ(bytes(seen.ranges()), bytes(right.ranges()));
  if (!expected.mask->contains(FieldMask(LaserScan::Field::intensities))) return;
  EXPECT_EQ(bytes(seen.intensities()), bytes(right.intensities()));
}

TEST_F(PartReaderTest, PartsOfScansAreThoseOfACopy) {
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const LaserScan scan = layouts.scan();
    expect_same(scan,
                selection<LaserScan>("ranges", 1, static_cast<std::uint32_t>(scan.ranges.size()), false));
  }
}

/// A sample with its part in place, during the lifetime of this object.
template <class T>
struct Reduced {
  Reduced(RemoteCopy& copies, const SampleHandle& sample, std::shared_ptr<const Asked> asked)
      : around(copies.in_place(sample, std::move(asked))),
        state(state_of(*around.sample, type_support<T>().index_slots())) {
    state.parts = around.parts;
  }
  ~Reduced() {
    if (around.parts != nullptr) PartReader::end(around.parts);
  }
  Reduced(const Reduced&) = delete;
  Reduced& operator=(const Reduced&) = delete;

  RemoteCopy::InPlace around;
  detail::SampleState state;
};

LaserScan numbered_scan() {
  LaserScan scan;
  for (int i = 0; i < 1000; ++i) scan.ranges.push_back(static_cast<float>(i));
  return scan;
}

TEST_F(PartReaderTest, APartThatLiesTogetherIsReadInTheWholeSample) {
  const auto copies = copier<LaserScan>();
  const SampleHandle whole = sample(numbered_scan());
  const Reduced<LaserScan> some(*copies, whole, asked<LaserScan>("ranges[100:200]"));
  const auto ranges = view<LaserScan>(some.state).ranges();
  ASSERT_EQ(ranges.size(), 100U);
  EXPECT_EQ(ranges[0], 100.F);
  const auto* const first = reinterpret_cast<const std::byte*>(ranges.data());
  EXPECT_TRUE(first > whole->data && first < whole->data + whole->capacity);
}

TEST_F(PartReaderTest, TheWholeSampleIsHeldAndReaderAndMemoryAreUsedAgain) {
  const auto copies = copier<LaserScan>();
  const SampleHandle whole = sample(numbered_scan());
  const PartReader* first = nullptr;
  for (int i = 0; i < 3; ++i) {
    const Reduced<LaserScan> some(*copies, whole, asked<LaserScan>("ranges[::4]"));
    EXPECT_FALSE(whole->references.load() == 1);
    EXPECT_EQ(view<LaserScan>(some.state).ranges().size(), 250U);
    if (first == nullptr) first = some.around.parts;
    EXPECT_EQ(some.around.parts, first);
  }
  EXPECT_TRUE(whole.is_only());
}

TEST_F(PartReaderTest, ASampleOutlivesWhatMadeIt) {
  auto copies = copier<LaserScan>();
  const Reduced<LaserScan> some(*copies, sample(numbered_scan()), asked<LaserScan>("ranges[::4]"));
  copies.reset();
  EXPECT_EQ(view<LaserScan>(some.state).ranges()[3], 12.F);
}

/// A sample with every second beam of a scan, and another field. There is not enough memory for a copy of
/// them.
class WithoutMemory : public PartReaderTest {
 protected:
  static LaserScan long_scan() {
    LaserScan scan = numbered_scan();
    scan.scan_time = 0.5F;
    scan.ranges.resize(100'000);
    return scan;
  }

  const std::shared_ptr<RemoteCopy> copies =
      RemoteCopy::make(type_support<LaserScan>(), BufferPool::make(std::size_t{1} << 14));
  const SampleHandle whole = sample(long_scan());
  const Reduced<LaserScan> some{*copies, whole, asked<LaserScan>("ranges[::2], scan_time")};
  const DynamicView dynamic{some.state, type_support<LaserScan>().type()};
};

TEST_F(WithoutMemory, CellsAndOtherFieldsAreReadSinceNothingIsCopied) {
  for (const auto& beams :
       {view<LaserScan>(some.state).ranges<float>(), cells_of<float>(dynamic, "ranges")}) {
    ASSERT_TRUE(beams) << beams.error().message;
    EXPECT_EQ(beams->size(), 50'000U);
    EXPECT_EQ((*beams)[499], 998.F);
  }
  EXPECT_EQ(dynamic["scan_time"].as<float>().value(), 0.5F);
  EXPECT_FALSE(some.state.is_malformed());
}

TEST_F(WithoutMemory, ADynamicViewGoesThroughItsMembersSinceNothingIsCopied) {
  std::vector<std::string_view> present;
  for (const DynamicView& member : dynamic.members()) {
    if (!member.is_absent()) present.push_back(member.name());
  }
  EXPECT_TRUE(std::ranges::count(present, "ranges") == 1 && std::ranges::count(present, "scan_time") == 1);
  EXPECT_FALSE(some.state.is_malformed());
}

TEST_F(WithoutMemory, APartThatLiesTogetherIsASpanOfTheSampleAlsoByItsName) {
  const Reduced<LaserScan> first{*copies, whole, asked<LaserScan>("ranges[100:50000]")};
  const DynamicView scan(first.state, type_support<LaserScan>().type());
  EXPECT_EQ(scan["ranges"].size().value(), 49'900U);
  const auto span = scan["ranges"].as<std::span<const float>>();
  ASSERT_TRUE(span) << span.error().message;
  const auto* const at = reinterpret_cast<const std::byte*>(span->data());
  EXPECT_TRUE(at > whole->data && at < whole->data + whole->capacity);
  EXPECT_EQ((*span)[1], 101.F);
}

TEST_F(WithoutMemory, TheElementsOfADynamicViewAreAnErrorAndTheSampleMalformed) {
  EXPECT_EQ(dynamic["ranges"][0].as<float>().error().code, Errc::malformed);
  std::size_t errors = 0;
  for (const DynamicView& beam : dynamic["ranges"].elements()) errors += beam.error() != nullptr ? 1 : 0;
  EXPECT_EQ(errors, 1U);
  EXPECT_EQ(dynamic["ranges"].size().error().code, Errc::malformed);
  EXPECT_TRUE(some.state.is_malformed());
}

TEST_F(WithoutMemory, ThePartIsEmptyAndTheSampleMalformed) {
  ASSERT_TRUE(some.around.parts);
  EXPECT_TRUE(view<LaserScan>(some.state).ranges().empty());
  EXPECT_TRUE(some.state.is_malformed());
  EXPECT_EQ(some.around.parts->put_together().body, nullptr);
}

TEST_F(PartReaderTest, ADynamicViewReadsTheElementsOfAPartInACopy) {
  const auto copies = copier<LaserScan>();
  const Reduced<LaserScan> some(*copies, sample(numbered_scan()), asked<LaserScan>("ranges[100:200:4]"));
  const DynamicView scan(some.state, type_support<LaserScan>().type());
  EXPECT_EQ(scan["ranges"].size().value(), 25U);
  EXPECT_EQ(scan["ranges"][24].as<float>().value(), 196.F);
  EXPECT_EQ(scan.find("ranges").as<std::span<const float>>().value()[1], 104.F);
  std::size_t count = 0;
  for (const DynamicView& beam : scan["ranges"].elements())
    EXPECT_EQ(beam.as<float>().value(), 100.F + 4 * static_cast<float>(count++));
  EXPECT_EQ(count, 25U);
}

TEST_F(PartReaderTest, ThreadsThatReadOneSampleShareOneCopy) {
  const auto copies = copier<LaserScan>();
  const Reduced<LaserScan> some(*copies, sample(numbered_scan()), asked<LaserScan>("ranges[::4]"));
  std::vector<const float*> seen(4);
  std::vector<const std::byte*> together(seen.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    threads.emplace_back([&, i] {
      seen[i] = view<LaserScan>(some.state).ranges().data();
      together[i] = some.around.parts->put_together().body;
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const float* one : seen) EXPECT_EQ(one, seen[0]);
  for (const std::byte* one : together) EXPECT_EQ(one, together[0]);
  EXPECT_NE(together[0], nullptr);
}

TEST_F(PartReaderTest, AHeaderThatChangesAfterwardsLeadsNowhereElse) {
  const auto copies = copier<PointCloud2>();
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const PointCloud2 cloud = layouts.cloud();
    const SampleHandle whole = sample(cloud);
    const Reduced<PointCloud2> some(
        *copies, whole, asked<PointCloud2>(selection<PointCloud2>("data", cloud.height, cloud.width, true)));
    const detail::SampleLayout layout(type_support<PointCloud2>().index_slots());
    for (std::byte* at = whole->data + layout.body_offset; at < whole->data + layout.body_offset + 64; ++at)
      *at = static_cast<std::byte>(random());
    if (some.around.parts == nullptr) continue;
    const auto seen = view<PointCloud2>(some.state);
    // Makes a sanitizer see the bytes that are read.
    for (const auto byte : seen.data()) asm volatile("" : : "r"(byte));
    if (const auto points = view<PointCloud2>(some.state).points<float>("x")) {
      for (const auto& [x] : *points) asm volatile("" : : "m"(x));
    }
  }
}

TEST_F(PartReaderTest, CellsStayWithinTheSampleAlsoIfItsHeaderChangesAfterwards) {
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    const Image image = layouts.image();
    const auto copies = copier<Image>();
    const SampleHandle whole = sample(image);
    const Reduced<Image> some(*copies, whole,
                              asked<Image>(selection<Image>("data", image.height, image.width, false)));
    const auto pixels = view<Image>(some.state).data<std::uint16_t>();
    const detail::SampleLayout layout(type_support<Image>().index_slots());
    for (std::byte* at = whole->data + layout.body_offset; at < whole->data + layout.body_offset + 64; ++at)
      *at = static_cast<std::byte>(random());
    for (const auto& cells : {pixels, view<Image>(some.state).data<std::uint16_t>()}) {
      if (!cells) continue;
      for (const std::uint16_t pixel : *cells)
        asm volatile("" : : "r"(pixel));  // makes a sanitizer notice the read
      for (std::size_t row = 0; row < cells->rows(); ++row) {
        const auto span = cells->row(row);
        if (span && !span->empty()) asm volatile("" : : "r"(span->back()));
      }
    }
  }
}

}  // namespace
}  // namespace sft::core
