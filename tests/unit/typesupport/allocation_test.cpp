// These tests check operations that must not allocate memory.
#include <gtest/gtest.h>

#include <ranges>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/view.h"
#include "sft/type_support.h"
#include "tests/support/encoded.h"
#include "tests/support/thread_allocations.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

template <class Work>
std::uint64_t allocations_of(Work work) {
  const std::uint64_t before = test::thread_allocations();
  work();
  return test::thread_allocations() - before;
}

PointCloud2 cloud_with_fields(std::size_t count) {
  PointCloud2 cloud;
  cloud.fields.resize(count);
  for (std::size_t i = 0; i < count; ++i) cloud.fields[i].name.assign(i % 5, 'x');
  return cloud;
}

TEST(MaskAllocations, UpTo64LeavesNothingIsAllocated) {
  const FieldMask full = FieldMask::full(64);
  FieldMask some = FieldMask(64);
  some.insert(3);
  std::size_t sum = 0;
  EXPECT_EQ(allocations_of([&] {
              const FieldMask result = ((~some | some) & full) - (some ^ full);
              for (const std::size_t leaf : result) sum += leaf;
              sum += result == some && full.contains(some) && some.intersects(full) && !some.empty() ? 1 : 0;
              sum += FieldMask(F::header | F::data).contains(F::header) ? 1 : 0;
              sum += static_cast<std::size_t>(some.hash());
            }),
            0U);
  EXPECT_EQ(sum, 3U + 1 + 1 + 8);
}

class ElementAllocations : public ::testing::Test {
 protected:
  ElementAllocations() { state.elements = &index; }
  auto fields() const { return view_of<PointCloud2, all<PointCloud2>>(state).fields(); }
  std::size_t jumps() const {
    return fields()[90].name().size() + fields()[7].name().size() + fields().back().name().size();
  }

  test::Encoded encoded{cloud_with_fields(100)};
  SampleState state = encoded.state();
  ElementIndex index;
};

TEST_F(ElementAllocations, GoingForwardAllocatesNothing) {
  std::size_t sum = 0;
  EXPECT_EQ(allocations_of([&] {
              for (const auto field : fields()) sum += field.name().size();
              for (const auto field : fields() | std::views::drop(3) | std::views::take(5))
                sum += field.name().size();
              sum += static_cast<std::size_t>(
                  std::ranges::count_if(fields(), [](const auto& f) { return f.name().empty(); }));
            }),
            0U);
  EXPECT_EQ(sum, 200U + 3 + 4 + 0 + 1 + 2 + 20);
}

TEST_F(ElementAllocations, TheFirstJumpOfAllAllocatesAndThoseInLaterSamplesDoNot) {
  EXPECT_GT(allocations_of([&] { jumps(); }), 0U);
  EXPECT_EQ(allocations_of([&] { jumps(); }), 0U);
  index.clear();
  EXPECT_EQ(allocations_of([&] { jumps(); }), 0U);
}

TEST_F(ElementAllocations, NoMoreThanALimitIsKeptForLaterSamples) {
  const test::Encoded large{cloud_with_fields(ElementIndex::kept_bytes_max / sizeof(std::uint32_t))};
  const auto last = [&](const test::Encoded& encoded_cloud) {
    SampleState s = encoded_cloud.state();
    s.elements = &index;
    return view_of<PointCloud2, all<PointCloud2>>(s).fields().back().count();
  };
  last(large);
  index.clear();
  EXPECT_GT(allocations_of([&] { last(large); }), 0U);
}

TEST_F(ElementAllocations, JumpsBetweenElementsOfOneStrideAllocateNothing) {
  const test::Encoded offsets(cloud_with_fields(100), F::fields.each.offset | F::fields.each.datatype);
  SampleState s = offsets.state();
  s.elements = &index;
  constexpr Req<PointCloud2> requirement = F::fields.each.offset | F::fields.each.datatype;
  EXPECT_EQ(allocations_of([&] {
              const auto range = view_of<PointCloud2, requirement>(s).fields();
              EXPECT_EQ(range[99].offset() + range[50].datatype(), 0U);
            }),
            0U);
}

}  // namespace
}  // namespace sft
