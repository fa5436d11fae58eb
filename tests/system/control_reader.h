// The discovery of one node, without the rest of the node. It records the announcements on the control
// topics.
#pragma once

#include <dds/dds.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/dds_config.h"
#include "core/discovery/desired_links.h"
#include "core/discovery/discovery.h"
#include "core/platform/domain_id.h"
#include "core/sync/mutex.h"
#include "tests/support/eventually.h"

namespace sft::test {

/// Returns the DDS domain of the host on which the test runs.
inline std::uint32_t control_domain() { return core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value(); }

/// A participant of plain Cyclone DDS that can exchange samples with the nodes of this host.
class LoopbackParticipant {
 public:
  LoopbackParticipant() {
    const core::LinkSpec loopback{.interface = "lo",
                                  .ip = core::loopback_ipv4,
                                  .prefix_bits = 8,
                                  .loopback = true,
                                  .reaches_own_host = true};
    const std::string config = core::dds_config(control_domain(), {}, "").value().text_for(loopback);
    domain_ = dds_create_domain(number, config.c_str());
    participant_ = dds_create_participant(number, nullptr, nullptr);
  }
  ~LoopbackParticipant() { dds_delete(domain_); }
  LoopbackParticipant(const LoopbackParticipant&) = delete;
  LoopbackParticipant& operator=(const LoopbackParticipant&) = delete;

  dds_entity_t entity() const { return participant_; }

 private:
  static constexpr dds_domainid_t number = 200;  ///< Cyclone's number of the domain in this process

  dds_entity_t domain_ = 0, participant_ = 0;
};

inline core::Endpoint control_endpoint(core::Role role, core::EndpointId id) {
  core::Endpoint e;
  e.id = id;
  e.role = role;
  e.node_id = id;
  e.topic = "points";
  e.type_name = "Points";
  e.request.reader = id;
  return e;
}

/// Announces endpoints and requests as a node does, and records what other nodes announce.
class ControlReader final {
 public:
  /// Objects with the same name `process` share Cyclone domains. Objects with different names discover each
  /// other as if they were in different processes.
  explicit ControlReader(const std::string& process = "", const std::string& cyclone_config = "") {
    const core::DiscoveryOptions options{
        .domain = control_domain(), .user_config = cyclone_config, .threads = {.name_prefix = process}};
    discovery_ = std::move(core::Discovery::open(options, [] {}).value());
  }

  void announce(core::Role role, core::EndpointId id) { discovery_->announce(control_endpoint(role, id)); }
  void announce(const core::Endpoint& endpoint) { discovery_->announce(endpoint); }
  void withdraw(core::EndpointId id) { discovery_->withdraw(id); }
  void inquire(const std::set<core::Inquiry>& inquiries) { discovery_->inquire(inquiries); }
  bool is_asked(const core::Inquiry& inquiry) const {
    return eventually([&] { return discovery_->inquiries().all.contains(inquiry); });
  }
  bool is_asked_nothing() const {
    return eventually([&] { return discovery_->inquiries().all.empty(); });
  }
  void report(const core::NodeReport& report) { discovery_->report(report); }
  void ask(core::EndpointId reader, std::uint64_t sequence) {
    core::Request request;
    request.reader = reader;
    request.sequence = sequence;
    discovery_->send(request);
  }
  void hear(core::Role role) { discovery_->hear(role); }
  /// Does the periodic work, as the agent of a node would.
  void look() { (void)discovery_->look_after(std::chrono::steady_clock::now()); }

  std::set<core::EndpointId> heard() const { return record().heard; }
  bool hears(core::EndpointId id) const {
    return eventually([&] { return heard().contains(id); });
  }
  /// Returns the number of announced endpoints that were withdrawn or lost.
  std::size_t gone() const { return record().gone; }
  std::uint64_t asked() const { return record().asked; }
  std::size_t reports() const { return record().reports; }
  /// Returns a sentence for each link that was made anew.
  std::vector<std::string> renewals() const { return record().renewals; }
  std::vector<std::string> refused() const { return record().refused; }

 private:
  /// The events of which the node was notified so far.
  struct Record {
    void operator()(const core::EndpointSeen& endpoint) {
      heard.insert(endpoint->id);
      asked = std::max(asked, endpoint->request.sequence);
    }
    void operator()(const core::EndpointDeparted& departed) {
      heard.erase(departed.id);
      ++gone;
    }
    void operator()(const core::EndpointLost&) { ++gone; }
    void operator()(const core::Request& request) { asked = std::max(asked, request.sequence); }
    void operator()(const core::NodeReport&) { ++reports; }
    void operator()(const core::VanillaChanged&) {}
    void operator()(const core::DiscoveryNews& news) {
      if (news.kind == core::DiscoveryNews::Kind::link_renewed) renewals.push_back(news.text);
      if (news.kind == core::DiscoveryNews::Kind::malformed) refused.push_back(news.text);
    }

    std::set<core::EndpointId> heard;
    std::size_t gone = 0, reports = 0;
    std::uint64_t asked = 0;
    std::vector<std::string> refused, renewals;
  };
  Record record() const {
    const core::Lock lock(mutex_);
    for (const core::DiscoveryEvent& event : discovery_->take_events()) std::visit(record_, event);
    return record_;
  }

  mutable core::Mutex mutex_;
  mutable Record record_ SFT_GUARDED_BY(mutex_);
  std::unique_ptr<core::Discovery> discovery_;
};

}  // namespace sft::test
