// A node announces its endpoints, also on links that are opened later.
#include "core/discovery/own_announcements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/control/control_digest.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;

/// Writes down what is written to it.
class WrittenLink final : public DiscoveryLink {
 public:
  Result<void> hear(Role) override { return {}; }
  Result<void> write(const Endpoint& endpoint) override {
    written.push_back("endpoint " + std::to_string(endpoint.revision));
    return {};
  }
  Result<void> write(const Request& request) override {
    written.push_back("request " + std::to_string(request.sequence));
    return {};
  }
  Result<void> exchange_full_signs() override { return {}; }
  void write(const Assertion&, bool) override {}
  bool hear_pulses(Time) override { return true; }
  void dispose(EndpointId, Role) override {}
  void end_life(NodeId) override {}
  void greet() override {}
  void complain(const std::vector<AnnouncerId>&) override {}
  void flush(std::chrono::milliseconds) override {}
  std::vector<std::string> written;
};

class OwnAnnouncementsTest : public ::testing::Test {
 protected:
  static Endpoint endpoint(std::uint64_t revision = 0) {
    Endpoint e;
    e.id = 5;
    e.role = Role::reader;
    e.revision = revision;
    e.request.reader = 5;
    e.request.sequence = 1;
    return e;
  }
  static Request second_request() {
    Request request;
    request.reader = 5;
    request.sequence = 2;
    return request;
  }
  std::vector<std::string> written() const {
    WrittenLink link;
    own.write_to(link);
    return link.written;
  }

  OwnAnnouncements own;
};

TEST_F(OwnAnnouncementsTest, EachAnnouncementHasAGreaterRevision) {
  EXPECT_EQ(own.announce(endpoint()).revision, 1U);
  EXPECT_EQ(own.announce(endpoint()).revision, 2U);
  EXPECT_EQ(own.announce(endpoint(100)).revision, 100U) << "somebody else has used 99 in its name";
  EXPECT_EQ(own.announce(endpoint()).revision, 101U);
}

TEST_F(OwnAnnouncementsTest, ANewLinkGetsEachEndpointWithItsLatestRequest) {
  own.announce(endpoint());
  EXPECT_THAT(written(), ElementsAre("endpoint 1"));
  own.request(second_request());
  EXPECT_THAT(written(), ElementsAre("endpoint 1", "request 2"));
  Endpoint with_request = endpoint();
  with_request.request.sequence = 2;
  own.announce(with_request);
  EXPECT_THAT(written(), ElementsAre("endpoint 2")) << "which contains the request";
}

TEST_F(OwnAnnouncementsTest, RequestsOfOthersAndOfWithdrawnReadersAreNotKept) {
  own.request(second_request());
  own.announce(endpoint());
  EXPECT_THAT(written(), ElementsAre("endpoint 1"));
  EXPECT_EQ(own.withdraw(5), Role::reader);
  EXPECT_THAT(written(), ElementsAre());
  EXPECT_EQ(own.digest(Role::reader), 0U);
  EXPECT_EQ(own.withdraw(5), std::nullopt);
}

TEST_F(OwnAnnouncementsTest, EachRoleHasADigestOfItsOwn) {
  Endpoint writer = endpoint();
  writer.id = 6;
  writer.role = Role::writer;
  own.announce(writer);
  EXPECT_EQ(own.digest(Role::writer), add_to_digest(0, digest_part(6, 1, 1)));
  EXPECT_EQ(own.digest(Role::reader), 0U);
  own.announce(endpoint());
  EXPECT_EQ(own.digest(Role::writer), add_to_digest(0, digest_part(6, 1, 1)));
  EXPECT_EQ(own.digest(Role::reader), add_to_digest(0, digest_part(5, 1, 1)));
}

TEST_F(OwnAnnouncementsTest, TheDigestIsOfRevisionsAndLatestRequests) {
  own.announce(endpoint());
  EXPECT_EQ(own.digest(Role::reader), add_to_digest(0, digest_part(5, 1, 1)));
  own.request(second_request());
  EXPECT_EQ(own.digest(Role::reader), add_to_digest(0, digest_part(5, 1, 2)));
}

}  // namespace
}  // namespace sft::core
