// Readers, writers and transports are destroyed while datagrams are sent and received.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

TEST_P(TransportTest, GivesItsPortBackWhenItCloses) {
  UdpOptions options{.bind_address = GetParam().loopback, .backend = GetParam()};
  options.port = open()->addresses()[0].port;
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(open_udp_transport(options, test::make_pool()));
}

TEST_P(TransportTest, TellsPortsThatItIsGone) {
  auto there = open();
  const auto here = open();
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  Subscriber subscriber(*there, {"*"});
  there.reset();
  EXPECT_EQ(publisher.publish(make_image(10)), core::SendStatus::lost_port);
  EXPECT_FALSE(subscriber.port().take());
}

/// Publishes without a pause, on a thread of its own.
class Flood {
 public:
  Flood(core::Network& transport, const core::UdpAddress& to, std::size_t bytes) : publisher_(transport) {
    publisher_.serve({{to}});
    thread_ = std::thread([this, bytes] {
      const Image image = make_image(bytes);
      while (!done_) publisher_.publish(image);
    });
  }
  ~Flood() {
    done_ = true;
    thread_.join();
  }
  core::EndpointId id() const { return publisher_.id(); }

 private:
  Publisher publisher_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

class Untouchable final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    EXPECT_FALSE(gone);
    ++calls;
  }
  std::atomic<bool> gone{false};
  std::atomic<int> calls{0};
};

TEST_P(TransportTest, CallsNoListenerAfterItsReaderWent) {
  const auto there = open(), here = open();
  for (const std::size_t bytes : {20U, 100'000U}) {
    Flood flood(*there, loopback_address(*here), bytes);
    for (int i = 0; i < 50; ++i) {
      Untouchable listener;
      auto reader = here->open_reader({.id = 1,
                                       .type = &test::type_support<Image>(),
                                       .depth = 1,
                                       .listener = &listener,
                                       .doorbell = {}})
                        .value();
      reader->accept({{.wanted = {fields<Image>("*")}}});
      ASSERT_TRUE(reader->connect({flood.id(), 0}));
      ASSERT_TRUE(eventually([&] { return listener.calls > 0; }));
      reader.reset();
      listener.gone = true;
    }
  }
}

class ReaderDestroying final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    reader.reset();
    done = true;
  }
  std::unique_ptr<core::NetworkReader> reader;
  std::atomic<bool> done{false};
};

TEST_P(TransportTest, LetsAListenerDestroyItsReader) {
  const auto there = open(), here = open();
  for (int i = 0; i < 20; ++i) {
    ReaderDestroying listener;
    listener.reader = here->open_reader({.id = 1,
                                         .type = &test::type_support<Image>(),
                                         .depth = 1,
                                         .listener = &listener,
                                         .doorbell = {}})
                          .value();
    listener.reader->accept({{.wanted = {fields<Image>("*")}}});
    // Uses a new writer, because the receiving thread would discard the repeated first sample of a known
    // writer.
    Publisher publisher(*there, Publisher::usual_id + static_cast<core::EndpointId>(i));
    ASSERT_TRUE(listener.reader->connect({publisher.id(), 0}));
    publisher.serve({{loopback_address(*here)}});
    publisher.publish(make_image(10));
    ASSERT_TRUE(eventually([&] { return listener.done.load(); }));
  }
}

TEST_P(TransportTest, ClosesWhileDatagramsCome) {
  const auto there = open();
  for (int i = 0; i < 20; ++i) {
    auto here = open();
    Flood flood(*there, loopback_address(*here), 50'000);
    Subscriber subscriber(*here, {"*"}, 1);
    subscriber.listen_to(flood.id());
    EXPECT_GE(subscriber.await(1).size(), 1U);
    here.reset();
  }
}

TEST_P(TransportTest, ClosesWhileItSends) {
  const auto here = open();
  for (int i = 0; i < 20; ++i) {
    auto there = open();
    Publisher publisher(*there);
    publisher.serve({{loopback_address(*here)}});
    for (int k = 0; k < 4; ++k) EXPECT_EQ(publisher.publish(make_image(4'000'000)), core::SendStatus::sent);
    there.reset();
    EXPECT_NE(publisher.publish(make_image(10)), core::SendStatus::sent) << "nobody sends it any more";
  }
  const auto there = open();
  Publisher publisher(*there, 0x77);
  Subscriber subscriber(*here, {"*"});
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  publisher.publish(make_image(1'000'000));
  EXPECT_EQ(subscriber.await_sequences(1), first_numbers(1)) << "what was cut off does not stand in its way";
}

}  // namespace
}  // namespace sft::udp
