// A writer counts, for each reader, the samples that are sent, dropped and withheld, while routes change and
// queues overflow.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include "core/seam/delivery.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using namespace detail;

using core::Delivered;
using test::fields;
using test::Image;

class DeliveryTest : public testing::Test {
 protected:
  static std::unique_ptr<core::Network> open_transport(const DecorateIo& decorate = {}) {
    return open_udp_transport(
               {.bind_address = INADDR_LOOPBACK, .backend = Backend::sockets, .send_queue_depth = 4},
               test::make_pool(), decorate)
        .value();
  }
  void open(const DecorateIo& decorate = {}) {
    transport = open_transport(decorate);
    publisher.emplace(*transport, test::Publisher::usual_id, 0, book);
  }
  core::UdpAddress here() { return test::loopback_address(*transport); }
  /// Returns the size of one body under a mask, in bytes.
  static std::size_t body(const std::string& mask) {
    return encoded_size(TypeTable<Image>::type, &image(),
                        test::type_support<Image>().closed(fields<Image>(mask)))
        .bytes;
  }
  static const Image& image() {
    static const Image small = test::make_image(1000);
    return small;
  }
  void publish(int samples) {
    for (int i = 0; i < samples; ++i) {
      const core::SampleHandle sample = publisher->make(image());
      sample->whole_bytes = static_cast<std::uint32_t>(body("*"));
      publisher->port().send(sample);
    }
  }

  const std::shared_ptr<core::DeliveryBook> book = std::make_shared<core::DeliveryBook>();
  std::unique_ptr<core::Network> transport;
  std::optional<test::Publisher> publisher;
};

TEST_F(DeliveryTest, EachReaderHasTheBytesOfItsOwnFieldsAndSavesTheRest) {
  open();
  publisher->serve({{here(), "name"}, {here(), "*"}, {here(), "name"}});
  publish(10);
  const std::size_t name = body("name"), all = body("*");
  const Delivered small{.sent = 10, .bytes = 10 * name, .bytes_saved = 10 * (all - name)};
  EXPECT_EQ(book->of(1), small);
  EXPECT_EQ(book->of(2), (Delivered{.sent = 10, .bytes = 10 * all}));
  EXPECT_EQ(book->of(3), small) << "what travels once counts for each";
}

TEST_F(DeliveryTest, CountsGoOnWhileMasksChange) {
  open();
  // A second process, because readers of one process might share a copy.
  const auto elsewhere = open_transport();
  sft::test::Random random{sft::test::test_seed()};
  SCOPED_TRACE(sft::test::how_to_repeat());
  const std::vector<std::string> masks{"name", "data", "*"};
  std::uint64_t published = 0, bytes = 0;
  for (int change = 0; change < 200; ++change) {
    const std::string& mask = masks[random() % masks.size()];
    publisher->serve({{here(), mask}, {test::loopback_address(*elsewhere), masks[random() % masks.size()]}});
    const int samples = static_cast<int>(random() % 3);
    publish(samples);
    published += static_cast<std::uint64_t>(samples);
    bytes += static_cast<std::uint64_t>(samples) * body(mask);
  }
  const Delivered first = book->of(1);
  EXPECT_EQ(first.sent + first.dropped, published);
  EXPECT_EQ(first.bytes, bytes);
  EXPECT_EQ(first.bytes + first.bytes_saved, published * body("*"));
  EXPECT_EQ(book->of(2).sent + book->of(2).dropped, published);
}

TEST_F(DeliveryTest, EachReaderHasTheBytesOfTheCopyThatItShares) {
  open();
  publisher->serve({{here(), "data"}, {here(), "*"}});
  publish(1);
  transport->poll(std::chrono::steady_clock::now());
  publish(10);
  const std::size_t data = body("data"), all = body("*");
  EXPECT_EQ(book->of(1), (Delivered{.sent = 11, .bytes = data + 10 * all, .bytes_saved = all - data}));
  EXPECT_EQ(book->of(2), (Delivered{.sent = 11, .bytes = 11 * all}));
}

TEST_F(DeliveryTest, WhatCouldNotBeMadeIsDroppedForAll) {
  open();
  publisher->serve({{here(), "name"}, {here(), "*"}});
  publisher->port().begin().miss();
  EXPECT_EQ(book->of(1), (Delivered{.dropped = 1}));
  EXPECT_EQ(book->of(2), (Delivered{.dropped = 1}));
}

TEST_F(DeliveryTest, WhatIsPushedOutOfAQueueIsDroppedForThoseBehindItOnly) {
  open();
  constexpr std::uint16_t elsewhere = 9;
  core::UdpAddress far = here();
  far.port = elsewhere;
  publisher->serve({{here(), "name"}});
  publish(1);
  // The reader waits for a retained sample, so live samples wait in its queue, which takes at most 256 small
  // samples.
  publisher->port().set_routes(
      {{1, here(), fields<Image>("name")}, {2, far, fields<Image>("name"), 0, nullptr, 1}});
  publish(300);
  EXPECT_EQ(book->of(1).sent, 301U);
  EXPECT_EQ(book->of(1).dropped, 0U);
  EXPECT_GT(book->of(2).dropped, 0U);
  EXPECT_EQ(book->of(2).sent + book->of(2).dropped, 300U);
}

}  // namespace
}  // namespace sft::udp
