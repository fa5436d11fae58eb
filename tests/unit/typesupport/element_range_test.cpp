// Ranges of structs and strings. Random access finds the same elements as a walk.
#include "sft/detail/element_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cstring>
#include <proof.hpp>
#include <ranges>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <thread>
#include <vector>

#include "sft/detail/view.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using test::Encoded;

template <class T, Req<T> R>
using FieldsOfView = decltype(std::declval<ViewOf<T, R>>().fields());
template <class T>
using Range = FieldsOfView<T, Req<T>(all<T>)>;

static_assert(std::ranges::random_access_range<Range<PointCloud2>>);
static_assert(std::ranges::sized_range<Range<PointCloud2>>);
static_assert(std::ranges::common_range<Range<PointCloud2>>);
static_assert(std::ranges::borrowed_range<Range<PointCloud2>>);
static_assert(std::ranges::view<Range<PointCloud2>>);
static_assert(std::random_access_iterator<StringRange::iterator>);
static_assert(std::ranges::view<StringRange> && std::ranges::borrowed_range<StringRange>);

/// A sample, with or without memory for the offsets of elements. Subscribers have such memory.
class Sample {
 public:
  template <class T>
  explicit Sample(const T& message, const Mask<T>& mask = all<T>, bool remembers = true)
      : encoded_(message, mask), state_(encoded_.state()) {
    if (remembers) state_.elements = &elements_;
  }
  template <class T>
  auto view() const {
    return view_of<T, all<T>>(state_);
  }
  SampleState& state() { return state_; }
  Encoded& encoded() { return encoded_; }

 private:
  Encoded encoded_;
  ElementIndex elements_;
  SampleState state_;
};

/// Returns a cloud with fields named "field 0000", "field 0001" and so on. Each name ends with 0 to 6
/// further characters.
PointCloud2 cloud_with_fields(std::size_t count) {
  PointCloud2 cloud;
  cloud.fields.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    cloud.fields[i].name = "field " + std::string(4 - number.size(), '0') + number + std::string(i % 7, '+');
    cloud.fields[i].offset = static_cast<std::uint32_t>(i * 4);
    cloud.fields[i].count = 1;
  }
  return cloud;
}

class ElementRangeTest : public ::testing::TestWithParam<bool> {
 protected:
  Sample sample{cloud_with_fields(100), all<PointCloud2>, GetParam()};
  Range<PointCloud2> fields = sample.view<PointCloud2>().fields();
};

TEST_P(ElementRangeTest, ElementsAreReachedByTheirPosition) {
  EXPECT_EQ(fields[42].offset(), 168U);
  EXPECT_EQ((fields.begin() + 7)->offset(), 28U);
  EXPECT_EQ(fields.front().offset(), 0U);
  EXPECT_EQ(fields.back().offset(), 396U);
  EXPECT_EQ((*(fields.end() - 2)).offset(), 392U);
  EXPECT_EQ(fields.end() - fields.begin(), 100);
  EXPECT_EQ(std::ranges::size(fields), 100U);
  EXPECT_LT(fields.begin(), fields.begin() + 1);
  EXPECT_EQ((5 + fields.begin())[-3].offset(), 8U);
}

TEST_P(ElementRangeTest, AlgorithmsOfRangesTakeThem) {
  const auto name = [](const auto& field) { return field.name(); };
  const auto found = std::ranges::lower_bound(fields, "field 0050", {}, name);
  EXPECT_EQ(found - fields.begin(), 50);
  EXPECT_TRUE(std::ranges::binary_search(fields, 396U, {}, [](const auto& field) { return field.offset(); }));
  EXPECT_TRUE(std::ranges::is_sorted(fields, {}, name));
  EXPECT_EQ(std::ranges::find_if(fields, [](const auto& f) { return f.offset() == 36; }) - fields.begin(), 9);
  EXPECT_EQ(std::ranges::max_element(fields, {}, name) - fields.begin(), 99);
}

TEST_P(ElementRangeTest, ViewsOfRangesTakeThem) {
  namespace views = std::views;
  const auto offset = views::transform([](const auto& field) { return field.offset() / 4; });
  const auto numbers = [](auto&& range) {
    std::vector<std::uint32_t> result;
    for (const std::uint32_t number : range) result.push_back(number);
    return result;
  };
  using Numbers = std::vector<std::uint32_t>;
  EXPECT_EQ(numbers(fields | views::take(3) | offset), (Numbers{0, 1, 2}));
  EXPECT_EQ(numbers(fields | views::drop(97) | offset), (Numbers{97, 98, 99}));
  EXPECT_EQ(numbers(fields | views::reverse | views::take(3) | offset), (Numbers{99, 98, 97}));
  EXPECT_EQ(numbers(fields | views::drop(20) | views::take(2) | views::reverse | offset), (Numbers{21, 20}));
}

TEST_P(ElementRangeTest, IteratorsOutliveTheRange) {
  const auto at = std::ranges::find_if(sample.view<PointCloud2>().fields(),
                                       [](const auto& field) { return field.offset() == 200; });
  EXPECT_EQ((at + 1)->offset(), 204U);
  EXPECT_EQ((at - 40)->offset(), 40U);
}

TEST_P(ElementRangeTest, IteratorsGoOnFromWhereTheyJumpedTo) {
  auto at = fields.begin();
  at += 50;
  ++at;
  EXPECT_EQ(at->offset(), 204U);
  --at;
  EXPECT_EQ((*at--).offset(), 200U);
  EXPECT_EQ((*at++).offset(), 196U);
  EXPECT_EQ(at - fields.begin(), 50);
}

TEST_P(ElementRangeTest, OfStringsToo) {
  proof::Bounded bounded;
  bounded.tags = {"a", "", "abc", "abcdefgh"};
  const Sample strings(bounded, all<proof::Bounded>, GetParam());
  const StringRange tags = strings.view<proof::Bounded>().tags();
  EXPECT_EQ(tags[3], "abcdefgh");
  EXPECT_EQ(tags.back().size(), 8U);
  EXPECT_TRUE(std::ranges::equal(tags | std::views::reverse, std::vector{"abcdefgh", "abc", "", "a"}));
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutMemory, ElementRangeTest, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Remembering" : "Walking"; });

TEST(NestedAndRecordedRanges, ASequenceInAnElementIsARangeOfItsOwn) {
  proof::Scene scene;
  scene.tracks.resize(20);
  for (std::size_t t = 0; t < 20; ++t) {
    scene.tracks[t].pairs.resize(30);
    for (std::size_t p = 0; p < 30; ++p) scene.tracks[t].pairs[p].b = static_cast<double>(100 * t + p);
    for (std::size_t s = 0; s < 25; ++s) scene.tracks[t].tags.push_back(std::to_string(100 * t + s));
  }
  const Sample sample(scene);
  const auto tracks = sample.view<proof::Scene>().tracks();
  for (const std::size_t t : {19, 3, 11, 0}) {
    EXPECT_EQ(tracks[t].pairs()[29].b(), static_cast<double>(100 * t + 29));
    EXPECT_EQ(tracks[t].pairs()[1].b(), static_cast<double>(100 * t + 1));
    EXPECT_EQ(tracks[t].tags()[24], std::to_string(100 * t + 24));
    EXPECT_EQ(tracks[t].tags()[13], std::to_string(100 * t + 13));
  }
}

TEST(NestedAndRecordedRanges, OfRecordedSamplesOutlivesItsOptional) {
  const Encoded encoded(cloud_with_fields(30));
  const auto view = view_of<PointCloud2, recorded>(encoded.state());
  std::uint32_t sum = 0;
  for (const auto field : *view.fields()) sum += field.offset().value();
  EXPECT_EQ(sum, 30 * 29 / 2 * 4U);
  EXPECT_EQ((*view.fields())[20].offset(), 80U);
}

/// Compares each position that element_begin() returns, in any order, with the position that a walk finds.
class ElementBeginTest : public test::RandomTest, public ::testing::WithParamInterface<test::MessageType> {
 protected:
  void check_collections(const SampleState& s, const StructType& type, std::size_t leaf,
                         std::uint64_t offset) {
    for (const Member& m : type.members) {
      const std::size_t leaves = leaf_count(m);
      if (s.mask->any_of(leaf, leaves)) check_member(s, m, leaf, offset);
      offset = skip(s, m, leaf, offset);
      leaf += leaves;
    }
  }

 private:
  void check_member(const SampleState& s, const Member& m, std::size_t leaf, std::uint64_t offset) {
    if (m.kind == Kind::structure && m.shape == Shape::single)
      return check_collections(s, *m.type, leaf, offset);
    if (is_primitive(m.kind) || m.shape == Shape::single) return;
    const bool is_sequence = m.shape == Shape::sequence;
    const Extent extent =
        is_sequence ? checked_length(s, offset) : Extent{static_cast<std::uint32_t>(offset), m.count};
    check(s, {m.type, leaf + (is_sequence && m.type != nullptr ? 1 : 0), extent.first, extent.count});
  }

  void check(const SampleState& s, const Elements& elements) {
    std::vector<std::uint32_t> begins;
    for (std::uint32_t at = elements.first; begins.size() < elements.count;
         at = next_element(s, elements, at))
      begins.push_back(at);
    if (begins.empty()) return;
    KnownElement known{0, elements.first};
    for (int jump = 0; jump < 20; ++jump) {
      const auto to = static_cast<std::uint32_t>(random() % begins.size());
      ASSERT_EQ(element_begin(s, elements, to, known), begins[to]) << to << " of " << begins.size();
      if (random() % 2 == 0) known = {to, begins[to]};
    }
    if (elements.type == nullptr) return;
    for (const std::uint32_t at : begins) check_collections(s, *elements.type, elements.leaf, at);
  }
};

TEST_P(ElementBeginTest, IsWhereWalkingEndsUpForAllValuesAndMasks) {
  test::RandomValues values(random);
  const TypeSupport& support = *GetParam().support;
  ElementIndex index;
  for (int round = 0; round < 300 && !HasFatalFailure(); ++round) {
    test::OwnedValue value = GetParam().make();
    values.fill(value.type(), value.get());
    const FieldMask mask = support.closed(values.mask(support.leaves()));
    SCOPED_TRACE(support.format_mask(mask));
    const Encoded encoded(value.type(), value.get(), mask);
    SampleState state = encoded.state();
    state.elements = round % 3 == 0 ? nullptr : &index;
    check_collections(state, support.type(), 0, 0);
    index.clear();
  }
}

INSTANTIATE_TEST_SUITE_P(Types, ElementBeginTest, ::testing::ValuesIn(test::all_types()),
                         [](const auto& test) { return test.param.short_name(); });

void put_u32(Sample& sample, std::size_t slot, std::uint32_t value) {
  std::memcpy(sample.encoded().body() + sample.state().index[slot], &value, sizeof value);
}

constexpr std::size_t fields_slot = 5;

TEST(HostileElements, ALengthThatTheBytesCannotHoldReadsAsEmpty) {
  for (const std::uint32_t length : {0xFFFFFFFFU, 0x80000000U, 100'000U}) {
    Sample sample(cloud_with_fields(10));
    put_u32(sample, fields_slot, length);
    EXPECT_TRUE(sample.view<PointCloud2>().fields().empty());
    EXPECT_TRUE(sample.state().is_malformed());
  }
}

TEST(HostileElements, JumpsBehindTheLastOneThatIsThereGiveEmptyValues) {
  Sample sample(cloud_with_fields(10));
  put_u32(sample, fields_slot, 60);  // the length counts one field per byte, but there are fewer fields
  const auto fields = sample.view<PointCloud2>().fields();
  ASSERT_EQ(fields.size(), 60U);
  EXPECT_EQ(fields[9].offset(), 36U);
  EXPECT_FALSE(sample.state().is_malformed());
  EXPECT_EQ(fields[59].name(), "");
  EXPECT_EQ(fields[59].count(), 0U);
  EXPECT_TRUE(sample.state().is_malformed());
}

TEST(HostileElements, GoingForwardEndsBehindTheLastOneThatIsThere) {
  Sample sample(cloud_with_fields(10));
  put_u32(sample, fields_slot, 60);
  const auto fields = sample.view<PointCloud2>().fields();
  std::size_t steps = 0;
  for (auto field = fields.begin(); field != fields.end(); ++field) {
    EXPECT_FALSE(sample.state().is_malformed()) << steps;
    ++steps;
  }
  EXPECT_GE(steps, 10U);
  EXPECT_LT(steps, 60U);
  EXPECT_TRUE(sample.state().is_malformed());
}

TEST(HostileElements, BytesThatChangeAfterTheFirstJumpHarmNobody) {
  Sample sample(cloud_with_fields(100));
  const auto fields = sample.view<PointCloud2>().fields();
  EXPECT_EQ(fields[90].offset(), 360U);
  std::memset(sample.encoded().body(), 0xFF, sample.state().body_bytes);
  for (const auto position : {90, 0, 99, 50}) {
    EXPECT_EQ(fields[position].name(), "");
  }
  EXPECT_TRUE(sample.state().is_malformed());
}

TEST(HostileElements, OfElementsWithoutBytesAnyNumberMayBeWrittenButFewAreVisited) {
  Sample sample(cloud_with_fields(10), Mask<PointCloud2>(PointCloud2::Field::fields.size));
  put_u32(sample, fields_slot, 0xFFFFFFFF);
  constexpr Req<PointCloud2> size_only = PointCloud2::Field::fields.size;
  const auto fields = view_of<PointCloud2, size_only>(sample.state()).fields();
  EXPECT_EQ(fields.size(), 0xFFFFFFFFU);
  EXPECT_EQ(fields.end() - fields.begin(), std::ptrdiff_t{max_empty_elements});
}

TEST(ElementIndexTest, OfOneSampleHasNoMoreOffsetsThanItsBytesJustify) {
  const std::vector<std::uint64_t> zeros(1000);  // 2000 empty strings
  const FieldMask mask = FieldMask::full(1);
  ElementIndex index;
  const SampleState state{.body = reinterpret_cast<const std::byte*>(zeros.data()),
                          .body_bytes = 8000,
                          .mask = &mask,
                          .elements = &index};
  const auto strings = [](std::uint32_t first, std::uint32_t count) {
    return Elements{.first = first, .count = count};
  };
  EXPECT_NE(index.table(state, strings(0, 1000)), nullptr);
  EXPECT_NE(index.table(state, strings(4, 1000)), nullptr);
  EXPECT_EQ(index.table(state, strings(8, 1)), nullptr);
  EXPECT_EQ(element_begin(state, strings(8, 100), 50, {0, 8}), 208U) << "it is walked to";
  EXPECT_NE(index.table(state, strings(4, 1000)), nullptr) << "what is known stays known";
  index.clear();
  EXPECT_NE(index.table(state, strings(8, 1)), nullptr);
}

TEST(ElementIndexTest, SeveralThreadsReadOneSampleAtOnce) {
  const PointCloud2 cloud = cloud_with_fields(500);
  for (int round = 0; round < 20; ++round) {
    const Sample sample(cloud);
    std::vector<std::jthread> readers;
    std::atomic<int> wrong{0};
    for (int reader = 0; reader < 3; ++reader) {
      readers.emplace_back([&, reader] {
        const auto fields = sample.view<PointCloud2>().fields();
        for (std::size_t i = 0; i < 500; ++i) {
          const std::size_t at = (i * 7 + static_cast<std::size_t>(reader) * 100) % 500;
          if (fields[at].offset() != 4 * at) ++wrong;
        }
      });
    }
    readers.clear();
    EXPECT_EQ(wrong.load(), 0);
  }
}

// The table that is finished second is discarded, and does not reduce the memory for tables of other
// collections.
TEST(ElementIndexTest, ATableThatTwoThreadsBuildAtOnceCountsOnce) {
  constexpr std::uint32_t strings = 50'000;
  std::vector<std::uint32_t> body;  // empty strings: the length, a NUL and padding
  for (std::uint32_t i = 0; i < strings; ++i) body.insert(body.end(), {1, 0});
  const SampleState state{.body = reinterpret_cast<const std::byte*>(body.data()), .body_bytes = 8 * strings};
  ElementIndex index;
  for (int round = 0; round < 20; ++round) {
    std::barrier start(2);
    const auto build = [&] {
      start.arrive_and_wait();
      EXPECT_NE(index.table(state, {.first = 0, .count = strings}), nullptr);
    };
    std::thread other(build);
    build();
    other.join();
    ASSERT_NE(index.table(state, {.first = 8, .count = strings - 1}), nullptr) << "in round " << round;
    index.clear();
  }
}

}  // namespace
}  // namespace sft
