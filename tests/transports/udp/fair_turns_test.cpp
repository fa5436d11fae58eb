// A topic that never stops and a topic of a stop button share a sending thread or a receiving thread.
#include <atomic>
#include <functional>
#include <thread>

#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using test::make_image;
using test::Publisher;
using test::Subscriber;

/// Publishes until it is destroyed.
class EndlessTopic {
 public:
  explicit EndlessTopic(std::function<void()> publish_one)
      : thread_([this, publish_one = std::move(publish_one)] {
          for (; !ends_; ++published_) publish_one();
        }) {}
  ~EndlessTopic() {
    ends_ = true;
    thread_.join();
  }
  std::size_t published() const { return published_; }

 private:
  std::atomic<bool> ends_{false};
  std::atomic<std::size_t> published_{0};
  std::thread thread_;
};

class FairTurnsTest : public TransportTest {
 protected:
  static constexpr core::EndpointId cloud_id = 7, stop_id = 8;
  static constexpr std::size_t presses = 20;

  /// Returns a reader whose queue holds one sample. No thread takes the sample.
  static std::unique_ptr<core::NetworkReader> reader_of_cloud(core::Network& there, bool reliable) {
    auto reader =
        there.open_reader({.id = 2, .type = &type_support<test::Image>(), .depth = 1, .doorbell = {}})
            .value();
    reader->accept({{.wanted = {test::selection_of<test::Image>("*")}}});
    EXPECT_TRUE(reader->connect({.writer = cloud_id, .reliable = reliable}));
    return reader;
  }
  /// Presses the stop button repeatedly, while the other topic goes on. Expects each press to arrive.
  static void press(Publisher& stop, const std::vector<Subscriber*>& all, const EndlessTopic& flood) {
    for (std::size_t n = 1; n <= presses; ++n) {
      const std::size_t before = flood.published();
      ASSERT_TRUE(test::eventually([&] { return flood.published() > before; })) << "it goes on";
      stop.publish(make_image(4));
      for (Subscriber* of_stop : all) ASSERT_EQ(of_stop->await(n).size(), n);
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Over, FairTurnsTest, all_ways, way_name);

/// Each reading process requests other fields, so that the sending thread sends most variants.
TEST_P(FairTurnsTest, ASendingThreadServesAStopButtonBesideAPublisherThatNeverStops) {
  const auto here = open();
  std::vector<std::unique_ptr<core::Network>> there;
  std::vector<std::unique_ptr<Subscriber>> subscribers;
  std::vector<Subscriber*> of_stop;
  std::vector<Publisher::Reader> once, reliably;
  for (const char* mask : {"name", "height", "width", "stamp.sec", "stamp.nanosec", "data", "*"}) {
    there.push_back(open());
    of_stop.push_back(
        subscribers.emplace_back(std::make_unique<Subscriber>(*there.back(), std::vector<std::string>{mask}))
            .get());
    of_stop.back()->listen_reliably_to(stop_id);
    once.push_back({test::loopback_address(*there.back()), mask, false});
    reliably.push_back({test::loopback_address(*there.back()), mask, true});
  }
  Publisher cloud(*here, cloud_id), stop(*here, stop_id);
  cloud.serve(once);
  stop.serve(reliably);
  const test::Image image = make_image(100);
  const EndlessTopic flood([&] { cloud.publish(image); });
  press(stop, of_stop, flood);
}

TEST_P(FairTurnsTest, ASendingThreadServesAStopButtonBesideLargeSamplesWithoutEnd) {
  const auto here = open(), there = open();
  const auto of_cloud = reader_of_cloud(*there, true);
  Subscriber of_stop(*there, {"*"}, 1000, 1);
  of_stop.listen_reliably_to(stop_id);
  Publisher cloud(*here, cloud_id), stop(*here, stop_id);
  cloud.serve({{test::loopback_address(*there), "*", true}});
  stop.serve({{test::loopback_address(*there), "*", true}});
  const test::Image image = make_image(33'000'000);
  const EndlessTopic flood([&] { cloud.publish(image); });
  press(stop, {&of_stop}, flood);
}

/// The publishers' threads send both topics themselves as long as there is room at the receiver.
TEST_P(FairTurnsTest, APublisherThatNeverStopsLeavesRoomAtTheReceiverToAStopButtonOfItsNode) {
  const auto here = open(), there = open();
  const auto of_cloud = reader_of_cloud(*there, false);
  Subscriber of_stop(*there, {"*"}, 1000, 1);
  of_stop.listen_reliably_to(stop_id);
  Publisher cloud(*here, cloud_id), stop(*here, stop_id);
  cloud.serve({{test::loopback_address(*there), "*"}});
  stop.serve({{test::loopback_address(*there), "*", true}});
  const test::Image image = make_image(4);
  const EndlessTopic flood([&] { cloud.publish(image); });
  press(stop, {&of_stop}, flood);
}

TEST_P(FairTurnsTest, AReceivingThreadServesAStopButtonBesideASenderThatNeverStops) {
  const auto flooding = open(), rare = open(), there = open();
  const auto of_cloud = reader_of_cloud(*there, false);
  Subscriber of_stop(*there, {"*"}, 1000, 1);
  of_stop.listen_reliably_to(stop_id);
  Publisher cloud(*flooding, cloud_id), stop(*rare, stop_id);
  cloud.serve({{test::loopback_address(*there), "*"}});
  stop.serve({{test::loopback_address(*there), "*", true}});
  const EndlessTopic flood([&] { cloud.publish(make_image(4)); });
  press(stop, {&of_stop}, flood);
}

}  // namespace
}  // namespace sft::udp
