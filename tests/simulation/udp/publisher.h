// The publisher of the simulation. It makes samples at random times, lets the gates of the readers decide,
// encodes the samples as the readers request, and hands them to the channel or to the multicast group.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "core/publish/gates.h"
#include "core/seam/buffer_pool.h"
#include "tests/simulation/udp/channel_sender.h"
#include "tests/simulation/udp/group_path.h"
#include "tests/simulation/udp/laws.h"
#include "tests/simulation/udp/scenario.h"
#include "tests/simulation/udp/topic.h"

namespace sft::simulation {

class Publisher {
 public:
  /// The arguments must outlive this object.
  Publisher(const Scenario& scenario, Random& random, ChannelSender& channel, GroupPath& group, Laws& laws)
      : scenario_(scenario), random_(random), channel_(channel), group_(group), laws_(laws) {}

  /// Publishes one sample, or several small ones. `asked` has the wishes of the readers, as far as the writer
  /// knows them.
  void publish(const std::map<core::EndpointId, Wish>& asked, Time now);
  /// Returns the time at which publish() is due next.
  Time next() const { return publish_at_; }
  /// Returns the number of samples that are still to be published.
  std::size_t left() const { return scenario_.samples - published_; }
  /// Returns the number of existing gates, of wishes in force and of former wishes.
  std::size_t gates() const;
  /// Returns the number of samples that have passed a gate and were sent to a group.
  std::size_t gated_by_group() const { return gated_by_group_; }

 private:
  /// The gates of the wishes that have conditions.
  using GatesInForce = std::map<Wish, std::shared_ptr<core::Gate>>;

  GatesInForce give_gates(const std::map<core::EndpointId, Wish>& asked);
  void ask_gates(const GatesInForce& gates, const Cloud& cloud);
  std::vector<Cloud> next_clouds(bool may_span);
  static void mark(udp::Job& job, Wish wish, const GatesInForce& gates);
  static std::uint16_t number_of(const std::set<Wish>& served);
  udp::JobHandle encode(std::span<const Cloud> clouds, const Selection& selection, std::uint16_t variant);
  void project(udp::Job& job, const core::SampleHandle& sample, const Selection& selection, bool packed);

  const Scenario& scenario_;
  Random& random_;
  ChannelSender& channel_;
  GroupPath& group_;
  Laws& laws_;
  std::shared_ptr<udp::JobPool> jobs_ = udp::JobPool::make();
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  core::Gates gates_{cloud_type()};
  core::Serving serving_{};  ///< the wishes in force, as routes
  /// All gates so far; some may have been removed.
  std::map<const core::Gate*, std::weak_ptr<const core::Gate>> given_{};
  std::size_t gated_by_group_ = 0;
  std::uint64_t sequence_ = scenario_.first_sequence;  ///< the sequence of the next sample
  std::size_t published_ = 0;
  Time publish_at_ = start_time;
};

}  // namespace sft::simulation
