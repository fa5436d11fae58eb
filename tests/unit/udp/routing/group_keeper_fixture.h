// A GroupKeeper of a writer with readers on several links, in simulated time.
#pragma once

#include "udp_transport/routing/group_keeper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/seam/gate.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp::test {

using namespace std::chrono_literals;
inline constexpr const char* unsettled =
    "alone: it asks for that only since just now, or often for something else";

/// The networks of this host. Its addresses are 10.0.0.1 and 10.0.1.1 on two cables, and 10.0.2.1 on a
/// wireless interface.
inline constexpr std::uint32_t first_link = 0x0a000000, second_link = 0x0a000100, wireless = 0x0a000200;
inline constexpr std::uint32_t netmask = 0xffffff00;

class GroupKeeperTest : public testing::Test {
 protected:
  GroupKeeperTest() { restart(Multicast::automatic); }

  void restart(Multicast use, std::uint32_t writer = 7) {
    keeper_ = std::make_unique<GroupKeeper>(setup(type_support<Image>(), use, writer));
  }

  GroupKeeper::Setup setup(const TypeSupport& type, Multicast use, std::uint32_t writer) {
    GroupKeeper::Setup setup;
    setup.writer = writer;
    setup.type = &type;
    setup.use = use;
    setup.report_port = 9;
    setup.tally = tally_;
    setup.registry = &registry_;
    setup.connect = [this](std::uint32_t group, std::uint32_t own, std::size_t datagram_bytes) {
      connected_.push_back({group, own, datagram_bytes});
      DestinationLimits limits;
      limits.datagram_bytes = datagram_bytes;
      return std::make_shared<Destination>(SocketAddress{core::IpAddress(group), group_port}, limits, 0,
                                           connections_.connect());
    };
    setup.links = [](Multicast) {
      return std::vector<MulticastLink>{{"eth0", first_link + 1, netmask},
                                        {"eth1", second_link + 1, netmask},
                                        {"wlan0", wireless + 1, netmask, "interface wlan0 is wireless"}};
    };
    return setup;
  }

  core::Route& reader(std::uint32_t ip, const char* mask = "*") {
    core::Route route{routes_.size() + 1, core::UdpAddress{ip, 1000, 1'000'000},
                      selection_of<Image>(mask).without_rate()};
    route.reliable = true;
    return routes_.emplace_back(std::move(route));
  }
  void readers(std::uint32_t count, const char* mask = "*") {
    for (std::uint32_t i = 0; i < count; ++i) reader(first_link + 10 + next_host_++, mask);
  }

  /// Serves the present routes, like make_route_table().
  void serve() {
    merged_ = bundle_routes(routes_, destinations_);
    keeper_->merge(merged_, now_);
    groups_.clear();
    for (const RouteBundle& bundle : merged_) {
      if (!bundle.multicast) continue;
      std::vector<MulticastGroup::Member> members;
      for (const auto& to : bundle.destinations) members.push_back({lane(to), channel(to)});
      groups_.push_back(keeper_->find(*bundle.multicast, std::move(members)));
    }
    keeper_->merged(now_);
  }
  void publish(std::size_t data_bytes = 1000, bool together = false) {
    publish(data_bytes, together, fields<Image>("*"));
  }
  void publish_often(const char* mask) {
    for (int i = 0; i < 1000; ++i) publish(1000, false, fields<Image>(mask));
  }
  void publish(std::size_t data_bytes, bool together, const FieldMask& all) {
    publish(make_image(data_bytes), together, all);
  }
  void publish(const Image& image) { publish(image, false, fields<Image>("*")); }
  void publish(const Image& image, bool together, const FieldMask& all) {
    pass_gates();
    if (keeper_->sizes() == nullptr) return;
    const core::SampleHandle sample = memory_->take(sample_bytes(image, all));
    fill(*sample, image, all, 7, 1);
    keeper_->sizes()->measure(core::state_of(*sample, type_support<Image>().index_slots()), now_, together);
  }
  /// Lets each gate evaluate each sample once. The conditions are evaluated without any known fields.
  void pass_gates() {
    if (!anything_passes_) return;
    std::set<const core::Gate*> gates;
    for (const core::Route& route : routes_) {
      if (route.gate == nullptr || !gates.insert(route.gate.get()).second) continue;
      const auto gate = std::const_pointer_cast<core::Gate>(route.gate);
      const auto stamp = std::chrono::nanoseconds(now_.time_since_epoch()).count();
      gate->consider(detail::FieldSource::of_nothing(), stamp);
      gate->made(detail::FieldSource::of_nothing(), stamp);
    }
  }
  /// Publishes at 1 kHz for that time, and makes new routes whenever the keeper has a new plan. Returns the
  /// number of new plans.
  int go_on(std::chrono::milliseconds time) {
    int times = 0;
    for (const auto end = now_ + time; now_ < end; now_ += 1ms) {
      publish();
      if (!keeper_->replan(now_)) continue;
      serve();
      ++times;
    }
    return times;
  }
  /// Publishes a small sample each `period` for that time, and makes new routes whenever the keeper has a
  /// new plan.
  void go_on_every(std::chrono::milliseconds period, std::chrono::milliseconds time) {
    for (const auto end = now_ + time; now_ < end; now_ += period) {
      publish(0);
      if (keeper_->replan(now_)) serve();
    }
  }
  /// Publishes until the keeper has a new plan. Returns the time until then.
  std::chrono::milliseconds time_until_plan() {
    const auto since = now_;
    while (go_on(1ms) == 0 && now_ - since < 10s) {
    }
    return std::chrono::floor<std::chrono::milliseconds>(now_ - since) - 1ms;
  }
  /// Removes all readers. Returns their former group.
  std::shared_ptr<MulticastGroup> end_of_group() {
    const std::shared_ptr<MulticastGroup> group = groups_.at(0);
    routes_.clear();
    serve();
    return group;
  }
  std::size_t members() const {
    std::size_t count = 0;
    for (const auto& group : groups_) count += group->members().size();
    return count;
  }
  std::string why(core::EndpointId reader) const { return keeper_->why(reader); }
  /// Returns the members that got a farewell of the group, in ascending order. A member that got two
  /// farewells is listed twice.
  std::vector<std::size_t> withdrawn(const MulticastGroup& group) const {
    std::vector<std::size_t> reported;
    for (const auto& datagram : connections_.sent()) {
      const auto offer = parse_as<GroupOffer>(datagram);
      for (std::size_t i = 0; offer && i < group.members().size(); ++i) {
        if (*offer == group.farewell(i)) reported.push_back(i);
      }
    }
    std::ranges::sort(reported);
    return reported;
  }

  struct Connected {
    std::uint32_t group, own;
    std::size_t datagram_bytes;
  };
  GroupKeeper::Time now_{1h};
  bool anything_passes_ = true;  ///< true: samples of publish() pass the gates
  std::vector<core::Route> routes_;
  std::vector<RouteBundle> merged_;
  std::vector<std::shared_ptr<MulticastGroup>> groups_;
  std::vector<Connected> connected_;
  Connections connections_;
  std::unique_ptr<GroupKeeper> keeper_;

 private:
  std::shared_ptr<Lane> lane(const std::shared_ptr<Destination>& to) {
    std::shared_ptr<Lane>& known = lanes_[to.get()];
    if (known == nullptr) known = std::make_shared<Lane>(to, 4, tally_);
    return known;
  }
  std::shared_ptr<Channel> channel(const std::shared_ptr<Destination>& to) {
    std::shared_ptr<Channel>& known = channels_[to.get()];
    if (known == nullptr)
      known = std::make_shared<Channel>(7, static_cast<std::uint32_t>(channels_.size()), to, tally_, 9);
    return known;
  }

  std::uint32_t next_host_ = 0;
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{1} << 20);
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  DestinationDirectory destinations_{DestinationLimits{.report_port = 9}, connections_.connect()};
  GroupRegistry registry_;
  std::map<const Destination*, std::shared_ptr<Lane>> lanes_;
  std::map<const Destination*, std::shared_ptr<Channel>> channels_;
};

}  // namespace sft::udp::test
