// A node listens to those whom its own endpoints may concern, and to everybody once it is told to.
#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/control/control_codec.h"
#include "core/discovery/discovery.h"
#include "core/sync/mutex.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::test {
namespace {

using core::EndpointId;
using core::Role;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::uint32_t domain() {
  const char* number = std::getenv("ROS_DOMAIN_ID");
  return number == nullptr ? 0 : static_cast<std::uint32_t>(std::atoi(number));
}

core::Endpoint endpoint(Role role, EndpointId id) {
  core::Endpoint e;
  e.id = id;
  e.role = role;
  e.node_id = id;
  e.topic = "points";
  e.type_name = "Points";
  e.request.reader = id;
  return e;
}

/// What one node hears.
class Ear final : private core::DiscoveryListener {
 public:
  Ear()
      : discovery_(std::move(core::Discovery::open({.domain = domain(), .user_config = ""}, *this).value())) {
  }

  void announce(Role role, EndpointId id) { ASSERT_TRUE(discovery_->announce(endpoint(role, id))); }
  void withdraw(EndpointId id) { discovery_->withdraw(id); }
  void ask(EndpointId reader, std::uint64_t sequence) {
    core::Request request;
    request.reader = reader;
    request.sequence = sequence;
    ASSERT_TRUE(discovery_->send(request));
  }
  void hear(Role role) { ASSERT_TRUE(discovery_->hear(role)); }

  std::set<EndpointId> heard() const {
    const core::Lock lock(mutex_);
    return heard_;
  }
  bool hears(EndpointId id) const {
    return eventually([&] { return heard().contains(id); });
  }
  std::uint64_t asked() const {
    const core::Lock lock(mutex_);
    return asked_;
  }
  std::vector<std::string> refused() const {
    const core::Lock lock(mutex_);
    return refused_;
  }

 private:
  void endpoint_seen(core::Endpoint endpoint) override {
    const core::Lock lock(mutex_);
    heard_.insert(endpoint.id);
    asked_ = std::max(asked_, endpoint.request.sequence);
  }
  void endpoint_departed(EndpointId id) override {
    const core::Lock lock(mutex_);
    heard_.erase(id);
  }
  void endpoint_lost(EndpointId) override {}
  void request_received(core::Request request) override {
    const core::Lock lock(mutex_);
    asked_ = std::max(asked_, request.sequence);
  }
  void liveliness_asserted(core::Assertion) override {}
  void node_lost(core::NodeId) override {}
  void control_malformed(std::string why) override {
    const core::Lock lock(mutex_);
    refused_.push_back(std::move(why));
  }

  mutable core::Mutex mutex_;
  std::set<EndpointId> heard_ SFT_GUARDED_BY(mutex_);
  std::uint64_t asked_ SFT_GUARDED_BY(mutex_) = 0;
  std::vector<std::string> refused_ SFT_GUARDED_BY(mutex_);
  std::unique_ptr<core::Discovery> discovery_;
};

class RolesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
};

TEST_F(RolesTest, ReadersHearOfWritersOnlyAndWritersOfReadersUntilTheyAreToldToHearMore) {
  Ear reader, other_reader, writer;
  reader.announce(Role::reader, 1);
  other_reader.announce(Role::reader, 2);
  writer.announce(Role::writer, 3);
  EXPECT_TRUE(writer.hears(1) && writer.hears(2));
  EXPECT_TRUE(reader.hears(3) && other_reader.hears(3));
  other_reader.announce(Role::writer, 4);  // behind its reader
  EXPECT_TRUE(reader.hears(4));
  EXPECT_THAT(reader.heard(), ElementsAre(3, 4));
  EXPECT_THAT(writer.heard(), ElementsAre(1, 2));
  reader.hear(Role::reader);
  EXPECT_TRUE(reader.hears(2)) << "though it was announced before";
  writer.hear(Role::writer);
  EXPECT_TRUE(writer.hears(4));
}

TEST_F(RolesTest, WhoeverHasNoEndpointHearsWhatItIsToldToHear) {
  Ear reader, writer, observer;
  reader.announce(Role::reader, 1);
  writer.announce(Role::writer, 2);
  EXPECT_TRUE(reader.hears(2) && writer.hears(1));
  EXPECT_THAT(observer.heard(), ElementsAre());
  observer.hear(Role::writer);
  EXPECT_TRUE(observer.hears(2));
  EXPECT_THAT(observer.heard(), ElementsAre(2));
  observer.hear(Role::reader);
  EXPECT_TRUE(observer.hears(1));
  reader.withdraw(1);
  EXPECT_TRUE(eventually([&] { return !observer.heard().contains(1) && !writer.heard().contains(1); }));
}

TEST_F(RolesTest, AWriterThatComesLateHearsTheLatestRequestOfEachReader) {
  Ear reader, writer;
  reader.announce(Role::reader, 1);
  for (std::uint64_t sequence = 1; sequence < 10; ++sequence) reader.ask(1, sequence);
  writer.announce(Role::writer, 2);
  EXPECT_TRUE(eventually([&] { return writer.asked() == 9; }));
}

TEST_F(RolesTest, AnEndpointOnTheTopicOfTheOtherRoleIsRefusedAndToldOf) {
  Ear reader;
  reader.announce(Role::reader, 1);
  const dds_entity_t participant = dds_create_participant(domain(), nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t topic =
      dds_create_topic(participant, &sft_control_Endpoint_desc, "sft_writer", qos, nullptr);
  const dds_entity_t writer = dds_create_writer(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  core::ControlStorage storage;
  const core::Endpoint made_up = endpoint(Role::reader, 5);
  const sft_control_Endpoint sample = core::to_dds(made_up, storage);
  ASSERT_EQ(dds_write(writer, &sample), DDS_RETCODE_OK);
  EXPECT_TRUE(eventually([&] { return !reader.refused().empty(); }));
  EXPECT_THAT(reader.refused(), ElementsAre(HasSubstr("the topic of the other role")));
  EXPECT_THAT(reader.heard(), ElementsAre());
  dds_delete(participant);
}

}  // namespace
}  // namespace sft::test
