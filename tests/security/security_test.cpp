// Nodes with certificates take part, and all others neither see them nor are seen by them.
#include <sys/mount.h>
#include <sys/stat.h>

#include <cstdlib>

#include "tests/negotiation/fixture.h"

namespace sft::test {
namespace {

/// Beside /tmp, of which each host has its own.
constexpr const char* certificates = "/mnt/certificates";

class Security : public NegotiationTest {
 protected:
  void SetUp() override {
    if (isolation_refusal().empty()) {
      ASSERT_EQ(mount("tmpfs", "/mnt", "tmpfs", 0, "size=4m"), 0);
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

  Peer plain_publisher(there(), "plain publisher");
  Peer plain_subscriber(here(), "plain subscriber");
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
  Peer plain_subscriber(here(), "plain subscriber");
  publisher.advertise();
  plain_subscriber.subscribe("height, width");
  Peer subscriber(there(), "subscriber", certified("subscriber"));
  subscriber.subscribe("*");
  ASSERT_TRUE(agree(publisher, subscriber));
  EXPECT_TRUE(accounts_for_all(publisher, subscriber));
  EXPECT_EQ(readers(publisher), 1U);
  EXPECT_EQ(writers(plain_subscriber), 0U);
}

}  // namespace
}  // namespace sft::test
