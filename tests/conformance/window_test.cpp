// A reader requests one window of an image or a cloud after the other, while its writer publishes. A layout
// rule of the message type says how the data consists of rows and columns, and which other fields a part
// changes. Each sample names a window that may have been in force when the sample was sent, and equals the
// part that a reference cuts for that window. Readers that share the whole sample cut the part themselves.
#include <atomic>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <thread>

#include "core/negotiation/accepted_requests.h"
#include "tests/conformance/conformance.h"
#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/test_seed.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using sensor_msgs::msg::PointCloud2;
using Picture = sensor_msgs::msg::Image;

constexpr std::uint32_t rows_most = 24, columns_most = 32;

/// Returns an image in which each byte depends on its place and on `number`. Each row ends with padding.
Picture message_of(std::uint32_t number, const Picture&) {
  Picture picture;
  picture.header.stamp.sec = static_cast<std::int32_t>(number);
  picture.header.frame_id = "camera";
  picture.height = 1 + number % rows_most;
  picture.width = 1 + number * 7 % columns_most;
  picture.encoding = "rgb8";
  picture.step = 3 * picture.width + number % 5;
  picture.data.resize(std::size_t{picture.height} * picture.step);
  udp::test::fill_with_distances(picture.data, number);
  return picture;
}

/// Returns a cloud of the same kind, which also has gaps between the channels.
PointCloud2 message_of(std::uint32_t number, const PointCloud2&) {
  using sensor_msgs::msg::PointField;
  PointCloud2 cloud;
  cloud.header.stamp.sec = static_cast<std::int32_t>(number);
  cloud.header.frame_id = "lidar";
  cloud.fields = {{.name = "x", .offset = 0, .datatype = PointField::FLOAT32, .count = 1},
                  {.name = "y", .offset = 5, .datatype = PointField::FLOAT32, .count = 1},
                  {.name = "ring", .offset = 10, .datatype = PointField::UINT16, .count = 1}};
  cloud.point_step = 14;
  cloud.height = 1 + number % rows_most;
  cloud.width = 1 + number * 7 % columns_most;
  cloud.row_step = cloud.width * cloud.point_step + number % 4;
  cloud.data.resize(std::size_t{cloud.height} * cloud.row_step);
  udp::test::fill_with_distances(cloud.data, number);
  return cloud;
}

/// Returns a random range for a message with up to `most` rows or columns. The range may reach beyond the
/// edge.
std::string any_range(test::Random& random, std::uint32_t most) {
  const std::uint64_t begin = random() % most, end = begin + 1 + random() % most;
  return std::to_string(begin) + ":" + std::to_string(end) + ":" + std::to_string(1 + random() % 3);
}

std::string any_window(test::Random& random) {
  return "[rows " + any_range(random, rows_most) + ", columns " + any_range(random, columns_most) + "]";
}

std::string any_wish(test::Random& random, const Picture&) {
  const std::vector<std::string> others{"header.stamp, ", "header, ", ""};
  return others[random() % others.size()] + "data" + any_window(random);
}

std::string any_wish(test::Random& random, const PointCloud2&) {
  const std::vector<std::string> channels{"", "{x}", "{y,ring}", "{ring,lacking}", "{x,y,ring}"};
  return "header.stamp, data" + channels[random() % channels.size()] + any_window(random);
}

/// A writer, and the reader whose window moves.
template <class Message>
class MovingWindow {
 public:
  static constexpr std::size_t changes = 1000;

  MovingWindow(Stage& stage, test::Random random) : stage_(stage) {
    for (std::size_t i = 0; i <= changes; ++i)
      asked_.push_back(selection(any_wish(random, Message()), type()));
    requests_ = core::AcceptedRequests({asked_[0]}, stage.medium->traits().reliable);
    reader_.accept(requests_.all());
    reader_.hear(writer_);
    writer_.serve({reader_.route(asked_[0])});
  }

  /// Moves the window repeatedly. At least one sample is sent between two moves.
  void move(const std::stop_token& stop) {
    for (std::size_t change = 1; change <= changes; ++change) {
      const std::size_t sent = published_;
      still_since_ = sent;
      while (published_ < sent + 2 && !stop.stop_requested()) std::this_thread::yield();
      if (stop.stop_requested()) return;
      begun_ = change;
      requests_.asks_for({asked_[change]}, std::chrono::steady_clock::now());
      reader_.accept(requests_.all());
      writer_.serve({reader_.route(asked_[change])});
      done_ = change;
    }
  }
  /// Publishes and compares samples until all changes are complete, and then two more samples.
  void publish_and_compare() {
    for (std::size_t left = 2; left > 0; left -= done_ == changes ? 1 : 0) {
      ASSERT_NO_FATAL_FAILURE(publish());
      ASSERT_NO_FATAL_FAILURE(take_and_compare(in_flight()));
    }
    ASSERT_NO_FATAL_FAILURE(take_and_compare(0));
  }
  void expect_all_windows_to_have_come() {
    std::set<std::uint64_t> all;
    for (const Selection& one : asked_) all.insert(one.hash());
    EXPECT_EQ(came_.size(), all.size());
    EXPECT_EQ(came_, all);
  }

 private:
  /// The numbers of the first and the last window that may have been in force while a sample was sent.
  struct Span {
    std::size_t first = 0, last = 0;
  };

  static const TypeSupport& type() { return udp::test::type_support<Message>(); }
  static Message message(std::uint64_t sequence) {
    return message_of(static_cast<std::uint32_t>(sequence), Message());
  }
  /// Returns the number of samples that may be under way at a time. For best-effort readers this number is
  /// 0, because samples under another selection may overtake earlier samples.
  std::uint64_t in_flight() const { return stage_.medium->traits().reliable ? 8 : 0; }

  /// Publishes a sample. If four samples were published since the last change, first waits for the next
  /// change.
  void publish() {
    while (published_ >= still_since_ + 4 && done_ < changes) std::this_thread::yield();
    Span span{.first = done_};
    const SampleHandle sample = writer_.make_of(message(writer_.sequence() + 1));
    ASSERT_TRUE(sample);
    ASSERT_EQ(writer_.port().send(sample), core::SendStatus::sent);
    span.last = begun_;
    spans_.push_back(span);
    ++published_;
  }
  /// Takes and checks samples until at most `under_way` published samples are still to come.
  void take_and_compare(std::uint64_t under_way) {
    while (taken_ + under_way < published_) {
      const SampleHandle sample = reader_.next();
      ASSERT_TRUE(sample) << "sample " << taken_ + 1 << " does not come";
      ASSERT_EQ(sample->sequence, ++taken_) << "no route was ever missing";
      stage_.medium->traits().projects ? expect_named_part(*sample) : expect_part_of_whole(*sample);
    }
  }
  void expect_named_part(const core::SampleBuffer& sample) {
    const Span span = spans_[sample.sequence];
    for (std::size_t i = span.first; i <= span.last; ++i) {
      if (asked_[i].mask() != sample.mask || asked_[i].parts_hash() != sample.parts) continue;
      ASSERT_EQ(udp::test::body_of(sample), part(sample.sequence, asked_[i])) << "sample " << sample.sequence;
      came_.insert(asked_[i].hash());
      return;
    }
    FAIL() << "sample " << sample.sequence << " names a window that was not in force";
  }
  /// Checks a whole sample that all readers share. The test then cuts the part that the reader requests.
  void expect_part_of_whole(const core::SampleBuffer& sample) {
    const Selection& asked = asked_[spans_[sample.sequence].last];
    ASSERT_EQ(sample.parts, 0U);
    ASSERT_EQ(udp::test::body_of(sample), encoded_body(message(sample.sequence), type().full()));
    const detail::ProjectionPlan plan(type(), asked);
    detail::Projection projection;
    ASSERT_TRUE(projection.project(core::state_of(sample, type().index_slots()), plan, {}));
    ASSERT_EQ(test::gathered(projection), part(sample.sequence, asked)) << "sample " << sample.sequence;
    came_.insert(asked.hash());
  }
  static std::vector<std::byte> part(std::uint64_t sequence, const Selection& asked) {
    return encoded_body(test::cut_reference::cut(message(sequence), asked.parts().front()), asked.mask());
  }

  Stage& stage_;
  std::vector<Selection> asked_;  ///< in the order of the reader's requests
  Writer writer_{stage_, 1, {}, type()};
  Reader reader_{stage_, {.type = &type()}};
  core::AcceptedRequests requests_;
  std::vector<Span> spans_{1};  ///< the windows that may have been in force for each sample, by sequence
  std::atomic<std::size_t> published_{0};
  std::atomic<std::size_t> still_since_{0};  ///< the number of samples published before the last change
  /// The numbers of the last change that has begun, and of the last change that is complete.
  std::atomic<std::size_t> begun_{0}, done_{0};
  std::uint64_t taken_ = 0;
  std::set<std::uint64_t> came_;  ///< the hashes of the selections under which samples arrived
};

template <class Message>
void move_a_window_while_samples_come(Stage& stage) {
  MovingWindow<Message> world(stage, test::Random(test::test_seed()));
  std::jthread agent([&world](const std::stop_token& stop) { world.move(stop); });
  ASSERT_NO_FATAL_FAILURE(world.publish_and_compare());
  agent.join();
  world.expect_all_windows_to_have_come();
  EXPECT_EQ(stage.here->counters().malformed, 0U);
}

TEST_P(Conformance, GivesEachSampleOfAnImageTheRowsAndColumnsThatItNamesWhileTheWindowMoves) {
  SCOPED_TRACE(test::how_to_repeat());
  move_a_window_while_samples_come<Picture>(stage);
}

TEST_P(Conformance, GivesEachSampleOfACloudTheChannelsRowsAndColumnsThatItNamesWhileTheWindowMoves) {
  SCOPED_TRACE(test::how_to_repeat());
  move_a_window_while_samples_come<PointCloud2>(stage);
}

}  // namespace
}  // namespace sft::conformance
