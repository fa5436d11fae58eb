// Nodes with certificates find each other. Nodes without certificates neither find them nor are found by
// them.
#include <sys/mount.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>

#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

/// Not in /tmp, because each host has a /tmp of its own.
constexpr const char* certificates = "/srv/certificates";

class Security : public NegotiationTest {
 protected:
  void SetUp() override {
    if (isolation_refusal().empty()) {
      ASSERT_EQ(mount("tmpfs", "/srv", "tmpfs", 0, "size=4m"), 0);
      const std::string command =
          program_directory() + "/make_certificates.sh " + certificates + " publisher subscriber";
      ASSERT_EQ(std::system(command.c_str()), 0);
    }
    NegotiationTest::SetUp();
  }

  static json certified(const std::string& name) {
    return {{"cyclonedds", std::string("file://") + certificates + "/" + name + "/cyclonedds.xml"}};
  }

  static std::size_t readers(Peer& publisher) { return publisher.status()["publisher"]["readers"].size(); }
  static std::size_t writers(Peer& subscriber) { return subscriber.status()["subscriber"]["writers"].size(); }
};

TEST_F(Security, APairWithCertificatesMatchesAndAPairWithoutSeesNothingOfItAndIsNotSeen) {
  Peer publisher(here(), "publisher", certified("publisher"));
  Peer subscriber(there(), "subscriber", certified("subscriber"));
  publisher.advertise();
  subscriber.subscribe("height, width");
  ASSERT_TRUE(agree(publisher, subscriber));
  EXPECT_TRUE(accounts_for_all(publisher, subscriber));

  Peer plain_publisher(there(), "plain_publisher");
  Peer plain_subscriber(here(), "plain_subscriber");
  plain_publisher.advertise();
  plain_subscriber.subscribe("height, width");
  ASSERT_TRUE(agree(plain_publisher, plain_subscriber))
      << "without certificates nodes find each other as ever";
  EXPECT_TRUE(accounts_for_all(plain_publisher, plain_subscriber));

  EXPECT_TRUE(accounts_for_all(publisher, subscriber));
  EXPECT_EQ(readers(publisher), 1U);
  EXPECT_EQ(writers(subscriber), 1U);
  EXPECT_EQ(readers(plain_publisher), 1U);
  EXPECT_EQ(writers(plain_subscriber), 1U);
}

TEST_F(Security, ANodeWithCertificatesThatComesLaterIsServedByOneThatMetNodesWithout) {
  Peer publisher(here(), "publisher", certified("publisher"));
  Peer plain_subscriber(here(), "plain_subscriber");
  publisher.advertise();
  plain_subscriber.subscribe("height, width");
  Peer subscriber(there(), "subscriber", certified("subscriber"));
  subscriber.subscribe("*");
  ASSERT_TRUE(agree(publisher, subscriber));
  EXPECT_TRUE(accounts_for_all(publisher, subscriber));
  EXPECT_EQ(readers(publisher), 1U);
  EXPECT_EQ(writers(plain_subscriber), 0U);
}

TEST_F(Security, WhatAForgerWithoutACertificateSaysInTheNamesOfAPairWithOneCostsItNothing) {
  Peer publisher(here(), "publisher", certified("publisher"));
  Peer subscriber(there(), "subscriber", certified("subscriber"));
  // The forger learns the entity numbers of writers from these nodes. The nodes also show that the forger
  // does harm where there are no certificates.
  Peer plain_publisher(here(), "plain_publisher"), plain_subscriber(there(), "plain_subscriber");
  Peer forger(there(), "forger");
  publisher.advertise();
  subscriber.subscribe("recorded");
  plain_publisher.advertise();
  plain_subscriber.subscribe("height, width");
  ASSERT_TRUE(agree(plain_publisher, plain_subscriber));
  forger.forge("watch");
  ASSERT_TRUE(agree(publisher, subscriber));
  publisher.start_publishing();
  // Longer than the time for which a node waits for a first heartbeat.
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (std::chrono::steady_clock::now() < end) {
    forger.forge("outdate announcements");
    forger.forge("outdate heartbeats");
    forger.forge("heartbeats");
    const std::uint64_t received = subscriber.status()["subscriber"]["received"];
    ASSERT_TRUE(comes_true([&] { return subscriber.status()["subscriber"]["received"] > received + 20; }))
        << "its samples come all the time";
  }
  EXPECT_GT(plain_publisher.status()["node"]["links_renewed"], 0) << "without a certificate it does harm";
  subscriber.read("height");
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher, subscriber, "height"); }));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, subscriber));
  for (Peer* peer : {&publisher, &subscriber})
    EXPECT_EQ(peer->status()["node"]["links_renewed"], 0) << "what it says counts only with its signature";
}

}  // namespace
}  // namespace sft::test
