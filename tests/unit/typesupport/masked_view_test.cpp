// The generated getters return the values that were encoded, for samples that lack some fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <nav_msgs/msg/Odometry.hpp>
#include <proof.hpp>
#include <ranges>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

#include "sft/detail/view.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"

namespace sft {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::PointCloud2;
using test::Encoded;

// Compares a getter's result with the owned struct, by bits, so that a NaN equals itself.
template <class V>
requires std::is_arithmetic_v<V> || std::is_enum_v<V>
bool same(V got, V owned) { return std::memcmp(&got, &owned, sizeof got) == 0; }

bool same(std::string_view got, const std::string& owned) { return got == owned; }

template <class E>
bool same(std::span<const E> got, const std::vector<E>& owned) {
  return std::ranges::equal(got, owned, [](E a, E b) { return same(a, b); });
}

template <class E, std::size_t N>
bool same(std::span<const E> got, const std::array<E, N>& owned) {
  return std::ranges::equal(got, owned, [](E a, E b) { return same(a, b); });
}

bool same(StringRange got, const std::vector<std::string>& owned) { return std::ranges::equal(got, owned); }

/// Returns true if the range of views is as long as `owned`, and same_element(view, element) is true for each
/// pair.
template <class Range, class Owned, class SameElement>
bool each_same(const Range& got, const Owned& owned, SameElement same_element) {
  return got.size() == owned.size() && std::ranges::equal(got, owned, same_element);
}

class MaskedViewTest : public test::RandomTest {
 protected:
  /// Calls check(view, message) for a reader that declared R, with two samples. One sample has only the
  /// fields of R. The other sample has all fields, like a sample that a reader on the publisher's host
  /// gets.
  template <class T, Req<T> R, class Check>
  void for_samples(Check check) {
    for (int round = 0; round < 400 && !HasFailure(); ++round) {
      T message;
      values.fill(TypeTable<T>::type, &message);
      const Encoded exact(message, R.mask);
      const Encoded full(message);
      for (const Encoded* sample : {&exact, &full}) {
        check(view_of<T, R>(sample->state()), message);
        EXPECT_FALSE(sample->state().is_malformed());
      }
    }
  }

  test::RandomValues values{random};
};

TEST_F(MaskedViewTest, ScalarsStringsAndBlocksOfACloud) {
  using F = PointCloud2::Field;
  for_samples<PointCloud2, F::header.frame_id | F::width | F::data | F::is_dense>(
      [](const auto& view, const PointCloud2& cloud) {
        EXPECT_TRUE(same(view.header().frame_id(), cloud.header.frame_id));
        EXPECT_TRUE(same(view.width(), cloud.width));
        EXPECT_TRUE(same(view.data(), cloud.data));
        EXPECT_TRUE(same(view.is_dense(), cloud.is_dense));
      });
}

TEST_F(MaskedViewTest, SomeLeavesOfTheElementsOfASequence) {
  using F = PointCloud2::Field;
  for_samples<PointCloud2, F::fields.each.name | F::fields.each.count>(
      [](const auto& view, const PointCloud2& cloud) {
        EXPECT_TRUE(each_same(view.fields(), cloud.fields, [](const auto& field, const auto& owned) {
          return same(field.name(), owned.name) && same(field.count(), owned.count);
        }));
      });
}

TEST_F(MaskedViewTest, TheLengthAloneOfASequence) {
  for_samples<PointCloud2, PointCloud2::Field::fields.size>([](const auto& view, const PointCloud2& cloud) {
    EXPECT_EQ(view.fields().size(), cloud.fields.size());
  });
}

TEST_F(MaskedViewTest, LeavesFarBelowInNestedStructs) {
  using F = Odometry::Field;
  for_samples<Odometry, F::header.stamp.nanosec | F::pose.pose.position | F::twist.covariance>(
      [](const auto& view, const Odometry& odometry) {
        EXPECT_TRUE(same(view.header().stamp().nanosec(), odometry.header.stamp.nanosec));
        EXPECT_TRUE(same(view.pose().pose().position().x(), odometry.pose.pose.position.x));
        EXPECT_TRUE(same(view.pose().pose().position().z(), odometry.pose.pose.position.z));
        EXPECT_TRUE(same(view.twist().covariance(), odometry.twist.covariance));
      });
}

TEST_F(MaskedViewTest, BehindSequencesThatAreAbsent) {
  using F = BatteryState::Field;
  for_samples<BatteryState, F::present | F::cell_temperature | F::serial_number>(
      [](const auto& view, const BatteryState& battery) {
        EXPECT_TRUE(same(view.present(), battery.present));
        EXPECT_TRUE(same(view.cell_temperature(), battery.cell_temperature));
        EXPECT_TRUE(same(view.serial_number(), battery.serial_number));
      });
}

TEST_F(MaskedViewTest, ElementsThatLieOtherwiseAlignedThanInTheWholeMessage) {
  using F = proof::Misaligned::Field;
  constexpr auto same_b = [](const auto& pair, const proof::Pair& owned) { return same(pair.b(), owned.b); };
  for_samples<proof::Misaligned, F::pairs.each.b | F::grid.each.b | F::doubles | F::last>(
      [=](const auto& view, const proof::Misaligned& message) {
        std::vector<proof::Pair> grid(message.grid[0].begin(), message.grid[0].end());
        grid.insert(grid.end(), message.grid[1].begin(), message.grid[1].end());
        EXPECT_TRUE(each_same(view.pairs(), message.pairs, same_b));
        EXPECT_TRUE(each_same(view.grid(), grid, same_b));
        EXPECT_TRUE(same(view.doubles(), message.doubles));
        EXPECT_TRUE(same(view.last(), message.last));
      });
}

TEST_F(MaskedViewTest, SequencesInElementsOfSequences) {
  using F = proof::Scene::Field;
  for_samples<proof::Scene, F::tracks.each.pairs.each.b | F::tracks.each.flags | F::tracks.each.mark |
                                F::ends.each.corners | F::few.each.tags | F::tail>(
      [](const auto& view, const proof::Scene& scene) {
        EXPECT_TRUE(each_same(view.tracks(), scene.tracks, [](const auto& track, const proof::Track& owned) {
          return each_same(track.pairs(), owned.pairs,
                           [](const auto& pair, const proof::Pair& p) { return same(pair.b(), p.b); }) &&
                 same(track.flags(), owned.flags) && same(track.mark(), owned.mark);
        }));
        EXPECT_TRUE(each_same(view.ends(), scene.ends, [](const auto& track, const proof::Track& owned) {
          return each_same(track.corners(), owned.corners, [](const auto& pair, const proof::Pair& p) {
            return same(pair.a(), p.a) && same(pair.b(), p.b);
          });
        }));
        EXPECT_TRUE(each_same(view.few(), scene.few, [](const auto& track, const proof::Track& owned) {
          return same(track.tags(), owned.tags);
        }));
        EXPECT_TRUE(same(view.tail(), scene.tail));
      });
}

TEST_F(MaskedViewTest, OfANestedSequenceTheLengthAloneWithMembersBehindIt) {
  using F = proof::Scene::Field;
  for_samples<proof::Scene, F::tracks.each.pairs.size | F::tracks.each.mark>(
      [](const auto& view, const proof::Scene& scene) {
        EXPECT_TRUE(each_same(view.tracks(), scene.tracks, [](const auto& track, const proof::Track& owned) {
          return track.pairs().size() == owned.pairs.size() && same(track.mark(), owned.mark);
        }));
      });
}

TEST_F(MaskedViewTest, EnumerationsStringsAndBooleansInSequences) {
  using F = torture::Sequences::Field;
  for_samples<torture::Sequences, F::flags | F::letters | F::eight | F::texts | F::colors | F::tinies |
                                      F::nicknames>([](const auto& view, const torture::Sequences& owned) {
    EXPECT_TRUE(same(view.flags(), owned.flags));
    EXPECT_TRUE(same(view.letters(), owned.letters));
    EXPECT_TRUE(same(view.eight(), owned.eight));
    EXPECT_TRUE(same(view.texts(), owned.texts));
    EXPECT_TRUE(same(view.colors(), owned.colors));
    EXPECT_TRUE(same(view.tinies(), owned.tinies));
    EXPECT_TRUE(same(view.nicknames(), owned.nicknames));
  });
}

/// Returns true if the optional result of a getter has a value exactly if `expected` is true, and that value
/// equals `owned`.
template <class V, class Owned>
bool there_if(bool expected, const std::optional<V>& got, const Owned& owned) {
  return got.has_value() == expected && (!expected || same(*got, owned));
}

TEST_F(MaskedViewTest, RecordedGettersHaveAValueExactlyIfTheSampleHasTheLeaf) {
  const TypeSupport support(TypeTable<PointCloud2>::type);
  for (int round = 0; round < 1000 && !HasFailure(); ++round) {
    PointCloud2 cloud;
    values.fill(support.type(), &cloud);
    const FieldMask mask = support.closed(values.mask(support.leaves()));
    const Encoded sample(support.type(), &cloud, mask);
    const auto has = [&](std::string_view path) { return mask.contains(*support.find(path)); };

    std::vector<AccessWord> words(1);
    AccessLog log(words, nullptr);
    SampleState state = sample.state();
    state.log = &log;
    const auto view = view_of<PointCloud2, recorded>(state);
    EXPECT_TRUE(there_if(has("header.stamp.sec"), view.header().stamp().sec(), cloud.header.stamp.sec));
    EXPECT_TRUE(there_if(has("header.frame_id"), view.header().frame_id(), cloud.header.frame_id));
    EXPECT_TRUE(there_if(has("data"), view.data(), cloud.data));
    EXPECT_TRUE(there_if(has("is_dense"), view.is_dense(), cloud.is_dense));
    const auto fields = view.fields();
    ASSERT_EQ(fields.has_value(), has("fields.size"));
    if (!fields) continue;
    EXPECT_TRUE(each_same(*fields, cloud.fields, [&](const auto& field, const auto& owned) {
      return there_if(has("fields[].name"), field.name(), owned.name) &&
             there_if(has("fields[].datatype"), field.datatype(), owned.datatype) &&
             there_if(has("fields[].count"), field.count(), owned.count);
    }));
    EXPECT_FALSE(state.is_malformed());
    const FieldMask read =
        FieldMask::from_words(support.leaves(), std::vector{words[0].found.load() | words[0].missed.load()});
    EXPECT_TRUE(
        read.contains(*support.parse_mask("header.stamp.sec, header.frame_id, data, is_dense, fields.size")));
    EXPECT_FALSE(read.any_of(3, 2)) << "nobody has read height and width";
    EXPECT_EQ(read.contains(*support.find("fields[].count")), !cloud.fields.empty());
  }
}

}  // namespace
}  // namespace sft
